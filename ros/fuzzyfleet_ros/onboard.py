"""One robot driven by a law: what its own computer does in a period, from postures and messages to a command.

The laws of the catalogue are written for all robots of all runs at once; here one robot knows itself, and of the others
what the radio has brought. Nothing here knows ROS.
"""

from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from math import cos, hypot, inf, isfinite, nan, sin
from typing import Any, NamedTuple

import numpy as np

from fuzzy.errors import InputError
from fuzzyfleet_ros.frames import Posture
from robotics.laws.equation import RobotColumns, SeenColumns
from robotics.laws.foreign import checked_control, checked_init
from robotics.laws.law import Command, Law, Observation, check_needs
from robotics.laws.modes import MODES
from robotics.laws.setting import Setting
from robotics.simulation.safety.monitor import MonitorLanes, keep_one, note_order
from robotics.simulation.safety.opening import guard_on_board, is_guarded, told_by
from robotics.world.radio.channel import AirColumns, Heard
from robotics.world.sensing.carried import sensor_names
from robotics.world.sensing.sonar import Ranges
from robotics.world.vehicle.plant import TruthColumns, saturate, velocity_limits

_STANDS = 100  # periods without an order, after which nothing is on its way to the wheels any more
# m: by how much other robots are moved to find out whether a law reads where they are
_MOVED = (0.0, 0.01, 0.3, -0.5, nan)


class OnboardError(InputError):
    """A robot that cannot be driven so. The message says why, and what can be."""


class Received(NamedTuple):
    """The last message that a robot has received of each other robot."""

    noted: np.ndarray  # (robots,) s: when its age was noted
    age: np.ndarray  # (robots,) s: how old it was then; infinite before the first
    values: np.ndarray  # (fields, robots); not-a-number before the first

    @classmethod
    def nothing(cls, fields: int, robots: int) -> "Received":
        """What has been received at the start."""
        return cls(np.zeros(robots), np.full(robots, inf), np.full((fields, robots), np.nan))

    def with_message(self, sender: int, noted: float, age: float, values: Sequence[float]) -> "Received":
        """The same after a message of robot ``sender``, counted from 0, unless a newer one was heard before.

        It was ``age`` [s] old at the time ``noted`` [s].
        """
        if noted - age < self.noted[sender] - self.age[sender] - 1e-6:
            return self
        times, ages, table = self.noted.copy(), self.age.copy(), self.values.copy()
        times[sender], ages[sender], table[:, sender] = noted, age, values
        return Received(times, ages, table)

    def ages(self, time: float) -> np.ndarray:
        """How old the messages are at ``time`` [s] (robots,)."""
        return np.maximum(self.age + (time - self.noted), 0.0)


class OwnState(NamedTuple):
    """Where a robot is and how fast, as it knows it itself."""

    posture: Posture  # in the frame of the paths; the heading is continuous
    v: float  # m/s, by the wheels over the last period
    w: float  # rad/s, likewise


class Perceived(NamedTuple):
    """What a robot knows in one period."""

    time: float  # s since the start
    own: OwnState
    others: Mapping[int, OwnState]  # where others are, counted from 0, for a law that reads it
    received: Received  # what the radio has brought
    # What its range sensors read, by name [m]; infinite or left out: nothing is seen. None: nobody looks
    ranges: Mapping[str, float] | None = None
    looked: Collection[str] | None = None  # the sensors that have looked since the period before; None: as they should
    odometry: Posture | None = None  # of its own, in a frame that stays from task to task; None: that of the paths
    clock: float | None = None  # s by a clock that goes on while it stands, and from task to task; None: its time


class Order(NamedTuple):
    """What a law tells its robot in one period."""

    v: float  # m/s, within the bounds
    w: float  # rad/s
    message: tuple[float, ...]  # what it broadcasts, in the order of :attr:`Onboard.fields`; none: nothing
    target: Posture  # where it wants to be
    mode: str  # of robotics.laws.modes.MODES; "": the law has no modes
    lost: str  # why it is stopped for good; "": it drives


class Remembered(NamedTuple):
    """What a robot remembers from period to period."""

    law: Any
    guard: MonitorLanes | None  # of its monitor of passive safety, written in place; None: there is none
    k: int  # the last period, counted by the clock; -1: none yet


@dataclass(frozen=True, eq=False)
class Onboard:
    """The computer of one robot: its law, its task and its bounds. :meth:`begin` and :meth:`step` drive it."""

    setting: Setting
    law: Law[Any]
    robot: int  # counted from 0
    limits: np.ndarray  # (4, 1): of robotics.world.vehicle.plant.velocity_limits
    hears: np.ndarray  # (robots, robots) bool: the graph of the radio
    guarded: bool  # whether the monitor of passive safety is below the law
    fields: tuple[str, ...]  # of a message: the law's, and then the monitor's

    @classmethod
    def of(
        cls,
        setting: Setting,
        law: Law[Any],
        robot: int = 0,
        *,
        v_max: float = inf,
        w_max: float = inf,
        torque_as_velocity: bool = False,
        scales: bool = True,
    ) -> "Onboard":
        """Put a law on a robot.

        Args:
            setting: The task; it may have more robots than this one.
            law: The law.
            robot: Which robot of the setting, counted from 0.
            v_max: A bound of the speed [m/s], beside the robot's own.
            w_max: A bound of the turn rate [rad/s], beside the robot's own.
            torque_as_velocity: Whether a law that commands torques may drive by the velocity that it tries to reach.
            scales: Whether it keeps wheels within their top speed, at the same curvature; else the base sees to that.

        Raises OnboardError, or ControllerError where the law cannot drive the setting.
        """
        robots = len(setting.robots)
        if setting.ensemble:
            raise OnboardError(f"{setting.name}: a robot follows one scenario, not an ensemble of them")
        if not 0 <= robot < robots:
            raise OnboardError(f"{setting.name}: robots are 1 to {robots}, got {robot + 1}")
        if law.level == "torque" and not torque_as_velocity:
            raise OnboardError(
                f"{type(law).__name__} commands the torques of the wheels, and a base takes velocities; with "
                "torque_as_velocity the base's own wheel loops follow the velocity that the law tries to reach, which "
                "is another controller than in the simulator"
            )
        check_needs(setting, law)
        guarded = is_guarded(setting, law)
        limits = velocity_limits([setting.robots[robot]])
        limits[0], limits[1] = np.minimum(limits[0], v_max), np.minimum(limits[1], w_max)
        if not scales:
            limits[3] = inf
        fields = (*law.message, *told_by(setting, law))
        graph = setting.radio.adjacency(robots).astype(bool) if fields else np.zeros((robots, robots), dtype=bool)
        return cls(setting, law, robot, limits, graph, guarded, fields)

    def start_of(self, robot: int) -> Posture:
        """Where the setting lets a robot, counted from 0, start."""
        return Posture(*(float(value) for value in self.setting.starts[robot]))

    @property
    def start(self) -> Posture:
        """Where the setting lets this robot start."""
        return self.start_of(self.robot)

    def plan(self, points: int) -> list[Posture]:
        """So many postures of this robot's reference, from its start to the end of the task."""
        times = np.linspace(0.0, self.duration, points)
        on = self.setting.references.sampled(times)
        rows = zip(*(field[:, self.robot].tolist() for field in on[:3]), strict=True)
        return [Posture(*row) for row in rows]

    def rehearse(self) -> None:
        """Decide once in thought: what is compiled is compiled then, and what cannot be driven is said.

        Raises ControllerError.
        """
        known = OwnState(self.start, 0.0, 0.0)
        others = {j: OwnState(self.start_of(j), 0.0, 0.0) for j in range(len(self.setting.robots)) if j != self.robot}
        self.step(Perceived(0.0, known, others if self.sees_others else {}, self.silence(), {}), self.begin())

    @property
    def duration(self) -> float:
        """How long the task lasts [s]."""
        return self.setting.ticks * self.setting.period

    @property
    def senders(self) -> tuple[int, ...]:
        """The robots, counted from 0, that this one hears."""
        return tuple(int(j) for j in np.flatnonzero(self.hears[self.robot]) if j != self.robot)

    def begin(self, before: Remembered | None = None) -> Remembered:
        """What is remembered at the start; of a task ``before``, what the monitor knows, as the robot may drive.

        Raises ControllerError where the law cannot drive the setting.
        """
        law, guard = checked_init(self.law, self.setting, 1), before.guard if before else None
        if self.guarded and guard is None:
            guard = guard_on_board(self.setting, self.law)
        return Remembered(law, guard, before.k if before else -1)

    @property
    def needs(self) -> tuple[str, ...]:
        """The range sensors without whose readings it must stand: those of the law, for the monitor all."""
        return tuple(self.setting.sensors[self.robot]) if self.guarded else self.law.needs

    @cached_property
    def sees_others(self) -> bool:
        """Whether the law reads where other robots are, beside what the radio brings.

        It is found out by moving them, from where they start and from their references a third and two thirds later.
        """
        if len(self.setting.robots) == 1:
            return False
        starts = [OwnState(self.start_of(j), 0.0, 0.0) for j in range(len(self.setting.robots))]
        later = [(time, self._due(time)) for time in (self.duration / 3, 2 * self.duration / 3)]
        return any(self._differs(time, places) for time, places in ((0.0, starts), *later))

    def _due(self, time: float) -> list[OwnState]:
        """All robots where their references are at ``time`` [s]."""
        rows = np.stack(self.setting.references.at(time)[:5], axis=1).tolist()
        return [OwnState(Posture(*row[:3]), *row[3:]) for row in rows]

    def _differs(self, time: float, places: Sequence[OwnState]) -> bool:
        """Whether this robot's command at ``time`` [s] is another when the others stand elsewhere than ``places``."""
        found = []
        for way in _MOVED:
            moved = {j: _onward(known, way) for j, known in enumerate(places) if j != self.robot}
            command, _ = self._commanded(Perceived(time, places[self.robot], moved, self.silence()), self.begin().law)
            found.append([self._own(value) for value in command[:4]])
        return any(not np.array_equal(found[0], other, equal_nan=True) for other in found[1:])

    def silence(self) -> Received:
        """What has been heard before the first message."""
        return Received.nothing(len(self.fields), len(self.setting.robots))

    def step(self, seen: Perceived, memory: Remembered) -> tuple[Order, Remembered]:
        """Decide on the command of one period by what is ``seen``; return the new ``memory``, too.

        Raises ControllerError where a law of the user's own fails.
        """
        command, own = self._commanded(seen, memory.law)
        # Periods in which it stood, as its odometry was old, count for the monitor; its clock may be a little uneven
        k = max(memory.k + 1, round((seen.time if seen.clock is None else seen.clock) / self.setting.period))
        memory, before = Remembered(own, memory.guard, k), memory.k
        posture, reference = seen.own.posture, self.setting.references.at(seen.time)
        aim = reference if command.target is None else command.target
        target = Posture(*(self._own(field) for field in aim[:3]))
        message: tuple[float, ...] = ()
        if command.message is not None:
            said = command.message
            message = tuple(self._own(said[name]) for name in self.law.message)
        mode = "" if command.mode is None else MODES[int(self._own(command.mode))]
        first, second = self._own(command.first), self._own(command.second)
        away = hypot(posture.x - target.x, posture.y - target.y)
        lost = ""
        if not (isfinite(first) and isfinite(second)):
            lost = "the law's command is not a finite number"
        elif not away < self.setting.divergence:
            lost = f"it is {away:.3g} m from its target, and {self.setting.divergence:g} m are allowed"
        if self.law.level == "torque":
            first, second = self._own(command.v), self._own(command.w)
        if lost:
            first = second = 0.0
        v, w = (float(part[0]) for part in saturate(self.limits, np.array([first]), np.array([second])))
        if memory.guard is not None:
            v, w, told = self._guarded(memory.guard, range(before + 1, k), k, seen, v, w)
            message += told
        return Order(v, w, message, target, mode, lost), memory

    def _guarded(
        self, guard: MonitorLanes, missed: range, k: int, seen: Perceived, v: float, w: float
    ) -> tuple[float, float, tuple[float, ...]]:
        """What the monitor makes of the order of period ``k``, and what it tells the others, if any.

        In the periods ``missed`` the robot was let stand.
        """
        robots, me, period, said = len(self.setting.robots), self.robot, self.setting.period, len(self.law.message)
        for earlier in missed[-_STANDS:]:
            note_order(guard, me, earlier, period, 0.0, 0.0)
        truth, known, order = (np.zeros((n, robots)) for n in (TruthColumns.size, SeenColumns.size, 2))
        posture, here = seen.own.posture, TruthColumns(truth, me)
        here.odo_x, here.odo_y, here.odo_heading = seen.odometry or posture
        known[: RobotColumns.size, me] = (*posture, seen.own.v, seen.own.w)
        order[:, me] = v, w
        if self.fields:
            heard = AirColumns(guard.air.heard)
            heard.age[me] = seen.received.ages(seen.time)
            heard.values[:, me] = seen.received.values[said:]
        if seen.looked is not None:
            for q in range(guard.begin[me], guard.end[me]):
                new = self._names[guard.column[q]] in seen.looked
                guard.every[q] = 1 if new else k + 1  # of which no period but the first is a multiple
        keep_one(guard, me, k, period, robots, truth, known, self._readings(seen.ranges or {}), order)
        return *order[:, me].tolist(), tuple(guard.said[:, me].tolist()) if self.fields else ()

    def _commanded(self, seen: Perceived, memory: Any) -> tuple[Command, Any]:
        """What the law commands; a robot of which nothing is known is nowhere, so that whoever asks for it is lost."""
        time, references = seen.time, self.setting.references
        x, y, heading, v, w = states = np.full((5, 1, len(self.setting.robots)), np.nan)
        for j, other in {**seen.others, self.robot: seen.own}.items():
            states[:, 0, j] = (*other.posture, other.v, other.w)
        heard, looked = self._heard(time, seen.received), self._ranges(seen.ranges)
        observation = Observation(time, x, y, heading, v, w, references.at(time), references, heard, looked)
        return checked_control(self.law, observation, memory, self.setting.period)

    def _own(self, values: Any) -> float:
        """This robot's part of ``values``, which fit (1, robots)."""
        return float(np.broadcast_to(values, (1, len(self.setting.robots)))[0, self.robot])

    def _heard(self, time: float, received: Received) -> Heard:
        """What the radio brought; what the others have heard is unknown."""
        fields, robots = self.law.message, len(self.setting.robots)
        if not fields:
            return Heard.nothing(1, robots)
        age = np.full((1, robots, robots), inf)
        age[0, self.robot] = received.ages(time)
        values = np.full((len(fields), 1, robots, robots), np.nan)
        values[:, 0, self.robot] = received.values[: len(fields)]
        return Heard(fields, values, age, self.hears)

    @cached_property
    def _names(self) -> tuple[str, ...]:
        return sensor_names(self.setting.sensors)

    def _ranges(self, readings: Mapping[str, float] | None) -> Ranges | None:
        if readings is None or not self.law.looks:
            return None
        return Ranges(self._names, self._readings(readings)[None])

    def _readings(self, readings: Mapping[str, float]) -> np.ndarray:
        """The readings of this robot [m] (robots, sensors)."""
        values = np.full((len(self.setting.robots), len(self._names)), inf)
        for name, reading in readings.items():
            if name in self._names:
                values[self.robot, self._names.index(name)] = reading
        return values


def _onward(known: OwnState, way: float) -> OwnState:
    """A robot ``way`` [m] farther along its heading, which is turned, and faster."""
    x, y, heading = known.posture
    return OwnState(
        Posture(x + way * cos(heading), y + way * sin(heading), heading + way), known.v + way, known.w + way
    )
