"""Outcomes of arenas that never were held: costs are given, and everything else follows."""

from collections.abc import Mapping
from dataclasses import replace

import numpy as np
import pandas as pd

from robotics.plugins.arena.changes import CHANGES
from robotics.plugins.arena.description import Arena, parse_arena
from robotics.plugins.arena.outcome import ArenaEntry, Outcome
from robotics.plugins.arena.work import SHOWN, Search
from robotics.studies.tuning.cost import COST_TERMS

SCENARIOS, SEEDS = 12, 40
SHAPE = (SCENARIOS, SEEDS)
TEXT = """
laws = ["fuzzy", "lyapunov", "lqr"]
testing_runs = 40
choosing_runs = 4
robustness_runs = 10
evaluations = 100
[[tune]]
path = "sine"
[[choose]]
path = "sine"
[[test]]
path = "sine"
count = 4
[[test]]
path = "circle"
count = 4
[[test]]
path = "eight"
count = 4
"""


def arena(**changes: object) -> Arena:
    """A small arena of three laws."""
    return replace(parse_arena(TEXT), **changes)  # type: ignore[arg-type]


def noisy(level: float, seed: int, spread: float = 0.1) -> np.ndarray:
    """Costs around a level, with noise that all laws share but for a tenth."""
    shared = np.random.default_rng(1).normal(0.0, spread, SHAPE)
    own = np.random.default_rng(100 + seed).normal(0.0, spread / 10, SHAPE)
    return level * np.exp(shared + own)


def table(costs: np.ndarray) -> pd.DataFrame:
    """Runs that cost so much, all of it by the first term; infinite: the robot was stopped."""
    scenario, seed = np.meshgrid(np.arange(costs.shape[0]), np.arange(costs.shape[1]), indexing="ij")
    failed = np.isinf(costs)
    columns = {"candidate": np.zeros(costs.size, dtype=int), "scenario": scenario.ravel(), "seed": seed.ravel()}
    columns |= {term.metric: np.zeros(costs.size) for term in COST_TERMS} | {
        name: np.zeros(costs.size) for name in SHOWN
    }
    columns[COST_TERMS[0].metric] = np.where(failed, 1.0, costs * COST_TERMS[0].scale / COST_TERMS[0].weight).ravel()
    return pd.DataFrame(columns | {"stopped": failed.ravel().astype(int)})


def outcome(
    tuned: Mapping[str, np.ndarray],
    published: Mapping[str, np.ndarray] | None = None,
    choosing: Mapping[str, np.ndarray] | None = None,
    computing: Mapping[str, float] | None = None,
    changed: float = 1.5,
    **changes: object,
) -> Outcome:
    """An outcome of laws whose costs (scenarios, seeds) are given.

    Args:
        tuned: The costs of the tuned laws, by law.
        published: Those of the laws as published; by default twice as much.
        choosing: The cost of the candidates (published, cmaes, random) of each law, on every choosing run.
        computing: µs a period, by law; by default 1.
        changed: By what the costs are multiplied under each change.
        changes: Other fields of the arena.
    """
    made = arena(laws=tuple(tuned), **changes)
    searches = [Search("", engine, 0) for engine in made.engines]
    entries = []
    for law, costs in tuned.items():
        before = 2 * costs if published is None else published[law]
        levels = np.array([2.0, 1.0, 1.0]) if choosing is None else choosing[law]
        entries.append(
            ArenaEntry(
                law=law,
                parameters=("gain",),
                chosen=1,
                budgets=(50, 100),
                searches=tuple(replace(s, law=law) for s in searches),
                looked_at=np.array([[0, 1], [0, 2]])[: len(searches)],
                choosing=np.ones((3, 1, made.choosing_runs)) * levels[:, None, None],
                runs={"published": table(before), "tuned": table(costs)},
                changed={change: table(changed * costs[:, : made.robustness_runs]) for change in CHANGES},
            )
        )
    times = dict.fromkeys(tuned, 1.0) if computing is None else dict(computing)
    return Outcome(made, tuple(entries), times, "a machine", draws=200)
