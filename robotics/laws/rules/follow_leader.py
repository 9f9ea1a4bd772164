"""Leader and followers on any paths: a law by quantities that rule bases can learn.

Robot 1 leads. Each robot drives along its own path, which may close, cross itself and turn back in x; its place there
is the nearest point about where it was before. With d the leader's lead over a robot, along the leader's path, and over
the followers' mean for the leader itself (``leader_ahead``), λ the way on the own path for each metre of the leader's
(``stretch``), and β the bearing of the own path's point L further on (``onward_bearing``),

    v_1 = v_d S(d; 3/2, 0, 2)        the leader hurries from behind and waits in front
    v_i = v_d λ S(d; 1/4, 7/4, 4)    the followers wait for a leader behind and hurry after one ahead
    ω = 2 v sin(β)/L                 along the arc through that point: pure pursuit

with S of :func:`robotics.laws.formation.leader_follower.pace`, which is 1 at d = 0. The law is a smooth function of
three quantities, so a network of them can learn it. Of the S curves the forms are those of thesis 5.2.1, the numbers
are choices: the wheels must not saturate, and a follower must come into its place by itself, not only when the leader
waits for the mean.

Stability: with e_i = d_i − d_1 a follower's lead beside the mean, e_i' = −v_d S'(0) e_i = −(3/2) v_d e_i, and the mean
lead decays with v_d (3/2 + 1). A cross-track error obeys e'' + (2/L) e' + (2/L²) e = 0 per metre: a damping of 0.71;
where the curvature changes by κ' per metre it is κ' L³/6 (4.5 mm for L = 0.3 m and κ' = 1 1/m²).

All robots stop when the leader reaches the end of its path. One computer commands all robots: nothing is heard by
radio, late or lost.
"""

import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from fuzzy.compiled.columns import Columns, column, several
from fuzzy.compiled.jit import compiled_only
from fuzzy.quantity import quantity
from robotics.laws.equation import EquationLaw, RobotColumns, equation
from robotics.laws.formation.leader_follower import pace_compiled
from robotics.laws.law import ControllerError
from robotics.laws.rules.perception import level_with_leader, on_leader, onward_bearing, stretched
from robotics.laws.rules.situation import ONWARD
from robotics.laws.setting import Setting
from robotics.laws.teams.neighbours import reach
from robotics.world.paths.road import at, nearest

_AT_END = 1e-3  # m: a leader this near to the end of its path has arrived


class FollowColumns(Columns):
    """What a robot remembers."""

    over = column("", "1: the leader has arrived, and all stand still")
    places = several(0, "m", "(robots,): the abscissae of all")


@compiled_only
def find_formation(known, i, memory, places):  # type: ignore[no-untyped-def]
    """Bring the places of all robots (robots,) [m] up to date, and notice in ``memory`` that the leader has arrived."""
    road, robots = known.road, known.heard.shape[2]
    path, first, near = known.path[i] - i % robots, i - i % robots, reach(known.heard, i, known.time)
    for j in range(robots):
        robot = RobotColumns(known.seen, first + j)
        places[j] = nearest(road, path + j, robot.x, robot.y, places[j], near)
    if places[0] >= road.lengths[path] - _AT_END:
        memory.over = 1.0


@compiled_only
def aim_level(target, v, known, i, place, begin):  # type: ignore[no-untyped-def]
    """Let the ``target`` be level with the leader, who is at ``place`` [m] and drives ``v`` [m/s].

    ``begin`` (robots,) [m] is where the references begin.
    """
    road, path, number = known.road, known.path[i], i % known.heard.shape[2]
    s = level_with_leader(road, path - number, number, place, begin)
    target.x, target.y, target.heading, curvature = at(road, path, s)
    target.v, target.s = v * stretched(road, path - number, number, s, begin), s
    target.w = target.v * curvature


class FollowDerived(Columns):
    """What the law makes of the timing."""

    demanded = column("m/s", "v_d")


@equation
def follow(robot, gain, memory, command, known, i, table):  # type: ignore[no-untyped-def]
    """Evaluate the law at the measured postures; ``table`` says where the references begin (robots,) [m]."""
    road, robots, places = known.road, known.heard.shape[2], memory.places
    number = i % robots
    path, leader = known.path[i], known.path[i] - number
    find_formation(known, i, memory, places)
    total = 0.0
    for j in range(1, robots):
        total += on_leader(road, leader, j, places[j], table)
    v = gain.demanded * pace_compiled(places[0] - total / (robots - 1), 1.5, 0.0, gain.leader_rate)
    leads = 0.0 if memory.over > 0 else v
    if number > 0:
        ahead = places[0] - on_leader(road, leader, number, places[number], table)
        stretch = stretched(road, leader, number, places[number], table)
        v = gain.demanded * stretch * pace_compiled(ahead, 0.25, 1.75, gain.rate)
    w = 2 * v * math.sin(onward_bearing(road, path, robot, places[number])) / ONWARD
    if memory.over > 0:
        v, w = 0.0, 0.0
    command.first, command.second, command.wish_v, command.wish_w = v, w, v, w
    aim_level(command.target, leads, known, i, places[0], table)


@dataclass(frozen=True, kw_only=True)
class FollowLeader(EquationLaw):
    """The law of the module's head."""

    speed: float = quantity(0.0, "m/s", least=0, doc="Speed v_d of the leader; 0: that of its timing.")
    leader_rate: float = quantity(2.0, "1/m", above=0, doc="How steeply the leader's speed falls with its lead.")
    rate: float = quantity(4.0, "1/m", above=0, doc="How steeply the followers' speed grows with the leader's lead.")

    equation, remembers, derived = follow, FollowColumns, FollowDerived
    aims = True

    def derive(self, setting: Setting) -> Mapping[str, Any]:
        """v_d, by the leader's timing where the law does not say it."""
        references = setting.references
        way = (references.joined.lengths - references.at(0.0).s) / references.ends
        return {"demanded": self.speed or np.broadcast_to(way[..., :1], way.shape)}

    def tables(self, setting: Setting) -> np.ndarray:
        """Where the references begin (rows, robots) [m]."""
        return setting.references.at(-setting.references.road.since).s.reshape(-1, len(setting.robots))

    def begin(self, setting: Setting, runs: int) -> np.ndarray:
        """Find the robots on their paths. Raises ControllerError for a single robot."""
        places = places_at_start(setting, runs)
        return np.concatenate([np.zeros((1, *places.shape[1:])), places])


def formation_reach(setting: Setting) -> np.ndarray:
    """How far robots may be along their paths from where these should begin [m], of the shape of the starts.

    Where a path closes, its end is as near as its beginning: it is looked for no farther than the robot may be. Raises
    ControllerError for a single robot.
    """
    if len(setting.robots) < 2:
        raise ControllerError(f"{setting.name}: a formation needs a leader and followers, at least two robots")
    begin = setting.references.at(0.0)
    return np.asarray(0.2 + 1.2 * np.hypot(setting.starts[..., 0] - begin.x, setting.starts[..., 1] - begin.y))


def places_at_start(setting: Setting, runs: int) -> np.ndarray:
    """The abscissae of all robots as each knows them (robots, runs, robots) [m]; raises as :func:`formation_reach`."""
    near = setting.starting_places(runs, setting.references.at(0.0).s, formation_reach(setting))
    return np.repeat(near.T[:, :, None], len(setting.robots), axis=2)
