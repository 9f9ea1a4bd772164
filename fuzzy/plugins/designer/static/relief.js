// The 3-D picture of a surface on a canvas: a box seen from a side that turns, painted from back to front.
import { said, ticks, widthOf } from "./chart.js";
import { section, tint } from "./field.js";

/** The projection of (x, y, z) in the unit box, seen from the angles, into a canvas. */
function eye({ turn, lift }, width, height) {
  const [c, s, cl, sl] = [Math.cos(turn), Math.sin(turn), Math.cos(lift), Math.sin(lift)];
  const size = Math.min(width * 0.56, height * 0.66);
  return (x, y, z) => {
    const [u, v, w] = [x - 0.5, y - 0.5, (z - 0.5) * 0.75],
      across = c * u - s * v,
      deep = s * u + c * v;
    return [width / 2 + size * across, height * 0.5 - size * (cl * w + sl * deep) + 4, cl * deep - sl * w];
  };
}

/** Paint a field; view: {turn, lift}, scene: {width, height, levels, map, names, point, theme, second}. */
export function paintRelief(canvas, field, view, scene) {
  const { width, height, levels, map, names, theme } = scene,
    ratio = Math.max(1, window.devicePixelRatio || 1);
  canvas.width = Math.round(width * ratio);
  canvas.height = Math.round(height * ratio);
  Object.assign(canvas.style, { width: `${width}px`, height: `${height}px` });
  const pen = canvas.getContext("2d"),
    project = eye(view, width, height),
    low = levels[0],
    high = levels.at(-1);
  const unit = (value) => (value - low) / (high - low),
    path = (points) => {
      pen.beginPath();
      points.forEach((p, k) => (k ? pen.lineTo(p[0], p[1]) : pen.moveTo(p[0], p[1])));
    };
  pen.setTransform(ratio, 0, 0, ratio, 0, 0);
  pen.clearRect(0, 0, width, height);
  pen.lineJoin = "round";
  // Which walls are at the back
  const far = (x, y) => project(x, y, 0.5)[2],
    backX = far(1, 0.5) > far(0, 0.5) ? 1 : 0,
    backY = far(0.5, 1) > far(0.5, 0) ? 1 : 0;
  const ends = [
    [field.x[0], field.x.at(-1)],
    [field.y[0], field.y.at(-1)],
    [low, high],
  ];
  const marks = ends.map(([a, b]) => ticks(a, b, 4).map((value) => [value, (value - a) / (b - a || 1)]));
  pen.strokeStyle = theme.line;
  pen.lineWidth = 1;
  const stroke = (...points) => {
    path(points.map((p) => project(...p)));
    pen.stroke();
  };
  for (const [, t] of marks[0]) stroke([t, 1 - backY, 0], [t, backY, 0], [t, backY, 1]);
  for (const [, t] of marks[1]) stroke([1 - backX, t, 0], [backX, t, 0], [backX, t, 1]);
  for (const [, t] of marks[2]) stroke([1 - backX, backY, t], [backX, backY, t], [backX, 1 - backY, t]);
  pen.strokeStyle = theme.quiet;
  stroke([0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0], [0, 0, 0]);
  stroke([backX, backY, 0], [backX, backY, 1]);

  const faces = [],
    add = (deep, draw) => faces.push({ deep, draw });
  const { nx, ny, z, fired } = field,
    stepX = Math.max(1, Math.round((nx - 1) / 40)),
    stepY = Math.max(1, Math.round((ny - 1) / 40));
  for (let j = 0; j + stepY < ny; j += stepY) {
    for (let i = 0; i + stepX < nx; i += stepX) {
      const ids = [
          [i, j],
          [i + stepX, j],
          [i + stepX, j + stepY],
          [i, j + stepY],
        ],
        at = ids.map(([a, b]) => b * nx + a),
        known = at.every((k) => fired[k] && Number.isFinite(z[k]));
      const flat = (h) => ids.map(([a, b], n) => project(a / (nx - 1), b / (ny - 1), known ? unit(z[at[n]]) : h));
      const quad = flat(0),
        deep = (quad[0][2] + quad[2][2]) / 2;
      if (!known) {
        path(quad);
        pen.fillStyle = hatching(pen, theme);
        pen.fill();
        continue;
      }
      const mean = at.reduce((sum, k) => sum + unit(z[k]), 0) / 4,
        slope = unit(z[at[1]]) - unit(z[at[0]]) + (unit(z[at[2]]) - unit(z[at[1]])),
        shade = 1 - 0.16 * Math.tanh(6 * slope);
      const tone = tint(map, mean).map((v) => Math.min(255, Math.round(v * shade)));
      add(deep, () => {
        path(quad);
        pen.closePath();
        pen.fillStyle = `rgb(${tone})`;
        pen.fill();
        pen.strokeStyle = "rgba(0, 0, 0, 0.22)";
        pen.lineWidth = 0.5;
        pen.stroke();
      });
    }
  }
  const ribbon = (cut, where, style) => {
    const put = cut.at.map((_, k) => project(...where(k / (cut.at.length - 1)), unit(cut.z[k])));
    for (let k = 0; k + 1 < put.length; k++) {
      if (!cut.fired[k] || !cut.fired[k + 1]) continue;
      add((put[k][2] + put[k + 1][2]) / 2 - 0.03, () => {
        Object.assign(pen, style);
        path([put[k], put[k + 1]]);
        pen.stroke();
      });
    }
  };
  if (scene.second) {
    // The other design as a mesh of grey lines
    for (let n = 0; n <= 12; n++) {
      const style = { strokeStyle: theme.other, lineWidth: 1.1 },
        t = n / 12,
        of = (list) => list[0] + t * (list.at(-1) - list[0]);
      ribbon(section(scene.second, "x", of(field.y)), (s) => [s, t], style);
      ribbon(section(scene.second, "y", of(field.x)), (s) => [t, s], style);
    }
  }
  const share = scene.point.map((value, k) =>
      Math.min(1, Math.max(0, (value - ends[k][0]) / (ends[k][1] - ends[k][0] || 1))),
    ),
    mark = { strokeStyle: theme.mark, lineWidth: 2.4 };
  ribbon(section(field, "x", scene.point[1]), (s) => [s, share[1]], mark);
  ribbon(section(field, "y", scene.point[0]), (s) => [share[0], s], mark);
  faces.sort((a, b) => b.deep - a.deep);
  for (const { draw } of faces) draw();

  // Numbers and names along the near edges
  pen.font = '12px system-ui, "Segoe UI", "DejaVu Sans", sans-serif';
  pen.fillStyle = theme.quiet;
  pen.textBaseline = "middle";
  const centre = project(0.5, 0.5, 0),
    middles = [project(0.5, 1 - backY, 0), project(1 - backX, 0.5, 0)];
  // All numbers of an edge go the same way: where two edges meet they part.
  const ways = middles.map(([x, y]) => {
    const d = Math.hypot(x - centre[0], y - centre[1]) || 1;
    return [(x - centre[0]) / d, (y - centre[1]) / d];
  });
  const write = (text, p, [ux, uy], out, strong = false) => {
    const wide = widthOf(text, 12);
    pen.fillStyle = strong ? theme.ink : theme.quiet;
    pen.textAlign = "center";
    const x = p[0] + ux * (out + Math.abs(ux) * wide * 0.5),
      y = p[1] + Math.max(uy, 0.25) * out + (strong ? 3 : 0);
    pen.fillText(text, Math.min(width - wide / 2 - 2, Math.max(wide / 2 + 2, x)), Math.min(height - 8, y));
  };
  for (const [value, t] of marks[0]) write(said(value, 3), project(t, 1 - backY, 0), ways[0], 13);
  for (const [value, t] of marks[1]) write(said(value, 3), project(1 - backX, t, 0), ways[1], 13);
  middles.forEach((p, k) => write(names[k], p, ways[k], 36, true));
  const posts = [
    [1 - backX, backY],
    [backX, 1 - backY],
  ].sort((a, b) => project(...a, 0)[0] - project(...b, 0)[0])[0];
  pen.textAlign = "right";
  pen.fillStyle = theme.quiet;
  for (const [value, t] of marks[2]) {
    const p = project(...posts, t);
    pen.fillText(said(value, 3), p[0] - 7, t < 0.03 ? p[1] - 7 : p[1]); // at the corner another axis has its number
  }
  const top = project(...posts, 1);
  pen.fillStyle = theme.ink;
  pen.textAlign = "left";
  pen.fillText(names[2], Math.max(4, top[0] - widthOf(names[2], 12) / 2), Math.max(10, top[1] - 18));
}

function hatching(pen, theme) {
  const tile = document.createElement("canvas");
  tile.width = tile.height = 7;
  const small = tile.getContext("2d");
  small.strokeStyle = theme.hatch;
  small.lineWidth = 1;
  small.beginPath();
  small.moveTo(-1, 8);
  small.lineTo(8, -1);
  small.stroke();
  return pen.createPattern(tile, "repeat");
}
