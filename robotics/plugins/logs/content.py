"""What stands in the log of a run: topics, and their messages in the order of time.

Of one seed. What a run does not keep (encoders, messages and their ages, ranges, inputs of rule bases) is not logged.
Stamps count from the run's start. Of a robot that was stopped only its state is logged from then on.
"""

from collections.abc import Iterator, Sequence
from importlib.metadata import version
from typing import Any, NamedTuple

import numpy as np

from fuzzy.figures.palette import COLORS, ROLES
from fuzzy.files.fisfile import FisFileError, format_fis
from robotics.laws.modes import MODES
from robotics.measures.decisions import decisions, shares
from robotics.plugins.logs import names as topics
from robotics.plugins.logs.messages import Composer
from robotics.plugins.logs.names import MAP, SCENE, Names, token
from robotics.simulation.channels import CHANNELS, TEAM_CHANNELS
from robotics.simulation.run import REFERENCE, Run
from robotics.world.radio.faults import FAULTS
from robotics.world.sensing.carried import sensor_names

HEIGHT, LINE = 0.12, 0.02  # m: of bodies, of lines
# Types of visualization_msgs/Marker
_CUBE = 1
_CYLINDER = 3
_LINES = 5
_MOST_POINTS = 1001  # of a path: as many as that are drawn, and read back
_TO = ("progress", "x_target", "y_target", "heading_target")


class LogRecord(NamedTuple):
    """One message of a log."""

    time: float  # s since the run's start
    topic: str
    message: Any
    once: bool = False  # it holds for the whole run: whoever comes later gets it too


def facts(run: Run, seed: int) -> dict[str, str]:
    """What a log says of its run beside its topics, in words."""
    about = {"scenario": run.scenario, "controller": run.controller, "seed": str(seed)}
    return about | {"fuzzyfleet": version("fuzzyfleet")}


def records(run: Run, seed: int, composer: Composer) -> Iterator[LogRecord]:
    """The messages of the log of the run of ``seed``, in the order of time."""
    return _Log(run.only(seed), seed, composer).all()


class _Log:
    """The log of a run of one seed."""

    def __init__(self, run: Run, seed: int, make: Composer) -> None:
        self.run, self.seed, self.make = run, seed, make
        count = len(run.about.robots)
        self.robots = tuple(Names.of(i, count) for i in range(1, count + 1))
        # What each rule base was asked, and how strongly its rules fired (samples, robots, rules)
        asked = decisions(run, 0) if run.about.rule_bases and run.inputs is not None else ()
        self.fired = [(each, each.firing()) for each in asked]
        self.frame = {name: run[name][0] for name in CHANNELS}  # (robots, samples) each
        self.frame |= {f"{name}_reference": run.target(name) for name in REFERENCE}
        none = np.full_like(self.frame["x"], np.nan)
        self.frame |= {name: run[name][0] if run.team is not None else none for name in _TO}

    def all(self) -> Iterator[LogRecord]:
        yield from self._once()
        for k, time in enumerate(self.run.time.tolist()):
            yield self._transforms(k, time)
            if k and self.run.obstacles is not None and len(self.run.obstacles.circles) > 1:
                yield LogRecord(time, SCENE, bodies(self.run, self.robots, self.make, k, time))
            for robot in range(len(self.robots)):
                yield from self._of(robot, k, time)

    # What is said once ------------------------------------------------------------------------------------------

    def _once(self) -> Iterator[LogRecord]:
        run, make = self.run, self.make
        info = make.make(
            "fuzzyfleet_msgs/RunInfo",
            scenario=run.scenario,
            kind=run.about.kind,
            controller=run.controller,
            level=run.level,
            seed=self.seed,
            version=version("fuzzyfleet"),
            robots=[names.namespace for names in self.robots if names.namespace],
            message=list(run.about.message),
        )
        yield LogRecord(0.0, topics.INFO, info, once=True)
        for each, _ in self.fired:
            base = make.make(
                "fuzzyfleet_msgs/RuleBase",
                task=each.task,
                inputs=[variable.name for variable in each.system.inputs],
                units=[variable.unit or "" for variable in each.system.inputs],
                rules=[str(rule) for rule in each.system.rules],
                fis=_as_fis(each.system),
            )
            yield LogRecord(0.0, topics.rule_base(each.task), base, once=True)
        resting = make.make("tf2_msgs/TFMessage", transforms=[*mounts(run, self.robots, make)])
        yield LogRecord(0.0, topics.STATIC_TRANSFORMS, resting, once=True)
        yield LogRecord(0.0, SCENE, bodies(run, self.robots, make, 0, 0.0), once=True)
        for names, nodes in zip(self.robots, run.paths, strict=True):
            header = make.header(0.0, names.frame("odom"))
            yield LogRecord(0.0, names.topic("path"), make.path(header, _points(nodes)), once=True)

    # What is said in every period -------------------------------------------------------------------------------

    def _transforms(self, k: int, time: float) -> LogRecord:
        """Where all robots are: as they measure it, and in truth."""
        make, rows = self.make, []
        for robot, names in enumerate(self.robots):
            header, world = make.header(time, names.frame("odom")), make.header(time, MAP)
            seen = [float(self.frame[f"{n}_measured"][robot, k]) for n in ("x", "y", "heading")]
            true = [float(self.frame[n][robot, k]) for n in ("x", "y", "heading")]
            if np.isfinite(true).all():
                rows.append(make.transform(header, names.frame("base_link"), *seen))
                rows.append(make.transform(world, names.frame("base_link_true"), *true))
        return LogRecord(time, topics.TRANSFORMS, make.make("tf2_msgs/TFMessage", transforms=rows))

    def _of(self, robot: int, k: int, time: float) -> Iterator[LogRecord]:
        """The messages of one robot."""
        run, names, make = self.run, self.robots[robot], self.make
        frame = {name: float(values[robot, k]) for name, values in self.frame.items()}
        yield LogRecord(time, names.topic("state"), self._state(robot, k, time, frame))
        if not np.isfinite(frame["x"]):
            return
        odom, base = make.header(time, names.frame("odom")), make.header(time, names.frame("base_link"))
        measured = [np.nan] * 4 if run.encoders is None else run.encoders[k, :, 0, robot].tolist()
        told = {
            "odom": ("base_link", "_measured", *measured[2:]),
            "ground_truth": ("base_link_true", "", frame["v"], frame["w"]),
            "reference": ("reference", "_reference", frame["v_reference"], frame["w_reference"]),
        }
        for name, (child, which, v, w) in told.items():
            posture = [frame[f"{n}{which}"] for n in ("x", "y", "heading")]
            yield LogRecord(time, names.topic(name), make.odometry(odom, names.frame(child), posture, v, w))
        ordered = ("command_1", "command_2") if run.level == "velocity" else ("v_demand", "w_demand")
        twist = make.twist(*(frame[name] for name in ordered))
        stamped = make.make("geometry_msgs/TwistStamped", header=base, twist=twist)
        yield LogRecord(time, names.topic("cmd_vel"), stamped)
        if run.encoders is not None:
            yield LogRecord(time, names.topic("joint_states"), self._joints(robot, k, base))
        yield from self._ranges(robot, k, time)
        yield from self._radio(robot, k, time, base)
        yield from self._rules(robot, k, time, base)

    def _state(self, robot: int, k: int, time: float, frame: dict[str, float]) -> Any:
        """All that is kept of a robot in a period."""
        run = self.run
        code = 0.0 if run.team is None else float(run.team[k, [*TEAM_CHANNELS].index("fault"), 0, robot])
        said = {value: name for name, value in FAULTS.items()}
        gone = run.stopped[0, robot] >= 0 and k > run.stopped[0, robot]
        mode = "" if run.modes is None else MODES[int(run.modes[k, 0, robot])]
        return self.make.make(
            "fuzzyfleet_msgs/RobotState",
            header=self.make.header(time, self.robots[robot].frame("odom")),
            mode="stopped" if gone else mode,
            fault="" if not np.isfinite(code) else said.get(int(code), ""),
            guarded=bool(run.guarded is not None and run.guarded[k, 0, robot]),
            **frame,
        )

    def _joints(self, robot: int, k: int, header: Any) -> Any:
        """The wheels: their angles as the encoders count them, their speeds since the last period, their torques."""
        run = self.run
        assert run.encoders is not None
        per_radian = run.about.robots[robot].counts_per_turn / (2 * np.pi)
        now, before = (np.floor(run.encoders[j, 1::-1, 0, robot] * per_radian) for j in (k, max(k - 1, 0)))
        effort = np.zeros(0) if run.torques is None else run.torques[k, ::-1, 0, robot].astype(float)
        return self.make.make(
            "sensor_msgs/JointState",
            header=header,
            name=list(topics.WHEELS),
            position=now / per_radian,
            velocity=(now - before) / per_radian / float(run.time[1] - run.time[0]),
            effort=effort,
        )

    def _ranges(self, robot: int, k: int, time: float) -> Iterator[LogRecord]:
        """What the range sensors read that the robot carries."""
        run, names = self.run, self.robots[robot]
        if run.ranges is None:
            return
        carried = run.about.sensors[robot]
        for place, name in enumerate(sensor_names(run.about.sensors)):
            if name in carried:
                sensor = carried[name]
                header, reading = self.make.header(time, mount(names, name)), float(run.ranges[k, 0, robot, place])
                limits = {"cone": 2 * sensor.half_cone, "least": sensor.minimum, "most": sensor.range}
                message = self.make.range(header, **limits, reading=reading)
                yield LogRecord(time, names.reading(name), message)

    def _radio(self, robot: int, k: int, time: float, header: Any) -> Iterator[LogRecord]:
        """What the robot broadcasts, and how old what it has heard is."""
        run, names, make = self.run, self.robots[robot], self.make
        if run.messages is not None:
            values = run.messages[k, :, 0, robot].tolist()
            if not np.isnan(values).all():
                told = zip(run.about.message, values, strict=True)
                named = [make.make("fuzzyfleet_msgs/NamedValue", name=name, value=value) for name, value in told]
                message = make.make("fuzzyfleet_msgs/RadioMessage", header=header, sender=robot + 1, values=named)
                yield LogRecord(time, names.topic("radio"), message)
        if run.message_ages is not None:
            ages = run.message_ages[k, 0, robot].astype(float)
            message = make.make("fuzzyfleet_msgs/RadioAges", header=header, age=ages)
            yield LogRecord(time, names.topic("radio_ages"), message)

    def _rules(self, robot: int, k: int, time: float, header: Any) -> Iterator[LogRecord]:
        """How the rules of each rule base fired that was asked."""
        for each, firing in self.fired:
            strengths = firing[k, robot]
            if np.isnan(strengths).any():
                continue
            best = int(np.argmax(strengths)) if strengths.size and strengths.max() > 0 else -1
            message = self.make.make(
                "fuzzyfleet_msgs/RuleFiring",
                header=header,
                task=each.task,
                inputs=each.inputs[k, robot].astype(float),
                firing=strengths,
                shares=shares(strengths),
                strongest=best + 1,
                strongest_rule=str(each.system.rules[best]) if best >= 0 else "",
            )
            yield LogRecord(time, topics.firing(self.robots[robot], each.task), message)


def _as_fis(system: Any) -> str:
    """The system as a .fis file; nothing where such a file cannot hold it."""
    try:
        return format_fis(system)
    except FisFileError:
        return ""


def _points(nodes: np.ndarray) -> np.ndarray:
    """A path (n, 3), x, y and heading, through at most MOST_POINTS of its ``nodes`` (2, nodes)."""
    x, y = nodes
    places = np.unique(np.linspace(0, len(x) - 1, _MOST_POINTS).round().astype(int))
    heading = np.arctan2(np.gradient(y), np.gradient(x)) if len(x) > 1 else np.zeros(len(x))
    return np.stack([x, y, heading], axis=-1)[places]


# What stands around: the frames that do not move, robots and obstacles to be drawn ----------------------------------


def mount(names: Names, sensor: str) -> str:
    """The frame of a range sensor."""
    return names.frame(f"range_{token(sensor)}")


def mounts(run: Run, robots: Sequence[Names], make: Composer) -> Iterator[Any]:
    """Where the frames stand that do not move: all robots count from the same place, and carry their sensors."""
    for names, carried in zip(robots, run.about.sensors, strict=True):
        yield make.transform(make.header(0.0, MAP), names.frame("odom"), 0.0, 0.0, 0.0)
        for name, sensor in carried.items():
            header = make.header(0.0, names.frame("base_link"))
            yield make.transform(header, mount(names, name), sensor.x, sensor.y, sensor.axis)


def bodies(run: Run, robots: Sequence[Names], make: Composer, k: int, time: float) -> Any:
    """The bodies of robots, which go with their frames, and of obstacles as they stand at sample ``k``."""
    markers = []
    for i, (names, robot) in enumerate(zip(robots, run.about.robots, strict=True)):
        header = make.header(time, names.frame("base_link_true"))
        place, size = (0.0, 0.0, HEIGHT / 2, 0.0), (robot.length, robot.width, HEIGHT)
        markers.append(make.marker(header, "robots", i, _CUBE, place, size, COLORS[i % len(COLORS)], carried=True))
    world = run.obstacles
    if world is None:
        return make.make("visualization_msgs/MarkerArray", markers=markers)
    at, header, grey = min(k, len(world.circles) - 1), make.header(time, MAP), ROLES["quiet"].light
    for body in range(int(world.counts[min(at, len(world.counts) - 1)])):
        x, y, radius = world.circles[at, body].tolist()
        first, count = world.bodies[min(at, len(world.bodies) - 1), body, :2].tolist()
        if count == 0:
            place, size = (x, y, HEIGHT / 2, 0.0), (2 * radius, 2 * radius, HEIGHT)
            markers.append(make.marker(header, "obstacles", body, _CYLINDER, place, size, grey))
            continue
        edges = world.segments[at, first : first + count].reshape(-1, 2).tolist()
        place, size = (0.0, 0.0, HEIGHT / 2, 0.0), (LINE, LINE, LINE)
        markers.append(make.marker(header, "obstacles", body, _LINES, place, size, grey, edges))
    return make.make("visualization_msgs/MarkerArray", markers=markers)
