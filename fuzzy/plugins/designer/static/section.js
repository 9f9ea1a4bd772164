// A section of a surface, or the curve over a single input: the line, where no rule fires, and the other design's.
import { axes, clamp, labelled, line, put, quantity, scale, shape, element } from "./chart.js";
import { section } from "./field.js";

/**
 * The chart {node, svg, draw(scene, along, width)}; `own` begins the names that the page shares, `cross` are the
 * lines to drag, of which a curve over one input shows the first. draw() gives such a curve's scale, else null.
 */
export function sectionChart(own, cross) {
  const rest = shape("g"),
    svg = shape("svg", { class: "fd-chart", role: "img" }, rest);

  function draw({ drawn, old, levels, title, a, b, at }, along, width) {
    let lone = null;
    const variable = along === "x" ? a : b,
      across = along === "x" ? b : a,
      value = along === "x" ? at[1] : at[0],
      here = along === "x" ? at[0] : at[1];
    const cut = section(drawn, along, value ?? 0),
      frame = { left: 52, right: width - 16, top: 40, bottom: drawn.flat ? 160 : 300 };
    const x = scale(variable.low, variable.high, frame.left, frame.right),
      y = scale(levels[0], levels.at(-1), frame.bottom, frame.top),
      px = x(clamp(here, variable.low, variable.high));
    put(svg, { width, height: frame.bottom + 50, viewBox: `0 0 ${width} ${frame.bottom + 50}` });
    const parts = [axes(frame, x, y, [labelled(variable), null])],
      path = (c, ok) =>
        line(
          c.at.map(x),
          c.z.map((z, k) => (ok(k) ? y(clamp(z, levels[0], levels.at(-1))) : NaN)),
        );
    // Where no rule fires: a hatched band over the whole height
    const id = `${own}-${along}`;
    parts.push(
      shape(
        "defs",
        {},
        shape(
          "pattern",
          { id, width: 7, height: 7, patternUnits: "userSpaceOnUse", patternTransform: "rotate(45)" },
          shape("line", { x1: 0, x2: 0, y1: 0, y2: 7, class: "fd-hatch" }),
        ),
      ),
    );
    for (let k = 0; k < cut.at.length; k++) {
      if (cut.fired[k]) continue;
      const from = k;
      while (k + 1 < cut.at.length && !cut.fired[k + 1]) k++;
      const half = (cut.at[1] - cut.at[0]) / 2,
        [l, r] = [
          x(clamp(cut.at[from] - half, variable.low, variable.high)),
          x(clamp(cut.at[k] + half, variable.low, variable.high)),
        ];
      parts.push(
        shape("rect", {
          x: l,
          width: r - l,
          y: frame.top,
          height: frame.bottom - frame.top,
          fill: `url(#${id})`,
          class: "fd-gap",
        }),
      );
    }
    if (old) parts.push(shape("path", { d: path(section(old, along, value ?? 0), () => true), class: "fd-compared" }));
    parts.push(
      shape("path", { d: path(cut, (k) => !cut.fired[k]), class: "fd-unfired" }),
      shape("path", { d: path(cut, (k) => cut.fired[k]), class: "fd-section", "data-along": along }),
    );
    parts.push(shape("line", { x1: px, x2: px, y1: frame.top, y2: frame.bottom, class: "fd-cross" }));
    const text = drawn.flat ? `${title.name} at ${across.name} = ${quantity(value, across)}` : labelled(title);
    parts.push(shape("text", { x: 14, y: 16, class: "fd-name fd-strong" }, text));
    if (!drawn.flat) {
      put(cross[0].children[0], { x1: px, x2: px, y1: frame.top, y2: frame.bottom });
      put(cross[0].children[1], { x1: px, x2: px, y1: frame.top, y2: frame.bottom });
      put(cross[0].children[2], { d: `M${px - 6} ${frame.bottom + 10}h12L${px} ${frame.bottom}z` });
      put(cross[0], {
        "aria-label": `current ${variable.name}`,
        "aria-valuemin": variable.low,
        "aria-valuemax": variable.high,
        "aria-valuenow": clamp(here, variable.low, variable.high),
        "aria-valuetext": quantity(here, variable),
      });
      if (cross[0].parentNode !== svg) {
        cross[1].remove();
        svg.append(cross[0]);
      }
      lone = x;
    }
    rest.replaceChildren(...parts);
    put(svg, {
      "aria-label": `${text}${drawn.flat ? "" : ` over ${variable.name}`}`,
      role: drawn.flat ? "img" : "group",
    });
    return lone;
  }

  return { node: element("div", { class: "fd-plot" }, svg), svg, draw };
}
