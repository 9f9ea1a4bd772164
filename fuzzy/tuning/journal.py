"""The folder of a search: what it is, and what it has found, generation by generation.

``search.json`` says what is searched for, and ``history.csv`` has a row an evaluation; both appear whole or not at
all. After a stop, also of a killed process, the same search in the same folder goes on from there.
"""

import csv
from collections.abc import Callable, Mapping, Sequence
from contextlib import AbstractContextManager, nullcontext
from pathlib import Path
from typing import Any

import numpy as np

from fuzzy.files.claim import claimed
from fuzzy.files.table import write_frame
from fuzzy.tuning.parameter import SearchParameter, TuningError
from fuzzy.tuning.search import Cost, Evaluations, search

ABOUT, HISTORY = "search.json", "history.csv"


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

    Raises TuningError as the search does, where the folder holds another search, or a history that is not one of it,
    and where another process is at work there; and SearchInterrupt after Ctrl-C, if there is anything to hand over.
    """
    so_far: list[Evaluations] = []

    def after(found: Evaluations) -> bool | None:
        so_far[:] = [found]
        if folder is not None:
            write_frame(found.table(), folder / HISTORY)
        return progress(found) if progress is not None else None

    with _claimed(folder, about, fresh) if folder is not None else nullcontext():
        try:
            return search(
                cost,
                parameters,
                evaluations=evaluations,
                seed=seed,
                engine=engine,
                names=names,
                known=_known(folder / HISTORY, names) if folder is not None else None,
                after=after,
            )
        except KeyboardInterrupt:
            if not so_far:
                raise
            raise SearchInterrupt(so_far[0]) from None


def _claimed(folder: Path, about: Mapping[str, Any], fresh: bool) -> AbstractContextManager[None]:
    def discard() -> None:
        (folder / HISTORY).unlink(missing_ok=True)

    return claimed(folder, ABOUT, about, discard, kind="search", fault=TuningError, elsewhere="folder", fresh=fresh)


def _known(path: Path, names: tuple[str, ...]) -> np.ndarray | None:
    """The objectives (evaluations, objectives) called ``names`` that a history has; None: there is none.

    A single one stands in the column of the cost, whatever it is called. Raises TuningError where this is no history of
    this search.
    """
    names = names if len(names) > 1 else ("cost",)
    if not path.exists():
        return None
    try:
        with path.open(encoding="utf-8", newline="") as file:
            return np.array([[float(row[name]) for name in names] for row in csv.DictReader(file)])
    except (OSError, ValueError, KeyError, TypeError) as error:
        raise TuningError(f"{path}: this is no history of this search: {error}; --fresh starts over") from None
