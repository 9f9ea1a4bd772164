// The editor of the terms: the chosen variable's curves or consequents, and a line of fields for each term.
import { button, choices, color, element, endOf, offer, put, said, say, watch, whenShown, whenSized } from "./chart.js";
import { hold, numberField, pressing, problemLine, wordField } from "./dragging.js";
import { membershipChart } from "./curves.js";
import { degree, lowerDegree } from "./membership.js";
import { consequentChart, consequent } from "./outputs.js";

// How much of a parameter is dust depends on what it is; a shape has no unit to compare it with.
const DUST_OF = { location: (span) => span, width: (span) => span, slope: (span) => 1 / span, shape: () => 0 };
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
    awaited = null, // what is chosen once the design has it: a name that was asked for, a term that is being added
    range = null, // a new range of the chosen variable, while it is asked what becomes of the terms
    sought = model.get("selected")?.show ?? null, // the last link that led here
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
  const edit = (op, content, field = null, name = null) =>
    model.send({ edit: op, kind: selected().kind, ...content, gesture: name, field });

  const hands = {
    select: (term) => {
      const { kind, variable } = selected();
      select(kind, variable.name, term);
    },
    move(term, parameters, name, pressed, field = null) {
      const { variable, kind } = selected(),
        before = variable.terms.find((each) => each.name === term);
      if (!before || JSON.stringify(parametersOf(variable, before)) === JSON.stringify(parameters)) return;
      const message = { edit: "term", kind, variable: variable.name, term, parameters, gesture: name, field };
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
    "name of the variable",
    (text, field) => {
      const { variable, kind, term } = selected();
      awaited = { kind, variable: text, term };
      edit("rename_variable", { variable: variable.name, name: text }, field);
    },
    "name",
  );
  const span = () => {
    const { variable } = selected();
    return [variable.low, variable.high];
  };
  // A new range goes to Python at once where it is none, or where there are no terms; else it is asked first.
  function ranged(low, high, event, field) {
    const { variable, kind } = selected();
    range = { kind, variable: variable.name, low, high, field, gesture: key(event) };
    if (!(low < high) || !variable.terms.length) settleRange(false);
    else {
      paint();
      if (event.key !== "Enter") return;
      event.preventDefault(); // this Enter is no answer yet
      question.querySelector("button").focus();
    }
  }
  function settleRange(scale) {
    const { variable, low: from, high: to, field, gesture } = range;
    range = null;
    edit("universe", { variable, low: from, high: to, scale }, field, gesture);
    question.hidden = true;
  }
  const wanted = () => range ?? selected().variable;
  const low = numberField(
    "from, the lowest value",
    span,
    (value, event, field) => ranged(value, wanted().high, event, field),
    "from",
  );
  const high = numberField(
    "to, the highest value",
    span,
    (value, event, field) => ranged(wanted().low, value, event, field),
    "to",
  );
  const unit = wordField(
    "unit",
    (text, field) => edit("unit", { variable: selected().variable.name, unit: text }, field),
    "unit",
  );
  const now = numberField(
    "now, the current value",
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
  const asked = element("span");
  const question = element(
    "div",
    { class: "fd-question", role: "group", "aria-label": "Terms in the new range", hidden: true },
    asked,
    button(null, "the terms move and stretch with the range", () => settleRange(true), "Scale the terms"),
    button(null, "the terms stay where they are", () => settleRange(false), "Keep the terms"),
    button(
      null,
      "the range stays as it was",
      () => {
        range = null;
        paint();
      },
      "Cancel",
    ),
  );
  question.addEventListener("keydown", (event) => {
    if (event.key !== "Escape") return;
    range = null;
    low.input.focus();
    paint();
  });
  const inputChart = membershipChart(hands),
    outputChart = consequentChart(hands);
  const list = element("div", { class: "fd-list", role: "list", "aria-label": "Terms" });
  const add = button(
    "plus",
    "add a term where the others leave most room",
    () => {
      const { variable, kind } = selected();
      awaited = { kind, variable: variable.name, besides: new Set(variable.terms.map((term) => term.name)) };
      edit("add_term", { variable: variable.name });
    },
    "Add term",
  );
  // Of all the variable's terms at once
  const count = element("input", {
    type: "number",
    class: "fd-count",
    min: 2,
    max: 200,
    step: 1,
    "aria-label": "number of terms to spread",
  });
  const spread = () => {
    const number = Number(count.value);
    edit("spread_terms", { variable: selected().variable.name, count: count.value === "" ? null : number });
  };
  count.addEventListener("keydown", (event) => {
    if (event.key === "Enter") (event.preventDefault(), spread());
  });
  const evenly = element(
    "span",
    { class: "fd-together", role: "group", "aria-label": "Spread evenly" },
    button(
      null,
      "spread the terms evenly over the range; names stay, more are added between, or some are taken away",
      spread,
      "Spread evenly",
    ),
    element("label", { class: "fd-choice" }, count, element("span", { "aria-hidden": "true" }, "terms")),
  );
  const allAs = choices("all terms as", [], "", (value) => {
    if (value) edit("term_types", { variable: selected().variable.name, type: value });
    allAs.value = "";
  });
  let counted = ""; // of which the number of terms is shown, until another is typed
  const legend = element("p", { class: "fd-note" });
  const problem = problemLine(model, root);
  root.append(
    tabs,
    about,
    question,
    inputChart.node,
    outputChart.node,
    legend,
    list,
    element("div", { class: "fd-actions" }, add, evenly, allAs),
    problem.node,
  );
  el.append(root);

  const one = ({ lower: [, left, right] }) => left === right;

  // A term's line; it stays while the number of terms does, so that a field keeps the focus.
  function row(i) {
    const mine = () => {
      const { variable, kind } = selected();
      return { variable, kind, term: variable.terms[i] };
    };
    const word = wordField(
      "",
      (text, field) => {
        const { variable, kind, term } = mine();
        awaited = { kind, variable: variable.name, term: text };
        edit("rename_term", { variable: variable.name, term: term.name, name: text }, field);
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
      beneath = [],
      form = "";
    const show = (variable, kind, term, current) => {
      const owner = `${kind} ${variable.name} ${term.name}`;
      word.show(term.name, owner);
      put(word.input, { "aria-label": `name of ${term.name}` });
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
      // Of a type-2 system; one lag stands for both sides as long as they are the same.
      const feet = !term.lower ? [] : [`lower scale`, ...(one(term) ? ["lag"] : ["left lag", "right lag"])];
      if (form !== JSON.stringify([words, feet, term.name])) {
        form = JSON.stringify([words, feet, term.name]);
        inside = words.map((text, k) =>
          numberField(
            `${text} of ${term.name}`,
            span,
            (number, event, field) => {
              const { variable: own, term: it } = mine();
              hands.move(
                it.name,
                parametersOf(own, it).map((p, n) => (n === k ? number : p)),
                key(event),
                false,
                field,
              );
            },
            text,
          ),
        );
        beneath = feet.map((text, k) =>
          numberField(
            `${text} of ${term.name}`,
            () => [0, 1],
            (number, event, field) => {
              const { variable: own, term: it } = mine(),
                both = k === 1 && one(it);
              const lower = it.lower.map((old, n) => (n === k || (both && n === 2) ? number : old));
              edit("footprint", { variable: own.name, term: it.name, lower }, field, key(event));
            },
            text,
          ),
        );
        fields.replaceChildren(...[...inside, ...beneath].map((field) => field.node));
      }
      const wide = variable.high - variable.low;
      const dust = (k) => {
        if (kind === "input") return DUST_OF[functions[term.type].roles[k]]?.(wide) ?? 0;
        const input = term.type === "linear" ? design.inputs[k] : null; // a slope, per unit of its input
        return input ? wide / (input.high - input.low || 1) : wide;
      };
      inside.forEach((field, k) => field.show(term.parameters[k], owner, dust(k)));
      beneath.forEach((field, k) => field.show(term.lower[k], owner));
      const amount = kind === "input" ? degree(term.type, current, term.parameters) : consequent(term, point());
      bar.hidden = kind !== "input";
      bar.parentNode.hidden = term.type === "constant";
      bar.firstChild.style.cssText = `width: ${100 * (kind === "input" ? amount : 0)}%; background: ${color(i)}`;
      const least = term.lower && lowerDegree(term, functions[term.type], variable.low, variable.high)(current);
      const between = least === undefined ? "" : `${least.toFixed(2)}–`;
      say(value, kind === "input" ? between + amount.toFixed(2) : said(amount, 4, wide));
      value.title = kind === "input" ? "degree at the current value" : "value at the current point";
    };
    return { node, word, show };
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
    if (range && (range.variable !== own.name || range.kind !== kind)) range = null;
    const wide = own.high - own.low,
      owner = `${kind} ${own.name}`,
      [several, them] = own.terms.length === 1 ? ["its term", "it"] : [`the ${own.terms.length} terms`, "them"];
    name.show(own.name, owner);
    low.show(wanted().low, owner, wide);
    high.show(wanted().high, owner, wide);
    unit.show(own.unit ?? "", owner);
    now.node.hidden = kind !== "input";
    if (kind === "input") now.show(point()[i], owner, wide);
    question.hidden = !range;
    if (range)
      say(asked, `From ${said(range.low)} to ${said(range.high)}: scale ${several} with the range, or keep ${them}?`);
    inputChart.node.hidden = kind !== "input";
    outputChart.node.hidden = kind === "input";
    const inner = Math.max(220, width);
    if (kind === "input")
      inputChart.draw({
        functions,
        variable,
        histogram: (model.get("histograms") ?? []).find((h) => h.name === own.name) ?? null,
        compared: old,
        selected: term,
        point: point()[i],
        width: inner,
      });
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
    offer(allAs, [["", "All terms as …"], ...(kind === "input" ? kinds : CONSEQUENTS)], "");
    evenly.hidden = kind === "output" && own.terms.some(({ type }) => type === "linear");
    if (counted !== `${owner} ${own.terms.length}`) {
      counted = `${owner} ${own.terms.length}`;
      count.value = String(Math.max(2, own.terms.length));
    }
    while (rows.length < variable.terms.length) {
      rows.push(row(rows.length));
      list.append(rows.at(-1).node);
    }
    for (const extra of rows.splice(variable.terms.length)) extra.node.remove();
    rows.forEach((each, n) => each.show(variable, kind, variable.terms[n], point()[i]));
    // A link, or what was added, takes the focus to the name.
    const link = chosen ?? model.get("selected");
    if (!link?.show || link.show === sought || link.variable !== own.name || root.clientWidth === 0) return;
    sought = link.show;
    const field = link.term ? rows[variable.terms.findIndex((each) => each.name === term)]?.word : name;
    field?.input.focus();
    field?.input.select();
  }

  // What was asked for is there now: it is what everything on the page looks at.
  function settleAwaited() {
    if (!awaited) return;
    const { kind, variable: name, besides } = awaited,
      found = (kind === "input" ? design.inputs : design.outputs).find((each) => each.name === name);
    const term = besides ? found?.terms.find((each) => !besides.has(each.name))?.name : awaited.term;
    if (!found || (term !== null && !found.terms.some((each) => each.name === term))) return;
    awaited = null;
    chosen = { kind, variable: name, term, show: besides ? {} : null };
    model.send({ look: "select", kind, variable: name, term });
  }

  function settle() {
    design = model.get("design");
    settleAwaited();
    for (const [variable] of variables())
      for (const term of variable.terms) terms.settle(`${variable.name} ${term.name}`, term.parameters);
    place.settle("point", model.get("point"));
    paint();
  }
  const ends = [
    watch(model, ["design", "point", "viewer", "compared", "histograms"], settle),
    watch(model, ["selected"], () => {
      chosen = null;
      paint();
    }),
    watch(model, ["problem"], () => {
      if (model.get("problem")) {
        terms.drop();
        awaited = null;
        paint(); // what was typed goes back into its field after that
      }
      problem.show();
    }),
    whenSized(root, () => {
      width = root.clientWidth;
      paint();
    }),
  ];
  ends.push(whenShown(root, paint)); // a link may lead here before the tab is shown
  return endOf(root, ...ends, terms.drop, place.drop);
}

export default { render };
