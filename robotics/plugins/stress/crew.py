"""Thousands of random runs, in pieces that threads, processes or a Dask cluster share."""

from collections.abc import Callable, Mapping, Sequence
from functools import partial
from itertools import pairwise
from typing import Any

import pandas as pd

from fuzzy.shell.progress import Begin, unwatched
from robotics.commands.crew import Crew
from robotics.plugins.stress.outcome import StressOutcome
from robotics.studies.passes import Done, run_passes

ROBOTS_A_PASS = 600  # robots that one pass simulates at most
_MOST = 20_000  # pairs of robots that one pass simulates at most
FEWEST = 60  # robots for which a process of its own pays
_SHARED = 16  # workers for which what is kept is cut, whoever does it
_PRELOAD = (
    "pyarrow",
    "robotics.plugins.stress.crossings",
    "robotics.plugins.stress.obstaclecourse",
    "robotics.laws.catalogue",
)


def in_pieces(
    stress: Callable[..., StressOutcome],
    robots: int,
    seeds: Sequence[int],
    crew: Crew | None = None,
    *,
    begin: Begin = unwatched,
    threads: bool = False,
    about: Mapping[str, Any] | None = None,
    resumed: Callable[[int, int], None] = lambda done, pieces: None,
) -> Done[Sequence[int]]:
    """Stress a controller with random runs, in pieces; Ctrl-C and processes that die lose no piece that is done.

    Args:
        stress: Makes the outcome of some of ``seeds``, given as its one positional argument; a progress display is
            given as ``begin``. A :func:`functools.partial` of
            :func:`robotics.plugins.stress.crossings.stress_crossing` or
            :func:`robotics.plugins.stress.obstaclecourse.stress_obstacles`.
        robots: Number of robots of each run.
        seeds: One run for each.
        crew: Who does it, by default a process for each core; in its folder results.csv has a row a run and robot.
        begin: Starts a bar of a progress display, by its text and total.
        threads: Whether processes are threads of this one instead: quicker where compiled code drives the runs.
        about: All that determines the outcome, as JSON can hold it.
        resumed: Called with how many pieces are there already, and of how many.

    Returns:
        The table of an outcome, and which parts of the seeds are missing.

    Raises PassesError where the folder holds another stress test; WorkerError where no cluster answers.
    """
    crew = crew or Crew()
    parts = _parts(seeds, robots, _SHARED if crew.out or crew.dask else crew.count)
    alone = len(parts) == 1 and crew.dask is None  # its own bars tell more
    return run_passes(
        parts,
        partial(_table, partial(stress, begin=begin) if alone else stress),
        partial(crew.at_work, preload=_PRELOAD, threads=threads),
        kind="stress test",
        about=about or {},
        place=_called,
        folder=crew.out,
        fresh=crew.fresh,
        begin=unwatched if alone else begin,
        resumed=resumed,
    )


def _table(stress: Callable[[Sequence[int]], StressOutcome], seeds: Sequence[int]) -> pd.DataFrame:
    return stress(seeds).table


def _called(seeds: Sequence[int]) -> str:
    return f"seeds {seeds[0]} to {seeds[-1]}"


def _parts(seeds: Sequence[int], robots: int, shared: int) -> list[Sequence[int]]:
    """The seeds in parts of the same size, to one; a multiple of the number of workers, so that none is idle."""
    total = len(seeds)
    size = max(1, min(ROBOTS_A_PASS // robots, _MOST // robots**2))
    count = -(-total // size)
    if count > 1:
        count = min(-(-count // shared) * shared, total)
    count = max(count, min(shared, total * robots // FEWEST))
    bounds = [total * k // count for k in range(count + 1)]
    return [seeds[a:b] for a, b in pairwise(bounds)]
