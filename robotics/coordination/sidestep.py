"""Side-steps: paths bent so that they pass the starts and the ends of other robots' paths at a distance.

A robot that waits at its start, or is parked at its end, on another's path cannot be passed, in whatever order the
robots go. The path of the one that would run into it is shifted sideways there, by a bump without jumps in curvature,

    p(s) → p(s) + n(s) Σ_k h_k (1 − ((s − s_k) / w_k)²)³        |s − s_k| < w_k

n being its normal to the left, and measured again. It begins and ends where it did. Where two paths have a stretch in
common in opposite directions, both robots keep to the right of it.
"""

from collections.abc import Sequence

import numpy as np

from robotics.path import CURVATURE, HEADING, U, X, Y

WIDTH, NARROWEST = 1.6, 0.6  # m: half the length of a bump, and what there must be room for
SHARPEST = 5.0  # 1/m: no path is bent further
_ROUNDS = 8
_FACING = -0.8  # cosine of the angle between two paths that run against each other


def sidestepped(tables: Sequence[np.ndarray], clear: float, mirrored: bool = False) -> list[np.ndarray]:
    """``tables`` (5, nodes) of one team's paths (:class:`robotics.path.Path`), bent where others start or end.

    ``clear`` [m] is what they keep from there, where there is room; the shift is away from the other robot, and
    ``mirrored`` to the other side, past it. A path that would become too sharp is left as it is.
    """
    ends = [(table[:2, 0], table[:2, -1]) for table in tables]
    bent = [
        _around(table, [p for j, pair in enumerate(ends) if j != i for p in pair], clear, mirrored)
        for i, table in enumerate(tables)
    ]
    return _keeping_right(bent, clear)


def _around(table: np.ndarray, points: list[np.ndarray], clear: float, mirrored: bool) -> np.ndarray:
    """One path, bent around ``points``."""
    for _ in range(_ROUNDS):
        shift = np.zeros(table.shape[1])
        s = _abscissae(table)
        for point in points:
            distance = np.hypot(table[X] - point[0], table[Y] - point[1])
            k = int(np.argmin(distance))
            room = min(s[k], s[-1] - s[k])
            if distance[k] >= clear or room < NARROWEST:
                continue
            left = -np.sin(table[HEADING, k]) * (point[0] - table[X, k]) + np.cos(table[HEADING, k]) * (
                point[1] - table[Y, k]
            )
            away = -1.0 if left > 0 else 1.0
            gap = clear + 0.02 - abs(left)
            if mirrored and abs(left) < clear / 2:
                away, gap = -away, clear + 0.02 + abs(left)
            shift += away * gap * _bump((s - s[k]) / min(WIDTH, room))
        if not shift.any():
            return table
        mirrored = False  # once past the point, away from it
        moved = _shifted(table, shift)
        if moved is None:
            return table
        table = moved
    return table


def _keeping_right(tables: list[np.ndarray], clear: float) -> list[np.ndarray]:
    """The paths, both shifted to the right where two run against each other."""
    tables = list(tables)
    for i in range(len(tables)):
        for j in range(i):
            a, b = tables[i], tables[j]
            facing = np.cos(a[HEADING][:, None] - b[HEADING]) < _FACING
            near = facing & (np.hypot(a[X][:, None] - b[X], a[Y][:, None] - b[Y]) < clear)
            if not near.any():
                continue
            for k, met in ((i, near.any(axis=1)), (j, near.any(axis=0))):
                s = _abscissae(tables[k])
                first, last = s[np.flatnonzero(met)[[0, -1]]]
                flat = np.clip(np.abs(s - (first + last) / 2) - (last - first) / 2, 0.0, None)
                room = min(WIDTH, max(first, NARROWEST), max(s[-1] - last, NARROWEST))
                shift = -(clear / 2 + 0.02) * _bump(flat / room)
                # The ends stay, whatever lies near them.
                shift *= np.clip(np.minimum(s, s[-1] - s) / NARROWEST, 0.0, 1.0) ** 3
                moved = _shifted(tables[k], shift)
                if moved is not None:
                    tables[k] = moved
    return tables


def _bump(u: np.ndarray) -> np.ndarray:
    return np.where(np.abs(u) < 1, (1 - np.minimum(u**2, 1.0)) ** 3, 0.0)


def _abscissae(table: np.ndarray) -> np.ndarray:
    chords = np.hypot(np.diff(table[X]), np.diff(table[Y]))
    return np.concatenate([[0.0], np.cumsum(chords)])


def _shifted(table: np.ndarray, shift: np.ndarray) -> np.ndarray | None:
    """The table of the path ``shift`` [m] (nodes,) to the left of ``table``; None if it has a cusp or is too sharp."""
    from scipy.interpolate import CubicSpline

    x = table[X] - np.sin(table[HEADING]) * shift
    y = table[Y] + np.cos(table[HEADING]) * shift
    curve = CubicSpline(np.linspace(0.0, 1.0, len(x)), np.stack([x, y], axis=1))
    fine = np.linspace(0.0, 1.0, 8 * len(x))
    speed = np.hypot(*curve(fine, 1).T)
    if speed.min() < 0.2 * speed.max():
        return None
    s = np.concatenate([[0.0], np.cumsum((speed[1:] + speed[:-1]) / 2 * np.diff(fine))])
    u = np.interp(np.linspace(0.0, s[-1], max(len(x), int(np.ceil(s[-1] / 0.02)) + 1)), s, fine)
    (x, y), slope, bend = curve(u).T, curve(u, 1).T, curve(u, 2).T
    result = np.empty((5, len(u)))
    result[X], result[Y] = x, y
    result[HEADING] = np.unwrap(np.arctan2(slope[1], slope[0]))
    result[HEADING] += 2 * np.pi * np.round((table[HEADING, 0] - result[HEADING, 0]) / (2 * np.pi))
    result[CURVATURE] = (slope[0] * bend[1] - slope[1] * bend[0]) / np.hypot(*slope) ** 3
    result[U] = u
    steepest = max(SHARPEST, float(np.abs(table[CURVATURE]).max()))
    return result if np.abs(result[CURVATURE]).max() <= steepest else None
