"""The work of an arena in pieces: searches, and runs that are measured. Each can be done by itself, anywhere."""

import re
import warnings
from dataclasses import dataclass
from pathlib import Path
from typing import Literal

import numpy as np
import pandas as pd
from threadpoolctl import threadpool_limits

from fuzzy.tuning.search import Evaluations
from robotics.plugins.arena.changes import changed
from robotics.plugins.arena.description import Arena
from robotics.plugins.arena.plan import ArenaPlan
from robotics.studies.executors import Workers
from robotics.studies.population import simulate_many
from robotics.studies.tuning.tune import Tuned, tune

BUDGETS = (10, 20, 50, 100, 200, 300, 500, 700, 1000)  # evaluations at which a search is looked at
SHOWN = ("max_cross_track_m", "torque_variation_nmps")  # metrics that are measured beside those of the cost


@dataclass(frozen=True)
class Search:
    """A search of one engine for one law."""

    law: str
    engine: str
    repeat: int  # from 0

    @property
    def name(self) -> str:
        """What it is called in files and tables; repeats count from 1."""
        return f"{self.engine}-{self.repeat + 1}"


@dataclass(frozen=True)
class DriveJob:
    """Candidates of one law that drive some scenarios of a block, and are measured."""

    law: str
    part: str  # what it is for: "choose", "published", "tuned" or a change
    candidates: tuple[tuple[float, ...] | None, ...]  # each the values of the law's space; None: as published
    block: Literal["choose", "test"]
    scenarios: tuple[int, ...]  # places in the block
    runs: int
    change: str = ""

    @property
    def count(self) -> int:
        """How many runs these are."""
        return len(self.candidates) * len(self.scenarios) * self.runs


def plain(text: str) -> str:
    """A specification, or a part, as the name of a file."""
    words = text.replace("+", "plus").replace("-20", "minus20").replace("×", "x")
    return re.sub(r"[^\w.=-]+", "-", words).strip("-")


def search_folder(folder: Path, search: Search) -> Path:
    """Where a search is written down."""
    return folder / "searches" / plain(search.law) / search.name


def budgets_of(arena: ArenaPlan, law: str) -> list[int]:
    """The numbers of evaluations at which the searches of a law are looked at; the last is its whole budget."""
    whole = arena.budget(law)
    return [n for n in BUDGETS if n < whole] + [whole] * (whole > 0)


def searched(arena: Arena, folder: Path, workers: Workers | None, search: Search) -> Evaluations:
    """Do a search, or what is left of it; ``folder`` is the arena's."""
    return tuned(arena, folder, workers, search).evaluated


def tuned(arena: Arena, folder: Path, workers: Workers | None, search: Search) -> Tuned:
    """Run one search, as :func:`searched` does; return its evaluations with the law and the cost they belong to."""
    space = arena.space(search.law)
    assert space is not None
    with threadpool_limits(1, "blas"):  # matrices here are small: more threads would wait for each other
        return tune(
            space,
            arena.scenarios("tune"),
            specification=search.law,
            runs=arena.runs,
            evaluations=arena.budget(search.law),
            seed=arena.seed + search.repeat,
            engine=search.engine,
            cost=arena.made_cost,
            first_seed=arena.tuning_seed(search.repeat),
            folder=search_folder(folder, search),
            threads=1,
            workers=workers,
        )


def driven(arena: Arena, drive: DriveJob) -> pd.DataFrame:
    """Drive and measure: a row a run, with the places of its candidate and of its scenario, and its seed."""
    law, space = arena.law(drive.law), arena.space(drive.law)
    laws = [law if values is None or space is None else space.made(values) for values in drive.candidates]
    names = list(dict.fromkeys([*arena.made_cost.metrics, *SHOWN]))
    seeds, scenarios, found = arena.seeds(drive.block, drive.runs), arena.scenarios(drive.block), []
    for place in drive.scenarios:
        scenario, truth = changed(scenarios[place], drive.change)
        # A rule base that is asked outside of its universe pays for it
        with threadpool_limits(1, "blas"), warnings.catch_warnings(action="ignore"):
            runs = simulate_many(scenario, laws, seeds, keep="metrics", metrics=names, truth=truth, threads=1)
        candidate, seed = np.meshgrid(np.arange(len(laws)), np.asarray(seeds), indexing="ij")
        columns = {"candidate": candidate.ravel(), "scenario": np.full(candidate.size, place), "seed": seed.ravel()}
        columns |= {name: runs[name].mean(axis=-1).ravel() for name in names}
        columns["stopped"] = runs.stopped.any(axis=-1).ravel().astype(int)
        found.append(pd.DataFrame(columns))
    return pd.concat(found, ignore_index=True)
