"""Side-steps: paths bent so that they pass the starts and the ends of other robots' paths at a distance.

A robot that waits at its start, or is parked at its end, on another's path cannot be passed, in whatever order the
robots go. The path of the one that would run into it is shifted sideways there, by a bump without jumps in curvature,

    p(s) → p(s) + n(s) Σ_k h_k (1 − ((s − s_k) / w_k)²)³        |s − s_k| < w_k

n being its normal to the left, and the path's length is measured again. Its ends stay where they were. Where two paths
have a stretch in common in opposite directions, both robots keep to the right of it: the shift grows from 0 at the
path's ends by u³ (10 − 15 u + 6 u²), which has no jump in curvature either.

A crowd, where the paths of many robots cross, is turned into a roundabout: all robots pass its middle to the right, at
such a distance that they can be on the way around it at the same time.

All of this is a choice; the thesis bends no paths.
"""

from collections.abc import Sequence
from typing import Any

import numpy as np

from fuzzy.compiled.jit import kernel
from robotics.world.paths.path import PathColumns

_WIDTH = 1.6  # m: half the length of a bump
NARROWEST = 0.6  # m: the least half length; where there is no room for it, a path is not bent
SHARPEST = 5.0  # 1/m: no path is bent to a higher curvature
CROWD = 4  # the number of paths through one place that make a roundabout
_SPACING = 1.25  # times the clearance: the arc of a roundabout that each robot has
_TURNS = (1.2, 1.6)  # m tried: the way within which a path leaves for the roundabout, and comes back
_ROUNDS = 8  # how often a path is bent anew around the points that are still too near
_FACING = -0.8  # cosine of the angle between two paths: below it they run against each other


def sidestepped(tables: Sequence[np.ndarray], clear: float, mirrored: bool = False) -> list[np.ndarray]:
    """Bend one team's paths around the places where others start or end.

    Args:
        tables: The tables (5, nodes) of the paths, as of :class:`robotics.world.paths.path.Path`.
        clear: The distance [m] to keep from those places, where there is room.
        mirrored: Whether a path passes on the far side of the other robot; otherwise it is shifted away from it.

    A path that would become too sharp is left as it is.
    """
    ends = [(table[:2, 0], table[:2, -1]) for table in tables]
    bent = [
        _around(table, np.array([p for j, pair in enumerate(ends) if j != i for p in pair]), clear, mirrored)
        for i, table in enumerate(tables)
    ]
    return _keeping_right(bent, clear)


def roundabout(tables: Sequence[np.ndarray], clear: float) -> list[np.ndarray] | None:
    """Bend those of one team's paths, ``tables`` (5, nodes) each, that lead through the largest crowd around it.

    On the way around it each robot has 5/4 of ``clear`` [m]. Returns None where there is no crowd, or no room to turn.
    """
    points = np.concatenate([table[:2, ::8].T for table in tables])
    distances = np.array([_distances(table, points) for table in tables])  # to the inner parts of the paths
    count = (distances < clear).sum(axis=0)
    if count.max() < CROWD:
        return None
    middle = points[count == count.max()].mean(axis=0)
    through = [i for i, table in enumerate(tables) if _distances(table, middle[None])[0] < clear]
    if len(through) < CROWD:  # the mean of two crowds
        return None
    nearest = [int(np.argmin(np.hypot(*(tables[i][:2].T - middle).T))) for i in through]
    lengths = [_abscissae(tables[i]) for i in through]
    rooms = [min(s[k], s[-1] - s[k]) for s, k in zip(lengths, nearest, strict=True)]
    radius = _SPACING * clear * len(through) / (2 * np.pi)
    for turn in _TURNS:
        result: list[Any] = list(tables)
        for i, k, s, room in zip(through, nearest, lengths, rooms, strict=True):
            node = PathColumns(tables[i], k)
            sin, cos = np.sin(node.heading), np.cos(node.heading)
            left = cos * (middle[1] - node.y) - sin * (middle[0] - node.x)
            half = min(room, radius + _WIDTH / 2)
            ahead = np.abs(s - s[k]) / half
            ring = np.sqrt(np.clip(1 - ahead**2, 0.0, None)) * _rising((1 - ahead) * half / min(turn, half))
            result[i] = _shifted(tables[i], -(radius - left) * ring)
        if all(table is not None for table in result):
            return result
    return None


def _distances(table: np.ndarray, points: np.ndarray) -> np.ndarray:
    """The distances [m] of ``points`` (points, 2) from a path without its ends; infinite where it is too short."""
    s = _abscissae(table)
    inner = table[:2, np.minimum(s, s[-1] - s) >= _WIDTH / 2]
    if not inner.size:
        return np.full(len(points), np.inf)
    return np.asarray(np.hypot(inner[0] - points[:, :1], inner[1] - points[:, 1:]).min(axis=1))


def _around(table: np.ndarray, points: np.ndarray, clear: float, mirrored: bool) -> np.ndarray:
    """One path, bent around ``points`` (points, 2)."""
    for _ in range(_ROUNDS):
        shift = np.zeros(table.shape[1])
        s = _abscissae(table)
        nodes = PathColumns(table)
        distances = np.hypot(nodes.x - points[:, :1], nodes.y - points[:, 1:])
        nearest = distances.argmin(axis=1)
        for point, k, distance in zip(points, nearest, distances.min(axis=1), strict=True):
            room = min(s[k], s[-1] - s[k])
            if distance >= clear or room < NARROWEST:
                continue
            sin, cos = np.sin(nodes.heading[k]), np.cos(nodes.heading[k])
            left = -sin * (point[0] - nodes.x[k]) + cos * (point[1] - nodes.y[k])
            away = -1.0 if left > 0 else 1.0
            gap = clear + 0.02 - abs(left)
            if mirrored and abs(left) < clear / 2:
                away, gap = -away, clear + 0.02 + abs(left)
            shift += away * gap * _bump((s - s[k]) / min(_WIDTH, room))
        if not shift.any():
            return table
        mirrored = False  # once past the point, away from it
        moved = _shifted(table, shift)
        if moved is None:
            return table
        table = moved
    return table


def _keeping_right(tables: list[np.ndarray], clear: float) -> list[np.ndarray]:
    """Shift two paths that run against each other to the right, both."""
    tables = list(tables)
    for i in range(len(tables)):
        for j in range(i):
            stretches = _stretches(tables[i], tables[j], clear**2)
            if stretches[0, 1] < 0:
                continue
            for k, stretch in zip((i, j), stretches, strict=True):
                s = _abscissae(tables[k])
                first, last = s[stretch]
                flat = np.clip(np.abs(s - (first + last) / 2) - (last - first) / 2, 0.0, None)
                room = min(_WIDTH, max(first, NARROWEST), max(s[-1] - last, NARROWEST))
                shift = -(clear / 2 + 0.02) * _bump(flat / room)
                # The ends stay, whatever lies near them.
                shift *= _rising(np.minimum(s, s[-1] - s) / min(_WIDTH, s[-1] / 2))
                moved = _shifted(tables[k], shift)
                if moved is not None:
                    tables[k] = moved
    return tables


@kernel
def _stretches(a, b, clear):  # type: ignore[no-untyped-def]
    """The first and last nodes (2, 2) at which paths ``a`` and ``b`` run against each other within √clear; -1: none."""
    result = np.empty((2, 2), dtype=np.int64)
    result[:, 0] = max(a.shape[1], b.shape[1])
    result[:, 1] = -1
    for i in range(a.shape[1]):
        for j in range(b.shape[1]):
            one, other = PathColumns(a, i), PathColumns(b, j)
            near = (one.x - other.x) ** 2 + (one.y - other.y) ** 2 < clear
            if near and np.cos(one.heading - other.heading) < _FACING:
                result[0, 0] = min(result[0, 0], i)
                result[0, 1] = i
                result[1, 0] = min(result[1, 0], j)
                result[1, 1] = max(result[1, 1], j)
    return result


def _bump(u: np.ndarray) -> np.ndarray:
    return np.where(np.abs(u) < 1, (1 - np.minimum(u**2, 1.0)) ** 3, 0.0)


def _rising(u: np.ndarray) -> np.ndarray:
    """A step from 0 to 1 over ``u`` in [0, 1], without jumps in curvature."""
    u = np.clip(u, 0.0, 1.0)
    return u**3 * (10 - 15 * u + 6 * u**2)


def _abscissae(table: np.ndarray) -> np.ndarray:
    chords = np.hypot(*np.diff(table[:2]))
    return np.concatenate([[0.0], np.cumsum(chords)])


def _shifted(table: np.ndarray, shift: np.ndarray) -> np.ndarray | None:
    """The table of the path ``shift`` [m] (nodes,) to the left of ``table``; None if it has a cusp or is too sharp."""
    from scipy.interpolate import CubicSpline

    nodes = PathColumns(table)
    x = nodes.x - np.sin(nodes.heading) * shift
    y = nodes.y + np.cos(nodes.heading) * shift
    curve = CubicSpline(np.linspace(0.0, 1.0, len(x)), np.stack([x, y], axis=1))
    fine = np.linspace(0.0, 1.0, 8 * len(x))
    speed = np.hypot(*curve(fine, 1).T)
    if speed.min() < 0.2 * speed.max():
        return None
    s = np.concatenate([[0.0], np.cumsum((speed[1:] + speed[:-1]) / 2 * np.diff(fine))])
    u = np.interp(np.linspace(0.0, s[-1], max(len(x), int(np.ceil(s[-1] / 0.02)) + 1)), s, fine)
    (x, y), slope, bend = curve(u).T, curve(u, 1).T, curve(u, 2).T
    heading = np.unwrap(np.arctan2(slope[1], slope[0]))
    heading += 2 * np.pi * np.round((nodes.heading[0] - heading[0]) / (2 * np.pi))
    curvature = (slope[0] * bend[1] - slope[1] * bend[0]) / np.hypot(*slope) ** 3
    steepest = max(SHARPEST, float(np.abs(nodes.curvature).max()))
    return np.stack([x, y, heading, curvature, u]) if np.abs(curvature).max() <= steepest else None
