// An output over one or two inputs: its numbers, levels, colours, sections, and the filled bands of a contour picture.
import { said, ticks, widthOf } from "./chart.js";

const VIRIDIS = [
  "#440154",
  "#481a6c",
  "#472f7d",
  "#414487",
  "#39568c",
  "#31688e",
  "#2a788e",
  "#23888e",
  "#1f988b",
  "#22a884",
  "#35b779",
  "#54c568",
  "#7ad151",
  "#a5db36",
  "#d2e21b",
  "#fde725",
];
const PUOR = [
  "#7f3b08",
  "#b35806",
  "#e08214",
  "#fdb863",
  "#fee0b6",
  "#f7f7f7",
  "#d8daeb",
  "#b2abd2",
  "#8073ac",
  "#542788",
  "#2d004b",
];
const parsed = (list) => list.map((hex) => [1, 3, 5].map((k) => parseInt(hex.slice(k, k + 2), 16)));
const MAPS = { viridis: parsed(VIRIDIS), difference: parsed(PUOR) };

/** The colour [r, g, b] of a share in [0, 1]. */
export function tint(map, share) {
  const list = MAPS[map],
    at = Math.min(1, Math.max(0, share)) * (list.length - 1),
    k = Math.min(list.length - 2, Math.floor(at));
  return list[k].map((c, n) => Math.round(c + (at - k) * (list[k + 1][n] - c)));
}

// As a picture keeps it: red in the lowest byte, opaque
const packed = ([r, g, b]) => ((255 << 24) | (b << 16) | (g << 8) | r) >>> 0;

/** What a trait `surface` says, as one row of numbers; null is not-a-number. */
export function fieldOf(surface) {
  const flat = surface.y !== null && surface.y !== undefined,
    number = (v) => (v === null ? NaN : Number(v));
  const rows = flat ? surface.z : [surface.z],
    fired = flat ? surface.fired : [surface.fired];
  const axis = (values) => (values && Array.isArray(values[0]) ? null : values);
  const x = axis(surface.x) ?? surface.x[0],
    y = flat ? (axis(surface.y) ?? surface.y.map((row) => row[0])) : [0];
  return {
    x,
    y,
    nx: x.length,
    ny: rows.length,
    flat,
    z: Float64Array.from(rows.flat(), number),
    fired: Uint8Array.from(fired.flat(), Number),
  };
}

/** a − b, where both are known; null where the grids differ. */
export function difference(a, b) {
  const same = (p, q) => p.length === q.length && p.every((v, k) => Math.abs(v - q[k]) < 1e-9 * (1 + Math.abs(v)));
  if (!b || a.flat !== b.flat || !same(a.x, b.x) || !same(a.y, b.y)) return null;
  return { ...a, z: a.z.map((v, k) => v - b.z[k]), fired: a.fired.map((v, k) => v & b.fired[k]) };
}

/** The lowest and highest value where a rule fires, and round levels between them. */
export function levelsOf(fields, centred = false) {
  let low = Infinity,
    high = -Infinity;
  for (const { z, fired } of fields)
    for (let k = 0; k < z.length; k++)
      if (fired[k] && Number.isFinite(z[k])) {
        low = Math.min(low, z[k]);
        high = Math.max(high, z[k]);
      }
  if (!(low <= high)) [low, high] = [0, 1];
  if (centred) {
    high = Math.max(Math.abs(low), Math.abs(high));
    low = -high;
  }
  // A flat surface still needs two levels round its one value.
  const middle = (low + high) / 2,
    half = Math.max((high - low) / 2, Math.abs(middle) * 1e-6, 1e-9);
  if (high - low < 1e-6 * Math.max(Math.abs(low), Math.abs(high), 1e-3)) {
    low = middle - Math.max(half, 0.05 * Math.abs(middle) || 0.5);
    high = 2 * middle - low;
  }
  const list = ticks(low, high, 10),
    step = list.length > 1 ? list[1] - list[0] : high - low;
  const first = Math.floor(low / step + 1e-9) * step,
    count = Math.max(1, Math.ceil((high - first) / step - 1e-9));
  return Array.from({ length: count + 1 }, (_, k) => Number((first + k * step).toPrecision(12)));
}

const cell = (list, value) => {
  const n = list.length,
    at = n < 2 ? 0 : ((value - list[0]) / (list[n - 1] - list[0] || 1)) * (n - 1),
    k = Math.max(0, Math.min(n - 2, Math.floor(at)));
  return [k, Math.min(1, Math.max(0, at - k))];
};

/** The field along x at `value` of y (or along y at `value` of x): {at, z, fired}. */
export function section(field, along, value) {
  const { x, y, nx, z, fired } = field,
    across = along === "x" ? y : x,
    own = along === "x" ? x : y,
    [k, share] = cell(across, value);
  const index = (i, j) => (along === "x" ? j * nx + i : i * nx + j),
    out = { at: own, z: [], fired: [] };
  for (let i = 0; i < own.length; i++) {
    const a = index(i, k),
      b = across.length > 1 ? index(i, k + 1) : a;
    out.z.push(share === 0 ? z[a] : share === 1 ? z[b] : z[a] + share * (z[b] - z[a]));
    out.fired.push(share < 0.5 ? fired[a] : fired[b]);
  }
  return out;
}

/** Paint the filled bands into a canvas of width × height CSS pixels, `ratio` dots a pixel, hatched where no rule fires. */
export function paintBands(canvas, field, levels, map, style) {
  const ratio = style.ratio ?? 2,
    wide = Math.max(1, Math.round(style.width * ratio)),
    high = Math.max(1, Math.round(style.height * ratio));
  canvas.width = wide;
  canvas.height = high;
  Object.assign(canvas.style, { width: `${style.width}px`, height: `${style.height}px` });
  const pen = canvas.getContext("2d"),
    image = pen.createImageData(wide, high),
    dots = new Uint32Array(image.data.buffer),
    { nx, ny, z, fired } = field;
  const bands = levels.length - 1,
    base = levels[0],
    step = levels[1] - base,
    tints = levels.map((_, k) => tint(map, bands === 1 ? 0.5 : k / (bands - 1))),
    inside = Uint32Array.from(tints, packed),
    edges = Uint32Array.from(tints, (tone) => packed(tone.map((c) => Math.round(0.55 * c + 0.45 * 255))));
  const [paper, hatch] = [packed(style.paper), packed(style.hatch)],
    [period, thick] = [7 * ratio, 1.25 * ratio],
    line = new Int16Array(wide).fill(-1);
  // Where a column of dots stands between the columns of the field
  const columns = new Int32Array(wide),
    shares = new Float64Array(wide);
  for (let px = 0; px < wide; px++) {
    const u = ((px + 0.5) / wide) * (nx - 1);
    columns[px] = Math.min(nx - 2, Math.floor(u));
    shares[px] = u - columns[px];
  }
  for (let py = 0, at = 0; py < high; py++) {
    const v = (1 - (py + 0.5) / high) * (ny - 1),
      j = Math.min(ny - 2, Math.floor(v)),
      t = v - j;
    let left = -1;
    for (let px = 0; px < wide; px++, at++) {
      const s = shares[px],
        a = j * nx + columns[px],
        b = a + nx;
      const value = (1 - t) * ((1 - s) * z[a] + s * z[a + 1]) + t * ((1 - s) * z[b] + s * z[b + 1]);
      // A cell with a corner where no rule fires is not the rules' own.
      if (fired[a] && fired[a + 1] && fired[b] && fired[b + 1] && value === value) {
        const band = Math.max(0, Math.min(bands - 1, Math.floor((value - base) / step + 1e-9))),
          above = line[px];
        dots[at] = ((left >= 0 && left !== band) || (above >= 0 && above !== band) ? edges : inside)[band];
        left = line[px] = band;
      } else {
        dots[at] = (px + py) % period < thick ? hatch : paper;
        left = line[px] = -1;
      }
    }
  }
  pen.putImageData(image, 0, 0);
}

/** The lines of one level, as segments [x1, y1, x2, y2] in shares of the box (y upward). */
export function isoline(field, level) {
  const { nx, ny, z, fired } = field,
    out = [];
  for (let j = 0; j < ny - 1; j++) {
    for (let i = 0; i < nx - 1; i++) {
      const a = j * nx + i,
        corners = [a, a + 1, a + nx + 1, a + nx];
      if (!corners.every((k) => fired[k] && Number.isFinite(z[k]))) continue;
      const where = [
          [i, j],
          [i + 1, j],
          [i + 1, j + 1],
          [i, j + 1],
        ],
        cuts = [];
      for (let k = 0; k < 4; k++) {
        const m = (k + 1) % 4,
          p = z[corners[k]] - level,
          q = z[corners[m]] - level;
        if (p < 0 === q < 0) continue;
        const s = p / (p - q);
        cuts.push([
          (where[k][0] + s * (where[m][0] - where[k][0])) / (nx - 1),
          (where[k][1] + s * (where[m][1] - where[k][1])) / (ny - 1),
        ]);
      }
      for (let k = 0; k + 1 < cuts.length; k += 2) out.push([...cuts[k], ...cuts[k + 1]]);
    }
  }
  return out;
}

/** Where to write the levels: {x, y, text} in pixels of the box, apart from each other, the rim and `kept`. */
export function levelLabels(field, levels, width, height, kept = []) {
  const out = [];
  for (const level of levels.slice(1, -1)) {
    const text = said(level, 3),
      wide = widthOf(text, 11) + 8;
    let best = null,
      most = 0;
    for (const [x1, y1, x2, y2] of isoline(field, level)) {
      const x = ((x1 + x2) / 2) * width,
        y = (1 - (y1 + y2) / 2) * height;
      const rim = Math.min(x - wide / 2 - 2, width - wide / 2 - 2 - x, y - 9, height - 9 - y);
      const far = Math.min(
        ...out.map((o) => Math.max(Math.abs(o.x - x) - (o.wide + wide) / 2, Math.abs(o.y - y) - 14)),
        ...kept.map((k) => Math.max(Math.abs(k.x - x) - wide / 2, Math.abs(k.y - y) - 8)),
        60,
      );
      const room = Math.min(rim, far);
      if (rim > 0 && far > 2 && room > most) [best, most] = [{ x, y, text, wide }, room];
    }
    if (best) out.push(best);
  }
  return out;
}
