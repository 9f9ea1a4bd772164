"""The setting of many random runs: each with paths of its own, which all robots of a run drive in one time."""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from robotics.experiments.stress.disturbance import Disturbance
from robotics.laws.setting import Kind, Setting
from robotics.paths.joined import join_tables
from robotics.paths.path import Quintic
from robotics.paths.references import EvenTiming
from robotics.paths.trajectory import Timing
from robotics.scenario.description import Member, Scenario
from robotics.sensing.posture import LABORATORY

SPEED = 0.22  # m/s: mean speed on the longest path of a run


def evenly_timed(
    name: str, kind: Kind, tables: Sequence[Sequence[np.ndarray]], disturbance: Disturbance, factor: float
) -> Setting:
    """An ensemble of one run for each sequence of paths, with the laboratory's noise.

    Args:
        name: The scenario's.
        kind: Of scenario.
        tables: The tables of the paths of each run, one for each robot.
        disturbance: The robots talk over its radio, and runs may take longer.
        factor: The longest an undisturbed run takes, in times the longest nominal duration.
    """
    paths = join_tables(tables)
    durations = paths.lengths.max(axis=1) / SPEED
    starts = np.array([[t[:3, 0] for t in row] for row in tables])
    shared = Member(
        start=(0.0, 0.0, 0.0),
        path=Quintic(start=(0.0, 0.0), end=(5.0, 0.0)),
        timing=Timing(duration=float(np.ceil(durations.max()))),
    )
    scenario = Scenario(
        name=name,
        robots=(shared,) * len(tables[0]),
        duration=float(np.ceil(factor * durations.max() + disturbance.extra)),
        kind=kind,
        sensing=LABORATORY,
        radio=disturbance.radio,
    )
    return replace(scenario.setting, starts=starts, references=EvenTiming(paths, durations))
