"""The folder of a search: what it is, and what it has found, generation by generation.

``search.json`` says what is searched for, and ``history.csv`` has a row an evaluation; both appear whole or not at
all. After a stop, also of a killed process, the same search in the same folder goes on from there.
"""

import csv
import json
import sys
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import numpy as np

from fuzzy.files.atomic import replacing
from fuzzy.files.table import write_frame
from fuzzy.tuning.parameter import TuningError
from fuzzy.tuning.search import Evaluations

ABOUT, HISTORY = "search.json", "history.csv"


class Journal:
    """The folder of one search, which no other process may have; use :func:`open_journal`."""

    def __init__(self, folder: Path, about: Mapping[str, Any]) -> None:
        self.folder, self.about = folder, about

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
    with _alone(folder):
        path, about = folder / ABOUT, json.loads(json.dumps(about))
        if fresh:
            path.unlink(missing_ok=True)
            (folder / HISTORY).unlink(missing_ok=True)
        if path.exists():
            try:
                there = json.loads(path.read_text(encoding="utf-8"))
            except (OSError, ValueError) as error:
                raise TuningError(f"{path}: this is no search: {error}; --fresh starts over") from None
            if there != about:
                raise TuningError(
                    f"{folder} holds another search: {_difference(there, about)}; give another folder, or --fresh to "
                    "throw it away and start over"
                )
        else:
            (folder / HISTORY).unlink(missing_ok=True)
            with replacing(path) as temporary:
                temporary.write_text(json.dumps(about, indent=2, ensure_ascii=False) + "\n", encoding="utf-8")
        yield Journal(folder, about)


def _difference(there: Any, about: Mapping[str, Any]) -> str:
    there = there if isinstance(there, dict) else {}
    changed = [key for key in {**about, **there} if there.get(key) != about.get(key)]
    return f"{', '.join(changed)} changed" if changed else "it changed"


@contextmanager
def _alone(folder: Path) -> Iterator[None]:
    """Hold the folder's lock, which the system gives back however the process ends."""
    if sys.platform == "win32":
        yield
        return
    import fcntl

    with (folder / ".lock").open("w") as file:
        try:
            fcntl.flock(file, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except OSError:
            raise TuningError(
                f"{folder}: another search is at work here; wait for it, or give another folder"
            ) from None
        yield
