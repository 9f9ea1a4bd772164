// The system as a tree: inputs, outputs, their terms, the rules, and the choices of inference.
import { button, choices, color, element, endOf, line, offer, put, said, scale, shape, watch } from "./chart.js";
import { problemLine, wordField } from "./dragging.js";
import { degree, places } from "./membership.js";

const CHOICE_WORDS = {
  and_method: "and",
  or_method: "or",
  defuzzification: "defuzzification",
  no_rule_fires: "where no rule fires",
  out_of_range: "input out of range",
  implication: "implication",
  aggregation: "aggregation",
};
const VALUE_WORDS = {
  prod: "product",
  min: "minimum",
  probor: "probabilistic or",
  max: "maximum",
  wtaver: "weighted average",
  wtsum: "weighted sum",
  midrange: "middle of the range",
  nan: "not a number",
  error: "an error",
  warn: "warn",
  ignore: "as it is",
  clip: "clip to the range",
  sum: "sum",
  karnikmendel: "Karnik-Mendel",
  ekm: "enhanced Karnik-Mendel",
  iasc: "IASC",
  eiasc: "enhanced IASC",
  nietan: "Nie-Tan",
};

const CURVE = [56, 18]; // px of membership functions in small

export function render({ model, el }) {
  const root = element("div", { class: "fd fd-tree" });
  const edit = (op, content) => model.send({ edit: op, ...content, gesture: null });
  const title = wordField("system's name", (name, field) => edit("rename", { name, field }), "system");
  const tree = element("ul", { role: "tree", "aria-label": "System", class: "fd-branches" });
  const add = element(
    "div",
    { class: "fd-actions" },
    button("plus", "add an input with three terms", () => addVariable("input"), "Add input"),
    button("plus", "add an output with three terms", () => addVariable("output"), "Add output"),
  );
  const form = element("div", { class: "fd-choices", role: "group", "aria-label": "Choices" });
  const problem = problemLine(model, root);
  root.append(title.node, tree, add, element("h2", {}, "Inference"), form, problem.node);
  el.append(root);

  const shut = new Set(); // what is folded
  let current = "inputs",
    items = [],
    drawn = "",
    awaited = null; // the kind of a variable that is being added, and the names that there were

  const named = (kind) => model.get("design")[kind === "input" ? "inputs" : "outputs"].map(({ name }) => name);
  function addVariable(kind) {
    awaited = { kind, besides: new Set(named(kind)) };
    edit("add_variable", { kind });
  }
  // What was added is chosen, and its name takes the focus.
  function settleAwaited() {
    const variable = awaited && named(awaited.kind).find((name) => !awaited.besides.has(name));
    if (!variable) return;
    model.send({ look: "select", kind: awaited.kind, variable, term: null, show: true });
    current = `${awaited.kind} ${variable}`;
    awaited = null;
  }

  function branches(design) {
    const branch = (kind, list) =>
      list.map((variable) => ({
        id: `${kind} ${variable.name}`,
        text: variable.name,
        more: "",
        said: variable.terms.length === 1 ? "1 term" : `${variable.terms.length} terms`,
        curve: kind === "input" ? variable.terms.map((term, i) => [term.type, term.parameters, i]) : null,
        span: [variable.low, variable.high],
        kind,
        variable: variable.name,
        remove: variable.name,
        children: variable.terms.map((term, i) => ({
          id: `${kind} ${variable.name} ${term.name}`,
          text: term.name,
          more: kind === "output" && term.type === "constant" ? said(term.parameters[0], 3) : "",
          said: term.type,
          curve: kind === "input" ? [[term.type, term.parameters, i]] : null,
          span: [variable.low, variable.high],
          kind,
          variable: variable.name,
          term: term.name,
          color: color(i),
          children: [],
        })),
      }));
    const off = design.rules.filter((rule) => !rule.enabled).length,
      wrong = design.rules.filter((rule) => rule.problem).length;
    const rules = [
      `${design.rules.length}`,
      ...(off ? [`${off} off`] : []),
      ...(wrong ? [`${wrong} with an error`] : []),
    ].join(", ");
    return [
      {
        id: "inputs",
        text: "Inputs",
        more: `${design.inputs.length}`,
        head: true,
        children: branch("input", design.inputs),
      },
      {
        id: "outputs",
        text: "Outputs",
        more: `${design.outputs.length}`,
        head: true,
        children: branch("output", design.outputs),
      },
      { id: "rules", text: "Rules", more: rules, head: true, children: [] },
    ];
  }

  function node(item, level) {
    const open = item.children.length > 0 && !shut.has(item.id);
    const group = open
      ? element(
          "ul",
          { role: "group", "aria-label": item.text },
          ...item.children.map((child) => node(child, level + 1)),
        )
      : null;
    // An item is its line alone: its words are then those of its name. The group below it says by its level whose it is.
    const own = element(
      "span",
      {
        class: item.head ? "fd-leaf fd-head" : "fd-leaf",
        role: "treeitem",
        "aria-level": level,
        "aria-label": `${item.text} ${item.said ?? item.more}`,
        title: item.said ?? null,
        "data-id": item.id,
        tabindex: item.id === current ? 0 : -1,
        "aria-expanded": item.children.length ? String(open) : null,
        onclick: (event) => {
          if (event.target.closest(".fd-twist")) fold(item.id, open);
          else choose(item);
        },
      },
      // A sign, and no text: what is read is what the item is called.
      element("span", {
        class: "fd-twist",
        "aria-hidden": "true",
        "data-sign": item.children.length ? (open ? "▾" : "▸") : "",
      }),
      item.color ? element("span", { class: "fd-swatch", style: `background: ${item.color}` }) : null,
      element("span", { class: "fd-text" }, item.text),
      " ",
      item.curve ? sketch(item.curve, item.span) : element("span", { class: "fd-more" }, item.more || item.said || ""),
    );
    if (item.remove) {
      // The bin is the mouse's; the keyboard has Delete, which a tree's item may have without being two things.
      own.append(
        element("span", {
          class: "fd-bin",
          "data-sign": "×",
          title: `remove ${item.text}`,
          "aria-hidden": "true",
          onclick: (event) => {
            event.stopPropagation();
            edit("remove_variable", { kind: item.kind, variable: item.remove });
          },
        }),
      );
      put(own, { "aria-keyshortcuts": "Delete" });
    }
    items.push({ item, own, open });
    return element("li", { role: "none" }, own, group);
  }

  /** Membership functions in small, in the colours of their terms. */
  function sketch(curves, [low, high]) {
    const x = scale(low, high, 1, CURVE[0] - 1),
      y = scale(0, 1, CURVE[1] - 1, 1);
    const drawn = curves.map(([type, parameters, i]) => {
      const xs = places(parameters, low, high, 31);
      return shape("path", {
        d: line(
          xs.map(x),
          xs.map((value) => y(degree(type, value, parameters))),
        ),
        style: `stroke: ${color(i)}`,
      });
    });
    return shape("svg", { class: "fd-sketch", width: CURVE[0], height: CURVE[1], "aria-hidden": "true" }, ...drawn);
  }

  function fold(id, on) {
    if (on) shut.add(id);
    else shut.delete(id);
    paint(true);
  }
  function choose(item) {
    current = item.id;
    if (item.variable)
      model.send({ look: "select", kind: item.kind, variable: item.variable, term: item.term ?? null });
    else if (item.children.length) shut.has(item.id) ? shut.delete(item.id) : shut.add(item.id);
    paint(true);
  }

  function paint(focus = false) {
    const design = model.get("design"),
      selected = model.get("selected") ?? {};
    title.show(design.name);
    const list = branches(design),
      text = JSON.stringify([list, [...shut], current], (name, value) => (name === "curve" ? value !== null : value));
    if (text !== drawn) {
      const had = focus || tree.contains(document.activeElement);
      drawn = text;
      items = [];
      tree.replaceChildren(...list.map((item) => node(item, 1)));
      items = [...tree.querySelectorAll("[role=treeitem]")].map((own) => items.find((each) => each.own === own));
      if (!items.some(({ item }) => item.id === current)) {
        current = "inputs";
        put(items[0].own, { tabindex: 0 });
      }
      if (had) items.find(({ item }) => item.id === current).own.focus();
    } else {
      // A hand that drags a term changes curves alone.
      const seen = (each) => each.flatMap((item) => [item, ...(shut.has(item.id) ? [] : seen(item.children))]);
      for (const [k, { curve, span }] of seen(list).entries()) {
        const { item, own } = items[k];
        if (JSON.stringify(curve) === JSON.stringify(item.curve)) continue;
        item.curve = curve;
        own.querySelector(".fd-sketch").replaceWith(sketch(curve, span));
      }
    }
    for (const { item, own } of items) {
      const on =
        item.variable !== undefined &&
        item.variable === selected.variable &&
        (item.term ?? null) === (selected.term ?? null);
      put(own, { "aria-selected": String(on) });
      own.classList.toggle("fd-on", on);
    }
    const names = Object.keys(design.choices ?? {}).filter((name) => (design.accepted?.[name]?.length ?? 0) > 1);
    for (const name of names) {
      const options = design.accepted[name].map((value) => [value, VALUE_WORDS[value] ?? value]);
      const select = form.querySelector(`[data-choice="${CSS.escape(name)}"]`);
      if (select) {
        offer(select, options, design.choices[name]);
        continue;
      }
      const word = CHOICE_WORDS[name] ?? name.replaceAll("_", " ");
      const made = choices(word, options, design.choices[name], (value) => edit("choice", { name, value }));
      made.dataset.choice = name;
      form.append(element("label", { class: "fd-choice" }, element("span", { "aria-hidden": "true" }, word), made));
    }
  }

  // However an item came by the focus, the keys are its own.
  tree.addEventListener("focusin", (event) => {
    const id = event.target.closest("[role=treeitem]")?.dataset.id;
    if (id === undefined || id === current) return;
    current = id;
    for (const { item, own } of items) put(own, { tabindex: item.id === id ? 0 : -1 });
  });
  tree.addEventListener("keydown", (event) => {
    const at = items.findIndex(({ item }) => item.id === current),
      { item, open, own } = items[at];
    const go = (to) => {
      if (to) {
        current = to.item.id;
        paint(true);
      }
    };
    const act = {
      ArrowDown: () => go(items[at + 1]),
      ArrowUp: () => go(items[at - 1]),
      Home: () => go(items[0]),
      End: () => go(items.at(-1)),
      ArrowRight: () => (open ? go(items[at + 1]) : item.children.length && fold(item.id, false)),
      ArrowLeft: () =>
        open
          ? fold(item.id, true)
          : go(items.find((each) => each.own === own.closest("[role=group]")?.previousSibling)),
      Enter: () => choose(item),
      " ": () => choose(item),
      Delete: () => {
        if (item.remove) edit("remove_variable", { kind: item.kind, variable: item.remove });
        else if (item.term) edit("remove_term", { kind: item.kind, variable: item.variable, term: item.term });
      },
    }[event.key];
    if (!act || event.ctrlKey || event.metaKey || event.altKey) return;
    event.preventDefault();
    event.stopPropagation();
    act();
  });

  const ends = [
    watch(model, ["design", "selected"], () => {
      settleAwaited();
      paint();
    }),
    watch(model, ["problem"], () => {
      if (model.get("problem")) awaited = null;
      problem.show();
    }),
  ];
  paint();
  return endOf(root, ...ends);
}

export default { render };
