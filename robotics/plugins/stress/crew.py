"""Who does the work of a command in pieces, and where what is done is kept: options that such commands share."""

from collections.abc import Sequence
from contextlib import AbstractContextManager, nullcontext
from dataclasses import dataclass
from pathlib import Path
from typing import Annotated

from fuzzy.compiled.threads import processors
from fuzzy.files.atomic import check_folder
from fuzzy.shell.options import option
from robotics.commands.shared import Dask
from robotics.commands.shared import Workers as Processes
from robotics.studies.executors import Workers, check_workers, dask, in_threads, processes


@dataclass(frozen=True, kw_only=True)
class Crew:
    """Who does some work, and where what is done is kept. Raises an InputError for a place where nothing can be."""

    workers: Processes = None
    dask: Dask = None
    out: Annotated[
        Path | None,
        option("Folder that keeps what is done, and results.csv. Default: nothing is kept", "-o", "--out", "FOLDER"),
    ] = None
    fresh: Annotated[bool, option("Discard what FOLDER holds of earlier work.")] = False

    def __post_init__(self) -> None:
        check_workers(self.workers, self.dask)
        if self.out is not None:
            check_folder(self.out)

    @property
    def count(self) -> int:
        """The number of workers of this machine."""
        return self.workers or processors()

    def at_work(
        self, pieces: int, preload: Sequence[str] = (), *, threads: bool = False
    ) -> "AbstractContextManager[Workers | None]":
        """Start who does so many pieces, for a ``with`` block; None: this process.

        Args:
            pieces: How many there are.
            preload: The modules that processes import.
            threads: Whether processes are threads of this one instead.
        """
        count = min(pieces, self.count)
        if self.dask is not None and pieces:
            return dask(self.dask)
        if count <= 1:
            return nullcontext()
        return in_threads(count) if threads else processes(count, preload)
