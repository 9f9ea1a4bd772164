"""Thousands of random runs, in pieces that threads, processes or a Dask cluster share, into one table.

A folder keeps what is done: work that is stopped, also by SIGKILL, goes on where it was, and ends with the same bytes.
"""

from collections.abc import Callable, Mapping, Sequence
from contextlib import ExitStack
from dataclasses import replace
from functools import partial
from itertools import pairwise
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any, NamedTuple

import pandas as pd

from fuzzy.errors import InputError
from fuzzy.files.claim import claimed
from fuzzy.files.table import write_frame
from fuzzy.shell.progress import Begin, unwatched
from robotics.plugins.stress.crew import Crew
from robotics.plugins.stress.outcome import StressOutcome
from robotics.studies.chunks import Chunk, KeptChunks, discard_chunks, run_chunk
from robotics.studies.executors import WorkerError
from robotics.studies.keptcomparison import PACKAGES, PIECES_FOLDER
from robotics.studies.versions import digest, versions

ROBOTS_A_PASS = 600  # robots that one pass simulates at most
_MOST = 20_000  # pairs of robots that one pass simulates at most
FEWEST = 60  # robots for which a process of its own pays
_SHARED = 16  # workers for which what is kept is cut, whoever does it
_KIND = "stress test"
_PRELOAD = (
    "pyarrow",
    "robotics.plugins.stress.crossings",
    "robotics.plugins.stress.obstaclecourse",
    "robotics.laws.catalogue",
)
RESULTS = "results.csv"


class StressError(InputError):
    """A folder that holds another stress test."""


class Done(NamedTuple):
    """What was done of some runs, and what kept the others from it."""

    table: pd.DataFrame | None  # of the parts that are done, in their order; None: there is none
    missing: tuple[Sequence[int], ...] = ()  # seeds
    interrupted: bool = False  # by Ctrl-C
    reason: str = ""  # why runs are missing that were not interrupted


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
) -> Done:
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

    Raises StressError where the folder holds another stress test; WorkerError where no cluster answers; and what
    ``stress`` raises.
    """
    crew, reasons, interrupted = crew or Crew(), list[WorkerError](), False
    parts = _parts(seeds, robots, _SHARED if crew.out or crew.dask else crew.count)
    alone = len(parts) == 1 and crew.dask is None  # its own bars tell more
    one = partial(_table, partial(stress, begin=begin) if alone else stress)
    about = {**(about or {}), "versions": versions(*PACKAGES)}
    with ExitStack() as stack:
        folder = crew.out or Path(stack.enter_context(TemporaryDirectory()))

        def discard() -> None:
            (folder / RESULTS).unlink(missing_ok=True)
            discard_chunks(folder / PIECES_FOLDER)

        options: dict[str, Any] = {"kind": _KIND, "fault": StressError, "fresh": crew.fresh}
        stack.enter_context(claimed(folder, "stress-test.json", about, discard, **options))
        pieces = KeptChunks(
            folder / PIECES_FOLDER,
            _KIND,
            digest(about),
            len(parts),
            chunk=lambda number: Chunk(number, (parts[number - 1],)),
            one=partial(run_chunk, one, _called, about["versions"], None),
            place=_called,
        )
        if len(todo := pieces.missing()) < len(parts):
            resumed(len(parts) - len(todo), len(parts))
        try:
            with crew.at_work(len(todo), _PRELOAD, threads=threads) as workers:
                bar = (unwatched if alone else begin)("pieces", len(todo))
                replace(pieces, workers=workers).compute(todo, bar, reasons.append)
        except KeyboardInterrupt:
            interrupted = True
        found = [pieces.there(number) for number in range(1, len(parts) + 1)]
        tables = [table.to_pandas() for table in found if table is not None]
        whole = pd.concat(tables, ignore_index=True) if tables else None
        if crew.out is not None and len(tables) == len(parts):
            write_frame(whole, folder / RESULTS)
    missing = tuple(part for part, table in zip(parts, found, strict=True) if table is None)
    return Done(whole, missing, interrupted, str(reasons[-1]) if reasons else "")


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
