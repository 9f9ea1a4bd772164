"""Thousands of random runs, in chunks that several processes may share."""

import os
from collections.abc import Callable, Sequence
from itertools import pairwise
from typing import TypeVar

from fuzzy.shell.progress import Begin
from robotics.experiments.executors import processes
from robotics.experiments.stress.outcome import StressOutcome, joined

CHUNK, MOST = 600, 20_000  # robots, and pairs of robots, that one pass simulates at most
FEWEST = 60  # robots for which a process of its own pays
_PRELOAD = (
    "robotics.experiments.stress.crossing_runs",
    "robotics.experiments.stress.obstaclecourse",
    "robotics.laws.catalogue",
)
Outcome = TypeVar("Outcome", bound=StressOutcome)


def in_chunks(
    stress: Callable[..., Outcome], robots: int, seeds: Sequence[int], *, jobs: int | None = None, begin: Begin
) -> Outcome:
    """Stress a controller with random runs, in chunks.

    Args:
        stress: Makes the outcome of some of ``seeds``, given as its one positional argument; a progress display is
            given as ``begin``. A :func:`functools.partial` of
            :func:`robotics.experiments.stress.crossing_runs.stress_crossing` or
            :func:`robotics.experiments.stress.obstaclecourse.stress_obstacles`.
        robots: Number of robots of each run.
        seeds: One run for each.
        jobs: Number of processes, by default one for each core; it does not change the outcome.
        begin: Starts a bar of a progress display, by its text and total.
    """
    chunks = _chunks(seeds, robots, jobs or _cores())
    workers = min(len(chunks), jobs or _cores())
    if workers == 1:
        return joined([stress(chunk, begin=begin) for chunk in chunks])
    advance = begin("chunks of runs", len(chunks))
    with processes(workers, _PRELOAD) as crew:
        work = [crew.executor.submit(stress, chunk) for chunk in chunks]
        parts = []
        for future in work:
            parts.append(future.result())
            advance()
    return joined(parts)


def _chunks(seeds: Sequence[int], robots: int, workers: int) -> list[Sequence[int]]:
    """The seeds in chunks of the same size, to one; a multiple of the number of workers, so that none is idle."""
    total = len(seeds)
    size = max(1, min(CHUNK // robots, MOST // robots**2))
    count = -(-total // size)
    if count > 1:
        count = min(-(-count // workers) * workers, total)
    count = max(count, min(workers, total * robots // FEWEST))
    bounds = [total * k // count for k in range(count + 1)]
    return [seeds[a:b] for a, b in pairwise(bounds)]


def _cores() -> int:
    """How many cores this process may use."""
    return len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1
