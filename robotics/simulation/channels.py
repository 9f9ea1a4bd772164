"""The recorded channels: the numbers that a run keeps of every period, and their places in the state.

To record something more, let the step that makes it put it into :class:`robotics.simulation.state.State` and declare it
here; runs then keep, save, load and cut it by its axes.
"""

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from robotics.laws.modes import STOPPED
from robotics.simulation.state import State
from robotics.vehicle import plant as p

Axes = tuple[str, ...]  # of "sample", "channel", "run", "robot", "sender", "sensor", "input"


@dataclass(frozen=True, kw_only=True)
class Scalars:
    """Numbers of each robot, kept as one array: their names and units, and their place in a state."""

    units: Mapping[str, str]
    of: Callable[[State], Any]


@dataclass(frozen=True, kw_only=True)
class Record:
    """One recorded array: its axes, its place in a state, and the value that it holds for stopped robots."""

    axes: Axes
    of: Callable[[State], Any] | None = None  # a result of None: this period has none
    scalars: tuple[Scalars, ...] = ()  # in place of ``of``
    dtype: Any = float
    stopped: float | int | None = None  # in place of the values of a robot that was stopped; None: they stay


SAMPLES = (
    Scalars(  # the truth
        units={"x": "m", "y": "m", "heading": "rad", "v": "m/s", "w": "rad/s"},
        of=lambda state: state.truth[: p.W + 1],
    ),
    Scalars(  # as the law saw it
        units={"x_measured": "m", "y_measured": "m", "heading_measured": "rad"},
        of=lambda state: state.posture,
    ),
    Scalars(  # v and ω, or the torques of the right and the left wheel
        units={"command_1": "m/s or N m", "command_2": "rad/s or N m"},
        of=lambda state: state.order,
    ),
    # the velocities that the law tries to reach; the recorder brings them within the robot's limits
    Scalars(units={"v_demand": "m/s"}, of=lambda state: state.command.v),
    Scalars(units={"w_demand": "rad/s"}, of=lambda state: state.command.w),
    # ∫ τr² + τl² dt so far; Σ |Δτr| + |Δτl| so far, at the wheel loops' 100 Hz
    Scalars(
        units={"effort": "N² m² s", "torque_variation": "N m"},
        of=lambda state: state.truth[p.EFFORT : p.VARIATION + 1],
    ),
)
TEAM = (
    # the law's own path parameter; not-a-number if it has none
    Scalars(units={"progress": "1"}, of=lambda s: np.nan if s.command.progress is None else s.command.progress),
    # the target that the law has chosen
    Scalars(units={"x_target": "m"}, of=lambda state: state.target.x),
    Scalars(units={"y_target": "m"}, of=lambda state: state.target.y),
    Scalars(units={"heading_target": "rad"}, of=lambda state: state.target.heading),
    # 0 none, 1 failure, 2 delay, 3 silence, 4 stall
    Scalars(units={"fault": "1"}, of=lambda state: 0 if state.condition is None else state.condition.code),
)


def _ages(state: State) -> np.ndarray:
    return np.where(state.heard.hears, state.heard.age, np.inf)


RECORDS: dict[str, Record] = {
    "samples": Record(axes=("sample", "channel", "run", "robot"), scalars=SAMPLES, stopped=np.nan),
    # of a team's run
    "team": Record(axes=("sample", "channel", "run", "robot"), scalars=TEAM, stopped=np.nan),
    # s: the age of the last message of each robot that each other heard, if a run keeps it; infinite: it heard none
    "links": Record(axes=("sample", "run", "robot", "sender"), of=_ages, dtype=np.float32),
    # codes of robotics.laws.modes.MODES
    "modes": Record(axes=("sample", "run", "robot"), of=lambda s: s.command.mode, dtype=np.int8, stopped=STOPPED),
    # whether the emergency rule overrode what the law wanted
    "guarded": Record(axes=("sample", "run", "robot"), of=lambda s: s.command.guarded, dtype=np.bool_, stopped=False),
    # m: readings of the range sensors, those of robotics.sensing.carried.sensor_names
    "ranges": Record(
        axes=("sample", "run", "robot", "sensor"),
        of=lambda state: None if state.ranges is None else state.ranges.values,
        dtype=np.float32,
    ),
    # the inputs of the law's rule bases, those of Run.about.rule_bases in their order, each in its own unit
    "inputs": Record(
        axes=("sample", "input", "run", "robot"),
        of=lambda state: state.command.inputs,
        dtype=np.float32,
        stopped=np.nan,
    ),
}


def units_of(scalars: tuple[Scalars, ...]) -> dict[str, str]:
    """The names of all ``scalars``, in their order, with their units."""
    return {name: unit for part in scalars for name, unit in part.units.items()}


CHANNELS = units_of(SAMPLES)  # the channels of every run, in the order of ``Run.samples``, with their units
TEAM_CHANNELS = units_of(TEAM)  # further channels of a team's run, in the order of ``Run.team``
