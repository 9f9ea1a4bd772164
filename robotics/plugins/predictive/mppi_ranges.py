"""MPPI on range sensors: the sampled plans of :mod:`robotics.plugins.predictive.mppi` that keep out of what is seen.

Around each point that a sensor sees there is a disc (:mod:`robotics.plugins.predictive.discs`), and what a sample pays
for being in one is the obstacle critic of Nav2's optimizer on the readings themselves, without a map between. It hears
nobody: another robot is what the sensors see of it, at rest.
"""

import math
from dataclasses import dataclass

import numpy as np

from fuzzy.compiled.columns import several
from fuzzy.compiled.jit import compiled_only
from fuzzy.quantity import quantity, whole
from robotics.laws.equation import EquationLaw, equation
from robotics.laws.setting import Setting
from robotics.plugins.predictive.discs import keep_points, line
from robotics.plugins.predictive.mppi import PAST, AheadColumns, PathIntegral, room_of_plans, send_average
from robotics.plugins.reactive.along import AlongMemory, AlongPath, around, look_around, wanted

_AHEAD = AheadColumns.size


class SampledAroundMemory(AlongMemory):
    """What the law remembers: what it has seen, and its plan."""

    past = several(2 * PAST, "m/s, rad/s", "as those of SampledMemory")
    adds = several(0, "m/s, rad/s")


@compiled_only
def lead_along(robot, work, gain, speed, course):  # type: ignore[no-untyped-def]
    """Write a reference that goes straight on from the robot."""
    steps, cos, sin = int(gain.steps), math.cos(course), math.sin(course)
    led = work.rest[_AHEAD * steps :]
    for t in range(steps):
        to, way = AheadColumns(work.rest, t, steps), (t + 1) * gain.step * speed
        to.x, to.y, to.cos, to.sin = robot.x + way * cos, robot.y + way * sin, cos, sin
        led[t], led[steps + t] = speed, 0.0


@equation
def sample_around(robot, gain, memory, command, work, known, i, table, rules):  # type: ignore[no-untyped-def]
    """Make the discs of all that is seen, and command the beginning of the average of the sampled plans."""
    speed, course = wanted(robot, gain, memory, command, known, i)
    points = work.rest[room_of_plans(int(gain.steps), len(rules)) :]
    own = table[i % known.heard.shape[2]] + gain.margin
    count = look_around(robot, gain, memory, known, i, table, gain.near, points)
    course = around(memory, points, count, own, course, robot.heading, gain.clears)
    work.around.count, work.around.weight = 0.0, gain.disc
    keep_points(work.around, robot, points, count, own)
    speed, course = line(robot, speed, course)
    lead_along(robot, work, gain, speed, course)
    send_average(robot, gain, memory, command, work, rules, known.time, known.dt)


@dataclass(frozen=True, kw_only=True)
class IntegralAround(AlongPath, PathIntegral):
    """MPPI on range sensors: its samples over 2 s, what being in the middle of a disc costs, and what it looks at."""

    samples: int = whole(256, least=2, most=100_000, doc="The number of plans that are simulated in a period.")
    steps: int = whole(20, least=5, most=1000, doc="The number of steps of the horizon.")
    step: float = quantity(0.1, "s", above=0, most=1)
    x_scale: float = quantity(1.0, "m", above=0)  # to stand must cost less than to drive through
    y_scale: float = quantity(0.5, "m", above=0)
    disc: float = quantity(50.0, "1", above=0, most=1e6)  # a step in the middle of one
    margin: float = quantity(0.06, "m", above=0, most=2)
    near: float = quantity(1.0, "m", above=0, most=100)  # what is seen farther away does not count
    clears: float = quantity(0.6, "m", above=0, most=10)  # the way that is free in the direction of its line

    equation, sort_of_law = sample_around, "predictive"
    barred = EquationLaw.barred  # type: ignore[assignment]
    remembers, works = SampledAroundMemory, PathIntegral.works  # type: ignore[assignment]

    @property
    def knows(self) -> tuple[str, ...]:
        """Of its reference what is due now; of wheels what its model has."""
        return tuple(word for word in super().knows if word != "preview")

    def begin(self, setting: Setting, runs: int) -> np.ndarray:
        """Where on its path each robot starts, and plans that add nothing."""
        return np.concatenate([AlongPath.begin(self, setting, runs), PathIntegral.begin(self, setting, runs)])
