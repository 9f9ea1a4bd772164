"""Holding an arena: every law tuned with the same budget, the best chosen on other runs, and tested on others again.

Every piece of work that is done stands in the folder, whole or not at all; after a stop, also of a killed process, the
same arena in the same folder goes on from there and ends with the same bytes.
"""

import json
from collections.abc import Callable, Mapping, Sequence
from contextlib import nullcontext
from dataclasses import asdict, dataclass, replace
from functools import cached_property, partial
from operator import attrgetter
from pathlib import Path
from typing import Any, Literal

import numpy as np
import pandas as pd

from fuzzy.errors import InputError
from fuzzy.files.atomic import write_json
from fuzzy.files.claim import claimed
from fuzzy.shell.progress import Begin, unwatched
from fuzzy.tuning.search import Evaluations
from fuzzy.words import counted
from robotics.plugins.arena.changes import CHANGES
from robotics.plugins.arena.computing import Timed, machine, timed
from robotics.plugins.arena.description import Arena, about
from robotics.plugins.arena.families import ArenaError
from robotics.plugins.arena.outcome import ArenaEntry, Outcome
from robotics.plugins.arena.work import DriveJob, Search, budgets_of, driven, plain, searched
from robotics.studies.chunks import Chunk, KeptChunks, discard_chunks, run_chunk
from robotics.studies.executors import Workers, in_threads
from robotics.studies.keptcomparison import PACKAGES
from robotics.studies.pieces import kept_piece, run_pieces
from robotics.studies.versions import digest, versions

_PLAN, _TIMES = "arena.json", "computing.json"
PUBLISHED, TUNED = "published", "tuned"
_UNKNOWN = Timed(float("nan"), 1.0)
Values = tuple[float, ...]  # of what moves of a law


def drive_arena(
    arena: Arena,
    folder: Path,
    workers: Workers | None = None,
    *,
    fresh: bool = False,
    clocked: bool = True,
    begin: Begin = unwatched,
    announce: Callable[[str], None] = lambda text: None,
) -> Outcome:
    """Run an arena, or finish one that was interrupted.

    Args:
        arena: The arena.
        folder: The folder of the results.
        workers: Who does the work, by default this process.
        fresh: Whether to discard what the folder holds of an arena.
        clocked: Whether computing times are measured first; otherwise there are none, and nothing is foretold.
        begin: Starts a bar of a progress display, by its text and total.
        announce: Called with sentences before the work begins: which laws are not tuned, and how long it will take.

    Raises ArenaError where the folder holds another arena, another process is at work there, or a law fails.
    """
    workers = workers or Workers()

    def discard() -> None:
        for left in [*folder.glob("searches/*/*/*"), folder / _TIMES]:
            if left.is_file():
                left.unlink()
        for runs in folder.glob("runs/*"):
            discard_chunks(runs)

    plan = {**about(arena), "versions": versions()}
    with claimed(folder, _PLAN, plan, discard, kind="arena", fault=ArenaError, fresh=fresh):
        times = _times(arena, folder, begin) if clocked else dict.fromkeys(arena.laws, _UNKNOWN)
        for law in arena.untuned:
            announce(f"{law}: nothing of it moves, of {', '.join(arena.move)}; it takes part as published")
        if clocked:
            announce(_estimate(arena, times, workers))
        outcome = _ArenaRun(arena, plan, folder, workers, times, begin).outcome()
        under = {}
        for conditions in arena.under:
            announce(f"{conditions.title}: every law is tuned anew")
            again, place = replace(arena, conditions=conditions, under=()), folder / "under" / plain(conditions.title)
            under[conditions.title] = drive_arena(
                again, place, workers, fresh=fresh, clocked=clocked, begin=begin, announce=announce
            )
        return replace(outcome, under=under)


@dataclass(frozen=True)
class _Candidates:
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

    def chosen(self, costs: np.ndarray) -> int:
        """The place of the law as published or of the end of a search, whichever costs least (candidates, ...)."""
        means = costs.mean(axis=(1, 2))
        return min(sorted({0, *(int(row[-1]) for row in self.looked_at)}), key=lambda n: float(means[n]))


def _values(evaluated: Evaluations, place: int) -> Values:
    return tuple(map(float, evaluated.values[place]))


@dataclass(frozen=True)
class _ArenaRun:
    """An arena that is being held."""

    arena: Arena
    about: Mapping[str, Any]  # all that determines its numbers
    folder: Path
    workers: Workers
    times: Mapping[str, Timed]
    begin: Begin

    def outcome(self) -> Outcome:
        """Do all the work there is, and put together what came of it."""
        arena, searches = self.arena, self.searches()
        laws = {
            law: _Candidates({s: e for s, e in searches.items() if s.law == law}, budgets_of(arena, law))
            for law in arena.laws
        }
        choosing = [d for law, c in laws.items() for d in self.by_scenario(law, "choose", c.values, "choose")]
        tried = self.drives("choosing", choosing)
        costs = {
            law: np.stack([_run_costs(arena, d, table) for d, table in tried.items() if d.law == law], axis=1)
            for law in laws
        }
        places = {law: candidates.chosen(costs[law]) for law, candidates in laws.items()}
        chosen = {law: laws[law].values[place] for law, place in places.items()}
        every = tuple(range(len(arena.scenarios("test"))))
        tests = [
            *(d for law in laws for d in self.by_scenario(law, PUBLISHED, (None,))),
            *(d for law in laws if places[law] for d in self.by_scenario(law, TUNED, (chosen[law],))),
            *(
                DriveJob(law, change, (chosen[law],), "test", every, arena.robustness_runs, change)
                for law in laws
                for change in CHANGES
            ),
        ]
        tested = self.drives("testing", tests)

        def runs(law: str, part: str) -> pd.DataFrame:
            return pd.concat([t for d, t in tested.items() if (d.law, d.part) == (law, part)], ignore_index=True)

        entries = tuple(
            ArenaEntry(
                law=law,
                parameters=next((tuple(p.name for p in e.parameters) for e in candidates.searches.values()), ()),
                chosen=places[law],
                budgets=tuple(candidates.budgets),
                searches=tuple(candidates.searches),
                looked_at=candidates.looked_at,
                choosing=costs[law],
                runs={PUBLISHED: runs(law, PUBLISHED), TUNED: runs(law, TUNED if places[law] else PUBLISHED)},
                changed={change: runs(law, change) for change in CHANGES},
            )
            for law, candidates in laws.items()
        )
        computing = {law: self.times[law].period for law in arena.laws}
        return Outcome(arena, entries, computing, machine())

    def searches(self) -> dict[Search, Evaluations]:
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
        one = partial(searched, arena, self.folder, workers if workers.apart else None)
        with in_threads(len(todo)) if workers.apart else nullcontext(workers) as those:
            found = dict(
                run_pieces(
                    one,
                    sorted(todo, key=lambda s: -self.times[s.law].run * arena.budget(s.law)),
                    those,
                    called=attrgetter("law"),
                    kept=ArenaError,
                    advance=self.begin(f"tuning: {len(todo)} searches", len(todo)),
                )
            )
        return {search: found[search] for search in todo}

    def by_scenario(
        self, law: str, part: str, candidates: tuple[Values | None, ...], block: Literal["choose", "test"] = "test"
    ) -> list[DriveJob]:
        """Candidates of a law that drive each scenario of a block by itself, with all its seeds."""
        places, runs = range(len(self.arena.scenarios(block))), len(self.arena.seeds(block))
        return [DriveJob(law, part, candidates, block, (k,), runs) for k in places]

    def drives(self, what: str, todo: Sequence[DriveJob]) -> dict[DriveJob, pd.DataFrame]:
        """Do drives, the longest first, or read what the folder has of them."""
        kept = KeptChunks(
            folder=self.folder / "runs" / what,
            kind="arena",
            key=digest([self.about, *map(repr, todo)]),
            count=len(todo),
            chunk=lambda number: Chunk(number, (todo[number - 1],)),
            one=partial(run_chunk, partial(driven, self.arena), attrgetter("law"), versions(*PACKAGES), ArenaError),
            place=attrgetter("law"),
            fault=ArenaError,
            workers=self.workers,
        )
        left = sorted(kept.missing(), key=lambda n: -self.times[todo[n - 1].law].run * todo[n - 1].count)
        kept.compute(left, self.begin(f"{what}: {sum(d.count for d in todo)} runs", max(len(left), 1)))
        return {drive: table.to_pandas() for drive, table in zip(todo, kept.tables(), strict=True)}


def _run_costs(arena: Arena, drive: DriveJob, table: pd.DataFrame) -> np.ndarray:
    """What the candidates of a drive cost (candidates, runs), a failed run what the search took it for."""
    cost = arena.made_cost
    metrics = {name: table[name].to_numpy(dtype=float)[:, None] for name in cost.metrics}
    return cost.of(metrics, table["stopped"].to_numpy()[:, None] > 0).reshape(len(drive.candidates), -1)


def _times(arena: Arena, folder: Path, begin: Begin) -> dict[str, Timed]:
    """How long the laws compute: measured once for a folder."""

    def read(path: Path) -> dict[str, Timed] | None:
        try:
            there = json.loads(path.read_text(encoding="utf-8"))
            return {law: Timed(**there["laws"][law]) for law in arena.laws}
        except (OSError, ValueError, KeyError, TypeError):
            return None

    if (found := kept_piece(folder / _TIMES, read, "arena")) is not None:
        return found
    advance, found = begin("measuring computing times", len(arena.laws)), {}
    for law in arena.laws:
        try:
            found[law] = timed(arena, law)
        except InputError as error:
            raise ArenaError(f"{law}: {error}") from None
        advance()
    write_json(folder / _TIMES, {"machine": machine(), "laws": {law: asdict(one) for law, one in found.items()}})
    return found


def _estimate(arena: Arena, times: Mapping[str, Timed], workers: Workers) -> str:
    """A sentence: how long it will take."""
    seconds = {law: times[law].run * _runs_of(arena, law) for law in arena.laws}
    total = sum(seconds.values())
    count = max(workers.in_flight // 2, 1)
    longest = sorted(seconds, key=lambda law: -seconds[law])[:3]
    most = ", ".join(f"{law} {100 * seconds[law] / total:.0f} %" for law in longest)
    return (
        f"{sum(_runs_of(arena, law) for law in arena.laws):,} runs: about {_minutes(total / count)} on "
        f"{counted(count, 'worker')} ({most}); what is done is kept"
    )


def _runs_of(arena: Arena, law: str) -> int:
    """The number of runs that a law drives in all, at most."""
    searches = len(arena.engines) * arena.repeats
    tuning = searches * arena.budget(law) * arena.runs * len(arena.scenarios("tune"))
    candidates = 1 + searches * len(budgets_of(arena, law))
    choosing = candidates * arena.choosing_runs * len(arena.scenarios("choose"))
    tests = 2 * arena.testing_runs + len(CHANGES) * arena.robustness_runs
    return tuning + choosing + tests * len(arena.scenarios("test"))


def _minutes(seconds: float) -> str:
    if seconds < 90:
        return f"{seconds:.0f} s"
    return f"{seconds / 60:.0f} min" if seconds < 5400 else f"{seconds / 3600:.1f} h"
