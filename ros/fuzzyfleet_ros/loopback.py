"""The simulator as a loopback: plants, sensors and radio as in ``simulate``, but the commands come from outside.

Nothing here knows ROS.
"""

from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from math import inf
from typing import Any, NamedTuple

import numpy as np

from robotics.laws.equation import RobotColumns
from robotics.laws.law import Command, Law, Observation
from robotics.laws.setting import Setting
from robotics.simulation.loop import Simulation, checked_seeds, when_stopped
from robotics.simulation.recorder import Recorder
from robotics.simulation.run import Run
from robotics.simulation.safety.opening import told_by
from robotics.simulation.steps import say
from robotics.world.radio.channel import Heard
from robotics.world.sensing.carried import sensor_names
from robotics.world.vehicle.plant import TruthColumns


class Sensed(NamedTuple):
    """What all robots sense in one period; arrays are copies."""

    posture: np.ndarray  # (3, robots): x [m], y [m], heading [rad] as measured
    velocity: np.ndarray  # (2, robots): v [m/s], ω [rad/s] by the encoders
    truth: np.ndarray  # (3, robots): the true posture
    speed: np.ndarray  # (2, robots): the true v [m/s] and ω [rad/s]
    wheels: np.ndarray  # (4, robots): angles of the left and of the right wheel [rad], their speeds [rad/s]; encoders
    ranges: np.ndarray  # (robots, sensors) m; infinite: nothing seen
    heard: Heard  # one run


@dataclass(frozen=True, eq=False, kw_only=True)
class Outside(Law[None]):
    """The law that commands what came from outside, and says what came from there."""

    message: tuple[str, ...] = ()  # the names of the values that each robot broadcasts
    watchdog: float = inf  # s: so long without a new command, and a robot at fault stops by itself
    looks: bool = False  # whether range sensors are read
    safe: str = ""  # "no": the monitor of passive safety is on board, if there is one
    order: np.ndarray = field(repr=False)  # (2, robots): v [m/s] and ω [rad/s], written before each period
    said: np.ndarray = field(repr=False)  # (values, robots): likewise

    def init(self, setting: Setting, runs: int) -> None:
        """It remembers nothing."""

    def control(self, seen: Observation, memory: None, dt: float) -> tuple[Command, None]:
        """What came from outside."""
        v, w = self.order[0][None].copy(), self.order[1][None].copy()
        message = {name: self.said[i][None].copy() for i, name in enumerate(self.message)} or None
        return Command(v, w, v, w, message), None


class Loopback:
    """The robots of a scenario, whose commands come from outside: :meth:`sense`, then :meth:`advance`, and so on."""

    def __init__(
        self,
        setting: Setting,
        law: Law[Any] | None = None,
        seed: int = 0,
        *,
        patience: float = 0.5,
        keeps: bool = False,
    ) -> None:
        """Begin it.

        Args:
            setting: The scenario; where its robots shall be plays no part.
            law: The law that drives from outside; what it and its monitor broadcast is taken from it. None: nothing.
            seed: Of all noise.
            patience: The time [s] without a command after which a base stops by itself; infinite: never.
            keeps: Whether what happens is recorded, for :meth:`run`.

        Raises SimulationError for the seed, and RadioError where the messages of a period do not fit.
        """
        robots = len(setting.robots)
        words = (*law.message, *told_by(setting, law)) if law else ()
        outside = Outside(
            message=words,
            safe="no" if law else "",
            watchdog=law.watchdog if law else inf,
            looks=any(setting.sensors),
            order=np.zeros((2, robots)),
            said=np.zeros((len(words), robots)),
        )
        setting = replace(setting, divergence=inf)
        self.setting, self.outside, self.patience, self.seed = setting, outside, patience, seed
        seeds = checked_seeds([seed])
        self.recorder = Recorder(setting, outside, 1, nothing=not keeps)
        self.simulation = Simulation(setting, outside, seeds, recorder=self.recorder)
        self.names = sensor_names(setting.sensors)
        self.age = np.full(robots, inf)  # s since the last command
        self.spoke = np.zeros(robots, dtype=bool)  # whether a robot has something to say
        self.radii = np.array([robot.wheel_radius for robot in setting.robots])
        self.axles = np.array([robot.half_axle for robot in setting.robots])
        self.k = 0

    @property
    def time(self) -> float:
        """Since the start [s]."""
        return self.k * self.setting.period

    @property
    def over(self) -> bool:
        """Whether the last period has come, after which nobody moves."""
        return self.k >= self.setting.ticks

    @property
    def speaks_now(self) -> bool:
        """Whether messages go on the air in this period."""
        return bool(self.outside.message) and self.k % self.simulation.lanes.air.every == 0

    def sense(self) -> Sensed:
        """What all robots sense now."""
        one, k = self.simulation, self.k
        one.sense(k)
        one.look(k)
        one.hear(k)
        lanes = one.lanes
        truth, robot = TruthColumns(lanes.body.truth), RobotColumns(lanes.known.seen)
        ranges = np.full((len(self.age), len(self.names)), inf)
        if one.ranges is not None:
            ranges[...] = one.ranges.values[0]
        per_radian = np.array([robot.counts_per_turn / (2 * np.pi) for robot in self.setting.robots])
        angles = np.floor(np.stack([truth.left.angle, truth.right.angle]) * per_radian) / per_radian
        v, turn = robot.v, self.axles * robot.w
        wheels = np.concatenate([angles, [(v - turn) / self.radii, (v + turn) / self.radii]])
        posture, velocity = robot.array[:3].copy(), robot.array[3:5].copy()
        place, speed = truth.array[:3].copy(), np.stack([truth.v, truth.w])
        return Sensed(posture, velocity, place, speed, wheels, ranges, one.heard())

    def command(self, robot: int, v: float, w: float) -> None:
        """Give robot ``robot``, counted from 0, a command: v [m/s] and ω [rad/s]."""
        self.outside.order[:, robot] = v, w
        self.age[robot] = 0.0

    def speak(self, robot: int, values: Sequence[float]) -> None:
        """Let robot ``robot``, counted from 0, have a message to broadcast."""
        self.outside.said[:, robot] = values
        self.spoke[robot] = True

    def advance(self) -> None:
        """Do what was commanded, put on the air what was said, and move on by a period, unless it is over."""
        one, k = self.simulation, self.k
        self.outside.order[:, self.age > self.patience + 1e-9] = 0.0
        one.decide(k)
        one.obey()
        one.keep(k)
        one.watch(k)
        if self.over:
            return
        lanes = one.lanes
        cut = lanes.trouble.cut | ~self.spoke  # who has nothing to say is not heard
        say(k, lanes.period, cut, lanes.air, lanes.command, lanes.body.truth)
        one.move(k)
        self.age += self.setting.period
        self.k += 1

    def run(self, name: str) -> Run:
        """What was recorded up to now, of a loopback that keeps it; ``name`` is that of the law."""
        gone = when_stopped(self.simulation.lanes, self.k)
        return self.recorder.run(self.setting, (self.seed,), name, gone, self.k + 1)
