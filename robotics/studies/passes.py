"""Passes of runs, done by whoever there is, into one table with a row a run and robot; a folder keeps what is done.

Work that is stopped, also by SIGKILL, goes on where it was, and ends with the same bytes.
"""

from collections.abc import Callable, Mapping, Sequence
from contextlib import AbstractContextManager, ExitStack, nullcontext
from dataclasses import replace
from functools import partial
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any, Generic, NamedTuple

import pandas as pd

from fuzzy.errors import InputError
from fuzzy.files.claim import claimed
from fuzzy.files.table import write_frame
from fuzzy.shell.progress import Begin, unwatched
from robotics.studies.chunks import Chunk, KeptChunks, Pass, discard_chunks, run_chunk
from robotics.studies.executors import WorkerError, Workers
from robotics.studies.keptcomparison import PACKAGES, PIECES_FOLDER
from robotics.studies.versions import digest, versions

RESULTS = "results.csv"


class PassesError(InputError):
    """A folder that holds other work."""


class Done(NamedTuple, Generic[Pass]):
    """What was done of some passes, and what kept the others from it."""

    table: pd.DataFrame | None  # of the passes that are done, in their order; None: there is none
    missing: tuple[Pass, ...] = ()
    interrupted: bool = False  # by Ctrl-C
    reason: str = ""  # why passes are missing that were not interrupted


def run_passes(
    passes: Sequence[Pass],
    one: Callable[[Pass], pd.DataFrame],
    workers: Callable[[int], AbstractContextManager[Workers | None]] = lambda passes: nullcontext(),
    *,
    kind: str,
    about: Mapping[str, Any],
    place: Callable[[Pass], str],
    folder: Path | None = None,
    fresh: bool = False,
    begin: Begin = unwatched,
    resumed: Callable[[int, int], None] = lambda done, passes: None,
) -> Done[Pass]:
    """Do what is left of some passes; Ctrl-C and processes that die lose none that is done.

    Args:
        passes: What is computed at a time.
        one: Simulates and measures a pass, into a row a run and robot.
        workers: Starts who does so many passes, by default this process.
        kind: What messages call such work: "stress test".
        about: All that determines the table, as JSON can hold it.
        place: What messages call a pass.
        folder: What is done is kept here, and in the end the table as results.csv. Default: nothing is kept.
        fresh: Whether to discard what the folder holds of such work.
        begin: Starts a bar of a progress display, by its text and total.
        resumed: Called with how many passes are there already, and of how many.

    Raises PassesError where the folder holds other work, WorkerError where workers cannot be reached, and what ``one``
    raises.
    """
    reasons, interrupted, about = list[WorkerError](), False, {**about, "versions": versions(*PACKAGES)}
    with ExitStack() as stack:
        there = folder or Path(stack.enter_context(TemporaryDirectory()))

        def discard() -> None:
            (there / RESULTS).unlink(missing_ok=True)
            discard_chunks(there / PIECES_FOLDER)

        file = kind.replace(" ", "-") + ".json"
        stack.enter_context(claimed(there, file, about, discard, kind=kind, fault=PassesError, fresh=fresh))
        pieces = KeptChunks(
            there / PIECES_FOLDER,
            kind,
            digest(about),
            len(passes),
            chunk=lambda number: Chunk(number, (passes[number - 1],)),
            one=partial(run_chunk, one, place, about["versions"], None),
            place=place,
        )
        if len(todo := pieces.missing()) < len(passes):
            resumed(len(passes) - len(todo), len(passes))
        try:
            with workers(len(todo)) as crew:
                replace(pieces, workers=crew).compute(todo, begin("pieces", len(todo)), reasons.append)
        except KeyboardInterrupt:
            interrupted = True
        found = [pieces.there(number) for number in range(1, len(passes) + 1)]
        tables = [table.to_pandas() for table in found if table is not None]
        whole = pd.concat(tables, ignore_index=True) if tables else None
        if folder is not None and len(tables) == len(passes):
            write_frame(whole, folder / RESULTS)
    missing = tuple(part for part, table in zip(passes, found, strict=True) if table is None)
    return Done(whole, missing, interrupted, str(reasons[-1]) if reasons else "")
