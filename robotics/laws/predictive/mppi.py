"""Model predictive path integral control, MPPI, of a robot that tracks its reference: sampled plans, averaged.

In every period the plan of the one before, U = (v, ω) of each step of the horizon, is shifted, and perturbed by normal
noise with the deviations σ. A unicycle is simulated along each perturbed plan V, and with its cost S the new plan is

    S = Σ (x_e/X)² + (y_e/Y)² + 2 (1 − cos ψ_e)/Ψ²  +  γ Σ (U − u_d)ᵀ Σ_σ⁻¹ (V − U)
    U ← Σ w V / Σ w,    w = exp(−(S − min S) / λ)                        (Williams et al. 2017; Nav2's mppi optimizer)

with the errors from the reference at each step's end in its own frame, Bryson's scales X, Y, Ψ, and u_d = (v_d, ω_d) of
the reference, which is where a robot on its path would find its plan: the feed-forward. So γ weighs what a plan adds to
it, where Nav2's weighs the plan. The plan is then smoothed by Nav2's filter, that of Savitzky and Golay over 9 steps.

As in Nav2: 56 steps of 0.05 s, one iteration a period, γ = 0.015, σ = 0.2 m/s and 0.4 rad/s, commands clipped before
they are simulated and averaged, a plan shifted by what a period lasts, and its second step sent, since a command acts a
period late. Not as in Nav2:

* One cost, of tracking a reference in time, in place of its critics of paths, goals and obstacles. The temperature goes
  with the cost: λ = 1 is one error of its scale in one step, and on a straight path, at 0.3 m/s, 41 of 1,000 samples
  count, as (Σ w)² / Σ w² has it. With Nav2's 0.3 they are 8, and the plan is as noisy as that.
* 1,000 samples, its built-in number, and not the 2,000 of its example: they take half the time, and on the circle and
  the sine of the Lyapunov law's tests lose 0.1 mm of some 0.8 mm of error. 500 lose 0.5 mm and vary ω by a quarter
  more; with 250 the error is three times as large, and some runs leave their path again for a while.
* The unicycle goes along exact arcs, Nav2's in straight pieces. With ``lag`` its speeds follow commands as a
  first-order lag from those that the encoders tell; by default there is none, as in Nav2. What both wheels together can
  do is not in the model, only the bounds of each speed; and no more than a turn of 1 rad in a step.
* The perturbations are drawn once, from ``seed``, and all robots, runs and laws use the same: differences between runs
  are those of the runs. They come in pairs ± and so have the mean 0. From period to period the rows of one horizon's
  noise change their places, so that a period's noise is not the last one's; it is the same again after ``steps``.

No proof of stability is known. It knows the reference ahead in time; with ``lag`` also the wheel speeds and their lag.
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass
from functools import lru_cache
from typing import Any, Literal

import numpy as np

from fuzzy.compiled.jit import inner
from robotics.laws.equation import (
    AT_V,
    AT_W,
    FIRST,
    HEADING,
    WISH_V,
    EquationLaw,
    V,
    W,
    X,
    Y,
    equation,
)
from robotics.laws.law import ControllerError
from robotics.laws.setting import Setting
from robotics.paths.road import moving
from robotics.quantity import check_quantities, quantity, whole
from robotics.vehicle.plant import velocity_limits

# Places of the gains
(
    V_MAX, W_MAX, SAMPLES, STEPS, STEP, V_STD, W_STD, PER_TEMPERATURE, GAMMA_V, GAMMA_W,
    Q_X, Q_Y, Q_HEADING, FOLLOWS, SENT, SMOOTH, FULL,
) = range(17)  # fmt: skip
BLOCK = 16  # samples that are simulated side by side, which the compiler turns into vector instructions
STRIDE = 17  # rows by which the noise moves on from a period to the next
WEIGHTLESS = 1e-17  # a weight that is less changes no sum
FILTER = (59 / 231, 54 / 231, 39 / 231, 14 / 231, -21 / 231)  # Savitzky and Golay 1964: 9 points, a parabola
PAST = 4  # commands that the filter looks back on
# Places in what a block of samples works in, BLOCK numbers each
_X, _Y, _COS, _SIN, _V, _W, _COST = (BLOCK * n for n in range(7))
_STATE = 7 * BLOCK
# sin h / h and cos h by their series in h²: exact to rounding for |h| <= 1/2
_S1, _S2, _S3, _S4, _S5 = -1 / 6, 1 / 120, -1 / 5040, 1 / 362880, -1 / 39916800
_C1, _C2, _C3, _C4, _C5, _C6 = -1 / 2, 1 / 24, -1 / 720, 1 / 40320, -1 / 3628800, 1 / 479001600
STEEPEST = 1.0  # rad: the most that a robot turns in a step


@lru_cache(maxsize=8)
def perturbations(seed: int, samples: int, steps: int) -> np.ndarray:
    """Standard normal numbers (blocks, steps, 2, BLOCK): of v and ω, for one of each pair ± of ``samples``."""
    blocks = -(-samples // (2 * BLOCK))
    bank = np.random.default_rng(seed).standard_normal((blocks, steps, 2, BLOCK))
    bank.flags.writeable = False
    return bank


@inner
def _clipped(value, most):  # type: ignore[no-untyped-def]
    value = value if value < most else most
    return value if value > -most else -most


@inner
def _look_ahead(i, known, steps, step, reference):  # type: ignore[no-untyped-def]
    """Put where the reference is at the end of each step, and how fast it moves meanwhile, into (6, steps) numbers."""
    v, w = known.seen[AT_V, i], known.seen[AT_W, i]
    for t in range(steps):
        x, y, heading, v_then, w_then, _ = moving(known.road, known.path[i], known.time + (t + 1) * step)
        reference[t], reference[steps + t] = x, y
        reference[2 * steps + t], reference[3 * steps + t] = math.cos(heading), math.sin(heading)
        reference[4 * steps + t], reference[5 * steps + t] = 0.5 * (v + v_then), 0.5 * (w + w_then)
        v, w = v_then, w_then


@inner
def _shift(i, memory, steps, by, full, reference, plan):  # type: ignore[no-untyped-def]
    """Put the last plan, ``by`` steps on, into (2, steps) numbers: what it adds to the reference's velocities, too."""
    for axis in range(2):
        for t in range(steps):
            place = min(t + by, steps - 1.0)
            k = min(int(place), steps - 2)
            a, b = memory[axis * steps + k, i], memory[axis * steps + k + 1, i]
            plan[axis * steps + t] = full * reference[(4 + axis) * steps + t] + a + (place - k) * (b - a)


@inner
def _simulate(steps, first, sign, gains, g, plan, reference, noise, work):  # type: ignore[no-untyped-def]
    """Add up the costs of a block of samples, whose state and cost stand in ``work``."""
    v_max, w_max, follows, step = gains[V_MAX, g], gains[W_MAX, g], gains[FOLLOWS, g], gains[STEP, g]
    v_std, w_std = sign * gains[V_STD, g], sign * gains[W_STD, g]
    q_x, q_y, q_heading = gains[Q_X, g], gains[Q_Y, g], 2 * gains[Q_HEADING, g]
    half = 0.5 * step
    for t in range(steps):
        at = (t + first) % steps * 2 * BLOCK
        to_x, to_y, cos_d, sin_d = (
            reference[t], reference[steps + t], reference[2 * steps + t], reference[3 * steps + t],
        )  # fmt: skip
        plan_v, plan_w = plan[t], plan[steps + t]
        pull_v = gains[GAMMA_V, g] * (plan_v - gains[FULL, g] * reference[4 * steps + t])
        pull_w = gains[GAMMA_W, g] * (plan_w - gains[FULL, g] * reference[5 * steps + t])
        for n in range(BLOCK):
            to_v = _clipped(plan_v + v_std * noise[at + n], v_max)
            to_w = _clipped(plan_w + w_std * noise[at + BLOCK + n], w_max)
            v = work[_V + n] + follows * (to_v - work[_V + n])
            w = work[_W + n] + follows * (to_w - work[_W + n])
            h = half * w
            q = h * h
            sinc = 1 + q * (_S1 + q * (_S2 + q * (_S3 + q * (_S4 + q * _S5))))
            cos_h = 1 + q * (_C1 + q * (_C2 + q * (_C3 + q * (_C4 + q * (_C5 + q * _C6)))))
            sin_h = h * sinc
            cos_m = work[_COS + n] * cos_h - work[_SIN + n] * sin_h  # half-way through the step
            sin_m = work[_SIN + n] * cos_h + work[_COS + n] * sin_h
            chord = v * step * sinc
            x, y = work[_X + n] + chord * cos_m, work[_Y + n] + chord * sin_m
            cos, sin = cos_m * cos_h - sin_m * sin_h, sin_m * cos_h + cos_m * sin_h
            dx, dy = to_x - x, to_y - y
            x_e, y_e = cos_d * dx + sin_d * dy, cos_d * dy - sin_d * dx
            cost = q_x * x_e * x_e + q_y * y_e * y_e + q_heading * (1 - (cos * cos_d + sin * sin_d))
            work[_COST + n] += cost + (pull_v * (to_v - plan_v) + pull_w * (to_w - plan_w))
            work[_X + n], work[_Y + n], work[_COS + n], work[_SIN + n] = x, y, cos, sin
            work[_V + n], work[_W + n] = v, w


@inner
def _cost_all(i, known, steps, blocks, first, plan, reference, costs, work):  # type: ignore[no-untyped-def]
    """Put the cost of every sample into (blocks, 2, BLOCK) numbers, and return the least."""
    gains, g, seen, noise = known.gains, known.column[i], known.seen, known.rules[known.base[i]]
    cos, sin = math.cos(seen[HEADING, i]), math.sin(seen[HEADING, i])
    least = math.inf
    for b in range(2 * blocks):
        for n in range(BLOCK):
            work[_X + n], work[_Y + n], work[_COS + n], work[_SIN + n] = seen[X, i], seen[Y, i], cos, sin
            work[_V + n], work[_W + n], work[_COST + n] = seen[V, i], seen[W, i], 0.0
        own = noise[b // 2 * steps * 2 * BLOCK :]
        _simulate(steps, first, 1.0 - 2.0 * (b % 2), gains, g, plan, reference, own, work)
        for n in range(BLOCK):
            inside = 2 * (b // 2 * BLOCK + n) < gains[SAMPLES, g]
            costs[b * BLOCK + n] = work[_COST + n] if inside else math.inf
            least = min(least, costs[b * BLOCK + n])
    return least


@inner
def _average(i, known, steps, blocks, first, least, plan, costs, total):  # type: ignore[no-untyped-def]
    """Make the plan the mean of all samples, each with its weight."""
    gains, g, noise = known.gains, known.column[i], known.rules[known.base[i]]
    weights = 0.0
    for n in range(2 * steps * BLOCK):
        total[n] = 0.0
    for b in range(2 * blocks):
        most = 0.0
        for n in range(b * BLOCK, (b + 1) * BLOCK):
            costs[n] = math.exp((least - costs[n]) * gains[PER_TEMPERATURE, g])
            weights += costs[n]
            most = max(most, costs[n])
        if most < WEIGHTLESS:
            continue
        own, weight = noise[b // 2 * steps * 2 * BLOCK :], costs[b * BLOCK :]
        for axis in range(2):
            bound, std = gains[V_MAX + axis, g], (1.0 - 2.0 * (b % 2)) * gains[V_STD + axis, g]
            for t in range(steps):
                at, to = ((t + first) % steps * 2 + axis) * BLOCK, (axis * steps + t) * BLOCK
                planned = plan[axis * steps + t]
                for n in range(BLOCK):
                    total[to + n] += weight[n] * _clipped(planned + std * own[at + n], bound)
    for t in range(2 * steps):
        mean = 0.0
        for n in range(BLOCK):
            mean += total[t * BLOCK + n]
        plan[t] = mean / weights


@inner
def _remember(i, memory, steps, smooth, full, reference, plan):  # type: ignore[no-untyped-def]
    """Keep, smoothed, what the plan adds to the reference's velocities."""
    for axis in range(2):
        base, past = axis * steps, 2 * steps + axis * PAST
        for t in range(steps):
            plan[base + t] -= full * reference[(4 + axis) * steps + t]
        for t in range(steps):
            found = FILTER[0] * plan[base + t]
            for k in range(1, PAST + 1):
                before = plan[base + t - k] if t >= k else memory[past + PAST + t - k, i]
                found += FILTER[k] * (before + plan[base + min(t + k, steps - 1)])
            memory[base + t, i] = found if smooth > 0 else plan[base + t]


@equation
def average_plans(i, known, memory, command, work):  # type: ignore[no-untyped-def]
    """Command the beginning of the average of the sampled plans."""
    gains, g = known.gains, known.column[i]
    steps, full, sent = int(gains[STEPS, g]), gains[FULL, g], int(gains[SENT, g])
    blocks = known.rules.shape[1] // (steps * 2 * BLOCK)
    reference, rest = work[_STATE : _STATE + 6 * steps], work[_STATE + 6 * steps :]
    ends = 2 * steps, 2 * steps * (1 + BLOCK)
    plan, total, costs = rest[: ends[0]], rest[ends[0] : ends[1]], rest[ends[1] :]
    first = round(known.time / known.dt) * STRIDE % steps
    _look_ahead(i, known, steps, gains[STEP, g], reference)
    _shift(i, memory, steps, known.dt / gains[STEP, g], full, reference, plan)
    least = _cost_all(i, known, steps, blocks, first, plan, reference, costs, work)
    _average(i, known, steps, blocks, first, least, plan, costs, total)
    _remember(i, memory, steps, gains[SMOOTH, g], full, reference, plan)
    for axis in range(2):
        past = 2 * steps + axis * PAST
        adds = memory[axis * steps + sent, i]
        for k in range(PAST - 1):
            memory[past + k, i] = memory[past + k + 1, i]
        memory[past + PAST - 1, i] = adds
        value = full * reference[(4 + axis) * steps + sent] + adds
        command[FIRST + axis, i] = command[WISH_V + axis, i] = _clipped(value, gains[V_MAX + axis, g])


@dataclass(frozen=True, kw_only=True)
class PathIntegral(EquationLaw):
    """Model predictive path integral control: its samples, its horizon, its noise, and what weighs errors."""

    samples: int = whole(1000, least=2, most=100_000, doc="The number of plans that are simulated in a period.")
    steps: int = whole(56, least=5, most=1000, doc="The number of steps of the horizon.")
    step: float = quantity(0.05, "s", above=0, most=1)  # with steps: a horizon of 2.8 s
    v_std: float = quantity(0.2, "m/s", above=0)  # σ
    w_std: float = quantity(0.4, "rad/s", above=0)
    temperature: float = quantity(1.0, "1", above=0)  # λ
    gamma: float = quantity(0.015, "1", least=0)  # γ
    # Errors that weigh alike; those of the linear-quadratic regulator
    x_scale: float = quantity(0.1, "m", above=0)
    y_scale: float = quantity(0.1, "m", above=0)
    heading_scale: float = quantity(0.5, "rad", above=0)
    lag: float = quantity(0.0, "s", least=0, most=10)  # of the wheels, in the model
    sent: int = whole(1, least=0, most=4, doc="Which step of the plan is sent: 0 is the first.")
    smoothing: Literal["savitzky-golay", "none"] = "savitzky-golay"
    feed_forward: Literal["full", "none"] = "full"  # none: plans begin at rest, and γ weighs them as a whole
    seed: int = whole(0, least=0, doc="The seed of the perturbations, which all runs share.")

    def __post_init__(self) -> None:
        check_quantities(self, ControllerError)

    equation = average_plans

    @property
    def knows(self) -> tuple[str, ...]:
        """The reference ahead in time; the wheels where its model has their lag."""
        known = ("reference", "reference velocity", "preview")
        return (*known, "wheel speeds", "wheel lag") if self.lag > 0 else known

    def gain_rows(self, setting: Setting) -> Sequence[Any]:
        """The numbers of the equation, in the order of the places above."""
        v_max, w_max, _, _ = velocity_limits(setting.robots)
        noise = self.v_std, self.w_std, 1 / self.temperature, self.gamma / self.v_std**2, self.gamma / self.w_std**2
        weights = (scale**-2 for scale in (self.x_scale, self.y_scale, self.heading_scale))
        follows = -math.expm1(-self.step / self.lag) if self.lag > 0 else 1.0
        options = self.sent, self.smoothing != "none", self.feed_forward == "full"
        bounds = v_max, np.minimum(w_max, STEEPEST / self.step)
        return *bounds, self.samples, self.steps, self.step, *noise, *weights, follows, *map(float, options)

    def rule_rows(self) -> Sequence[np.ndarray]:
        """The perturbations."""
        return (perturbations(self.seed, self.samples, self.steps).ravel(),)

    def begin(self, setting: Setting, runs: int) -> np.ndarray:
        """Begin with plans that add nothing to the reference's velocities."""
        return np.zeros((2 * (self.steps + PAST), runs, len(setting.robots)))

    @property
    def working(self) -> int:
        """A block of samples, the reference ahead, the plan, its sums, and the costs."""
        samples = perturbations(self.seed, self.samples, self.steps).shape[0] * 2 * BLOCK
        return _STATE + 6 * self.steps + 2 * self.steps * (1 + BLOCK) + samples
