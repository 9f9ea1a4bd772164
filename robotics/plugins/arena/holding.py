"""Holding an arena of any kind: its folder, the searches of every law, the runs that are measured, and what is chosen.

Every piece of work that is done stands in the folder, whole or not at all; after a stop, also of a killed process, the
same arena in the same folder goes on from there and ends with the same bytes.
"""

from collections.abc import Callable, Mapping, Sequence
from contextlib import AbstractContextManager, nullcontext
from dataclasses import dataclass
from functools import cached_property, partial
from operator import attrgetter
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd

from fuzzy.files.claim import claimed
from fuzzy.shell.progress import Begin
from fuzzy.tuning.search import Evaluations
from robotics.plugins.arena.plan import ArenaError, ArenaPlan
from robotics.plugins.arena.work import DriveJob, Search, budgets_of
from robotics.studies.chunks import Chunk, KeptChunks, discard_chunks, run_chunk
from robotics.studies.executors import Workers, in_threads
from robotics.studies.keptcomparison import PACKAGES
from robotics.studies.pieces import run_pieces
from robotics.studies.versions import digest, versions

_PLAN = "arena.json"
Values = tuple[float, ...]  # of what moves of a law
Searched = Callable[[Path, Workers | None, Search], Evaluations]  # does a search, or what is left of it


def claimed_folder(folder: Path, about: Mapping[str, Any], *, fresh: bool, besides: Sequence[str] = ()) -> Any:
    """Hold the folder of an arena while it is held, for a ``with`` block.

    Args:
        folder: The folder.
        about: All that determines the arena's numbers.
        fresh: Whether to discard what the folder holds of an arena.
        besides: Files that are discarded, too.

    Raises ArenaError where the folder holds another arena, or another process is at work there.
    """

    def discard() -> None:
        for left in [*folder.glob("searches/*/*/*"), *(folder / name for name in besides)]:
            if left.is_file():
                left.unlink()
        for runs in folder.glob("runs/*"):
            discard_chunks(runs)

    return claimed(folder, _PLAN, about, discard, kind="arena", fault=ArenaError, fresh=fresh)


@dataclass(frozen=True)
class Candidates:
    """What is driven of a law to choose among: the law as published, and what each search held best at each budget."""

    searches: Mapping[Search, Evaluations]
    budgets: Sequence[int]

    @cached_property
    def _best(self) -> list[list[Values]]:
        """The best values of each search at each budget."""
        return [[_values(e, e.best_within(n)) for n in self.budgets] for e in self.searches.values()]

    @cached_property
    def values(self) -> tuple[Values | None, ...]:
        """The candidates, none of them twice; None: the law as published."""
        starts = {_values(evaluated, 0) for evaluated in self.searches.values()}
        return None, *sorted({values for row in self._best for values in row} - starts)

    @cached_property
    def looked_at(self) -> np.ndarray:
        """The places of the candidates that were best (searches, budgets) int; 0 where nothing was better."""
        place = {values: n for n, values in enumerate(self.values)}
        return np.array([[place.get(values, 0) for values in row] for row in self._best], dtype=int)

    @cached_property
    def ends(self) -> list[int]:
        """The places of the law as published and of the ends of the searches, among which is chosen."""
        return sorted({0, *(int(row[-1]) for row in self.looked_at)})

    @cached_property
    def parameters(self) -> tuple[str, ...]:
        """The names of what moves."""
        return next((tuple(p.name for p in evaluated.parameters) for evaluated in self.searches.values()), ())


def _values(evaluated: Evaluations, place: int) -> Values:
    return tuple(map(float, evaluated.values[place]))


@dataclass(frozen=True)
class Holding:
    """An arena that is being held."""

    arena: ArenaPlan
    about: Mapping[str, Any]  # all that determines its numbers
    folder: Path
    workers: Workers
    begin: Begin
    seconds: Mapping[str, float]  # s that a run takes, by law: the longest work is done first

    def searches(self, one: Searched) -> dict[Search, Evaluations]:
        """Do every search of every law, the longest first."""
        arena, workers = self.arena, self.workers
        todo = [
            Search(law, engine, repeat)
            for law in arena.laws
            if law not in arena.untuned
            for engine in arena.engines
            for repeat in range(arena.repeats)
        ]
        # Workers that do not see the folder do a generation at a time, which this process writes down
        one_of = partial(one, self.folder, workers if workers.apart else None)
        those: AbstractContextManager[Workers] = in_threads(len(todo)) if workers.apart else nullcontext(workers)
        with those as crew:
            found = dict(
                run_pieces(
                    one_of,
                    sorted(todo, key=lambda s: -self.seconds[s.law] * arena.budget(s.law)),
                    crew,
                    called=attrgetter("law"),
                    kept=ArenaError,
                    advance=self.begin(f"tuning: {len(todo)} searches", len(todo)),
                )
            )
        return {search: found[search] for search in todo}

    def candidates(self, searches: Mapping[Search, Evaluations]) -> dict[str, Candidates]:
        """What is chosen among, by law."""
        return {
            law: Candidates({s: e for s, e in searches.items() if s.law == law}, budgets_of(self.arena, law))
            for law in self.arena.laws
        }

    def drives(
        self, what: str, todo: Sequence[DriveJob], one: Callable[[DriveJob], pd.DataFrame]
    ) -> dict[DriveJob, pd.DataFrame]:
        """Do drives, the longest first, or read what the folder has of them."""
        kept = KeptChunks(
            folder=self.folder / "runs" / what,
            kind="arena",
            key=digest([self.about, *map(repr, todo)]),
            count=len(todo),
            chunk=lambda number: Chunk(number, (todo[number - 1],)),
            one=partial(run_chunk, one, attrgetter("law"), versions(*PACKAGES), ArenaError),
            place=attrgetter("law"),
            fault=ArenaError,
            workers=self.workers,
        )
        left = sorted(kept.missing(), key=lambda n: -self.seconds[todo[n - 1].law] * todo[n - 1].count)
        kept.compute(left, self.begin(f"{what}: {sum(d.count for d in todo)} runs", max(len(left), 1)))
        return {drive: table.to_pandas() for drive, table in zip(todo, kept.tables(), strict=True)}
