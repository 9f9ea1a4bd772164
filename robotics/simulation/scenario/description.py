"""Scenarios: descriptions of what is simulated, as frozen dataclasses.

A scenario says which robots start where, on which paths with which timing, how they sense, how late commands
arrive, and for how long. Units are SI and radians throughout. A scenario that cannot be run is a
:class:`ScenarioError` that names the field and what is accepted.
"""

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from math import dist, pi
from pkgutil import resolve_name
from typing import Any, Literal

import numpy as np

from fuzzy.errors import InputError, concerning
from fuzzy.quantity import LARGEST_NUMBER, check_quantities, described, is_number, quantity
from fuzzy.shown import shown
from fuzzy.sketch import lines, table, titled
from fuzzy.words import counted
from robotics.laws.knowledge import Knowledge
from robotics.laws.setting import Kind, Safety, Setting
from robotics.simulation.scenario.feasibility import demands
from robotics.simulation.scenario.robots import RobotModel, standard_robot
from robotics.world.environment.world import Obstacle, World, compile_world
from robotics.world.paths.goal import Goal
from robotics.world.paths.offset import Offset, compile_offset
from robotics.world.paths.path import Shape
from robotics.world.paths.trajectory import Timing, Trajectory, compile_motion, together
from robotics.world.radio.description import Radio
from robotics.world.radio.faults import Fault
from robotics.world.sensing.posture import Sensing
from robotics.world.sensing.sonar import RangeSensor
from robotics.world.vehicle.floor import Patch
from robotics.world.vehicle.plant import STEP
from robotics.world.vehicle.robot import Robot

Pose = tuple[float, float, float]
_NO_PATH = "a robot needs a path, such as path = { shape = 'sine', amplitude = 1.0 }"
# In a notebook
_ROBOTS_DRAWN = 12
_POINTS_DRAWN = 200  # of a path


class ScenarioError(InputError):
    """A scenario that cannot be run. The message names the file, line, field and accepted values."""


class InfeasibleError(ScenarioError):
    """A scenario with a reference that no command can follow, and in which nothing else is wrong."""

    scenario: "Scenario"  # complete but for that


@dataclass(frozen=True, kw_only=True)
class Member:
    """One robot of a scenario: its start, path, timing, parameters and sensors.

    Attributes:
        goal: The path and the timing of a robot with a goal are those of :meth:`Goal.motion`; :meth:`reaching` makes
            such a robot.
        model: What the robot was made of; None: only its numbers are known.

    Raises:
        ScenarioError: Parts that do not suit each other.
    """

    start: Pose = described(
        "Where the robot starts: x, y and heading; with an offset it may be left out.", example=[0.0, 0.0, 0.0]
    )
    path: Shape = described("The path that the robot shall follow.", missing=_NO_PATH)
    timing: Timing = described("The timetable of the robot along its path.")
    goal: Goal | None = described("Where the robot shall come to, at no stated time, instead of path and timing.", None)
    start_spread: Pose = described(
        "How far each seed's start lies from start at most, evenly: in x, y and heading.", (0.0, 0.0, 0.0)
    )
    robot: Robot = described(
        "Which robot this one is, instead of the one of all.", default_factory=lambda: standard_robot().robot
    )
    model: RobotModel | None = None
    sensing: Sensing | None = described("How this robot knows its posture, instead of [sensing].", None)
    sensors: Mapping[str, RangeSensor] | None = described(
        "The range sensors of this robot, instead of [[sensors]].", None
    )

    def __post_init__(self) -> None:
        if self.model is None and self.robot is standard_robot().robot:  # nothing was said of it
            object.__setattr__(self, "model", standard_robot())
        if not all(is_number(v) for v in self.start):
            what = f"start must be finite, its numbers {LARGEST_NUMBER:g} in size at most; got {self.start!r}"
            raise ScenarioError(what)
        if not all(is_number(v) and v >= 0 for v in self.start_spread):
            what = f"start_spread must be three numbers >= 0, in m, m and rad; got {self.start_spread!r}"
            raise ScenarioError(what).about("start_spread")
        if abs(self.start[2]) > 2 * pi:
            raise ScenarioError(
                f"start: the heading is in radians, between -2π and 2π; got {self.start[2]!r}"
                + (" (degrees?)" if abs(self.start[2]) <= 360 else "")
            ).about("start")

    @classmethod
    def reaching(cls, goal: Goal, start: Pose, **more: Any) -> "Member":
        """A robot that shall come to a goal.

        Args:
            goal: The goal.
            start: Where it starts: x [m], y [m], heading [rad].
            more: Other fields.

        Raises:
            ScenarioError: Parts that do not suit each other.
        """
        path, timing = goal.motion(start)
        return cls(start=start, path=path, timing=timing, goal=goal, **more)


@dataclass(frozen=True, kw_only=True)
class VirtualRobot:
    """The virtual robot from which offsets are measured, thesis (3.3). Raises PathError."""

    path: Shape = described("The path of the virtual robot.", missing=_NO_PATH)
    timing: Timing = described(
        "The timetable of the virtual robot along its path.",
        missing="the virtual robot needs a timing, such as timing = { duration = 30.0 }",
    )

    def __post_init__(self) -> None:
        compile_motion(self.path, self.timing)


@dataclass(frozen=True, kw_only=True)
class Scenario:
    """A scenario: its robots, their sensing and radio, the obstacles, and time.

    On construction the trajectory is compiled, and checked to be drivable.

    Attributes:
        name: What it is called: its file's name.
        robots: The robots, in the order of their numbers.
        trajectory: The paths with their timing, for all robots.
        setting: The compiled scenario, for a simulation and its law.

    Raises:
        ScenarioError: A scenario that cannot be run.
    """

    name: str
    robots: tuple[Member, ...]
    duration: float = quantity(30.0, "s", above=0, most=86400, doc="How long the run lasts.")
    latency: float = quantity(
        0.0, "s", least=0, most=2, doc="The time from deciding on a command to its effect, in steps of 10 ms."
    )
    period: float = quantity(
        0.05, "s", above=0, most=1, doc="The period in which a controller decides, in steps of 10 ms."
    )
    plant: Literal["dynamic", "kinematic"] = described(
        "Whether robots have mass and motors, or do at once what is commanded.", "dynamic"
    )
    divergence: float = quantity(
        10.0, "m", above=0, doc="The distance from its reference at which a robot is stopped, as diverged."
    )
    sensing: Sensing = described("How the robots know their posture.", default_factory=Sensing)
    knowledge: Knowledge = described("Knowledge for every law that can use it.", default_factory=Knowledge)
    sensors: Mapping[str, RangeSensor] | None = described(
        "The range sensors that each robot carries; left out: those of the robot's own file.", None
    )
    kind: Kind = described(
        "What the robots do: each follows its own path (tracking), followers keep to a leader (formation), all arrive "
        "together (team), or each comes to its goal (goal).",
        "tracking",
    )
    controller: str = described(
        "The controller to run if no other is asked for: name or name:gain=value,...", "", example="fuzzy"
    )
    radio: Radio = described("The radio of a team.", default_factory=Radio)
    faults: tuple[Fault, ...] = described("Faults of robots and of their radio.", ())
    obstacles: tuple[Obstacle, ...] = described("Obstacles, which the robots do not know but only sense.", ())
    patches: tuple[Patch, ...] = described("Patches of the floor where its friction is another.", ())
    safety: Safety = described(
        "passive: below any controller a monitor keeps each robot from driving into what its sensors could see, or "
        "into a robot that it hears; left out: there is none.",
        "",
        example="passive",
    )
    others_speed: float | None = quantity(
        None,
        "m/s",
        least=0,
        most=10,
        doc="The greatest speed of what moves among the obstacles, which that monitor assumes; left out: that of the "
        "fastest one.",
        example=0.2,
    )
    metrics: tuple[str, ...] = described(
        "Metrics of the task: they come first in tables, and alone in short ones and pictures; the first one says who "
        "leads. A name, or file.py:function of your own.",
        (),
        example=["control_effort"],
    )
    title: str = described("What happens, in a line.", "", example="What happens")
    source: str = described(
        "Where the numbers come from: a paper, a section of a book; and what was chosen.", "", example="a choice"
    )
    trajectory: Trajectory = field(init=False, repr=False, compare=False)
    setting: Setting = field(init=False, repr=False, compare=False)

    def __post_init__(self) -> None:
        check_quantities(self, ScenarioError)
        if not self.robots:
            raise ScenarioError("a scenario needs at least one robot: [[robots]]")
        for name in ("period", "latency"):
            steps = getattr(self, name) / STEP
            if abs(steps - round(steps)) > 1e-9:
                raise ScenarioError(f"{name} must be a multiple of {STEP:g} s, got {getattr(self, name)!r}").about(name)
        if self.patches and self.plant == "kinematic":
            raise ScenarioError(
                'patches of the floor are for plant = "dynamic": the kinematic one slips nowhere'
            ).about("patches")
        if self.ticks < 1:
            what = f"duration must be at least a period, {self.period:g} s; got {self.duration!r}"
            raise ScenarioError(what).about("duration")
        self._check_team()
        for i, member in enumerate(self.robots):
            if (member.goal is None) == (self.kind == "goal"):
                what = 'kind = "goal" is for robots with a goal, each of them, and robots with a goal are of that kind'
                raise ScenarioError(f"robot {i + 1} has {'no' if member.goal is None else 'a'} goal: {what}").about(
                    "kind" if member.goal else "robots", *(() if member.goal else (i,))
                )
        self._check_metrics()
        trajectory = _trajectory(self.robots)
        object.__setattr__(self, "trajectory", trajectory)
        object.__setattr__(self, "setting", self._compiled())
        self._check_feasible(trajectory)

    def __repr__(self) -> str:
        title = f", {self.title!r}" if self.title else ""
        return f"Scenario({self.name!r}{title}: {self._counted()})"

    def _repr_html_(self) -> str:
        """What a notebook shows: the title, the conditions, and the paths from above."""
        few = slice(_ROBOTS_DRAWN)
        on = self.trajectory.sampled(np.linspace(0.0, self.duration, _POINTS_DRAWN))
        paths = [list(zip(x, y, strict=True)) for x, y in zip(on.x.T[few].tolist(), on.y.T[few].tolist(), strict=True)]
        rows = [
            ["controller", self.controller or "fuzzy"],
            ["source", self.source],
            ["references", lines(paths, size=(320.0, 200.0), equal=True)],
        ]
        return titled(self.title or self.name, f"({self.name}): {self._counted()}", table((), rows))

    def _counted(self) -> str:
        among = f", {counted(len(self.obstacles), 'obstacle')}" if self.obstacles else ""
        return f"{self.kind}, {counted(len(self.robots), 'robot')}{among}, {shown(self.duration)} s"

    def spread(self, spread: Pose) -> "Scenario":
        """The same with each seed's start within ``spread`` [m, m, rad] of every robot's. Raises ScenarioError."""
        return replace(self, robots=tuple(replace(member, start_spread=spread) for member in self.robots))

    def with_robot(self, model: RobotModel) -> "Scenario":
        """The same with every robot of a ``model``, which carries its own sensors. Raises ScenarioError."""
        robots = tuple(replace(each, robot=model.robot, model=model, sensors=None) for each in self.robots)
        return replace(self, robots=robots, sensors=None)

    @property
    def ticks(self) -> int:
        """The number of control periods."""
        return round(self.duration / self.period)

    @property
    def times(self) -> np.ndarray:
        """The times of the samples (ticks + 1,) [s], both ends included."""
        return self.setting.times

    @property
    def starts(self) -> np.ndarray:
        """The start poses (robots, 3): x [m], y [m], heading [rad]."""
        return np.array([member.start for member in self.robots])

    def _compiled(self) -> Setting:
        return Setting(
            name=self.name,
            kind=self.kind,
            robots=tuple(member.robot for member in self.robots),
            starts=self.starts,
            start_spread=np.array([member.start_spread for member in self.robots]),
            goals=tuple(member.goal.reach for member in self.robots if member.goal is not None),
            references=self.trajectory,
            radio=self.radio,
            sensing=tuple(member.sensing or self.sensing for member in self.robots),
            sensors=tuple(self._sensors(member) for member in self.robots),
            world=compile_world(World(obstacles=self.obstacles, known=False)) if self.obstacles else None,
            faults=self.faults,
            ticks=self.ticks,
            period=self.period,
            latency=self.latency,
            plant=self.plant,
            divergence=self.divergence + self._way_off(),
            knowledge=self.knowledge,
            safety=self.safety,
            others_speed=self.others_speed,
            patches=self.patches,
        )

    def _way_off(self) -> float:
        """How far goals lie from where robots start [m]: that far from them nobody has diverged."""
        if self.kind != "goal":
            return 0.0
        begin = self.trajectory.at(0.0)
        return max(dist(m.start[:2], (begin.x[i], begin.y[i])) for i, m in enumerate(self.robots))

    def _sensors(self, member: Member) -> Mapping[str, RangeSensor]:
        """The range sensors that a robot carries: its own, else the scenario's, else its model's."""
        carried = self.sensors if member.sensors is None else member.sensors
        if carried is None:
            return member.model.sensors if member.model else {}
        return carried

    def _check_team(self) -> None:
        """Refuse robots that do not exist in the radio and the faults, and a team with several durations."""
        count = len(self.robots)
        with concerning("radio"):
            self.radio.adjacency(count)
        every = self.radio.period / self.period
        if self.kind == "team" and (round(every) < 1 or abs(every - round(every)) > 1e-9):
            raise ScenarioError(
                f"radio: period must be a multiple of {self.period:g} s, got {self.radio.period:g}"
            ).about("radio", "period")
        for i, fault in enumerate(self.faults):
            for name in ("robot", "other"):
                number = getattr(fault, name)
                if number is not None and not 1 <= number <= count:
                    problem = ScenarioError(f"{name} must be a robot, 1 to {count}; got {number}")
                    raise problem.about("faults", i, name)
        if self.kind == "team":
            if count < 2:
                raise ScenarioError("a team needs at least two robots").about("robots")
            durations = [member.timing.duration for member in self.robots]
            for i, (member, duration) in enumerate(zip(self.robots, durations, strict=True)):
                if duration is None or duration != durations[0] or member.timing.ramp != self.robots[0].timing.ramp:
                    problem = ScenarioError("a team arrives together: every timing has the same duration and ramp")
                    raise problem.about("robots", i, "timing")

    def _check_metrics(self) -> None:
        """Refuse metrics that scenarios of this kind have not. Runs are measured above, where metrics have names."""
        if self.metrics:
            try:
                resolve_name("robotics.measures.registry:chosen_metrics")(self.metrics, self.kind)
            except InputError as error:
                raise ScenarioError(str(error)).about("metrics", *error.at) from None

    def _check_feasible(self, trajectory: Trajectory) -> None:
        """Refuse a reference that no command can follow: |v| + L |ω| beyond what the wheels can turn."""
        for demand in demands([member.robot for member in self.robots], trajectory, self.duration):
            if not demand.feasible:
                place = f"({demand.x:.3f}, {demand.y:.3f}) m, abscissa {demand.s:.3f} m"
                problem = InfeasibleError(
                    f"robot {demand.robot + 1}: the reference is infeasible: at t = {demand.time:.2f} s, {place}, "
                    f"{demand.words}; slow the timing down or smooth the path"
                )
                problem.scenario = self
                raise problem.about("robots", demand.robot, "timing")


def _trajectory(robots: tuple[Member, ...]) -> Trajectory:
    """Compile the robots' trajectory. A PathError is about the robot's path or about its timing."""
    parts = []
    for i, member in enumerate(robots):
        if isinstance(member.path, Offset):
            with concerning("robots", i, "offset"):
                parts.append(compile_offset(member.path, member.timing))
        else:
            with concerning("robots", i):
                parts.append(compile_motion(member.path, member.timing))
    return together(parts)
