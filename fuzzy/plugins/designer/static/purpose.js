// What the rule base is for: a switch by which only what fits is shown. Model: "purposes", and the chosen "purpose".
import { element, endOf, put, watch } from "./chart.js";

const WORDS = {
  function: "a function of its inputs",
  loop: "the controller of a plant",
  robot: "the law of a robot",
  tree: "a system of a tree",
};
const capital = (text) => text[0].toUpperCase() + text.slice(1);

export function render({ model, el }) {
  const buttons = model.get("purposes").map((purpose) =>
    element(
      "button",
      {
        role: "radio",
        title: WORDS[purpose] ? `The rule base is ${WORDS[purpose]}` : null,
        "data-purpose": purpose,
        onclick: () => choose(purpose),
      },
      capital(purpose),
    ),
  );
  const root = element(
    "div",
    { class: "shell-purpose", role: "radiogroup", "aria-label": "What the rule base is for" },
    ...buttons,
  );
  el.append(root);

  function choose(purpose) {
    root.closest(".shell-group")?.scrollTo({ left: 0 }); // where the panes are swiped
    if (purpose !== model.get("purpose")) model.send({ purpose });
  }
  root.addEventListener("keydown", (event) => {
    const by = { ArrowRight: 1, ArrowDown: 1, ArrowLeft: -1, ArrowUp: -1 }[event.key];
    if (!by) return;
    event.preventDefault();
    const to = buttons[(buttons.indexOf(document.activeElement) + by + buttons.length) % buttons.length];
    to.focus();
    choose(to.dataset.purpose);
  });
  function paint() {
    for (const button of buttons) {
      const on = button.dataset.purpose === model.get("purpose");
      put(button, { "aria-checked": String(on), tabindex: on ? 0 : -1 });
    }
  }
  const end = watch(model, ["purpose"], paint);
  paint();
  return endOf(root, end);
}

export default { render };
