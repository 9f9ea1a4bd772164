"""The state of a simulation: all that one period hands to the next, and what each of its steps found."""

from dataclasses import dataclass
from typing import Any, Self

import numpy as np

from robotics.laws.law import Command
from robotics.paths.trajectory import Reference
from robotics.radio.channel import Air, Heard
from robotics.radio.faults import Condition
from robotics.sensing.sonar import Echoes, Ranges


@dataclass(frozen=True, eq=False)
class State:
    """All runs in one period; arrays are (runs, robots) unless they say otherwise.

    The steps of a period fill it in this order: sense, hear, decide, obey; say and move lead to the next period.
    """

    def then(self, **changes: Any) -> Self:
        """The same state but for these fields: what ``dataclasses.replace`` gives, in a fifth of the time."""
        other = object.__new__(type(self))
        other.__dict__.update(self.__dict__)
        other.__dict__.update(changes)
        return other

    k: int  # the period
    time: float  # s
    truth: np.ndarray  # (plant channels, runs, robots): the plant's state
    # sense
    counts: np.ndarray  # (2, lanes): of the encoders
    reference: Reference  # the setting's; each field (robots,), or (runs, robots)
    posture: np.ndarray | None  # (3, runs, robots): x [m], y [m], heading [rad] as measured; none before the first
    v: np.ndarray  # m/s, from the encoders
    w: np.ndarray  # rad/s, from the encoders
    echoes: tuple[Echoes, ...]  # what the range sensors remember
    ranges: Ranges | None  # what they read
    # hear
    air: Air | None  # what is on its way by radio; none: the law says nothing
    condition: Condition | None  # who is at fault; none: nobody
    heard: Heard
    # decide
    memory: Any  # of the law
    command: Command
    target: Reference  # where the law wants the robots to be
    # obey
    order: np.ndarray  # (2, runs, robots): the command after faults, and after stops from the next period on
    held_for: np.ndarray | float  # s without a new command
    stopped: np.ndarray  # int: the period before this one in which the robot was stopped, or -1
    lost: np.ndarray  # bool: it is stopped in this one
    all_drive: bool  # no robot of any run was stopped before this period
    # move
    pending: tuple[np.ndarray, ...]  # (2, lanes) each: orders on their way to the wheels, newest first
