"""What each robot was about, and when that changed: the table of modes and hand-overs of a run."""

from typing import NamedTuple

import numpy as np

# Codes of Command.mode
TRACK, AVOID, FOLLOW, YIELD = range(4)
ALONE = 4  # added to AVOID and FOLLOW: the group goes on without the robot
MODES = (
    "tracking",
    "avoiding",
    "following the wall",
    "yielding",
    "",
    "avoiding, left behind",
    "following the wall, left behind",
    "yielding, left behind",
)


class Event(NamedTuple):
    """One change of a robot's mode."""

    time: float  # s
    run: int
    robot: int
    before: str
    after: str


def mode_events(times: np.ndarray, modes: np.ndarray) -> list[Event]:
    """The changes in ``modes`` (samples, runs, robots) of codes, at ``times`` (samples,) [s]; in the order of time."""
    changed = np.argwhere(modes[1:] != modes[:-1])
    return [
        Event(float(times[k + 1]), int(r), int(i), MODES[modes[k, r, i]], MODES[modes[k + 1, r, i]])
        for k, r, i in changed.tolist()
    ]
