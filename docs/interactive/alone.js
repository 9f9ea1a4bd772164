// The designer's membership and rule views without Python behind them: a model that evaluates the system itself.
import { consequent } from "../../fuzzy/plugins/designer/static/outputs.js";
import { clauseDegree, degree } from "../../fuzzy/plugins/designer/static/membership.js";
import { strengthOf } from "../../fuzzy/plugins/designer/static/rulegrid.js";
import terms from "../../fuzzy/plugins/designer/static/terms.js";
import viewer from "../../fuzzy/plugins/designer/static/viewer.js";

const clamped = (value, { low, high }) => Math.min(high, Math.max(low, value));
const said = (value) => String(Number(value.toPrecision(4))).replace("-", "−");
const strength = (value) => (value < 0.01 ? "less than 0.01" : value.toFixed(2));

/** What each rule does at a point, as viewer_data of fuzzy/plugins/designer/views.py tells it. */
export function evaluated(design, point) {
  const { inputs, outputs, choices } = design;
  const at = choices.out_of_range === "clip" ? point.map((value, i) => clamped(value, inputs[i])) : point;
  const place = new Map(inputs.map(({ name }, i) => [name, i]));
  const rules = design.rules.filter(({ enabled }) => enabled);
  const rows = rules.map((rule) => {
    const degrees = rule.when.map((clause) => {
      const i = place.get(clause.variable),
        term = inputs[i].terms.find(({ name }) => name === clause.term);
      return clauseDegree(clause, term.type, at[i], term.parameters);
    });
    const proposed = outputs.map((output) => {
      const named = rule.then.find(({ variable }) => variable === output.name);
      return named
        ? consequent(
            output.terms.find(({ name }) => name === named.term),
            at,
          )
        : null;
    });
    return { key: rule.key, degrees, firing: strengthOf(rule, degrees, choices), proposed };
  });
  const total = outputs.map((_, j) => rows.reduce((sum, row) => sum + (row.proposed[j] === null ? 0 : row.firing), 0));
  const sums = choices.defuzzification === "wtsum";
  for (const row of rows) {
    row.share = row.proposed.map((value, j) => (value === null || !(total[j] > 0) ? null : row.firing / total[j]));
    row.contribution = row.proposed.map((value, j) =>
      value === null ? null : (sums ? row.firing : (row.share[j] ?? 0)) * value,
    );
  }
  const fired = total.map((sum) => sum > 0);
  const output = outputs.map(({ low, high }, j) =>
    fired[j] ? rows.reduce((sum, row) => sum + (row.contribution[j] ?? 0), 0) : (low + high) / 2,
  );
  const words = [
    ...rows
      .filter(({ firing }) => firing > 0)
      .sort((a, b) => b.firing - a.firing)
      .map(({ key, firing }) => {
        const place = design.rules.findIndex((rule) => rule.key === key);
        return `rule ${place + 1} fires ${strength(firing)}: ${design.rules[place].text}`;
      }),
    ...outputs.map(({ name, unit }, j) => `${name} = ${said(output[j])} ${unit}`.trim()),
  ];
  return {
    point: at,
    memberships: inputs.map((variable, i) => variable.terms.map((term) => degree(term.type, at[i], term.parameters))),
    rules: rows,
    output,
    fired,
    outside: [],
    words: words.join("\n"),
  };
}

/** A model in anywidget's form that holds a design by itself. */
export function modelOf(values) {
  const listeners = new Map();
  const tell = (...names) => {
    for (const name of names) for (const listener of listeners.get(`change:${name}`) ?? []) listener();
  };
  const show = (...names) => {
    values.viewer = evaluated(values.design, values.point);
    tell(...names, "viewer");
  };
  let refusals = 0;
  const model = {
    get: (name) => values[name],
    set(name, value) {
      values[name] = value;
      tell(name);
    },
    save_changes() {},
    on(events, listener) {
      for (const event of events.split(" ")) listeners.set(event, new Set([...(listeners.get(event) ?? []), listener]));
    },
    off(events, listener) {
      if (!events) listeners.clear();
      else for (const event of events.split(" ")) listeners.get(event)?.delete(listener);
    },
    send(message) {
      if (message.look === "point") {
        values.point = message.point;
        show("point");
      } else if (message.look === "select") {
        values.selected = { kind: message.kind, variable: message.variable, term: message.term };
        tell("selected");
      } else if (message.edit === "term" && message.parameters) {
        const kind = message.kind === "input" ? "inputs" : "outputs";
        const [design, variable] = [structuredClone(values.design), message.variable];
        const own = design[kind].find(({ name }) => name === variable);
        own.terms.find(({ name }) => name === message.term).parameters = message.parameters;
        design.revision += 1;
        values.design = design;
        values.problem = null;
        show("design", "problem");
      } else {
        const sentence = "This page only moves what is there; the designer itself does that: fuzzy design";
        values.problem = { message: sentence, number: ++refusals, field: message.field ?? null };
        tell("problem");
      }
    },
    widget_manager: null,
  };
  values.viewer = evaluated(values.design, values.point);
  return model;
}

/** What needs the designer itself is not offered: names, types, ranges, and terms more or fewer. */
function narrow(part) {
  const kept = 'input[aria-label^="now"]';
  for (const field of part.querySelectorAll('[aria-label="Variable"] > *'))
    if (!field.querySelector(kept)) field.hidden = true;
  for (const one of part.querySelectorAll(".fd-actions, .fd-row > button")) one.hidden = true;
  for (const one of part.querySelectorAll('[aria-label^="name of "], [aria-label^="type of "]')) one.disabled = true;
}

const VIEWS = { "Membership functions": terms, "Rules at the point": viewer };

/** Put these views into an element. */
export function begin(el, values, names = Object.keys(VIEWS)) {
  const model = modelOf(values);
  for (const name of names) {
    const part = document.createElement("section");
    part.setAttribute("aria-label", name);
    el.append(part);
    VIEWS[name].render({ model, el: part });
    const again = () => narrow(part);
    new MutationObserver(again).observe(part, { childList: true, subtree: true });
    again();
  }
  return model;
}
