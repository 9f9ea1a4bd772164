"""A setting for one robot that follows way-points, such as those of a path that a planner has published."""

from collections.abc import Sequence
from dataclasses import replace
from math import atan2, hypot

from robotics.laws.setting import Setting
from robotics.simulation.scenario.description import Member, Scenario
from robotics.simulation.scenario.robots import RobotModel
from robotics.world.paths.path import Waypoints
from robotics.world.paths.trajectory import Timing

_SETTLE = 2.0  # s that a robot may take after the reference has arrived
_NEAREST = 1e-3  # m: points closer than this to the one before are taken for the same


def thinned(points: Sequence[tuple[float, float]], spacing: float) -> tuple[tuple[float, float], ...]:
    """Those of ``points`` [m] that are at least ``spacing`` [m] from the one kept before, and the last one."""
    kept: list[tuple[float, float]] = []
    for point in points:
        if not kept or hypot(point[0] - kept[-1][0], point[1] - kept[-1][1]) >= max(spacing, _NEAREST):
            kept.append(point)
    if points and kept[-1] != points[-1]:
        if len(kept) > 1:
            kept[-1] = points[-1]
        elif hypot(points[-1][0] - kept[0][0], points[-1][1] - kept[0][1]) >= _NEAREST:
            kept.append(points[-1])
    return tuple(kept)


def setting_along(
    points: Sequence[tuple[float, float]],
    model: RobotModel,
    speed: float,
    *,
    ramp: float = 1.0,
    spacing: float = 0.05,
    period: float = 0.05,
) -> Setting:
    """Compile the task of following a spline through way-points at a constant speed.

    Args:
        points: The way-points x, y [m], two or more.
        model: The robot.
        speed: Along the path, between the ramps [m/s].
        ramp: The time in which the speed rises at the start, and in which it falls at the end [s].
        spacing: Points closer than this to the one before are left out [m].
        period: The control period, a multiple of 10 ms [s].

    Raises PathError, or ScenarioError where no command of the robot can follow.
    """
    shape = Waypoints(points=thinned(points, spacing))
    (x0, y0), (x1, y1) = shape.points[:2]
    member = Member(
        start=(x0, y0, atan2(y1 - y0, x1 - x0)),
        path=shape,
        timing=Timing(speed=speed, ramp=ramp),
        robot=model.robot,
        model=model,
    )
    described = Scenario(name="path", robots=(member,), period=period)
    end = float(described.trajectory.ends[0]) + _SETTLE
    return replace(described, duration=max(period, round(end / period) * period)).setting
