// The frame of the rule viewer: its columns, a rule's firing strength, and the line of outputs below the rules.
import { clamp, cut, put, quantity, said, scale, shape, widthOf } from "./chart.js";
import { reach } from "./outputs.js";

const NARROWEST = 36; // px of a column

/** The columns of the inputs, the firing and the outputs, {kind, from, to, x} each, and the width of all. */
export function columnsOf({ inputs, outputs }, width) {
  // With many variables the columns grow narrow before one has to scroll: the outputs are to be seen with the inputs.
  const many = inputs.length + outputs.length,
    tight = width < 110 * (many + 1),
    left = tight ? 26 : 30,
    gap = tight ? 8 : 16,
    strength = tight ? 52 : 92;
  const each = clamp((width - left - strength - gap * many - 4) / many, NARROWEST, 230);
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
      return { ...c, kind: "output", ends: [low, high], x: scale(low - room, high + room, c.from + 2, c.to - 2) };
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
  return degrees.reduce((a, b) => join(a, b)) * rule.weight; // reduce would give Math.min more than two
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
    // The axis goes as far as consequents do; the output's range on it is the thicker part.
    nodes.push(
      shape(
        "line",
        { x1: column.x(variable.low), x2: column.x(variable.high), y1: base, y2: base, class: "fd-range" },
        shape("title", {}, `range ${said(variable.low)} to ${quantity(variable.high, variable)}`),
      ),
    );
    const numbers = column.ends.map((tick) => said(tick, 3, column.ends[1] - column.ends[0]));
    const together = numbers.reduce((sum, text) => sum + widthOf(text, 10.5), 10);
    for (const [n, text] of together < column.to - column.from ? numbers.entries() : [])
      nodes.push(
        shape(
          "text",
          {
            x: n ? column.to : column.from,
            y: base + 15,
            "text-anchor": n ? "end" : "start",
            class: "fd-tick fd-small",
          },
          text,
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
    // A number is not cut: where there is no room for it with its unit, it stands alone, in smaller digits if need be.
    const wide = column.to - column.from + 6,
      fits = (text, size) => widthOf(text, size, 600) <= wide;
    const full = f ? `= ${quantity(value ?? NaN, variable)}` : "no rule fires",
      text = fits(full, 13) ? full : f ? said(value ?? NaN, 3, variable.high - variable.low) : cut(full, wide, 11, 600);
    nodes.push(
      shape(
        "text",
        {
          x: column.to,
          y: base + 32,
          "text-anchor": "end",
          class: fits(text, 13) ? "fd-answer" : "fd-answer fd-small",
          "data-output": variable.name,
        },
        text,
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
    "aria-label": outputs.map((v, j) => `${v.name} ${quantity(at?.output?.[j] ?? NaN, v)}`).join(", "),
  });
}
