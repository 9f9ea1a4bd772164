"""Prove a decrease of V whose states are the commands on their way, too.

docs/explanation/certificate.md has the theorem. The states ζ are X, Y, ψ and what the wheels were told at the samples
before, so that the loop is linear but for four signals: what the law asks for, and what the kinematics adds in a
period. Of all ζ with one posture V(k+1) − λ² V(k) is at most a form in the posture and these signals (a Schur
complement), so boxes are split over the posture and the reference alone. Over a box a signal is a linear function and
a rest that is bounded (affine arithmetic [de Figueiredo & Stolfi 2004]); what is linear costs nothing.

The certificate's file is checked by another program, :mod:`robotics.plugins.certificates.statechecker`.
"""

# mypy: disable-error-code="no-untyped-def"
import itertools
import math

import numpy as np

from robotics.plugins.certificates.checker import LIBRARY, Boxes, RefutedError, fired, mean, up
from robotics.plugins.certificates.statechecker import FALL_SLACK

_BOXES, _PIECE, AFFINE_SYMBOLS = 300_000, 4096, 5  # boxes at most; how many at once; X, Y, ψ, v_r and the curvature
_ROUND, _LEAST = 2e-15, 1e-6
_EXACT = 1e-12  # relative: more than entries of the loop's matrices are off


class Affine:
    """Functions middle + Σ slope_j ε_j ± rest over boxes, |ε| <= 1: (n,), (5, n), (n,)."""

    def __init__(self, middle, slope=0.0, rest=0.0):
        self.middle = np.atleast_1d(middle)
        self.slope = slope + np.zeros((AFFINE_SYMBOLS, *[1] * self.middle.ndim))
        self.rest = rest + _ROUND * (np.abs(self.middle) + np.abs(self.slope).sum(0)) + 1e-300

    @property
    def radius(self):
        """How far it is from the middle at most."""
        return (np.abs(self.slope).sum(0) + self.rest) * (1 + _ROUND)

    @property
    def size(self):
        """|x| at most."""
        return np.abs(self.middle) + self.radius

    @property
    def range(self):
        """An interval that holds it."""
        return Boxes(self.middle - self.radius, self.middle + self.radius)

    def __add__(self, other):
        other = affine(other)
        return Affine(self.middle + other.middle, self.slope + other.slope, self.rest + other.rest)

    def __neg__(self):
        return Affine(-self.middle, -self.slope, self.rest)

    def __sub__(self, other):
        return self + -affine(other)

    def __rsub__(self, other):
        return affine(other) + -self

    def __mul__(self, other):
        other = affine(other)
        rest = np.abs(self.middle) * other.rest + np.abs(other.middle) * self.rest + self.radius * other.radius
        return Affine(self.middle * other.middle, self.middle * other.slope + other.middle * self.slope, rest)

    __radd__, __rmul__ = __add__, __mul__

    def cos(self):
        """The cosine, by Taylor."""
        cos, sin = np.cos(self.middle), np.sin(self.middle)
        return Affine(cos, -sin * self.slope, np.abs(sin) * self.rest + self.radius**2 / 2 + LIBRARY)

    def sin(self):
        """The sine."""
        cos, sin = np.cos(self.middle), np.sin(self.middle)
        return Affine(sin, cos * self.slope, np.abs(cos) * self.rest + self.radius**2 / 2 + LIBRARY)


def affine(x):
    """A number, or an interval, as such a function."""
    if isinstance(x, Boxes):
        return Affine((x.low + x.high) / 2, 0.0, up((x.high - x.low) / 2) + _ROUND * x.size)
    return x if isinstance(x, Affine) else Affine(np.asarray(x, float))


def about(by):
    """−by to by."""
    return Affine(0.0 * by, 0.0, by)


def chosen(where, x, other):
    """The first where that is so, else the second."""
    return Affine(*(np.where(where, a, b) for a, b in zip(parts(x), parts(other), strict=True)))


def parts(x):
    """What an Affine is made of."""
    return x.middle, x.slope, x.rest


def infer(rules, x):
    """The outputs of the rule base, and where it may have none.

    The mean of linear functions is at their mean in the middle, and as steep as the mean of their slopes.
    """
    if rules["clip"]:
        for n, i in enumerate(rules["inputs"]):
            box = x[n].range
            cut = affine(Boxes(*(np.clip(e, i["low"], i["high"]) for e in box.ends)))
            x[n] = chosen((box.low >= i["low"]) & (box.high <= i["high"]), x[n], cut)
    weights = fired(rules, [v.range for v in x])
    found, hole = {}, False
    for o, name in enumerate(rules["outputs"]):
        taking = [rule["then"][o] is not None for rule in rules["rules"]]
        weak, strong = weights[taking].swapaxes(0, 1)
        hole = hole | ~(weak.sum(0) > 1e-280)
        numbers = np.array([rule["then"][o] for rule in rules["rules"] if rule["then"][o] is not None], float)
        said = Affine(numbers[:, :1])
        for i, v in enumerate(x, 1):
            wide = Affine(v.middle[None], v.slope[:, None], v.rest[None])
            said = said + Affine(numbers[:, i, None]) * wide
        flat = np.zeros_like(weak)
        means = [
            affine(Boxes(mean(weak, strong, y, -1), mean(weak, strong, y, 1)))
            for y in (said.middle + flat, *(said.slope + flat))
        ]
        rest = mean(weak, strong, said.rest + flat, 1)
        slope = np.array([m.middle for m in means[1:]])
        found[name] = Affine(means[0].middle, slope, sum(m.rest for m in means) + rest)
    return found, hole


class StateLoop:
    """The loop about one speed of the reference: ζ(k+1) = A ζ + G r, |what else is added| by V's norm."""

    def __init__(self, k, f):
        low, high = f["speed"]
        speed, groups, t, s = (low + high) / 2, int(k["groups"]), k["period"], k["fresh"]
        self.P, n = np.array(f["P"]), 2 * groups + 1
        told = np.zeros((2, groups, n + 4))  # what the wheels were told of v and of ω, from now on back
        for i in range(2):
            first = 3 + i * (groups - 1)
            told[i, 0, first], told[i, 0, n + i] = 1 - s, s
            told[i, 1:, first : first + groups - 1] = np.eye(groups - 1)
        mean_a, mean_b = (np.array(k[w][:groups]) @ e for w, e in zip(("v_weight", "w_weight"), told, strict=True))
        if not positive(self.P, self.P):
            raise RefutedError("V is not seen to be positive")
        step = np.eye(n, n + 4)
        step[0] += -t * mean_a + np.eye(n + 4)[n + 2]
        step[1] += -speed * t * t / 2 * mean_b + np.eye(n + 4)[n + 3]
        step[2] += -t * mean_b
        step[3:] = np.vstack([told[0, :-1], told[1, :-1]])
        self.step, reach = step, np.sqrt(np.diag(np.linalg.inv(self.P)) * (1 + 1e-7))
        if not all(positive(self.P - np.outer(e, e) / c**2, self.P) for e, c in zip(np.eye(n), reach, strict=True)):
            raise RefutedError("V is not seen to bound its states")
        self.whole = reach[:3]
        # What the wheels were told is the newest state a sample later; a and b at any time are that, and more
        reach, wide = reach[[3, 2 + groups]], 1 + 2 * k["overshoot"]
        fast, turning = high + reach[0], high * k["curvature"] + reach[1]
        if not (fast < k["v_max"] and turning < k["w_max"] and fast + k["half_axle"] * turning < k["wheel_limit"]):
            raise RefutedError("a command may meet a limit of the wheels")
        turns = 1.0 * (low - reach[0] - k["half_axle"] * turning <= k["slow"])
        more = np.array([k[f"{n}_ripple"] + turns * k[f"{n}_reversal"] for n in "vw"])
        self.a, self.b = wide * reach + more
        columns = np.zeros((4, n))
        columns[0, 0], columns[1, 1:3], columns[2, 0], columns[3, 1] = t, [speed * t * t / 2, t], 1.0, 1.0
        signs = np.array([*itertools.product((-1.0, 1.0), repeat=4)])  # the norm is greatest at ends of its parts

        def differs(part, a, b, error):
            """By how much ζ may differ, of half of the hull's width, of a, b at any time, and of the means."""
            v, beta = high, t * self.b
            turned = high * k["curvature"] * t * t / 2 * (a + v * t * b)  # what ω_r adds to what is driven
            x = (v + self.a) * t * beta / 6 * t * b + turned
            y = (v / 2 + 0.51 * (high - low)) * t * t / 2 * b + t * beta / 2 * a + v * t * beta**2 / 6 * t * b + turned
            ends = signs * [*(2 * k["share"] * part + error), x, y] @ columns
            return math.sqrt(np.einsum("ki,ij,kj->k", ends, self.P, ends).max()) * (1 + 1e-9)

        off = np.array([k[f"{n}_error"] + turns * k[f"{n}_reversal"] for n in "vw"])
        self.past, self.off = differs(reach, *(wide * reach), 0.0), differs(0.0, *more, off)
        # Noise in what the law asks for; the heading turns its part in the mean of a
        noise = np.array([*f["noise"], *[t * mean_a[n] * self.whole[2] * f["noise"][0]] * 2])
        by_noise = signs * noise @ step[:, n:].T
        self.off += math.sqrt(np.einsum("ki,ij,kj->k", by_noise, self.P, by_noise).max()) * (1 + 1e-9)
        self.told, self.mean_error = mean_a, 2 * k["share"] * reach[0] + off[0]

    def prepare(self, f):
        """Find the form that boxes are about, and what is known of the mean of a."""
        self.slack = 2 * FALL_SLACK * f["fall"] * f["inner"] ** 2
        self.form, self.near = schur(self.P, self.step, f["fall"] ** 2)
        # The mean of a is ahead'δ + fresh u, within aside √(1 − δ'Nδ) and what the wheels differ
        P, n = self.P, len(self.P)
        row = self.told[:n].copy()
        self.ahead, self.fresh = row[:3] - P[:3, 3:] @ np.linalg.solve(P[3:, 3:], row[3:]), self.told[n]
        self.aside = math.sqrt(row[3:] @ np.linalg.solve(P[3:, 3:], row[3:])) * (1 + 1e-6)
        row[:3] -= self.ahead
        rest = P - np.outer(row, row) / self.aside**2
        rest[:3, :3] -= self.near * (1 - 1e-6)
        if not positive(rest, P):
            raise RefutedError("what was told is not seen to be bounded")

    def signals(self, d, boxes):
        """What the law asks for and what the kinematics adds, over boxes (2, 5, n), and where that cannot be said."""
        k, t = d["loop"], d["loop"]["period"]
        middle, half = boxes.mean(axis=0), (boxes[1] - boxes[0]) / 2 * (1 + _ROUND) + 4e-16 * np.abs(boxes).max(axis=0)
        x, y, psi, v_r, bend = (
            Affine(m, h * e[:, None]) for m, h, e in zip(middle, half, np.eye(AFFINE_SYMBOLS), strict=True)
        )
        cos, sin, w_r = psi.cos(), psi.sin(), v_r * bend
        x_err, y_err = cos * x - sin * y, sin * x + cos * y
        if d["rules"] is None:
            out, hole = {"dv": k["kx"] * x_err, "bend": k["ky"] * y_err + k["kpsi"] * sin}, False
        else:
            known = {"x_err": x_err, "y_err": y_err, "heading_err": psi, "target_v": v_r, "target_w": w_r}
            out, hole = infer(d["rules"], [known[i["quantity"]] for i in d["rules"]["inputs"]])
        none = affine(0.0 * middle[0])
        a = out.get("dv", none) - v_r * (1 - cos)
        v, target, catch = (v_r + a).range, v_r.range, k["catch_up"]
        least, most = np.maximum(np.maximum(v.low, -v.high), 0), np.minimum(v.size, catch)
        speed = affine(Boxes(np.maximum(target.low, np.minimum(least, catch)), np.maximum(target.high, most)))
        speed = chosen((v.low >= target.high) & (v.high <= catch), v_r + a, chosen(most <= target.low, v_r, speed))
        b = out.get("dw", none) + speed * out.get("bend", none)
        turned, fast, far = t * self.b, v_r.size + self.a, psi.size
        both = w_r.size * t * t / 2 * v_r.size * far
        turn = t * w_r
        around = about(turn.size**2 / 2)  # 1 − cos, and sin x − x is less than it, times x
        more_x = fast * far * t * turned / 2 + both
        more_y = v_r.size * t * turned**2 / 6 * far + v_r.size * far**2 / 2 * t * turned / 2 + both
        level = (1 - 1e-6) * self.least(boxes)
        mean_a = sum(g * e for g, e in zip(self.ahead, (x, y, psi), strict=True)) + self.fresh * a
        rate = t * (v_r + mean_a + about(self.aside * np.sqrt(1 - np.clip(level, 0, 1)) + self.mean_error))
        n_x = rate * (1 - cos) + turn * y + around * x + about(turn.size**2 / 2) * y + about(more_x)
        n_y = rate * sin - turn * x + around * y + about(turn.size**2 / 2) * x + about(more_y)
        return (x, y, psi, a, b, n_x, n_y), hole | (far > 3.1) | (turn.size > 0.5)

    def falls(self, d, boxes):
        """Over which boxes the form is at most the slack."""
        signals, bad = self.signals(d, boxes)
        shape = boxes.shape[2]
        middle = np.array([e.middle + np.zeros(shape) for e in signals])
        slope = np.array([e.slope + np.zeros((AFFINE_SYMBOLS, shape)) for e in signals])  # (7, 5, n)
        rest, M = np.array([e.rest + np.zeros(shape) for e in signals]), self.form
        turned = np.einsum("ij,jsn->isn", M, slope)
        at, bent = M @ middle, np.einsum("isn,itn->stn", slope, turned)
        square = np.einsum("ssn->sn", bent)
        value = (middle * at).sum(0) + 2 * np.abs(np.einsum("in,isn->sn", at, slope)).sum(0)
        value += np.maximum(square, 0).sum(0) + np.abs(bent).sum((0, 1)) - np.abs(square).sum(0)
        value += (rest * (2 * np.abs(at) + 2 * np.abs(turned).sum(1) + np.abs(M) @ rest)).sum(0)
        size = np.abs(middle) + np.abs(slope).sum(1) + rest
        value += 1e-13 * np.einsum("in,ij,jn->n", size, np.abs(M), size)
        return ~bad & (value <= self.slack)

    def least(self, boxes):
        """δ'Nδ at least, of boxes."""
        middle, half = boxes[:, :3].mean(axis=0), (boxes[1, :3] - boxes[0, :3]) / 2 * (1 + 1e-9)
        at = self.near @ middle
        bent = np.einsum("in,ij,jn->n", half, np.abs(self.near), half)
        return (middle * at).sum(0) * (1 - 1e-9) - 2 * (np.abs(at) * half).sum(0) - bent


def positive(matrix, of_size):
    """Whether a symmetric matrix is positive definite for sure; its entries are off by a part of those ``of_size``."""
    scale = 1 / np.sqrt(np.abs(np.diag(of_size)) + 1e-300)
    scale = np.outer(scale, scale)
    matrix, error = matrix * scale, _EXACT * np.abs(of_size) * scale
    vectors = np.linalg.eigh(matrix)[1]
    near = vectors.T @ matrix @ vectors
    off = np.abs(near) + np.abs(vectors).T @ (error + 1e-14 * np.abs(matrix)) @ np.abs(vectors) * len(matrix)
    return bool((np.diag(near) > off.sum(1) - np.diag(near)).all())


def schur(P, step, fall):
    """M (7, 7) and N (3, 3): V(k+1) − fall V <= [δ; r]'M[δ; r] and V >= δ'Nδ for all ζ with the posture δ."""
    n, keep = len(P), np.array([0, 1, 2, *range(len(P), len(P) + 4)])
    S = step.T @ P @ step
    size = np.abs(step).T @ np.abs(P) @ np.abs(step)
    S[:n, :n] -= fall * P
    size[:n, :n] += np.abs(P)
    behind = S[3:n, 3:n]
    M = S[np.ix_(keep, keep)] - S[keep, 3:n] @ np.linalg.solve(behind, S[3:n, keep])
    M = (M + M.T) / 2 + 1e-7 * np.diag(np.abs(np.diag(M)))
    N = (P[:3, :3] - P[:3, 3:] @ np.linalg.solve(P[3:, 3:], P[3:, :3])) * (1 - 1e-7)
    above, below = -S, P.copy()
    above[np.ix_(keep, keep)] += M
    size[np.ix_(keep, keep)] += np.abs(M)
    below[:3, :3] -= N
    if not (positive(above, size) and positive(below, P)):
        raise RefutedError("V is not seen to fall behind the posture")
    return M, (N + N.T) / 2


def check_cell(d, f, boxes=_BOXES):
    """Raise RefutedError unless V falls, of one range of speeds; return how many boxes it took, and the loop."""
    k = d["loop"]
    groups = int(k["groups"])
    for holds, wrong in (
        (groups >= 2 and k["last"][:groups] == [*range(groups)], "ages of commands are not those of the states"),
        (0.5 < f["fall"] < 1, "what the wheels may differ keeps V from falling"),
        (not (k["v_rate"] or k["w_rate"]), "references that change are not covered"),
    ):
        if not holds:
            raise RefutedError(wrong)
    loop = StateLoop(k, f)
    if not f["fall"] + FALL_SLACK + loop.past + loop.off < 1 - 1e-12:
        by = f"√V by {loop.past:.2g} of what it was and {loop.off:.2g}"
        raise RefutedError(f"what the wheels may differ, or noise, keeps V from falling: {by}")
    loop.prepare(f)
    return split(d, f, loop, boxes), loop


def split(d, f, loop, limit):
    """Branch and bound over posture, speed and curvature."""
    bend, count, (low, high) = d["loop"]["curvature"], 0, f["speed"]
    boxes = np.array([[*-loop.whole, low, -bend], [*loop.whole, high, bend]])[..., None]
    whole = boxes[1, :, 0] - boxes[0, :, 0] + 1e-300
    weight = np.array([1.0, 1.0, 1.0, 0.2, 0.2])[:, None]
    while boxes.size:
        boxes, rest = boxes[..., -_PIECE:], boxes[..., :-_PIECE]
        boxes = boxes[..., loop.least(boxes) <= 1]
        count += boxes.shape[2]
        boxes = boxes[..., ~loop.falls(d, boxes)]
        sides = (boxes[1] - boxes[0]) / whole[:, None]
        far = np.abs(boxes[:, :3]).max(axis=0) / whole[:3, None]
        sides[:3] /= np.maximum(far.max(axis=0), 1e-9)
        sides *= weight
        axis, n = sides.argmax(axis=0), np.arange(boxes.shape[2])
        middles = np.repeat(boxes.mean(axis=0)[None, :, :: max(1, len(n) // 50)], 2, axis=0)
        level = np.einsum("in,ij,jn->n", middles[0, :3], loop.near, middles[0, :3])
        wrong = middles[0][:, (level < 1) & ~loop.falls(d, middles)]
        if count > limit or wrong.size or (sides[axis, n] < _LEAST).any():
            where = wrong[:, 0] if wrong.size else boxes[..., sides[axis, n].argmin()].mean(axis=0)
            raise RefutedError(f"V is not seen to fall at X, Y, ψ, v_r, curvature = {where.round(4).tolist()}")
        first, second = boxes.copy(), boxes.copy()
        first[1, axis, n] = second[0, axis, n] = boxes[:, axis, n].mean(axis=0)
        boxes = np.concatenate([rest, first, second], axis=2)
    return count
