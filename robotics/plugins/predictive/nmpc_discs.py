"""Predictive control in a team: the plan of :mod:`robotics.plugins.predictive.nmpc` that keeps out of discs.

Around what the sensors see, and no message explains, and around each robot that is heard there is a disc
(:mod:`robotics.plugins.predictive.discs`); a robot that is heard is led on with the velocity that it told last. Its
penalty is quadratic in how deep a plan goes in, and part of the same problem as the errors, the wheels' lag, the
latency and the bounds of commands. "keeping right" as in ORCA: the line is turned by ``right``, which breaks
symmetries.
"""

import math
from dataclasses import dataclass

import numpy as np

from fuzzy.compiled.columns import column, several
from fuzzy.compiled.jit import compiled_only
from fuzzy.quantity import quantity, whole
from robotics.laws.avoidance.priority import tell_whereabouts
from robotics.laws.equation import EquationLaw, equation
from robotics.laws.setting import Setting
from robotics.plugins.predictive.discs import keep, keep_points, line
from robotics.plugins.predictive.ilqr import NODE, node_of
from robotics.plugins.predictive.nmpc import PredictiveControl, PredictiveMemory, end_at, forecast, send_best
from robotics.plugins.reactive.along import AlongMemory, AlongPath, around, wanted
from robotics.plugins.reactive.orca import OrcaHeard, OrcaMessage, look_for_others
from robotics.world.radio.channel import predicted


class PlannedAroundMemory(AlongMemory):
    """What the law remembers: what it has seen, and its plan."""

    started = column("", "1: there is a plan")
    commands = several(0, "m/s, rad/s", "as those of PredictiveMemory")


@compiled_only
def lead_along(work, gain, dt, speed, course):  # type: ignore[no-untyped-def]
    """Write a reference that goes straight on from where the next command begins to act."""
    cos, sin, state = math.cos(course), math.sin(course), work.state
    for k in range(int(gain.horizon) + 1):
        to, way = node_of(work, k).to, (k + 1) * dt * speed
        to.x, to.y, to.heading, to.cos, to.sin = state.x + way * cos, state.y + way * sin, course, cos, sin
        to.v, to.w = speed, 0.0
    work.end_v, work.end_w = speed, 0.0
    end_at(gain, work, speed)


@equation
def plan_around(robot, gain, memory, command, work, known, i, table):  # type: ignore[no-untyped-def]
    """Make the discs of all that is seen and heard, and send the first command of the best plan."""
    speed, course = wanted(robot, gain, memory, command, known, i)
    robots, points = known.heard.shape[2], work.nodes[NODE * (int(gain.horizon) + 1) :]
    own = table[i % robots] + gain.margin
    count = look_for_others(robot, gain, memory, known, i, table, points)
    course = around(memory, points, count, own, course, robot.heading, gain.clears)
    work.fixed = gain.fixed
    work.around.count, work.around.weight = 0.0, 1 / (gain.disc_scale * gain.disc_scale)
    keep_points(work.around, robot, points, count, own)
    for j in range(robots):
        heard = OrcaHeard(known.heard, i, j)
        where = heard.said.where
        x, y = predicted(where.x, where.v_x, heard.age), predicted(where.y, where.v_y, heard.age)
        if heard.hears > 0 and math.hypot(x - robot.x, y - robot.y) < gain.sight:  # not-a-number: never heard
            at_x, at_y = x + gain.delay * where.v_x, y + gain.delay * where.v_y
            keep(work.around, robot, at_x, at_y, where.v_x, where.v_y, own + table[j])
    speed, course = line(robot, speed, course - gain.right * min(1.0, speed / gain.fastest))
    forecast(robot, gain, memory.commands, work)
    lead_along(work, gain, known.dt, speed, course)
    send_best(gain, memory, command, work)
    tell_whereabouts(command.say.where, robot)


@dataclass(frozen=True, kw_only=True)
class PredictiveAround(AlongPath, PredictiveControl):
    """Predictive control with discs: how deep in a disc weighs as much as a scale of an error, and what it looks at."""

    along_scale: float = quantity(2.0, "m", least=1e-3, most=1e3)  # to stand must cost less than to drive through
    cross_scale: float = quantity(0.5, "m", least=1e-3, most=1e3)
    horizon: int = whole(40, least=2, most=200, doc="Control periods that it plans ahead.")
    disc_scale: float = quantity(0.01, "m", above=0, most=10)
    margin: float = quantity(0.06, "m", above=0, most=2)
    sight: float = quantity(4.0, "m", above=0, most=100)  # of robots that are heard
    near: float = quantity(1.0, "m", above=0, most=100)  # what is seen farther away does not count
    clears: float = quantity(0.6, "m", above=0, most=10)  # the way that is free in the direction of its line
    right: float = quantity(0.15, "rad", above=0, most=1)

    equation, sort_of_law = plan_around, "predictive"
    barred = EquationLaw.barred  # type: ignore[assignment]
    remembers, works, says = PlannedAroundMemory, PredictiveControl.works, OrcaMessage  # type: ignore[assignment]

    @property
    def knows(self) -> tuple[str, ...]:
        """Of its reference what is due now; of wheels and latency what its model has."""
        return tuple(word for word in super().knows if word not in ("curvature", "preview"))

    def begin(self, setting: Setting, runs: int) -> np.ndarray:
        """Where on its path each robot starts, and no plan."""
        plan = PredictiveControl.begin(self, setting, runs)[PredictiveMemory.size - 1 :]
        return np.concatenate([AlongPath.begin(self, setting, runs), plan])
