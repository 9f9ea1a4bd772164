"""NSGA-II over the genes of rules, by pymoo, which this module imports."""

from collections.abc import Callable
from typing import Any

import numpy as np
from pymoo.algorithms.moo.nsga2 import NSGA2
from pymoo.config import Config
from pymoo.core.callback import Callback
from pymoo.core.crossover import Crossover
from pymoo.core.mutation import Mutation
from pymoo.core.problem import Problem
from pymoo.optimize import minimize

from fuzzy.plugins.front.space import RuleSpace

_POPULATION = 60
_EMPTIED = 0.5  # of the mutated conditions so many are left out
_REPLACED = 0.05  # of the rules so many are made anew


def evolved(
    space: RuleSpace, generations: int, seed: int, progress: Callable[[int, int], None] | None
) -> list[np.ndarray]:
    """The genes (genes,) int of the candidates that no other one found beats in both objectives."""
    Config.warnings["not_compiled"] = False
    rng = np.random.default_rng(seed)
    algorithm = NSGA2(
        _POPULATION,
        sampling=np.array([_fresh(space, rng) for _ in range(_POPULATION)]),
        crossover=_RulesSwap(len(space.data.inputs)),
        mutation=_Mutation(space, rng),
        eliminate_duplicates=True,
    )
    shown = _Counting(generations, progress)
    result = minimize(_Problem(space), algorithm, ("n_gen", generations), seed=seed, callback=shown, verbose=False)
    return [row.astype(int) for row in np.atleast_2d(result.X)]


def _fresh(space: RuleSpace, rng: np.random.Generator) -> np.ndarray:
    """Genes at random, their rules from samples."""
    n = len(space.data.inputs)
    genes = rng.integers(0, space.upper + 1)
    rows = genes[n + 1 :].reshape(space.rules, n)
    rows[:] = 0
    for row in rows[: rng.integers(1, space.rules + 1)]:
        row[:] = space.sprout(rng, genes)
    return genes


class _Problem(Problem):
    def __init__(self, space: RuleSpace):
        super().__init__(n_var=len(space.upper), n_obj=2, xl=0, xu=space.upper, vtype=int)
        self.space = space

    def _evaluate(self, x: np.ndarray, out: dict[str, Any], *_: Any, **__: Any) -> None:
        out["F"] = np.array([self.space.objectives(self.space.candidate(row.astype(int))) for row in x])


class _RulesSwap(Crossover):
    """Two parents exchange whole rules, and how many terms an input has."""

    def __init__(self, inputs: int):
        super().__init__(2, 2)
        self.inputs = inputs

    def _do(self, problem: Any, x: np.ndarray, *_: Any, random_state: Any = None, **__: Any) -> np.ndarray:
        head = self.inputs + 1
        whole = random_state.random((x.shape[1], (x.shape[2] - head) // self.inputs)) < 0.5
        swap = np.concatenate(
            [random_state.random((x.shape[1], head)) < 0.5, np.repeat(whole, self.inputs, axis=1)], axis=1
        )
        return np.where(swap, x[::-1], x)


class _Mutation(Mutation):
    """One gene in a candidate changes on average, of a rule often to nothing; some rules come anew from samples."""

    def __init__(self, space: RuleSpace, rng: np.random.Generator):
        super().__init__()
        self.space, self.rng = space, rng

    def _do(self, problem: Any, x: np.ndarray, *_: Any, **__: Any) -> np.ndarray:
        space, rng = self.space, self.rng
        x = x.astype(int)
        n = len(space.data.inputs)
        changed = rng.random(x.shape) < 1 / x.shape[1]
        drawn = rng.integers(0, space.upper + 1, x.shape)
        drawn[:, n + 1 :][rng.random(drawn[:, n + 1 :].shape) < _EMPTIED] = 0
        x = np.where(changed, drawn, x)
        for genes in x:
            for row in genes[n + 1 :].reshape(space.rules, n):
                if rng.random() < _REPLACED:
                    row[:] = space.sprout(rng, genes) if rng.random() < 0.5 else 0
        return x


class _Counting(Callback):
    def __init__(self, generations: int, progress: Callable[[int, int], None] | None):
        super().__init__()
        self.generations, self.progress = generations, progress

    def notify(self, algorithm: Any) -> None:
        if self.progress is not None:
            self.progress(algorithm.n_gen, self.generations)
