// Several rules of the list, selected: what can be done with them, each as one edit.
import { button, choices, element, offer, put, say } from "./chart.js";
import { numberField, pressing } from "./dragging.js";
import { proposed } from "./matrixcells.js";

/**
 * The selection {node, has, size, pick, all, clear, drop, move, show}; node are its tools. `edit(op, content, gesture)`
 * sends an edit, `shown()` are the keys of the list's rules in its order, `movable()` whether that is the order in which
 * they are written, and `changed()` draws another selection.
 */
export function selectedRules({ model, edit, shown, movable, changed }) {
  const keys = new Set(),
    press = pressing();
  let anchor = null, // from which Shift selects
    extent = null;
  const rules = () => model.get("design").rules;
  const list = () => rules().flatMap(({ key }) => (keys.has(key) ? [key] : []));

  const count = element("span", { class: "fd-count", role: "status" });
  const weight = numberField(
    "weight of the selected rules",
    () => [0, 1],
    (value, event, field) => edit("rule_weight", { keys: list(), weight: value, field }, press(event)),
    "weight",
  );
  const place = numberField(
    "place of the selected rules",
    () => [1, rules().length - keys.size + 1],
    (value, event, field) => edit("move_rule", { keys: list(), to: value - 1, field }, press(event)),
    "to place",
  );
  const tools = {
    up: button("up", "move the selected rules up (Alt+↑)", () => move(-1)),
    down: button("down", "move the selected rules down (Alt+↓)", () => move(1)),
  };
  const thens = element("span", { class: "fd-thens" });
  const node = element(
    "div",
    { class: "fd-selected", role: "group", "aria-label": "Selected rules", hidden: true },
    count,
    button("check", "switch the selected rules on", () => edit("rule_enabled", { keys: list(), enabled: true }), "On"),
    button(
      "cross",
      "switch the selected rules off",
      () => edit("rule_enabled", { keys: list(), enabled: false }),
      "Off",
    ),
    weight.node,
    thens,
    tools.up,
    tools.down,
    place.node,
    button("bin", "delete the selected rules (Delete)", () => drop(), "Delete"),
    button("", "select nothing (Escape)", () => clear(), "Deselect"),
  );

  function drop() {
    if (keys.size) edit("remove_rule", { keys: list() });
  }
  function clear() {
    keys.clear();
    anchor = extent = null;
    changed();
  }
  // All of them together, one place on
  function move(by) {
    if (!keys.size || !movable()) return;
    const order = rules().map((rule) => rule.key),
      picked = list(),
      [first, last] = [picked[0], picked.at(-1)].map((key) => order.slice(0, order.indexOf(key)));
    const before = (by < 0 ? first : last).filter((key) => !keys.has(key)).length,
      to = Math.max(0, Math.min(order.length - picked.length, before + by));
    edit("move_rule", { keys: picked, to });
  }

  function show() {
    const design = model.get("design");
    const there = new Set(design.rules.map((rule) => rule.key));
    for (const key of keys) if (!there.has(key)) keys.delete(key);
    if (!there.has(anchor)) anchor = extent = null;
    node.hidden = keys.size === 0;
    if (!keys.size) return;
    const own = design.rules.filter((rule) => keys.has(rule.key));
    say(count, `${keys.size} selected`);
    const weights = new Set(own.map((rule) => rule.weight));
    weight.show(weights.size === 1 ? own[0].weight : NaN);
    const first = design.rules.findIndex((rule) => keys.has(rule.key));
    place.show(first + 1, JSON.stringify([...keys]));
    for (const tool of Object.values(tools)) tool.disabled = !movable();
    while (thens.childElementCount > design.outputs.length) thens.lastChild.remove();
    design.outputs.forEach((variable, k) => {
      const select =
        thens.children[k] ??
        choices("", [], "", (value) => {
          if (value) edit("rule_then", { keys: list(), ...JSON.parse(value) });
        });
      if (!thens.children[k]) thens.append(select);
      const { name, terms } = variable,
        as = (term) => JSON.stringify({ variable: name, term });
      put(select, { "aria-label": `${name} of the selected rules` });
      const of = new Set(own.map((rule) => proposed(rule, name)));
      const options = [
        ["", `${name} …`],
        ...terms.map((t) => [as(t.name), `${name} is ${t.name}`]),
        [as(null), `no ${name}`],
      ];
      offer(select, options, of.size === 1 ? as([...of][0]) : "");
    });
  }

  return {
    node,
    has: (key) => keys.has(key),
    size: () => keys.size,
    drop,
    clear,
    move,
    show,
    /** Select a rule or not; with `extend` all that are shown from the last one selected to this. */
    pick(key, on, extend) {
      const ids = shown(),
        [a, b] = [ids.indexOf(anchor), ids.indexOf(key)];
      if (extend && a >= 0 && b >= 0) {
        // What Shift took along before, and does not any more
        const old = ids.indexOf(extent);
        if (old >= 0) for (let i = Math.min(a, old); i <= Math.max(a, old); i++) keys.delete(ids[i]);
        for (let i = Math.min(a, b); i <= Math.max(a, b); i++) keys.add(ids[i]);
        extent = key;
      } else {
        if (on) keys.add(key);
        else keys.delete(key);
        anchor = key;
        extent = null;
      }
      changed();
    },
    all() {
      for (const key of shown()) keys.add(key);
      changed();
    },
  };
}
