// The editor of the terms: the chosen variable's curves or consequents, and a line of fields for each term.
import { button, choices, color, element, offer, put, said, say, watch, whenSized } from "./chart.js";
import { hold, numberField, pressing, problemLine, wordField } from "./dragging.js";
import { membershipChart } from "./curves.js";
import { degree } from "./membership.js";
import { consequentChart, consequent } from "./outputs.js";

const CONSEQUENTS = [
  ["constant", "constant"],
  ["linear", "linear"],
];

export function render({ model, el }) {
  const root = element("div", { class: "fd fd-terms" });
  const terms = hold((message) => model.send(message)),
    place = hold((message) => model.send(message));
  const key = pressing();
  const functions = model.get("functions"); // by MATLAB's name; they do not change
  const kinds = Object.entries(functions).map(([type, { title }]) => [type, `${type} · ${title}`]);
  let design = model.get("design"),
    chosen = null,
    width = 0;

  const variables = () => [...design.inputs.map((v) => [v, "input"]), ...design.outputs.map((v) => [v, "output"])];
  // The chosen variable and term: what the page says, as far as it exists.
  function selected() {
    const all = variables(),
      wanted = chosen ?? model.get("selected") ?? {};
    const [variable, kind] = all.find(([v, k]) => v.name === wanted.variable && (!wanted.kind || k === wanted.kind)) ??
      all[0] ?? [null, "input"];
    const term = variable?.terms.find(({ name }) => name === wanted.term) ?? variable?.terms[0];
    return { variable, kind, term: term?.name ?? null };
  }
  const parametersOf = (variable, term) => terms.value(`${variable.name} ${term.name}`, term.parameters);
  const shown = (variable) => ({
    ...variable,
    terms: variable.terms.map((term) => ({ ...term, parameters: parametersOf(variable, term) })),
  });
  const point = () => place.value("point", model.get("point") ?? design.inputs.map((v) => (v.low + v.high) / 2));

  function select(kind, variable, term) {
    const now = selected();
    if (now.variable?.name === variable && now.term === term && now.kind === kind) return;
    chosen = { kind, variable, term };
    model.send({ look: "select", kind, variable, term });
    paint();
  }
  // An input and an output may share a name, so each message says which is meant.
  const edit = (op, content, name = null) => model.send({ edit: op, kind: selected().kind, ...content, gesture: name });

  const hands = {
    select: (term) => {
      const { kind, variable } = selected();
      select(kind, variable.name, term);
    },
    move(term, parameters, name, pressed) {
      const { variable, kind } = selected(),
        before = variable.terms.find((each) => each.name === term);
      if (!before || JSON.stringify(parametersOf(variable, before)) === JSON.stringify(parameters)) return;
      const message = { edit: "term", kind, variable: variable.name, term, parameters, gesture: name };
      terms.take(`${variable.name} ${term}`, parameters, message, before.parameters, pressed);
      paint();
    },
    release: () => terms.release(),
    point(value, pressed) {
      const i = design.inputs.indexOf(selected().variable),
        before = model.get("point"),
        now = [...point()];
      if (now[i] === value) return;
      now[i] = value;
      place.take("point", now, { look: "point", point: now }, before, pressed);
      paint();
    },
    releasePoint: () => place.release(),
  };

  // Parts
  const tabs = element("div", { class: "fd-tabs", role: "group", "aria-label": "Variables" });
  const name = wordField(
    "variable's name",
    (text) => {
      const { variable, kind } = selected();
      chosen = { kind, variable: text, term: selected().term };
      edit("rename_variable", { variable: variable.name, name: text });
    },
    "name",
  );
  const span = () => {
    const { variable } = selected();
    return [variable.low, variable.high];
  };
  const low = numberField(
    "lowest value",
    span,
    (value, event) => edit("universe", { variable: selected().variable.name, low: value, high: span()[1] }, key(event)),
    "from",
  );
  const high = numberField(
    "highest value",
    span,
    (value, event) => edit("universe", { variable: selected().variable.name, low: span()[0], high: value }, key(event)),
    "to",
  );
  const unit = wordField("unit", (text) => edit("unit", { variable: selected().variable.name, unit: text }), "unit");
  const now = numberField(
    "current value",
    span,
    (value) => {
      hands.point(value, false);
    },
    "now",
  );
  const about = element(
    "div",
    { class: "fd-fields", role: "group", "aria-label": "Variable" },
    name.node,
    low.node,
    high.node,
    unit.node,
    now.node,
    button("bin", "remove the variable", () => {
      edit("remove_variable", { variable: selected().variable.name });
      chosen = null;
    }),
  );
  const inputChart = membershipChart(hands),
    outputChart = consequentChart(hands);
  const list = element("div", { class: "fd-list", role: "list", "aria-label": "Terms" });
  const add = button("plus", "add a term", () => edit("add_term", { variable: selected().variable.name }), "Add term");
  const legend = element("p", { class: "fd-note" });
  const problem = problemLine(model);
  root.append(
    tabs,
    about,
    inputChart.node,
    outputChart.node,
    legend,
    list,
    element("div", { class: "fd-actions" }, add),
    problem.node,
  );
  el.append(root);

  // A term's line; it stays while the number of terms does, so that a field keeps the focus.
  function row(i) {
    const mine = () => {
      const { variable, kind } = selected();
      return { variable, kind, term: variable.terms[i] };
    };
    const word = wordField(
      "term's name",
      (text) => {
        const { variable, kind, term } = mine();
        chosen = { kind, variable: variable.name, term: text };
        edit("rename_term", { variable: variable.name, term: term.name, name: text });
      },
      "",
    );
    const type = choices("type", [], "", (value) => {
      const { variable, term } = mine();
      edit("term_type", { variable: variable.name, term: term.name, type: value });
    });
    const fields = element("div", { class: "fd-fields" });
    const bar = element("span", { class: "fd-degree", "aria-hidden": "true" }, element("i")),
      value = element("output", { class: "fd-value" });
    const remove = button("bin", "remove the term", () => {
      const { variable, term } = mine();
      edit("remove_term", { variable: variable.name, term: term.name });
    });
    const node = element(
      "div",
      { class: "fd-row", role: "listitem" },
      element("span", { class: "fd-swatch", style: `background: ${color(i)}` }),
      word.node,
      type,
      fields,
      element("div", { class: "fd-now" }, bar, value),
      remove,
    );
    node.addEventListener("focusin", () => {
      const { variable, kind, term } = mine();
      if (term && chosen?.term !== term.name) select(kind, variable.name, term.name);
    });
    let inside = [],
      form = "";
    const show = (variable, kind, term, current) => {
      word.show(term.name);
      put(node, {
        "aria-label": `term ${term.name}`,
        class: term.name === selected().term ? "fd-row fd-on" : "fd-row",
      });
      offer(type, kind === "input" ? kinds : CONSEQUENTS, term.type);
      put(type, { "aria-label": `type of ${term.name}` });
      put(remove, { "aria-label": `remove the term ${term.name}`, title: `remove the term ${term.name}` });
      const words =
        kind === "input"
          ? functions[term.type].words
          : term.type === "constant"
            ? ["value"]
            : [...design.inputs.map((v) => `× ${v.name}`), "+ constant"];
      if (form !== JSON.stringify([words, term.name])) {
        form = JSON.stringify([words, term.name]);
        inside = words.map((text, k) =>
          numberField(
            `${text} of ${term.name}`,
            span,
            (number, event) => {
              const { variable: own, term: it } = mine();
              hands.move(
                it.name,
                parametersOf(own, it).map((p, n) => (n === k ? number : p)),
                key(event),
                false,
              );
            },
            text,
          ),
        );
        fields.replaceChildren(...inside.map((field) => field.node));
      }
      inside.forEach((field, k) => field.show(term.parameters[k]));
      const amount = kind === "input" ? degree(term.type, current, term.parameters) : consequent(term, point());
      bar.hidden = kind !== "input";
      bar.parentNode.hidden = term.type === "constant";
      bar.firstChild.style.cssText = `width: ${100 * (kind === "input" ? amount : 0)}%; background: ${color(i)}`;
      say(value, kind === "input" ? amount.toFixed(2) : said(amount));
      value.title = kind === "input" ? "degree at the current value" : "value at the current point";
    };
    return { node, show };
  }

  const rows = [];
  function paint() {
    const { variable: own, kind, term } = selected();
    if (!own || width === 0) return;
    const variable = shown(own),
      i = design.inputs.indexOf(own),
      j = design.outputs.indexOf(own);
    const compared = model.get("compared"),
      old = (kind === "input" ? compared?.inputs : compared?.outputs)?.find((v) => v.name === own.name) ?? null;
    const all = variables();
    while (tabs.childElementCount > all.length) tabs.lastChild.remove();
    all.forEach(([v, k], n) => {
      if (n >= tabs.childElementCount)
        tabs.append(
          element("button", {
            type: "button",
            class: "fd-tab",
            onclick: () => {
              const [x, y] = variables()[n];
              select(y, x.name, x.terms[0]?.name ?? null);
            },
          }),
        );
      const tab = tabs.children[n];
      say(tab, v.name);
      put(tab, {
        "aria-pressed": v === own ? "true" : "false",
        class: k === "input" ? "fd-tab" : "fd-tab fd-output",
        title: k,
      });
    });
    name.show(own.name);
    low.show(own.low);
    high.show(own.high);
    unit.show(own.unit ?? "");
    now.node.hidden = kind !== "input";
    if (kind === "input") now.show(point()[i]);
    inputChart.node.hidden = kind !== "input";
    outputChart.node.hidden = kind === "input";
    const inner = Math.max(220, width);
    if (kind === "input")
      inputChart.draw({ functions, variable, compared: old, selected: term, point: point()[i], width: inner });
    else
      outputChart.draw({
        variable,
        inputs: design.inputs,
        compared: old,
        selected: term,
        point: point(),
        value: model.get("viewer")?.output?.[j] ?? null,
        width: inner,
      });
    say(
      legend,
      old
        ? `dashed grey: ${compared.name}`
        : kind === "input"
          ? "Drag a handle or a whole curve; the arrow keys move a handle, and with Alt the curve."
          : "Drag a marker; a bar shows the range of a linear consequent, its dot the value at the current point.",
    );
    while (rows.length < variable.terms.length) {
      rows.push(row(rows.length));
      list.append(rows.at(-1).node);
    }
    for (const extra of rows.splice(variable.terms.length)) extra.node.remove();
    rows.forEach((each, n) => each.show(variable, kind, variable.terms[n], point()[i]));
  }

  function settle() {
    design = model.get("design");
    for (const [variable] of variables())
      for (const term of variable.terms) terms.settle(`${variable.name} ${term.name}`, term.parameters);
    place.settle("point", model.get("point"));
    paint();
  }
  const ends = [
    watch(model, ["design", "point", "viewer", "compared"], settle),
    watch(model, ["selected"], () => {
      chosen = null;
      paint();
    }),
    watch(model, ["problem"], () => {
      problem.show();
      if (model.get("problem")) {
        terms.drop();
        paint();
      }
    }),
    whenSized(root, () => {
      width = root.clientWidth;
      paint();
    }),
  ];
  return () => {
    for (const end of ends) end();
    terms.drop();
    place.drop();
    root.remove();
  };
}

export default { render };
