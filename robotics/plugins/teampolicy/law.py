"""A learnt policy for teams among obstacles: a small network beside the way that the reactive laws take.

A robot wants to drive to a point of its path ahead, in a direction near it in which the way is free, as the laws of
:mod:`robotics.plugins.reactive` do: with a velocity u [m/s], in the robot's frame. The network adds to its command:

    v = clip(clip(u_x) + m_v a),   ω = clip(clip(u_y / point) + m_ω b),   (a, b) = clip(net(o))

with v from 0 to ``fastest``, |ω| up to ``quickest``, and the observation o of :func:`observe_team`: u, how it moves,
what was added last, the nearest thing seen in each of SECTORS directions, and of the nearest robots that are heard
where they are, how fast they come nearer and pass, and who counts first. It never backs: hardly a robot sees what is
behind it. How it is learnt tells :mod:`robotics.plugins.teampolicy.learning`.

Stability and safety: none is proved. It was shown by runs on random scenarios alone.
"""

import math
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path

import numpy as np

from fuzzy.compiled.columns import column
from fuzzy.compiled.jit import compiled_only
from fuzzy.quantity import quantity
from robotics.laws.avoidance.priority import tell_whereabouts
from robotics.laws.equation import equation
from robotics.laws.law import ControllerError
from robotics.laws.setting import Setting
from robotics.plugins.reactive.along import (
    REMEMBERED_POINTS,
    AlongMemory,
    AlongPath,
    around,
    room_for_points,
    tell,
    wanted,
)
from robotics.plugins.reactive.orca import OrcaHeard, OrcaMessage, look_for_others
from robotics.plugins.reinforcement.neural import NeuralPolicy, answer
from robotics.plugins.reinforcement.policyfile import Policy, PolicyColumns, load_policy
from robotics.world.radio.channel import predicted

SECTORS = 12  # directions around the robot, of each of which the nearest thing seen counts
NEAREST_ROBOTS = 3  # robots that are heard
_HEARD = ("cos", "sin", "near", "far", "closing", "crossing", "age", "first")
TEAM_INPUTS = (
    *("wanted_ahead", "wanted_left", "path_cos", "path_sin", "v", "w", "behind", "remaining"),
    *("last_v", "last_w", "radius"),
    *(f"seen_{n + 1}" for n in range(SECTORS)),
    *(f"robot{n + 1}_{name}" for n in range(NEAREST_ROBOTS) for name in _HEARD),
)
_SEEN_FROM = TEAM_INPUTS.index("seen_1")
_HEARD_FROM, _OF_ONE, ALL = _SEEN_FROM + SECTORS, len(_HEARD), len(TEAM_INPUTS)
_FAR = 2.0  # m and s: more behind, farther from the end or older counts no more
_QUICK = 2.0  # rad/s
_OWN = "ppo-team"


class TeamPolicyMemory(AlongMemory):
    """What it remembers beside what it has seen."""

    last_v = column("1", "what the network answered last")
    last_w = column("1")


@compiled_only
def look(robot, gain, memory, command, known, i, table, points):  # type: ignore[no-untyped-def]
    """Look along the path and around: the speed wanted [m/s], its direction [rad], that of the path, what is seen."""
    speed, path = wanted(robot, gain, memory, command, known, i)
    count = look_for_others(robot, gain, memory, known, i, table, points)
    own = table[i % known.heard.shape[2]] + gain.margin
    return speed, around(memory, points, count, own, path, robot.heading, gain.clears), path, count


@compiled_only
def observe_team(robot, gain, memory, command, known, i, table, speed, course, path, count, points, seen):  # type: ignore[no-untyped-def]
    """Write what the network observes into ``seen``: TEAM_INPUTS, all of them about -1 to 1.

    Args:
        robot, gain, memory, command, known, i, table: As an equation has them.
        speed, course, path, count: As of :func:`look`.
        points: What is seen but for robots that are heard, in the robot's frame [m].
        seen: (ALL,).
    """
    robots = known.heard.shape[2]
    cos, sin, radius = math.cos(robot.heading), math.sin(robot.heading), table[i % robots]
    behind, remaining = command.target.s - memory.place, known.road.lengths[known.path[i]] - memory.place
    share = speed / gain.fastest
    seen[0], seen[1] = share * math.cos(course - robot.heading), share * math.sin(course - robot.heading)
    seen[2], seen[3] = math.cos(path - robot.heading), math.sin(path - robot.heading)
    seen[4], seen[5] = robot.v / gain.fastest, robot.w / _QUICK
    seen[6], seen[7] = min(max(behind / _FAR, -1.0), 1.0), min(remaining / _FAR, 1.0)
    seen[8], seen[9], seen[10] = memory.last_v, memory.last_w, radius
    for n in range(_SEEN_FROM, ALL):
        seen[n] = 0.0
    for n in range(count):
        x, y = points[2 * n], points[2 * n + 1]
        place = _SEEN_FROM + int((math.atan2(y, x) / math.pi + 1) / 2 * SECTORS) % SECTORS
        seen[place] = max(seen[place], 1 - max(math.hypot(x, y) - radius, 0.0) / gain.near)
    before = -1.0
    for n in range(NEAREST_ROBOTS):
        nearest, who, ahead, left = gain.sight, -1, 0.0, 0.0
        for j in range(robots):
            heard = OrcaHeard(known.heard, i, j)
            where = heard.said.where
            dx = predicted(where.x, where.v_x, heard.age) - robot.x
            dy = predicted(where.y, where.v_y, heard.age) - robot.y
            apart = math.hypot(dx, dy)
            if heard.hears > 0 and before < apart < nearest:  # not-a-number: never heard
                nearest, who, ahead, left = apart, j, cos * dx + sin * dy, cos * dy - sin * dx
        if who < 0:
            break
        heard, k = OrcaHeard(known.heard, i, who), _HEARD_FROM + n * _OF_ONE
        where, apart = heard.said.where, max(nearest, 1e-6)
        to_cos, to_sin, gap = ahead / apart, left / apart, max(nearest - radius - table[who], 0.0)
        v_x = robot.v - cos * where.v_x - sin * where.v_y
        v_y = sin * where.v_x - cos * where.v_y
        seen[k], seen[k + 1] = to_cos, to_sin
        seen[k + 2], seen[k + 3] = max(1 - gap / gain.near, 0.0), max(1 - gap / gain.sight, 0.0)
        seen[k + 4] = (v_x * to_cos + v_y * to_sin) / gain.fastest
        seen[k + 5] = (v_y * to_cos - v_x * to_sin) / gain.fastest
        seen[k + 6], seen[k + 7] = min(heard.age / _FAR, 1.0), 1.0 if who < i % robots else -1.0
        before = nearest


@compiled_only
def plain(robot, gain, speed, course):  # type: ignore[no-untyped-def]
    """The command without the network: v [m/s] and ω [rad/s]."""
    alpha = course - robot.heading
    return within_bounds(gain, speed * math.cos(alpha), speed * math.sin(alpha) / gain.point)


@compiled_only
def within_bounds(gain, v, w):  # type: ignore[no-untyped-def]
    """What may be commanded."""
    return min(max(v, 0.0), gain.fastest), min(max(w, -gain.quickest), gain.quickest)


@compiled_only
def drive_answer(robot, gain, memory, command, policy, speed, course, one, two):  # type: ignore[no-untyped-def]
    """Command what is wanted and what the network adds to it; tell the others where the robot is."""
    memory.last_v, memory.last_w = min(max(one, -1.0), 1.0), min(max(two, -1.0), 1.0)
    v, w = plain(robot, gain, speed, course)
    v, w = within_bounds(gain, v + policy.first * memory.last_v, w + policy.second * memory.last_w)
    tell(command, v, w)
    tell_whereabouts(command.say.where, robot)


@equation
def add_learnt(robot, gain, memory, command, work, rules, known, i, table):  # type: ignore[no-untyped-def]
    """Ask the network what it adds to the velocity wanted, and drive that."""
    points, policy = work.points, PolicyColumns(rules)
    units = points[2 * (3 * known.ranges.shape[0] + REMEMBERED_POINTS) :]
    speed, course, path, count = look(robot, gain, memory, command, known, i, table, points)
    observe_team(robot, gain, memory, command, known, i, table, speed, course, path, count, points, units)
    one, two = answer(policy, units)
    drive_answer(robot, gain, memory, command, policy, speed, course, one, two)


@dataclass(frozen=True, kw_only=True)
class TeamPolicy(AlongPath):
    """A learnt policy for teams; ``ppo-team`` comes with the package."""

    policy: str | Policy = _OWN  # that of the package, or a .json file
    point: float = quantity(0.06, "m", above=0, most=2)  # as ORCA's
    margin: float = quantity(0.06, "m", above=0, most=2)
    sight: float = quantity(4.0, "m", above=0, most=100)  # others that are heard from farther away do not count
    near: float = quantity(1.0, "m", above=0, most=100)  # nor what is seen farther away
    clears: float = quantity(0.6, "m", above=0, most=10)  # the way that is free in the direction it wants
    quickest: float = quantity(1.5, "rad/s", above=0, most=20)

    equation = add_learnt
    remembers = TeamPolicyMemory
    says = OrcaMessage

    def __post_init__(self) -> None:
        super().__post_init__()
        if self.network.inputs != TEAM_INPUTS:
            raise ControllerError(
                f"the policy {self.name} was not learnt for teams: its inputs must be {', '.join(TEAM_INPUTS)}"  # type: ignore[misc]
            )

    name, learnt_how, rule_rows = NeuralPolicy.name, NeuralPolicy.learnt_how, NeuralPolicy.rule_rows

    @cached_property
    def network(self) -> Policy:
        """The policy of the file. Raises ControllerError."""
        if isinstance(self.policy, Policy):
            return self.policy
        return load_policy(Path(__file__).parent / "data" / f"{_OWN}.json" if self.policy == _OWN else self.policy)

    def working_for(self, robots: int, sensors: int) -> int:
        """Room for the points, and for two layers."""
        return self.working + room_for_points(sensors) + 2 * self.network.widest

    def begin(self, setting: Setting, runs: int) -> np.ndarray:
        """As the laws beside it; nothing has been added yet."""
        memory = super().begin(setting, runs)
        return np.concatenate([memory, np.zeros((self.remembers.size - len(memory), *memory.shape[1:]))])
