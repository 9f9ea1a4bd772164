"""Commands driven without feedback: a law that replays them, and a simulated drive of a robot by it."""

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from fuzzy.files.table import write_table
from robotics.laws.law import Command, Law, Observation
from robotics.simulation.loop import simulate
from robotics.simulation.physics import Physics
from robotics.simulation.run import Run
from robotics.simulation.scenario.description import Member, Scenario
from robotics.world.paths.path import Line
from robotics.world.paths.trajectory import Timing
from robotics.world.sensing.posture import Sensing
from robotics.world.vehicle.robot import Robot

if TYPE_CHECKING:
    from robotics.plugins.logs.content import LogRecord
    from robotics.plugins.logs.messages import Composer

# Columns of a log, and their units; ``robotics identify`` leaves out ODOMETRY_POSES of a table
COMMANDS = {"v_command": "m/s", "w_command": "rad/s"}
VELOCITIES = {"v": "m/s", "w": "rad/s"}
POSES = {"x": "m", "y": "m", "heading": "rad"}
ODOMETRY_POSES = {f"odometry_{name}": unit for name, unit in POSES.items()}
WHEEL_SPEEDS = {"left": "rad/s", "right": "rad/s"}
YAW = {"yaw_rate": "rad/s"}
COMMAND_PERIOD = 0.05  # s: from command to command, and from sample to sample


class Program(NamedTuple):
    """Commands over time, each for a period; the last one stays."""

    time: np.ndarray  # (n,) s
    v: np.ndarray  # (n,) m/s
    w: np.ndarray  # (n,) rad/s


@dataclass(frozen=True, eq=False)
class ProgramReplay(Law[None]):
    """Command what a program says, whatever is measured."""

    program: Program = field(default_factory=lambda: Program(*np.zeros((3, 1))))

    def control(self, seen: Observation, memory: None, dt: float) -> tuple[Command, None]:
        """The command of the moment, for all robots."""
        place = int(np.searchsorted(self.program.time, seen.time + 1e-9, side="right")) - 1
        v, w = (np.full_like(seen.x, float(row[max(place, 0)])) for row in self.program[1:])
        return Command(v, w, v, w), None


def replayed(
    robot: Robot,
    program: Program,
    *,
    latency: float = 0.0,
    sensing: Sensing | None = None,
    seed: int = 0,
    plant: Physics | str = "",
) -> Run:
    """Simulate a robot that drives by a program from the middle of a floor; its encoders are kept.

    Args:
        robot: The robot.
        program: The commands.
        latency: From a command to its effect [s], a multiple of 10 ms.
        sensing: How its pose is measured; by default by odometry.
        seed: Of the noise.
        plant: As of :func:`robotics.simulate`.
    """
    member = Member(
        start=(0.0, 0.0, 0.0), path=Line(start=(0.0, 0.0), end=(1.0, 0.0)), timing=Timing(speed=0.01), robot=robot
    )
    scenario = Scenario(
        name="excite",
        robots=(member,),
        duration=float(np.ceil(program.time[-1] / COMMAND_PERIOD) * COMMAND_PERIOD + COMMAND_PERIOD),
        period=COMMAND_PERIOD,
        latency=latency,
        divergence=1e6,
        sensing=sensing or Sensing(),
        sensors={},
    )
    return simulate(scenario, ProgramReplay(program=program), [seed], name="replay", encoders=True, plant=plant)


def write_program(program: Program, target: Path) -> None:
    """Write commands, as :func:`write_log` writes a log of them."""
    write_log(target, COMMANDS, np.stack([row.round(6) for row in program], axis=1))


def write_drive(run: Run, target: Path) -> None:
    """Write what a robot logs of a run, as .mcap or as a CSV file. Raises LogError and OSError."""
    if target.suffix.lower() == ".mcap":
        from robotics.plugins.logs.writing import write_mcap

        write_mcap(run, target)
        return
    assert run.encoders is not None
    told = run["command_1"][0, 0], run["command_2"][0, 0], *run.encoders[:, 2:4, 0, 0].T
    poses = (run[f"{name}_measured"][0, 0] for name in POSES)
    write_log(target, COMMANDS | VELOCITIES | POSES, np.stack([run.time, *told, *poses], axis=1))


def write_log(target: Path, units: Mapping[str, str], rows: np.ndarray) -> None:
    """Write what a robot logged, in the order of time, as a CSV file or, by the file's ending, as an MCAP file.

    Its messages are those that ``robotics identify`` reads, on the topics cmd_vel, odom, joint_states, imu and pose.

    Args:
        target: The file, whose name ends in .csv or .mcap.
        units: The columns after the time, and their units: some of COMMANDS, VELOCITIES, POSES, ODOMETRY_POSES,
            WHEEL_SPEEDS and YAW. POSES are odometry's own where there are no ODOMETRY_POSES.
        rows: Times [s] and columns (n, 1 + columns); not-a-number: not told at that time.

    Raises:
        DataError, OSError: It cannot be written.
        LogError: A package is missing that an MCAP file needs.
    """
    if target.suffix.lower() != ".mcap":
        write_table(target, ("time", *units), rows, ("s", *units.values()))
        return
    from robotics.plugins.logs.writing import write_records

    write_records(partial(_messages, list(units), rows), {}, target)


def _messages(names: list[str], rows: np.ndarray, make: "Composer") -> Iterator["LogRecord"]:
    """The messages of a log."""
    from robotics.plugins.logs.content import LogRecord
    from robotics.plugins.logs.names import WHEELS as JOINTS

    own = set(ODOMETRY_POSES) <= set(names)
    for time, *values in rows.tolist():
        told = {name: value for name, value in zip(names, values, strict=True) if np.isfinite(value)}

        def of(group: Mapping[str, str], told: dict[str, float] = told) -> list[float]:
            return [told[name] for name in group] if set(group) <= set(told) else []

        header = make.header(time, "base_link")
        if given := of(COMMANDS):
            stamped = make.make("geometry_msgs/TwistStamped", header=header, twist=make.twist(*given))
            yield LogRecord(time, "/cmd_vel", stamped)
        at = of(ODOMETRY_POSES if own else POSES)
        if seen := of(VELOCITIES):
            place = make.header(time, "odom")
            yield LogRecord(time, "/odom", make.odometry(place, "base_link", at or (0.0, 0.0, 0.0), *seen))
        if own and (pose := of(POSES)):
            posed = make.make("geometry_msgs/PoseStamped", header=make.header(time, "map"), pose=make.pose(*pose))
            yield LogRecord(time, "/pose", posed)
        if turning := of(WHEEL_SPEEDS):
            none = np.zeros(0)
            fields = {"position": none, "velocity": np.array(turning), "effort": none}
            yield LogRecord(
                time, "/joint_states", make.make("sensor_msgs/JointState", header=header, name=list(JOINTS), **fields)
            )
        if rate := of(YAW):
            yield LogRecord(time, "/imu", make.turn_rate(header, *rate))
