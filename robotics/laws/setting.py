"""The setting of a law: all that it is told, before the start, of its robots and of their task."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Literal

import numpy as np

from robotics.laws.knowledge import NOTHING_GIVEN, Knowledge
from robotics.world.environment.world import Obstacles
from robotics.world.paths.goal import Reach
from robotics.world.paths.references import References
from robotics.world.radio.description import Radio
from robotics.world.radio.faults import Fault
from robotics.world.random_streams import START_STREAM
from robotics.world.sensing.posture import Sensing
from robotics.world.sensing.sonar import RangeSensor
from robotics.world.vehicle.floor import Patch
from robotics.world.vehicle.plant import Level
from robotics.world.vehicle.robot import Robot
from robotics.world.vehicle.wheel_loop import wheel_lag

# Each robot has its own reference; a leader and its followers; a team that shall arrive together; a goal for each robot
Kind = Literal["tracking", "formation", "team", "goal"]
Safety = Literal["", "passive"]


@dataclass(frozen=True, kw_only=True)
class TrueParameters:
    """What is so, where it is not what the laws, the wheel loops and odometry are told: how robust a law is."""

    robots: tuple[Robot, ...]  # as they are; their loops and limits go by the robots of the setting
    latency: float  # s


@dataclass(frozen=True, kw_only=True, eq=False)
class Setting:
    """A compiled scenario, or an ensemble of runs that each have their own paths, ready for one array pass.

    In an ensemble the starts, the references and the world differ from run to run, and carry (runs, ...) in front; the
    rest is shared.

    Attributes:
        name: Of the scenario, for messages.
        kind: What the robots do: "tracking", "formation", "team" or "goal".
        robots: Their parameters.
        starts: (robots, 3), in an ensemble (runs, robots, 3): x [m], y [m], heading [rad]; as :meth:`seeded` gives it
            also where each seed has its own.
        references: The paths with their timing.
        radio: Who hears whom, and how.
        sensing: How each robot knows its posture.
        sensors: The range sensors that each robot carries, by name.
        world: The obstacles; the robots do not know them, they only sense them.
        faults: What goes wrong, and when.
        ticks: The number of control periods.
        period: That of the controller [s].
        latency: From deciding on a command to its effect [s].
        plant: Whether robots have mass and motors, or do at once what is commanded.
        divergence: A robot this far from its target is stopped [m].
        knowledge: Knowledge for every law that can use it.
        start_spread: (robots, 3) or None: how far each seed's start is from that, at most [m, m, rad].
        goals: Of the kind "goal": what counts as having come to it, of each robot.
        truth: None: all is as it is told here; no law may look at it.
        safety: "passive": the monitor of :mod:`robotics.simulation.safety` is below the law; "": it is not.
        others_speed: The greatest speed of what moves among the obstacles, which that assumes [m/s]; None: that of the
            fastest one.
        patches: Where the floor's friction is another; no law knows of it.
    """

    name: str
    kind: Kind
    robots: tuple[Robot, ...]
    starts: np.ndarray
    references: References
    radio: Radio
    sensing: tuple[Sensing, ...]
    sensors: tuple[Mapping[str, RangeSensor], ...]
    world: Obstacles | None
    faults: tuple[Fault, ...]
    ticks: int
    period: float
    latency: float
    plant: Literal["dynamic", "kinematic"]
    divergence: float
    knowledge: Knowledge = NOTHING_GIVEN
    start_spread: np.ndarray | None = None
    goals: tuple[Reach, ...] = ()
    truth: TrueParameters | None = None
    safety: Safety = ""
    others_speed: float | None = None
    patches: tuple[Patch, ...] = ()

    @property
    def ensemble(self) -> bool:
        """Whether each run has paths and starts of its own."""
        return self.references.joined.lengths.ndim == 2

    def seeded(self, seeds: Sequence[int]) -> "Setting":
        """The setting of runs with these ``seeds``, each of which starts where its seed says."""
        if self.start_spread is None or not self.start_spread.any():
            return self
        shape = self.start_spread.shape
        draws = [np.random.default_rng([seed, START_STREAM]).uniform(-1.0, 1.0, shape) for seed in seeds]
        return replace(self, starts=self.starts + np.array(draws) * self.start_spread, start_spread=None)

    @property
    def has_others(self) -> bool:
        """Whether there is something that a robot can touch: another robot, or an obstacle."""
        return len(self.robots) > 1 or self.world is not None

    @property
    def times(self) -> np.ndarray:
        """The times of the samples (ticks + 1,) [s], both ends included."""
        return np.arange(self.ticks + 1) * self.period

    def auto_lead(self, level: Level) -> np.ndarray:
        """The lead "auto" [s] of each robot (robots,) for a law of ``level``: latency, wheel lag and half a period."""
        lags = np.array([wheel_lag(robot) for robot in self.robots])
        lag = lags if level == "velocity" and self.plant == "dynamic" else np.zeros_like(lags)
        return self.latency + lag + self.period / 2

    def starting_places(self, runs: int, around: np.ndarray, reach: float | np.ndarray) -> np.ndarray:
        """The abscissae [m] (runs, robots) of the paths' points nearest to where robots start.

        Args:
            runs: Number of runs.
            around: Where they are looked for [m], of a shape that fits (runs, robots).
            reach: How far to both sides of that [m], one number or of such a shape: (runs, robots).
        """
        pose = np.broadcast_to(self.starts, (runs, len(self.robots), 3))
        return self.references.joined.nearest(pose[..., 0], pose[..., 1], around, np.asarray(reach))
