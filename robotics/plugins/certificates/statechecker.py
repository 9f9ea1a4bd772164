"""Check a certificate whose states are the commands on their way, too, from its file alone.

Nothing here is the prover's (:mod:`robotics.plugins.certificates.statedecrease`). docs/explanation/certificate.md has
the theorem. Matrices and constants are computed in fractions, exactly: which form is left of V when all ζ with one
posture are considered (a Schur complement), and by how much the wheels may change √V. What the law asks for and what
the kinematics adds is enclosed over boxes of posture, speed and curvature in slope arithmetic
[Krawczyk & Neumaier 1985], with balls (a middle and a radius that holds all rounding): f(x) = f(c) + Σ s_j (x_j − c_j)
for some s_j of known balls. A rule's firing has slopes, too, by the derivative of its membership functions.
"""

# mypy: disable-error-code="no-untyped-def"
import itertools
from fractions import Fraction
from functools import partial

import numpy as np

from robotics.plugins.certificates.checker import RefutedError

STATES_FORMAT = "fuzzyfleet loop certificate of states 1"
FALL_SLACK = 1e-4  # σ: what is claimed of √V is a fall by ``fall`` and this
_BOXES, _PIECE, _LEAST, _SYMBOLS = 300_000, 4096, 1e-6, 5  # boxes at most; how many at once; parts of the whole
_UNIT, _TINY, _FUNCTION = 4e-16, 1e-300, 2e-15  # more than one rounding, relative and absolute; that of cos and sin
_DEGREE, _DERIVATIVE = 2e-12, 1e-9  # relative: more than a degree of membership is off, and than its derivative


# Balls, and functions over boxes as a ball in the middle and balls for slopes -------------------------------------


class MidRad:
    """Numbers within ``radius`` of ``middle`` (..., n)."""

    __array_ufunc__ = None  # a number of NumPy leaves its product to the ball

    def __init__(self, middle, radius=0.0):
        self.middle, self.radius = np.broadcast_arrays(np.asarray(middle, float), radius)

    def __add__(self, other):
        other = midrad(other)
        middle = self.middle + other.middle
        return MidRad(middle, (self.radius + other.radius) * (1 + _UNIT) + _UNIT * np.abs(middle) + _TINY)

    def __mul__(self, other):
        other = midrad(other)
        middle, far = self.middle * other.middle, np.abs(other.middle) + other.radius
        radius = np.abs(self.middle) * other.radius + self.radius * far
        return MidRad(middle, radius * (1 + 4 * _UNIT) + _UNIT * np.abs(middle) + _TINY)

    def __neg__(self):
        return MidRad(-self.middle, self.radius)

    def __sub__(self, other):
        return self + -midrad(other)

    @property
    def ends(self):
        """Numbers that are not above, and not below, any of it."""
        size = self.radius * (1 + _UNIT) + _UNIT * np.abs(self.middle) + _TINY
        return self.middle - size, self.middle + size

    @property
    def size(self):
        """|x| at most."""
        return (np.abs(self.middle) + self.radius) * (1 + 2 * _UNIT)


def midrad(x):
    """A number as a ball."""
    return x if isinstance(x, MidRad) else MidRad(x)


def between(low, high):
    """The ball of an interval."""
    middle = (low + high) / 2
    return MidRad(middle, (high - low) / 2 * (1 + _UNIT) + _UNIT * np.abs(middle) + _TINY)


class Slopes:
    """f = at + Σ slope_j ε_j over boxes, |ε| <= 1: balls (n,) and (5, n), each of which may be another at each ε."""

    def __init__(self, at, slope=None):
        self.at, self.slope = at, MidRad(np.zeros((_SYMBOLS, *at.middle.shape))) if slope is None else slope
        self.moves = (np.abs(self.slope.middle) + self.slope.radius).sum(axis=0) * (1 + 8 * _UNIT)  # f - at, at most
        self.range = MidRad(at.middle, (at.radius + self.moves) * (1 + 8 * _UNIT))  # f over the box

    def __add__(self, other):
        return Slopes(self.at + other.at, self.slope + other.slope) if isinstance(other, Slopes) else self + some(other)

    def __mul__(self, other):
        if not isinstance(other, Slopes):
            return Slopes(self.at * other, self.slope * other)
        return Slopes(self.at * other.at, self.range * other.slope + other.at * self.slope)

    def __neg__(self):
        return Slopes(-self.at, -self.slope)

    def __sub__(self, other):
        return self + -other

    def __rsub__(self, other):
        return other + -self

    __radd__, __rmul__ = __add__, __mul__

    def cos_sin(self):
        """The cosine and the sine."""
        at, over = (
            [MidRad(f(b.middle), b.radius + _FUNCTION) for f in (np.cos, np.sin)] for b in (self.at, self.range)
        )
        return Slopes(at[0], -over[1] * self.slope), Slopes(at[1], over[0] * self.slope)


def some(x):
    """A number, or any of a ball, as such a function."""
    return Slopes(midrad(x) + np.zeros(1))


def least(f, g):
    """The minimum: as steep as one of both, or as a mean of their slopes."""
    first, second = f.range.ends[1] <= g.range.ends[0], g.range.ends[1] <= f.range.ends[0]

    def either(x, y):  # the ends of both, or twice those of the one that is the less
        return [(np.where(second, b, a), np.where(first, a, b)) for a, b in zip(x.ends, y.ends, strict=True)]

    (low, high), slopes = either(f.at, g.at), either(f.slope, g.slope)
    return Slopes(between(np.minimum(*low), np.minimum(*high)), between(np.minimum(*slopes[0]), np.maximum(*slopes[1])))


# The rule base: a membership is a product of parts, each of which rises with z = rate (x − centre), most steeply at
# one place. The functions give the degree and its derivative, or None where that has no bound ---------------------


def step(z):
    """0 below 0, else 1."""
    return 1.0 * (z >= 0), None


def ramp(z):
    """0 up to 0, 1 from 1 on."""
    return np.clip(z, 0, 1), 1.0 * ((z > 0) & (z < 1))


def spline(z):
    """The same, smoothly."""
    z = np.clip(z, 0, 1)
    return np.where(z < 0.5, 2 * z**2, 1 - 2 * (1 - z) ** 2), 4 * np.minimum(z, 1 - z)


def gauss(z):
    """Half a Gaussian: 1 for z >= 0."""
    z = np.minimum(z, 0)
    value = np.exp(np.maximum(-(z**2) / 2, -700))
    return value, -z * value


def sigmoid(z):
    """1 / (1 + exp(−z))."""
    tail = np.exp(-np.minimum(np.abs(z), 700))
    return np.where(z < 0, tail, 1) / (1 + tail), tail / (1 + tail) ** 2


def bell(z, b):
    """Half a bell: 1 for z >= 0."""
    z = np.maximum(np.minimum(z, 0), -(1e300 ** (1 / (2 * b))))
    value = 1 / (1 + np.abs(z) ** (2 * b))
    return value, 2 * b * np.abs(z) ** (2 * b - 1) * value**2 if b > 0.6 else None


def power(p, k):
    """A hedged degree."""
    p = np.maximum(p, 0)
    return p**k, k * p ** (k - 1) if k >= 1 else None


_RISE, _BOTH = [(0, 1)], [(0, 1), (3, 2)]  # where a part is 0, and where it is 1
_RAMPS = {"linsmf": _RISE, "linzmf": [(1, 0)], "trimf": [(0, 1), (2, 1)], "trapmf": _BOTH}
_EDGES = _RAMPS | {"smf": _RISE, "zmf": [(1, 0)], "pimf": _BOTH}
_HALVES = {"gaussmf": (1, 0, 1, 0), "gauss2mf": (1, 0, 3, 2), "gbellmf": (2, 0, 2, 0)}  # centre and width of both


def parts(kind, n):
    """The parts of a membership function: centre, rate, where it is steepest, and its function of z."""
    if kind in _EDGES:
        function = ramp if kind in _RAMPS else spline
        ends = [(n[i], n[j], 2 * (j > i) - 1) for i, j in _EDGES[kind]]
        return [
            (a, 1 / (b - a), 0.5, function) if sign * (b - a) > 0 else ((a + b) / 2, sign, 0.0, step)
            for a, b, sign in ends
        ]
    if kind in _HALVES:
        function, steepest, (a, width, b, other) = gauss, -1.0, _HALVES[kind]
        if kind == "gbellmf":
            function, steepest = partial(bell, b=n[1]), -(max((2 * n[1] - 1) / (2 * n[1] + 1), 0) ** (0.5 / n[1]))
        return [(n[a], 1 / abs(n[width]), steepest, function), (n[b], -1 / abs(n[other]), steepest, function)]
    return [(c, a, 0.0, sigmoid) for a, c in zip(n[::2], n[1::2], strict=True)]


def monotone(z, steepest, function):
    """A function that rises with z, by its derivative."""
    first, last = z.range.ends
    ends = [function(e + s * _DERIVATIVE * (1 + np.abs(e)))[1] for s, e in ((-1, first), (1, last))]
    low, high = z.range.ends if ends[0] is None else z.at.ends
    at = between(function(low)[0] * (1 - _DEGREE) - _TINY, function(high)[0] * (1 + _DEGREE) + _TINY)
    if ends[0] is None:
        return Slopes(at)
    steep = np.where((first < steepest) & (steepest < last), function(steepest)[1], np.maximum(*ends))
    return Slopes(at, between(np.minimum(*ends) * (1 - _DERIVATIVE), steep * (1 + _DERIVATIVE)) * z.slope)


def degree(x, kind, n):
    """The degree of a membership function."""
    first, *other = [monotone((x - some(centre)) * rate, *how) for centre, rate, *how in parts(kind, n)]
    if kind == "dsigmf":
        return -least(other[0] - first, some(0.0))
    return first * other[0] if other else first


def fires(rule, rules, degrees):
    """How much a rule fires."""
    method, w = rules["or" if rule["or"] else "and"], None
    for i, t, hedge, negated in rule["clauses"]:
        p = degrees[i][t] if hedge == 1 else monotone(degrees[i][t], np.inf, partial(power, k=hedge))
        p = 1 - p if negated != rule["or"] else p  # "or" by De Morgan
        w = p if w is None else least(w, p) if method in ("max", "min") else w * p
    w = some(1.0) if w is None else w
    return (1 - w if rule["or"] else w) * rule["weight"]


def infer(rules, x):
    """The outputs of the rule base over functions ``x`` of its inputs, and where it may have none."""
    if rules["clip"]:
        ends = [(some(i["low"]), some(i["high"])) for i in rules["inputs"]]
        x = [-least(-least(v, high), -low) for v, (low, high) in zip(x, ends, strict=True)]
    degrees = [[degree(v, *t) for t in i["terms"]] for v, i in zip(x, rules["inputs"], strict=True)]
    weights = [fires(rule, rules, degrees) for rule in rules["rules"]]
    found, hole = {}, False
    for o, name in enumerate(rules["outputs"]):
        taking = [(w, r["then"][o]) for w, r in zip(weights, rules["rules"], strict=True) if r["then"][o] is not None]
        said = [sum((v * n for v, n in zip(x, slopes, strict=True)), some(c)) for _, (c, *slopes) in taking]
        found[name], bad = mean([w for w, _ in taking], said)
        hole = hole | bad
    return found, hole


def mean(weights, y):
    """The weighted mean Σ w y / Σ w, and where Σ w may be 0.

    With u that at c, its slope is [Σ w (slope of y) + Σ (slope of w) (y(c) − u)] / Σ w, with Σ w at x.
    """
    total = sum(weights, some(0.0))
    bad = ~(total.range.ends[0] > 1e-280)
    near_part, part = (between(*(1 / np.where(bad, 1, e) for e in b.ends[::-1])) for b in (total.at, total.range))
    share = [w.at.middle * near_part.middle for w in weights]
    near = sum(s * v.at.middle for s, v in zip(share, y, strict=True))
    lean = sum(s * v.slope.middle for s, v in zip(share, y, strict=True))
    at = sum((w.at * (v.at - near) for w, v in zip(weights, y, strict=True)), midrad(0.0)) * near_part + near
    bent = [w.range * (v.slope - lean) + w.slope * (v.at - at) for w, v in zip(weights, y, strict=True)]
    return Slopes(at, sum(bent, midrad(0.0)) * part + lean), bad


# The closed loop, in fractions ------------------------------------------------------------------------------------


exact = np.vectorize(Fraction, otypes=[object])  # arrays of fractions


def eliminated(matrix, places, sign):
    """The Schur complement of a symmetric matrix, whose block ``places`` is definite of that sign.

    It is the greatest (-1) or the least (1) of the form over what is eliminated.
    """
    for k in places:
        if not sign * matrix[k, k] > 0:
            raise RefutedError("V is not positive" if sign > 0 else "V does not fall behind the posture")
        matrix = matrix - np.outer(matrix[:, k], matrix[k]) / matrix[k, k]
    keep = [i for i in range(len(matrix)) if i not in places]
    return matrix[np.ix_(keep, keep)]


def root(square):
    """A number that is at least the root of a fraction."""
    return Fraction(float(np.sqrt(float(square))) * (1 + 1e-14) + 1e-150)


def asked(d, boxes, noise=None):
    """X, Y, ψ, v_r and curvature over boxes (2, 5, n), what the law asks for, and where that cannot be said.

    With ``noise`` (5, 1) the symbols are the noise of each, about any point of a box, which is a ball then.
    """
    k, middle = d["loop"], boxes.mean(axis=0)
    half = np.maximum(boxes[1] - middle, middle - boxes[0]) * (1 + _UNIT)
    about, along = (0 * half, half) if noise is None else (half, noise + 0 * half)
    parts = zip(middle, about, along, np.eye(_SYMBOLS), strict=True)
    x, y, psi, v_r, bend = z = [Slopes(MidRad(m, r), MidRad(h * e[:, None])) for m, r, h, e in parts]
    (cos, sin), w_r = psi.cos_sin(), v_r * bend
    x_err, y_err = cos * x - sin * y, sin * x + cos * y
    if d["rules"] is None:
        out, hole = {"dv": x_err * k["kx"], "bend": y_err * k["ky"] + sin * k["kpsi"]}, False
    else:
        known = {"x_err": x_err, "y_err": y_err, "heading_err": psi, "target_v": v_r, "target_w": w_r}
        out, hole = infer(d["rules"], [known[i["quantity"]] for i in d["rules"]["inputs"]])
    a = out.get("dv", some(0.0)) - v_r * (1 - cos)
    v = v_r + a
    speed = -least(-v_r, -least(-least(v, -v), some(k["catch_up"])))  # max(v_r, min(|v|, catch_up))
    return z, a, out.get("dw", some(0.0)) + speed * out.get("bend", some(0.0)), hole | (psi.range.size > 3.1)


class SpeedCell:
    """The loop about one range of the reference's speed, ζ(k+1) = A ζ + G r + d: what is known of it."""

    def __init__(self, numbers, f):
        k = {n: Fraction(v) for n, v in numbers.items() if not isinstance(v, list)}
        groups, T, s, P, (low, high) = int(k["groups"]), k["period"], k["fresh"], exact(f["P"]), exact(f["speed"])
        n, fall, centre, fastest = len(P), Fraction(f["fall"]), (low + high) / 2, high * k["curvature"]
        unit, told, behind = exact(np.eye(n + 4, dtype=int)), [], range(3, n)  # unit: each of the states, and of r
        for i, first in enumerate((3, 2 + groups)):
            newest = (1 - s) * unit[first] + s * unit[n + i]
            told.append(np.vstack([newest, unit[first : first + groups - 1]]))
        mean_a, mean_b = (exact(numbers[w][:groups]) @ e for w, e in zip(("v_weight", "w_weight"), told, strict=True))
        posture = unit[:3] - T * np.array([mean_a, centre * T / 2 * mean_b, mean_b])
        posture[:2] += unit[n + 2 :]
        step = np.vstack([posture, told[0][:-1], told[1][:-1]])
        eliminated(P, range(n), 1)
        reach = np.array([root(1 / eliminated(P, [*range(i), *range(i + 1, n)], 1)[0, 0]) for i in range(n)])
        self.whole, reach = reach[:3].astype(float), reach[[3, 2 + groups]]
        fast, turning = high + reach[0], fastest + reach[1]
        if fast >= k["v_max"] or turning >= k["w_max"] or fast + k["half_axle"] * turning >= k["wheel_limit"]:
            raise RefutedError("a command may meet a limit of the wheels")
        turns = int(low - reach[0] - k["half_axle"] * turning <= k["slow"])
        # a and b at any time of a period: in the commands' hull, in proportion to √V, and what is beyond it
        hulls = (1 + 2 * k["overshoot"]) * reach
        more, off = (np.array([k[f"{i}_{w}"] + turns * k[f"{i}_reversal"] for i in "vw"]) for w in ("ripple", "error"))
        A, B = hulls + more
        columns = np.array([[T, 0, 0], [0, centre * T * T / 2, T], [1, 0, 0], [0, 1, 0]])

        def norm(a, b, means):
            """‖d‖ at most, of a and b at any time and of what the wheels' means differ by; it is convex in them."""
            turned = fastest * (T**2 / 2 * a + high * T**3 / 6 * b)
            x = (high + A) * B * T**3 / 6 * b + turned
            y = (high + high - low) * T**2 / 4 * b + high * B**2 * T**4 / 24 * b + B * T**2 / 2 * a + turned
            ends = [np.array(e) @ columns for e in itertools.product(*((-e, e) for e in (*means, x, y)))]
            return root(max(d @ P[:3, :3] @ d for d in ends))

        # Noise in what the law asks for; the heading turns its part in the mean of a
        noise, change = exact(f.get("noise", [0, 0])), step.T @ P @ step
        turned = [T * mean_a[n] * Fraction(self.whole[2]) * noise[0]] * 2
        ends = [np.array(e) for e in itertools.product(*((-e, e) for e in (*noise, *turned)))]
        by_noise, self.noise = root(max(e @ change[n:, n:] @ e for e in ends)), noise.astype(float)
        self.past, self.added = norm(*hulls, 2 * k["share"] * reach), norm(*more, off) + by_noise
        if not fall + Fraction(FALL_SLACK) + self.past + self.added < 1:
            by = f"√V by {float(self.past):.2g} of what it was and {float(self.added):.2g}"
            raise RefutedError(f"what the wheels may differ, or noise, keeps V from falling: {by}")
        change[:n, :n] -= fall**2 * P
        self.form = eliminated(change, behind, -1).astype(float)
        # The mean of a, with r's u_a apart, over all ζ with a posture and V <= 1: ahead'δ within aside √(1 − δ'Nδ)
        form = eliminated(np.block([[P, mean_a[:n, None]], [mean_a[None, :n], exact([[0]])]]), behind, 1)
        self.near, self.ahead = form[:3, :3].astype(float), form[3, :3].astype(float)
        self.aside = float(root(-form[3, 3]))
        self.mean_error, self.fresh, self.period = float(2 * k["share"] * reach[0] + off[0]), float(mean_a[n]), float(T)
        self.any_a, self.any_b = float(A) * (1 + _UNIT), float(B) * (1 + _UNIT)
        self.slack = 2 * FALL_SLACK * f["fall"] * f["inner"] ** 2 * (1 - 1e-12)

    def signals(self, d, boxes):
        """δ, what the law asks for and what the kinematics adds over boxes (2, 5, n); and where that cannot be said."""
        T, B, ((x, y, psi, v_r, bend), a, b, bad) = self.period, self.any_b, asked(d, boxes)
        (cos, sin), w_r = psi.cos_sin(), v_r * bend
        level = -greatest(-self.near, [x, y, psi])[0]
        aside = (self.aside * np.sqrt(np.maximum(1 - level, 0)) + self.mean_error) * (1 + 1e-12)
        mean_a = sum((z * g for z, g in zip((x, y, psi), self.ahead, strict=True)), a * self.fresh) + MidRad(0.0, aside)
        fast, turn, far, w = v_r.range.size, w_r * T, psi.range.size, w_r.range.size
        (turned, rotated), whole = turn.cos_sin(), (v_r + mean_a) * T
        # What is in proportion to ψ of the way that is driven while the heading, or the reference's, turns
        more_x = T * T / 2 * ((fast + self.any_a) * B + w * fast) * (1 + 1e-12)
        more_y = (T**3 * B * B / 6 * fast + fast * far * T * T / 4 * B + T * T / 2 * w * fast) * (1 + 1e-12)
        n_x = whole * (1 - cos) + (turned - 1.0) * x + rotated * y + psi * MidRad(0.0, more_x)
        n_y = whole * sin - rotated * x + (turned - 1.0) * y + psi * MidRad(0.0, more_y)
        return [x, y, psi, a, b, n_x, n_y], level, bad

    def moved(self, d, boxes, noise):
        """Where noise (5, 1) may change what the law asks for by more than is said."""
        _, a, b, bad = asked(d, boxes, noise)
        return bad | ~((a.moves <= self.noise[0]) & (b.moves <= self.noise[1]))

    def grows(self, d, boxes):
        """Over which boxes V may be 1 at most and not fall, and what each side adds to what is not known."""
        noise = np.array([[d["loop"][f"{n}_noise"]] for n in ("position", "position", "heading")] + [[0], [0]])
        signals, level, bad = self.signals(d, boxes)
        bad, (value, sides) = bad | (noise.any() and self.moved(d, boxes, noise)), greatest(self.form, signals)
        return ~(level > 1) & (bad | ~(value <= self.slack)), sides


def greatest(matrix, z):
    """z'Mz of functions z at most, of a matrix within _UNIT of M; and how much of it is of each symbol.

    A concave part of a symbol counts: 2 g ε + B ε² is at most −g²/B where that is within |ε| <= 1.
    """
    middle, radius = (np.array([getattr(f.at, e) for f in z]) for e in ("middle", "radius"))
    slope, unsure = (np.array([getattr(f.slope, e) for f in z]) for e in ("middle", "radius"))
    about, turned = np.einsum("ij,jn->in", matrix, middle), np.einsum("ij,jsn->isn", matrix, slope)
    first, second = np.einsum("in,isn->sn", about, slope), np.einsum("isn,itn->stn", slope, turned)
    square = np.einsum("ssn->sn", second)
    linear, concave = np.abs(first), np.maximum(-square, np.abs(first)) + _TINY
    along = np.where(-square > linear, linear**2 / concave, 2 * linear + square)
    across = np.abs(second).sum(axis=1) - np.abs(square)
    steep = 2 * (np.abs(about) + np.abs(turned).sum(axis=1))
    rest = radius + unsure.sum(axis=1)
    value = (middle * about).sum(axis=0) + (along + across).sum(axis=0)
    value += (rest * (steep + np.einsum("ij,jn->in", np.abs(matrix), rest))).sum(axis=0)
    size = np.abs(middle) + np.abs(slope).sum(axis=1) + rest
    value += 1e-13 * np.einsum("in,ij,jn->n", size, np.abs(matrix), size)
    return value, across + np.einsum("in,isn->sn", steep, unsure)


# The certificate ----------------------------------------------------------------------------------------------------


def check_states(d):
    """Raise RefutedError unless the certificate, whose loop's numbers are in range, is true; how many boxes it took."""
    k, speeds = d["loop"], [float(end) for f in d["V"] for end in f["speed"]]
    if not (groups := int(k["groups"])) == k["groups"] >= 2 or k["last"][:groups] != [*range(groups)]:
        raise RefutedError("ages of commands are not those of the states")
    if k["v_rate"] or k["w_rate"]:
        raise RefutedError("references that change are not covered")
    for f in d["V"]:
        P, (low, high) = np.array(f["P"], float), f["speed"]
        if P.shape != (2 * groups + 1,) * 2 or (P != P.T).any() or not (0.5 < f["fall"] < 1 and 0 < f["inner"] < 1):
            raise RefutedError("V is out of its range")
        if not 0 < low <= high or speeds[1:-1:2] != speeds[2::2]:
            raise RefutedError("the ranges of speed do not follow one another")
    if (speeds[0], speeds[-1]) != (k["speed_low"], k["speed_high"]):
        raise RefutedError("the speeds are not all covered")
    return sum(_prove(d, SpeedCell(k, f), *f["speed"]) for f in d["V"])


def _prove(d, cell, low, high):
    """Branch and bound over posture, speed and curvature: how many boxes it takes."""
    bend, count = d["loop"]["curvature"], 0
    boxes = np.array([[*-cell.whole, low, -bend], [*cell.whole, high, bend]])[..., None]
    whole = (boxes[1] - boxes[0]) + _TINY
    while boxes.size:
        boxes, rest = boxes[..., -_PIECE:], boxes[..., :-_PIECE]
        count += boxes.shape[2]
        left, sides = cell.grows(d, boxes)
        boxes, sides = boxes[..., left], np.where(boxes[1] > boxes[0], sides, -1.0)[:, left]
        axis, n = sides.argmax(axis=0), np.arange(boxes.shape[2])
        middles = np.repeat(boxes.mean(axis=0)[None, :, :: max(1, len(n) // 50)], 2, axis=0)
        if middles.size:
            wrong = middles[0][:, cell.grows(d, middles)[0]]
            if count > _BOXES or wrong.size or ((boxes[1] - boxes[0]) / whole)[axis, n].min() < _LEAST:
                place = (wrong if wrong.size else boxes.mean(axis=0))[:, 0].round(4).tolist()
                raise RefutedError(f"V is not seen to fall, or noise to be small, at X, Y, ψ, v_r, curvature = {place}")
        halves = np.array([boxes, boxes])
        halves[0, 1, axis, n] = halves[1, 0, axis, n] = boxes[:, axis, n].mean(axis=0)
        boxes = np.concatenate([rest, *halves], axis=2)
    return count
