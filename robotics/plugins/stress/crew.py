"""Thousands of random runs, in chunks that several threads or processes may share."""

from collections.abc import Callable, Iterable, Sequence
from contextlib import AbstractContextManager, nullcontext
from functools import partial
from itertools import pairwise
from typing import Generic, NamedTuple, TypeVar

from fuzzy.compiled.threads import processors
from fuzzy.shell.progress import Begin
from robotics.plugins.stress.outcome import StressOutcome, joined
from robotics.studies.executors import WorkerError, Workers, in_threads, processes
from robotics.studies.pieces import run_pieces

ROBOTS_A_PASS = 600  # robots that one pass simulates at most
_MOST = 20_000  # pairs of robots that one pass simulates at most
FEWEST = 60  # robots for which a process of its own pays
_PRELOAD = (
    "robotics.plugins.stress.crossing_runs",
    "robotics.plugins.stress.obstaclecourse",
    "robotics.laws.catalogue",
)
Outcome = TypeVar("Outcome", bound=StressOutcome)


class Stressed(NamedTuple, Generic[Outcome]):
    """The outcome of all runs that were done, and what kept the others from it."""

    outcome: Outcome | None  # None: not one chunk was done
    missing: tuple[tuple[int, int], ...] = ()  # the first and the last seed of each stretch that was not done
    interrupted: bool = False
    reason: str = ""  # why chunks are missing that were not interrupted


def in_chunks(
    stress: Callable[..., Outcome],
    robots: int,
    seeds: Sequence[int],
    *,
    jobs: int | None = None,
    begin: Begin,
    threads: bool = False,
) -> Stressed[Outcome]:
    """Stress a controller with random runs, in chunks; Ctrl-C and processes that die lose no chunk that is done.

    Args:
        stress: Makes the outcome of some of ``seeds``, given as its one positional argument; a progress display is
            given as ``begin``. A :func:`functools.partial` of
            :func:`robotics.plugins.stress.crossing_runs.stress_crossing` or
            :func:`robotics.plugins.stress.obstaclecourse.stress_obstacles`.
        robots: Number of robots of each run.
        seeds: One run for each.
        jobs: Number of processes, by default one for each core; it does not change the outcome.
        begin: Starts a bar of a progress display, by its text and total.
        threads: Whether they are threads of this process instead: quicker where compiled code drives the runs.
    """
    chunks = _chunks(seeds, robots, jobs or processors())
    count = min(len(chunks), jobs or processors())
    done: dict[int, Outcome] = {}
    interrupted, reasons = False, list[WorkerError]()
    try:
        with _workers(count, threads) as workers:
            for chunk, outcome in run_pieces(
                partial(stress, begin=begin) if count == 1 else stress,
                chunks,
                workers,
                lost=reasons.append,
                advance=begin("chunks of runs", len(chunks)) if count > 1 else None,
            ):
                done[chunk[0]] = outcome
    except KeyboardInterrupt:
        interrupted = True
    missing = _stretches(chunk for chunk in chunks if chunk[0] not in done)
    parts = [done[first] for first in sorted(done)]
    reason = str(reasons[-1]) if reasons else ""
    return Stressed(joined(parts) if parts else None, missing, interrupted, reason)


def _workers(count: int, threads: bool) -> "AbstractContextManager[Workers | None]":
    if count == 1:
        return nullcontext()
    return in_threads(count) if threads else processes(count, _PRELOAD)


def _stretches(chunks: Iterable[Sequence[int]]) -> tuple[tuple[int, int], ...]:
    """The first and the last seed of every stretch of chunks that follow each other."""
    found: list[tuple[int, int]] = []
    for chunk in chunks:
        first = found.pop()[0] if found and found[-1][1] + 1 == chunk[0] else chunk[0]
        found.append((first, chunk[-1]))
    return tuple(found)


def _chunks(seeds: Sequence[int], robots: int, workers: int) -> list[Sequence[int]]:
    """The seeds in chunks of the same size, to one; a multiple of the number of workers, so that none is idle."""
    total = len(seeds)
    size = max(1, min(ROBOTS_A_PASS // robots, _MOST // robots**2))
    count = -(-total // size)
    if count > 1:
        count = min(-(-count // workers) * workers, total)
    count = max(count, min(workers, total * robots // FEWEST))
    bounds = [total * k // count for k in range(count + 1)]
    return [seeds[a:b] for a, b in pairwise(bounds)]
