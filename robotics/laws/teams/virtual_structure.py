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

from dataclasses import dataclass, field
from math import inf
from typing import Literal, NamedTuple

import numpy as np

from robotics.laws.law import Command, ControllerError, Law, Observation, check_team
from robotics.laws.setting import Setting
from robotics.laws.teams.neighbours import OUTAGE, alone_for, differences, smallest_heard
from robotics.laws.tracking.lyapunov import Lyapunov
from robotics.paths.path import PathPoint
from robotics.paths.trajectory import Reference
from robotics.quantity import check_quantities, quantity
from robotics.radio.graph import is_connected, smallest_eigenvalue, unreached, weights

SEARCH_SHARE = 0.05  # of the path: how far from its last place a robot looks for the next
SEARCH_SHARE_AFTER_OUTAGE = 0.25  # of the path: the same for a robot that was alone


class _Memory(NamedTuple):
    """Each field is (runs, robots) unless it says otherwise."""

    s: np.ndarray  # 1: the path parameter
    rate: np.ndarray  # 1/s: s_i' of the period before
    integral: np.ndarray  # 1/s: η
    clock: np.ndarray  # s: each robot's copy of the leader's time
    pace: np.ndarray  # 1: of that copy
    weights: np.ndarray  # (robots, robots): a_ij
    lengths: np.ndarray  # (robots,) m
    end: np.ndarray  # (1,), in an ensemble (runs, 1) s: the leader arrives


@dataclass(frozen=True, kw_only=True)
class VirtualStructure(Law[_Memory]):
    """Virtual structure: gains of the coordination, and the tracker."""

    variant: Literal["virtual", "measured", "waiting"] = "waiting"
    kappa: float = quantity(1.0, "1/s", above=0)  # κ
    gamma: float = quantity(0.5, "1/s", least=0)  # γ; 0: without (4.11). Only of the variant "virtual"
    leader: float = quantity(1.0, "1", least=0)  # b_i of every robot
    tracker: Lyapunov = field(default_factory=Lyapunov)  # catch_up=0 there: (2.32) as printed
    v_most: float = quantity(0.8, "m/s", above=0)  # 0 <= L_i s_i' <= v_most
    slack: float = quantity(0.05, "1", above=0)  # of the path: a robot that is so far behind stops the clock; "waiting"
    catch_up: float = quantity(1.0, "1", least=1, most=5)  # pace of a clock that is late; "waiting"
    coupling: Literal["corrected", "literal"] = "corrected"  # literal: a_ij = l_ij, as (4.10) prints it

    message = ("s", "s_rate", "clock", "pace")

    def __post_init__(self) -> None:
        check_quantities(self, ControllerError)

    @property
    def idle(self) -> frozenset[str]:
        """The gains that have no effect in this variant."""
        idle = {"gamma"} if self.variant != "virtual" else set()
        return frozenset(idle | ({"slack", "catch_up"} if self.variant != "waiting" else set()))

    @property
    def watchdog(self) -> float:
        """After how long [s] without a new command a robot stops."""
        return OUTAGE if self.variant == "waiting" else inf

    def init(self, setting: Setting, runs: int) -> _Memory:
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
        a = weights(a)
        self._check_gains(a, b)
        zero = np.zeros((runs, robots))
        if self.coupling == "literal":
            a = -a
        lengths = setting.references.joined.lengths
        paths = setting.references.joined
        start = paths.share(setting.references.at(0.0).s)
        s = zero + start
        if self.variant != "virtual":
            pose, reach = setting.starts, SEARCH_SHARE_AFTER_OUTAGE * lengths
            near = paths.nearest(pose[..., 0], pose[..., 1], paths.place(start), reach)
            s = zero + paths.share(near)
        return _Memory(s, zero, zero, zero, zero + 1.0, a, lengths, setting.references.ends.max(axis=-1, keepdims=True))

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

    def control(self, seen: Observation, memory: _Memory, dt: float) -> tuple[Command, _Memory]:
        """Move the path parameters by (4.10), (4.11), and track their points by (2.30), (2.32)."""
        heard = seen.heard
        paths, lengths = seen.references.joined, memory.lengths
        s = memory.s
        if self.variant != "virtual":
            reach = np.where(alone_for(heard, seen.time) > OUTAGE, SEARCH_SHARE_AFTER_OUTAGE, SEARCH_SHARE) * lengths
            s = paths.share(paths.nearest(seen.x, seen.y, paths.place(s), reach))
        theirs = heard.now("s", by="s_rate")
        # The leader
        clock, pace = memory.clock, memory.pace
        leader = seen.references.each_at(np.minimum(clock, memory.end))
        s0 = paths.share(leader.s)
        v_leader = leader.v / paths.stretch(s0)
        if self.variant == "waiting":
            slowest = smallest_heard(s, theirs, heard.hears)
            late = np.clip(seen.time - clock, 0.0, 1.0)
            pace = np.clip(1 - (s0 - slowest) / self.slack, 0.0, 1.0) * (1 + (self.catch_up - 1) * late)
        v_leader = v_leader * pace
        # (4.10), (4.11)
        gap = differences(s, theirs, memory.weights) + self.leader * (s - s0)
        wish = v_leader - self.kappa * gap + memory.integral
        stretch = paths.stretch(s)
        rate = np.clip(wish, 0.0, self.v_most / stretch)
        integral = memory.integral
        if self.variant == "virtual" and self.gamma > 0:
            # No integration while the wish is beyond what the robot may do: (4.11) would wind up.
            integral = integral - dt * np.where(rate == wish, self.gamma * self.kappa * gap, 0.0)
        rate = np.where(s >= 1, 0.0, rate)
        # (4.1), (4.2)
        place = paths.place(s)
        target = _moving(paths.at(place), stretch * rate, place)
        command, _ = self.tracker.control(seen._replace(reference=target), None, dt)
        message = {"s": s, "s_rate": rate, "clock": clock, "pace": pace}
        if self.variant == "virtual":
            s = np.minimum(s + dt * rate, 1.0)
        clock = clock + dt * pace
        if self.variant == "waiting":
            theirs = heard.now("clock", by="pace") + dt * np.maximum(heard["pace"], 1.0)
            clock = np.minimum(clock, smallest_heard(clock, theirs, heard.hears))
        after = memory._replace(s=s, rate=rate, integral=integral, clock=clock, pace=pace)
        return command._replace(message=message, target=target, progress=message["s"]), after


def _moving(point: PathPoint, v: np.ndarray, s: np.ndarray) -> Reference:
    """A target that moves along its path with ``v`` [m/s]."""
    return Reference(point.x, point.y, point.heading, v, v * point.curvature, s)
