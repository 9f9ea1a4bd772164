"""Intervals on what a learnt system says, from samples that it was not learnt from: conformal prediction.

An interval of level 0.9 holds the true output of at least 90 % of new samples, however wrong the system and whatever
the noise, if new samples are drawn as the held-back ones were (they are exchangeable): on average over samples, not for
each. Split conformal [Vovk 2005, Lei 2018] takes samples that were held back. CV+, the jackknife+ by folds
[Barber 2021], takes the folds of a cross-validation, where every sample is held back once; what it guarantees is 80 %
for 0.9, what it gives is near 90 %.
"""

import math
from dataclasses import dataclass
from typing import Any

import numpy as np

from anfis.data import DataError
from anfis.folds import CrossValidation
from fuzzy.fitting.clustering import finite_table
from fuzzy.fitting.consequents import output_table
from fuzzy.inference import infer_quietly
from fuzzy.system import Sugeno

OUTLYING = 0.01  # a sample is outside the data if so few of the data lie as far from their neighbours


@dataclass(frozen=True, eq=False)
class PredictionInterval:
    """Between which values the outputs are.

    Attributes:
        low: (samples, outputs), in the outputs' units; −inf where there are too few held-back samples for the level.
        high: (samples, outputs), likewise; inf there.
    """

    low: np.ndarray
    high: np.ndarray


@dataclass(frozen=True, eq=False)
class Conformal:
    """What held-back samples tell of a system's errors.

    Attributes:
        systems: One system, or those of the folds.
        learnt: (samples,) int: of which of them each sample was held back.
        errors: (samples, outputs) |y − predicted|, in the outputs' units.
        inputs: (samples, inputs) of these samples.
    """

    systems: tuple[Sugeno, ...]
    learnt: np.ndarray
    errors: np.ndarray
    inputs: np.ndarray

    def interval(self, x: Any, level: float = 0.9) -> PredictionInterval:
        """The interval of the outputs at other inputs, which holds a share of new samples.

        Args:
            x: The inputs (samples, inputs).
            level: The share, between 0 and 1.

        Raises:
            DataError: Another level.
            ClusteringError: Inputs that are not finite numbers.
        """
        if not 0 < level < 1:
            raise DataError(f"the level of an interval must be between 0 and 1, such as 0.9; got {level:g}")
        said = [infer_quietly(fis, finite_table(x, "x")).output for fis in self.systems]
        count = len(self.errors)
        # The k-th smallest of n counts from 1; rounding is no reason to take another one
        rank = math.ceil((count + 1) * level - 1e-9)
        ends = []
        for sign in (-1, 1):
            if rank > count:
                ends.append(np.full(said[0].shape, sign * np.inf))
            elif len(said) == 1:
                ends.append(said[0] + sign * np.sort(self.errors, axis=0)[rank - 1])
            else:
                own = [self.errors[self.learnt == k] for k in range(len(said))]
                ends.append(sign * _ranked([sign * f for f in said], own, rank))
        return PredictionInterval(*ends)

    def outside(self, x: Any) -> np.ndarray:
        """Whether other inputs lie outside the data (samples,) bool.

        The density is that of the distance to the k-th nearest of the held-back samples, k = √samples, in ranges of
        the inputs [Loftsgaarden 1965]; outside is where at most 1 % of these samples (or none) are as far from theirs.

        Args:
            x: The inputs (samples, inputs).

        Raises:
            ClusteringError: Inputs that are not finite numbers.
        """
        from scipy.spatial import cKDTree

        spread = np.ptp(self.inputs, axis=0)
        scale = np.where(spread > 0, spread, 1.0)
        tree, k = cKDTree(self.inputs / scale), min(max(1, round(math.sqrt(len(self.inputs)))), len(self.inputs) - 1)
        own = tree.query(self.inputs / scale, k=[k + 1])[0][:, 0]  # the nearest is itself
        far = tree.query(finite_table(x, "x") / scale, k=[max(k, 1)])[0][:, 0]
        as_far = len(own) - np.searchsorted(np.sort(own), far)
        return np.asarray(as_far <= OUTLYING * len(own))


def _ranked(said: list[np.ndarray], errors: list[np.ndarray], rank: int) -> np.ndarray:
    """The rank-th smallest of all said + error, of each sample and output, without a table of all of them."""
    out = np.empty_like(said[0])
    for i, j in np.ndindex(out.shape):
        sums = np.concatenate([f[i, j] + e[:, j] for f, e in zip(said, errors, strict=True)])
        out[i, j] = np.partition(sums, rank - 1)[rank - 1]
    return out


def calibrate(system: Sugeno | CrossValidation, x: Any, y: Any) -> Conformal:
    """Learn from samples how far a system is off, for intervals around its outputs: split conformal, or CV+.

    Args:
        system: A system, which was not learnt from these samples (nor stopped or chosen by them); or the folds of
            :func:`anfis.cross_validate` on just these samples, each of which some fold held back.
        x: The inputs (samples, inputs).
        y: The outputs (samples,) or (samples, outputs).

    Returns:
        Their errors, which give the intervals.

    Raises:
        DataError: Numbers of rows or columns that do not suit, or rows for which the system says nothing.
        ClusteringError: Values that are not finite numbers.
    """
    x, y = finite_table(x, "x"), output_table(y)
    systems = tuple(fold.training.system for fold in system.folds) if isinstance(system, CrossValidation) else (system,)
    learnt = np.zeros(len(x), dtype=int)
    if isinstance(system, CrossValidation):
        held = np.concatenate([fold.held for fold in system.folds])
        if len(held) != len(x):
            raise DataError(f"the folds held back {len(held)} samples; got {len(x)}: give those they were made of")
        for k, fold in enumerate(system.folds):
            learnt[fold.held] = k
    shape = len(x), len(systems[0].outputs)
    if x.shape[1] != len(systems[0].inputs) or y.shape != shape:
        raise DataError(
            f"the samples must be ({len(x)}, {len(systems[0].inputs)}) inputs and {shape} outputs of the system; got "
            f"{x.shape} and {y.shape}"
        )
    if len(x) < 2:
        raise DataError("two samples are the least that tell of errors")
    errors = np.empty(y.shape)
    for k, fis in enumerate(systems):
        errors[learnt == k] = np.abs(infer_quietly(fis, x[learnt == k]).output - y[learnt == k])
    if not np.isfinite(errors).all():
        row = int(np.argwhere(~np.isfinite(errors))[0, 0])
        raise DataError(f"the system says nothing in row {row + 1} of the samples, where no rule fires")
    return Conformal(systems, learnt, errors, x)
