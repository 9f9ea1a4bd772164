"""Nonlinear model predictive control of a differential drive: every period the best plan of the next ones.

The law simulates a model of its robot (:mod:`robotics.plugins.predictive.model`) over ``horizon`` control periods and
sends the first command of the plan that costs least (:mod:`robotics.plugins.predictive.ilqr`):

    J = Σ_k ½ [(along/a)² + (cross/c)² + (2 sin(ψ_e/2)/ψ)² + ((v_c − v_r)/v)² + ((ω_c − ω_r)/ω)² + |Δu/Δ|²] + ½ e' P e

where a, c, ψ, v, ω, Δ are the scales of the class: by Bryson's rule the deviations that weigh alike [Bryson & Ho 1975,
5.2], by default those of :mod:`robotics.laws.tracking.pdc`, and for the wheels 1 m/s² in periods of 50 ms, about a
fifth of what an EtsRo's can do. Δu is the change of both wheels' speeds from the command before, and P the terminal
cost (:mod:`robotics.plugins.predictive.terminal`). A period of the plan is a control period: its commands are those
that will be sent, so that the bounds of their change and the latency are what they are, and each plan is the first
guess of the next. Bounds: what the plant makes of a command (v_max, ω_max, the speed of the wheels, and (5.1) where a
robot has it), and a change a period of each wheel that its motor can follow.

What it knows: the reference from now to the end of the horizon (position, heading, velocity, curvature), the wheel
speeds by the encoders, the lag of the wheels, and the latency with the commands that are still to act. The pose is
predicted over the latency first. (v_r, ω_r) is the reference's velocity in the middle of a period, and τ later, since
the wheels follow that much later.

A real-time iteration [Diehl, Bock & Schlöder 2005]: ``iterations`` steps at most from the plan of the period before,
shifted by one; fewer where there is nothing to gain. With many it is the converged plan.

Left out: an estimate of the pose beyond what is measured, so that its noise enters; other robots and obstacles, which
:mod:`robotics.plugins.predictive.nmpc_discs` keeps clear of.
"""

from collections.abc import Mapping
from dataclasses import dataclass
from types import MappingProxyType
from typing import Any, Literal

import numpy as np

from fuzzy.compiled.columns import Columns, column, several, within
from fuzzy.compiled.jit import compiled_only
from fuzzy.quantity import quantity, whole
from robotics.laws.equation import EquationLaw, equation
from robotics.laws.setting import Setting
from robotics.plugins.predictive import model
from robotics.plugins.predictive.ilqr import TAIL, FixedColumns, SolverColumns, node_of, solve, working
from robotics.plugins.predictive.model import ResponseColumns, ShareColumns, moved
from robotics.plugins.predictive.terminal import SPEEDS, Weights, tail_table
from robotics.world.paths.road import moving
from robotics.world.vehicle.plant import STEP, velocity_limits
from robotics.world.vehicle.robot import Robot
from robotics.world.vehicle.wheel_loop import wheel_lag

CONVERGED = 1e-7  # of the cost: with less to gain a plan is left as it is


class PredictiveDerived(Columns):
    """What the law makes of its setting."""

    fixed = within(FixedColumns)
    delay = column("s", "the latency")
    periods = column("1", "whole periods of it")
    lead = column("s", "of the reference's velocity")
    share = within(ShareColumns)
    part = within(ResponseColumns)  # over the part of a period by which the latency is longer than ``periods``
    table = several(SPEEDS * (1 + TAIL), "", "(SPEEDS, 1 + TAIL) of the terminal cost, each row from its speed on")


class PredictiveMemory(Columns):
    """What the law remembers."""

    started = column("", "1: there is a plan")
    commands = several(0, "m/s, rad/s", "those that were sent, the oldest first, then the plan, each as v and ω")


@compiled_only
def forecast(robot, gain, sent, work):  # type: ignore[no-untyped-def]
    """Write the state of a robot at which the next command begins to act, and the command before it."""
    share, after = gain.share, gain.fixed.after
    v = share.mean * robot.v + share.older * sent[0] + share.newer * sent[2]
    w = share.mean * robot.w + share.older * sent[1] + share.newer * sent[3]
    x, y, heading = robot.x, robot.y, robot.heading
    x, y, heading, v, w, _, _, _ = moved(x, y, heading, v, w, sent[2], sent[3], gain.part)
    late = int(gain.periods)
    for n in range(1, late + 1):
        x, y, heading, v, w, _, _, _ = moved(x, y, heading, v, w, sent[2 + 2 * n], sent[3 + 2 * n], after)
    work.before_v, work.before_w = sent[2 + 2 * late], sent[3 + 2 * late]
    state = work.state
    state.x, state.y, state.heading, state.v, state.w = x, y, heading, v, w


@compiled_only
def preview(road, path, time, dt, gain, work):  # type: ignore[no-untyped-def]
    """Write where a robot's reference is at the ends of all periods, its velocities, and the terminal cost."""
    begin, lead, horizon = time + gain.delay, gain.lead + 0.5 * dt, int(gain.horizon)
    v = 0.0
    for k in range(horizon + 1):
        to, then = node_of(work, k).to, begin + k * dt
        _, _, _, to.v, to.w, _ = moving(road, path, then + lead)
        x, y, heading, v, w, _ = moving(road, path, then + dt if k < horizon else then)
        to.x, to.y, to.heading, to.cos, to.sin = x, y, heading, np.cos(heading), np.sin(heading)
        work.end_v, work.end_w = v, w
    end_at(gain, work, v)


@compiled_only
def end_at(gain, work, v):  # type: ignore[no-untyped-def]
    """Write the terminal cost of a reference that goes on at a speed ``v`` [m/s]."""
    table, tail, row, width = gain.table, work.tail, 0, 1 + TAIL
    while row < SPEEDS - 2 and v > table[width * (row + 1)]:
        row += 1
    low = width * row
    high = low + width
    share = (v - table[low]) / (table[high] - table[low])
    share = min(max(share, 0.0), 1.0)
    for n in range(TAIL):
        tail[n] = table[low + 1 + n] + share * (table[high + 1 + n] - table[low + 1 + n])


@equation
def predict(robot, gain, memory, command, work, road, path, time, dt):  # type: ignore[no-untyped-def]
    """Send the first command of the best plan."""
    work.fixed, work.around.count = gain.fixed, 0.0
    forecast(robot, gain, memory.commands, work)
    preview(road, path, time, dt, gain, work)
    send_best(gain, memory, command, work)


@compiled_only
def send_best(gain, memory, command, work):  # type: ignore[no-untyped-def]
    """Improve the plan of the period before, remember it, and send its first command."""
    horizon, commands, first = int(gain.horizon), memory.commands, 4 + 2 * int(gain.periods)
    for k in range(horizon):
        plan = node_of(work, k).plan
        ready = memory.started > 0 and k < horizon - 1
        plan.v_c = commands[first + 2 * k + 2] if ready else np.nan
        plan.w_c = commands[first + 2 * k + 3] if ready else np.nan
    solve(work, horizon, gain.iterations, CONVERGED)
    for k in range(horizon):
        plan = node_of(work, k).plan
        commands[first + 2 * k], commands[first + 2 * k + 1] = plan.v_c, plan.w_c
    for n in range(first - 2):
        commands[n] = commands[n + 2]
    memory.started = 1.0 if np.isfinite(work.cost) else 0.0
    v, w = commands[first], commands[first + 1]
    commands[first - 2], commands[first - 1] = v, w
    command.first, command.second, command.wish_v, command.wish_w = v, w, v, w


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

    equation, sort_of_law = predict, "predictive"
    barred = MappingProxyType({"lead": "it reads its reference ahead by its own model"})
    works, derived, remembers = SolverColumns, PredictiveDerived, PredictiveMemory

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
        return np.zeros((PredictiveMemory.size + 2 * (periods + 2 + self.horizon), runs, len(setting.robots)))

    def derive(self, setting: Setting) -> Mapping[str, Any]:
        """The numbers of the solver, of the forecast and of the terminal cost, each of all robots."""
        found = [self._numbers(setting, robot) for robot in setting.robots]
        return {name: np.transpose([one[name] for one in found]) for name in found[0]}

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

    def _numbers(self, setting: Setting, robot: Robot) -> dict[str, Any]:
        """What :meth:`derive` gives, of one robot."""
        period, lag = setting.period, self.lag(setting, robot)
        after, weights = model.response(period, lag), self.weights(robot)
        periods, beyond = self._late(setting)
        v_max, w_max, half_axle, wheel = velocity_limits([robot])[:, 0]
        rates = [np.inf if rate is None else rate for rate in (robot.v_rate_max, robot.w_rate_max)]
        rates = [rate * period for rate in (*rates, model.wheel_rate(robot), model.wheel_rate(robot))]
        tops = v_max, w_max, wheel, wheel
        fixed = {"after": after, "weights": weights, "half_axle": half_axle, "tops": tops, "rates": rates}
        return {
            "fixed": FixedColumns.stacked(fixed),
            "delay": periods * period + beyond,
            "periods": periods,
            "lead": lag,
            "share": model.velocity_shares(period, beyond, lag),
            "part": model.response(beyond, lag),
            "table": tail_table(weights, after, float(wheel)).ravel(),
        }
