"""A certificate of a rule base's closed loop with a linear plant: a region, a rate, and a proof over boxes.

With ζ = z - z* about the loop's rest, V = ζ'Pζ, and what the rules add about it, v = φ(q) - φ(q*), the loop of
:mod:`fuzzy.plugins.loop.sampledloop` is ζ(k+1) = A ζ + B v with v a function of δ = C ζ alone. Of all ζ with one δ

    V(k+1) - μ V(k) <= [δ; v]' M [δ; v],

where M is the Schur complement of the form in ζ: the states behind δ, however many, are eliminated exactly. So
there is left a question about the rules' few inputs: whether that is at most s wherever V <= 1, that is over all δ with
δ' N δ <= 1, N = (C P⁻¹ C')⁻¹. Branch and bound over boxes of δ answers it, with the interval extension of the rules
(:mod:`fuzzy.compiled.intervals`). Then V(k+1) <= μ V(k) + s, so what starts in V <= 1 stays there, and V falls by μ
each sample until it is at most s / (1 - μ). P comes from a semidefinite program in which a multiplier Π, a quadratic
constraint that the rules meet at samples, stands for them [Boyd et al. 1994, section 8]; it is not believed: both
matrix inequalities are verified with all rounding [Rump 1999].
"""

import math
import warnings
from collections.abc import Mapping
from dataclasses import dataclass
from types import MappingProxyType
from typing import Any, NamedTuple

import numpy as np
from scipy.optimize import root

from fuzzy.extras import install_command
from fuzzy.plugins.loop.controller import LoopError, factor_of, roles_of
from fuzzy.plugins.loop.response import Loop
from fuzzy.plugins.loop.sampledloop import Ball, SampledLoop, ball, sampled_loop
from fuzzy.shown import shown
from fuzzy.system import Sugeno

_END = 1e-6  # of the region's V: where it ends
MOST_STATES = 24  # the semidefinite program takes minutes for 40
_SIZES = (4.0, 2.0, 1.2, 0.7, 0.3, 0.1, 0.03)  # of the inputs' greatest in the step response
_SHARES = {1: (0.98, 0.9, 0.8, 0.5, 0.25)}  # of the rate at rest, by the number of inputs: near it boxes are many
_FEW = (0.6, 0.4, 0.2)  # of it, for more inputs
_SLOW = 0.1  # of it, with which the largest region is looked for
_MARGIN = 0.4  # of what V falls more at rest than is asked: boxes need it, to be few
_SAMPLES, _ROUNDS = 400, 3  # of a candidate; counter-examples are added
_BOXES, _PIECE = 200_000, 4096
_DEADBEAT = 0.05  # the least radius of a loop that is asked for
_NO_FUNCTION = "no quadratic function falls at the samples, however near to its rest"
_INFLATED = 1e-7  # of M, which verification needs


class NotCertified(NamedTuple):
    """Why a loop is not certified."""

    why: str
    box: Mapping[str, tuple[float, float]] = MappingProxyType(
        {}
    )  # of the rules' inputs, by role and in the units of the loop
    direction: Mapping[str, float] = MappingProxyType({})  # of the states from rest, in which V grows most there


@dataclass(frozen=True, eq=False)
class StepCertificate:
    """What starts in V <= 1 stays there, and V(k+1) <= fall · V(k) + (1 - fall) · end.

    Attributes:
        system: The loop.
        P: (n, n), of V = (z - rest)' P (z - rest).
        rest: z* (n,).
        fall: By how much V falls in a sample.
        end: V in the end.
        start: V where the step response begins; the response itself is certified where it is at most 1.
        widths: How far error, rate and sum reach from rest in the region, by role, in the units of the loop.
        fastest: The rate of the loop linearised at rest [1/s], which none exceeds.
        boxes: How many were verified.
    """

    system: SampledLoop
    P: np.ndarray
    rest: np.ndarray
    fall: float
    end: float
    start: float
    widths: Mapping[str, float]
    fastest: float
    boxes: int

    @property
    def rate(self) -> float:
        """The rate with which the errors, √V, fall [1/s]."""
        return -math.log(self.fall) / (2 * self.system.loop.period)

    def level(self, z: np.ndarray) -> np.ndarray:
        """V at states (..., n)."""
        away = z - self.rest
        return np.asarray(np.einsum("...i,ij,...j", away, self.P, away))


def certify_step(
    fis: Sugeno, plant: Any, loop: Loop | None = None, roles: Mapping[str, str] | None = None
) -> StepCertificate | NotCertified:
    """Certify the closed loop of a rule base and a linear plant: that it converges, from where, and how fast.

    Args:
        fis: A rule base whose names say what they are (see :func:`.controller.roles_of`).
        plant: A TransferFunction, or a FunctionPlant that says it is linear.
        loop: Reference, sample time, limits and scale factors; noise and disturbance are taken as none.
        roles: What variables are, by their names, where those do not say it.

    Returns:
        The certificate with the largest region that was found; or why there is none.

    Raises:
        LoopError: A plant or rule base that makes no linear loop, or cvxpy is not installed.
    """
    system = sampled_loop(fis, plant, loop or Loop(), roles_of(fis, roles))
    about = _about_rest(system)
    if isinstance(about, NotCertified):
        return about
    found = NotCertified(_NO_FUNCTION)
    for size in _SIZES:
        other = _certified(about, size, _SLOW)
        if isinstance(other, StepCertificate):
            faster = (_certified(about, size, share) for share in _SHARES.get(len(about.q), _FEW))
            as_large = (
                each for each in faster if isinstance(each, StepCertificate) and each.start <= max(1, other.start)
            )
            return next(as_large, other)
        found = other if other.box else found
    return found


def sentences(found: StepCertificate | NotCertified) -> list[str]:
    """What is proven, or what fails, in sentences."""
    if isinstance(found, NotCertified):
        box = ", ".join(f"{role} {shown(a)} to {shown(b)}" for role, (a, b) in found.box.items())
        way = ", ".join(f"{name} {shown(value)}" for name, value in found.direction.items())
        return [found.why + (f", at {box}" if box else ""), *([f"worst there in the direction {way}"] if way else [])]
    region = ", ".join(f"{role} ±{shown(width)}" for role, width in found.widths.items())
    share = math.sqrt(found.end)
    inside = "inside" if found.start <= 1 else "outside"
    return [
        f"what starts in V <= 1, which reaches to {region} from the loop's rest, never leaves it",
        f"√V, the size of the errors, falls by {shown(found.rate)} 1/s at least, to {share:.2g} of the region "
        f"(linearised at rest: {shown(found.fastest)} 1/s)",
        f"the step response itself starts {inside}: V = {shown(found.start)}",
        f"proven over {found.boxes:,} boxes in intervals rounded outwards, for the plant as given, every start of its "
        "states and of the controls on their way, no noise, and no disturbance",
    ]


class _AtRest(NamedTuple):
    """A loop about its rest, in scaled coordinates ζ / scale, δ / reach, v / push."""

    system: SampledLoop
    rest: np.ndarray  # (n,) z*
    q: np.ndarray  # (m,) q*
    blur: np.ndarray  # (m,) by which q* may differ
    v: np.ndarray  # (p,) φ(q*)
    scale: np.ndarray
    reach: np.ndarray
    push: np.ndarray
    whole: Ball  # [A B] (n, n + p)
    seen: Ball  # C (m, n)
    residual: Ball  # (n, 1) of the rest
    radius: float  # of the loop linearised at rest: the greatest |eigenvalue|


def _about_rest(system: SampledLoop) -> _AtRest | NotCertified:
    """A loop about its rest, which is looked for from where its step response ends."""
    (n, m, p), rows = system.sizes, system.rows
    if n > MOST_STATES:
        raise LoopError(f"the sampled loop has {n} states, at most {MOST_STATES} are certified: sample it more slowly")
    if not m or np.linalg.matrix_rank(rows.mid[n : n + m, :n]) < m:
        raise LoopError("the inputs of the rules do not all follow from the states: no region is certified of them")
    z, guesses = system.start, [system.start]
    for _ in range(system.loop.steps):
        before, z = z, system.advance(z)
        if not abs(z).max(initial=0.0) <= 1e6 * max(1.0, abs(system.loop.reference)):
            break
        guesses[1:] = [z]
        if abs(z - before).max() <= 1e-6 * abs(z).max():
            break
    found = [root(lambda z: np.nan_to_num(system.advance(z) - z, nan=1e6), z, tol=1e-14).x for z in guesses[::-1]]
    rests = [z for z in (*found, guesses[-1]) if abs(system.advance(z) - z).max() <= 1e-9 * max(1.0, abs(z).max())]
    if not rests:
        return NotCertified("no state was found in which the loop rests")
    rest, C, B = rests[0], rows.mid[n : n + m, :n], rows.mid[:n, n : n + p]
    q = C @ rest + rows.mid[n : n + m, -1]
    v, step = system.rules(q), np.array([np.ptp(system.fis.inputs[i].universe) for i in system.moving])
    near = np.diag(1e-6 * step)
    slopes = ((system.rules(q + near) - system.rules(q - near)) / (2e-6 * step[:, None])).T  # (p, m)
    linear = rows.mid[:n, :n] + B @ slopes @ C
    if not np.isfinite(linear).all():
        return NotCertified("no rule fires about the loop's rest")
    values, modes = np.linalg.eig(linear)
    worst = int(abs(values).argmax())
    radius = float(abs(values[worst]))
    if not radius < 1 - 1e-9:
        return NotCertified(
            f"about its rest the loop does not settle: the greatest eigenvalue of its sampled model is {radius:.6g}",
            direction=dict(zip(system.states, modes[:, worst].real.tolist(), strict=True)),
        )
    away = [system.start - rest]
    for _ in range(min(system.loop.steps, 2000)):
        away.append(linear @ away[-1])
    most = abs(np.array(away)).max(axis=0)
    scale = np.maximum(most, 1e-4 * most.max()) if most.max() else np.ones(n)
    reach = np.maximum(abs(np.array(away) @ C.T).max(axis=0), 1e-3 * step)
    push = np.maximum(abs(slopes) @ reach, 1e-6)
    residual = (rows.part(slice(n)) @ ball(np.concatenate([rest, v, [1.0]])[:, None])).plus(ball(rest[:, None]), -1)
    whole, seen = rows.part(slice(n), slice(n + p)), rows.part(slice(n, n + m), slice(n))
    blur = (rows.part(slice(n, n + m)) @ ball(np.concatenate([rest, 0 * v, [1.0]])[:, None])).rad[:, 0]
    return _AtRest(system, rest, q, blur, v, scale, reach, push, whole, seen, residual, radius)


def _certified(about: _AtRest, size: float, share: float) -> StepCertificate | NotCertified:
    """A certificate of one size and rate, whose candidate learns from boxes that fail."""
    fall, m = max(about.radius, _DEADBEAT) ** (2 * share), len(about.q)
    rng = np.random.default_rng(0)
    unit = rng.normal(size=(_SAMPLES, m))
    unit /= np.linalg.norm(unit, axis=1)[:, None]
    delta = unit * np.geomspace(1e-3, 1, _SAMPLES)[:, None] * size * about.reach
    found = NotCertified(_NO_FUNCTION)
    for _ in range(_ROUNDS):
        v = about.system.rules(about.q + delta) - about.v
        if not np.isfinite(v).all():
            return NotCertified("no rule fires", _box(about, delta[~np.isfinite(v).all(axis=1)][:1].repeat(2, axis=0)))
        P = _candidate(about, fall, size, np.hstack([delta, v]), _MARGIN * (1 - share) * (1 - about.radius**2))
        if P is None:
            return found
        done = _verified(about, P, fall)
        if not isinstance(done, tuple):
            return done
        found, more = done
        if not len(more):
            break
        delta = np.vstack([delta, more])
    return found


def _candidate(about: _AtRest, fall: float, size: float, samples: np.ndarray, margin: float) -> np.ndarray | None:
    """P (n, n), so that V falls at samples [δ; v] (N, m + p) and V <= 1 stays within the inputs' reach; or None."""
    try:
        import cvxpy as cp
    except ModuleNotFoundError:
        raise LoopError(f"a certificate needs cvxpy: {install_command('certify')}") from None
    (n, m, p), scale = about.system.sizes, size * about.scale
    bound = np.concatenate([size * about.reach, size * about.push])
    whole = about.whole.mid / scale[:, None] * np.concatenate([scale, bound[m:]])
    C = about.seen.mid * scale / bound[:m, None]
    lift = np.block([[C, np.zeros((m, p))], [np.zeros((p, n)), np.eye(p)]])
    P, multiplier = cp.Variable((n, n), PSD=True), cp.Variable((m + p, m + p), symmetric=True)
    keep = np.eye(n, n + p)
    form = whole.T @ P @ whole - fall * keep.T @ P @ keep + lift.T @ multiplier @ lift
    unit = samples / bound
    rows = np.einsum("ki,kj->kij", unit, unit).reshape(len(unit), -1)
    room = margin * (unit[:, :m] ** 2).sum(axis=1)
    weight = np.sqrt(1 / np.maximum((unit**2).sum(axis=1), 1e-300))
    rules = cp.multiply(weight**2, rows @ cp.reshape(multiplier, (rows.shape[1],), order="C")) >= weight**2 * room
    within = [cp.bmat([[P, c[:, None]], [c[None], np.ones((1, 1))]]) >> 0 for c in C]
    away = (about.system.start - about.rest) / scale
    problem = cp.Problem(
        cp.Minimize(size**2 * cp.quad_form(away, P) + 1e-3 * cp.trace(P)),
        [P >> 1e-7 * np.eye(n), form + form.T << 0, rules, *within],
    )
    with warnings.catch_warnings(action="ignore"):
        try:
            problem.solve(solver="CLARABEL")
        except cp.SolverError:
            return None
    if P.value is None or not np.isfinite(P.value).all():
        return None
    value = P.value * (1 + 1e-6) / np.outer(scale, scale)
    return np.asarray((value + value.T) / 2)


def positive(matrix: Ball) -> bool:
    """Whether a symmetric matrix is positive definite for sure: by Gershgorin's circles, near its eigenvectors."""
    values, vectors = np.linalg.eigh(matrix.mid)
    if not values[0] > 0:
        return False
    turned = ball(vectors / np.sqrt(values))
    near = turned.T @ matrix @ turned
    off = abs(near.mid) + near.rad
    return bool((np.diag(near.mid) - np.diag(near.rad) > off.sum(axis=1) - np.diag(off)).all())


def _verified(about: _AtRest, P: np.ndarray, fall: float) -> StepCertificate | tuple[NotCertified, np.ndarray]:
    """The certificate that a P gives; or the box that fails, with the inputs there, for the next candidate."""
    system, (n, m, p) = about.system, about.system.sizes
    nothing = NotCertified(_NO_FUNCTION), np.empty((0, m))
    S = about.whole.T @ ball(P) @ about.whole
    S = S.plus(Ball(fall * np.pad(P, (0, p)), 4e-16 * abs(np.pad(P, (0, p)))), -1)  # V(k+1) - μ V(k) by [ζ; v]
    lift = Ball(
        *(
            np.block([[c, np.zeros((m, p))], [np.zeros((p, n)), e * np.eye(p)]])
            for c, e in zip(about.seen, (1, 0), strict=True)
        )
    )
    # All ζ with one δ are pinv(C) δ + K η: what is greatest over η
    K = np.linalg.svd(about.seen.mid)[2][m:].T
    behind = -K.T @ S.mid[:n, :n] @ K
    base = np.block([[np.linalg.pinv(about.seen.mid), np.zeros((n, p))], [np.zeros((p, m)), np.eye(p)]])
    if n > m and not np.linalg.eigvalsh(behind)[0] > 0:
        return nothing
    cross = K.T @ S.mid[:n] @ base
    worst = base + np.vstack([K @ np.linalg.solve(behind, cross), np.zeros((p, m + p))])  # [ζ; v] of [δ; v]
    bound = np.concatenate([about.reach, about.push])
    M = worst.T @ S.mid @ worst
    M = (M + M.T) / 2
    M += _INFLATED * np.diag(abs(M * bound[:, None] * bound).max() / bound**2)
    N = np.linalg.inv(about.seen.mid @ np.linalg.solve(P, about.seen.mid.T)) * (1 - 1e-7)
    N = (N + N.T) / 2
    whole, reach = np.sqrt(np.diag(np.linalg.inv(N))) * (1 + 1e-6), ball(np.diag(about.reach))
    unit = np.diag(np.concatenate([about.scale, bound[m:]]))

    def scaled(matrix: Ball, size: int) -> Ball:
        by = ball(unit[:size, :size])
        return by @ matrix @ by

    if not (
        positive(scaled((lift.T @ ball(M) @ lift).plus(S, -1), n + p))
        and np.linalg.eigvalsh(M[m:, m:])[0] > 0
        and positive(scaled(ball(P).plus(about.seen.T @ ball(N) @ about.seen, -1), n))
        and all(positive(reach @ ball(N).plus(ball(np.diag(side), 4), -1) @ reach) for side in np.diag(whole**-2))
    ):
        return nothing
    gap = ball(abs(about.residual.mid) + about.residual.rad)
    away = gap.T @ ball(abs(P)) @ gap
    shift = float((away.mid + away.rad).item()) * 1e9  # (x + r)² <= (1 + 1e-9) x² + (1 + 1e9) r²
    # The integral reaches `room` from its rest, and with v the control stays within the limits
    limits, carried = (-math.inf, math.inf), about.system.rows.mid[-1, :n]
    if not system.clips:
        room = math.sqrt(carried @ np.linalg.solve(P, carried) * (1 + 1e-6))
        if room and not positive(scaled(ball(P).plus(ball(np.outer(carried, carried) / room**2, 4), -1), n)):
            return nothing
        at = float(carried @ about.rest)
        room += 1e-9 * (room + abs(at))
        limits = (system.loop.low - at + room, system.loop.high - at - room)
    most = (1 - fall) * _END
    count, failed = _searched(about, M, N, whole, most, limits)
    if failed is not None:
        low, high = failed
        middle = (low + high) / 2
        corners = np.where(np.array([*np.ndindex(*(2,) * m)]), high, low)
        helps = not _falls(about, M, most, limits, np.stack([middle, middle])[:, None]).all()
        more = np.vstack([corners, middle]) if helps else corners[:0]  # others would need boxes too small
        v = system.rules(about.q + middle) - about.v
        state = worst[:n] @ np.concatenate([middle, v])
        direction = dict(zip(system.states, (state / max(np.sqrt(state @ P @ state), 1e-300)).tolist(), strict=True))
        return NotCertified(_why(about, low, high, limits), _box(about, np.stack([low, high])), direction), more
    fall, most = fall * (1 + 2e-9), most * (1 + 2e-9) + 2 * shift
    end = most / (1 - fall)
    if not end < 1:
        return nothing
    scales = np.array([factor_of(system.loop.scale, system.roles.inputs[i]) for i in system.moving])
    widths = np.sqrt(np.diag(np.linalg.inv(N))) * (1 - 1e-6) / abs(scales)
    names = [system.roles.inputs[i] for i in system.moving]
    start, fastest = system.start - about.rest, -math.log(max(about.radius, 1e-300)) / system.loop.period
    return StepCertificate(
        system,
        P,
        about.rest,
        fall,
        end,
        float(start @ P @ start),
        dict(zip(names, widths.tolist(), strict=True)),
        fastest,
        count,
    )


def _searched(
    about: _AtRest, M: np.ndarray, N: np.ndarray, whole: np.ndarray, most: float, limits: tuple[float, float]
) -> tuple[int, tuple[np.ndarray, np.ndarray] | None]:
    """How many boxes of δ it takes to see [δ; v]'M[δ; v] <= ``most`` wherever δ'Nδ <= 1, which is within ±``whole``;
    or the box that fails."""
    boxes, count = np.stack([-whole, whole])[:, None], 0  # (2, N, m)
    while boxes.size:
        boxes, rest = boxes[:, -_PIECE:], boxes[:, :-_PIECE]
        middle, half = _middles(boxes)
        level = np.einsum("ki,ij,kj->k", middle, N, middle)
        near = level - _around(N, middle @ N, half) <= 1 + 1e-9
        count += int(near.sum())
        near[near] = ~_falls(about, M, most, limits, boxes[:, near])
        boxes, middle, level = boxes[:, near], middle[near], level[near]
        wrong = level <= 1 - 1e-6
        wrong[wrong] = ~_falls(about, M, most, limits, middle[None, wrong].repeat(2, axis=0))
        sides = np.ptp(boxes, axis=0) / whole
        if wrong.any() or (count > _BOXES and len(sides)) or (sides.max(axis=1) < 1e-7).any():
            k = int(np.where(wrong, -level, sides.max(axis=1)).argmin())
            return count, (boxes[0, k], boxes[1, k])
        axis, rows = sides.argmax(axis=1), np.arange(len(sides))
        first, second = boxes.copy(), boxes.copy()
        first[1, rows, axis] = second[0, rows, axis] = middle[rows, axis]
        boxes = np.concatenate([rest, first, second], axis=1)
    return count, None


def _middles(boxes: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """The middles (N, m) of boxes (2, N, m), and how far they reach from these at most."""
    middle = boxes.mean(axis=0)
    return middle, np.ptp(boxes, axis=0) / 2 * (1 + 1e-15) + 4e-16 * abs(middle)


def _around(form: np.ndarray, slope: np.ndarray, half: np.ndarray) -> np.ndarray:
    """By how much a form differs at most over boxes from its value in their middles, where it has half of ``slope``."""
    by: np.ndarray = 2 * (abs(slope) * half).sum(axis=1) + np.einsum("ki,ij,kj->k", half, abs(form), half)
    return by


def _falls(about: _AtRest, M: np.ndarray, most: float, limits: tuple[float, float], boxes: np.ndarray) -> np.ndarray:
    """Over which boxes of δ (2, N, m) the form is at most ``most``, a rule fires, and the control is in its limits."""
    m = boxes.shape[2]
    low, high, holes = _added(about, boxes)
    good = ~holes & (low.sum(axis=1) >= limits[0]) & (high.sum(axis=1) <= limits[1])
    middle, half = _middles(boxes)
    ends = np.stack([low, high]) - about.v
    ends += np.array([-1e-15, 1e-15])[:, None, None] * (abs(ends) + abs(about.v))
    for corner in np.ndindex(*(2,) * len(about.v)):  # it is convex in v
        x = np.hstack([middle, np.stack([ends[side, :, k] for k, side in enumerate(corner)], axis=1)])
        value = np.einsum("ki,ij,kj->k", x, M, x) + _around(M[:m, :m], x @ M[:, :m], half)
        good &= value + 1e-13 * np.einsum("ki,ij,kj->k", abs(x), abs(M), abs(x)) <= most
    return good


def _added(about: _AtRest, boxes: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Bounds of φ over boxes of δ (2, N, m), and where it may be that no rule fires."""
    q = about.q + boxes
    pad = 4e-16 * (abs(about.q) + abs(boxes)) + 2 * about.blur
    return about.system.enclosed(q[0] - pad[0], q[1] + pad[1])


def _box(about: _AtRest, ends: np.ndarray) -> dict[str, tuple[float, float]]:
    """A box of δ (2, m) by the roles of the inputs, in the units of the loop."""
    roles = [about.system.roles.inputs[i] for i in about.system.moving]
    found = np.sort((about.q + ends) / [factor_of(about.system.loop.scale, role) for role in roles], axis=0)
    return {role: (float(a), float(b)) for role, a, b in zip(roles, *found, strict=True)}


def _why(about: _AtRest, low: np.ndarray, high: np.ndarray, limits: tuple[float, float]) -> str:
    """What fails in a box of δ."""
    least, most, holes = _added(about, np.stack([low, high])[:, None])
    if holes.any():
        return "it may be that no rule fires"
    if not (least.sum() >= limits[0] and most.sum() <= limits[1]):
        return "the control may meet its limits, which the integral or the sum then remembers"
    return "V is not seen to fall"
