// The histogram of measured rows below the memberships of an input, in the tabs Data and Memberships.
import { said, shape } from "./chart.js";

/** How many rows each bar stands for, of all kinds together. */
const totals = ({ counts }) => counts[0].map((_, k) => counts.reduce((sum, kind) => sum + kind[k], 0));

/** The most rows that a bar stands for. */
export const tallest = (histogram) => Math.max(1, ...totals(histogram));

/** The bars of a histogram between two heights, for a chart with the abscissa `x`: a group. The kinds stand stacked. */
export function bars(histogram, x, top, bottom) {
  const { low, high, counts } = histogram,
    under = totals(histogram).map(() => 0),
    most = tallest(histogram),
    step = (high - low) / under.length;
  const drawn = counts.map((kind, n) => {
    let d = "";
    kind.forEach((count, k) => {
      if (!count) return;
      const [a, b] = [x(low + k * step), x(low + (k + 1) * step)];
      const [y, to] = [under[k], (under[k] += count)].map((v) => bottom - (v / most) * (bottom - top));
      d += `M${a.toFixed(2)} ${y.toFixed(2)}V${to.toFixed(2)}H${b.toFixed(2)}V${y.toFixed(2)}Z`;
    });
    return shape("path", { d, class: n ? "fd-bars fd-second" : "fd-bars" });
  });
  return shape("g", {}, ...drawn);
}

/** A histogram as a strip of its own below a chart, with what it says as its title. */
export function strip(histogram, x, box) {
  const line = { x1: box.left, x2: box.right, y1: box.bottom, y2: box.bottom, class: "fd-grid" };
  return shape(
    "g",
    { role: "img", "aria-label": `The rows of the tab Data. ${histogram.words}` },
    shape("title", {}, histogram.words),
    shape("line", line),
    bars(histogram, x, box.top, box.bottom),
    shape(
      "text",
      { x: box.left - 12, y: box.top + 8, "text-anchor": "end", class: "fd-tick" },
      said(tallest(histogram)),
    ),
    shape("text", { x: box.left - 12, y: box.bottom + 1, "text-anchor": "end", class: "fd-tick" }, "rows"),
  );
}
