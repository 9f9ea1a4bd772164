"""Holding an arena: every law tuned with the same budget, the best chosen on other runs, and tested on others again.

Every piece of work that is done stands in the folder, whole or not at all; after a stop, also of a killed process, the
same arena in the same folder goes on from there and ends with the same bytes.
"""

import csv
import json
from collections.abc import Callable, Iterator, Mapping, Sequence
from concurrent.futures import CancelledError, Future, ThreadPoolExecutor
from dataclasses import asdict, dataclass, replace
from pathlib import Path
from typing import Any, TypeVar

import numpy as np
import pandas as pd

from fuzzy.errors import InputError
from fuzzy.files.atomic import write_json
from fuzzy.files.claim import alone, claim
from fuzzy.files.table import write_frame
from fuzzy.shell.progress import Begin, unwatched
from fuzzy.tuning.search import Evaluations
from robotics.arena.changes import CHANGES
from robotics.arena.computing import Timed, machine, timed
from robotics.arena.description import Arena, about
from robotics.arena.families import ArenaError
from robotics.arena.outcome import ArenaEntry, Outcome
from robotics.arena.work import WHOLE, DriveJob, Search, budgets_of, driven, plain, searched
from robotics.experiments.executors import InProcess, WorkerError, Workers, as_done
from robotics.experiments.versions import versions

_PLAN, _TIMES = "arena.json", "computing.json"
PUBLISHED, TUNED = "published", "tuned"
_LOST = "the connection to the workers was lost; the same command goes on from there"
_UNKNOWN = Timed(float("nan"), 1.0)
Piece = TypeVar("Piece", Search, DriveJob)


@dataclass(frozen=True)
class ArenaWorkers:
    """Who does the work, and what it cannot do."""

    workers: Workers
    apart: bool = False  # whether the workers do not see the folder, as on a cluster


def drive_arena(
    arena: Arena,
    folder: Path,
    crew: ArenaWorkers | None = None,
    *,
    fresh: bool = False,
    clocked: bool = True,
    begin: Begin | None = None,
    announce: Callable[[str], None] = lambda text: None,
) -> Outcome:
    """Hold an arena, or do what is left of it.

    Args:
        arena: The arena.
        folder: The folder of the results.
        crew: Who does the work, by default this process.
        fresh: Whether to discard what the folder holds of an arena.
        clocked: Whether computing times are measured first; otherwise there are none, and nothing is foretold.
        begin: Starts a bar of a progress display, by its text and total.
        announce: Called with sentences before the work begins: which laws are not tuned, and how long it will take.

    Raises ArenaError where the folder holds another arena, another process is at work there, or a law fails.
    """
    crew = crew or ArenaWorkers(Workers(InProcess()))
    folder.mkdir(parents=True, exist_ok=True)
    with alone(folder, ArenaError(f"{folder}: another arena is held here; wait for it, or give another --out")):
        _open(arena, folder, fresh)
        times = _times(arena, folder, begin) if clocked else dict.fromkeys(arena.laws, _UNKNOWN)
        for law in arena.untuned:
            announce(f"{law}: nothing of it moves, of {', '.join(arena.move)}; it takes part as published")
        if clocked:
            announce(_estimate(arena, times, crew))
        return _ArenaRun(arena, folder, crew, times, begin).outcome()


class _ArenaRun:
    """An arena that is being held."""

    def __init__(
        self, arena: Arena, folder: Path, crew: ArenaWorkers, times: Mapping[str, Timed], begin: Begin | None
    ) -> None:
        self.arena, self.folder, self.crew, self.times = arena, folder, crew, times
        self.begin: Begin = begin or unwatched

    def outcome(self) -> Outcome:
        """Do all the work there is, and put together what came of it."""
        searches = self.searches()
        published = [
            DriveJob(law, PUBLISHED, (None,), "test", (k,), self.arena.testing_runs) for law, k in self.places()
        ]
        candidates = {law: self.candidates(law, searches) for law in self.arena.laws}
        choosing = [
            DriveJob(law, "choose", tuple(candidates[law]), "choose", (k,), self.arena.choosing_runs)
            for law in self.arena.laws
            for k in range(len(self.arena.scenarios("choose")))
        ]
        found = self.drives("choosing", choosing)
        chosen = {law: self.chosen(law, candidates[law], found, searches) for law in self.arena.laws}
        found |= self.drives("testing", [*published, *self.tests(chosen)])
        return Outcome(
            arena=self.arena,
            entries=tuple(self.entry(law, candidates[law], chosen[law], found, searches) for law in self.arena.laws),
            computing={law: self.times[law].period for law in self.arena.laws},
            machine=machine(),
            versions=versions(),
        )

    # Searching -------------------------------------------------------------------------------------------------

    def searches(self) -> dict[Search, Evaluations]:
        """Every search of every law, the longest first."""
        arena = self.arena
        todo = [
            Search(law, engine, repeat)
            for law in arena.laws
            if law not in arena.untuned
            for engine in arena.engines
            for repeat in range(arena.repeats)
        ]
        todo.sort(key=lambda s: -self.times[s.law].run * arena.budget(s.law))
        here = self.crew.workers
        if not self.crew.apart:
            return self.all_of(todo, lambda s: here.executor.submit(searched, arena, s, self.folder), here)
        with ThreadPoolExecutor(len(todo)) as pool:  # generation by generation, which this process writes down
            side_by_side = replace(here, executor=pool, in_flight=len(todo))
            return self.all_of(todo, lambda s: pool.submit(searched, arena, s, self.folder, here), side_by_side)

    def all_of(
        self, todo: Sequence[Search], submit: "Callable[[Search], Future[Any]]", workers: Workers
    ) -> dict[Search, Evaluations]:
        """The outcome of all searches, by whoever does them."""
        advance = self.begin(f"tuning: {len(todo)} searches", len(todo))
        found = {}
        for search, evaluated in _as_done(todo, submit, workers):
            found[search] = evaluated
            advance()
        return found

    def candidates(self, law: str, searches: Mapping[Search, Evaluations]) -> list[tuple[float, ...] | None]:
        """The law as published, and what each search held for the best at each budget; none of them twice."""
        found: list[tuple[float, ...] | None] = [None]
        for search, evaluated in searches.items():
            if search.law == law:
                found += [_best(evaluated, n) for n in budgets_of(self.arena, law)]
        starts = {tuple(map(float, e.values[0])) for s, e in searches.items() if s.law == law}
        numbers = sorted({values for values in found if values is not None} - starts)
        return [None, *numbers]

    # Driving ---------------------------------------------------------------------------------------------------

    def places(self) -> list[tuple[str, int]]:
        """Every law with every scenario that is tested on."""
        return [(law, k) for law in self.arena.laws for k in range(len(self.arena.scenarios("test")))]

    def tests(self, chosen: Mapping[str, tuple[float, ...] | None]) -> list[DriveJob]:
        """The runs of the chosen laws, as they are told and with every change; those of a law that stays are there."""
        arena, every = self.arena, tuple(range(len(self.arena.scenarios("test"))))
        drives = [
            DriveJob(law, TUNED, (chosen[law],), "test", (k,), arena.testing_runs)
            for law, k in self.places()
            if chosen[law] is not None
        ]
        return drives + [
            DriveJob(law, change, (chosen[law],), "test", every, arena.robustness_runs, change)
            for law in arena.laws
            for change in CHANGES
        ]

    def drives(self, what: str, todo: Sequence[DriveJob]) -> dict[DriveJob, pd.DataFrame]:
        """Do drives, or read what the folder has of them."""
        found: dict[DriveJob, pd.DataFrame] = {}
        left = []
        for drive in todo:
            table = _read(self.file(drive), drive)
            if table is None:
                left.append(drive)
            else:
                found[drive] = table
        left.sort(key=lambda d: -self.times[d.law].run * d.count)
        advance = self.begin(f"{what}: {sum(d.count for d in todo)} runs", max(len(left), 1))
        submit = self.crew.workers.executor.submit
        for drive, table in _as_done(left, lambda d: submit(driven, self.arena, d), self.crew.workers):
            path = self.file(drive)
            path.parent.mkdir(parents=True, exist_ok=True)
            write_frame(table, path)
            found[drive] = table
            advance()
        return found

    def file(self, drive: DriveJob) -> Path:
        """Where the runs of a drive stand."""
        which = f"-{drive.scenarios[0] + 1}" if len(drive.scenarios) == 1 else ""
        return self.folder / "runs" / plain(drive.law) / f"{plain(drive.part)}{which}.csv"

    # Choosing --------------------------------------------------------------------------------------------------

    def chosen(
        self,
        law: str,
        candidates: Sequence[tuple[float, ...] | None],
        found: Mapping[DriveJob, pd.DataFrame],
        searches: Mapping[Search, Evaluations],
    ) -> tuple[float, ...] | None:
        """The law as published or the end of a search, whichever costs least on the runs for choosing."""
        costs = self.choosing_costs(law, len(candidates), found).mean(axis=(1, 2))
        ends = {_best(e, self.arena.budget(law)) for s, e in searches.items() if s.law == law}
        allowed = [n for n, values in enumerate(candidates) if values is None or values in ends]
        return candidates[min(allowed, key=lambda n: float(costs[n]))]

    def choosing_costs(self, law: str, count: int, found: Mapping[DriveJob, pd.DataFrame]) -> np.ndarray:
        """What a law's candidates cost (candidates, scenarios, seeds), a failed run what the search took it for."""
        arena = self.arena
        scenarios = len(arena.scenarios("choose"))
        costs = np.empty((count, scenarios, arena.choosing_runs))
        for drive, table in found.items():
            if drive.law == law and drive.part == "choose":
                cost = costs_in(arena, table)
                costs[:, drive.scenarios[0]] = cost.reshape(count, arena.choosing_runs)
        return costs

    def entry(
        self,
        law: str,
        candidates: Sequence[tuple[float, ...] | None],
        chosen: tuple[float, ...] | None,
        found: Mapping[DriveJob, pd.DataFrame],
        searches: Mapping[Search, Evaluations],
    ) -> ArenaEntry:
        """All that is known of a law in the end."""
        arena = self.arena
        mine = {s: e for s, e in searches.items() if s.law == law}
        budgets = budgets_of(arena, law)
        place = {values: n for n, values in enumerate(candidates)}
        starts = {tuple(map(float, e.values[0])) for e in mine.values()}

        def of(evaluated: Evaluations, n: int) -> int:
            values = _best(evaluated, n)
            return 0 if values in starts else place[values]

        order = sorted(mine, key=lambda s: (arena.engines.index(s.engine), s.repeat))
        tables: dict[str, pd.DataFrame] = {}
        for part in (PUBLISHED, TUNED, *CHANGES):
            drives = sorted((d for d in found if (d.law, d.part) == (law, part)), key=lambda d: d.scenarios)
            if drives:
                tables[part] = pd.concat([found[d] for d in drives], ignore_index=True)
        ways = {s.name for s in order if chosen is not None and _best(mine[s], arena.budget(law)) == chosen}
        return ArenaEntry(
            law=law,
            parameters=next((tuple(p.name for p in e.parameters) for e in mine.values()), ()),
            chosen=chosen,
            by=min(ways) if ways else "",
            budgets=tuple(budgets),
            searches=tuple(order),
            looked_at=np.array([[of(mine[s], n) for n in budgets] for s in order], dtype=int),
            choosing=self.choosing_costs(law, len(candidates), found),
            runs={PUBLISHED: tables[PUBLISHED], TUNED: tables.get(TUNED, tables[PUBLISHED])},
            changed={change: tables[change] for change in CHANGES},
        )


def _best(evaluated: Evaluations, n: int) -> tuple[float, ...]:
    return tuple(map(float, evaluated.values[evaluated.best_within(n)]))


def costs_in(arena: Arena, table: pd.DataFrame) -> np.ndarray:
    """What the runs of a table cost (rows,), a failed run ``failed``."""
    cost = arena.made_cost
    metrics = {name: table[name].to_numpy(dtype=float)[:, None] for name in cost.metrics}
    return cost.of(metrics, table["stopped"].to_numpy()[:, None] > 0)


# The folder -------------------------------------------------------------------------------------------------------


def _open(arena: Arena, folder: Path, fresh: bool) -> None:
    """Check that the folder is this arena's, or make it so."""

    def discard() -> None:
        for left in [*folder.glob("searches/*/*/*"), *folder.glob("runs/*/*.csv"), folder / _TIMES]:
            if left.is_file():
                left.unlink()

    plan = {**about(arena), "versions": versions()}
    claim(folder / _PLAN, plan, discard, kind="arena", elsewhere="--out", fault=ArenaError, fresh=fresh)


def _read(path: Path, drive: DriveJob) -> pd.DataFrame | None:
    """The runs of a drive, if the folder has them whole."""
    try:
        with path.open(encoding="utf-8", newline="") as file:
            rows = list(csv.DictReader(file))
        columns = {  # Python reads a number as it was written, to the last bit
            name: [int(row[name]) if name in WHOLE else float(row[name]) for row in rows] for name in (rows or [{}])[0]
        }
    except (OSError, ValueError, TypeError, KeyError):
        return None
    return pd.DataFrame(columns) if len(rows) == drive.count else None


def _times(arena: Arena, folder: Path, begin: Begin | None) -> dict[str, Timed]:
    """How long the laws compute: measured once for a folder."""
    path = folder / _TIMES
    if path.exists():
        try:
            there = json.loads(path.read_text(encoding="utf-8"))
            return {law: Timed(**there["laws"][law]) for law in arena.laws}
        except (OSError, ValueError, KeyError, TypeError):
            pass  # it is measured again
    advance = (begin or unwatched)("measuring computing times", len(arena.laws))
    found: dict[str, Timed] = {}
    for law in arena.laws:
        try:
            found[law] = timed(arena, law)
        except InputError as error:
            raise ArenaError(f"{law}: {error}") from None
        advance()
    write_json(path, {"machine": machine(), "laws": {law: asdict(one) for law, one in found.items()}})
    return found


def _estimate(arena: Arena, times: Mapping[str, Timed], crew: ArenaWorkers) -> str:
    """A sentence: how long it will take."""
    seconds = estimated_seconds(arena, times)
    total = sum(seconds.values())
    workers = max(crew.workers.in_flight // 2, 1)
    longest = sorted(seconds, key=lambda law: -seconds[law])[:3]
    most = ", ".join(f"{law} {100 * seconds[law] / total:.0f} %" for law in longest)
    return (
        f"{sum(runs_of(arena, law) for law in arena.laws):,} runs: about {_minutes(total / workers)} on {workers} "
        f"worker{'s' * (workers != 1)} ({most}); what is done is kept"
    )


def estimated_seconds(arena: Arena, times: Mapping[str, Timed]) -> dict[str, float]:
    """How long one worker takes for each law [s]."""
    return {law: times[law].run * runs_of(arena, law) for law in arena.laws}


def runs_of(arena: Arena, law: str) -> int:
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


# Work that is done elsewhere --------------------------------------------------------------------------------------


def _as_done(
    jobs: Sequence[Piece], submit: "Callable[[Piece], Future[Any]]", workers: Workers
) -> "Iterator[tuple[Piece, Any]]":
    """Pieces of work with their results as they get done. Raises ArenaError for one that fails."""
    for job, future in as_done(jobs, submit, workers, ArenaError(_LOST)):
        try:
            result = future.result()
        except CancelledError:
            raise ArenaError(_LOST) from None
        except WorkerError as error:
            raise ArenaError(f"{job.law}: {error}; the same command goes on from there") from None
        except InputError as error:
            raise ArenaError(f"{job.law}: {error}") from None
        yield job, result
