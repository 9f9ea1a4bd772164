"""Parking in polar coordinates about the goal [Aicardi et al. 1995, eqs 4 to 9].

With the distance e of the goal, its bearing α from the robot's heading, and θ = α − ψ_err, the angle of the line of
sight from the goal's heading:

    v = γ cos α e,    ω = k α + γ (cos α sin α / α) (α + h θ)

    V = (e² + α² + h θ²)/2 falls:  V' = −γ cos² α e² − k α² <= 0

so that robot and goal become one posture, from every start but the goal itself, where the angles have no meaning. The
robot drives backwards where the goal is behind it. Of a goal that moves it sees the place, not the velocity: it trails.

Choices: nearer than ``near`` the bearing is noise, so the robot stops and turns to the goal's heading; v and ω shrink
together where one is beyond the robot's limits, so that the curve driven is the one that was asked for.
"""

import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

from fuzzy.compiled.columns import Columns, column
from fuzzy.quantity import quantity
from robotics.laws.equation import EquationLaw, equation
from robotics.laws.setting import Setting
from robotics.world.paths.posture import wrapped_compiled
from robotics.world.vehicle.plant import velocity_limits


class PolarDerived(Columns):
    """What the law is told of a robot."""

    v_most = column("m/s")
    w_most = column("rad/s")


@equation
def park(robot, aim, gain):  # type: ignore[no-untyped-def]
    """Come to the aim and stand as it stands."""
    dx, dy = aim.x - robot.x, aim.y - robot.y
    e, off = math.hypot(dx, dy), wrapped_compiled(aim.heading - robot.heading)
    if e < gain.near:
        return 0.0, max(-gain.w_most, min(gain.k * off, gain.w_most))
    alpha = wrapped_compiled(math.atan2(dy, dx) - robot.heading)
    theta = wrapped_compiled(alpha - off)
    cos = math.cos(alpha)
    slope = math.sin(alpha) / alpha if abs(alpha) > 1e-9 else 1.0
    v = gain.gamma * cos * e
    w = gain.k * alpha + gain.gamma * cos * slope * (alpha + gain.h * theta)
    share = max(abs(v) / gain.v_most, abs(w) / gain.w_most, 1.0)
    return v / share, w / share


@dataclass(frozen=True, kw_only=True)
class Polar(EquationLaw):
    """Gains of the parking law; by default those of which the sum of V falls as fast in distance as in angle."""

    gamma: float = quantity(0.5, "1/s", above=0)  # γ: of the distance
    k: float = quantity(1.5, "1/s", above=0)  # of the bearing
    h: float = quantity(1.0, "1", above=0)  # weight of θ in V
    near: float = quantity(0.04, "m", least=0)  # closer to the goal it only turns

    knows = ("reference",)
    equation = park
    derived = PolarDerived

    def derive(self, setting: Setting) -> Mapping[str, Any]:
        """The limits of v and ω."""
        v_most, w_most, *_ = velocity_limits(setting.robots)
        return {"v_most": v_most, "w_most": w_most}
