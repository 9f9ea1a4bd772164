// The contour picture of a surface: filled bands with their levels, a scale of colours, and the two sections' lines.
import { axes, clamp, element, labelled, put, quantity, said, scale, shape, widthOf } from "./chart.js";
import { isoline, levelLabels, paintBands, tint } from "./field.js";

const rgb = (hex) => [1, 3, 5].map((k) => parseInt(hex.slice(k, k + 2), 16));

const REST = 200; // ms without another surface, after which it rests

/** The picture {node, svg, draw(scene), drop()}; `cross` are the sections' lines; draw() gives the scales of x and y. */
export function contourPicture(cross) {
  const bands = element("canvas", { "aria-hidden": "true" }),
    back = shape("g");
  const over = shape("svg", { class: "fd-over-bands", role: "group", "aria-label": "Contour picture" }, back);
  let shown = null,
    looks = "",
    fine = 0,
    last = -Infinity;

  // While the surface changes from frame to frame its bands are painted with fewer dots, and finely once it rests.
  function paintSoon(drawn, levels, map, style) {
    clearTimeout(fine);
    const now = performance.now(),
      busy = now - last < REST;
    last = now;
    paintBands(bands, drawn, levels, map, { ...style, ratio: busy ? 1 : 2 });
    if (busy) fine = setTimeout(() => paintBands(bands, drawn, levels, map, { ...style, ratio: 2 }), REST);
  }

  function draw({ drawn, old, levels, map, title, width, tall, colours, a, b, at }) {
    // The scale of colours is as wide as its numbers.
    const bar = Math.max(60, 22 + Math.max(...levels.map((level) => widthOf(said(level, 3), 12))));
    const high = clamp(Math.min((width - 128) * 0.78, tall - 72), 140, 400);
    const box = { left: 52, right: width - bar - 16, top: 22, bottom: 22 + high };
    const wide = box.right - box.left;
    const x = scale(a.low, a.high, box.left, box.right);
    const y = scale(b.low, b.high, box.bottom, box.top);
    const key = JSON.stringify([levels, map, width, high, colours.paper]);
    if (drawn !== shown || key !== looks) {
      [shown, looks] = [drawn, key];
      paintSoon(drawn, levels, map, {
        width: wide,
        height: high,
        paper: rgb(colours.paper),
        hatch: rgb(colours.hatch),
      });
      Object.assign(bands.style, { left: `${box.left}px`, top: `${box.top}px` });
    }
    put(over, { width, height: box.bottom + 50, viewBox: `0 0 ${width} ${box.bottom + 50}` });
    const px = [x(clamp(at[0], a.low, a.high)), y(clamp(at[1], b.low, b.high))],
      frame = axes(box, x, y, [labelled(a), labelled(b)]);
    frame.querySelectorAll(".fd-grid").forEach((node) => node.remove());
    const lines = old
      ? levels.flatMap((level) => {
          const d = isoline(old, level)
            .map(
              ([x1, y1, x2, y2]) =>
                `M${(box.left + x1 * wide).toFixed(1)} ${(box.bottom - y1 * high).toFixed(1)}L${(box.left + x2 * wide).toFixed(1)} ${(box.bottom - y2 * high).toFixed(1)}`,
            )
            .join("");
          // White over dark: to be seen on every colour.
          return ["fd-iso-under", "fd-compared fd-iso"].map((name) => shape("path", { class: name, d }));
        })
      : [];
    const kept = Array.from({ length: 12 }, (_, k) => [
      { x: px[0] - box.left, y: (high * k) / 11 },
      { x: (wide * k) / 11, y: px[1] - box.top },
    ]).flat();
    const texts = levelLabels(drawn, levels, wide, high, kept).map((label) =>
      shape(
        "text",
        { x: box.left + label.x, y: box.top + label.y + 4, "text-anchor": "middle", class: "fd-level" },
        label.text,
      ),
    );
    back.replaceChildren(frame, ...lines, ...texts, ...colourBar(box, levels, map, title, width, bar));
    if (cross[0].parentNode !== over) over.append(...cross);
    put(cross[0].children[0], { x1: px[0], x2: px[0], y1: box.top, y2: box.bottom });
    put(cross[0].children[1], { x1: px[0], x2: px[0], y1: box.top, y2: box.bottom });
    put(cross[0].children[2], { d: `M${px[0] - 6} ${box.bottom + 10}h12L${px[0]} ${box.bottom}z` });
    put(cross[1].children[0], { x1: box.left, x2: box.right, y1: px[1], y2: px[1] });
    put(cross[1].children[1], { x1: box.left, x2: box.right, y1: px[1], y2: px[1] });
    put(cross[1].children[2], { d: `M${box.left - 10} ${px[1] - 6}v12L${box.left} ${px[1]}z` });
    [a, b].forEach((v, k) =>
      put(cross[k], {
        "aria-label": `section at ${v.name}`,
        "aria-valuemin": v.low,
        "aria-valuemax": v.high,
        "aria-valuenow": clamp(at[k], v.low, v.high),
        "aria-valuetext": quantity(at[k], v),
      }),
    );
    return [x, y];
  }

  const drop = () => clearTimeout(fine);
  return { node: element("div", { class: "fd-bands" }, bands, over), svg: over, draw, drop };
}

// The scale of colours with its numbers
function colourBar(box, levels, map, title, width, bar) {
  const left = width - bar,
    bands = levels.length - 1,
    high = (box.bottom - box.top) / bands,
    out = [];
  const every = Math.max(1, Math.ceil(16 / high));
  levels.forEach((level, k) => {
    const y = box.bottom - k * high;
    if (k < bands)
      out.push(
        shape("rect", {
          x: left,
          y: y - high - 0.3,
          width: 14,
          height: high + 0.6,
          fill: `rgb(${tint(map, bands === 1 ? 0.5 : k / (bands - 1))})`,
        }),
      );
    if (k % every === 0) out.push(shape("text", { x: left + 19, y: y + 4, class: "fd-tick" }, said(level, 3)));
  });
  out.push(shape("text", { x: width - 4, y: box.top - 12, "text-anchor": "end", class: "fd-name" }, labelled(title)));
  return out;
}
