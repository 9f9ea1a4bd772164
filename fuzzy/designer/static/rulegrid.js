// The frame of the rule viewer: its columns, a rule's firing strength, and the line of outputs below the rules.
import { clamp, cut, put, quantity, said, scale, shape } from "./chart.js";
import { reach } from "./outputs.js";

/** The columns of the inputs, the firing and the outputs, {kind, from, to, x} each, and the width of all. */
export function columnsOf({ inputs, outputs }, width) {
  const left = 30,
    gap = 16,
    strength = width < 560 ? 56 : 92;
  const each = Math.max(
    84,
    Math.min(
      230,
      (width - left - strength - gap * (inputs.length + outputs.length + 1)) / (inputs.length + outputs.length),
    ),
  );
  let at = left;
  const next = (wide) => {
    const from = at;
    at += wide + gap;
    return { from, to: from + wide };
  };
  const columns = inputs.map((v) => {
    const c = next(each);
    return { ...c, kind: "input", x: scale(v.low, v.high, c.from, c.to) };
  });
  const firing = next(strength);
  columns.push({ ...firing, kind: "firing", x: scale(0, 1, firing.from, firing.to - 30) });
  columns.push(
    ...outputs.map((v) => {
      const c = next(each),
        reached = v.terms.flatMap((term) => reach(term, inputs)).filter(Number.isFinite);
      const low = Math.min(v.low, ...reached),
        high = Math.max(v.high, ...reached),
        room = (high - low || 1) * 0.05;
      return { ...c, kind: "output", x: scale(low - room, high + room, c.from + 2, c.to - 2) };
    }),
  );
  return [columns, at - gap + 4];
}

/** The firing strength of a rule by the degrees of its clauses, as fuzzy/inference.py joins them. */
export function strengthOf(rule, degrees, choices) {
  if (!degrees.length) return 0;
  const { and_method: and = "prod", or_method: or = "probor" } = choices ?? {};
  const join =
    rule.connective === "or"
      ? or === "max"
        ? Math.max
        : (a, b) => a + b - a * b
      : and === "min"
        ? Math.min
        : (a, b) => a * b;
  return degrees.reduce(join) * rule.weight;
}

/** Draw the outputs: every rule's share at its proposal, and the result. */
export function paintFoot(foot, columns, at, { inputs, outputs, choices }) {
  const nodes = [];
  outputs.forEach((variable, j) => {
    const column = columns[inputs.length + 1 + j],
      base = 40,
      value = at?.output?.[j],
      f = at?.fired?.[j] !== false;
    nodes.push(shape("line", { x1: column.from, x2: column.to, y1: base, y2: base, class: "fd-axis" }));
    const [first, last] = [variable.low, variable.high];
    for (const [n, tick] of [
      [0, first],
      [2, last],
    ])
      nodes.push(
        shape(
          "text",
          {
            x: clamp(column.x(tick), column.from, column.to),
            y: base + 15,
            "text-anchor": n ? "end" : "start",
            class: "fd-tick fd-small",
          },
          said(tick, 3),
        ),
      );
    for (const rule of at?.rules ?? []) {
      if (!(rule.share[j] > 0) || rule.proposed[j] === null) continue;
      const px = column.x(rule.proposed[j]);
      nodes.push(shape("line", { x1: px, x2: px, y1: base, y2: base - 26 * rule.share[j], class: "fd-share" }));
    }
    if (Number.isFinite(value ?? NaN)) {
      const px = clamp(column.x(value), column.from, column.to);
      nodes.push(shape("line", { x1: px, x2: px, y1: 4, y2: base, class: f ? "fd-result" : "fd-result fd-dotted" }));
    }
    const text = f ? `= ${quantity(value ?? NaN, variable.unit)}` : "no rule fires";
    nodes.push(
      shape(
        "text",
        { x: column.to, y: base + 32, "text-anchor": "end", class: "fd-answer", "data-output": variable.name },
        cut(text, column.to - column.from + 14, 13, 600),
      ),
    );
  });
  nodes.push(
    shape(
      "text",
      { x: 2, y: 46, class: "fd-name" },
      choices?.defuzzification === "wtsum" ? "weighted sum" : "weighted average",
    ),
  );
  foot.replaceChildren(...nodes);
  put(foot, {
    "aria-label": outputs.map((v, j) => `${v.name} ${quantity(at?.output?.[j] ?? NaN, v.unit)}`).join(", "),
  });
}
