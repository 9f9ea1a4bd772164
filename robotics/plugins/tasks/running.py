"""Holding an arena of tasks: every law tuned with the same budget, chosen on other scenarios, tested on others again.

Laws of an emergency rule are tested without it, too, with the same numbers. Everybody drives the same scenarios with
the same noise.
"""

from collections.abc import Callable, Sequence
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd

from fuzzy.errors import InputError
from fuzzy.shell.progress import Begin, unwatched
from fuzzy.tuning.journal import resumable_search
from fuzzy.tuning.search import Evaluations
from robotics.laws.catalogue import with_gains
from robotics.laws.law import Law
from robotics.plugins.arena.holding import Candidates, Holding, claimed_folder
from robotics.plugins.arena.plan import Block
from robotics.plugins.arena.work import DriveJob, Search, search_folder
from robotics.plugins.tasks.description import GUARD, TaskArena, guarded
from robotics.plugins.tasks.driving import drive
from robotics.plugins.tasks.outcome import TaskEntry, TaskOutcome, key_of
from robotics.studies.executors import Workers
from robotics.studies.pieces import run_pieces
from robotics.studies.tuning.space import LawSpace
from robotics.studies.versions import versions

UNGUARDED = "without the emergency rule"
_SHARE = 20  # scenarios that one piece of work drives


def drive_tasks(
    arena: TaskArena,
    folder: Path,
    workers: Workers | None = None,
    *,
    fresh: bool = False,
    begin: Begin = unwatched,
    announce: Callable[[str], None] = lambda text: None,
) -> TaskOutcome:
    """Hold an arena of tasks, or finish one that was interrupted.

    Args:
        arena: The arena.
        folder: The folder of the results.
        workers: Who does the work, by default this process.
        fresh: Whether to discard what the folder holds of an arena.
        begin: Starts a bar of a progress display, by its text and total.
        announce: Called with sentences before the work begins: which laws are not tuned, and how many runs there are.

    Raises ArenaError where the folder holds another arena, another process is at work there, or a law fails.
    """
    plan = {**arena.about(), "versions": versions()}
    with claimed_folder(folder, plan, fresh=fresh):
        for sentence in arena.said_of_untuned():
            announce(sentence)
        announce(f"{_runs(arena):,} runs at most; what is done is kept")
        held = Holding(arena, plan, folder, workers or Workers(), begin, dict.fromkeys(arena.laws, 1.0))
        laws = held.candidates(held.searches(partial(searched, arena)))
        one = partial(driven, arena)
        choosing = {
            law: _jobs(arena, law, "choose", "choose", tuple(candidates.values[n] for n in candidates.ends))
            for law, candidates in laws.items()
        }
        tried = held.drives("choosing", [job for jobs in choosing.values() for job in jobs], one)
        tables = {law: _joined([tried[job] for job in jobs]) for law, jobs in choosing.items()}
        places = {law: _chosen(candidates, tables[law]) for law, candidates in laws.items()}
        values = {law: laws[law].values[place] for law, place in places.items()}
        testing = {
            (law, part): _jobs(arena, law, part, "test", (values[law],))
            for law in arena.laws
            for part in ("", *([UNGUARDED] if guarded(arena.law(law)) else []))
        }
        tested = held.drives("testing", [job for jobs in testing.values() for job in jobs], one)
        runs = {key: _joined([tested[job] for job in jobs]) for key, jobs in testing.items()}
    entries = tuple(
        TaskEntry(
            law=law,
            parameters=candidates.parameters,
            searches=tuple(candidates.searches),
            ends=tuple(candidates.ends),
            chosen=places[law],
            values=values[law],
            choosing=tables[law],
            runs=runs[law, ""],
            unguarded=runs.get((law, UNGUARDED)),
        )
        for law, candidates in laws.items()
    )
    return TaskOutcome(arena, entries)


def _runs(arena: TaskArena) -> int:
    """How many runs there are, at most."""
    searches = len(arena.engines) * arena.repeats
    total = 0
    for law in arena.laws:
        total += searches * arena.budget(law) * arena.count("tune")
        total += (1 + searches * (law not in arena.untuned)) * arena.count("choose")
        total += (1 + guarded(arena.law(law))) * arena.count("test")
    return total


def _jobs(arena: TaskArena, law: str, part: str, block: Any, candidates: tuple[Any, ...]) -> list[DriveJob]:
    """Candidates of a law that drive all scenarios of a block, some at a time."""
    count = arena.count(block)
    change = part if part == UNGUARDED else ""
    return [
        DriveJob(law, part, candidates, block, tuple(range(first, min(first + _SHARE, count))), 1, change)
        for first in range(0, count, _SHARE)
    ]


def _joined(tables: Sequence[pd.DataFrame]) -> pd.DataFrame:
    return pd.concat(tables, ignore_index=True)


def _chosen(candidates: Candidates, table: pd.DataFrame) -> int:
    """The place of the law as published, or of the end of a search, whichever is first in the order of the ranking."""
    keys = [key_of(table[table["candidate"] == n]) for n in range(len(candidates.ends))]
    return candidates.ends[min(range(len(keys)), key=lambda n: (keys[n], n))]


def driven(arena: TaskArena, job: DriveJob) -> pd.DataFrame:
    """Drive the scenarios of a job: a row a run, with the place of its candidate."""
    law, space, found = arena.law(job.law), arena.space(job.law), []
    for n, values in enumerate(job.candidates):
        made = law if values is None or space is None else space.made(values)
        if job.change == UNGUARDED:
            made = with_gains(made, {GUARD: 0.0})
        scenarios = ((place, arena.scenario(job.block, place)) for place in job.scenarios)
        found.append(drive(scenarios, made).assign(candidate=n))
    return _joined(found)


# Tuning ------------------------------------------------------------------------------------------------------------


def searched(arena: TaskArena, folder: Path, workers: Workers | None, search: Search) -> Evaluations:
    """Do a search, or what is left of it; ``folder`` is the arena's."""
    space = arena.space(search.law)
    assert space is not None

    def evaluate(values: np.ndarray) -> np.ndarray:
        one = partial(candidate_cost, arena, space, search.repeat)
        costs = dict(run_pieces(one, map(tuple, values.tolist()), workers, called=lambda row: search.law))
        return np.array([[costs[tuple(row)]] for row in values.tolist()])

    return resumable_search(
        evaluate,
        space.parameters,
        about=_about(arena, space, search),
        folder=search_folder(folder, search),
        fresh=False,
        evaluations=arena.budget(search.law),
        seed=arena.seed + search.repeat,
        engine=search.engine,
    )


def candidate_cost(arena: TaskArena, space: LawSpace, repeat: int, values: Sequence[float]) -> float:
    """What a candidate costs on the scenarios that are tuned on; one that is no law costs more than any run."""
    try:
        law: Law[Any] = space.made(values)
    except InputError:
        return arena.contact + arena.deadlock + arena.tail + 100.0
    places = range(arena.count("tune"))
    return search_cost(arena, drive(((place, arena.scenario("tune", place, repeat)) for place in places), law))


def search_cost(arena: TaskArena, table: pd.DataFrame) -> float:
    """The one number of a table of runs that a search makes smaller; see :class:`TaskArena`."""
    clearance = table["clearance_m"].fillna(arena.near).to_numpy()  # of who stays nothing is near
    cost = arena.contact * table["caused"].fillna(0.0).mean() + arena.deadlock * table["deadlock"].mean()
    return float(cost + arena.tail * tail_of(clearance, arena.worst, arena.near) + table["time"].mean() - 1)


def tail_of(clearance: np.ndarray, worst: float, near: float) -> float:
    """The mean of max(1 − clearance/near, 0) over the share ``worst`` of the runs that are nearest (conditional value
    at risk); ``clearance`` (runs,) and ``near`` are in metres.
    """
    count = max(1, round(worst * len(clearance)))
    return float(np.maximum(1 - np.sort(clearance)[:count] / near, 0.0).mean())


def _about(arena: TaskArena, space: LawSpace, search: Search) -> dict[str, Any]:
    """All that determines a search, as JSON can hold it."""
    told = arena.about()
    block: Block = "tune"
    return {
        "law": search.law,
        "start": repr(space.law),
        "parameters": [{"name": p.name, "start": p.start, "low": p.lower, "high": p.upper} for p in space.parameters],
        "scenarios": told["families"][block],
        "seeds": [search.repeat, arena.count(block)],
        "cost": {name: told[name] for name in ("contact", "deadlock", "tail", "worst", "near")},
        "evaluations": arena.budget(search.law),
        "seed": arena.seed + search.repeat,
        "engine": search.engine,
        "versions": versions(),
    }
