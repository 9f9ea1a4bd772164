"""Check a certificate of a closed loop again, from its file alone: without the search and without the prover's code.

Intervals in NumPy, many at once, every operation rounded outwards by one unit in the last place (the mathematics
library's functions by eight). docs/explanation/certificate.md has the theorem, whose condition is checked here over
boxes of its own: for all w in [inner, outer], all errors with V <= ν w and V <= w at the N samples before, V <= μ ν w
after a period, for every reference, noise and behaviour of the wheels that the file allows; and ν <= μ^N.
"""

# mypy: disable-error-code="no-untyped-def"
import itertools
import json
import math
from pathlib import Path

import numpy as np

FORMAT = "fuzzyfleet loop certificate 2"
LIBRARY, BOXES, PIECE = 2e-15, 3_000_000, 4096  # relative error of cos, exp ...; the most boxes; how many at once
_NEAR, _STEP, _CELL, _LEAST, _PARTS = 0.75, 0.9, 1.12, 0.004, (6, 10, 10)
QUANTITIES = ("x_err", "y_err", "heading_err", "target_v", "target_w")


class RefutedError(ValueError):
    """A certificate that does not hold, or cannot be read. The message says what fails."""


class Boxes:
    """Intervals (n,)."""

    __array_ufunc__ = None  # a number of NumPy leaves its product with a Boxes to the Boxes

    def __init__(self, low, high):
        self.low, self.high = np.asarray(low, float), np.asarray(high, float)

    def __add__(self, other):
        other = of(other)
        return Boxes(np.nextafter(self.low + other.low, -np.inf), np.nextafter(self.high + other.high, np.inf))

    def __neg__(self):
        return Boxes(-self.high, -self.low)

    def __sub__(self, other):
        return self + -of(other)

    def __rsub__(self, other):
        return of(other) + -self

    def __mul__(self, other):
        other = of(other)
        ends = np.stack(np.broadcast_arrays(*(a * b for a in self.ends for b in other.ends)))
        return Boxes(np.nextafter(ends.min(0), -np.inf), np.nextafter(ends.max(0), np.inf))

    __radd__, __rmul__ = __add__, __mul__

    def __getitem__(self, place):
        return Boxes(self.low[place], self.high[place])

    @property
    def ends(self):
        """Both."""
        return self.low, self.high

    @property
    def size(self):
        """|x| at most."""
        return np.maximum(np.abs(self.low), np.abs(self.high))

    def square(self):
        """x²."""
        least = np.where((self.low <= 0) & (self.high >= 0), 0, np.minimum(np.abs(self.low), np.abs(self.high)))
        return Boxes(np.maximum(np.nextafter(least**2, -1), 0), np.nextafter(self.size**2, np.inf))

    def cos(self):
        """The cosine, of angles within ±4π."""
        low, high = np.minimum(np.cos(self.low), np.cos(self.high)), np.maximum(np.cos(self.low), np.cos(self.high))
        for n in range(-4, 5):
            holds = (self.low <= n * math.pi + 1e-14) & (n * math.pi - 1e-14 <= self.high)
            low, high = np.where(holds & (n % 2 == 1), -1, low), np.where(holds & (n % 2 == 0), 1, high)
        return Boxes(np.maximum(low - LIBRARY, -1), np.minimum(high + LIBRARY, 1))

    def sin(self):
        """The sine."""
        return (self - Boxes(np.nextafter(math.pi / 2, 0), np.nextafter(math.pi / 2, 2))).cos()

    def hull(self, other):
        """What holds both."""
        return Boxes(np.minimum(self.low, other.low), np.maximum(self.high, other.high))

    def within(self, other):
        """What both have in common; a point of the other where that is nothing, which no trajectory meets."""
        low, high = np.maximum(self.low, other.low), np.minimum(self.high, other.high)
        point = np.minimum(low, other.high)
        return Boxes(np.where(low <= high, low, point), np.where(low <= high, high, point))


def of(x):
    """A number as an interval."""
    return x if isinstance(x, Boxes) else Boxes(x, x)


def wide(by):
    """−by to by."""
    by = np.nextafter(np.abs(by), np.inf)
    return Boxes(-by, by)


# The rule base: thirteen membership functions, by their values at the ends and at what lies between ----------------


def ramp(x, a, b):
    """0 up to a, 1 from b on."""
    return np.clip((x - a) / (b - a), 0, 1) if b > a else (x >= b) * 1.0


def spline(x, a, b):
    """The same, smoothly."""
    z = ramp(x, a, b) if b > a else (x >= (a + b) / 2) * 1.0
    return np.where(z < 0.5, 2 * z * z, 1 - 2 * (1 - z) ** 2)


def sigmoid(x, a, c):
    """A rise or a fall about c."""
    return 1 / (1 + np.exp(np.clip(-a * (x - c), -700, 700)))


def two_sided(left, right, a, b, c, d):
    """Two halves of bells, each at a place of its own."""
    p, q = np.minimum(left - b, 0) / a, np.maximum(right - d, 0) / c
    return np.exp(np.maximum(-0.5 * p * p, -700)) * np.exp(np.maximum(-0.5 * q * q, -700))


RISING = {"linsmf": ramp, "smf": spline, "sigmf": sigmoid}
FALLING = {"linzmf": lambda x, a, b: 1 - ramp(x, a, b), "zmf": lambda x, a, b: spline(-x, -b, -a)}
BUMPS = {  # the function, and the places between which it is greatest
    "trimf": (lambda x, a, b, c: np.minimum(ramp(x, a, b), ramp(-x, -c, -b)), lambda a, b, c: (b, b)),
    "trapmf": (lambda x, a, b, c, d: np.minimum(ramp(x, a, b), ramp(-x, -d, -c)), lambda a, b, c, d: (b, c)),
    "gaussmf": (lambda x, a, b: np.exp(np.maximum(-0.5 * ((x - b) / a) ** 2, -700)), lambda a, b: (b, b)),
    "gbellmf": (lambda x, a, b, c: 1 / (1 + np.minimum(np.abs((x - c) / a) ** (2 * b), 1e300)), lambda a, b, c: (c, c)),
}


def degree(x, kind, n):
    """The degrees of a term over intervals."""
    if kind in RISING or kind in FALLING:
        ends = [{**RISING, **FALLING}[kind](e, *n) for e in x.ends]
        low, high = np.minimum(*ends), np.maximum(*ends)
    elif kind in BUMPS:
        function, top = BUMPS[kind]
        if kind == "gbellmf" and not n[1] > 0:
            raise RefutedError("gbellmf: its power must be above 0")
        first, last = top(*n)
        ends = [function(e, *n) for e in x.ends]
        low, high = np.minimum(*ends), np.where((x.low <= last) & (x.high >= first), 1.0, np.maximum(*ends))
    elif kind == "gauss2mf":
        a, b, c, d = n
        # Each side at the end that is worst for it, and at the one that is best
        low = two_sided(x.low, x.high, abs(a), b, abs(c), d)
        high = two_sided(x.high, x.low, abs(a), b, abs(c), d)
    elif kind in ("pimf", "dsigmf", "psigmf"):
        one, two = (spline, lambda x, a, b: spline(-x, -b, -a)) if kind == "pimf" else (sigmoid, sigmoid)
        p, q = sorted_ends(one, x, n[:2]), sorted_ends(two, x, n[2:])
        low, high = (p[0] - q[1], p[1] - q[0]) if kind == "dsigmf" else (p[0] * q[0], p[1] * q[1])
    else:
        raise RefutedError(f"no membership function {kind!r} is known")
    if kind in ("gaussmf", "gauss2mf", "gbellmf", "sigmf"):  # relative accuracy, which tails need
        return Boxes(np.clip(low * (1 - 2e-12), 0, 1), np.clip(high * (1 + 2e-12) + 1e-300, 0, 1))
    return Boxes(
        np.where(low < 1, np.clip(low - 2e-12, 0, 1), 1.0), np.where(high > 0, np.clip(high + 2e-12, 0, 1), 0.0)
    )


def sorted_ends(function, x, n):
    """The least and the greatest value of a monotone function."""
    ends = [function(e, *n) for e in x.ends]
    return np.minimum(*ends), np.maximum(*ends)


def mean(low, high, y, sign):
    """A bound of the weighted mean of y (rules, n) from above (1) or below (-1) [Karnik & Mendel 2001]."""
    y = np.where(high > 0, sign * y, -np.inf)
    top = y.max(0)
    y = np.where(high > 0, y, top)
    bound = (high * y).sum(0) / np.maximum(high.sum(0), 1e-300)
    for _ in range(10):
        w = np.where(y > bound, high, low)
        bound = np.maximum(bound, (w * y).sum(0) / np.maximum(w.sum(0), 1e-300))
    bound = bound + 1e-12 * (top - y.min(0)) + 1e-14 * np.abs(bound)
    w = np.where(y > bound, high, low)
    holds = (w * (y - bound)).sum(0) + 1e-14 * (w * np.abs(y - bound)).sum(0) <= 0
    return sign * np.where(holds, np.minimum(bound, top), top)


def infer(rules, x):
    """The outputs of the rule base over intervals ``x`` of its inputs, and where it may have none."""
    if rules["clip"]:
        x = [Boxes(*(np.clip(e, i["low"], i["high"]) for e in v.ends)) for v, i in zip(x, rules["inputs"], strict=True)]
    degrees = [[degree(v, *t) for t in i["terms"]] for v, i in zip(x, rules["inputs"], strict=True)]
    low, high = [], []
    for rule in rules["rules"]:
        parts = []
        for i, t, power, negated in rule["clauses"]:
            w = degrees[i][t]
            w = (
                Boxes(np.clip(w.low**power - LIBRARY, 0, 1), np.clip(w.high**power * (1 + LIBRARY), 0, 1))
                if power != 1
                else w
            )
            parts.append(1 - w if negated else w)
        if rules["or" if rule["or"] else "and"] in ("max", "min"):
            pick = np.maximum if rule["or"] else np.minimum
            w = Boxes(pick.reduce([p.low for p in parts]), pick.reduce([p.high for p in parts]))
        else:
            w = of(1.0)
            for p in parts:
                w = w * (1 - p if rule["or"] else p)
            w = 1 - w if rule["or"] else w
        w = w * rule["weight"]
        low.append(np.broadcast_to(np.clip(w.low, 0, None), x[0].low.shape))
        high.append(np.broadcast_to(np.where(w.high > 0, np.maximum(w.high, 1e-290), 0), x[0].low.shape))
    found, hole = {}, np.zeros_like(x[0].low, bool)
    for o, name in enumerate(rules["outputs"]):
        taking = [r for r, rule in enumerate(rules["rules"]) if rule["then"][o] is not None]
        weak, strong = np.array([low[r] for r in taking]), np.array([high[r] for r in taking])
        hole |= ~(weak.sum(0) > 1e-280)
        numbers = np.array([rules["rules"][r]["then"][o] for r in taking], float)  # a constant, and slopes
        base = numbers[np.argmax(weak + strong, axis=0), 1:]  # (n, inputs): what the rules' slopes are taken beside
        ys, common = [], of(0.0)
        for row in numbers:
            y = of(row[0])
            for i, v in enumerate(x):
                slope = row[1 + i] - base[:, i]
                y = y + Boxes(np.nextafter(slope, -np.inf), np.nextafter(slope, np.inf)) * v
            ys.append(y)
        for i, v in enumerate(x):
            common = common + base[:, i] * v
        tops = np.array([np.broadcast_to(y.high, strong[0].shape) for y in ys])
        bottoms = np.array([np.broadcast_to(y.low, strong[0].shape) for y in ys])
        found[name] = Boxes(mean(weak, strong, bottoms, -1), mean(weak, strong, tops, 1)) + common
    return found, hole


# The closed loop -----------------------------------------------------------------------------------------------


def ask(d, v_r, w_r, z):
    """What the law asks for beside the reference's velocity, and where it cannot be said, over errors ``z``."""
    k = d["loop"]
    x, y, psi = z[0] + wide(k["position_noise"]), z[1] + wide(k["position_noise"]), z[2] + wide(k["heading_noise"])
    bad, dv, dw = psi.size > 3.14, wide(k["v_rate"] * k["span"]), wide(k["w_rate"] * k["span"])
    cos, sin = psi.cos(), psi.sin()
    x_err, y_err = cos * x - sin * y, sin * x + cos * y
    target = (v_r + dv).within(Boxes(k["speed_low"], k["speed_high"]))
    if d["rules"] is None:
        out = {"dv": k["kx"] * x_err, "bend": k["ky"] * y_err + k["kpsi"] * sin}
    else:
        known = dict(zip(QUANTITIES, (x_err, y_err, psi, target, w_r + dw), strict=True))
        out, hole = infer(d["rules"], [known[i["quantity"]] for i in d["rules"]["inputs"]])
        bad = bad | hole
    a = out.get("dv", of(0.0)) - target * (1 - cos)
    v = target + a
    least, catch = np.maximum(np.maximum(v.low, -v.high), 0), k["catch_up"]
    speed = Boxes(np.maximum(target.low, np.minimum(least, catch)), np.maximum(target.high, np.minimum(v.size, catch)))
    b = out.get("dw", of(0.0)) + speed * out.get("bend", of(0.0))
    a, b = a + dv, b + dw
    fast, turning = (v_r + a).size, (w_r + b).size
    bad = bad | (fast > k["v_max"]) | (turning > k["w_max"])
    return a, b, bad | ~(fast + k["half_axle"] * turning < k["wheel_limit"] * (1 - 1e-12))


def turns(k, v_r, w_r, a, b):
    """1 where a wheel may turn round."""
    v, rim, slow = v_r + a, k["half_axle"] * (w_r + b), k["slow"]
    return 1.0 * np.any([(e.low <= slow) & (e.high >= -slow) for e in (v + rim, v - rim)], axis=0)


def driven(k, kind, share, turning, a, b, width):
    """What the wheels do, of what is asked for: over a period ("error") or at any time of it ("ripple")."""
    by = [share * w + k[f"{n}_{kind}"] + turning * k[f"{n}_reversal"] for n, w in zip("vw", width, strict=True)]
    return a + wide(by[0] * (1 + 1e-14)), b + wide(by[1] * (1 + 1e-14))


def references(k, v_r, bend):
    """v_r and ω_r at any time that counts, of what they are now."""
    return v_r + wide(k["v_rate"] * k["span"]), v_r * bend + wide(k["w_rate"] * k["span"])


def rates(v_r, w_r, a, x, y, psi):
    """X' and Y'."""
    return v_r * (1 - psi.cos()) - a * psi.cos() + w_r * y, (v_r + a) * psi.sin() - w_r * x


def level(f, z):
    """V."""
    return f["a"] * z[0].square() + f["b"] * z[1].square() + (z[2] + f["m"] * z[1]).square()


def reach(f, c):
    """The box of V <= c."""
    sizes = np.sqrt(c / f["a"]), np.sqrt(c / f["b"]), np.sqrt(c * (1 + f["m"] ** 2 / f["b"]))
    return [wide(s * (1 + 1e-14)) for s in sizes]


def earlier(d, v_r, w_r, inst, mean_b, z, c, periods):
    """Where the errors were at the samples of the last periods, with V <= c there."""
    t, f, most = d["loop"]["period"], d["V"], reach(d["V"], c)
    span, a = Boxes(-t * periods * (1 + 1e-14), 0.0), inst[0]
    psi = z[2] + span * -inst[1]
    step = t * (2 * v_r.high + a.size)
    step = (step + t * w_r.size * (most[0].high + most[1].high + step)) * (1 + 1e-13)
    x, y = most[0] + wide(step), most[1] + wide(step)
    for _ in range(2):
        dx, dy = rates(v_r, w_r, a, x, y, psi)
        x, y = (z[0] + span * dx).within(x), (z[1] + span * dy).within(y)
    x, y, psi = x.within(most[0]), y.within(most[1]), (z[2] + span * -mean_b).within(most[2])
    return [x, y, psi.within(-f["m"] * y + wide(np.sqrt(c) * (1 + 1e-14)))]


def moved(d, v_r, w_r, a, b, inst, z):
    """By how much the errors change in a period, but for T ω_r (Y, −X)."""
    t, psi = d["loop"]["period"], z[2]
    heading, speed = psi + Boxes(0.0, t) * -inst[1], v_r + inst[0]

    def bent(factor):
        middle = (factor.low + factor.high) / 2
        radius = (factor.high - factor.low) / 2 * (1 + 1e-15) + 1e-300
        return middle * (b + wide((inst[1].high - inst[1].low) / 4)) + wide(radius * inst[1].size)

    x = v_r * (1 - psi.cos()) - a * psi.cos() - t / 2 * bent(speed * heading.sin())
    y = (v_r + a) * psi.sin() - t / 2 * bent(speed * heading.cos())
    far = wide((z[0].size + z[1].size + t * (2 * v_r.high + inst[0].size)) * (1 + 1e-13))
    dx, dy = rates(v_r, w_r, inst[0], far, far, heading)
    return [t * (x + t / 2 * (w_r * dy)), t * (y - t / 2 * (w_r * dx)), -t * b]


def turned(d, w_r, z, moves):
    """The change with the rotation by ω_r."""
    t = d["loop"]["period"]
    return [moves[0] + t * (w_r * z[1]), moves[1] - t * (w_r * z[0]), moves[2]]


def change(d, v_r, w_r, z, c, table):
    """By how much V may grow in a period, with V <= c before, and where that cannot be said."""
    k, f, every = d["loop"], d["V"], (Boxes(table[:, 0], table[:, 1]), Boxes(table[:, 2], table[:, 3]))
    width, steps, bad = [e.high - e.low for e in every], int(k["memory"]), np.zeros(len(c), bool)
    hulls, turning = [every] * (steps + 2), turns(k, v_r, w_r, *every)
    ages = [int(n) for n in k["last"][: int(k["groups"])]]

    def average(n):
        told = [hulls[min(n + age, steps + 1)] for age in ages]
        return [sum((w * h[i] for w, h in zip(k[f"{axis}_weight"], told, strict=False)), of(0.0))
                for i, axis in enumerate("vw")]  # fmt: skip

    def at_any_time(n, turning):
        hull = hulls[min(n, steps + 1)]
        return driven(k, "ripple", k["overshoot"], turning, *hull, [e.high - e.low for e in hull])

    for n in range(steps, -1, -1):
        past, hulls[n] = z, hulls[n + 1]
        if n:
            mean_b = driven(k, "error", k["share"], turning, *average(n), width)[1]
            past = earlier(d, v_r, w_r, at_any_time(n + int(k["prompt"]), turning), mean_b, z, c, n)
        *asked, wrong = ask(d, v_r, w_r, past)
        hulls[n], bad = tuple(a.within(h) for a, h in zip(asked, hulls[n + 1], strict=True)), bad | wrong
    turning = turns(k, v_r, w_r, *hulls[min(int(k["turning"]), steps + 1)])
    a, b = driven(k, "error", k["share"], turning, *average(0), width)
    moves = moved(d, v_r, w_r, a, b, at_any_time(int(k["prompt"]), turning), z)
    s, ds = z[2] + f["m"] * z[1], moves[2] + f["m"] * moves[1]
    first = f["a"] * (z[0] * moves[0]) + f["b"] * (z[1] * moves[1]) + s * ds
    skew = Boxes(np.nextafter(f["a"] - f["b"], -1e9), np.nextafter(f["a"] - f["b"], 1e9)) * z[1] - f["m"] * s
    first = first + k["period"] * (w_r * z[0] * skew)
    return (2 * first + level(f, turned(d, w_r, z, moves))).high, bad


def tabulate(d, v_r, w_r, levels):
    """What the law asks for all over V <= c (levels, 4), and by how much √V then grows in a period (levels,)."""
    f, table, growth = d["V"], [], []
    for c in levels:
        most = reach(f, np.array([c]))
        edges = [np.linspace(m.low[0], m.high[0], n + 1) for m, n in zip(most, _PARTS, strict=True)]
        lows, highs = (np.stack(np.meshgrid(*(e[s] for e in edges), indexing="ij")).reshape(3, -1)
                       for s in (slice(None, -1), slice(1, None)))  # fmt: skip
        z = [Boxes(np.nextafter(a, -np.inf), np.nextafter(b, np.inf)) for a, b in zip(lows, highs, strict=True)]
        inside = level(f, z).low <= c
        a, b, _ = ask(d, v_r, w_r, [e[inside] for e in z])
        a, b = (Boxes(e.low.min(keepdims=True), e.high.max(keepdims=True)) for e in (a, b))
        table.append([a.low[0], a.high[0], b.low[0], b.high[0]])
        widths = [e.high - e.low for e in (a, b)]
        inst = driven(d["loop"], "ripple", d["loop"]["overshoot"], turns(d["loop"], v_r, w_r, a, b), a, b, widths)
        moves = turned(d, w_r, most, moved(d, v_r, w_r, *inst, inst, most))
        growth.append(float(np.sqrt(level(f, moves).high[0]) * (1 + 1e-14)))
    return np.array(table), np.array(growth)


def falls(d, boxes, levels, table, growth):
    """Over which boxes (n, 5, 2) V is at most μ ν w after a period, for all w."""
    f, z = d["V"], [Boxes(*boxes[:, i].T) for i in range(3)]
    v_r, inner, v = Boxes(*boxes[:, 3].T), f["inner"], level(f, z)
    v_r, w_r = references(d["loop"], v_r, Boxes(*boxes[:, 4].T))
    goal = f["fall"] * f["share"] * (1 - 1e-15)
    v = Boxes(v.low, np.minimum(v.high, f["share"] * f["outer"]))
    near = np.maximum(np.minimum(v.high / _NEAR, levels[0]), inner)
    n = np.searchsorted(-levels, -near, side="right") - 1  # the least level that is not below
    grown, bad = change(d, v_r, w_r, z, levels[n], table[n])
    grown *= 1 + np.sign(grown) * 1e-15
    down = grown <= -(1 - f["fall"]) * v.high * (1 + 1e-14)
    good = ~bad & (down | (v.high + grown <= f["fall"] * np.maximum(v.low, f["share"] * inner) * (1 - 1e-14)))
    w = np.full(len(boxes), levels[0])  # from the greatest w down, where V is much less and may grow
    while (open_ := np.flatnonzero(good & (w > near))).size:
        n = np.searchsorted(-levels, -w[open_], side="right") - 1
        following = np.append(levels[1:], inner)[n]
        far = (np.sqrt(v.high[open_]) + growth[n]) ** 2 * (1 + 1e-13) <= goal * following
        w[open_[far]] = following[far]
        left, m = open_[~far], n[~far]
        if left.size:
            part = [e[left] for e in z]
            grown, bad = change(d, v_r[left], w_r[left], part, levels[m], table[m])
            w[left] = (v.high[left] + grown) / goal * (1 + 1e-14)
            good[left] = ~bad & (w[left] <= np.maximum(near[left], following[~far]))
    return good


def check(data):
    """Raise RefutedError unless a certificate, as its file holds it, is true; return how many boxes it took."""
    try:
        return _check(data)
    except (KeyError, IndexError, TypeError, ValueError, AttributeError, ArithmeticError) as error:
        if isinstance(error, RefutedError):
            raise
        raise RefutedError(f"the certificate cannot be read: {error!r}") from None


def _check(data):
    k, f = data["loop"], data["V"]
    numbers = np.array([*f.values(), *(n for v in k.values() for n in (v if isinstance(v, list) else [v]))], float)
    if data["format"] != FORMAT or not np.isfinite(numbers).all():
        raise RefutedError("the file is no certificate of this format")
    signed = {"v_weight", "w_weight", "kx", "ky", "kpsi", "last"}
    if min(v for n, v in k.items() if n not in signed) < 0 or not 0 < k["speed_low"] <= k["speed_high"]:
        raise RefutedError("a number of the loop is out of its range")
    groups, period, past = int(k["groups"]), k["period"], int(k["memory"]) + int(k["window"])
    if not (0 < period <= 0.5 and groups > 0 and min(k["last"]) >= 0 and k["memory"] >= 1):
        raise RefutedError("a number of the loop is out of its range")
    if max(abs(sum(k[n][:groups]) - 1) for n in ("v_weight", "w_weight")) > 1e-12:
        raise RefutedError("the weights of the commands must be 1 in all")
    if not (min(f["a"], f["b"], f["inner"]) > 0 and f["inner"] < f["outer"] and 0 < f["fall"] < 1):
        raise RefutedError("V must be positive, inner < outer, and fall below 1")
    if not 0 < f["share"] <= f["fall"] ** past:
        raise RefutedError("the share must be at most fall to the power of the samples that are remembered")
    count = math.ceil(math.log(f["inner"] / f["outer"]) / math.log(_STEP))
    levels = f["outer"] * (f["inner"] / f["outer"]) ** (np.arange(count + 1) / count)
    levels[0] = f["outer"]
    cells = max(1, math.ceil(math.log(k["speed_high"] / k["speed_low"]) / math.log(_CELL)))
    speeds = np.linspace(k["speed_low"], k["speed_high"], cells + 1)
    return sum(_prove(data, a, b, levels) for a, b in itertools.pairwise(speeds))


def _prove(data, slowest, fastest, levels):
    """Branch and bound over errors, v_r in a cell and curvature."""
    f, bend = data["V"], data["loop"]["curvature"]
    v_r = Boxes(np.array([slowest]), np.array([fastest]))
    table, growth = tabulate(data, *references(data["loop"], v_r, Boxes(-bend, bend)), levels)
    whole = np.array([m.high[0] for m in reach(f, np.array([f["outer"]]))])
    stack, count = [np.array([[*((-w, w) for w in whole), (slowest, fastest), (-bend, bend)]])], 0
    while stack:
        boxes = stack.pop()
        if len(boxes) > PIECE:
            stack.append(boxes[PIECE:])
            boxes = boxes[:PIECE]
        v = level(f, [Boxes(*boxes[:, i].T) for i in range(3)])
        boxes, size = boxes[v.low <= f["share"] * f["outer"]], v.high[v.low <= f["share"] * f["outer"]]
        count += len(boxes)
        good = falls(data, boxes, levels, table, growth) if len(boxes) else np.zeros(0, bool)
        boxes, size = boxes[~good], np.sqrt(np.maximum(size[~good], f["share"] * f["inner"]) / f["outer"])
        if not len(boxes):
            continue
        scale = np.column_stack([size[:, None] * whole, 2 * boxes[:, 3, 1], np.full(len(boxes), 16.0)])
        sides = (boxes[..., 1] - boxes[..., 0]) / scale
        axis, rows = sides.argmax(axis=1), np.arange(len(boxes))
        # Where it does not fall in the middle of a box no splitting helps
        middles = np.repeat(boxes[:: max(1, len(boxes) // 200)].mean(axis=2)[..., None], 2, axis=2)
        inside = level(f, [Boxes(*middles[:, i].T) for i in range(3)]).high <= f["share"] * f["outer"]
        wrong = middles[inside & ~falls(data, middles, levels, table, growth)]
        if count > BOXES or len(wrong) or (sides[rows, axis] < _LEAST).any():
            where = (wrong if len(wrong) else boxes[sides[rows, axis].argsort()])[0].mean(axis=1).round(4).tolist()
            raise RefutedError(f"V is not seen to fall at X, Y, ψ, v_r, curvature = {where}")
        first, second = boxes.copy(), boxes.copy()
        first[rows, axis, 1] = second[rows, axis, 0] = boxes[rows, axis].mean(axis=1)
        stack.append(np.concatenate([first, second]))
    return count


def check_file(path):
    """Check the certificate in a file; returns what it says. Raises RefutedError, or OSError."""
    try:
        data = json.loads(Path(path).read_text(encoding="utf-8"))
    except (UnicodeDecodeError, json.JSONDecodeError) as error:
        raise RefutedError(f"the certificate cannot be read: {error}") from None
    if not isinstance(data, dict):
        raise RefutedError("the file is no certificate of this format")
    check(data)
    return data
