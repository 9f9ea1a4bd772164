"""The plan of a team before it starts: on which paths, perhaps bent, and when each robot is where on them.

The plan of :mod:`robotics.laws.avoidance.reservation` says where each robot is at each moment of a common clock.

Where there is no plan because a robot waits at its start or is parked at its end on another's path, the other's path is
bent around it (:mod:`robotics.laws.avoidance.sidestep`); where many meet in one place, they go round it. If that is not
enough, robots come a little nearer to each other, and at last some may arrive early. Where there is still no plan, the
team is refused before it starts.

The outcome is a timing as every other, :class:`robotics.world.paths.references.References`, which a law may follow; and
it tells when each robot comes to which place, hence who passes first where two paths meet.
"""

from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np

from fuzzy.compiled.jit import kernel
from robotics.laws.avoidance.ends import near_ends, told
from robotics.laws.avoidance.reservation import CELLS, Plan, plan_right_of_way
from robotics.laws.avoidance.sidestep import roundabout, sidestepped
from robotics.laws.law import ControllerError
from robotics.laws.setting import Setting
from robotics.world.paths.joined import PathTable, join_tables
from robotics.world.paths.path import PathColumns
from robotics.world.paths.references import References
from robotics.world.paths.road import TIMED, road_of

CLOCK_MARGIN = 1.2  # s: how far two robots' clocks may differ before the plan's clearance is lost
PLANNED_SPREAD = 0.6  # s: within which the plan lets all arrive
SIDESTEP_MARGIN = 0.1  # m: how much farther than the clearance a side-step goes
_LONG = 1.6  # times the nominal duration: for a longer plan, a roundabout is tried too


class _Way(NamedTuple):
    """One way to find a plan where the paths as they are have none."""

    bent: bool  # paths are bent around who waits or is parked on them
    mirrored: bool = False  # they are bent to the other side
    clearance_scale: float = 1.0  # a factor on the clearance
    together: bool = True  # all arrive together
    rounded: bool = False  # a roundabout where many meet

    def bent_paths(self, tables: list[np.ndarray], clear: float) -> list[np.ndarray] | None:
        """The tables of one run's paths bent to keep ``clear`` [m] in this way; None where it does not apply."""
        if self.rounded:
            around = roundabout(tables, clear)
            if around is None:
                return None
            tables = around
        return sidestepped(tables, clear, self.mirrored) if self.bent else tables


_WAYS = (
    _Way(False, rounded=True),
    _Way(False, clearance_scale=0.9, rounded=True),
    _Way(False, clearance_scale=0.85, rounded=True),
    _Way(True),
    _Way(True, True),
    _Way(False, clearance_scale=0.9),
    _Way(True, clearance_scale=0.9),
    _Way(True, True, clearance_scale=0.9),
    _Way(False, together=False),
    _Way(True, together=False),
    _Way(True, True, together=False),
    _Way(True, clearance_scale=0.85, together=False),
)


@dataclass(frozen=True, eq=False)
class PlannedTiming(References):
    """The references that a plan makes: its paths, side-steps included, and when each robot is where on them.

    The first axis (runs,) is 1 where all runs share their paths. A run without a plan keeps the even timing.
    """

    progress: np.ndarray  # (runs, robots, ticks + 1): share of the path at every tick, from 0 to 1
    durations: np.ndarray  # (runs, 1) s: of CELLS ticks; the nominal duration, longer where a path was bent
    found: np.ndarray  # (runs, 1) bool: whether there is a plan

    def reached(self, spacing: float, count: int) -> np.ndarray:
        """The times [s] (runs, robots, count) at which the plan has each robot at every ``spacing`` [m] of its path.

        Beyond the path's end it is the time at which the robot is there.
        """
        lengths = self.joined.lengths.reshape(self.progress.shape[:2])
        shares = np.minimum(np.arange(count) * spacing / lengths[..., None], 1.0)
        ticks = _first_ticks(np.ascontiguousarray(self.progress), shares)
        return np.asarray(ticks * (self.durations / CELLS)[..., None])


def planned_timing(setting: Setting, clearance: float, margin: float = CLOCK_MARGIN) -> PlannedTiming:
    """Plan the team of ``setting``. In an ensemble there may be runs without a plan.

    Args:
        setting: The compiled scenario, or an ensemble.
        clearance: The least distance between the robots' centers [m].
        margin: How far two robots' clocks may differ [s].

    Raises ControllerError where a scenario has no safe plan.
    """
    robots = len(setting.robots)
    spans = np.atleast_2d(setting.references.ends)[:, :1]
    plan, paths, longer = _planned(setting.references.joined, robots, spans[:, 0], clearance, margin)
    if not setting.ensemble and not plan.found.any():
        near = near_ends(setting, clearance)
        pairs = "".join(f"{told(what, pair)}; " for what in near for pair in near[what])
        raise ControllerError(
            f"{setting.name}: there is no safe plan: {pairs}no order of the robots, no side-step around who "
            f"waits or is parked, and no horizon up to 3.4 times the duration keeps them {clearance:g} m "
            "apart; move starts or ends away from each other's paths"
        )
    durations, shape = longer[:, None] * spans, paths.lengths.shape
    ends = np.broadcast_to(plan.factor[:, None] * durations, plan.progress.shape[:2]).reshape(shape)
    each, rows = durations if len(shape) > 1 else durations[0], plan.progress.reshape(paths.lengths.size, -1)
    road = road_of(paths, TIMED.planned, ends, durations=each, plan=rows)
    return PlannedTiming(paths, ends, road, plan.progress, durations, plan.found[:, None])


def _planned(
    paths: PathTable, robots: int, durations: np.ndarray, clearance: float, clock_margin: float
) -> tuple[Plan, PathTable, np.ndarray]:
    """The plan of every run, the paths that it is for, and a factor (runs,) on the nominal duration.

    The plan is that of the first of the ways that has one, or that of the quickest roundabout where there are any.
    The nominal duration grows with the longest path. ``durations`` [s] is () or (runs,).
    """
    nodes = _nodes(paths, robots)
    durations = np.broadcast_to(durations, len(nodes))
    longer = np.ones(len(nodes))
    margin, together = np.minimum(clock_margin / durations, 1.0), np.minimum(PLANNED_SPREAD / durations, 1.0)
    plan = plan_right_of_way(nodes, clearance, margin, together=together)
    if (plan.found & (plan.factor <= _LONG)).all():
        return plan, paths, longer
    tables = [
        [paths.table[: PathColumns.size, f : f + c + 1] for f, c in zip(first, cells, strict=True)]
        for first, cells in zip(paths.first.reshape(-1, robots), paths.cells.reshape(-1, robots), strict=True)
    ]
    original = list(tables)
    longest = np.broadcast_to(paths.lengths.reshape(-1, robots).max(axis=1), len(nodes))
    for way in _WAYS:
        rest = np.flatnonzero(~plan.found | (way.rounded & (longer * plan.factor > _LONG)))
        clear = way.clearance_scale * clearance
        bent = [way.bent_paths(original[r], clear + SIDESTEP_MARGIN) for r in rest]
        rest = rest[[tables is not None for tables in bent]]
        tried = [tables for tables in bent if tables is not None]
        if not tried:
            continue
        bends = join_tables(tried)
        growth = np.maximum(bends.lengths.reshape(-1, robots).max(axis=1) / longest[rest], 1.0)
        span = together[rest] / growth if way.together else None
        found = plan_right_of_way(_nodes(bends, robots), clear, margin[rest] / growth, together=span)
        quicker = ~plan.found[rest] | (growth * found.factor < longer[rest] * plan.factor[rest])
        for k in np.flatnonzero(found.found & quicker):
            tables[rest[k]] = tried[k]
            longer[rest[k]] = growth[k]
            for mine, theirs in zip(
                (plan.progress, plan.found, plan.factor), (found.progress, found.found, found.factor), strict=True
            ):
                mine[rest[k]] = theirs[k]
    joined = join_tables(tables)
    return plan, replace(joined, lengths=joined.lengths.reshape(paths.lengths.shape)), longer


def _nodes(paths: PathTable, robots: int) -> np.ndarray:
    """Points of the paths at equal shares of their lengths (runs, robots, CELLS + 1, 2) [m]."""
    shares = np.linspace(0, 1, CELLS + 1)
    points = [np.stack(paths.at(share * paths.lengths)[:2], axis=-1) for share in shares]
    return np.stack(points, axis=-2).reshape(-1, robots, CELLS + 1, 2)


@kernel
def _first_ticks(plan, shares):  # type: ignore[no-untyped-def]
    """The first tick, with its fraction, at which each robot's plan has come to each of ``shares``, which grow."""
    out = np.empty(shares.shape)
    for r in range(shares.shape[0]):
        for i in range(shares.shape[1]):
            k = 0
            for c in range(shares.shape[2]):
                while k < plan.shape[2] - 1 and plan[r, i, k] < shares[r, i, c]:
                    k += 1
                out[r, i, c] = k
                if k > 0 and plan[r, i, k] > plan[r, i, k - 1]:
                    out[r, i, c] -= (plan[r, i, k] - shares[r, i, c]) / (plan[r, i, k] - plan[r, i, k - 1])
    return out
