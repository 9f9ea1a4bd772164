"""Scenarios: what is simulated, read from TOML into frozen dataclasses at the edge.

A scenario says which robots start where, on which paths with which timing, how they sense, how late commands
arrive, and for how long. Units are SI and radians throughout. Everything wrong with a file is a
:class:`ScenarioError` that names the file, the line, the field and what is accepted.
"""

import re
import tomllib
import types
from collections.abc import Sequence
from dataclasses import MISSING, dataclass, field, fields
from importlib import resources
from math import isfinite, pi
from pathlib import Path as FilePath
from typing import Any, Literal, Union, get_args, get_origin, get_type_hints

import numpy as np

from fuzzy.errors import InputError
from fuzzy.naming import expected
from robotics.environment.obstacletable import obstacle_from_table
from robotics.environment.world import Obstacle, Obstacles, World, WorldError, compile_world
from robotics.path import SHAPES, PathError, Shape, compile_path
from robotics.quantity import accepted, check_quantities, is_number, quantity
from robotics.radio import PRESETS, Fault, Radio, RadioError
from robotics.robot import Robot, RobotError
from robotics.trajectory import Timing, Trajectory, compile_trajectory

Pose = tuple[float, float, float]


class ScenarioError(InputError):
    """A scenario that cannot be run. The message names the file, line, field and accepted values."""


@dataclass(frozen=True, kw_only=True)
class Sensing:
    """How a robot knows its posture.

    ``posture`` "odometry": from its encoders alone, starting from where it believes to stand (``start``).
    "pose": the true pose with white noise, drawn afresh every period; with a ``filter_gain`` below 1 a complementary
    filter joins both, predicting by odometry and correcting by that share.
    """

    posture: Literal["odometry", "pose"] = "odometry"
    position_noise: float = quantity(0.0, "m", least=0, most=10)  # standard deviation in x and in y, for "pose"
    heading_noise: float = quantity(0.0, "rad", least=0, most=pi)  # standard deviation, for "pose"
    relative_noise: float = quantity(0.0, "1", least=0, most=1)  # x and y times 1 + this × normal (thesis 4.5: 0.1)
    noise_start: float = quantity(0.0, "s", least=0)  # the noise acts from then on
    noise_end: float | None = quantity(None, "s", above=0)  # and until then; none: to the end
    filter_gain: float = quantity(1.0, "1", above=0, most=1)  # 1: no filter
    # What odometry takes a wheel's radius and the axle to be: relative standard deviations over the seeds
    wheel_error: float = quantity(0.0, "1", least=0, most=0.2)
    axle_error: float = quantity(0.0, "1", least=0, most=0.2)
    # How far the robot truly stands from where it believes to stand: standard deviations over the seeds
    start_position: float = quantity(0.0, "m", least=0, most=10)
    start_heading: float = quantity(0.0, "rad", least=0, most=pi)

    def __post_init__(self) -> None:
        check_quantities(self, ScenarioError)
        own: dict[str, float | None] = {"position_noise": 0, "heading_noise": 0, "relative_noise": 0, "filter_gain": 1}
        own |= {"noise_start": 0, "noise_end": None}
        for name, default in own.items():
            if self.posture == "odometry" and getattr(self, name) != default:
                raise ScenarioError(f'{name} belongs to posture = "pose"; odometry has its own')
        if self.noise_end is not None and self.noise_end <= self.noise_start:
            problem = ScenarioError(f"noise_end must be > noise_start, {self.noise_start:g} s; got {self.noise_end:g}")
            problem.field = "noise_end"  # type: ignore[attr-defined]
            raise problem


@dataclass(frozen=True, kw_only=True)
class Member:
    """One robot of a scenario: where it starts, where it shall go and when, and what it is."""

    start: Pose  # x [m], y [m], heading [rad]
    path: Shape
    timing: Timing
    robot: Robot = field(default_factory=Robot)
    sensing: Sensing | None = None  # its own; none: the scenario's

    def __post_init__(self) -> None:
        if not all(isfinite(v) for v in self.start):
            raise ScenarioError(f"start must be finite, got {self.start!r}")
        if abs(self.start[2]) > 2 * pi:
            problem = ScenarioError(
                f"start: the heading is in radians, between -2π and 2π; got {self.start[2]!r}"
                + (" (degrees?)" if abs(self.start[2]) <= 360 else "")
            )
            problem.field = "start"  # type: ignore[attr-defined]
            raise problem


@dataclass(frozen=True, kw_only=True)
class Scenario:
    """Robots, time and sensing. The trajectory is compiled, and checked to be drivable, on construction."""

    name: str
    robots: tuple[Member, ...]
    duration: float = quantity(30.0, "s", above=0, most=86400)
    latency: float = quantity(0.0, "s", least=0, most=2)  # from deciding on a command to its effect, steps of 10 ms
    period: float = quantity(0.05, "s", above=0, most=1)  # of the high-level controller, in steps of 10 ms
    plant: Literal["dynamic", "kinematic"] = "dynamic"
    divergence: float = quantity(10.0, "m", above=0)  # a robot this far from its reference is stopped
    sensing: Sensing = field(default_factory=Sensing)
    # Each robot its own reference; a leader and followers; or a team that shall arrive together
    kind: Literal["tracking", "formation", "team"] = "tracking"
    controller: str = ""  # the one to run if no other is asked for
    radio: Radio = field(default_factory=Radio)  # of a team
    faults: tuple[Fault, ...] = ()
    obstacles: tuple[Obstacle, ...] = ()  # the robots do not know them, they only sense them
    title: str = ""
    source: str = ""  # thesis section or paper, and what was chosen here
    trajectory: Trajectory = field(init=False, repr=False, compare=False)
    world: Obstacles | None = field(init=False, repr=False, compare=False)  # none: no obstacles

    def __post_init__(self) -> None:
        check_quantities(self, ScenarioError)
        if not self.robots:
            raise ScenarioError("a scenario needs at least one robot: [[robots]]")
        for name in ("period", "latency"):
            steps = getattr(self, name) / STEP
            if abs(steps - round(steps)) > 1e-9:
                raise _about(
                    ScenarioError(f"{name} must be a multiple of {STEP:g} s, got {getattr(self, name)!r}"), name
                )
        if self.ticks < 1:
            raise _about(
                ScenarioError(f"duration must be at least a period, {self.period:g} s; got {self.duration!r}"),
                "duration",
            )
        self._check_team()
        trajectory = _compiled(self.robots)
        object.__setattr__(self, "trajectory", trajectory)
        world = compile_world(World(obstacles=self.obstacles, known=False)) if self.obstacles else None
        object.__setattr__(self, "world", world)
        self._check_feasible(trajectory)

    @property
    def ticks(self) -> int:
        """How many periods the scenario lasts."""
        return round(self.duration / self.period)

    @property
    def times(self) -> np.ndarray:
        """The times of the samples (ticks + 1,) [s], both ends included."""
        return np.arange(self.ticks + 1) * self.period

    @property
    def starts(self) -> np.ndarray:
        """Where the robots start (robots, 3): x [m], y [m], heading [rad]."""
        return np.array([member.start for member in self.robots])

    def _check_team(self) -> None:
        """Robots that the radio and the faults name exist, and a team has one duration for all."""
        count = len(self.robots)
        try:
            self.radio.adjacency(count)
        except RadioError as error:
            raise _about(error, "radio", getattr(error, "field", "graph")) from None
        every = self.radio.period / self.period
        if self.kind == "team" and (round(every) < 1 or abs(every - round(every)) > 1e-9):
            raise _about(
                ScenarioError(f"radio: period must be a multiple of {self.period:g} s, got {self.radio.period:g}"),
                "radio",
                "period",
            )
        for i, fault in enumerate(self.faults):
            for name in ("robot", "other"):
                number = getattr(fault, name)
                if number is not None and not 1 <= number <= count:
                    problem = ScenarioError(f"{name} must be a robot, 1 to {count}; got {number}")
                    raise _about(problem, "faults", i, name)
        if self.kind == "team":
            if count < 2:
                raise _about(ScenarioError("a team needs at least two robots"), "robots")
            durations = [member.timing.duration for member in self.robots]
            for i, (member, duration) in enumerate(zip(self.robots, durations, strict=True)):
                if duration is None or duration != durations[0] or member.timing.ramp != self.robots[0].timing.ramp:
                    problem = ScenarioError("a team arrives together: every timing has the same duration and ramp")
                    raise _about(problem, "robots", i, "timing")

    def _check_feasible(self, trajectory: Trajectory) -> None:
        """Refuse a reference that no command can follow: |v| + L |ω| beyond what the wheels can turn."""
        # Every 10 ms, not every period: a sharp corner lasts no longer.
        span = min(self.duration, trajectory.ends.max())
        times = np.linspace(0.0, span, min(round(span / STEP), 100_000) + 1)
        reference = trajectory.sampled(times)
        for i, member in enumerate(self.robots):
            robot = member.robot
            v, w = np.abs(reference.v[:, i]), np.abs(reference.w[:, i])
            for need, limit, what in (
                (v + robot.half_axle * w, robot.wheel_speed_limit, "|v| + L |ω| = {:.4g} m/s exceeds r ω_wheel ="),
                (v, robot.v_max, "|v| = {:.4g} m/s exceeds v_max ="),
                (w, robot.w_max, "|ω| = {:.4g} rad/s exceeds w_max ="),
            ):
                k = int(np.argmax(need))
                if need[k] > limit * (1 + 1e-9):
                    place = f"({reference.x[k, i]:.3f}, {reference.y[k, i]:.3f}) m, abscissa {reference.s[k, i]:.3f} m"
                    problem = ScenarioError(
                        f"robot {i + 1}: the reference is infeasible: at t = {times[k]:.2f} s, {place}, "
                        f"{what.format(need[k])} {limit:.4g} by {need[k] - limit:.3g} "
                        f"({100 * (need[k] / limit - 1):.1f} %); slow the timing down or smooth the path"
                    )
                    raise _about(problem, "robots", i, "timing")


def _compiled(robots: tuple[Member, ...]) -> Trajectory:
    """The robots' trajectory. An error is about the robot's path or about its timing."""
    parts = []
    for i, member in enumerate(robots):
        try:
            path = compile_path(member.path)
        except PathError as error:
            raise _about(error, "robots", i, "path") from None
        try:
            parts.append(compile_trajectory((path,), (member.timing,)))
        except PathError as error:
            raise _about(error, "robots", i, "timing") from None
    return Trajectory(
        tuple(part.paths[0] for part in parts),
        np.concatenate([part.tables for part in parts]),
        np.concatenate([part.ends for part in parts]),
    )


STEP = 0.01  # s, the wheel loops' period (thesis 2.1.3.1)


def _about(error: ValueError, *keys: str | int) -> ValueError:
    """Mark which keys of the file an error is about, so that the reader can name the line."""
    error.keys = keys  # type: ignore[attr-defined]
    return error


# Reading --------------------------------------------------------------------------------------------------------


def scenario_names(kind: str | None = None) -> list[str]:
    """The scenarios that come with the package; with ``kind`` those of one kind, "tracking" or "formation"."""
    folder = resources.files("robotics") / "scenarios"
    names = sorted(f.name.removesuffix(".toml") for f in folder.iterdir() if f.name.endswith(".toml"))
    return names if kind is None else [name for name in names if load_scenario(name).kind == kind]


def load_scenario(name: str | FilePath) -> Scenario:
    """The scenario of that name, or in that ``.toml`` file. Raises ScenarioError."""
    if str(name) in scenario_names():
        file = resources.files("robotics") / "scenarios" / f"{name}.toml"
        return parse_scenario(file.read_text(encoding="utf-8"), str(name), f"{name}.toml")
    path = FilePath(name)
    if path.suffix != ".toml":
        raise ScenarioError(f"{expected(str(name), scenario_names(), 'scenario')}; or the path of a .toml file")
    try:
        text = path.read_text(encoding="utf-8")
    except (OSError, ValueError) as error:
        reason = "it is not UTF-8 text" if isinstance(error, UnicodeDecodeError) else str(error)
        reason = (error.strerror or reason) if isinstance(error, OSError) else reason
        raise ScenarioError(f"{path}: cannot be read: {reason}") from None
    return parse_scenario(text, path.stem, str(path))


def parse_scenario(text: str, name: str, file: str = "<text>") -> Scenario:
    """The scenario that ``text`` (TOML) describes; ``file`` is what messages call it. Raises ScenarioError."""
    try:
        table = tomllib.loads(text)
    except (ValueError, RecursionError) as error:  # besides TOMLDecodeError: an endless number, an endless nesting
        line = re.search(r"at line (\d+)", str(error))
        end = f":{text.count(chr(10)) + 1}" if isinstance(error, tomllib.TOMLDecodeError) else ""
        where = f":{line[1]}" if line else end
        raise ScenarioError(f"{file}{where}: this is not TOML: {error}") from None
    try:
        return scenario_from_table(table, name)
    except InputError as error:
        keys = getattr(error, "keys", ())
        line_number = _line_of(text, keys)
        raise ScenarioError(f"{file}:{line_number}: {error}") from None


def scenario_from_table(table: dict[str, Any], name: str) -> Scenario:
    """The scenario of a TOML file's ``table``, which is left as it is.

    Raises an InputError whose attribute ``keys``, if it has one, says which keys of the table it is about.
    """
    rest = dict(table)
    common = rest.pop("robot", {})
    _expect_table(common, ("robot",))
    members = rest.pop("robots", [])
    if not (isinstance(members, list) and members):
        raise _about(ScenarioError("at least one [[robots]] table is needed"), "robots")
    robots = tuple(_member(m, common, ("robots", i)) for i, m in enumerate(members))
    scenario: Scenario = _build(Scenario, rest, (), name=name, robots=robots)
    if scenario.controller:
        from robotics.catalogue import make_controller  # a controller knows scenarios, not the other way round

        try:  # its gains may not suit the graph, its messages not the radio
            law = make_controller(scenario.controller)
            law.init(scenario, 1)
            scenario.radio.check_bandwidth(len(robots), len(getattr(law, "message", ())))
        except RadioError as error:
            raise _about(error, "radio", getattr(error, "field", "period")) from None
        except InputError as error:
            raise _about(error, "controller") from None
    return scenario


def _member(table: Any, common: dict[str, Any], keys: tuple[str | int, ...]) -> Member:
    _expect_table(table, keys)
    table = dict(table)
    own = table.pop("robot", {})
    _expect_table(own, (*keys, "robot"))
    robot = _build(Robot, common, ("robot",))
    if own:
        robot = _build(Robot, {**common, **own}, (*keys, "robot"))
    if "path" not in table:
        raise _about(ScenarioError("a robot needs a path, such as path = { shape = 'sine', amplitude = 1.0 }"), *keys)
    shape = table.pop("path")
    _expect_table(shape, (*keys, "path"))
    shape = dict(shape)
    if "shape" not in shape:
        raise _about(ScenarioError(f"path lacks shape, one of {', '.join(SHAPES)}"), *keys, "path")
    kind = shape.pop("shape")
    if not isinstance(kind, str) or kind not in SHAPES:
        raise _about(ScenarioError(expected(str(kind), SHAPES, "path shape")), *keys, "path", "shape")
    path = _build(SHAPES[kind], shape, (*keys, "path"))
    return _build(Member, table, keys, path=path, robot=robot)


def _expect_table(value: Any, keys: tuple[str | int, ...]) -> None:
    if not isinstance(value, dict):
        raise _about(ScenarioError(f"{keys[-1]} must be a table, got {value!r}"), *keys)


def _build(kind: type, table: dict[str, Any], keys: tuple[str | int, ...], **given: Any) -> Any:
    """A dataclass from a TOML table: every key known, every value of the field's type, nothing missing."""
    hints = get_type_hints(kind)
    known = {f.name: f for f in fields(kind) if f.init and f.name not in given and f.name != "name"}
    values = dict(given)
    for key, value in table.items():
        if key not in known:
            also = () if keys else ("robot", "robots")
            raise _about(ScenarioError(expected(key, [*known, *also], "key")), *keys, key)
        values[key] = _convert(value, hints[key], known[key], (*keys, key))
    missing = [n for n, f in known.items() if n not in values and f.default is MISSING and f.default_factory is MISSING]
    if missing:
        raise _about(ScenarioError(f"{kind.__name__.lower()} lacks {', '.join(missing)}"), *keys)
    try:
        return kind(**values)
    except (ScenarioError, PathError, RobotError, RadioError, WorldError) as error:
        if not hasattr(error, "keys"):
            about = getattr(error, "field", None)
            raise _about(error, *keys, *([about] if about else [])) from None
        raise


def _convert(value: Any, hint: Any, f: Any, keys: tuple[str | int, ...]) -> Any:
    def refuse(what: str) -> ValueError:
        return _about(ScenarioError(f"{f.name} must be {what}; got {value!r}"), *keys)

    origin = get_origin(hint)
    if origin in (Union, types.UnionType):
        hint = next(h for h in get_args(hint) if h is not type(None))
        origin = get_origin(hint)
    if hint in (Sensing, Timing, Radio):
        _expect_table(value, keys)
        if hint is Radio and "preset" in value:
            value = dict(value)
            preset = value.pop("preset")
            if not isinstance(preset, str) or preset not in PRESETS:
                raise _about(ScenarioError(expected(str(preset), PRESETS, "radio preset")), *keys, "preset")
            value = {**PRESETS[preset], **value}
        return _build(hint, value, keys)
    if hint == tuple[Obstacle, ...]:
        if not isinstance(value, list):
            raise refuse("tables [[obstacles]]")
        for i, row in enumerate(value):
            _expect_table(row, (*keys, i))
        return tuple(obstacle_from_table(row, (*keys, i), _build) for i, row in enumerate(value))
    if hint == tuple[Fault, ...]:
        if not isinstance(value, list):
            raise refuse("tables [[faults]]")
        for i, row in enumerate(value):
            _expect_table(row, (*keys, i))
        return tuple(_build(Fault, row, (*keys, i)) for i, row in enumerate(value))
    if hint is int:
        if isinstance(value, bool) or not isinstance(value, int):
            raise refuse("a whole number")
        return value
    if origin is Literal:
        if value not in get_args(hint):
            raise refuse("one of " + ", ".join(map(repr, get_args(hint))))
        return value
    if hint is float:
        if not is_number(value):
            raise refuse(accepted(f.metadata) if "unit" in f.metadata else "a finite number")
        return float(value)
    if hint is str:
        if not isinstance(value, str):
            raise refuse("text in quotes")
        return value
    if origin is tuple:
        inner = get_args(hint)
        if inner == (tuple[int, int], Ellipsis):
            good = isinstance(value, list) and all(isinstance(e, list) and len(e) == 2 for e in value)
            if not (good and all(type(i) is int for e in value for i in e)):
                raise refuse("a list of pairs [sender, receiver], robots counted from 1")
            return tuple((a, b) for a, b in value)
        if inner[-1] is Ellipsis:
            if not isinstance(value, list):
                raise refuse("a list of points [x, y]")
            return tuple(_numbers(row, 2, refuse) for row in value)
        return _numbers(value, len(inner), refuse)
    raise TypeError(f"a field of type {hint!r} cannot be read from TOML")


def _numbers(value: Any, count: int, refuse: Any) -> tuple[float, ...]:
    shape = {2: "[x, y] in m", 3: "[x, y, heading] in m, m, rad"}[count]
    good = isinstance(value, Sequence) and not isinstance(value, str) and len(value) == count
    if not (good and all(is_number(v) for v in value)):
        raise refuse(f"{count} finite numbers {shape}")
    return tuple(float(v) for v in value)


_HEADER = re.compile(r"^\s*(\[\[?)\s*([^\]]+?)\s*\]\]?\s*(#.*)?$")
_KEY = re.compile(r"^\s*([\w\-\".]+)\s*=")


def _line_of(text: str, keys: tuple[str | int, ...]) -> int:
    """The line (from 1) where ``keys`` stand in TOML ``text``: the deepest of them that has a line of its own."""
    wanted = [str(k) for k in keys]
    best, best_depth = 1, 0
    prefix: list[str] = []
    counts: dict[str, int] = {}
    for number, line in enumerate(text.splitlines(), start=1):
        header, key = _HEADER.match(line), _KEY.match(line)
        if header:
            names = [n.strip().strip('"') for n in header[2].split(".")]
            if header[1] == "[[":
                counts[header[2]] = counts.get(header[2], -1) + 1
            prefix = [part for n in names for part in ([n, str(counts[n])] if n in counts else [n])]
            here = prefix
        elif key:
            here = prefix + [n.strip('"') for n in key[1].split(".")]
        else:
            continue
        depth = 0
        while depth < min(len(here), len(wanted)) and here[depth] == wanted[depth]:
            depth += 1
        if depth == len(here) and depth > best_depth:
            best, best_depth = number, depth
    return best
