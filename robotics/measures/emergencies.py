"""The emergency rule's share: for how much of its way a robot did not do what its law wanted."""

import numpy as np

from robotics.measures.arrival import arrival_time
from robotics.measures.tracking import Metric
from robotics.simulation.run import Run

_KINDS = ("tracking", "team")


def emergency_share(run: Run) -> np.ndarray:
    """The share of the time on its way in which the emergency rule overrode each robot's law (runs, robots).

    A robot is on its way until it arrives, as :func:`robotics.measures.arrival.arrival_time` says, until it is stopped
    or the run ends. Not-a-number for a law without such a rule, and for a robot that was never on its way.
    """
    if run.guarded is None:
        return np.full(run.stopped.shape, np.nan)
    on_way = np.isfinite(run["x"]) & (run.time < arrival_time(run)[..., None])
    on_way[..., -1] = False  # no period follows the last sample
    acted = np.moveaxis(run.guarded, 0, -1) & on_way
    with np.errstate(invalid="ignore"):
        return np.asarray(acted.sum(axis=-1) / on_way.sum(axis=-1))


EMERGENCY_METRICS: dict[str, Metric] = {
    "emergency_share": Metric(
        emergency_share,
        "1",
        "share of the way on which the emergency rule overrode the law",
        kinds=_KINDS,
        headline=_KINDS,
        short="emergency share",
        needs_guard=True,
    ),
}
