"""A replay: what a moving picture of one seed of a run shows.

It holds poses, speeds and targets, the faults and stops as spans of time, which messages were stale when, the
obstacles, the readings of the sonars, and the mode of each robot.
"""

from dataclasses import dataclass, field, fields
from typing import NamedTuple

import numpy as np
import pandas as pd

from robotics.laws.catalogue import law_title
from robotics.measures.contacts import MOST_DRAWN, Contact, contacts
from robotics.simulation.mode_changes import ModeChange, mode_changes_in
from robotics.simulation.run import Run
from robotics.simulation.spans import FaultSpan, ReplayError, _after, fault_spans, seed_place
from robotics.world.environment.world import BodyColumns, Geometry, outlines

_MOST_STALE = 40_000  # spans of stale messages kept: the longest


@dataclass(frozen=True, eq=False)
class ReplayFrame:
    """The places of the robots; each array is (robots,) at one time, or (robots, frames) of a whole replay."""

    x: np.ndarray = field(repr=False)  # m
    y: np.ndarray = field(repr=False)  # m
    heading: np.ndarray = field(repr=False)  # rad, not wrapped
    v: np.ndarray = field(repr=False)  # m/s
    w: np.ndarray = field(repr=False)  # rad/s
    x_target: np.ndarray = field(repr=False)  # m
    y_target: np.ndarray = field(repr=False)  # m


class StaleSpans(NamedTuple):
    """The spans of time in which what a robot knew of another was stale; each field is (spans,)."""

    receiver: np.ndarray  # from 0
    sender: np.ndarray
    start: np.ndarray  # s
    end: np.ndarray  # s
    age: np.ndarray  # s, at the start, growing since; infinite if nothing was heard yet

    def at(self, time: float) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """The receivers, senders and ages [s] of the stale links at ``time`` [s]."""
        now = (self.start <= time) & (time < self.end)
        return self.receiver[now], self.sender[now], self.age[now] + (time - self.start[now])


@dataclass(frozen=True, eq=False)
class Replay(ReplayFrame):
    """One seed of a run. Arrays are (robots, frames) unless stated otherwise; a stopped robot stays where it was."""

    run: Run = field(repr=False)
    place: int  # of the seed in the run
    time: np.ndarray = field(repr=False)  # (frames,) s
    progress: np.ndarray | None = field(repr=False)  # 1; none: the law has no path parameter
    stops: np.ndarray = field(repr=False)  # (robots,) s; infinite: never stopped
    faults: tuple[FaultSpan, ...] = field(repr=False)
    hears: np.ndarray | None = field(repr=False)  # (receivers, senders) bool; none: no messages were recorded
    stale: StaleSpans = field(repr=False)
    stale_after: float = 0.0  # s: older messages are stale
    obstacles: Geometry | None = field(default=None, repr=False)  # its first axis: the frames, or 1 if all rest
    ranges: np.ndarray | None = field(default=None, repr=False)  # (robots, sensors, frames) m; inf: nothing
    modes: np.ndarray | None = field(default=None, repr=False)  # codes of robotics.laws.modes.MODES
    handovers: tuple[ModeChange, ...] = field(default=(), repr=False)  # changes of mode, in the order of time
    contacts: tuple[Contact, ...] = field(default=(), repr=False)  # by time, of the first MOST_DRAWN those it shows

    @property
    def title(self) -> str:
        """The law, the scenario and the seed, in words."""
        return f"{law_title(self.run.controller)} on {self.run.scenario}, seed {self.run.seeds[self.place]}"

    @property
    def bounds(self) -> tuple[float, float, float, float]:
        """The least and greatest x, then y [m], of all paths, driven trajectories and obstacles."""
        parts = [*self.run.paths, np.stack([self.x.ravel(), self.y.ravel()])]
        if self.obstacles is not None:
            circles = self.obstacles.circles[:, : self.obstacles.counts[0]]
            centers, radius = np.moveaxis(circles[..., :2], -1, 0), circles[..., 2]
            disc = self.obstacles.bodies[:, : circles.shape[1], BodyColumns.number.row] == 0
            ends = np.moveaxis(self.obstacles.segments.reshape(-1, 2), -1, 0)
            parts += [ends, *((centers[:, disc] + way * radius[disc]) for way in (-1, 1))]
        points = np.concatenate(parts, axis=1)
        (left, bottom), (right, top) = np.nanmin(points, axis=1), np.nanmax(points, axis=1)
        return float(left), float(right), float(bottom), float(top)

    def at(self, time: float) -> ReplayFrame:
        """The robots at ``time`` [s], interpolated between frames."""
        k, after, share = self._between(time)
        rows = (getattr(self, f.name) for f in fields(ReplayFrame))
        return ReplayFrame(*((1 - share) * row[:, k] + share * row[:, after] for row in rows))

    def _between(self, time: float) -> tuple[int, int, float]:
        """The frames before and after ``time`` [s], and how far it is from the one to the other, 0 to 1."""
        k = int(np.clip(np.searchsorted(self.time, time, side="right") - 1, 0, max(0, len(self.time) - 2)))
        after = min(k + 1, len(self.time) - 1)
        share = np.clip((time - self.time[k]) / ((self.time[after] - self.time[k]) or 1.0), 0.0, 1.0)
        return k, after, float(share)

    def obstacles_at(self, time: float) -> list[np.ndarray]:
        """The outlines of the obstacles at ``time`` [s], as of :func:`robotics.world.environment.world.outlines`."""
        if self.obstacles is None:
            return []
        if len(self.obstacles.counts) == 1:
            return outlines(self.obstacles)
        k, after, share = self._between(time)
        circles, segments = (
            (1 - share) * part[k : k + 1] + share * part[after : after + 1]
            for part in (self.obstacles.circles, self.obstacles.segments)
        )
        rest = Geometry(circles, self.obstacles.bodies[k : k + 1], segments, self.obstacles.counts[k : k + 1])
        return outlines(rest)

    def mode_at(self, robot: int, time: float) -> int:
        """The code of a robot's mode at ``time`` [s], that of the last frame: modes are not interpolated."""
        if self.modes is None:
            return 0
        k = int(np.clip(np.searchsorted(self.time, time + 1e-9, side="right") - 1, 0, len(self.time) - 1))
        return int(self.modes[robot, k])

    def kind_at(self, robot: int, time: float) -> str:
        """The kind of fault of a robot at ``time`` [s], or ""."""
        return next((f.kind for f in self.faults if f.robot == robot and f.start <= time < f.end), "")


def replay(run: Run, times: np.ndarray, seed: int | None = None, stale: float | None = None) -> Replay:
    """Make the replay of one seed of a run, interpolated between samples.

    Args:
        run: The run.
        times: The times of the frames (frames,) [s].
        seed: The seed, by default the first.
        stale: The age [s] from which a message is stale, by default the greater of five periods and three times the
            median age.

    Raises ReplayError for a seed that was not run, or a ``stale`` that is no positive number.
    """
    place = seed_place(run, seed)
    if stale is not None and not (np.isfinite(stale) and stale > 0):
        raise ReplayError(f"the age from which messages are stale must be > 0 s, got {stale:g}")

    # What cannot be interpolated is that of the last sample.
    held = np.clip(np.searchsorted(run.time, times + 1e-9, side="right") - 1, 0, len(run.time) - 1)
    sampled = np.array_equal(run.time[held], times)

    def over(values: np.ndarray) -> np.ndarray:
        known = _held(values)
        return known[:, held] if sampled else np.stack([np.interp(times, run.time, row) for row in known])

    team = run.team is not None
    rows = {name: run[name][place] for name in ("x", "y", "v", "w")}
    rows["heading"] = np.unwrap(_held(run["heading"][place]))
    rows |= {f"{name}_target": run[f"{name}_target"][place] if team else run.target(name) for name in "xy"}
    progress = run["progress"][place] if team else np.full(1, np.nan)
    hears, spans, limit = None, StaleSpans(*np.zeros((5, 0))), 0.0
    if run.message_ages is not None:
        limit = stale or _usual(run, place)
        hears, spans = _staleness(run, place, limit)
    stopped = run.stopped[place]
    obstacles = run.obstacles
    if obstacles is not None and len(obstacles.counts) > 1:
        obstacles = Geometry(*(part[held] for part in obstacles))
    ranges = None if run.ranges is None else np.moveaxis(run.ranges[held, place], 0, -1)
    modes: np.ndarray | None = None
    handovers: tuple[ModeChange, ...] = ()
    if run.modes is not None:
        modes = run.modes[held, place].T
        changes = mode_changes_in(run.time, run.modes[:, place : place + 1])
        handovers = tuple(e for e in changes if times[0] < e.time <= times[-1] + 1e-9)
    return Replay(
        **{name: over(values) for name, values in rows.items()},
        run=run,
        place=place,
        time=times,
        progress=over(progress) if np.isfinite(progress).any() else None,
        stops=np.where(stopped >= 0, run.time[stopped], np.inf),
        faults=fault_spans(run, place),
        hears=hears,
        stale=spans,
        stale_after=limit,
        obstacles=obstacles,
        ranges=ranges,
        modes=modes,
        handovers=handovers,
        contacts=tuple(
            c for c in contacts(run, place, MOST_DRAWN) if c.start <= times[-1] + 1e-9 and c.end >= times[0]
        ),
    )


def _held(rows: np.ndarray) -> np.ndarray:
    """``rows`` (robots, samples) with every unknown value as the last known one before it; at the start, the first."""
    if np.isfinite(rows).all():
        return np.ascontiguousarray(rows)
    known = np.where(np.isfinite(rows), rows, np.nan)
    return np.ascontiguousarray(pd.DataFrame(known.T).ffill().bfill().to_numpy().T)


def _usual(run: Run, place: int) -> float:
    """The age [s] from which a message is unusually old, with two digits."""
    assert run.message_ages is not None
    some = run.message_ages[:: max(1, len(run.time) // 200), place]
    known = some[np.isfinite(some)]
    period = float(run.time[1] - run.time[0])
    return float(f"{max(5 * period, 3 * float(np.median(known)) if known.size else 0.0):.2g}")


def _staleness(run: Run, place: int, limit: float) -> tuple[np.ndarray, StaleSpans]:
    """Who ever heard whom (robots, robots), and when that was stale.

    The wait for the first message is not stale before ``limit`` has passed, and the wait of those who never hear
    each other not at all.
    """
    assert run.message_ages is not None
    time, robots = run.time, run.message_ages.shape[2]
    hears = np.zeros((robots, robots), dtype=bool)
    parts = []
    for i in range(robots):  # one receiver at a time: all links of a large team are large
        age = run.message_ages[:, place, i]
        hears[i] = np.isfinite(age).any(axis=0)
        old = (age > limit + 1e-6) & hears[i]
        young = age[1:] < age[:-1]  # a newer message came, if only a stale one
        starts = old.copy()
        starts[1:] &= ~old[:-1] | young
        ends = old.copy()
        ends[:-1] &= ~old[1:] | young
        sender, a = np.nonzero(starts.T)
        _, b = np.nonzero(ends.T)
        until = _after(run, b + 1)
        keep = ~((a == 0) & (until - time[0] <= limit + 1e-9))
        spans = (np.full(len(a), i), sender, time[a], until, age[a, sender].astype(float))
        parts.append(tuple(column[keep] for column in spans))
    columns = [np.concatenate(column) for column in zip(*parts, strict=True)]
    if len(columns[0]) > _MOST_STALE:
        longest = np.sort(np.argsort(columns[2] - columns[3], kind="stable")[:_MOST_STALE])
        columns = [column[longest] for column in columns]
    return hears, StaleSpans(*columns)
