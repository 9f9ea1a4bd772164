"""Nonlinear model predictive control of a differential drive: every period the best plan of the next ones.

The law simulates a model of its robot (:mod:`robotics.laws.predictive.model`) over ``horizon`` control periods and
sends the first command of the plan that costs least (:mod:`robotics.laws.predictive.ilqr`):

    J = Σ_k ½ [(along/a)² + (cross/c)² + (2 sin(ψ_e/2)/ψ)² + ((v_c − v_r)/v)² + ((ω_c − ω_r)/ω)² + |Δu/Δ|²] + ½ e' P e

where a, c, ψ, v, ω, Δ are the scales of the class: by Bryson's rule the deviations that weigh alike [Bryson & Ho 1975,
5.2], by default those of :mod:`robotics.laws.tracking.pdc`, and for the wheels 1 m/s² in periods of 50 ms, about a
fifth of what an EtsRo's can do. Δu is the change of both wheels' speeds from the command before, and P the terminal
cost (:mod:`robotics.laws.predictive.terminal`). A period of the plan is a control period: its commands are those that
will be sent, so that the bounds of their change and the latency are what they are, and each plan is the first guess of
the next. Bounds: what the plant makes of a command (v_max, ω_max, the speed of the wheels, and (5.1) where a robot has
it), and a change a period of each wheel that its motor can follow.

What it knows: the reference from now to the end of the horizon (position, heading, velocity, curvature), the wheel
speeds by the encoders, the lag of the wheels, and the latency with the commands that are still to act. The pose is
predicted over the latency first. (v_r, ω_r) is the reference's velocity in the middle of a period, and τ later, since
the wheels follow that much later.

A real-time iteration [Diehl, Bock & Schlöder 2005]: ``iterations`` steps at most from the plan of the period before,
shifted by one; fewer where there is nothing to gain. With many it is the converged plan.

Left out: an estimate of the pose beyond what is measured, so that its noise enters; other robots and obstacles.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, Literal

import numpy as np

from fuzzy.compiled.jit import inner
from robotics.laws.equation import (
    FIRST,
    HEADING,
    SECOND,
    WISH_V,
    WISH_W,
    EquationLaw,
    V,
    W,
    X,
    Y,
    equation,
)
from robotics.laws.law import ControllerError
from robotics.laws.predictive.ilqr import (
    AT_END_V,
    AT_END_W,
    COST,
    FIXED,
    FROM_V,
    FROM_W,
    NODE,
    NODES,
    PLAN,
    STATE,
    TAIL,
    TAIL_NUMBERS,
    TO_COS,
    TO_HEADING,
    TO_SIN,
    TO_V,
    TO_W,
    TO_X,
    TO_Y,
    V_C,
    W_C,
    solve,
    working,
)
from robotics.laws.predictive.model import moved, response, velocity_shares, wheel_lag, wheel_rate
from robotics.laws.predictive.terminal import SPEEDS, Weights, tail_table
from robotics.laws.setting import Setting
from robotics.paths.road import moving
from robotics.quantity import check_quantities, quantity, whole
from robotics.vehicle.plant import STEP, velocity_limits
from robotics.vehicle.robot import Robot

# Places of the gains: first those of the solver, then
HORIZON, ITERATIONS, TOLERANCE = range(FIXED, FIXED + 3)
LATENCY, LEAD, PERIODS = range(FIXED + 3, FIXED + 6)  # s; s, of the reference's velocity; whole periods of latency
MEAN, OLDER, NEWER = range(FIXED + 6, FIXED + 9)  # robotics.laws.predictive.model.Shares
PART = FIXED + 9  # (5,) the response over the part of a period by which the latency is longer than PERIODS
TABLE = FIXED + 14  # (SPEEDS, 17) of the terminal cost
# Places of what is remembered: whether there is a plan; the commands that were sent, the oldest first, then the plan
STARTED, SENT = 0, 1
CONVERGED = 1e-7  # of the cost: with less to gain a plan is left as it is


@inner
def forecast(i, known, memory, work):  # type: ignore[no-untyped-def]
    """Write the state of lane ``i`` at which the next command begins to act, and the command before it."""
    seen, gains, g = known.seen, known.gains, known.column[i]
    v = gains[MEAN, g] * seen[V, i] + gains[OLDER, g] * memory[SENT, i] + gains[NEWER, g] * memory[SENT + 2, i]
    w = gains[MEAN, g] * seen[W, i] + gains[OLDER, g] * memory[SENT + 1, i] + gains[NEWER, g] * memory[SENT + 3, i]
    x, y, heading = seen[X, i], seen[Y, i], seen[HEADING, i]
    late = int(gains[PERIODS, g])
    for n in range(late + 1):
        at = 0 if n > 0 else PART
        sent = SENT + 2 + 2 * n
        x, y, heading, v, w, _, _, _ = moved(
            x, y, heading, v, w, memory[sent, i], memory[sent + 1, i],
            gains[at, g], gains[at + 1, g], gains[at + 2, g], gains[at + 3, g], gains[at + 4, g],
        )  # fmt: skip
    last = SENT + 2 + 2 * late
    work[FROM_V], work[FROM_W] = memory[last, i], memory[last + 1, i]
    work[STATE], work[STATE + 1], work[STATE + 2], work[STATE + 3], work[STATE + 4] = x, y, heading, v, w


@inner
def preview(i, known, horizon, work):  # type: ignore[no-untyped-def]
    """Write where the reference of lane ``i`` is at the ends of all periods, its velocities, and the terminal cost."""
    gains, g, road, path = known.gains, known.column[i], known.road, known.path[i]
    begin, lead = known.time + gains[LATENCY, g], gains[LEAD, g] + 0.5 * known.dt
    for k in range(horizon + 1):
        at, time = NODES + NODE * k, begin + k * known.dt
        _, _, _, work[at + TO_V], work[at + TO_W], _ = moving(road, path, time + lead)
        x, y, heading, v, w, _ = moving(road, path, time + known.dt if k < horizon else time)
        work[at + TO_X], work[at + TO_Y], work[at + TO_HEADING] = x, y, heading
        work[at + TO_COS], work[at + TO_SIN] = np.cos(heading), np.sin(heading)
        work[AT_END_V], work[AT_END_W] = v, w
    row, width = 0, TAIL_NUMBERS + 1
    while row < SPEEDS - 2 and v > gains[TABLE + width * (row + 1), g]:
        row += 1
    low = TABLE + width * row
    high = low + width
    share = (v - gains[low, g]) / (gains[high, g] - gains[low, g])
    share = min(max(share, 0.0), 1.0)
    for n in range(TAIL_NUMBERS):
        work[TAIL + n] = gains[low + 1 + n, g] + share * (gains[high + 1 + n, g] - gains[low + 1 + n, g])


@equation
def predict(i, known, memory, command, work):  # type: ignore[no-untyped-def]
    """Send the first command of the best plan."""
    gains, g = known.gains, known.column[i]
    horizon, plan = int(gains[HORIZON, g]), SENT + 4 + 2 * int(gains[PERIODS, g])
    for n in range(FIXED):
        work[n] = gains[n, g]
    forecast(i, known, memory, work)
    preview(i, known, horizon, work)
    for k in range(horizon):
        at = NODES + NODE * k
        ready = memory[STARTED, i] > 0 and k < horizon - 1
        work[at + PLAN + V_C] = memory[plan + 2 * k + 2, i] if ready else np.nan
        work[at + PLAN + W_C] = memory[plan + 2 * k + 3, i] if ready else np.nan
    solve(work, horizon, gains[ITERATIONS, g], gains[TOLERANCE, g])
    for k in range(horizon):
        memory[plan + 2 * k, i] = work[NODES + NODE * k + PLAN + V_C]
        memory[plan + 2 * k + 1, i] = work[NODES + NODE * k + PLAN + W_C]
    for n in range(SENT, plan - 2):
        memory[n, i] = memory[n + 2, i]
    memory[STARTED, i] = 1.0 if np.isfinite(work[COST]) else 0.0
    v, w = memory[plan, i], memory[plan + 1, i]
    memory[plan - 2, i], memory[plan - 1, i] = v, w
    command[FIRST, i] = command[WISH_V, i] = v
    command[SECOND, i] = command[WISH_W, i] = w


@dataclass(frozen=True, kw_only=True)
class PredictiveControl(EquationLaw):
    """Nonlinear model predictive control: the scales of errors and commands that weigh alike, and how far it plans."""

    along_scale: float = quantity(0.1, "m", least=1e-3, most=1e3)
    cross_scale: float = quantity(0.1, "m", least=1e-3, most=1e3)
    heading_scale: float = quantity(0.5, "rad", least=1e-3, most=1e3)
    v_scale: float = quantity(0.2, "m/s", least=1e-3, most=1e3)
    w_scale: float = quantity(1.0, "rad/s", least=1e-3, most=1e3)
    change_scale: float = quantity(0.05, "m/s", least=1e-3, most=1e3)  # of a wheel's speed, from one period to the next
    horizon: int = whole(20, least=2, most=200, doc="Control periods that it plans ahead.")
    iterations: int = whole(3, least=1, most=200, doc="Steps of the solver a period, at most; 50: until it converges.")
    wheel_lag: Literal["modelled", "ignored"] = "modelled"  # ignored: the wheels are taken to follow at once
    latency: Literal["modelled", "ignored"] = "modelled"  # ignored: commands are taken to act at once

    def __post_init__(self) -> None:
        check_quantities(self, ControllerError)

    equation = predict

    @property
    def knows(self) -> tuple[str, ...]:
        """What it uses: of wheels and latency only what its model has."""
        always = "reference", "reference velocity", "curvature", "preview"
        lag = ("wheel speeds", "wheel lag") if self.wheel_lag == "modelled" else ()
        return *always, *lag, *(("latency",) if self.latency == "modelled" else ())

    @property
    def working(self) -> int:
        """The numbers that a plan is made in."""
        return working(self.horizon)

    def begin(self, setting: Setting, runs: int) -> np.ndarray:
        """No plan, and robots at rest whose earlier commands were 0."""
        periods, _ = self._late(setting)
        return np.zeros((SENT + 2 * (periods + 2) + 2 * self.horizon, runs, len(setting.robots)))

    def gain_rows(self, setting: Setting) -> Sequence[Any]:
        """The numbers of the equation, in the order of the places above; each (robots,)."""
        return list(np.transpose([self._numbers(setting, robot) for robot in setting.robots]))

    def weights(self, robot: Robot) -> Weights:
        """The weights of the stage cost for ``robot``."""
        change = 2 / self.change_scale**2  # Δr² + Δl² = 2 (Δv² + L² Δω²)
        return Weights(
            along=self.along_scale**-2,
            cross=self.cross_scale**-2,
            turned=self.heading_scale**-2,
            deviation_v=self.v_scale**-2,
            deviation_w=self.w_scale**-2,
            change_v=change,
            change_w=change * robot.half_axle**2,
        )

    def _late(self, setting: Setting) -> tuple[int, float]:
        """The latency as the plant has it: whole periods, and seconds beyond them."""
        steps = round(setting.period / STEP)
        periods, beyond = divmod(round(setting.latency / STEP) if self.latency == "modelled" else 0, steps)
        return periods, beyond * STEP

    def lag(self, setting: Setting, robot: Robot) -> float:
        """τ [s] of its model of ``robot``: 0 where the wheels follow at once, or are taken to."""
        return wheel_lag(robot) if self.wheel_lag == "modelled" and setting.plant == "dynamic" else 0.0

    def _numbers(self, setting: Setting, robot: Robot) -> list[float]:
        period, lag = setting.period, self.lag(setting, robot)
        after, weights = response(period, lag), self.weights(robot)
        periods, beyond = self._late(setting)
        v_max, w_max, half_axle, wheel = velocity_limits([robot])[:, 0]
        rates = [np.inf if rate is None else rate for rate in (robot.v_rate_max, robot.w_rate_max)]
        rates = [rate * period for rate in (*rates, wheel_rate(robot), wheel_rate(robot))]
        late = periods * period + beyond, lag, periods
        shares, part = velocity_shares(period, beyond, lag), response(beyond, lag)
        table = tail_table(weights, after, float(wheel))
        of_solver = [*after, *weights, half_axle, v_max, w_max, wheel, wheel, *rates]
        return [*of_solver, self.horizon, self.iterations, CONVERGED, *late, *shares, *part, *table.ravel()]
