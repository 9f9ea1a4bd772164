// What a rule matrix shows, without the page: which terms stand where, which rules a cell has, and its colour.
import { tint } from "./field.js";
import { degree } from "./membership.js";

const SAMPLES = 201; // of a universe, for the place of a term on it

/** Does a rule ask for terms as they are, joined by "and"? As fuzzy/plugins/designer/ruleedits.py is_plain(). */
export const plain = (rule) =>
  (rule.connective === "and" || rule.when.length === 1) && !rule.when.some((c) => c.negated || c.power !== 1);

// Where a term is greatest: the middle of its core, which for a shoulder is cut off by the universe.
function placeOf({ type, parameters }, { low, high }) {
  let most = 0,
    sum = 0,
    count = 0;
  for (let k = 0; k < SAMPLES; k++) {
    const x = low + ((high - low) * k) / (SAMPLES - 1),
      value = degree(type, x, parameters);
    if (Number.isNaN(value)) return NaN;
    if (value > most + 1e-9) [most, sum, count] = [value, 0, 0];
    if (value > 0 && value >= most - 1e-9) {
      sum += x;
      count++;
    }
  }
  return count ? sum / count : parameters.reduce((a, b) => a + b, 0) / parameters.length;
}

/** The names of an input's terms in the order of their places; as written where one has no formula here. */
export function ordered(variable) {
  const places = new Map(variable.terms.map((term) => [term.name, placeOf(term, variable)]));
  const names = [...places.keys()];
  return [...places.values()].every(Number.isFinite) ? names.sort((a, b) => places.get(a) - places.get(b)) : names;
}

/** A cell's key: the inputs with the terms asked for, null left out. */
export const keyOf = (terms, inputs) => JSON.stringify(inputs.map(({ name }) => terms[name] ?? null));

/** The plain rules by their cells' keys: [{rule, number}]. */
export function byCell({ inputs, rules }) {
  const out = new Map();
  rules.forEach((rule, i) => {
    if (!plain(rule)) return;
    const terms = Object.fromEntries(rule.when.map((clause) => [clause.variable, clause.term]));
    const id = keyOf(terms, inputs);
    if (!out.has(id)) out.set(id, []);
    out.get(id).push({ rule, number: i + 1 });
  });
  return out;
}

/** The two inputs with which a matrix begins: many rules ask for both, and both have many terms; null without any. */
export function commonPair({ inputs, rules }) {
  const terms = new Map(inputs.map((v) => [v.name, v.terms.length])),
    scores = new Map();
  for (const { when } of rules.filter(plain))
    for (let i = 0; i < when.length; i++)
      for (let j = i + 1; j < when.length; j++) {
        const pair = JSON.stringify([when[i].variable, when[j].variable]);
        scores.set(pair, (scores.get(pair) ?? 0) + terms.get(when[i].variable) * terms.get(when[j].variable));
      }
  let best = null;
  for (const [pair, score] of scores) if (best === null || score > scores.get(best)) best = pair;
  return best && JSON.parse(best);
}

/** Is a rule that is not plain about a cell: does it ask for what the cell's terms are? */
export function touches(rule, terms) {
  const fits = ({ variable, term, negated }) => {
    const here = terms[variable] ?? null;
    return here === null ? rule.connective === "and" : (here === term) !== negated;
  };
  return rule.connective === "or" ? rule.when.some(fits) : rule.when.every(fits);
}

/** The consequent of a rule for an output, or null. */
export const proposed = (rule, output) => rule.then.find((each) => each.variable === output)?.term ?? null;

/** The colours of an output's terms, {back, ink} by their names: by the value, or a plane's mean over the inputs. */
export function colours(output, inputs) {
  const means = output.terms.map(({ type, parameters }) =>
    type === "constant"
      ? parameters[0]
      : inputs.reduce((sum, v, i) => sum + (parameters[i] * (v.low + v.high)) / 2, parameters.at(-1)),
  );
  const low = Math.min(...means),
    span = Math.max(...means) - low;
  return new Map(
    output.terms.map((term, k) => {
      const rgb = tint("viridis", span > 0 ? (means[k] - low) / span : 0.5);
      return [term.name, { back: `rgb(${rgb})`, ink: luminance(rgb) > 0.179 ? "black" : "white", mean: means[k] }];
    }),
  );
}

// Relative, as WCAG has it: black on a colour of 0.179 has the same contrast as white, 4.6.
function luminance(rgb) {
  const [r, g, b] = rgb.map((c) => (c / 255 <= 0.04045 ? c / 255 / 12.92 : ((c / 255 + 0.055) / 1.055) ** 2.4));
  return 0.2126 * r + 0.7152 * g + 0.0722 * b;
}

/** The cells [row, column] on the straight way between two, both included. */
export function between([r0, c0], [r1, c1]) {
  const steps = Math.max(Math.abs(r1 - r0), Math.abs(c1 - c0), 1);
  return Array.from({ length: steps + 1 }, (_, k) => [
    Math.round(r0 + ((r1 - r0) * k) / steps),
    Math.round(c0 + ((c1 - c0) * k) / steps),
  ]);
}
