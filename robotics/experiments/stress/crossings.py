"""Random crossings: teams whose paths meet, so that robots which keep their timing would collide.

Paths lie in a field of 16 m² a robot, 8 × 6 m for three, at least one pair nearer than 0.4 m at equal progress; starts
and ends are at least 0.6 m clear of the other paths (class A), or only 0.9 m apart from each other (class B). The
thesis has its two tests only; the classes are a choice.
"""

from collections.abc import Callable, Sequence
from dataclasses import replace
from typing import Literal

import numpy as np

from robotics.experiments.stress.conflict import ends_clear, evenly, in_conflict
from robotics.laws.setting import Setting
from robotics.paths.joined import join_tables
from robotics.paths.path import Quintic, X, Y
from robotics.paths.quintic_table import quintic_table
from robotics.paths.references import EvenTiming
from robotics.paths.trajectory import Timing
from robotics.radio.description import Radio
from robotics.scenario.description import Member, Scenario
from robotics.sensing.posture import LABORATORY

CROSSING_STREAM = 6  # of a seed's random streams: see robotics.radio.channel
AREA = 16.0  # m² of the field for each robot
ASPECT = 4 / 3  # ratio of the field's sides
APART = 0.9  # m: in class B starts, and ends, are at least this far from each other
SPEED = 0.22  # m/s: mean speed on the longest path


def crossing_ensemble(
    robots: int,
    seeds: Sequence[int],
    kind: Literal["A", "B"] = "A",
    *,
    radio: Radio | None = None,
    factor: float = 4.0,
    extra: float = 0.0,
    advance: Callable[[], None] | None = None,
) -> Setting:
    """A random crossing for every seed; a seed's crossing is the same whatever the other seeds are.

    Args:
        robots: Number of robots of each crossing.
        seeds: One crossing for each.
        kind: Class of the crossings: "A", whose ends are clear of the other paths, or "B", whose ends are only apart.
        radio: The radio over which the robots talk, by default a perfect one.
        factor: The longest a run takes, in times the longest nominal duration, and
        extra: this many seconds more.
        advance: Called after every crossing that is drawn.
    """
    drawn = []
    for seed in seeds:
        drawn.append(random_crossing(robots, np.random.default_rng([seed, CROSSING_STREAM]), kind))
        if advance is not None:
            advance()
    paths = join_tables(drawn)
    durations = paths.lengths.max(axis=1) / SPEED
    starts = np.array([[(t[X, 0], t[Y, 0], t[2, 0]) for t in tables] for tables in drawn])
    shared = Member(
        start=(0.0, 0.0, 0.0),
        path=Quintic(start=(0.0, 0.0), end=(5.0, 0.0)),
        timing=Timing(duration=float(np.ceil(durations.max()))),
    )
    scenario = Scenario(
        name=f"crossing-{robots}-{kind}",
        robots=(shared,) * robots,
        duration=float(np.ceil(factor * durations.max() + extra)),
        kind="team",
        sensing=LABORATORY,
        radio=radio or Radio(),
    )
    return replace(scenario.setting, starts=starts, references=EvenTiming(paths, durations))


def random_crossing(robots: int, rng: np.random.Generator, kind: Literal["A", "B"] = "A") -> list[np.ndarray]:
    """The tables of the paths of one crossing, one for each robot.

    Args:
        robots: Number of robots.
        rng: The generator from which the crossing is drawn.
        kind: Class of the crossing, "A" or "B".
    """
    field = np.sqrt(AREA * robots * np.array([ASPECT, 1 / ASPECT]))
    while True:
        shapes: list[Quintic] = []
        points: list[np.ndarray] = []
        for _ in range(400 * robots):
            drawn = _random_path(rng, field)
            if drawn is not None and all(_clear(drawn[1], other, kind) for other in points):
                shapes.append(drawn[0])
                points.append(drawn[1])
            if len(shapes) == robots:
                break
        if len(shapes) == robots and in_conflict(np.array(points)):
            return [quintic_table(shape) for shape in shapes]


def _random_path(rng: np.random.Generator, field: np.ndarray) -> tuple[Quintic, np.ndarray] | None:
    """A path, and points (samples, 2) [m] at equal shares of its length, to a few millimetres."""
    start, end = rng.uniform(0.0, 1.0, (2, 2)) * field
    gap = end - start
    reach = float(np.hypot(*gap))
    bends = np.arctan2(gap[1], gap[0]) + rng.uniform(-0.7, 0.7, 2)
    if reach < 0.5 * np.sqrt(field.prod()) or reach < 2.0:
        return None
    out, into = (reach * np.array([np.cos(a), np.sin(a)]) for a in bends)
    shape = Quintic(start=tuple(start), end=tuple(end), start_tangent=tuple(out), end_tangent=tuple(into))
    points = evenly(shape)
    return None if points is None else (shape, points)


def _clear(a: np.ndarray, b: np.ndarray, kind: str) -> bool:
    """May the paths ``a`` and ``b`` (samples, 2) be in one crossing?"""
    return ends_clear(a, b) if kind == "A" else min(np.hypot(*(a[k] - b[k])) for k in (0, -1)) >= APART
