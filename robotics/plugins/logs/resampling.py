"""Drives on one grid of times: postures interpolated, commands held, and a cut wherever something is missing.

Odometry, commands and references come at rates of their own, and jitter. At each time of the grid

* the posture and the velocities are interpolated between the samples before and after it, the heading without its
  jumps of 2π;
* the command is the last one given, which holds until the next;
* the reference is interpolated like the posture.

Where the two samples around a time are farther apart than a limit, or the last command is older than it, nothing is
known: the drive is cut there, and goes on as another piece. It is cut, too, where the robot gets another path.
"""

from dataclasses import dataclass

import numpy as np

from robotics.plugins.logs.drive import Drive, PlannedPath, Track
from robotics.plugins.logs.typestore import LogError

_AT_ONCE = 1e-6  # s: stamps are whole nanoseconds, and times of the grid are not
_LEAST = 2  # samples of a piece


@dataclass(frozen=True, eq=False)
class DrivePiece:
    """A part of a drive without gaps, at times that are equally far apart; arrays are (samples,)."""

    start: float  # s: of the drive, by the clock of its odometry
    time: np.ndarray  # s since then
    x: np.ndarray  # m
    y: np.ndarray  # m
    heading: np.ndarray  # rad, not wrapped
    v: np.ndarray  # m/s
    w: np.ndarray  # rad/s
    v_commanded: np.ndarray  # m/s
    w_commanded: np.ndarray  # rad/s
    plan: PlannedPath | None  # the path that the robot had


def pieces(
    drive: Drive, period: float = 0.05, gap: float = 0.5, delay: float = 0.0, *, whole: bool = False
) -> tuple[DrivePiece, ...]:
    """The parts of ``drive`` without gaps, on a grid of times.

    Args:
        drive: The drive.
        period: From time to time [s].
        gap: The longest time [s] without odometry, without a command, or without a reference.
        delay: From a posture to the command that answers it [s].
        whole: Whether the beginning and the end stay, where nothing is commanded.

    Raises LogError where nothing is left.
    """
    for name, value, least in (("period", period, 1e-3), ("gap", gap, period), ("delay", delay, 0.0)):
        if not least <= value <= 60.0:
            raise LogError(f"{name} must be a number of seconds from {least:g} to 60, got {value:g}")
    seen, given = _moving(drive.odometry), drive.commands
    start = max(seen.time[0], given.time[0] - delay)
    count = int(np.floor((min(seen.time[-1], given.time[-1] + gap - delay) - start) / period + _AT_ONCE)) + 1
    if count < _LEAST:
        raise LogError(
            f"{drive.log}: {drive.topics['odometry']} (from {seen.time[0]:.3f} to {seen.time[-1]:.3f} s) and "
            f"{drive.topics['commands']} (from {given.time[0]:.3f} to {given.time[-1]:.3f} s) do not overlap"
        )
    grid = start + period * np.arange(count)
    place = np.searchsorted(given.time, grid + delay + _AT_ONCE, side="right") - 1
    known = _known(seen.time, grid, gap) & (place >= 0) & (grid + delay - given.time[np.maximum(place, 0)] <= gap)
    if drive.reference is not None:
        known &= _known(drive.reference.time, grid, gap)
    v, w = given.v[np.maximum(place, 0)], given.w[np.maximum(place, 0)]
    if not whole:
        driven = np.flatnonzero(known & ((v != 0) | (w != 0)))
        if not len(driven):
            raise LogError(f"{drive.log}: {drive.topics['commands']} commands nothing but to stand still")
        known[: driven[0]] = known[driven[-1] + 1 :] = False
    turns = np.array([plan.time for plan in drive.plans[1:]])
    plan = np.searchsorted(turns, grid, side="right")
    cuts = np.flatnonzero((np.diff(known.astype(int)) != 0) | (np.diff(plan) != 0)) + 1
    found = []
    for part in np.split(np.arange(count), cuts):
        if known[part[0]] and len(part) >= _LEAST:
            at = grid[part]
            x, y, heading, speed, turn = (np.interp(at, seen.time, values) for values in seen[1:])
            path = drive.plans[int(plan[part[0]])] if drive.plans else None
            found.append(DrivePiece(start, at - start, x, y, heading, speed, turn, v[part], w[part], path))
    if not found:
        raise LogError(
            f"{drive.log}: no {_LEAST} moments in a row are known: its messages are farther apart than {gap:g} s"
        )
    return tuple(found)


def _known(time: np.ndarray, grid: np.ndarray, gap: float) -> np.ndarray:
    """Whether the samples at ``time`` before and after each time of the ``grid`` are no farther apart than ``gap``."""
    after = np.searchsorted(time, grid - _AT_ONCE, side="left")
    before = np.searchsorted(time, grid + _AT_ONCE, side="right") - 1
    inside = (before >= 0) & (after < len(time))
    before, after = np.maximum(before, 0), np.minimum(after, len(time) - 1)
    return inside & (time[after] - time[before] <= gap)


def _moving(track: Track) -> Track:
    """The track with its velocities; those of its postures where it does not tell them.

    Raises LogError for a track of one sample.
    """
    if len(track.time) < _LEAST:
        raise LogError("the odometry has fewer than two messages")
    if np.isfinite(track.v).all() and np.isfinite(track.w).all():
        return track
    ahead = np.gradient(track.x, track.time) * np.cos(track.heading)
    ahead += np.gradient(track.y, track.time) * np.sin(track.heading)
    return track._replace(v=ahead, w=np.gradient(track.heading, track.time))
