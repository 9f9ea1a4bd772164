"""Commands driven without feedback: a law that replays them, and a simulated drive of a robot by it."""

from dataclasses import dataclass, field
from pathlib import Path
from typing import NamedTuple

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
    """Write commands as a CSV file. Raises DataError where it cannot be written."""
    rows = np.stack([program.time.round(6), program.v.round(6), program.w.round(6)], axis=1)
    write_table(target, ("time", "v_command", "w_command"), rows, ("s", "m/s", "rad/s"))


def write_drive(run: Run, target: Path) -> None:
    """Write what a robot logs of a run, as .mcap or as a CSV file. Raises LogError and OSError."""
    if target.suffix.lower() == ".mcap":
        from robotics.plugins.logs.writing import write_mcap

        write_mcap(run, target)
        return
    assert run.encoders is not None
    columns = {
        ("time", "s"): run.time,
        ("v_command", "m/s"): run["command_1"][0, 0],
        ("w_command", "rad/s"): run["command_2"][0, 0],
        ("v", "m/s"): run.encoders[:, 2, 0, 0],
        ("w", "rad/s"): run.encoders[:, 3, 0, 0],
        ("x", "m"): run["x_measured"][0, 0],
        ("y", "m"): run["y_measured"][0, 0],
        ("heading", "rad"): run["heading_measured"][0, 0],
    }
    names, units = zip(*columns, strict=True)
    write_table(target, names, np.stack([*columns.values()], axis=1), units)
