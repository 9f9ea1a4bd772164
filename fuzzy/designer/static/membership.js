// MATLAB's 13 membership functions as fuzzy/membership.py states them, and where each is taken hold of.
// tests/fuzzy/test_designer_modules.py holds the two against each other on random and degenerate parameters.

/** The words of each parameter, in MATLAB's order. */
export const PARAMETERS = {
  trimf: ["left foot", "peak", "right foot"],
  trapmf: ["left foot", "left shoulder", "right shoulder", "right foot"],
  linsmf: ["foot", "shoulder"],
  linzmf: ["shoulder", "foot"],
  gaussmf: ["width σ", "centre"],
  gauss2mf: ["left width σ₁", "left end c₁", "right width σ₂", "right end c₂"],
  gbellmf: ["half-width a", "steepness b", "centre c"],
  sigmf: ["slope a", "crossover c"],
  dsigmf: ["slope a₁", "crossover c₁", "slope a₂", "crossover c₂"],
  psigmf: ["slope a₁", "crossover c₁", "slope a₂", "crossover c₂"],
  smf: ["foot", "shoulder"],
  zmf: ["shoulder", "foot"],
  pimf: ["left foot", "left shoulder", "right shoulder", "right foot"],
};
export const FUNCTIONS = Object.keys(PARAMETERS);
/** The functions in words, for a list to choose from. */
export const FUNCTION_WORDS = {
  trimf: "triangle",
  trapmf: "trapezoid",
  linsmf: "straight ramp up",
  linzmf: "straight ramp down",
  gaussmf: "Gaussian",
  gauss2mf: "two-sided Gaussian",
  gbellmf: "bell",
  sigmf: "sigmoid",
  dsigmf: "difference of sigmoids",
  psigmf: "product of sigmoids",
  smf: "S-shape",
  zmf: "Z-shape",
  pimf: "π-shape",
};

// Which parameters are places on the axis of x: they move together when the whole curve is moved.
const PLACES = {
  trimf: [0, 1, 2],
  trapmf: [0, 1, 2, 3],
  linsmf: [0, 1],
  linzmf: [0, 1],
  gaussmf: [1],
  gauss2mf: [1, 3],
  gbellmf: [2],
  sigmf: [1],
  dsigmf: [1, 3],
  psigmf: [1, 3],
  smf: [0, 1],
  zmf: [0, 1],
  pimf: [0, 1, 2, 3],
};
// Which are neighbours: one that is not right of the other stays so.
const NEIGHBOURS = {
  trimf: [
    [0, 1],
    [1, 2],
  ],
  trapmf: [
    [0, 1],
    [1, 2],
    [2, 3],
  ],
  linsmf: [[0, 1]],
  linzmf: [[0, 1]],
  gauss2mf: [[1, 3]],
  smf: [[0, 1]],
  zmf: [[0, 1]],
  pimf: [
    [0, 1],
    [1, 2],
    [2, 3],
  ],
};

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

/** The degree of membership of `x` (a number), in [0, 1]; NaN for a type that is none of MATLAB's. */
export function degree(type, x, parameters) {
  const formula = FORMULAS[type];
  return formula ? formula(x, ...parameters) : NaN;
}

/** The degree of a clause: the term's, to the power of the hedges, then "not". */
export function clauseDegree(clause, type, x, parameters) {
  const value = degree(type, x, parameters) ** clause.power;
  return clause.negated ? 1 - value : value;
}

/** Places to draw a curve through: evenly spread, and on both sides of every corner, so that an edge is upright. */
export function places(type, parameters, low, high, count = 201) {
  const out = Array.from({ length: count }, (_, k) => low + ((high - low) * k) / (count - 1));
  const near = 1e-9 * (high - low);
  const corners = (PLACES[type] ?? []).map((i) => parameters[i]);
  if (corners.length === 2) corners.push((corners[0] + corners[1]) / 2);
  for (const c of corners) if (c >= low && c <= high) out.push(Math.max(low, c - near), c, Math.min(high, c + near));
  return out.sort((a, b) => a - b);
}

// Taking hold --------------------------------------------------------------------------------------------------

/** The lowest and highest value of parameter `i` that keeps it in order with its neighbours. */
export function room(type, parameters, i) {
  let low = -Infinity,
    high = Infinity;
  for (const [a, b] of NEIGHBOURS[type] ?? []) {
    if (parameters[a] > parameters[b]) continue; // crossed already, which MATLAB allows for some
    if (i === a) high = Math.min(high, parameters[b]);
    if (i === b) low = Math.max(low, parameters[a]);
  }
  return [low, high];
}

/** The parameters with the whole curve moved by `by`. */
export const shifted = (type, parameters, by) => parameters.map((p, i) => (PLACES[type].includes(i) ? p + by : p));

const within = (value, [low, high]) => Math.min(high, Math.max(low, value));
const replaced = (parameters, i, value) => parameters.map((p, k) => (k === i ? value : p));

// A vertex: the parameter is the place itself.
function vertex(type, parameters, i) {
  const range = room(type, parameters, i),
    x = parameters[i];
  const at = degree(type, x, parameters);
  // At an upright edge foot and shoulder share a place; drawn at their own heights, both can be taken.
  const foot = PARAMETERS[type][i].includes("foot");
  const high = { gaussmf: 1, gauss2mf: at, gbellmf: at, sigmf: 0.5 }[type];
  const y = foot ? 0 : (high ?? (type === "dsigmf" || type === "psigmf" || parameters[1] > parameters[2] ? at : 1));
  return { name: PARAMETERS[type][i], index: i, x, y, range, move: (to) => replaced(parameters, i, within(to, range)) };
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
function slope(type, parameters, i) {
  const a = parameters[i],
    c = parameters[i + 1];
  if (a === 0) return null;
  const x = c + Math.log(9) / a,
    side = Math.sign(a);
  const move = (to, least) => replaced(parameters, i, (side * Math.log(9)) / Math.max(least, side * (to - c)));
  const range = side > 0 ? [c, Infinity] : [-Infinity, c];
  return { name: PARAMETERS[type][i], index: i, x, y: degree(type, x, parameters), range, move };
}

// A bell's steepness: where the bell is 0.9, left of its centre: z^2b = 1/9.
function steepness(parameters) {
  const [a, b, c] = parameters,
    width = Math.abs(a);
  if (b === 0) return null;
  const z = 9 ** (-1 / (2 * b)),
    x = c - width * z;
  // Between 0.05 and 0.999 of the half-width for b > 0, beyond it for b < 0.
  const inside = (to) => within((c - to) / width, b > 0 ? [1e-3, 0.99] : [1.01, 1e3]);
  const move = (to) => replaced(parameters, 1, -Math.log(9) / (2 * Math.log(inside(to))));
  return { name: "steepness b", index: 1, x, y: degree("gbellmf", x, parameters), range: [-Infinity, c], move };
}

/**
 * The handles of a curve, in the order of the parameters: name, parameter's index, place (x, y), range of x, and
 * move(to, least): the parameters after dragging it to `to`, in order; `least` is the smallest width.
 */
export function handles(type, parameters) {
  const own = (i) => vertex(type, parameters, i);
  const sides = (i, c, name) => [
    spread(type, parameters, i, c, -1, `${name}, left`),
    spread(type, parameters, i, c, 1, name),
  ];
  const list =
    {
      gaussmf: () => [...sides(0, 1, "width σ"), own(1)],
      gauss2mf: () => [
        spread(type, parameters, 0, 1, -1, "left width σ₁"),
        own(1),
        own(3),
        spread(type, parameters, 2, 3, 1, "right width σ₂"),
      ],
      gbellmf: () => [...sides(0, 2, "half-width a"), steepness(parameters), own(2)],
      sigmf: () => [slope(type, parameters, 0), own(1)],
      dsigmf: () => [slope(type, parameters, 0), own(1), slope(type, parameters, 2), own(3)],
      psigmf: () => [slope(type, parameters, 0), own(1), slope(type, parameters, 2), own(3)],
    }[type] ?? (() => (PLACES[type] ?? []).map(own));
  return list().filter((handle) => handle !== null && Number.isFinite(handle.x));
}
