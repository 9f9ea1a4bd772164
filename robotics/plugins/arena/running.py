"""Holding an arena of tracking: every law tuned with the same budget, chosen on other runs, tested on others again."""

import json
from collections.abc import Callable, Mapping
from dataclasses import asdict, dataclass, replace
from functools import partial
from pathlib import Path
from typing import Literal

import numpy as np
import pandas as pd

from fuzzy.errors import InputError
from fuzzy.files.atomic import write_json
from fuzzy.shell.progress import Begin, unwatched
from fuzzy.words import counted
from robotics.plugins.arena.changes import CHANGES
from robotics.plugins.arena.computing import Timed, machine, timed
from robotics.plugins.arena.description import Arena
from robotics.plugins.arena.holding import Candidates, Holding, Values, claimed_folder
from robotics.plugins.arena.outcome import ArenaEntry, Outcome
from robotics.plugins.arena.plan import ArenaError
from robotics.plugins.arena.work import DriveJob, budgets_of, driven, plain, searched
from robotics.studies.executors import Workers
from robotics.studies.pieces import kept_piece
from robotics.studies.versions import versions

_TIMES = "computing.json"
PUBLISHED, TUNED = "published", "tuned"
_UNKNOWN = Timed(float("nan"), 1.0)


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

    plan = {**arena.about(), "versions": versions()}
    with claimed_folder(folder, plan, fresh=fresh, besides=[_TIMES]):
        times = _times(arena, folder, begin) if clocked else dict.fromkeys(arena.laws, _UNKNOWN)
        for sentence in arena.said_of_untuned():
            announce(sentence)
        if clocked:
            announce(_estimate(arena, times, workers))
        seconds = {law: one.run for law, one in times.items()}
        outcome = _ArenaRun(arena, times, Holding(arena, plan, folder, workers, begin, seconds)).outcome()
        under = {}
        for conditions in arena.under:
            announce(f"{conditions.title}: every law is tuned anew")
            again, place = replace(arena, conditions=conditions, under=()), folder / "under" / plain(conditions.title)
            under[conditions.title] = drive_arena(
                again, place, workers, fresh=fresh, clocked=clocked, begin=begin, announce=announce
            )
        return replace(outcome, under=under)


@dataclass(frozen=True)
class _ArenaRun:
    """An arena that is being held."""

    arena: Arena
    times: Mapping[str, Timed]
    held: Holding

    def outcome(self) -> Outcome:
        """Do all the work there is, and put together what came of it."""
        arena, one = self.arena, partial(driven, self.arena)
        laws = self.held.candidates(self.held.searches(partial(searched, arena)))
        choosing = [d for law, c in laws.items() for d in self.by_scenario(law, "choose", c.values, "choose")]
        tried = self.held.drives("choosing", choosing, one)
        costs = {
            law: np.stack([_run_costs(arena, d, table) for d, table in tried.items() if d.law == law], axis=1)
            for law in laws
        }
        places = {law: _chosen(candidates, costs[law]) for law, candidates in laws.items()}
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
        tested = self.held.drives("testing", tests, one)

        def runs(law: str, part: str) -> pd.DataFrame:
            return pd.concat([t for d, t in tested.items() if (d.law, d.part) == (law, part)], ignore_index=True)

        entries = tuple(
            ArenaEntry(
                law=law,
                parameters=candidates.parameters,
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

    def by_scenario(
        self, law: str, part: str, candidates: tuple[Values | None, ...], block: Literal["choose", "test"] = "test"
    ) -> list[DriveJob]:
        """Candidates of a law that drive each scenario of a block by itself, with all its seeds."""
        places, runs = range(len(self.arena.scenarios(block))), len(self.arena.seeds(block))
        return [DriveJob(law, part, candidates, block, (k,), runs) for k in places]


def _chosen(candidates: Candidates, costs: np.ndarray) -> int:
    """The place of the law as published or of the end of a search, whichever costs least (candidates, ...)."""
    means = costs.mean(axis=(1, 2))
    return min(candidates.ends, key=lambda n: float(means[n]))


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
