"""The recorded channels: the numbers that a run keeps of every period, and their places in the state.

To record something more, declare it here, give it room in :class:`robotics.simulation.recorder.Recording`, and let
:func:`robotics.simulation.recorder.record` write it; runs then keep, save, load and cut it by its axes.
"""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

from robotics.laws.modes import STOPPED

Axes = tuple[str, ...]  # of "sample", "channel", "run", "robot", "sender", "sensor", "input", "wheel", "value"


@dataclass(frozen=True, kw_only=True)
class Record:
    """One recorded array: its axes, the names and units of its channels, and what stands for stopped robots."""

    axes: Axes
    units: Mapping[str, str] | None = None  # of its channels, where it has such an axis
    dtype: Any = float
    stopped: float | int | None = None  # in place of the values of a robot that was stopped; None: they stay


# The channels of every run, in the order of ``Run.samples``, with their units
CHANNELS = {
    "x": "m",
    "y": "m",
    "heading": "rad",
    "v": "m/s",
    "w": "rad/s",  # the truth
    "x_measured": "m",
    "y_measured": "m",
    "heading_measured": "rad",  # as the law saw it
    # v and ω, or the torques of the right and the left wheel
    "command_1": "m/s or N m",
    "command_2": "rad/s or N m",
    # the velocities that the law tries to reach, brought within the robot's limits
    "v_demand": "m/s",
    "w_demand": "rad/s",
    # ∫ τr² + τl² dt so far; Σ |Δτr| + |Δτl| so far, at the wheel loops' 100 Hz
    "effort": "N² m² s",
    "torque_variation": "N m",
}
# Further channels of a team's run, in the order of ``Run.team``
TEAM_CHANNELS = {
    "progress": "1",  # the law's own path parameter; not-a-number if it has none
    "x_target": "m",
    "y_target": "m",
    "heading_target": "rad",  # the target that the law has chosen
    "fault": "1",  # 0 none, 1 failure, 2 delay, 3 silence, 4 stall
}
# What the encoders tell, in the order of ``Run.encoders``
ENCODER_CHANNELS = {
    "angle_right": "rad",
    "angle_left": "rad",  # the wheels' angles, before they are counted
    "v_measured": "m/s",
    "w_measured": "rad/s",  # as the law saw them: from the counts of the last period
}

RECORDS: dict[str, Record] = {
    "samples": Record(axes=("sample", "channel", "run", "robot"), units=CHANNELS, stopped=float("nan")),
    # of a team's run
    "team": Record(axes=("sample", "channel", "run", "robot"), units=TEAM_CHANNELS, stopped=float("nan")),
    # s: the age of the last message of each robot that each other heard, if a run keeps it; infinite: it heard none
    "message_ages": Record(axes=("sample", "run", "robot", "sender"), dtype="float32"),
    # codes of robotics.laws.modes.MODES
    "modes": Record(axes=("sample", "run", "robot"), dtype="int8", stopped=STOPPED),
    # whether the emergency rule overrode what the law wanted
    "guarded": Record(axes=("sample", "run", "robot"), dtype="bool", stopped=False),
    # m: readings of the range sensors, those of robotics.world.sensing.carried.sensor_names
    "ranges": Record(axes=("sample", "run", "robot", "sensor"), dtype="float32"),
    # N m: the motors' torques at the right and the left wheel, at the start of the plant's last step, if a run keeps
    # them; 0 on the kinematic plant, which has no motors
    "torques": Record(axes=("sample", "wheel", "run", "robot"), dtype="float32", stopped=float("nan")),
    # what the encoders tell, if a run keeps it
    "encoders": Record(axes=("sample", "channel", "run", "robot"), units=ENCODER_CHANNELS, stopped=float("nan")),
    # the values that each robot broadcast, those of Run.about.message, if a run keeps them; not-a-number in periods in
    # which no message is due
    "messages": Record(axes=("sample", "value", "run", "robot"), stopped=float("nan")),
    # the inputs of the law's rule bases, those of Run.about.rule_bases in their order, each in its own unit
    "inputs": Record(axes=("sample", "input", "run", "robot"), dtype="float32", stopped=float("nan")),
}
