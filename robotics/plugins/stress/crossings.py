"""Random crossings: teams whose paths meet, so that robots which keep their timing would collide.

Paths lie in a field of 16 m² a robot, 8 × 6 m for three, at least one pair nearer than 0.4 m at equal progress; starts
and ends are at least 0.6 m clear of the other paths (class A), or only 0.9 m apart from each other (class B). The
thesis has its two tests only; the classes are a choice.
"""

import math
from collections.abc import Callable, Sequence
from dataclasses import replace
from typing import Any, Literal

import numpy as np

from fuzzy.compiled.jit import kernel
from fuzzy.compiled.threads import share_out
from fuzzy.shell.progress import Begin, unwatched
from robotics.laws.catalogue import as_law
from robotics.laws.law import Law
from robotics.laws.setting import Setting
from robotics.plugins.stress.conflict import (
    CLEAR,
    CONFLICT,
    SAMPLES,
    ends_apart,
    ends_clear,
    in_conflict,
    sampled_evenly,
)
from robotics.plugins.stress.disturbance import UNDISTURBED, Disturbance
from robotics.plugins.stress.outcome import StressOutcome
from robotics.plugins.stress.quintic_table import fill, tabulated
from robotics.plugins.stress.tally import run_ensemble
from robotics.simulation.loop import Periods, threads_for
from robotics.simulation.scenario.description import Member, Scenario
from robotics.simulation.scenario.robots import RobotModel, load_robot, standard_robot
from robotics.world.paths.joined import join_tables
from robotics.world.paths.path import PathColumns, Quintic
from robotics.world.paths.references import even_timing
from robotics.world.paths.trajectory import Timing
from robotics.world.sensing.posture import LABORATORY

CROSSING_STREAM = 6  # of a seed's random streams: see robotics.world.radio.channel
AREA = 16.0  # m² of the field for each robot
ASPECT = 4 / 3  # ratio of the field's sides
APART = 0.9  # m: in class B starts, and ends, are at least this far from each other
_BEND = 0.7  # rad: the most by which a path begins or ends aslant to the straight line between its ends
SHORTEST, SHORTEST_SHARE = 2.0, 0.5  # of that line: m, and of the field's mean side
SPEED = 0.22  # m/s: mean speed on the longest path
_PATHS = 400  # drawn for each robot of a team, at most
_DRAWS = 64  # paths for each robot whose numbers are drawn at a time
_TOGETHER = 32  # crossings that one thread draws at a time


def crossing_ensemble(
    robots: int,
    seeds: Sequence[int],
    kind: Literal["A", "B"] = "A",
    *,
    disturbance: Disturbance = UNDISTURBED,
    factor: float | None = None,
    advance: Callable[[], None] | None = None,
    robot: RobotModel | None = None,
) -> Setting:
    """A random crossing for every seed; a seed's crossing is the same whatever the other seeds are.

    Args:
        robots: Number of robots of each crossing.
        seeds: One crossing for each.
        kind: Class of the crossings: "A", whose ends are clear of the other paths, or "B", whose ends are only apart.
        disturbance: What is wrong in every run, of which the radio belongs to the setting.
        factor: The longest a run takes, in times the longest nominal duration; by default as long as it is judged.
        advance: Called after every crossing that is drawn.
        robot: What they are, by default the EtsRo; with others all lengths grow as of :func:`growth`.
    """
    told = Periods(len(seeds), 1, advance)

    def draw(some: Sequence[int]) -> list[list[np.ndarray]]:
        generators = [np.random.default_rng([seed, CROSSING_STREAM]) for seed in some]
        drawn = random_crossings(robots, generators, kind)
        told(len(some))
        return drawn

    parts = [seeds[first : first + _TOGETHER] for first in range(0, len(seeds), _TOGETHER)]
    drawn = [one for part in share_out(draw, parts, threads_for(None)) for one in part]
    name, across = f"crossing-{robots}-{kind}", float(np.hypot(*_field(robots)))
    return drawn_ensemble(name, drawn, factor or StressOutcome.limit, across, disturbance, robot)


def growth(robot: RobotModel | None) -> float:
    """How many times as large as with the EtsRo a scenario is drawn: lengths count in the robot's turning circle."""
    return 1.0 if robot is None else robot.robot.turning_circle / standard_robot().robot.turning_circle


def drawn_ensemble(
    name: str,
    drawn: Sequence[Sequence[np.ndarray]],
    factor: float,
    across: float,
    disturbance: Disturbance,
    robot: RobotModel | None = None,
) -> Setting:
    """Runs on paths that were drawn, the longest of each run at SPEED and the others as long in time.

    A robot that can drive no faster than twice SPEED drives at half of what it can.

    Args:
        name: What the scenario is called.
        drawn: The tables of the paths: for each run one for each robot.
        factor: The longest a run takes, in times the longest nominal duration, beside what it is held up.
        across: How far apart two places on a path may be [m]: a robot that waits so far behind has not diverged.
        disturbance: What is wrong in every run, of which the radio belongs to the setting.
        robot: What they are, by default the EtsRo, for which they were drawn.
    """
    model, grown = robot or standard_robot(), growth(robot)
    if grown != 1:
        drawn = [[_grown(table, grown) for table in tables] for tables in drawn]
    paths, robots = join_tables(drawn), len(drawn[0])
    durations = paths.lengths.max(axis=1) / min(SPEED, 0.5 * model.robot.v_max, 0.5 * model.robot.wheel_speed_limit)
    starts = np.array([[t[:3, 0] for t in tables] for tables in drawn])
    shared = Member(
        start=(0.0, 0.0, 0.0),
        path=Quintic(start=(0.0, 0.0), end=(1.0, 0.0)),
        timing=Timing(duration=float(np.ceil(durations.max()))),
        robot=model.robot,
        model=model,
    )
    scenario = Scenario(
        name=name,
        robots=(shared,) * robots,
        duration=float(np.ceil(factor * durations.max() + disturbance.extra)),
        kind="team" if robots > 1 else "tracking",
        sensing=LABORATORY,
        radio=disturbance.radio,
    )
    far = scenario.divergence + grown * across
    return replace(scenario.setting, starts=starts, references=even_timing(paths, durations), divergence=far)


def _grown(table: np.ndarray, factor: float) -> np.ndarray:
    """The ``table`` of a path that is ``factor`` times as large."""
    grown = np.array(table)
    nodes = PathColumns(grown)
    nodes.x, nodes.y, nodes.curvature = factor * nodes.x, factor * nodes.y, nodes.curvature / factor
    return grown


def random_crossings(
    robots: int, generators: Sequence[np.random.Generator], kind: Literal["A", "B"] = "A"
) -> list[list[np.ndarray]]:
    """The tables of the paths of crossings, for each one for each robot.

    Args:
        robots: Number of robots.
        generators: Those from which each crossing is drawn; of each more numbers are taken than the crossing needs.
        kind: Class of the crossings, "A" or "B".
    """
    field, clear = _field(robots), kind == "A"
    draws = np.stack([rng.random((_DRAWS * robots, 6)) for rng in generators])
    chosen = _chosen(draws, robots, *field, clear)
    paths = draws[np.arange(len(draws))[:, None], chosen]
    for n in np.flatnonzero(chosen[:, 0] < 0).tolist():
        more, where = draws[n], chosen[n]
        while where[0] < 0:
            more = np.concatenate([more, generators[n].random(more.shape)])
            (where,) = _chosen(more[None], robots, *field, clear)
        paths[n] = more[where]
    tables = tabulated(_shapes(paths.reshape(-1, 6), field))
    return [tables[first : first + robots] for first in range(0, len(tables), robots)]


def _field(robots: int) -> np.ndarray:
    """The sides of the field [m]."""
    return np.asarray(np.sqrt(AREA * robots * np.array([ASPECT, 1 / ASPECT])))


def _shapes(draws: np.ndarray, field: np.ndarray) -> np.ndarray:
    """The coefficients (paths, 2, 5) of the paths that uniform numbers ``draws`` (paths, 6) make."""
    start, end = draws[:, :2] * field, draws[:, 2:4] * field
    gap = end - start
    reach = np.hypot(gap[:, 0], gap[:, 1])
    courses = np.arctan2(gap[:, 1], gap[:, 0])[:, None] + (-_BEND + 2 * _BEND * draws[:, 4:])
    tangents = reach[:, None, None] * np.stack([np.cos(courses), np.sin(courses)], axis=1)
    shapes = np.empty((len(draws), 2, 5))
    _fill_in(shapes, start, end, tangents)
    return shapes


@kernel(nogil=True)
def _fill_in(shapes, starts, ends, tangents):  # type: ignore[no-untyped-def]
    for n in range(len(shapes)):
        for axis in range(2):
            fill(shapes[n, axis], starts[n, axis], ends[n, axis], tangents[n, axis, 0], tangents[n, axis, 1])


@kernel(nogil=True)
def _chosen(draws, robots, width, height, clear):  # type: ignore[no-untyped-def]
    """Which of the paths that uniform numbers make are the first crossing (crossings, robots); -1 if there is none.

    Args:
        draws: The numbers (crossings, paths, 6).
        robots: Number of robots.
        width: Of the field [m].
        height: Of the field [m].
        clear: Whether ends are clear of the other paths, or only apart.
    """
    shape, points = np.empty((2, 5)), np.empty((robots, SAMPLES, 2))
    chosen = np.empty((len(draws), robots), dtype=np.int64)
    for c in range(len(draws)):
        if not _choose(draws[c], width, height, clear, shape, points, chosen[c]):
            chosen[c] = -1
    return chosen


@kernel
def _choose(draws, width, height, clear, shape, points, chosen):  # type: ignore[no-untyped-def]
    """Fill in which paths are the first crossing, and return whether there is one."""
    robots, number, tried = len(chosen), 0, 0
    for n in range(len(draws)):
        if _draw(draws[n], width, height, shape) and sampled_evenly(shape, points[number]):
            fits = True
            for other in range(number):
                a, b = points[number], points[other]
                fits = fits and (ends_clear(a, b) if clear else ends_apart(a, b, APART))
            chosen[number] = n
            number += fits
        tried += 1
        if number == robots and in_conflict(points):
            return True
        if number == robots or tried == _PATHS * robots:  # another team
            number = tried = 0
    return False


@kernel
def _draw(numbers, width, height, shape):  # type: ignore[no-untyped-def]
    """Fill in the coefficients (2, 5) of the path that six uniform numbers make; return whether it is long enough."""
    x, y, end_x, end_y = numbers[0] * width, numbers[1] * height, numbers[2] * width, numbers[3] * height
    dx, dy = end_x - x, end_y - y
    reach, course = math.hypot(dx, dy), math.atan2(dy, dx)
    out, into = course + (2 * numbers[4] - 1) * _BEND, course + (2 * numbers[5] - 1) * _BEND
    fill(shape[0], x, end_x, reach * math.cos(out), reach * math.cos(into))
    fill(shape[1], y, end_y, reach * math.sin(out), reach * math.sin(into))
    return reach >= SHORTEST_SHARE * math.sqrt(width * height) and reach >= SHORTEST


def stress_crossing(
    controller: Law[Any] | str,
    robots: int,
    seeds: Sequence[int],
    kind: Any = "A",
    disturbance: Disturbance = UNDISTURBED,
    begin: Begin | None = None,
    robot: str | None = None,
) -> StressOutcome:
    """Drive a random crossing for every seed, and judge what became of it.

    Args:
        controller: The law that drives the robots, or its specification, as worker processes are given it: the class
            of a law in a user's file is known only where that file has run.
        robots: Number of robots of each crossing.
        seeds: One crossing for each.
        kind: Class of the crossings, "A" or "B".
        disturbance: What is wrong in every run.
        begin: Starts a bar of a progress display, by its text and total.
        robot: What they are, as :func:`robotics.load_robot` takes it; by default the EtsRo.

    Returns:
        What became of every run.
    """
    model = None if robot is None else load_robot(robot)
    start = begin or unwatched
    drawn = start("drawing crossings", len(seeds))
    ensemble = crossing_ensemble(robots, seeds, kind, disturbance=disturbance, advance=drawn, robot=model)
    advance = start("simulating", ensemble.ticks + 1)
    faults = disturbance.faults(ensemble, seeds)
    return run_ensemble(StressOutcome, ensemble, as_law(controller), seeds, faults, advance, disturbance.extra)


def crossing_forewarnings(law: Law[Any], name: str, kind: Literal["A", "B"]) -> list[str]:
    """Sentences on what will go wrong in the random crossings of a ``kind``, whatever their seeds."""
    sentences = []
    if not law.yields:
        sentences.append(
            f"{name} takes no care of other robots: in every crossing two of them come nearer than {CONFLICT:g} m if "
            "all are on time"
        )
    room, of = (CLEAR, "from the paths of others") if kind == "A" else (APART, "from each other")
    if law.yields and law.safety_distance is not None and law.safety_distance > room:
        sentences.append(
            f"{name} keeps {law.safety_distance:g} m between robots, and starts and goals of class {kind} may be only "
            f"{room:g} m {of}: robots may wait for ever"
        )
    return sentences
