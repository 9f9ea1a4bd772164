// The button Improve under the canvas: each way to improve the rule base opens a drawer. Model: "ways" ([title, words]);
// Python's message: { focus }.
import { element, put, watch } from "./chart.js";
import { menuOf } from "./menu.js";

const capital = (text) => text[0].toUpperCase() + text.slice(1);

export function render({ model, el }) {
  const root = element("div", { class: "shell-improve" });
  let menu = null;
  function build() {
    menu?.end();
    const ways = model.get("ways").map(([title, words]) => [`${capital(words)}: ${title}`, title]);
    const entries = ways.map(([text, title]) => [text, () => model.send({ open: title })]);
    menu = menuOf("Improve", entries, "first", true);
    put(root, { hidden: entries.length ? null : "" });
    root.replaceChildren(menu.node);
  }
  const hear = (message) => message.focus && menu.button.focus();
  const end = watch(model, ["ways"], build);
  model.on("msg:custom", hear);
  el.append(root);
  build();
  return () => {
    end();
    model.off("msg:custom", hear);
    menu.end();
    root.remove();
  };
}

export default { render };
