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
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import lru_cache
from types import MappingProxyType
from typing import Any, Literal

import numpy as np

from fuzzy.compiled.columns import Columns, codes, column, several, within
from fuzzy.compiled.jit import compiled_only
from fuzzy.quantity import quantity, whole
from robotics.laws.equation import EquationLaw, equation
from robotics.laws.setting import Setting
from robotics.laws.tracking.lyapunov import FEED_FORWARD, FeedForward
from robotics.plugins.predictive.discs import AroundColumns, disc_of
from robotics.world.paths.road import moving
from robotics.world.vehicle.plant import velocity_limits

Smoothing = Literal["savitzky-golay", "none"]
_SMOOTHING = codes(Smoothing)
_BLOCK = 16  # samples that are simulated side by side, which the compiler turns into vector instructions
STRIDE = 17  # rows by which the noise moves on from a period to the next
WEIGHTLESS = 1e-17  # a weight that is less changes no sum
FILTER = (59 / 231, 54 / 231, 39 / 231, 14 / 231, -21 / 231)  # Savitzky and Golay 1964: 9 points, a parabola
PAST = 4  # commands that the filter looks back on


class SampledDerived(Columns):
    """What the law makes of its gains and its robot."""

    v_max = column("m/s")
    w_max = column("rad/s")
    per_temperature = column("1", "1/λ")
    gamma_v = column("s²/m²", "γ/σ²")
    gamma_w = column("s²/rad²")
    q_x = column("1/m²")
    q_y = column("1/m²")
    q_heading = column("1/rad²")
    follows = column("1", "the share of a change of the command that the speeds follow in a step")


class SampledMemory(Columns):
    """What the law remembers."""

    past = several(2 * PAST, "m/s, rad/s", "(2, PAST): what the last commands have added to the reference's velocities")
    adds = several(0, "m/s, rad/s", "(2, steps): what the plan adds")


class SampledWork(Columns):
    """A block of samples, and what a plan is made of."""

    x = several(_BLOCK, "m")
    y = several(_BLOCK, "m")
    cos = several(_BLOCK, "1", "of the heading")
    sin = several(_BLOCK, "1")
    v = several(_BLOCK, "m/s")
    w = several(_BLOCK, "rad/s")
    cost = several(_BLOCK, "1")
    around = within(AroundColumns)
    rest = several(0, "", "the reference ahead, its velocities, the plan, its sums, and the costs")


class AheadColumns(Columns):
    """Where the reference is at the end of a step."""

    x = column("m")
    y = column("m")
    cos = column("1", "of the heading")
    sin = column("1")


_AHEAD = AheadColumns.size
# sin h / h and cos h by their series in h²: exact to rounding for |h| <= 1/2
_S1, _S2, _S3, _S4, _S5 = -1 / 6, 1 / 120, -1 / 5040, 1 / 362880, -1 / 39916800
_C1, _C2, _C3, _C4, _C5, _C6 = -1 / 2, 1 / 24, -1 / 720, 1 / 40320, -1 / 3628800, 1 / 479001600
STEEPEST = 1.0  # rad: the most that a robot turns in a step


@lru_cache(maxsize=8)
def perturbations(seed: int, samples: int, steps: int) -> np.ndarray:
    """Standard normal numbers (blocks, steps, 2, _BLOCK): of v and ω, for one of each pair ± of ``samples``."""
    blocks = -(-samples // (2 * _BLOCK))
    bank = np.random.default_rng(seed).standard_normal((blocks, steps, 2, _BLOCK))
    bank.flags.writeable = False
    return bank


def _room_of_plans(steps, noise):  # type: ignore[no-untyped-def]
    """How many numbers of SampledWork.rest plans of so many ``steps`` and numbers of ``noise`` take."""
    return _AHEAD * steps + 2 * steps * (2 + _BLOCK) + noise // steps


room_of_plans = compiled_only(_room_of_plans)


@compiled_only
def _clipped(value, most):  # type: ignore[no-untyped-def]
    value = value if value < most else most
    return value if value > -most else -most


@compiled_only
def _look_ahead(aim, road, path, time, steps, step, ahead, led):  # type: ignore[no-untyped-def]
    """Write where the reference is at the end of each step, and how fast it moves meanwhile: (2, steps) numbers."""
    v, w = aim.v, aim.w
    for t in range(steps):
        x, y, heading, v_then, w_then, _ = moving(road, path, time + (t + 1) * step)
        to = AheadColumns(ahead, t, steps)
        to.x, to.y, to.cos, to.sin = x, y, math.cos(heading), math.sin(heading)
        led[t], led[steps + t] = 0.5 * (v + v_then), 0.5 * (w + w_then)
        v, w = v_then, w_then


@compiled_only
def _shift(adds, steps, by, full, led, plan):  # type: ignore[no-untyped-def]
    """Put the last plan, ``by`` steps on, into (2, steps) numbers: what it adds to the reference's velocities, too."""
    for axis in range(2):
        for t in range(steps):
            place = min(t + by, steps - 1.0)
            k = min(int(place), steps - 2)
            a, b = adds[axis * steps + k], adds[axis * steps + k + 1]
            plan[axis * steps + t] = full * led[axis * steps + t] + a + (place - k) * (b - a)


@compiled_only
def _simulate(steps, first, sign, gain, full, plan, ahead, led, noise, work):  # type: ignore[no-untyped-def]
    """Add up the costs of a block of samples, whose state and cost stand in ``work``."""
    v_max, w_max, follows, step = gain.v_max, gain.w_max, gain.follows, gain.step
    v_std, w_std = sign * gain.v_std, sign * gain.w_std
    q_x, q_y, q_heading = gain.q_x, gain.q_y, 2 * gain.q_heading
    half = 0.5 * step
    xs, ys, coss, sins, vs, ws, costs = work.x, work.y, work.cos, work.sin, work.v, work.w, work.cost
    for t in range(steps):
        at = (t + first) % steps * 2 * _BLOCK
        to = AheadColumns(ahead, t, steps)
        to_x, to_y, cos_d, sin_d = to.x, to.y, to.cos, to.sin
        plan_v, plan_w = plan[t], plan[steps + t]
        pull_v = gain.gamma_v * (plan_v - full * led[t])
        pull_w = gain.gamma_w * (plan_w - full * led[steps + t])
        for n in range(_BLOCK):
            to_v = _clipped(plan_v + v_std * noise[at + n], v_max)
            to_w = _clipped(plan_w + w_std * noise[at + _BLOCK + n], w_max)
            v = vs[n] + follows * (to_v - vs[n])
            w = ws[n] + follows * (to_w - ws[n])
            h = half * w
            q = h * h
            sinc = 1 + q * (_S1 + q * (_S2 + q * (_S3 + q * (_S4 + q * _S5))))
            cos_h = 1 + q * (_C1 + q * (_C2 + q * (_C3 + q * (_C4 + q * (_C5 + q * _C6)))))
            sin_h = h * sinc
            cos_m = coss[n] * cos_h - sins[n] * sin_h  # half-way through the step
            sin_m = sins[n] * cos_h + coss[n] * sin_h
            chord = v * step * sinc
            x, y = xs[n] + chord * cos_m, ys[n] + chord * sin_m
            cos, sin = cos_m * cos_h - sin_m * sin_h, sin_m * cos_h + cos_m * sin_h
            dx, dy = to_x - x, to_y - y
            x_e, y_e = cos_d * dx + sin_d * dy, cos_d * dy - sin_d * dx
            cost = q_x * x_e * x_e + q_y * y_e * y_e + q_heading * (1 - (cos * cos_d + sin * sin_d))
            costs[n] += cost + (pull_v * (to_v - plan_v) + pull_w * (to_w - plan_w))
            xs[n], ys[n], coss[n], sins[n], vs[n], ws[n] = x, y, cos, sin, v, w
        for m in range(int(work.around.count)):
            disc = disc_of(work.around, m)
            there_x, there_y = disc.x + (t + 1) * step * disc.v_x, disc.y + (t + 1) * step * disc.v_y
            weight, per_square = work.around.weight, 1 / (disc.radius * disc.radius)
            for n in range(_BLOCK):
                dx, dy = xs[n] - there_x, ys[n] - there_y
                costs[n] += weight * max(1 - (dx * dx + dy * dy) * per_square, 0.0)


@compiled_only
def _cost_all(robot, gain, steps, blocks, first, full, plan, ahead, led, noise, costs, work):  # type: ignore[no-untyped-def]
    """Put the cost of every sample into (blocks, 2, _BLOCK) numbers, and return the least."""
    cos, sin = math.cos(robot.heading), math.sin(robot.heading)
    least = math.inf
    for b in range(2 * blocks):
        for n in range(_BLOCK):
            work.x[n], work.y[n], work.cos[n], work.sin[n] = robot.x, robot.y, cos, sin
            work.v[n], work.w[n], work.cost[n] = robot.v, robot.w, 0.0
        own = noise[b // 2 * steps * 2 * _BLOCK :]
        _simulate(steps, first, 1.0 - 2.0 * (b % 2), gain, full, plan, ahead, led, own, work)
        for n in range(_BLOCK):
            inside = 2 * (b // 2 * _BLOCK + n) < gain.samples
            costs[b * _BLOCK + n] = work.cost[n] if inside else math.inf
            least = min(least, costs[b * _BLOCK + n])
    return least


@compiled_only
def _average(gain, steps, blocks, first, least, plan, noise, costs, total):  # type: ignore[no-untyped-def]
    """Make the plan the mean of all samples, each with its weight."""
    weights = 0.0
    for n in range(2 * steps * _BLOCK):
        total[n] = 0.0
    for b in range(2 * blocks):
        most = 0.0
        for n in range(b * _BLOCK, (b + 1) * _BLOCK):
            costs[n] = math.exp((least - costs[n]) * gain.per_temperature)
            weights += costs[n]
            most = max(most, costs[n])
        if most < WEIGHTLESS:
            continue
        own, weight = noise[b // 2 * steps * 2 * _BLOCK :], costs[b * _BLOCK :]
        for axis in range(2):
            bound = gain.v_max if axis == 0 else gain.w_max
            std = (1.0 - 2.0 * (b % 2)) * (gain.v_std if axis == 0 else gain.w_std)
            for t in range(steps):
                at, to = ((t + first) % steps * 2 + axis) * _BLOCK, (axis * steps + t) * _BLOCK
                planned = plan[axis * steps + t]
                for n in range(_BLOCK):
                    total[to + n] += weight[n] * _clipped(planned + std * own[at + n], bound)
    for t in range(2 * steps):
        mean = 0.0
        for n in range(_BLOCK):
            mean += total[t * _BLOCK + n]
        plan[t] = mean / weights


@compiled_only
def _remember(memory, steps, smoothing, full, led, plan):  # type: ignore[no-untyped-def]
    """Keep, smoothed, what the plan adds to the reference's velocities."""
    past, adds = memory.past, memory.adds
    for axis in range(2):
        base = axis * steps
        for t in range(steps):
            plan[base + t] -= full * led[base + t]
        for t in range(steps):
            found = FILTER[0] * plan[base + t]
            for k in range(1, PAST + 1):
                before = plan[base + t - k] if t >= k else past[axis * PAST + PAST + t - k]
                found += FILTER[k] * (before + plan[base + min(t + k, steps - 1)])
            adds[base + t] = found if smoothing == _SMOOTHING.savitzky_golay else plan[base + t]


@equation
def average_plans(robot, aim, gain, memory, command, work, road, path, rules, time, dt):  # type: ignore[no-untyped-def]
    """Command the beginning of the average of the sampled plans, whose noise stands in the rules."""
    steps = int(gain.steps)
    ahead, led = work.rest[: _AHEAD * steps], work.rest[_AHEAD * steps :]
    work.around.count = 0.0
    _look_ahead(aim, road, path, time, steps, gain.step, ahead, led)
    send_average(robot, gain, memory, command, work, rules, time, dt)


@compiled_only
def send_average(robot, gain, memory, command, work, noise, time, dt):  # type: ignore[no-untyped-def]
    """Improve the plan of the period before, remember it, and command its beginning; ``work`` has the reference."""
    steps, sent = int(gain.steps), int(gain.sent)
    full = 1.0 if gain.feed_forward == FEED_FORWARD.full else 0.0
    blocks = len(noise) // (steps * 2 * _BLOCK)
    ahead, rest = work.rest[: _AHEAD * steps], work.rest[_AHEAD * steps :]
    led, rest = rest[: 2 * steps], rest[2 * steps :]
    plan, rest = rest[: 2 * steps], rest[2 * steps :]
    total, costs = rest[: 2 * steps * _BLOCK], rest[2 * steps * _BLOCK :]
    first = round(time / dt) * STRIDE % steps
    _shift(memory.adds, steps, dt / gain.step, full, led, plan)
    least = _cost_all(robot, gain, steps, blocks, first, full, plan, ahead, led, noise, costs, work)
    _average(gain, steps, blocks, first, least, plan, noise, costs, total)
    _remember(memory, steps, gain.smoothing, full, led, plan)
    past, adds = memory.past, memory.adds
    for axis in range(2):
        for k in range(PAST - 1):
            past[axis * PAST + k] = past[axis * PAST + k + 1]
        past[axis * PAST + PAST - 1] = adds[axis * steps + sent]
    command.first = command.wish_v = _clipped(full * led[sent] + adds[sent], gain.v_max)
    command.second = command.wish_w = _clipped(full * led[steps + sent] + adds[steps + sent], gain.w_max)


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
    smoothing: Smoothing = "savitzky-golay"
    feed_forward: FeedForward = "full"  # none: plans begin at rest, and γ weighs them as a whole
    seed: int = whole(0, least=0, doc="The seed of the perturbations, which all runs share.")

    equation, sort_of_law = average_plans, "predictive"
    barred = MappingProxyType({"lead": "it reads its reference ahead by its own model"})
    works, derived, remembers = SampledWork, SampledDerived, SampledMemory

    @property
    def knows(self) -> tuple[str, ...]:
        """The reference ahead in time; the wheels where its model has their lag."""
        known = ("reference", "reference velocity", "preview")
        return (*known, "wheel speeds", "wheel lag") if self.lag > 0 else known

    def derive(self, setting: Setting) -> Mapping[str, Any]:
        """The bounds, and what weighs in the cost."""
        v_max, w_max, _, _ = velocity_limits(setting.robots)
        return {
            "v_max": v_max,
            "w_max": np.minimum(w_max, STEEPEST / self.step),
            "per_temperature": 1 / self.temperature,
            "gamma_v": self.gamma / self.v_std**2,
            "gamma_w": self.gamma / self.w_std**2,
            "q_x": self.x_scale**-2,
            "q_y": self.y_scale**-2,
            "q_heading": self.heading_scale**-2,
            "follows": -math.expm1(-self.step / self.lag) if self.lag > 0 else 1.0,
        }

    def rule_rows(self) -> Sequence[np.ndarray]:
        """The perturbations."""
        return (perturbations(self.seed, self.samples, self.steps).ravel(),)

    def begin(self, setting: Setting, runs: int) -> np.ndarray:
        """Begin with plans that add nothing to the reference's velocities."""
        return np.zeros((SampledMemory.size + 2 * self.steps, runs, len(setting.robots)))

    @property
    def working(self) -> int:
        """A block of samples, the reference ahead, the plan, its sums, and the costs."""
        return SampledWork.size + _room_of_plans(self.steps, perturbations(self.seed, self.samples, self.steps).size)
