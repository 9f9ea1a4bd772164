// The formulas of fuzzy/membership.py, one line each, and where a curve is taken hold of.
// What else a function is comes from Python as the trait `functions` (functions_data in fuzzy/plugins/designer/views.py): by
// MATLAB's name {title, words, roles, vertices}, called `about` here.
// tests/fuzzy/plugins/designer/test_designer_panels.py holds the formulas against Python's on random and degenerate parameters.

// Formulas -----------------------------------------------------------------------------------------------------

const clipped = (z) => Math.min(1, Math.max(0, z));
const rise = (x, a, b) => (b > a ? clipped((x - a) / (b - a)) : Number(x >= b));
const fall = (x, c, d) => rise(-x, -d, -c);
const sigmoid = (x, a, c) => 1 / (1 + Math.exp(-a * (x - c)));

function spline(x, a, b) {
  if (!(b > a)) return Number(x >= (a + b) / 2);
  const z = clipped((x - a) / (b - a));
  return z < 0.5 ? 2 * z * z : 1 - 2 * (1 - z) ** 2;
}

function bell(x, a, b, c) {
  const z = Math.abs((x - c) / a);
  if (z === 0) return b > 0 ? 1 : b < 0 ? 0 : 0.5;
  return 1 / (1 + Math.exp(2 * b * Math.log(z)));
}

const FORMULAS = {
  trimf: (x, a, b, c) => Math.min(rise(x, a, b), fall(x, b, c)),
  trapmf: (x, a, b, c, d) => Math.min(rise(x, a, b), fall(x, c, d)),
  linsmf: rise,
  linzmf: (x, a, b) => 1 - rise(x, a, b),
  gaussmf: (x, sigma, c) => Math.exp(-0.5 * ((x - c) / sigma) ** 2),
  gauss2mf: (x, s1, c1, s2, c2) =>
    Math.exp(-0.5 * (Math.min(x - c1, 0) / s1) ** 2 - 0.5 * (Math.max(x - c2, 0) / s2) ** 2),
  gbellmf: bell,
  sigmf: sigmoid,
  dsigmf: (x, a1, c1, a2, c2) => clipped(sigmoid(x, a1, c1) - sigmoid(x, a2, c2)),
  psigmf: (x, a1, c1, a2, c2) => sigmoid(x, a1, c1) * sigmoid(x, a2, c2),
  smf: spline,
  zmf: (x, a, b) => spline(-x, -b, -a),
  pimf: (x, a, b, c, d) => spline(x, a, b) * spline(-x, -d, -c),
};

/** The degree of membership of `x` (a number), in [0, 1]; NaN for a type that has no formula here. */
export function degree(type, x, parameters) {
  const formula = FORMULAS[type];
  return formula ? formula(x, ...parameters) : NaN;
}

/**
 * The lower degree at a place, a function, of a type-2 term {type, parameters, lower: [scale, left lag, right lag]} of a
 * variable from low to high: that of fuzzy/plugins/type2/system.py.
 */
export function lowerDegree({ type, parameters, lower: [scale, left, right] }, { roles }, low, high) {
  const at = parameters.filter((_, i) => roles[i] === "location");
  at.push(...at.slice(1).map((b, i) => (at[i] + b) / 2), low, high);
  const degrees = at.map((x) => degree(type, x, parameters)),
    peak = at[degrees.indexOf(Math.max(...degrees))];
  return (x) => {
    const lag = x < peak ? left : right;
    return (scale * Math.max(0, degree(type, x, parameters) - lag)) / (1 - lag);
  };
}

/** The degree of a clause: the term's, to the power of the hedges, then "not". */
export function clauseDegree(clause, type, x, parameters) {
  const value = degree(type, x, parameters) ** clause.power;
  return clause.negated ? 1 - value : value;
}

/**
 * Places to draw a curve through: evenly spread, and on both sides of every corner, so that an edge is upright. Every
 * parameter may be a corner, and the middle of two; a place too many does no harm.
 */
export function places(parameters, low, high, count = 201) {
  const out = Array.from({ length: count }, (_, k) => low + ((high - low) * k) / (count - 1));
  const near = 1e-9 * (high - low);
  const corners = [...parameters];
  if (corners.length === 2) corners.push((corners[0] + corners[1]) / 2);
  for (const c of corners) if (c >= low && c <= high) out.push(Math.max(low, c - near), c, Math.min(high, c + near));
  return out.sort((a, b) => a - b);
}

// Taking hold --------------------------------------------------------------------------------------------------

/** The lowest and highest value of parameter `i` that keeps it in order with its neighbours. */
export function room({ vertices }, parameters, i) {
  let low = -Infinity,
    high = Infinity;
  for (const [k, b] of vertices.slice(1).entries()) {
    const a = vertices[k];
    if (parameters[a] > parameters[b]) continue; // crossed already, which MATLAB allows for some
    if (i === a) high = Math.min(high, parameters[b]);
    if (i === b) low = Math.max(low, parameters[a]);
  }
  return [low, high];
}

/** The parameters with the whole curve moved by `by`. */
export const shifted = ({ roles }, parameters, by) => parameters.map((p, i) => (roles[i] === "location" ? p + by : p));

const within = (value, [low, high]) => Math.min(high, Math.max(low, value));
const replaced = (parameters, i, value) => parameters.map((p, k) => (k === i ? value : p));

// A vertex: the parameter is the place itself.
function vertex(type, about, parameters, i) {
  const range = room(about, parameters, i),
    name = about.words[i],
    x = parameters[i];
  const at = degree(type, x, parameters);
  // At an upright edge foot and shoulder share a place; drawn at their own heights, both can be taken.
  const ends = about.vertices.length === parameters.length;
  const y = ends && name.includes("foot") ? 0 : ends && !(parameters[1] > parameters[2]) ? 1 : at;
  return { name, index: i, x, y, range, move: (to) => replaced(parameters, i, within(to, range)) };
}

// A width: the distance from a centre, which never becomes 0; its sign, which says nothing, stays.
function spread(type, parameters, i, centre, side, name) {
  const sign = Math.sign(parameters[i]) || 1,
    c = parameters[centre],
    x = c + side * Math.abs(parameters[i]);
  const move = (to, least) => replaced(parameters, i, sign * Math.max(least, side * (to - c)));
  const range = side > 0 ? [c, Infinity] : [-Infinity, c];
  return { name, index: i, x, y: degree(type, x, parameters), range, move };
}

// A slope: where its sigmoid is 0.9; it stays on its side of the crossover.
function slope(type, parameters, i, centre, name) {
  const a = parameters[i],
    c = parameters[centre];
  if (a === 0) return null;
  const x = c + Math.log(9) / a,
    side = Math.sign(a);
  const move = (to, least) => replaced(parameters, i, (side * Math.log(9)) / Math.max(least, side * (to - c)));
  const range = side > 0 ? [c, Infinity] : [-Infinity, c];
  return { name, index: i, x, y: degree(type, x, parameters), range, move };
}

// A bell's steepness: where the bell is 0.9, left of its centre: z^2b = 1/9.
function steepness(parameters, name) {
  const [a, b, c] = parameters,
    width = Math.abs(a);
  if (b === 0) return null;
  const z = 9 ** (-1 / (2 * b)),
    x = c - width * z;
  // Between 0.05 and 0.999 of the half-width for b > 0, beyond it for b < 0.
  const inside = (to) => within((c - to) / width, b > 0 ? [1e-3, 0.99] : [1.01, 1e3]);
  const move = (to) => replaced(parameters, 1, -Math.log(9) / (2 * Math.log(inside(to))));
  return { name, index: 1, x, y: degree("gbellmf", x, parameters), range: [-Infinity, c], move };
}

/**
 * The handles of a curve, in the order of the parameters: name, parameter's index, place (x, y), range of x, and
 * move(to, least): the parameters after dragging it to `to`, in order; `least` is the smallest width.
 */
export function handles(type, about, parameters) {
  const { roles, words } = about,
    widths = roles.flatMap((role, i) => (role === "width" ? [i] : []));
  const of = (role, i) => {
    const centre = roles.indexOf("location", i); // a width or a slope belongs to the place that follows
    if (role === "location") return [vertex(type, about, parameters, i)];
    if (role === "slope") return [slope(type, parameters, i, centre, words[i])];
    if (role === "shape") return type === "gbellmf" ? [steepness(parameters, words[i])] : [];
    // One width reaches to both sides, the first of two to the left and the second to the right.
    if (widths.length === 2) return [spread(type, parameters, i, centre, i === widths[0] ? -1 : 1, words[i])];
    return [
      spread(type, parameters, i, centre, -1, `${words[i]}, left`),
      spread(type, parameters, i, centre, 1, words[i]),
    ];
  };
  return roles.flatMap(of).filter((handle) => handle !== null && Number.isFinite(handle.x + handle.y));
}
