// The tree of which the file is a system: its picture, the way to each system's editor, and what the whole answers.
// From what fuzzy/plugins/trees/panel.py hands over.

import { element, keepDrawn, labelled, quantity, say } from "../../designer/static/chart.js";
import { field, formStyled, group, panelForm, row } from "../../designer/static/form.js";

const address = (name) => `${location.pathname}?file=${encodeURIComponent(name)}`;

export async function render({ model, el }) {
  await formStyled(import.meta.url);
  const form = panelForm(model, (note) => root.prepend(note)),
    { get, send, number } = form;
  const picture = element("img", { alt: "Boxes of the systems with their rules counted, and the wires between them" });
  picture.style.maxWidth = "100%";
  const systems = element("ul", { "aria-label": "Systems" }),
    inputs = row(),
    outputs = element("p", { class: "pn-said", role: "status" });
  const root = element(
    "div",
    { class: "fd fd-panel fd-form" },
    picture,
    group("Systems", systems),
    group("The whole, with the design in its place", inputs, outputs),
  );
  const asked = new Map(); // by name: the field of an input
  el.append(root);

  function link({ name, file, rules, here }) {
    const text = `${name}: ${rules} ${rules === 1 ? "rule" : "rules"}`;
    return element("li", {}, here ? `${text}, which is edited here` : element("a", { href: address(file) }, text));
  }

  function input(variable) {
    if (!asked.has(variable.name)) {
      const react = (value) => send({ do: "point", name: variable.name, value });
      asked.set(variable.name, number(labelled(variable), variable.name, {}, { react }));
    }
    return field(labelled(variable), asked.get(variable.name));
  }

  function draw() {
    const drawn = get("picture");
    picture.hidden = !drawn;
    if (drawn) picture.src = `data:image/svg+xml;charset=utf-8,${encodeURIComponent(drawn)}`;
    systems.replaceChildren(...get("systems").map(link));
    const names = get("inputs").map((variable) => variable.name);
    if (names.join() !== [...inputs.querySelectorAll("input")].map((node) => node.name).join()) {
      inputs.replaceChildren(...get("inputs").map(input));
      names.forEach((name) => (asked.get(name).name = name));
    }
    for (const { name, value } of get("inputs")) asked.get(name).show(value);
    say(
      outputs,
      get("outputs")
        .map((v) => `${v.name} = ${v.value === null ? "none" : quantity(v.value, v)}`)
        .join(", "),
    );
    form.drawProblem();
  }
  return keepDrawn(model, ["picture", "systems", "inputs", "outputs", "problem"], root, draw);
}

export default { render };
