"""Metrics of scenarios in which each robot comes to a goal: whether, when, how near, and how steadily it stays."""

from functools import partial

import numpy as np

from robotics.measures.once import CachedPerRun
from robotics.measures.tracking import Metric, at_end
from robotics.simulation.run import Run
from robotics.world.paths.posture import wrapped


@CachedPerRun
def goal_error(run: Run) -> tuple[np.ndarray, np.ndarray]:
    """How far each robot is from its goal [m], and by how much its heading is off [rad] (runs, robots, samples).

    In a region the distance is 0; where any heading will do the heading is off by 0.
    """
    x, y, heading = (run[name] - run.target(name) for name in ("x", "y", "heading"))
    away, off = np.hypot(x, y), np.abs(wrapped(heading))
    for i, goal in enumerate(run.about.goals):
        if goal.region is not None:
            known = np.isfinite(away[:, i])
            away[:, i][known] = goal.outside(run["x"][:, i][known], run["y"][:, i][known])
        if goal.heading_within is None:
            off[:, i] *= 0.0
    return away, off


@CachedPerRun
def at_goal(run: Run) -> np.ndarray:
    """Whether each robot is where its goal is (runs, robots, samples) bool."""
    away, off = goal_error(run)
    near = [(0.0 if goal.region is not None else goal.within) for goal in run.about.goals]
    turned = [np.inf if goal.heading_within is None else goal.heading_within for goal in run.about.goals]
    return np.asarray((away <= np.reshape(near, (-1, 1))) & (off <= np.reshape(turned, (-1, 1))))


@CachedPerRun
def goal_time(run: Run) -> np.ndarray:
    """The time [s] (runs, robots) from which a robot is at its goal as long as it shall be; infinite: it never is."""
    there, period = at_goal(run), run.time[1] - run.time[0] if len(run.time) > 1 else 1.0
    found = np.full(there.shape[:2], np.inf)
    for i, goal in enumerate(run.about.goals):
        held = round(goal.hold / period) + 1  # samples
        if held > there.shape[-1]:
            continue
        whole = np.lib.stride_tricks.sliding_window_view(there[:, i], held, axis=-1).all(axis=-1)
        found[:, i] = np.where(whole.any(axis=-1), run.time[whole.argmax(axis=-1)], np.inf)
    return found


def goal_share(run: Run) -> np.ndarray:
    """The share of the time from :func:`goal_time` on that a robot is at its goal (runs, robots); 0: it never is."""
    after = (run.time >= goal_time(run)[..., None]) & np.isfinite(run["x"])
    return np.asarray((at_goal(run) & after).sum(axis=-1) / np.maximum(after.sum(axis=-1), 1))


_of_goals = partial(Metric, kinds=("goal",), headline=("goal",), tried=("goal",))
GOAL_METRICS: dict[str, Metric] = {
    "goal_reached": _of_goals(
        lambda run: np.isfinite(goal_time(run)).astype(float),
        "1",
        "success: whether the robot comes to its goal and stays as long as it shall",
        short="success",
        larger=True,
    ),
    "goal_time_s": _of_goals(goal_time, "s", "time to the goal: when it has come there; infinite: never", short="time"),
    "goal_error_m": _of_goals(
        lambda run: at_end(goal_error(run)[0]), "m", "distance to the goal at the end", short="final error"
    ),
    "goal_heading_error_rad": _of_goals(
        lambda run: at_end(goal_error(run)[1]), "rad", "heading off the goal's at the end", short="final heading error"
    ),
    "goal_share": _of_goals(
        goal_share, "1", "share of the time afterwards in which it is there", short="share there", larger=True
    ),
}
