"""Check a certificate of a closed loop again, from its file alone: without the search and without the prover's code.

Intervals in NumPy, many at once, every operation rounded outwards by a part of 4e-16, which is more than it may be off
(the mathematics library's functions by five times that). docs/explanation/certificate.md has the theorem. Its condition
is checked here over boxes of its own: for all w in [inner, outer], all errors with V <= ν w and V <= w at the N samples
before, V <= μ ν w after a period, for every reference, noise and behaviour of the wheels that the file allows; and
ν <= μ^N.
"""

# mypy: disable-error-code="no-untyped-def"
import math
from functools import reduce

import numpy as np

FORMAT = "fuzzyfleet loop certificate 3"
LIBRARY, BOXES, PIECE = 2e-15, 3_000_000, 4096  # relative error of cos, exp ...; the most boxes; how many at once
_NEAR, _STEP, _CELL, _LEAST, _PARTS = 0.75, 0.9, 1.12, 0.004, (6, 10, 10)
_FIRST = (4, 8, 8, 1, 4)  # parts of the region's box and of the references, from which the boxes are split


class RefutedError(Exception):
    """A certificate that does not hold, or cannot be read. The message says what fails."""


def down(x):
    """A bound from below of the real number of which x is a rounded value."""
    return x - (np.abs(x) * 4e-16 + 1e-300)


def up(x):
    """The same from above."""
    return x + (np.abs(x) * 4e-16 + 1e-300)


class Boxes:
    """Intervals (..., n)."""

    __array_ufunc__ = None  # a number of NumPy leaves its product with a Boxes to the Boxes

    def __init__(self, low, high):
        self.low, self.high = self.ends = np.asarray(low, float), np.asarray(high, float)

    def __add__(self, other):
        other = of(other)
        return Boxes(down(self.low + other.low), up(self.high + other.high))

    def __neg__(self):
        return Boxes(-self.high, -self.low)

    def __sub__(self, other):
        return self + -of(other)

    def __rsub__(self, other):
        return of(other) + -self

    def __mul__(self, other):
        ends = [a * b for a in self.ends for b in (other.ends if isinstance(other, Boxes) else [other])]
        return Boxes(down(reduce(np.minimum, ends)), up(reduce(np.maximum, ends)))

    __radd__, __rmul__ = __add__, __mul__

    def __getitem__(self, place):
        return Boxes(self.low[place], self.high[place])

    @property
    def width(self):
        """high − low at most."""
        return (self.high - self.low) * (1 + 1e-15) + 1e-300

    @property
    def size(self):
        """|x| at most."""
        return np.maximum(np.abs(self.low), np.abs(self.high))

    def square(self):
        """x²."""
        least = np.where((self.low <= 0) & (self.high >= 0), 0, np.minimum(np.abs(self.low), np.abs(self.high)))
        return Boxes(np.maximum(down(least * least), 0), up(self.size * self.size))

    def cos(self):
        """The cosine."""
        ends = [np.cos(e) for e in self.ends]
        far, least, most = self.size > 12, self.low.min(initial=12), self.high.max(initial=-12)
        low, high = np.where(far, -1, np.minimum(*ends)), np.where(far, 1, np.maximum(*ends))
        for n in range(round(max(least, -12) / math.pi), round(min(most, 12) / math.pi) + 1):
            holds = (self.low <= n * math.pi + 1e-14) & (n * math.pi - 1e-14 <= self.high)
            low, high = np.where(holds & (n % 2 == 1), -1, low), np.where(holds & (n % 2 == 0), 1, high)
        return Boxes(np.maximum(low - LIBRARY, -1), np.minimum(high + LIBRARY, 1))

    def sin(self):
        """The sine."""
        return (self - about(math.pi / 2)).cos()

    def within(self, other):
        """What both have in common; a point of the other where that is nothing, which no trajectory meets."""
        low, high = np.maximum(self.low, other.low), np.minimum(self.high, other.high)
        return Boxes(*(np.where(low <= high, end, np.minimum(low, other.high)) for end in (low, high)))


def of(x):
    """A number as an interval."""
    return x if isinstance(x, Boxes) else Boxes(x, x)


def about(x):
    """The real number whose rounded value is x."""
    return Boxes(down(x), up(x))


def wide(by):
    """−by to by."""
    by = up(np.abs(by))
    return Boxes(-by, by)


# The rule base: thirteen membership functions, each of one or two parts that only rise or only fall ---------------


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


def gauss(z, a):
    """Half a Gaussian: 1 for z >= 0."""
    return np.exp(np.maximum(-0.5 * (np.minimum(z, 0) / a) ** 2, -700))


def bell(z, a, b):
    """Half a bell: 1 for z >= 0."""
    if not b > 0:
        raise RefutedError("gbellmf: its power must be above 0")
    return 1 / (1 + np.minimum(np.abs(np.minimum(z, 0) / a) ** (2 * b), 1e300))


TERM_PARTS = {
    "linsmf": lambda x, a, b: [ramp(x, a, b)],
    "linzmf": lambda x, a, b: [1 - ramp(x, a, b)],
    "trimf": lambda x, a, b, c: [ramp(x, a, b), ramp(-x, -c, -b)],
    "trapmf": lambda x, a, b, c, d: [ramp(x, a, b), ramp(-x, -d, -c)],
    "smf": lambda x, a, b: [spline(x, a, b)],
    "zmf": lambda x, a, b: [spline(-x, -b, -a)],
    "pimf": lambda x, a, b, c, d: [spline(x, a, b), spline(-x, -d, -c)],
    "gaussmf": lambda x, a, b: [gauss(x - b, a), gauss(b - x, a)],
    "gauss2mf": lambda x, a, b, c, d: [gauss(x - b, a), gauss(d - x, c)],
    "gbellmf": lambda x, a, b, c: [bell(x - c, a, b), bell(c - x, a, b)],
    "sigmf": lambda x, a, c: [sigmoid(x, a, c)],
    "psigmf": lambda x, a, b, c, d: [sigmoid(x, a, b), sigmoid(x, c, d)],
    "dsigmf": lambda x, a, b, c, d: [sigmoid(x, a, b), sigmoid(x, c, d)],
}


def degree(x, kind, n):
    """The degrees of a term over intervals: the product of its parts, or their difference."""
    ends = [TERM_PARTS[kind](e, *n) for e in x.ends]
    low, high = ([pick(p, q) for p, q in zip(*ends, strict=True)] for pick in (np.minimum, np.maximum))
    low, high = (low[0] - high[1], high[0] - low[1]) if kind == "dsigmf" else (math.prod(low), math.prod(high))
    if kind in ("gaussmf", "gauss2mf", "gbellmf", "sigmf"):  # relative accuracy, which tails need
        return Boxes(np.clip(low * (1 - 2e-12), 0, 1), np.clip(high * (1 + 2e-12) + 1e-300, 0, 1))
    low, high = np.where(low < 1, low - 2e-12, 1), np.where(high > 0, high + 2e-12, 0)
    return Boxes(np.clip(low, 0, 1), np.clip(high, 0, 1))


def mean(low, high, y, sign):
    """A bound of the weighted mean of y (rules, n) from above (1) or below (-1) [Karnik & Mendel 2001]."""
    top = np.where(high > 0, sign * y, -np.inf).max(0)
    y = np.where(high > 0, sign * y, top)
    bound = (high * y).sum(0) / np.maximum(high.sum(0), 1e-300)
    for _ in range(10):
        w, last = np.where(y > bound, high, low), bound
        bound = np.maximum(bound, (w * y).sum(0) / np.maximum(w.sum(0), 1e-300))
        if (bound == last).all():
            break
    bound = bound + 1e-12 * (top - y.min(0)) + 1e-14 * np.abs(bound)
    w = np.where(y > bound, high, low)
    holds = (w * (y - bound)).sum(0) + 1e-14 * (w * np.abs(y - bound)).sum(0) <= 0
    return sign * np.where(holds, np.minimum(bound, top), top)


def fires(rule, rules, degrees):
    """How much a rule fires."""
    w, method = of(1.0), rules["or" if rule["or"] else "and"]
    for i, t, power, negated in rule["clauses"]:
        p = degrees[i][t]
        if power != 1:
            p = Boxes(p.low**power * (1 - LIBRARY), np.minimum(p.high**power * (1 + LIBRARY), 1))
        p = 1 - p if negated != rule["or"] else p  # "or" by De Morgan
        w = Boxes(*map(np.minimum, w.ends, p.ends)) if method in ("max", "min") else w * p
    w = (1 - w if rule["or"] else w) * rule["weight"]
    return np.maximum(w.low, 0), np.where(w.high > 0, np.maximum(w.high, 1e-290), 0)


def fired(rules, x):
    """How much each rule fires over intervals ``x`` (rules, 2, n)."""
    degrees = [[degree(v, *t) for t in i["terms"]] for v, i in zip(x, rules["inputs"], strict=True)]
    return np.array([np.broadcast_arrays(*fires(r, rules, degrees), x[0].low)[:2] for r in rules["rules"]])


def infer(rules, x):
    """The outputs of the rule base over intervals ``x`` of its inputs, and where it may have none."""
    if rules["clip"]:
        x = [Boxes(*(np.clip(e, i["low"], i["high"]) for e in v.ends)) for v, i in zip(x, rules["inputs"], strict=True)]
    weights = fired(rules, x)
    found, hole = {}, np.zeros_like(x[0].low, bool)
    for o, name in enumerate(rules["outputs"]):
        taking = [rule["then"][o] is not None for rule in rules["rules"]]
        weak, strong = weights[taking].swapaxes(0, 1)
        hole |= ~(weak.sum(0) > 1e-280)
        numbers = np.array([rule["then"][o] for rule in rules["rules"] if rule["then"][o] is not None], float)
        base = numbers[np.argmax(weak + strong, axis=0)]  # (n, 1 + inputs): what the rules' slopes are taken beside
        y, common = of(numbers[:, :1] + np.zeros_like(weak)), of(0.0)  # (rules, n): a constant, and slopes
        for i, v in enumerate(x, 1):
            y, common = y + about(numbers[:, i, None] - base[:, i]) * v, common + base[:, i] * v
        found[name] = Boxes(mean(weak, strong, y.low, -1), mean(weak, strong, y.high, 1)) + common
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
        known = {"x_err": x_err, "y_err": y_err, "heading_err": psi, "target_v": target, "target_w": w_r + dw}
        out, hole = infer(d["rules"], [known[i["quantity"]] for i in d["rules"]["inputs"]])
        bad = bad | hole
    a = out.get("dv", of(0.0)) - target * (1 - cos)
    v, a = target + a, a + dv
    least, catch = np.maximum(np.maximum(v.low, -v.high), 0), k["catch_up"]
    speed = Boxes(np.maximum(target.low, np.minimum(least, catch)), np.maximum(target.high, np.minimum(v.size, catch)))
    b = out.get("dw", of(0.0)) + speed * out.get("bend", of(0.0)) + dw
    fast, turning = (v_r + a).size, (w_r + b).size
    bad = bad | (fast > k["v_max"]) | (turning > k["w_max"])
    return a, b, bad | ~(fast + k["half_axle"] * turning < k["wheel_limit"] * (1 - 1e-12))


def turns(k, v_r, w_r, a, b):
    """1 where a wheel may turn round."""
    v, rim, slow = v_r + a, k["half_axle"] * (w_r + b), k["slow"]
    return 1.0 * np.any([(e.low <= slow) & (e.high >= -slow) for e in (v + rim, v - rim)], axis=0)


def driven(k, kind, turning, told, every):
    """What the wheels do, of what they are told: over a period ("error") or at any time of it ("ripple")."""
    share = k["share" if kind == "error" else "overshoot"]
    by = [share * e.width + k[f"{n}_{kind}"] + turning * k[f"{n}_reversal"] for n, e in zip("vw", every, strict=True)]
    return [e + wide(n * (1 + 1e-14)) for e, n in zip(told, by, strict=True)]


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
    return [wide(np.sqrt(c * n) * (1 + 1e-14)) for n in (1 / f["a"], 1 / f["b"], 1 + f["m"] ** 2 / f["b"])]


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
        return sum(factor.ends) / 2 * (b + wide(inst[1].width / 4)) + wide(factor.width / 2 * inst[1].size)

    x = v_r * (1 - psi.cos()) - a * psi.cos() - t / 2 * bent(speed * heading.sin())
    y = (v_r + a) * psi.sin() - t / 2 * bent(speed * heading.cos())
    far = wide((z[0].size + z[1].size + t * (2 * v_r.high + inst[0].size)) * (1 + 1e-13))
    dx, dy = rates(v_r, w_r, inst[0], far, far, heading)
    return [t * (x + t / 2 * (w_r * dy)), t * (y - t / 2 * (w_r * dx)), -t * b]


def grown(d, w_r, z, moves):
    """V of the changes, with the rotation by ω_r."""
    w = d["loop"]["period"] * w_r
    return level(d["V"], [moves[0] + w * z[1], moves[1] - w * z[0], moves[2]]).high


def change(d, v_r, w_r, z, c, table):
    """By how much V may grow in a period, with V <= c before, and where that cannot be said."""
    k, f, every = d["loop"], d["V"], (Boxes(table[:, 0], table[:, 1]), Boxes(table[:, 2], table[:, 3]))
    bad, s, turning = np.zeros(len(c), bool), z[2] + f["m"] * z[1], turns(k, v_r, w_r, *every)
    steps, prompt, last = int(k["memory"]), int(k["prompt"]), [int(n) for n in k["last"][: int(k["groups"])]]
    weights = [list(zip(k[name], last, strict=False)) for name in ("v_weight", "w_weight")]
    hulls, sent, fresh = every, [every] * 3000, k["fresh"]  # what is asked for, and sent since n periods, oldest first

    def average(n):
        return [sum((w * sent[n + age][i] for w, age in weights[i]), of(0.0)) for i in range(2)]

    for n in range(steps, -1, -1):
        past, sent[n] = z, sent[n + 1]
        if n:
            mean_b = driven(k, "error", turning, average(n), every)[1]
            past = earlier(d, v_r, w_r, driven(k, "ripple", turning, *[sent[n + prompt]] * 2), mean_b, z, c, n)
        *asked, wrong = ask(d, v_r, w_r, past)
        hulls, bad = [a.within(h) for a, h in zip(asked, hulls, strict=True)], bad | wrong
        sent[n] = [fresh * h + about(1 - fresh) * e for h, e in zip(hulls, sent[n + 1], strict=True)]
    turning = turns(k, v_r, w_r, *sent[int(k["turning"])])
    a, b = driven(k, "error", turning, average(0), every)
    moves = moved(d, v_r, w_r, a, b, driven(k, "ripple", turning, *[sent[prompt]] * 2), z)
    first = f["a"] * (z[0] * moves[0]) + f["b"] * (z[1] * moves[1]) + s * (moves[2] + f["m"] * moves[1])
    first = first + k["period"] * (w_r * z[0] * (about(f["a"] - f["b"]) * z[1] - f["m"] * s))
    return (2 * first + grown(d, w_r, z, moves)).high, bad


def tabulate(d, v_r, w_r, levels):
    """What the law asks for all over V <= c (levels, 4), and by how much √V then grows in a period (levels,)."""
    f, k, table, growth = d["V"], d["loop"], [], []
    # What a low-pass has forgotten was anything between the limits
    rest = [wide(2 * (1 - k["fresh"]) ** (k["forgotten"] // 1 + 1) * (1 + 1e-9) * k[n]) for n in ("v_max", "w_max")]
    for c in levels:
        most = reach(f, np.array([c]))
        edges = [np.linspace(m.low[0], m.high[0], n + 1) for m, n in zip(most, _PARTS, strict=True)]
        low, high = (np.reshape(np.meshgrid(*(e[s] for e in edges)), (3, -1)) for s in (slice(-1), slice(1, None)))
        z = Boxes(np.nextafter(low, -np.inf), np.nextafter(high, np.inf))
        asked = ask(d, v_r, w_r, z[:, level(f, z).low <= c])[:2]
        asked = [Boxes(e.low.min(keepdims=True), e.high.max(keepdims=True)) for e in asked]
        asked = [e + r for e, r in zip(asked, rest, strict=True)]
        table.append([end[0] for e in asked for end in e.ends])
        inst = driven(k, "ripple", turns(k, v_r, w_r, *asked), asked, asked)
        growth.append(math.sqrt(grown(d, w_r, most, moved(d, v_r, w_r, *inst, inst, most))[0]) * (1 + 1e-14))
    return np.array(table), np.array(growth)


def falls(d, boxes, levels, table, growth):
    """Over which boxes V is at most μ ν w after a period, for all w.

    ``boxes`` (6, n) are of X, Y, ψ, v_r, curvature and number of the cell;
    ``table`` (cells, levels, 4) and ``growth`` (cells, levels) are those of :func:`tabulate`.
    """
    f, z, v, cell = d["V"], boxes[:3], level(d["V"], boxes), boxes.low[5].astype(int)
    v_r, w_r = references(d["loop"], boxes[3], boxes[4])
    end, goal = f["share"] * f["inner"], f["fall"] * f["share"] * (1 - 1e-15)
    most = np.minimum(v.high, f["share"] * f["outer"])
    near = np.maximum(np.minimum(most / _NEAR, levels[0]), f["inner"])
    n = np.searchsorted(-levels, -near, side="right") - 1  # the least level that is not below
    by, bad = change(d, v_r, w_r, z, levels[n], table[cell, n])
    by *= 1 + np.sign(by) * 1e-15
    down = by <= -(1 - f["fall"]) * most * (1 + 1e-14)
    good = ~bad & (down | (most + by <= f["fall"] * np.maximum(v.low, end) * (1 - 1e-14)))
    w = np.full(len(most), levels[0])  # from the greatest w down, where V is much less and may grow
    while (left := np.flatnonzero(good & (w > near))).size:
        n = np.searchsorted(-levels, -w[left], side="right") - 1
        w[left] = following = np.append(levels[1:], f["inner"])[n]
        slow = (np.sqrt(most[left]) + growth[cell[left], n]) ** 2 * (1 + 1e-13) > goal * following
        left, n = left[slow], n[slow]
        by, bad = change(d, v_r[left], w_r[left], z[:, left], levels[n], table[cell[left], n])
        w[left] = (most[left] + by) / goal * (1 + 1e-14)
        good[left] = ~bad & (w[left] <= np.maximum(near[left], following[slow]))
    return good


def check_levels(data):
    """Raise RefutedError unless a certificate, whose loop's numbers are in range, is true."""
    k, f = data["loop"], data["V"]
    past = sum(int(k[n]) for n in ("memory", "window", "forgotten"))
    for holds, wrong in (
        (data["format"] == FORMAT and np.isfinite([*f.values()]).all(), "the file is no certificate of this format"),
        (min(f["a"], f["b"]) > 0 and 0 < f["inner"] < f["outer"] and 0 < f["fall"] < 1, "V is out of its range"),
        (0 < f["share"] <= f["fall"] ** past, "share is above fall^(what counts)"),
    ):
        if not holds:
            raise RefutedError(wrong)
    count = math.ceil(math.log(f["inner"] / f["outer"]) / math.log(_STEP))
    levels = f["outer"] * (f["inner"] / f["outer"]) ** (np.arange(count + 1) / count)
    cells = math.ceil(math.log(k["speed_high"] / k["speed_low"]) / math.log(_CELL))
    speeds = np.linspace(k["speed_low"], k["speed_high"], max(1, cells) + 1)
    _prove(data, speeds[:-1], speeds[1:], levels)


def _prove(data, slowest, fastest, levels):
    """Branch and bound over errors, curvature and v_r, which begins in cells (n,)."""
    f, bend, most, count, tables = data["V"], data["loop"]["curvature"], data["V"]["share"] * data["V"]["outer"], 0, []
    for ends in zip(slowest[:, None], fastest[:, None], strict=True):
        tables.append(tabulate(data, *references(data["loop"], Boxes(*ends), Boxes(-bend, bend)), levels))
    about_levels = levels, *map(np.array, zip(*tables, strict=True))
    whole = np.array([m.high[0] for m in reach(f, np.array([f["outer"]]))])
    edges = [np.linspace(-e, e, n + 1) for e, n in zip([*whole, 0, bend], _FIRST, strict=True)]
    corners = [[*(e[s] for e in edges), np.arange(len(slowest))] for s in (slice(-1), slice(1, None))]
    boxes = np.array([np.reshape(np.meshgrid(*c, indexing="ij"), (6, -1)) for c in corners])  # (2, 6, n)
    boxes[:, 3] = np.array([slowest, fastest])[:, boxes[0, 5].astype(int)]
    while boxes.size:
        boxes, rest = boxes[..., -PIECE:], boxes[..., :-PIECE]
        boxes = boxes[..., level(f, Boxes(*boxes)).low <= most]
        count += boxes.shape[2]
        boxes = boxes[..., ~falls(data, Boxes(*boxes), *about_levels)]
        size = np.sqrt(np.maximum(level(f, Boxes(*boxes)).high, f["share"] * f["inner"]) / f["outer"])
        sides = (boxes[1, :5] - boxes[0, :5]) / [*size * whole[:, None], 2 * boxes[1, 3], np.full(len(size), 16.0)]
        axis, n = sides.argmax(axis=0), np.arange(len(size))
        # Where it does not fall in the middle of a box no splitting helps
        middles = boxes.mean(axis=0)[:, :: max(1, len(size) // 50)]
        wrong = middles[:5, (level(f, of(middles)).high <= most) & ~falls(data, of(middles), *about_levels)]
        if count > BOXES or wrong.size or (sides[axis, n] < _LEAST).any():
            where = wrong[:, 0] if wrong.size else boxes[:, :5, sides[axis, n].argmin()].mean(axis=0)
            raise RefutedError(f"V is not seen to fall at X, Y, ψ, v_r, curvature = {where.round(4).tolist()}")
        first, second = boxes.copy(), boxes.copy()
        first[1, axis, n] = second[0, axis, n] = boxes[:, axis, n].mean(axis=0)
        boxes = np.concatenate([rest, first, second], axis=2)
