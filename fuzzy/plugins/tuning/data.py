"""Tuning a system, a tree or a type-2 system on data: a search towards the least error, through the inference alone.

It needs no gradient and no linearity, so it moves what learning cannot: which consequent a rule takes, weights of
rules, memberships that stay ordered and covering. Where only consequents move, least squares finds the optimum at once
(:func:`fuzzy.fit_consequents`); where all of a network's numbers move, ``anfis.train`` is the quicker one.
"""

import warnings
from collections.abc import Callable, Collection, Sequence
from dataclasses import dataclass, field
from hashlib import sha256
from pathlib import Path
from typing import Any, Generic

import numpy as np

from fuzzy.detached import detached
from fuzzy.fitting.clustering import finite_table
from fuzzy.fitting.consequents import IdentificationError, least_squares, output_table
from fuzzy.fitting.folds import FoldOrder, fold_rows
from fuzzy.inference import InferenceWarning
from fuzzy.plugins.trees.tree import Tree
from fuzzy.plugins.tuning.spaces import System, answers_of, digest, systems_of
from fuzzy.plugins.type2.system import Type2Sugeno
from fuzzy.system import FuzzySystemError, Sugeno
from fuzzy.tuning.journal import SearchInterrupt, resumable_search
from fuzzy.tuning.parameter import TuningError
from fuzzy.tuning.search import Evaluations
from fuzzy.tuning.systemspace import MOVED, search_space

_EVALUATIONS = 1000  # of the cost, at most
_SEED = 1  # of the search
Progress = Callable[[Evaluations], bool | None]


@dataclass(frozen=True, eq=False)
class TunedSystem(Generic[System]):
    """What tuning on data has found. Errors are root mean squares over samples and outputs, in the outputs' unit.

    Attributes:
        system: The system of least error on the data; with checking data, that of least error on these among all that
            were the best so far.
        before: The error of the system as it was.
        after: The error of ``system``.
        check_before: Likewise on the checking data; not-a-number without.
        check_after: Likewise of ``system``.
        space: What could move, and from where to where.
        evaluated: All that was tried.
        stopped: Why: "evaluations", "progress" or "interrupted".
    """

    system: System
    before: float
    after: float
    check_before: float
    check_after: float
    space: Any = field(repr=False)
    evaluated: Evaluations = field(repr=False)
    stopped: str

    @property
    def evaluations(self) -> int:
        """How many systems were tried, the system as it was included."""
        return len(self.evaluated)

    def table(self) -> Any:
        """A row an evaluation as a pandas table: its error, the least so far, every parameter."""
        return self.evaluated.table()


@dataclass(frozen=True, eq=False)
class TunedFold:
    """One fold of a cross-validation of tuning."""

    held: np.ndarray  # (held,) int: the rows that were not tuned on, ascending
    before: float  # the error on them of the system as it was
    after: float  # and of the one that was tuned on the others
    tuned: TunedSystem[Any]


def tune(
    fis: System,
    x: Any,
    y: Any,
    *,
    move: Collection[str] | None = None,
    solve: bool = False,
    symmetric: bool = False,
    evaluations: int = _EVALUATIONS,
    seed: int = _SEED,
    engine: str = "cmaes",
    check: tuple[Any, Any] | None = None,
    folder: Path | None = None,
    fresh: bool = False,
    progress: Progress | None = None,
) -> TunedSystem[System]:
    """Look for the parameters of ``fis`` with which it errs least at the data.

    Args:
        fis: The system to start from, or a tree of systems, or an interval type-2 system.
        x: The inputs (samples, inputs).
        y: The outputs (samples,) or (samples, outputs).
        move: What may move: "memberships", "consequents", "weights", "choices" of consequents, "rules" on and off; of a
            type-2 system also "footprints", the scales and lags of lower functions. By default memberships and
            consequents, and footprints.
        solve: Whether the consequents of every candidate are solved for by least squares, instead of moving: with
            memberships that move this is by far the best use of a budget [Golub & Pereyra 1973, variable projection].
            Not of trees and of type-2 systems, whose answers are not linear in them.
        symmetric: Whether a system that answers to the left as to the right keeps that symmetry; of a tree each of its
            systems.
        evaluations: How many systems are tried, the one as it is included.
        seed: That of the search.
        engine: "cmaes" or "random".
        check: Data in the form of ``x`` and ``y`` that are not tuned on, and choose among the systems that were the
            best so far.
        folder: Where the search is written down after each generation, and goes on from if it was stopped.
        fresh: Whether to discard what the folder holds of a search.
        progress: Called after each generation with all evaluations so far; True ends the search.

    Constants of consequents move within the outputs' range in the data about their start at least, slopes within that
    range over the inputs'; between the systems of a tree their universe counts. Where no rule fires the middle of the
    output's range stands, and its error counts.

    Ctrl-C ends with the best so far. The same data, options and seed give the same result.

    Returns:
        The tuned system, its errors before and after, and all that was tried.

    Raises:
        TuningError: Nothing can be tuned so.
        InputError: Data that do not fit the system.
    """
    if solve and not isinstance(fis, Sugeno):
        raise TuningError(f"solve: in {fis.name}, a {type(fis).__name__}, consequents do not follow by least squares")
    fis = detached(fis)
    x, y = _samples(fis, x, y)
    checking = _samples(fis, *check) if check is not None else None
    moving = [part for part in move or MOVED if part != "consequents"] if solve else move
    space = search_space(fis, moving or None, symmetric, (x, y))
    about = {
        "system": digest(fis),
        "data": sha256(x.tobytes() + y.tobytes()).hexdigest(),
        "move": sorted(space.move),
        "solve": solve,
        "symmetric": symmetric,
        "evaluations": evaluations,
        "seed": seed,
        "engine": engine,
    }

    def made(row: np.ndarray) -> Any:
        return least_squares(space.made(row), x, y).fis if solve else space.made(row)

    def error(row: np.ndarray) -> float:
        try:
            return rmse(made(row), x, y)
        except (IdentificationError, FuzzySystemError):  # no rule fires at any sample; two lags make a step
            return float("inf")

    try:
        found = resumable_search(
            lambda values: np.array([error(row) for row in values]),
            space.parameters,
            about=about,
            folder=folder,
            fresh=fresh,
            evaluations=evaluations,
            seed=seed,
            engine=engine,
            progress=progress,
        )
        stopped = "evaluations" if len(found) >= evaluations else "progress"
    except SearchInterrupt as stop:
        found, stopped = stop.found, "interrupted"
    place, checks = found.best, dict[int, float]()
    if checking is not None:  # of all that were the best so far the one of least checking error
        checks = {k: rmse(made(found.values[k]), *checking) for k in _records(found.costs)}
        place = min(checks, key=lambda k: (checks[k], k))
    system, nothing = made(found.values[place]), float("nan")
    return TunedSystem(
        system,
        rmse(fis, x, y),
        rmse(system, x, y),
        checks.get(0, nothing),
        checks.get(place, nothing),
        space,
        found,
        stopped,
    )


def cross_validate_tuning(
    fis: Sugeno | Tree | Type2Sugeno,
    x: Any,
    y: Any,
    *,
    folds: int = 5,
    order: FoldOrder = "shuffled",
    seed: int = _SEED,
    folder: Path | None = None,
    progress: Callable[[int, Evaluations], bool | None] | None = None,
    **options: Any,
) -> tuple[TunedFold, ...]:
    """Tune ``folds`` times, each time without one part of the samples, and measure the error on that part.

    Args:
        fis: The system to start from, of any kind.
        x: The inputs (samples, inputs).
        y: The outputs (samples,) or (samples, outputs).
        folds: How many parts there are, at least 2.
        order: "shuffled", or "blocks" of neighbouring rows for time series.
        seed: That of the searches and of the shuffling.
        folder: As for :func:`tune`; each fold has a folder of its own in it.
        progress: Called with the number of the fold (from 0) and its evaluations so far.
        options: The others of :func:`tune`.

    Raises FoldError where no folds can be made, TuningError and InputError as :func:`tune` does, and KeyboardInterrupt
    when it is interrupted: some of the folds are not an answer.
    """
    x, y = _samples(fis, x, y)
    found = []
    for k, held in enumerate(fold_rows(len(x), folds, order, seed)):
        rest = np.delete(np.arange(len(x)), held)
        told = None if progress is None else lambda evaluated, k=k: progress(k, evaluated)
        own = None if folder is None else folder / f"fold-{k + 1}"
        tuned = tune(fis, x[rest], y[rest], seed=seed, folder=own, progress=told, **options)
        if tuned.stopped == "interrupted":
            raise KeyboardInterrupt
        found.append(TunedFold(held, rmse(fis, x[held], y[held]), rmse(tuned.system, x[held], y[held]), tuned))
    return tuple(found)


def rmse(fis: Sugeno | Tree | Type2Sugeno, x: np.ndarray, y: np.ndarray) -> float:
    """The root mean square error of ``fis`` at ``x`` (samples, inputs) against ``y`` (samples, outputs).

    Nothing is said of inputs outside their universes; where no rule fires the middle of the output's range stands.
    """
    with warnings.catch_warnings(action="ignore", category=InferenceWarning), np.errstate(all="ignore"):
        return float(np.sqrt(np.mean((answers_of(fis, x) - y) ** 2)))


def _samples(fis: Sugeno | Tree | Type2Sugeno, x: Any, y: Any) -> tuple[np.ndarray, np.ndarray]:
    """``x`` (samples, inputs) and ``y`` (samples, outputs) if they and the system fit together."""
    x, y = finite_table(fis.point(x) if isinstance(fis, Tree) else x, "x"), output_table(y)
    if x.shape[1] != len(fis.inputs) or y.shape[1] != len(fis.outputs) or len(x) != len(y):
        raise TuningError(
            f"{fis.name} has {len(fis.inputs)} inputs and {len(fis.outputs)} outputs; x has the shape {x.shape} and y "
            f"{y.shape}"
        )
    if not any(each.rules for each in systems_of(fis)):
        raise TuningError(f"{fis.name} has no rules, so there is nothing to tune")
    return x, y


def _records(costs: np.ndarray) -> Sequence[int]:
    """The places that were the best so far."""
    best = np.minimum.accumulate(costs)
    return [0, *(k for k in range(1, len(costs)) if best[k] < best[k - 1])]
