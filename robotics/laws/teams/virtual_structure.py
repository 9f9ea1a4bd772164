"""Virtual structure: path parameters that agree, and each robot tracks the point at its own, thesis chapter 4.

    s_i' = v_L − κ c_i + η_i                                   (4.10)
    η_i' = −γ κ c_i                                            (4.11)
    c_i = Σ_j a_ij (s_i − s_j) + b_i (s_i − s_0)
    v_d = L_i s_i',  ω_d = κ(s_i) v_d                          (4.1), (4.2)

(In a formation by offsets s_i is the share of the virtual path, and L_i the robot's way for each unit of it there.)

and the tracker (2.30), (2.32). a_ij = −l_ij: with the Laplacian's own entries, as (4.10) prints them, the coupling
drives the robots apart ("literal"). s_0 is the virtual leader, which follows the timing of the scenario.

Stability: the proof of theorem 4.1 holds with 0 < γ < 1 and κ > 1/(4 γ (1 − γ²) λ_min(L + B)) (it prints λ_max, for
which Q is indefinite). The system itself is stable for every κ, γ > 0.

Variants, by the meaning of s_i:

``virtual``: a number that each robot integrates by itself. Equal at the start, they stay equal, and a robot that is
held up shows in none of the s_i.
``measured``: the place of the robot, which is the nearest point of its path. There is no (4.11) here, since a fault
would wind up its integral.
``waiting``: as measured; the leader goes on only as far as the slowest robot lets it; a robot that gets no command
for 0.5 s stops, and afterwards looks for its place on the path again.

Chosen here: the leader is no robot, but each robot keeps a copy of its clock, and the copies of ``waiting`` agree on
the slowest (a minimum consensus), so that no robot is indispensable. s_i' stays between 0 and v_most / L_i.
"""

import math
from collections.abc import Mapping
from dataclasses import dataclass, field
from math import inf
from typing import Any, Literal

import numpy as np

from fuzzy.compiled.columns import Columns, codes, column, within
from fuzzy.compiled.jit import without_refcounts
from fuzzy.quantity import quantity
from robotics.laws.equation import EquationLaw, HeardColumns, RobotColumns, equation
from robotics.laws.law import ControllerError, check_team
from robotics.laws.setting import Setting
from robotics.laws.teams.neighbours import OUTAGE, alone
from robotics.laws.tracking.lyapunov import Lyapunov, track
from robotics.world.paths.road import at, nearest, place, share, stretch, timed
from robotics.world.radio.channel import predicted
from robotics.world.radio.graph import is_connected, smallest_eigenvalue, unreached, weights

SEARCH_SHARE = 0.05  # of the path: how far from its last place a robot looks for the next
SEARCH_SHARE_AFTER_OUTAGE = 0.25  # of the path: the same for a robot that was alone
Variant = Literal["virtual", "measured", "waiting"]
_VARIANT = codes(Variant)


class StructureMessage(Columns):
    """What every robot broadcasts."""

    s = column("1", "s_i, the path parameter")
    s_rate = column("1/s")
    clock = column("s", "its copy of the leader's time")
    pace = column("1", "of that clock")


class StructureHeard(HeardColumns):
    """What one robot has heard of another."""

    said = within(StructureMessage)


class StructureMemory(Columns):
    """What the law remembers."""

    s = column("1", "s_i")
    integral = column("1/s", "η_i")
    clock = column("s", "the robot's copy of the leader's time")


class StructureDerived(Columns):
    """What the law makes of its setting."""

    a_ij = column("1", "the same for all links of a robot")
    end = column("s", "when the leader arrives")


@without_refcounts
def measured_place(s, robot: RobotColumns, i, known):  # type: ignore[no-untyped-def]
    """The path parameter of the path's point that is nearest to the robot, looked for about ``s``."""
    road, path = known.road, known.path[i]
    lost = alone(known.heard, i, known.time) > OUTAGE
    reach = (SEARCH_SHARE_AFTER_OUTAGE if lost else SEARCH_SHARE) * road.lengths[path]
    found = nearest(road, path, robot.x, robot.y, place(road, path, s), reach)
    return share(road, path, found)


@without_refcounts
def slowest_clock(clock, i, known):  # type: ignore[no-untyped-def]
    """The earliest of a robot's own clock and its neighbours', by now [s]: the minimum consensus."""
    for j in range(known.heard.shape[2]):
        heard = StructureHeard(known.heard, i, j)
        if heard.hears > 0:
            ahead = known.dt * max(heard.said.pace, 1.0)
            theirs = predicted(heard.said.clock, heard.said.pace, heard.age) + ahead
            clock = theirs if theirs < clock else clock
    return clock


@without_refcounts
def slowest_place(s, i, known):  # type: ignore[no-untyped-def]
    """The smallest of a robot's own path parameter and its neighbours' that were heard."""
    for j in range(known.heard.shape[2]):
        heard = StructureHeard(known.heard, i, j)
        if heard.hears > 0:
            theirs = predicted(heard.said.s, heard.said.s_rate, heard.age)
            s = theirs if theirs < s else s
    return s


@without_refcounts
def disagreement(s, i, known, a_ij):  # type: ignore[no-untyped-def]
    """Σ_j a_ij (s − s_j) over the neighbours that were heard."""
    total = 0.0
    for j in range(known.heard.shape[2]):
        heard = StructureHeard(known.heard, i, j)
        if heard.hears > 0:
            gap = s - predicted(heard.said.s, heard.said.s_rate, heard.age)
            if not math.isnan(gap):
                total += gap * a_ij
    return total


@equation
def virtual_structure(robot, gain, memory, command, known, i, road, path, dt):  # type: ignore[no-untyped-def]
    """Move the path parameter by (4.10), (4.11), and track its point by (2.30), (2.32)."""
    s, clock, integral, pace = memory.s, memory.clock, memory.integral, 1.0
    if gain.variant != _VARIANT.virtual:
        s = measured_place(s, robot, i, known)
    # The leader
    s_leader, v_leader = timed(road, path, min(clock, gain.end))
    s_0 = share(road, path, s_leader)
    v_0 = v_leader / stretch(road, path, s_0)
    if gain.variant == _VARIANT.waiting:
        slowest = slowest_place(s, i, known)
        late = min(max(known.time - clock, 0.0), 1.0)
        pace = min(max(1 - (s_0 - slowest) / gain.slack, 0.0), 1.0) * (1 + (gain.catch_up - 1) * late)
    # (4.10), (4.11)
    c = disagreement(s, i, known, gain.a_ij) + gain.leader * (s - s_0)
    wish = v_0 * pace - gain.kappa * c + integral
    length = stretch(road, path, s)
    rate = min(max(wish, 0.0), gain.v_most / length)
    if gain.variant == _VARIANT.virtual and rate == wish:
        # No integration while the wish is beyond what the robot may do: (4.11) would wind up.
        memory.integral = integral - dt * (gain.gamma * gain.kappa * c)
    rate = 0.0 if s >= 1 else rate
    # (4.1), (4.2)
    target, abscissa = command.target, place(road, path, s)
    target.x, target.y, target.heading, curvature = at(road, path, abscissa)
    target.v, target.w, target.s = length * rate, length * rate * curvature, abscissa
    v, w = track(robot, target, gain.tracker)
    command.first, command.second, command.wish_v, command.wish_w = v, w, v, w
    say = command.say
    command.progress, say.s, say.s_rate, say.clock, say.pace = s, s, rate, clock, pace
    memory.s = min(s + dt * rate, 1.0) if gain.variant == _VARIANT.virtual else s
    clock = clock + dt * pace
    memory.clock = slowest_clock(clock, i, known) if gain.variant == _VARIANT.waiting else clock


@dataclass(frozen=True, kw_only=True)
class VirtualStructure(EquationLaw):
    """Virtual structure: gains of the coordination, and the tracker."""

    variant: Variant = "waiting"
    kappa: float = quantity(1.0, "1/s", above=0)  # κ
    gamma: float = quantity(0.5, "1/s", least=0)  # γ; 0: without (4.11). Only of the variant "virtual"
    leader: float = quantity(1.0, "1", least=0)  # b_i of every robot
    tracker: Lyapunov = field(default_factory=Lyapunov)  # catch_up=0 there: (2.32) as printed
    v_most: float = quantity(0.8, "m/s", above=0)  # 0 <= L_i s_i' <= v_most
    slack: float = quantity(0.05, "1", above=0)  # of the path: a robot that is so far behind stops the clock; "waiting"
    catch_up: float = quantity(1.0, "1", least=1, most=5)  # pace of a clock that is late; "waiting"
    coupling: Literal["corrected", "literal"] = "corrected"  # literal: a_ij = l_ij, as (4.10) prints it

    equation = virtual_structure
    says, remembers, derived = StructureMessage, StructureMemory, StructureDerived
    aims = True
    progresses = True

    @property
    def idle(self) -> frozenset[str]:
        """The gains that have no effect in this variant."""
        idle = {"gamma"} if self.variant != "virtual" else set()
        return frozenset(idle | ({"slack", "catch_up"} if self.variant != "waiting" else set()))

    @property
    def watchdog(self) -> float:
        """After how long [s] without a new command a robot stops."""
        return OUTAGE if self.variant == "waiting" else inf

    def derive(self, setting: Setting) -> Mapping[str, Any]:
        """The weights of the graph, and when the leader arrives."""
        ends = setting.references.ends
        links = weights(setting.radio.adjacency(len(setting.robots))).max(axis=1)
        return {
            "a_ij": np.broadcast_to(-links if self.coupling == "literal" else links, ends.shape),
            "end": np.broadcast_to(ends.max(axis=-1, keepdims=True), ends.shape),
        }

    def begin(self, setting: Setting, runs: int) -> np.ndarray:
        """Begin at the start of the paths. Raises ControllerError where the graph or the gains do not suit (4.10)."""
        robots = len(setting.robots)
        a = setting.radio.adjacency(robots)
        b = np.full(robots, self.leader)
        check_team(setting)
        if not is_connected(a) and unreached(a, b > 0):
            raise ControllerError(
                f"{setting.name}: the graph {setting.radio.graph!r} is not connected, and nothing of the leader "
                f"reaches robots {', '.join(map(str, unreached(a, b > 0)))}: give leader > 0, or a connected graph"
            )
        self._check_gains(weights(a), b)
        paths, memory = setting.references.joined, StructureMemory.zeros(runs, robots)
        start = paths.share(setting.references.at(0.0).s)
        memory.s = start
        if self.variant != "virtual":
            reach = SEARCH_SHARE_AFTER_OUTAGE * paths.lengths
            memory.s = paths.share(setting.starting_places(runs, paths.place(start), reach))
        return memory.array

    def _check_gains(self, a: np.ndarray, b: np.ndarray) -> None:
        """Raise ControllerError unless the gains fulfil the condition of theorem 4.1, with λ_min."""
        if self.variant != "virtual" or self.gamma == 0:
            return
        if self.gamma >= 1:
            raise ControllerError(f"theorem 4.1 needs 0 < gamma < 1, got {self.gamma:g} (0 is without (4.11))")
        smallest = smallest_eigenvalue(a, b)
        needed = 1 / (4 * self.gamma * (1 - self.gamma**2) * smallest) if smallest > 0 else inf
        if self.kappa <= needed and self.coupling == "corrected":
            raise ControllerError(
                f"theorem 4.1 needs kappa > 1/(4 gamma (1 - gamma²) λ_min(L + B)) = {needed:.4g} with "
                f"λ_min = {smallest:.4g}; got kappa = {self.kappa:g}"
            )
