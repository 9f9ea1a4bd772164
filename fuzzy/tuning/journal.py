"""The folder of a search: what it is, and what it has found, generation by generation.

``search.json`` says what is searched for, and ``history.csv`` has a row an evaluation; both appear whole or not at
all. After a stop, also of a killed process, the same search in the same folder goes on from there.
"""

import csv
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import numpy as np

from fuzzy.files.claim import alone, claim
from fuzzy.files.table import write_frame
from fuzzy.tuning.parameter import TuningError
from fuzzy.tuning.search import Evaluations

ABOUT, HISTORY = "search.json", "history.csv"


class Journal:
    """The folder of one search, which no other process may have; use :func:`open_journal`."""

    def __init__(self, folder: Path) -> None:
        self.folder = folder

    def known(self, names: tuple[str, ...]) -> np.ndarray | None:
        """The objectives (evaluations, objectives) called ``names`` that the folder has; None: it has none.

        Raises TuningError where its history is not one of this search.
        """
        path = self.folder / HISTORY
        if not path.exists():
            return None
        try:
            with path.open(encoding="utf-8", newline="") as file:
                return np.array([[float(row[name]) for name in names] for row in csv.DictReader(file)])
        except (OSError, ValueError, KeyError, TypeError) as error:
            raise TuningError(f"{path}: this is no history of this search: {error}; --fresh starts over") from None

    def write(self, found: Evaluations) -> None:
        """Write the history."""
        write_frame(found.table(), self.folder / HISTORY)


@contextmanager
def open_journal(folder: Path, about: Mapping[str, Any], fresh: bool = False) -> Iterator[Journal]:
    """Open the folder of a search, which is made where it is missing.

    Args:
        folder: The folder.
        about: What determines the result, as JSON can hold it.
        fresh: Whether to discard what the folder holds of a search.

    Raises TuningError where the folder holds another search, or another process is at work there.
    """
    folder.mkdir(parents=True, exist_ok=True)
    busy = TuningError(f"{folder}: another search is at work here; wait for it, or give another folder")
    with alone(folder, busy):
        claim(
            folder / ABOUT,
            about,
            lambda: (folder / HISTORY).unlink(missing_ok=True),
            kind="search",
            elsewhere="folder",
            fault=TuningError,
            fresh=fresh,
        )
        yield Journal(folder)
