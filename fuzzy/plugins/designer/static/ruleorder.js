// Which rules the list shows and in which order; the rules themselves stay as they are written.
import { colours, ordered, proposed } from "./matrixcells.js";

/** The orders that a design offers, [value, text]. */
export const orders = ({ inputs, outputs }) => [
  ["", "as written"],
  ["firing", "strength now"],
  ...outputs.map(({ name }) => [JSON.stringify({ output: name }), `consequent: ${name}`]),
  ...inputs.map(({ name }) => [JSON.stringify({ input: name }), `term: ${name}`]),
];

// A number by which rules are sorted; equals stay as they are written, and what has none comes last.
function rank(order, { inputs, outputs }, firing) {
  if (order === "firing") return (rule) => -(firing.get(rule.key) ?? -1);
  const { input, output } = JSON.parse(order);
  if (output !== undefined) {
    const variable = outputs.find((v) => v.name === output),
      tints = variable ? colours(variable, inputs) : new Map();
    return (rule) => tints.get(proposed(rule, output))?.mean ?? Infinity;
  }
  const variable = inputs.find((v) => v.name === input),
    places = new Map((variable ? ordered(variable) : []).map((name, k) => [name, k]));
  return (rule) => places.get(rule.when.find((clause) => clause.variable === input)?.term) ?? Infinity;
}

/** The rules with all of some words, of these those that fire where asked for, in an order; `held` is always there. */
export function listed(design, viewer, { words, fires, order, held }) {
  const firing = new Map((viewer?.rules ?? []).map((rule) => [rule.key, rule.firing]));
  const found = design.rules.filter(
    ({ key, text }) =>
      String(key) === held ||
      ((!fires || firing.get(key) > 0) && words.every((word) => text.toLowerCase().includes(word))),
  );
  if (!order) return found.map((rule) => rule.key);
  const of = rank(order, design, firing),
    value = new Map(found.map((rule) => [rule.key, of(rule)]));
  const by = (a, b) => (value.get(a.key) === value.get(b.key) ? 0 : value.get(a.key) < value.get(b.key) ? -1 : 1);
  return found.sort(by).map((rule) => rule.key);
}
