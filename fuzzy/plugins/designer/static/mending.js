// A line of a file that cannot be read, between its neighbours, to be mended or left out. Model: "file", "text", "fault"
// ({ line, reason, number }, the line from 0); Python's message: { problem }.
import { element, put, say, watch } from "./chart.js";

const AROUND = 2; // lines that are shown above and below

export function render({ model, el }) {
  let lines = model.get("text").split(/\r\n|\r|\n/),
    sent = lines; // what was sent last
  const title = element("h1", { tabindex: -1 }),
    reason = element("p", { role: "alert", id: "mending-reason" }),
    above = element("pre", { "aria-label": "the lines above" }),
    below = element("pre", { "aria-label": "the lines below" });
  const field = element("textarea", { rows: 2, spellcheck: "false", autocomplete: "off", class: "mending-line" });
  const at = () => model.get("fault").line;
  const send = (...instead) => {
    sent = lines.toSpliced(at(), 1, ...instead);
    model.send({ text: sent.join("\n") });
  };
  const open = element("button", { type: "submit", class: "first" }, "Open with this line"),
    drop = element("button", {}, "Leave the line out");
  drop.addEventListener("click", () => send());
  const form = element("form", {}, above, field, below, reason, element("div", { class: "buttons" }, drop, open));
  form.addEventListener("submit", (event) => {
    event.preventDefault();
    send(...field.value.split("\n"));
  });
  const file = model.get("file");
  el.append(
    element(
      "div",
      { class: "mending" },
      title,
      element("p", {}, `The rest of the file is kept. ${file} itself stays as it is until you save.`),
      form,
      element("p", {}, element("a", { href: "/" }, "Back to the designer")),
    ),
  );

  function paint() {
    const { reason: text } = model.get("fault"),
      n = at();
    say(title, `Line ${n + 1} of ${file} cannot be read`);
    say(reason, text);
    say(above, lines.slice(Math.max(0, n - AROUND), n).join("\n"));
    say(below, lines.slice(n + 1, n + 1 + AROUND).join("\n"));
    field.value = lines[n] ?? "";
    put(field, {
      "aria-label": `line ${n + 1} of the file`,
      "aria-invalid": "true",
      "aria-describedby": reason.id,
    });
    field.focus();
  }
  const hear = (message) => say(reason, message.problem);
  const end = watch(model, ["fault"], () => {
    lines = sent;
    paint();
  });
  model.on("msg:custom", hear);
  paint();
  return () => {
    end();
    model.off("msg:custom", hear);
  };
}

export default { render };
