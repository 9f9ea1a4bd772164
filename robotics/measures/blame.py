"""Blame for contacts: the robots whose own motion led to a contact that began between two samples.

A robot is to blame for its contact with an obstacle or with another robot if its motion alone leads to it, the other
held where it was, or brings it nearer by more than APPROACH. One that stands, as it was told to or because it is held
up, is not to blame; neither is one that another drives into from behind. Where neither of two robots alone can be
blamed, both are.
"""

import numpy as np

from robotics.world.environment.collision import footprints, obstacle_clearance, robot_clearance
from robotics.world.environment.swept import ContactColumns, Watch
from robotics.world.environment.world import Geometry

APPROACH = 0.02  # m/s: a robot that came no faster towards another, or an obstacle, did not drive into it
_V = 3  # of a pose (5,): the speeds begin here


def at_fault(before: Watch, after: Watch, ended: np.ndarray) -> np.ndarray:
    """The robots that are to blame for a contact that began since ``before`` (runs, robots) bool.

    Args:
        before: What was known at a sample.
        after: What :meth:`robotics.world.environment.swept.Watch.to` made of it at the next one.
        ended: The contacts that ended meanwhile, likewise.
    """
    blamed = np.zeros(after.known.counts.shape, dtype=bool)
    if not (after.known.counts > before.known.counts).any():
        return blamed
    for run, i, j, obstacle in _begun(before, after, ended):
        if obstacle >= 0:
            blamed[run, i] |= _drove_at_obstacle(before, after, run, i, obstacle)
            continue
        first, second = _drove_at_robot(before, after, run, i, j), _drove_at_robot(before, after, run, j, i)
        blamed[run, i] |= first or not second
        blamed[run, j] |= second or not first
    return blamed


def _begun(before: Watch, after: Watch, ended: np.ndarray) -> list[tuple[int, int, int, int]]:
    """The contacts that began: run, robot, other robot or -1, obstacle or -1."""
    until = ContactColumns.end.row
    known = {tuple(row) for row in before.open_contacts()[:, :until].tolist()}
    rows = np.concatenate([ended, after.open_contacts()])[:, :until].tolist()
    return [(int(row[0]), int(row[1]), int(row[2]), int(row[3])) for row in rows if tuple(row) not in known]


def _drove_at_robot(before: Watch, after: Watch, run: int, i: int, j: int) -> bool:
    """Whether robot ``i`` drove into robot ``j``, had that one stayed."""
    robots = before.robots[i], before.robots[j]
    first, last = before.poses[:, [run], [i, j]].copy(), after.poses[:, [run], [i, j]].copy()
    first[_V:, 1] = 0.0
    last[:, 1] = first[:, 1]
    poses = [pose[:, None] for pose in (first, last)]  # of one run
    alone, _ = Watch.opened(robots, before.time, poses[0]).to(after.time, poses[1])
    gaps = [robot_clearance(x, y, psi, footprints(robots))[0, 0] for x, y, psi, *_ in poses]
    return bool(np.isfinite(alone.known.first[0, 0, 0]) or gaps[0] - gaps[1] > APPROACH * (after.time - before.time))


def _drove_at_obstacle(before: Watch, after: Watch, run: int, i: int, obstacle: int) -> bool:
    """Whether robot ``i`` drove into an obstacle, had that one stayed."""
    assert before.geometry is not None
    robots, world = (before.robots[i],), _alone(before.geometry, before.known.spans, run, obstacle)
    poses = [watch.poses[:, run : run + 1, i : i + 1] for watch in (before, after)]
    alone, _ = Watch.opened(robots, before.time, poses[0], world).to(after.time, poses[1], world)
    gaps = [obstacle_clearance(x, y, psi, footprints(robots), world)[0, 0] for x, y, psi, *_ in poses]
    return bool(np.isfinite(alone.known.first[1, 0, 0]) or gaps[0] - gaps[1] > APPROACH * (after.time - before.time))


def _alone(geometry: Geometry, spans: np.ndarray, run: int, obstacle: int) -> Geometry:
    """A world with only one of the obstacles of a run."""
    g = run if len(geometry.counts) > 1 else 0
    first, last = spans[g, obstacle]
    circles, bodies = geometry.circles[g : g + 1, first:last], geometry.bodies[g : g + 1, first:last]
    return Geometry(circles, bodies, geometry.segments[g : g + 1], np.array([last - first]))
