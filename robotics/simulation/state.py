"""The state of a simulation in one period, as whoever looks at every period sees it."""

from dataclasses import dataclass
from typing import Any

import numpy as np

from robotics.laws.law import Command
from robotics.world.paths.references import Reference
from robotics.world.radio.channel import Heard
from robotics.world.sensing.sonar import Ranges


@dataclass(frozen=True, eq=False)
class State:
    """All runs in one period, after the law has decided and before the robots move; arrays are copies.

    They are (runs, robots) unless they say otherwise.
    """

    k: int  # the period
    time: float  # s
    truth: np.ndarray  # (plant channels, runs, robots): the plant's state
    posture: np.ndarray  # (3, runs, robots): x [m], y [m], heading [rad] as measured
    v: np.ndarray  # m/s, from the encoders
    w: np.ndarray  # rad/s, from the encoders
    reference: Reference  # the setting's
    heard: Heard
    ranges: Ranges | None  # what the range sensors read
    memory: Any  # of the law
    command: Command
    target: Reference  # where the law wants the robots to be
    fault: np.ndarray  # int: of robotics.world.radio.faults.FAULTS, or 0
    order: np.ndarray  # (2, runs, robots): the command after faults
    stopped: np.ndarray  # int: the period before this one in which the robot was stopped, or -1
    lost: np.ndarray  # bool: it is stopped in this one
