"""Contacts of robots with each other and with obstacles, in true size and between the samples too.

The judgement is that of :mod:`robotics.world.environment.swept`: a robot's own rectangle, carried from sample to sample
on its recorded motion. A robot that was stopped is measured up to then.
"""

from collections.abc import Iterator
from dataclasses import dataclass
from functools import partial

import numpy as np

from robotics.measures.once import CachedPerRun
from robotics.measures.tracking import SCENARIO_KINDS, Metric
from robotics.simulation.run import Run
from robotics.world.environment.swept import ContactColumns, Watch, pose_between
from robotics.world.environment.world import BodyColumns, Geometry

MOST_DRAWN = 500  # contacts of a seed that a picture marks
_POSE = 5  # the first channels of a run: x, y, heading, v, ω


@dataclass(frozen=True)
class Contact:
    """A contact of a robot with another one or with an obstacle; robots and obstacles count from 0."""

    robot: int
    other: int | None  # the other robot, of higher number
    obstacle: int | None  # as numbered in the scenario's file, from 0
    start: float  # s
    end: float  # s: the run's last sample, or the last before a robot was stopped, if it went on till then
    depth: float  # m: the least distance by which the shapes would have had to be moved apart when it was deepest
    x: float  # m: where it began
    y: float  # m


@dataclass(frozen=True, eq=False)
class Judgement:
    """The contacts and clearances of all seeds of a run."""

    first: np.ndarray  # (runs,) s: begin of the first contact of any robot; inf: there was none
    counts: np.ndarray  # (runs, robots) int: contacts of each robot
    least: np.ndarray  # (runs, robots) m: least signed clearance to another robot or an obstacle; < 0: how deep
    episodes: np.ndarray  # (contacts, 7): the columns of robotics.world.environment.swept, by run and time


def can_touch(run: Run) -> bool:
    """Whether there is something to touch in a run: several robots, or obstacles."""
    return len(run.about.robots) > 1 or run.obstacles is not None


@CachedPerRun
def judge(run: Run) -> Judgement:
    """Find all contacts and clearances of a run's seeds, in one compiled pass."""
    *_, (watch, episodes) = _watched(run, len(run.time))
    return Judgement(watch.known.first.min(axis=(0, 2)), watch.known.counts, watch.known.least.min(axis=0), episodes)


def _watched(run: Run, stretch: int = 64) -> Iterator[tuple[Watch, np.ndarray]]:
    """Watch a run, ``stretch`` samples at a time; yield the watch and all contacts so far, by run and time."""
    poses, world = np.moveaxis(run.samples[:, :_POSE], 0, -1), run.obstacles

    def placed(first: int, last: int) -> Geometry | None:
        moves = world is not None and len(world.counts) > 1
        return Geometry(*(part[first:last] for part in world)) if moves and world is not None else world

    watch = Watch.opened(run.about.robots, float(run.time[0]), poses[..., 0], placed(0, 1))
    begin, ended = 0, np.zeros((0, ContactColumns.size))
    while True:
        end = min(begin + stretch, len(run.time))
        watch, rows = watch.along(run.time[begin:end], poses[..., begin:end], placed(begin, end))
        ended = np.concatenate([ended, rows])
        episodes = np.concatenate([ended, watch.open_contacts()])
        by_name = ContactColumns(episodes.T)
        yield watch, episodes[np.lexsort((by_name.start, by_name.run))]
        if end == len(run.time):
            return
        begin = end - 1


def contacts(run: Run, place: int = 0, most: int | None = None) -> tuple[Contact, ...]:
    """The contacts of the run's seed at ``place``, by time; only the first ones where ``most`` are asked for."""
    if not can_touch(run):
        return ()
    one = run.only(run.seeds[place])
    if most is None or judge.known(one):
        return contacts_of(run, place, judge(one).episodes[:most])
    for watch, found in _watched(one):  # a crowd touches all the time: until the first ones are known to have ended
        episodes = found
        if len(episodes) >= most and (ContactColumns(episodes[:most].T).end < watch.time).all():
            break
    return contacts_of(run, place, episodes[:most])


def contacts_of(run: Run, place: int, episodes: np.ndarray) -> tuple[Contact, ...]:
    """The contacts of the run's seed at ``place``, from the ``episodes`` of a :class:`Judgement` of it alone."""
    found = []
    for _, robot, other, obstacle, start, end, depth in episodes:
        with_robot, with_obstacle = (None if n < 0 else int(n) for n in (other, obstacle))
        x, y = _touched(run, place, int(robot), with_robot, with_obstacle, start)
        found.append(Contact(int(robot), with_robot, with_obstacle, float(start), float(end), float(depth), x, y))
    return tuple(found)


def contact_sentences(run: Run) -> list[str]:
    """A sentence for each seed with contacts: who touched what first, and when."""
    if not can_touch(run):
        return []
    episodes = judge(run).episodes
    lines = []
    runs = ContactColumns(episodes.T).run
    for place in np.unique(runs).astype(int):
        mine = episodes[runs == place]
        more = f", and {len(mine) - 1} more" if len(mine) > 1 else ""
        found = ContactColumns(mine[0])
        first = who(int(found.robot), int(found.other), int(found.obstacle))
        lines.append(
            f"seed {run.seeds[place]}: {first} touch at t = {found.start:.3f} s, {1000 * found.depth:.1f} mm deep{more}"
        )
    return lines


def who(robot: int, other: int | None, obstacle: int | None) -> str:
    """The two that touch, in words: "robots 1 and 2", or "robot 1 and obstacle 3"."""
    if other is not None and other >= 0:
        return f"robots {robot + 1} and {other + 1}"
    assert obstacle is not None
    return f"robot {robot + 1} and obstacle {obstacle + 1}"


def first_contact(run: Run) -> np.ndarray:
    """The time [s] (runs,) at which the first contact of any robot begins; infinite: there is none."""
    first = np.full(len(run.seeds), np.inf)
    for watch, _ in _watched(run) if can_touch(run) else ():
        first = watch.known.first.min(axis=(0, 2))
        if np.isfinite(first).all():
            break
    return first


def until_contact(run: Run, first: np.ndarray) -> Run:
    """The same run with not-a-number for all samples that lie after ``first`` (runs,) [s]."""
    after = run.time[:, None] > first  # (samples, runs)
    if not after.any():
        return run
    arrays = {}
    for name in ("samples", "team"):
        if name in run.recorded:
            values = np.array(run.recorded[name].values, order="K")
            np.moveaxis(values, 1, -1)[after] = np.nan
            arrays[name] = values
    return run.with_recorded(**arrays)


_of_contacts = partial(Metric, headline=SCENARIO_KINDS, tried=("tracking", "team", "goal"), needs_others=True)
CONTACT_METRICS: dict[str, Metric] = {
    "contacts": _of_contacts(
        lambda run: judge(run).counts.astype(float),
        "1",
        "contacts with other robots and obstacles",
        of_run="max",
        short="contacts",
    ),
    "min_clearance_m": _of_contacts(
        lambda run: judge(run).least,
        "m",
        "least clearance to a robot or an obstacle, surface to surface; below 0: overlap",
        of_run="min",
        short="least clearance",
        larger=True,
    ),
}


# Where -------------------------------------------------------------------------------------------------------------


def _touched(
    run: Run, place: int, robot: int, other: int | None, obstacle: int | None, time: float
) -> tuple[float, float]:
    """The middle [m] of what two that touch at ``time`` [s] have in common."""
    k = int(np.clip(np.searchsorted(run.time, time, side="right") - 1, 0, max(len(run.time) - 2, 0)))
    last = min(k + 1, len(run.time) - 1)
    period = float(run.time[last] - run.time[k])
    share = (time - float(run.time[k])) / period if period > 0 else 0.0
    both = [robot] if other is None else [robot, other]
    before, after = (run.samples[m, :_POSE, place][:, both] for m in (k, last))
    pose = pose_between(period, before, np.where(np.isfinite(after), after, before), share)
    half = np.array([run.about.robots[robot].length, run.about.robots[robot].width]) / 2
    x, y, heading = pose[:, 0]
    turn = np.array([[np.cos(heading), np.sin(heading)], [-np.sin(heading), np.cos(heading)]])
    if other is not None:
        size = run.about.robots[other]
        corners = np.array([[-1, -1], [1, -1], [1, 1], [-1, 1]]) * (size.length / 2, size.width / 2)
        c, s = np.cos(pose[2, 1]), np.sin(pose[2, 1])
        ends = corners @ np.array([[c, s], [-s, c]]) + pose[:2, 1]
        sides, near = np.concatenate([ends, np.roll(ends, -1, axis=0)], axis=1), pose[:2, 1]
    else:
        assert run.obstacles is not None
        assert obstacle is not None
        sides, near = _obstacle_sides(run.obstacles, (k, last, share), obstacle, (x, y))
    inner = _common(sides, (x, y), turn, half)
    if inner is None:  # one lies in the other
        inner = np.clip(turn @ (near - (x, y)), -half, half)
    found = turn.T @ inner + (x, y)
    return float(found[0]), float(found[1])


def _obstacle_sides(
    world: Geometry, when: tuple[int, int, float], obstacle: int, at: tuple[float, float]
) -> tuple[np.ndarray, np.ndarray]:
    """The sides (sides, 4) of an obstacle between two samples, and the middle of its circle nearest to ``at``."""
    first, last = (min(k, len(world.counts) - 1) for k in when[:2])
    circles, segments = ((1 - when[2]) * part[first] + when[2] * part[last] for part in (world.circles, world.segments))
    mine = np.flatnonzero(BodyColumns(world.bodies[0, : world.counts[0]].T).owner == obstacle)
    gaps = np.hypot(*(circles[mine, :2] - at).T) - circles[mine, 2]
    near = circles[mine[np.argmin(gaps)], :2]
    bodies = [BodyColumns(b) for b in world.bodies[0, mine]]
    return np.concatenate([segments[b.first : b.first + b.number] for b in bodies]), near


def _common(sides: np.ndarray, at: tuple[float, float], turn: np.ndarray, half: np.ndarray) -> np.ndarray | None:
    """The middle of the parts of ``sides`` (sides, 4) that lie in a rectangle, in its frame; None: there are none."""
    total, weight = np.zeros(2), 0.0
    for side in sides:
        a, b = turn @ (side[:2] - at), turn @ (side[2:] - at)
        low, high = 0.0, 1.0
        for m in (0, 1):  # clip by the strip of each axis [Liang & Barsky 1984]
            step = b[m] - a[m]
            if abs(step) < 1e-12:
                if abs(a[m]) > half[m] + 1e-6:
                    high = -1.0
                continue
            ends = sorted(((-half[m] - 1e-6 - a[m]) / step, (half[m] + 1e-6 - a[m]) / step))
            low, high = max(low, ends[0]), min(high, ends[1])
        if low <= high:
            part = (high - low) * float(np.hypot(*(b - a))) + 1e-9
            total, weight = total + part * (a + (low + high) / 2 * (b - a)), weight + part
    return total / weight if weight else None
