"""The consequents of a Sugeno system by least squares: with given antecedents the output is linear in them."""

import warnings
from collections.abc import Sequence
from dataclasses import replace
from typing import Any, NamedTuple

import numpy as np

from fuzzy.detached import detached
from fuzzy.errors import InputError
from fuzzy.fitting.clustering import DataWarning, finite_table
from fuzzy.inference import InferenceWarning, infer
from fuzzy.system import Consequent, Constant, Linear, Sugeno

_LARGEST = 100_000_000  # numbers in the equations, at most: 0.8 GB


class IdentificationError(InputError):
    """Data or settings that identify no system. The message names the row, the column or the setting."""


class Fit(NamedTuple):
    """A fitted system and how well the samples determine it."""

    fis: Sugeno
    rmse: np.ndarray  # (outputs,) root mean square error at the samples where a rule fires, in the output's unit
    parameters: int  # of all consequents
    rank: int  # how many of them the samples determine
    silent: int  # samples where no rule fires for some output


def fit_consequents(fis: Sugeno, x: Any, y: Any, ridge: float = 0.0) -> Sugeno:
    """``fis`` with the consequents that fit ``y`` (samples,) or (samples, outputs) at ``x`` (samples, inputs) best.

    One global least squares for each output: the columns are the normalised firing strengths w̄ (the firing strengths
    w for wtsum) times [x 1], or times 1 for a constant [Jang 1993, (17); MATLAB genfis2]. The orders of the
    consequents, their names and who shares them stay; a consequent that no rule uses stays as it is.

    Where the samples do not determine the consequents the solution of least norm is taken. ``ridge`` >= 0, without a
    unit, adds ridge · |θ|² to the mean square error. Norms are measured with the inputs scaled to [−1, 1] and the
    outputs less their mean, so that they do not depend on units.

    Warns (DataWarning) of a rank that is too low, with the rank, and of samples where no rule fires, which do not
    count. Raises ClusteringError for values that are not finite, IdentificationError for shapes that do not fit.
    """
    fitted = least_squares(fis, x, y, ridge)
    if fitted.silent:
        warnings.warn(
            f"no rule fires at {fitted.silent} of {len(np.asarray(x))} samples: they do not count",
            DataWarning,
            stacklevel=2,
        )
    say_rank(fitted, len(np.asarray(x)))
    return fitted.fis


def say_rank(fitted: Fit, samples: int) -> None:
    """Warn (DataWarning) where the samples do not determine all parameters."""
    if fitted.rank < fitted.parameters:
        warnings.warn(
            f"the {samples} samples determine {fitted.rank} of {fitted.parameters} parameters of the consequents "
            "(the rank); the solution of least norm is taken. Fewer rules, order 0 or ridge > 0 helps",
            DataWarning,
            stacklevel=3,
        )


def least_squares(fis: Sugeno, x: Any, y: Any, ridge: float = 0.0) -> Fit:
    """As :func:`fit_consequents`, which see, with the error and the rank instead of warnings."""
    fis = detached(fis)
    x = finite_table(x, "x", [v.name for v in fis.inputs] if np.shape(x)[1:] == (len(fis.inputs),) else None)
    y = output_table(y, [v.name for v in fis.outputs])
    if x.shape[1] != len(fis.inputs) or y.shape[1] != len(fis.outputs):
        raise IdentificationError(
            f"{fis.name} has {len(fis.inputs)} inputs and {len(fis.outputs)} outputs; "
            f"x has {x.shape[1]} columns and y {y.shape[1]}"
        )
    if len(x) != len(y):
        raise IdentificationError(f"x has {len(x)} samples, y {len(y)}")
    if not (isinstance(ridge, (int, float)) and np.isfinite(ridge) and ridge >= 0):
        raise IdentificationError(f"ridge must be a finite number >= 0, got {ridge!r}")
    if not fis.rules:
        raise IdentificationError(f"{fis.name} has no rules, so there are no consequents to fit")
    for output, place in zip(fis.outputs, fis.structure.consequent, strict=True):
        count = sum(len(term.parameters) for t, term in enumerate(output.terms.values()) if (place == t).any())
        if count * len(x) > _LARGEST:
            raise IdentificationError(
                f"{len(x)} samples and {count} parameters of {output.name} are too large a system of equations; "
                "take fewer rules or fewer samples"
            )
    shares, fired = _shares(fis, x)
    if fis.out_of_range == "clip":
        x = np.clip(x, [v.universe[0] for v in fis.inputs], [v.universe[1] for v in fis.inputs])
    middle, half = (x.min(axis=0) + x.max(axis=0)) / 2, (x.max(axis=0) - x.min(axis=0)) / 2
    half[half == 0] = 1.0
    scaled = np.column_stack([(x - middle) / half, np.ones(len(x))])
    outputs, rmse = [], np.zeros(len(fis.outputs))
    parameters = rank = 0
    for j, output in enumerate(fis.outputs):
        place = fis.structure.consequent[j]
        terms = list(output.terms.items())
        used = [t for t in range(len(terms)) if (place == t).any()]
        count = sum(len(terms[t][1].parameters) for t in used)
        if not fired[:, j].any():
            raise IdentificationError(f"no rule fires for output {output.name} at any sample")
        design = np.concatenate(
            [shares[j][:, place == t].sum(axis=1)[:, None] * scaled[:, -len(terms[t][1].parameters) :] for t in used],
            axis=1,
        )[fired[:, j]]
        # With weights that sum to 1 a constant passes through; what is fitted is then the rest.
        mean = float(y[fired[:, j], j].mean()) if fis.defuzzification == "wtaver" else 0.0
        target = y[fired[:, j], j] - mean
        theta, found = _solved(design, target, ridge)
        rmse[j] = np.sqrt(np.mean((design @ theta - target) ** 2))
        parameters, rank = parameters + count, rank + found
        outputs.append(replace(output, terms=_terms(terms, used, theta, mean, middle, half)))
    silent = int((~fired.all(axis=1)).sum())
    return Fit(replace(fis, outputs=tuple(outputs)), rmse, parameters, rank, silent)


def output_table(y: Any, names: Sequence[str] | None = None) -> np.ndarray:
    """``y`` (samples,) or (samples, outputs) as (samples, outputs), all finite; ClusteringError otherwise."""
    if np.ndim(y) == 1:
        y = np.asarray(y)[:, None]
    return finite_table(y, "y", names if names is not None and np.shape(y)[1:] == (len(names),) else None)


def _shares(fis: Sugeno, x: np.ndarray) -> tuple[list[np.ndarray], np.ndarray]:
    """What each rule's proposal counts (samples, rules), for each output; where any rule fires (samples, outputs)."""
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", InferenceWarning)
        layers = infer(replace(fis, no_rule_fires="nan"), x)
    shares = []
    for place in fis.structure.consequent:
        if fis.defuzzification == "wtsum":
            shares.append(layers.firing * (place >= 0))
        else:
            share = layers.weights * (place >= 0)
            total = share.sum(axis=1, keepdims=True)
            shares.append(share / np.where(total > 0, total, 1.0))
    return shares, np.asarray(layers.fired)


def _solved(design: np.ndarray, target: np.ndarray, ridge: float) -> tuple[np.ndarray, int]:
    if ridge:
        samples, count = design.shape
        design = np.concatenate([design, np.sqrt(ridge * samples) * np.eye(count)])
        target = np.concatenate([target, np.zeros(count)])
    theta, _, rank, _ = np.linalg.lstsq(design, target, rcond=None)
    return theta, int(rank)


def _terms(
    terms: Sequence[tuple[str, Consequent]],
    used: Sequence[int],
    theta: np.ndarray,
    mean: float,
    middle: np.ndarray,
    half: np.ndarray,
) -> dict[str, Consequent]:
    """The output's terms, those ``used`` with their parameters from ``theta``, back in the units of the data."""
    fitted = dict(terms)
    for t in used:
        label, term = terms[t]
        count = len(term.parameters)
        *slopes, constant = theta[:count]
        theta = theta[count:]
        if isinstance(term, Linear):
            slopes = np.asarray(slopes) / half
            fitted[label] = Linear(tuple(slopes.tolist()), float(constant + mean - slopes @ middle))
        else:
            fitted[label] = Constant(float(constant + mean))
    return fitted
