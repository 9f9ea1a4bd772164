"""Changes of the robots' modes: when each robot changed between which modes, and why."""

from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from robotics.laws.modes import AVOID, FOLLOW, LEFT_BEHIND, MODES, STOPPED, TRACK, YIELD
from robotics.simulation.run import Run

if TYPE_CHECKING:
    import pandas as pd

# Why one of the first four modes follows another, (before, after); robotics.laws.avoidance tells it at length
_REASONS = {
    **{(TRACK, after): "an obstacle is near" for after in (AVOID, FOLLOW)},
    **{(before, TRACK): "all is free again" for before in (AVOID, FOLLOW)},
    (AVOID, FOLLOW): "no progress along its path",
    (FOLLOW, AVOID): "its way is free beyond where it got stuck",
    **{(before, YIELD): "another robot, or what may move, is near" for before in (TRACK, AVOID, FOLLOW)},
    **{(YIELD, after): "its way is free" for after in (TRACK, AVOID, FOLLOW)},
}
TIMED_OUT = "timed out: the group goes on without it"
REJOINED = "rejoined: the group waits for it again"


class ModeChange(NamedTuple):
    """One change of a robot's mode."""

    time: float  # s
    run: int
    robot: int
    before: str
    after: str
    why: str


def mode_changes_in(times: np.ndarray, modes: np.ndarray) -> list[ModeChange]:
    """The changes in ``modes`` (samples, runs, robots) of codes, at ``times`` (samples,) [s]; in the order of time."""
    changed = np.argwhere(modes[1:] != modes[:-1])
    return [
        ModeChange(float(times[k + 1]), int(r), int(i), MODES[before], MODES[after], reason(before, after))
        for k, r, i in changed.tolist()
        for before, after in [(int(modes[k, r, i]), int(modes[k + 1, r, i]))]
    ]


def reason(before: int, after: int) -> str:
    """The reason why a robot went from one mode to another (codes of MODES), or both of two reasons."""
    if after == STOPPED:
        return "its command was not finite, or it was lost"
    reasons = []
    if before & 3 != after & 3:
        reasons.append(_REASONS[before & 3, after & 3])
    if before & LEFT_BEHIND != after & LEFT_BEHIND:
        reasons.append(TIMED_OUT if after & LEFT_BEHIND else REJOINED)
    return "; ".join(reasons)


def mode_change_table(run: Run) -> "pd.DataFrame":
    """The changes of mode in ``run``, a row each: seed, time [s], robot (from 1), from, to, why.

    The rows are ordered by seed, then time. A law without modes has none.
    """
    import pandas as pd

    listed = [] if run.modes is None else sorted(mode_changes_in(run.time, run.modes), key=lambda e: e.run)
    rows = [(run.seeds[e.run], round(e.time, 9), e.robot + 1, e.before, e.after, e.why) for e in listed]
    return pd.DataFrame(rows, columns=["seed", "time", "robot", "from", "to", "why"])
