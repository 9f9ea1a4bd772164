"""Tuning a law through the closed loop: ``tune("fuzzy", ["lyapunov-sine"])``.

Every evaluation drives all scenarios with the same seeds, so that two candidates differ by what they are and not by the
noise that they met (common random numbers). A generation is one pass of :func:`robotics.simulate_many` a scenario.

Seeds come in blocks: ordinary commands count from 0, tuning from TUNING, the choice among what was tuned from CHOOSING,
and what is said of it is measured from TESTING on. No run is in two of them.
"""

import warnings
from collections.abc import Callable, Sequence
from contextlib import nullcontext, suppress
from dataclasses import dataclass, field, replace
from functools import cached_property, partial
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd

from fuzzy.errors import InputError
from fuzzy.tuning.journal import SearchInterrupt, resumable_search
from fuzzy.tuning.parameter import TuningError
from fuzzy.tuning.search import Evaluations
from robotics.laws.catalogue import as_law, files_of
from robotics.laws.law import ControllerError, Law
from robotics.simulation.loop import simulate
from robotics.simulation.scenario.conditions import noises
from robotics.simulation.scenario.description import Scenario
from robotics.simulation.scenario.reading import load_scenario
from robotics.studies.executors import Workers
from robotics.studies.pieces import run_pieces
from robotics.studies.tuning.cost import Cost, costs_of
from robotics.studies.tuning.space import LawSpace
from robotics.studies.versions import digest_of, versions
from robotics.world.sensing.posture import LABORATORY

TUNING = 1_000_000  # the first seed of the runs that candidates are judged by
CHOOSING = 2_000_000  # the first seed of the runs that the best of several is chosen by
TESTING = 3_000_000  # the first seed of the runs that nothing was tuned on
RUNS = 20  # that a candidate's cost is the mean of
_EVALUATIONS = 1000  # of the cost, at most
_SEED = 1  # of the search
_LOOKED_AT = 4  # seeds, to find where rule bases are asked


@dataclass(frozen=True, eq=False)
class Tuned:
    """What tuning has found.

    Attributes:
        space: The law and what of it could move.
        cost: What a run costs.
        evaluated: All that was tried.
        about: The provenance: all that determines the result.
    """

    space: LawSpace
    cost: Cost = field(repr=False)
    evaluated: Evaluations = field(repr=False)
    about: dict[str, Any] = field(repr=False)

    @property
    def before(self) -> float:
        """The cost of the law as it was, on the tuning runs."""
        return float(self.evaluated.costs[0])

    @property
    def after(self) -> float:
        """The cost of the tuned law, on the tuning runs."""
        return float(self.evaluated.costs[self.evaluated.best])

    @property
    def evaluations(self) -> int:
        """How many laws were tried, the law as it was included."""
        return len(self.evaluated)

    @cached_property
    def law(self) -> Law[Any]:
        """The tuned law."""
        return self.law_at(self.evaluated.best)

    def law_at(self, place: int) -> Law[Any]:
        """The law of an evaluation by its ``place``, from 0."""
        return self.space.made(self.evaluated.values[place])

    @property
    def history(self) -> pd.DataFrame:
        """A row an evaluation, see :meth:`fuzzy.tuning.search.Evaluations.table`."""
        return self.evaluated.table()


class TuningInterrupt(KeyboardInterrupt):
    """Ctrl-C while a law was tuned: :attr:`tuned` is what was found until then."""

    def __init__(self, tuned: Tuned) -> None:
        super().__init__(f"after {tuned.evaluations} evaluations")
        self.tuned = tuned


def tune(
    law: Law[Any] | str | LawSpace,
    scenarios: Sequence[Scenario | str | Path],
    *,
    specification: str = "",
    runs: int = RUNS,
    evaluations: int = _EVALUATIONS,
    seed: int = _SEED,
    engine: str = "cmaes",
    cost: Cost | None = None,
    pareto: bool = False,
    first_seed: int = TUNING,
    folder: Path | None = None,
    fresh: bool = False,
    threads: int | None = None,
    workers: Workers | None = None,
    progress: Callable[[Evaluations], bool | None] | None = None,
) -> Tuned:
    """Tune a law: look for the gains, and the rule bases, with which it costs least in the closed loop.

    Args:
        law: The law, or its specification, or a :class:`LawSpace`, which says what may move. What the runs say nothing
            of is held (:func:`reached`), unless the space says that it moves.
        scenarios: Scenarios, their names, or files.
        specification: That of the law, where a :class:`LawSpace` is given.
        runs: How many seeds each candidate drives on each scenario, the same for all.
        evaluations: How many candidates are tried, the law as it is included.
        seed: That of the search.
        engine: "cmaes" or "random".
        cost: What a run costs; by default that of :class:`Cost`.
        pareto: Whether to spread along the front of the cost's two objectives instead of making their sum smaller.
        first_seed: The first seed of the runs.
        folder: Where the search is written down after each generation, and goes on from if it was stopped.
        fresh: Whether to discard what the folder holds of a search.
        threads: How many threads share out the runs.
        workers: What runs parts of a generation elsewhere, by default this process; see
            :mod:`robotics.studies.executors`.
        progress: Called after each generation with all evaluations so far; True ends the search, and what is best then
            is the result.

    Returns:
        The tuned law, its cost before and after on the tuning runs, and all that was tried.

    Raises:
        TuningError: Nothing can be tuned so.
        ControllerError: As of :func:`robotics.simulate_many`.
        SimulationError: Likewise.
        TuningInterrupt: After Ctrl-C; a KeyboardInterrupt.
    """
    space = law if isinstance(law, LawSpace) else LawSpace(as_law(law))
    charged = cost or Cost()
    found = [s if isinstance(s, Scenario) else load_scenario(s) for s in scenarios]
    if not found:
        raise TuningError("at least one scenario is needed to tune on")
    if runs < 1:
        raise TuningError(f"runs must be a whole number >= 1; got {runs}")
    seeds = range(first_seed, first_seed + runs)
    if pareto and len(charged.objectives) != 2:
        raise TuningError(
            f"a front is looked for between two objectives; the cost has {', '.join(charged.objectives)}: give each "
            "term one of two"
        )
    space = reached(space, found, seeds)
    about = _about(space, law if isinstance(law, str) else specification, found, seeds, charged) | {
        "evaluations": evaluations,
        "seed": seed,
        "engine": "pareto" if pareto else engine,
    }

    def evaluate(values: np.ndarray) -> np.ndarray:
        """What candidates (candidates, parameters) cost: the mean (candidates, objectives) over scenarios and seeds.

        A candidate that is no law, or cannot drive, costs what a failed run costs: such as a gain that another one
        forbids.
        """
        laws: dict[int, Law[Any]] = {}
        for place, row in enumerate(values):
            try:
                laws[place] = space.made(row)
            except InputError:
                if len(values) == 1:
                    raise
        costs = np.full((len(values), len(charged.objectives)), charged.failed / len(charged.objectives))
        if workers is None:
            with suppress(ControllerError):  # of one that cannot drive; the others can
                costs[list(laws)] = mean_costs(charged, found, list(laws.values()), seeds, threads)
                return costs
        one = partial(_candidate_costs, charged, found, seeds, 1 if workers else threads, len(values) > 1)
        for (place, _), own in run_pieces(one, laws.items(), workers, called=lambda piece: f"candidate {piece[0] + 1}"):
            if own is not None:
                costs[place] = own
        return costs

    try:
        evaluated = resumable_search(
            evaluate,
            space.parameters,
            about=about,
            folder=folder,
            fresh=fresh,
            evaluations=evaluations,
            seed=seed,
            engine=about["engine"],
            names=charged.objectives,
            progress=progress,
        )
    except SearchInterrupt as stop:
        raise TuningInterrupt(Tuned(space, charged, stop.found, about)) from None
    return Tuned(space, charged, evaluated, about)


def reached(space: LawSpace, scenarios: Sequence[Scenario], seeds: Sequence[int]) -> LawSpace:
    """The same space with what the runs of its law say nothing of held, unless it says that this moves.

    A few seeds tell where rule bases are asked; the law is as it is before the search. Of a law that does not tell what
    it asks them (``Command.inputs``) nothing is held.
    """
    if space.unreached == "move" or not space.systems:
        return space
    law, few = space.law, list(seeds)[:_LOOKED_AT]
    with warnings.catch_warnings(action="ignore"):  # the rule base may be asked outside of its universe
        runs = [simulate(scenario, law, few) for scenario in scenarios]
    asked, first = {}, 0
    for name, fis in law.fuzzy_systems.items():
        count = len(fis.inputs)
        rows = [run.inputs[:, first : first + count] for run in runs if run.inputs is not None]
        points = np.concatenate([np.moveaxis(part, 1, -1).reshape(-1, count) for part in rows])
        asked[name], first = points[np.isfinite(points).all(axis=1)], first + count
    if not all(points.any() for points in asked.values()):  # inputs that are not told are recorded as 0
        return space
    return space.holding_unreached(asked)


def _candidate_costs(
    cost: Cost,
    scenarios: Sequence[Scenario],
    seeds: Sequence[int],
    threads: int | None,
    lenient: bool,
    candidate: tuple[int, Law[Any]],
) -> np.ndarray | None:
    """What a law, given with its place in a generation, costs; if that is ``lenient`` None where it cannot drive."""
    with suppress(ControllerError) if lenient else nullcontext():
        return mean_costs(cost, scenarios, [candidate[1]], seeds, threads)[0]
    return None


def mean_costs(
    cost: Cost,
    scenarios: Sequence[Scenario],
    laws: Sequence[Law[Any]],
    seeds: Sequence[int],
    threads: int | None = None,
) -> np.ndarray:
    """What laws cost in the mean over scenarios and seeds (laws, objectives); see :func:`costs_of`."""
    # A candidate may ask its rule base outside of the universe of discourse: that is what its cost says.
    with warnings.catch_warnings(action="ignore"):
        return np.asarray(costs_of(cost, scenarios, laws, seeds, threads).mean(axis=(1, 2)))


def _about(
    space: LawSpace, specification: str, scenarios: Sequence[Scenario], seeds: range, cost: Cost
) -> dict[str, Any]:
    """All that determines the result but the budget, as JSON can hold it."""
    return {
        "law": specification or type(space.law).__name__,
        "start": repr(space.law),
        "files": {name: digest_of(path) for name, path in files_of(specification).items()} if specification else {},
        "parameters": [
            {"name": p.name, "start": p.start, "low": p.lower, "high": p.upper, "scale": p.scale}
            | ({"choices": list(p.choices)} if p.choices else {})
            for p in space.parameters
        ],
        "scenarios": [s.name for s in scenarios],
        "scenario_contents": [repr(replace(s, name="")) for s in scenarios],
        "seeds": [seeds.start, seeds.stop - 1],
        "cost": cost.about(),
        "versions": versions(),
    }


def with_noise(scenario: Scenario) -> Scenario:
    """The scenario with postures measured as in a laboratory (3 mm, 3 mrad) if nothing in it is random."""
    return scenario if noises(scenario) else replace(scenario, sensing=LABORATORY)
