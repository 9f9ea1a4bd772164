"""The changes of the robots' modes in a run, with their reasons: the table of hand-overs."""

from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from robotics.laws.modes import AVOID, FOLLOW, LEFT_BEHIND, MODES, STOPPED, TRACK, YIELD
from robotics.simulation.run import Run

if TYPE_CHECKING:
    import pandas as pd

# The reasons why one of the first four modes follows another, by (before, after); robotics.laws.avoidance says more
_REASONS = {
    (TRACK, AVOID): "an obstacle is near",
    (TRACK, FOLLOW): "an obstacle is near",
    (AVOID, TRACK): "all is free again",
    (AVOID, FOLLOW): "no progress along its path",
    (FOLLOW, AVOID): "its way is free beyond where it got stuck",
    (FOLLOW, TRACK): "all is free again",
    (TRACK, YIELD): "another robot, or what may move, is near",
    (AVOID, YIELD): "another robot, or what may move, is near",
    (FOLLOW, YIELD): "another robot, or what may move, is near",
    (YIELD, TRACK): "its way is free",
    (YIELD, AVOID): "its way is free",
    (YIELD, FOLLOW): "its way is free",
}
TIMED_OUT = "timed out: the group goes on without it"
REJOINED = "rejoined: the group waits for it again"


class ModeChange(NamedTuple):
    """One change of a robot's mode."""

    time: float  # s
    run: int  # from 0
    robot: int  # from 0
    before: str  # of MODES
    after: str  # of MODES
    why: str


def mode_events(times: np.ndarray, modes: np.ndarray) -> list[ModeChange]:
    """The changes of ``modes``, codes (samples, runs, robots), at ``times`` (samples,) [s]; in the order of time."""
    changed = np.argwhere(modes[1:] != modes[:-1])
    return [
        ModeChange(float(times[k + 1]), int(r), int(i), MODES[before], MODES[after], reason(before, after))
        for k, r, i in changed.tolist()
        for before, after in [(int(modes[k, r, i]), int(modes[k + 1, r, i]))]
    ]


def reason(before: int, after: int) -> str:
    """The reasons why a robot went from the mode ``before`` to the mode ``after``, which are codes of MODES."""
    if after == STOPPED:
        return "its command was not finite, or it was lost"
    reasons = []
    if before & 3 != after & 3:
        reasons.append(_REASONS[before & 3, after & 3])
    if before & LEFT_BEHIND != after & LEFT_BEHIND:
        reasons.append(TIMED_OUT if after & LEFT_BEHIND else REJOINED)
    return "; ".join(reasons)


def events_of(run: Run) -> "pd.DataFrame":
    """A table of the hand-overs of ``run``: seed, time [s], robot (from 1), from, to, why.

    Its rows are sorted by seed, then by time. A run of a law without modes has none.
    """
    import pandas as pd

    listed = [] if run.modes is None else sorted(mode_events(run.time, run.modes), key=lambda e: e.run)
    rows = [(run.seeds[e.run], round(e.time, 9), e.robot + 1, e.before, e.after, e.why) for e in listed]
    return pd.DataFrame(rows, columns=["seed", "time", "robot", "from", "to", "why"])
