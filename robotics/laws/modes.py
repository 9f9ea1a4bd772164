"""A robot's operating mode: the codes of Command.mode and Run.modes; and state diagrams of laws, as data."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import NamedTuple

TRACK = 0
AVOID = 1
FOLLOW = 2
YIELD = 3
LEFT_BEHIND = 4  # added to one of those: the robot timed out, and the group goes on without it
STOPPED = 8  # the robot's controller diverged, or the robot was lost
MODES = (
    "tracking",
    "avoiding",
    "following the wall",
    "yielding",
    "tracking, left behind",
    "avoiding, left behind",
    "following the wall, left behind",
    "yielding, left behind",
    "stopped",
)


class Transition(NamedTuple):
    """One arrow of a state diagram."""

    before: int  # the code of a state
    after: int
    condition: str  # what leads from the one to the other


class StateBox(NamedTuple):
    """One state of a state diagram."""

    name: str
    does: str  # what the robot does in it


@dataclass(frozen=True)
class StateDiagram:
    """The states that a law goes through, and all transitions that it can make from one period to the next.

    It is what a test holds against the transitions of recorded runs, and what
    :func:`robotics.plugins.thesis.states.plot_states` draws.
    """

    states: Mapping[int, StateBox]  # by code, in the order in which they are drawn
    transitions: tuple[Transition, ...]
    mask: int = LEFT_BEHIND - 1  # the bits of a robot's code that are the state; without the others
