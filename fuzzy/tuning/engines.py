"""The engines of a search, all asked and told alike: CMA-ES of the package cmaes, and a random search of our own.

A ranking of what was tuned is safe only where two engines agree on it [Kégl 2023, arXiv 2311.15854]. Both start from
the parameters' own start, and are reproducible: the same seed and the same costs give the same points.

CMA-ES: [Hansen 2016, arXiv 1604.00772]; with choices CatCMA with margin [Hamano 2025, arXiv 2504.07884]. Its first
step is a tenth of the range between the bounds. Where it has converged before the budget is spent, it starts again from
the best point with twice as many points a generation [Auger and Hansen 2005].
"""

import math
import warnings
from abc import ABC, abstractmethod
from collections.abc import Callable, Sequence
from typing import Any

import numpy as np

from fuzzy.naming import check_known
from fuzzy.tuning.parameter import SearchParameter, TuningError, start_of

_STEP = 0.1  # of CMA-ES at first, in unit coordinates
_WORST = 1e250  # what CMA-ES is told of an infinite cost, with which it cannot count
_FRONT = 6  # places on a front that are looked for side by side
AFAR = 0.2  # of the points of the random search: anywhere
_NEAREST, _FARTHEST = 0.005, 0.3  # the steps of the others from the best, in unit coordinates


class Engine(ABC):
    """Asked for the points of a generation, and told their costs."""

    def __init__(self, parameters: Sequence[SearchParameter]) -> None:
        self.best, self.cost = start_of(parameters), math.inf  # unit coordinates of the best point so far, and its cost
        self.size = generation_size(len(parameters))
        self.counts = np.array([len(p.choices) for p in parameters])  # of what may be chosen; 0 of a number
        self.is_choice = self.counts > 0
        self.choices = self.counts[self.is_choice].tolist()

    def begin(self, cost: float) -> None:
        """Say the cost of the start."""
        self.cost = cost

    @abstractmethod
    def ask(self) -> np.ndarray:
        """The next points (points, parameters) in unit coordinates; choices are places."""

    @abstractmethod
    def tell(self, points: np.ndarray, objectives: np.ndarray) -> None:
        """Say the objectives (points, objectives) of the points that were asked for last."""

    def _keep(self, points: np.ndarray, costs: np.ndarray) -> None:
        place = int(np.argmin(costs))
        if costs[place] < self.cost:
            self.best, self.cost = points[place], float(costs[place])


class RandomSearch(Engine):
    """A fifth of the points anywhere, the others about the best so far, at steps of all sizes."""

    def __init__(self, parameters: Sequence[SearchParameter], seed: int) -> None:
        super().__init__(parameters)
        self.rng = np.random.default_rng(seed)

    def ask(self) -> np.ndarray:  # noqa: D102
        shape = self.size, len(self.best)
        anywhere = self.rng.random(shape)
        steps = _NEAREST * (_FARTHEST / _NEAREST) ** self.rng.random((self.size, 1))
        near = np.abs(self.best + steps * self.rng.standard_normal(shape))  # reflected at 0, and at 1
        near = np.clip(1 - np.abs(1 - near), 0.0, 1.0)
        afar = self.rng.random((self.size, 1)) < AFAR
        points = np.where(afar, anywhere, near)
        places = np.floor(self.rng.random(shape) * np.maximum(self.counts, 1))
        moved = afar | (self.rng.random(shape) < max(1 / shape[1], 0.1))
        return np.where(self.is_choice, np.where(moved, places, self.best), points)

    def tell(self, points: np.ndarray, objectives: np.ndarray) -> None:  # noqa: D102
        self._keep(points, objectives.sum(axis=1))


class CmaEs(Engine):
    """CMA-ES; with choices, CatCMA with margin."""

    def __init__(self, parameters: Sequence[SearchParameter], seed: int) -> None:
        super().__init__(parameters)
        import cmaes

        self.cmaes, self.seed, self.starts = cmaes, seed, 0
        self._start()

    def _start(self) -> None:
        seed = int(np.random.SeedSequence([self.seed, self.starts]).generate_state(1)[0])
        size, numbers = self.size * 2**self.starts, self.best[~self.is_choice]
        bounds = np.tile([0.0, 1.0], (len(numbers), 1))
        inside = np.clip(numbers, 0.01, 0.99)  # CMA-ES starts between its bounds, not on them
        self.asked: list[Any] = []
        if self.choices:
            self.engine: Any = _mixed(self.cmaes, inside, self.choices, self.best[self.is_choice], size, seed)
        else:
            self.engine = self.cmaes.CMA(mean=inside, sigma=_STEP, bounds=bounds, seed=seed, population_size=size)

    def ask(self) -> np.ndarray:  # noqa: D102
        with warnings.catch_warnings(action="ignore", category=RuntimeWarning):
            self.asked = [self.engine.ask() for _ in range(self.engine.population_size)]
        return _points(self.asked, self.is_choice) if self.choices else np.array(self.asked)

    def tell(self, points: np.ndarray, objectives: np.ndarray) -> None:  # noqa: D102
        costs = objectives.sum(axis=1)
        self._keep(points, costs)
        finite = np.minimum(costs, _WORST)
        with warnings.catch_warnings(action="ignore", category=RuntimeWarning):
            self.engine.tell(list(zip(self.asked, finite.tolist(), strict=True)))
            stopped = not self.is_choice.all() and self.engine.should_stop()
        if stopped:
            self.starts += 1
            self._start()


class ParetoCmaEs(Engine):
    """Several of CatCMA with margin side by side, which spread along a front of two objectives: COMO-CatCMA.

    [Toure 2019, arXiv 1904.08823], [Hamano 2025].
    """

    def __init__(self, parameters: Sequence[SearchParameter], seed: int) -> None:
        super().__init__(parameters)
        import cmaes

        rng, numbers = np.random.default_rng(seed), self.best[~self.is_choice]
        seeds = np.random.SeedSequence(seed).generate_state(_FRONT + 1)
        kernels = []
        for own in seeds[:_FRONT]:
            inside = np.clip(numbers + _STEP * rng.standard_normal(len(numbers)), 0.01, 0.99)
            kernels.append(_mixed(cmaes, inside, self.choices, self.best[self.is_choice], self.size, int(own)))
        spaces: dict[str, Any] = {"x_space": np.tile([0.0, 1.0], (len(numbers), 1))} if len(numbers) else {}
        spaces |= {"c_space": self.choices} if self.choices else {}
        self.engine = cmaes.COMOCatCMAwM(**spaces, kernels=kernels, seed=int(seeds[_FRONT]))
        self.asked: list[Any] = []

    def ask(self) -> np.ndarray:  # noqa: D102
        self.asked = list(self.engine.ask_iter())
        return _points(self.asked, self.is_choice)

    def tell(self, points: np.ndarray, objectives: np.ndarray) -> None:  # noqa: D102
        if objectives.shape[1] != 2:
            raise TuningError(f"a front is looked for between two objectives; the cost has {objectives.shape[1]}")
        finite = np.minimum(objectives, _WORST)
        self.engine.tell([(one, row.tolist()) for one, row in zip(self.asked, finite, strict=True)])


def _mixed(cmaes: Any, numbers: np.ndarray, choices: list[int], places: np.ndarray, size: int, seed: int) -> Any:
    """CatCMA with margin about numbers (n,) and the ``places`` of choices: half of what it draws at first are these.

    It leans towards what is known to work, for a rule base whose rules are drawn at random does nothing.
    """
    spaces: dict[str, Any] = {}
    if len(numbers):
        spaces |= {"x_space": np.tile([0.0, 1.0], (len(numbers), 1)), "mean": numbers, "sigma": _STEP}
    if choices:
        leaning = np.zeros((len(choices), max(choices)))
        for row, count, place in zip(leaning, choices, places, strict=True):
            row[:count] = 0.5 / count
            row[int(place)] += 0.5
        spaces |= {"c_space": choices, "cat_param": leaning}
    return cmaes.CatCMAwM(**spaces, population_size=size, seed=seed)


def _points(asked: list[Any], is_choice: np.ndarray) -> np.ndarray:
    """The points (points, parameters) of solutions of CatCMA."""
    points = np.empty((len(asked), len(is_choice)))
    for row, one in zip(points, asked, strict=True):
        if not is_choice.all():
            row[~is_choice] = one.x
        if is_choice.any():
            row[is_choice] = [int(np.argmax(which)) for which in one.c]
    return points


ENGINES: dict[str, Callable[[Sequence[SearchParameter], int], Engine]] = {
    "cmaes": CmaEs,
    "random": RandomSearch,
    "pareto": ParetoCmaEs,
}


def engine_of(name: str, parameters: Sequence[SearchParameter], seed: int) -> Engine:
    """The engine of that name for a search. Raises TuningError for an unknown one."""
    check_known(name, ENGINES, "engine", TuningError)
    return ENGINES[name](parameters, seed)


def generation_size(parameters: int) -> int:
    """The number of points of a generation: 4 + 3 ln n [Hansen 2016], and an even one, which two threads share."""
    size = 4 + int(3 * math.log(max(parameters, 1)))
    return size + size % 2
