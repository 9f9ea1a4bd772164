"""Tuning a system on data: a search towards the least error, through the inference and nothing else.

It needs no gradient and no linearity, so it moves what learning cannot: which consequent a rule takes, weights of
rules, memberships that stay ordered and covering. Where only consequents move, least squares finds the optimum at once
(:func:`fuzzy.fit_consequents`); where all of a network's numbers move, ``anfis.train`` is the quicker one.
"""

import warnings
from collections.abc import Callable, Collection, Sequence
from dataclasses import dataclass, field
from hashlib import sha256
from pathlib import Path
from typing import Any

import numpy as np

from fuzzy.compiled.sugeno import outputs_of
from fuzzy.detached import detached
from fuzzy.files.fisfile import format_fis
from fuzzy.fitting.clustering import finite_table
from fuzzy.fitting.consequents import IdentificationError, least_squares, output_table
from fuzzy.fitting.folds import FoldOrder, fold_rows
from fuzzy.inference import InferenceWarning, forgiving
from fuzzy.system import Linear, Sugeno
from fuzzy.tuning.journal import SearchInterrupt, resumable_search
from fuzzy.tuning.parameter import TuningError
from fuzzy.tuning.search import Evaluations
from fuzzy.tuning.systemspace import MOVED, SystemSpace

_EVALUATIONS = 1000  # of the cost, at most
_SEED = 1  # of the search
Progress = Callable[[Evaluations], bool | None]


@dataclass(frozen=True, eq=False)
class TunedSystem:
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

    system: Sugeno
    before: float
    after: float
    check_before: float
    check_after: float
    space: SystemSpace = field(repr=False)
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
    tuned: TunedSystem


def tune(
    fis: Sugeno,
    x: Any,
    y: Any,
    *,
    move: Collection[str] = MOVED,
    solve: bool = False,
    symmetric: bool = False,
    evaluations: int = _EVALUATIONS,
    seed: int = _SEED,
    engine: str = "cmaes",
    check: tuple[Any, Any] | None = None,
    folder: Path | None = None,
    fresh: bool = False,
    progress: Progress | None = None,
) -> TunedSystem:
    """Look for the parameters of ``fis`` with which it errs least at the data.

    Args:
        fis: The system to start from.
        x: The inputs (samples, inputs).
        y: The outputs (samples,) or (samples, outputs).
        move: What may move: "memberships", "consequents", "weights", "choices" of consequents, "rules" on and off.
        solve: Whether the consequents of every candidate are solved for by least squares, instead of moving: with
            memberships that move this is by far the best use of a budget [Golub & Pereyra 1973, variable projection].
        symmetric: Whether a system that answers to the left as to the right keeps that symmetry.
        evaluations: How many systems are tried, the one as it is included.
        seed: That of the search.
        engine: "cmaes" or "random".
        check: Data in the form of ``x`` and ``y`` that are not tuned on, and choose among the systems that were the
            best so far.
        folder: Where the search is written down after each generation, and goes on from if it was stopped.
        fresh: Whether to discard what the folder holds of a search.
        progress: Called after each generation with all evaluations so far; True ends the search.

    Constants of consequents move within the outputs' range in the data about their start at least, slopes within that
    range over the inputs'. Where no rule fires the middle of the output's range stands, and its error counts.

    Ctrl-C ends with the best so far. The same data, options and seed give the same result.

    Returns:
        The tuned system, its errors before and after, and all that was tried.

    Raises:
        TuningError: Nothing can be tuned so.
        InputError: Data that do not fit the system.
    """
    fis = detached(fis)
    x, y = _samples(fis, x, y)
    checking = _samples(fis, *check) if check is not None else None
    moving = tuple(part for part in move if not (solve and part == "consequents"))
    space = SystemSpace(fis, moving, symmetric, reach=_reach(fis, x, y))
    about = {
        "system": sha256(format_fis(fis).encode()).hexdigest(),
        "data": sha256(x.tobytes() + y.tobytes()).hexdigest(),
        "move": sorted(moving),
        "solve": solve,
        "symmetric": symmetric,
        "evaluations": evaluations,
        "seed": seed,
        "engine": engine,
    }

    def made(row: np.ndarray) -> Sugeno:
        return least_squares(space.made(row), x, y).fis if solve else space.made(row)

    def error(row: np.ndarray) -> float:
        try:
            return rmse(made(row), x, y)
        except IdentificationError:  # no rule fires at any sample
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
    fis: Sugeno,
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
        fis: The system to start from.
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


def rmse(fis: Sugeno, x: np.ndarray, y: np.ndarray) -> float:
    """The root mean square error of ``fis`` at ``x`` (samples, inputs) against ``y`` (samples, outputs).

    Nothing is said of inputs outside their universes; where no rule fires the middle of the output's range stands.
    """
    with warnings.catch_warnings(action="ignore", category=InferenceWarning), np.errstate(all="ignore"):
        return float(np.sqrt(np.mean((outputs_of(forgiving(fis, "midrange"), x) - y) ** 2)))


def _samples(fis: Sugeno, x: Any, y: Any) -> tuple[np.ndarray, np.ndarray]:
    """``x`` (samples, inputs) and ``y`` (samples, outputs) if they and the system fit together."""
    x, y = finite_table(x, "x"), output_table(y)
    if x.shape[1] != len(fis.inputs) or y.shape[1] != len(fis.outputs) or len(x) != len(y):
        raise TuningError(
            f"{fis.name} has {len(fis.inputs)} inputs and {len(fis.outputs)} outputs; x has the shape {x.shape} and y "
            f"{y.shape}"
        )
    if not fis.rules:
        raise TuningError(f"{fis.name} has no rules, so there is nothing to tune")
    return x, y


def _reach(fis: Sugeno, x: np.ndarray, y: np.ndarray) -> np.ndarray:
    """How far slopes and constants (outputs, inputs + 1) may move at least, by the ranges of the data."""
    across = np.ptp(x, axis=0)
    across[across == 0] = np.inf
    # A plane through the data has a constant that grows with their distance from 0.
    distance = 1 + float((np.abs(x).max(axis=0) / across).sum())
    rows = []
    for variable, spread in zip(fis.outputs, np.ptp(y, axis=0).tolist(), strict=True):
        linear = any(isinstance(term, Linear) for term in variable.terms.values())
        rows.append([*(spread / across), spread * (distance if linear else 1.0)])
    return np.array(rows)


def _records(costs: np.ndarray) -> Sequence[int]:
    """The places that were the best so far."""
    best = np.minimum.accumulate(costs)
    return [0, *(k for k in range(1, len(costs)) if best[k] < best[k - 1])]
