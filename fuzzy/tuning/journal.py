"""The folder of a search: what it is, and what it has found, generation by generation.

``search.json`` says what is searched for, and ``history.csv`` has a row an evaluation; both appear whole or not at
all. After a stop, also of a killed process, the same search in the same folder goes on from there.
"""

import csv
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import ExitStack, contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from fuzzy.files.claim import claimed
from fuzzy.files.table import write_frame
from fuzzy.tuning.parameter import SearchParameter, TuningError
from fuzzy.tuning.search import Cost, Evaluations, search

ABOUT, HISTORY = "search.json", "history.csv"


@dataclass(frozen=True)
class Journal:
    """The folder of one search, which no other process may have; use :func:`open_journal`."""

    folder: Path

    def known(self, names: tuple[str, ...]) -> np.ndarray | None:
        """The objectives (evaluations, objectives) called ``names`` that the folder has; None: it has none.

        A single one stands in the column of the cost, whatever it is called. Raises TuningError where its history is
        not one of this search.
        """
        path, names = self.folder / HISTORY, names if len(names) > 1 else ("cost",)
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
    with claimed(
        folder,
        ABOUT,
        about,
        lambda: (folder / HISTORY).unlink(missing_ok=True),
        kind="search",
        fault=TuningError,
        elsewhere="folder",
        fresh=fresh,
    ):
        yield Journal(folder)


class SearchInterrupt(KeyboardInterrupt):
    """Ctrl-C while something was searched for: :attr:`found` is all that was evaluated until then."""

    def __init__(self, found: Evaluations) -> None:
        super().__init__(f"after {len(found)} evaluations")
        self.found = found


def resumable_search(
    cost: Cost,
    parameters: Sequence[SearchParameter],
    *,
    about: Mapping[str, Any],
    folder: Path | None,
    fresh: bool,
    evaluations: int,
    seed: int,
    engine: str,
    names: tuple[str, ...] = ("cost",),
    progress: Callable[[Evaluations], bool | None] | None = None,
) -> Evaluations:
    """Search as :func:`fuzzy.tuning.search.search` does, written down in a folder after each generation.

    Args:
        cost: As for a search, and so ``parameters``, ``evaluations``, ``seed``, ``engine`` and ``names``.
        parameters: What may change.
        about: What determines the result.
        folder: The folder, where a search that was stopped goes on; None: nothing is written down.
        fresh: Whether to discard what the folder holds of a search.
        evaluations: The budget.
        seed: That of the engine.
        engine: What searches.
        names: What the objectives are called.
        progress: Called after each generation with all evaluations so far; True ends the search.

    Raises TuningError as :func:`open_journal` and the search do, and SearchInterrupt after Ctrl-C, if there is anything
    to hand over.
    """
    so_far: list[Evaluations] = []
    with ExitStack() as stack:
        journal = stack.enter_context(open_journal(folder, about, fresh)) if folder is not None else None

        def after(found: Evaluations) -> bool | None:
            so_far[:] = [found]
            if journal is not None:
                journal.write(found)
            return progress(found) if progress is not None else None

        known = journal.known(names) if journal is not None else None
        try:
            return search(
                cost,
                parameters,
                evaluations=evaluations,
                seed=seed,
                engine=engine,
                names=names,
                known=known,
                after=after,
            )
        except KeyboardInterrupt:
            if not so_far:
                raise
            raise SearchInterrupt(so_far[0]) from None
