"""The consequents of a Sugeno system by least squares: with given antecedents the output is linear in them.

This module is the home of the formulation, also for learning (:mod:`anfis.consequents`):

- **Design matrix.** A row is W ⊗ [x, 1]: for every term t in use its summed weight W_t times the inputs and 1, or
  times 1 alone for a constant term. Outputs of the same rules, terms and orders share it (:func:`output_groups`).
- **Rank.** Where the samples do not determine the consequents, the solution of least norm is taken. A singular value
  that is not above (the larger side of the matrix) × (the machine's precision) × (the largest one) counts as 0.
- **Ridge.** A ridge λ ≥ 0 adds λ |θ|² to the mean square error over the samples at which a rule fires. θ are the
  consequents of inputs scaled to [−1, 1] by the range of the samples, for outputs less their mean (not for a weighted
  sum, whose weights do not pass a constant through). So λ has no unit and means the same for any number of samples.
  This is Tikhonov's penalty on standardised variables [Hoerl & Kennard 1970], with the mean instead of the sum of
  squares as in glmnet [Friedman, Hastie & Tibshirani 2010]; they standardise by the standard deviation.
"""

import warnings
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any, NamedTuple

import numpy as np

from fuzzy.detached import detached
from fuzzy.errors import InputError
from fuzzy.fitting.clustering import DataWarning, finite_table
from fuzzy.inference import infer_quietly
from fuzzy.system import Consequent, Constant, Linear, Sugeno

LARGEST_RIDGE = 1e12  # far above it nothing is left but the outputs' mean
_LARGEST = 100_000_000  # numbers in the equations, at most: 0.8 GB


class IdentificationError(InputError):
    """Data or settings that identify no system. The message names the row, the column or the setting."""


@dataclass(frozen=True, eq=False)
class OutputGroup:
    """Outputs whose consequents share one design matrix: same rules on the same terms, same orders."""

    outputs: tuple[int, ...]
    place: np.ndarray  # (rules,) int: the term that each rule proposes, −1 for none
    linear: tuple[bool, ...]  # (terms,): is the consequent linear? Else it is a constant
    used: tuple[bool, ...]  # (terms,): does a rule propose the term? If not, it is not fitted
    columns: np.ndarray  # (parameters,) int: which of the terms × (inputs + 1) slopes and constants are fitted


def output_groups(fis: Sugeno) -> tuple[OutputGroup, ...]:
    """The outputs of ``fis`` by design matrix."""
    found: dict[Any, list[int]] = {}
    for o, output in enumerate(fis.outputs):
        key = (tuple(fis.structure.consequent[o]), tuple(isinstance(t, Linear) for t in output.terms.values()))
        found.setdefault(key, []).append(o)
    width = len(fis.inputs) + 1
    result = []
    for (place, linear), outputs in found.items():
        used = tuple(t in place for t in range(len(linear)))
        # The term's columns are its slopes, then its constant; a constant term has the last one only.
        columns = [
            t * width + k
            for t, is_linear in enumerate(linear)
            for k in range(width)
            if used[t] and (is_linear or k == width - 1)
        ]
        result.append(OutputGroup(tuple(outputs), np.array(place), linear, used, np.array(columns, dtype=int)))
    return tuple(result)


class ConsequentFit(NamedTuple):
    """A fitted system and how well the samples determine it."""

    fis: Sugeno
    rmse: np.ndarray  # (outputs,) root mean square error at the samples where a rule fires, in the output's unit
    parameters: int  # of all consequents
    rank: int  # how many of them the samples determine
    silent: int  # samples where no rule fires for some output


def fit_consequents(fis: Sugeno, x: Any, y: Any, ridge: float = 0.0) -> Sugeno:
    """The system with the consequents that fit ``y`` at ``x`` best.

    One global least squares for each output: the columns are the normalised firing strengths w̄ (the firing strengths w
    for wtsum) times [x 1], or times 1 for a constant [Jang 1993, (17); MATLAB genfis2]. The orders of the consequents,
    their names and who shares them stay; a consequent that no rule uses stays as it is.

    Where the samples do not determine the consequents the solution of least norm is taken. Norms are measured with the
    inputs scaled to [−1, 1] by the samples' range and the outputs less their mean, so that they do not depend on units;
    the module's description has the whole definition. Warns (DataWarning) of a rank that is too low, with the rank, and
    of samples where no rule fires, which do not count.

    Args:
        fis: The system, whose premises stay.
        x: The inputs (samples, inputs).
        y: The outputs (samples,) or (samples, outputs).
        ridge: >= 0, without a unit: adds ridge · |θ|² to the mean square error; the same in :class:`anfis.Options`.

    Raises:
        ClusteringError: Values that are not finite.
        IdentificationError: Shapes that do not fit.
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


def say_rank(fitted: ConsequentFit, samples: int) -> None:
    """Warn (DataWarning) where the samples do not determine all parameters."""
    if fitted.rank < fitted.parameters:
        warnings.warn(
            f"the {samples} samples determine {fitted.rank} of {fitted.parameters} parameters of the consequents "
            "(the rank); the solution of least norm is taken. Fewer rules, order 0 or ridge > 0 helps",
            DataWarning,
            stacklevel=3,
        )


def least_squares(fis: Sugeno, x: Any, y: Any, ridge: float = 0.0) -> ConsequentFit:
    """The fit of :func:`fit_consequents`, with its arguments and errors; the rank and the rest instead of warnings."""
    fis = detached(fis)
    groups = output_groups(fis)
    x, y = _checked(fis, groups, x, y, ridge)
    layers = infer_quietly(fis, x)
    fired = np.asarray(layers.fired)
    weights = layers.firing if fis.defuzzification == "wtsum" else layers.weights
    if fis.out_of_range == "clip":
        x = np.clip(x, [v.universe[0] for v in fis.inputs], [v.universe[1] for v in fis.inputs])
    middle, half = (x.min(axis=0) + x.max(axis=0)) / 2, (x.max(axis=0) - x.min(axis=0)) / 2
    half[half == 0] = 1.0
    scaled = np.column_stack([(x - middle) / half, np.ones(len(x))])
    outputs, rmse, parameters, rank = list(fis.outputs), np.zeros(len(fis.outputs)), 0, 0
    for group in groups:
        fires = fired[:, group.outputs[0]]
        if not fires.any():
            raise IdentificationError(f"no rule fires for output {outputs[group.outputs[0]].name} at any sample")
        matrix = _design(group, rule_shares(fis, group, weights), scaled)[fires]
        # An output at a time: several right-hand sides in one call would give other last digits.
        for j in group.outputs:
            # With weights that sum to 1 a constant passes through; what is fitted is then the rest.
            mean = float(y[fires, j].mean()) if fis.defuzzification == "wtaver" else 0.0
            target = y[fires, j] - mean
            theta, found = _solved(matrix, target, ridge)
            rmse[j] = np.sqrt(np.mean((matrix @ theta - target) ** 2))
            parameters, rank = parameters + len(group.columns), rank + found
            outputs[j] = replace(outputs[j], terms=_terms(outputs[j].terms, group, theta, mean, middle, half))
    silent = int((~fired.all(axis=1)).sum())
    return ConsequentFit(replace(fis, outputs=tuple(outputs)), rmse, parameters, rank, silent)


def _checked(fis: Sugeno, groups: Sequence[OutputGroup], x: Any, y: Any, ridge: float) -> tuple[np.ndarray, np.ndarray]:
    """``x`` (samples, inputs) and ``y`` (samples, outputs) if they, the system and the ridge fit together."""
    x = finite_table(x, "x", [v.name for v in fis.inputs] if np.shape(x)[1:] == (len(fis.inputs),) else None)
    y = output_table(y, [v.name for v in fis.outputs])
    if x.shape[1] != len(fis.inputs) or y.shape[1] != len(fis.outputs):
        raise IdentificationError(
            f"{fis.name} has {len(fis.inputs)} inputs and {len(fis.outputs)} outputs; "
            f"x has {x.shape[1]} columns and y {y.shape[1]}"
        )
    if len(x) != len(y):
        raise IdentificationError(f"x has {len(x)} samples, y {len(y)}")
    if not (isinstance(ridge, (int, float)) and 0 <= ridge <= LARGEST_RIDGE):
        raise IdentificationError(f"ridge must be a number >= 0 and <= {LARGEST_RIDGE:g}, got {ridge!r}")
    if not fis.rules:
        raise IdentificationError(f"{fis.name} has no rules, so there are no consequents to fit")
    for group in groups:
        if len(group.columns) * len(x) > _LARGEST:
            raise IdentificationError(
                f"{len(x)} samples and {len(group.columns)} parameters of {fis.outputs[group.outputs[0]].name} are too "
                "large a system of equations; take fewer rules or fewer samples"
            )
    return x, y


def output_table(y: Any, names: Sequence[str] | None = None) -> np.ndarray:
    """``y`` (samples,) or (samples, outputs) as (samples, outputs), all finite; ClusteringError otherwise."""
    if np.ndim(y) == 1:
        y = np.asarray(y)[:, None]
    return finite_table(y, "y", names if names is not None and np.shape(y)[1:] == (len(names),) else None)


def rule_shares(fis: Sugeno, group: OutputGroup, weights: np.ndarray) -> np.ndarray:
    """How much each rule's proposal counts for the outputs of ``group``, (samples, rules).

    ``weights`` (samples, rules) are the rules' weights; of a weighted sum their firing strengths.
    """
    share = weights * (group.place >= 0)
    if fis.defuzzification == "wtsum":
        return share
    total = share.sum(axis=1, keepdims=True)
    return np.asarray(share / np.where(total > 0, total, 1.0))


def _design(group: OutputGroup, shares: np.ndarray, scaled: np.ndarray) -> np.ndarray:
    """The design matrix (samples, parameters) from the rules' ``shares`` and ``scaled`` = [x, 1]."""
    # anfis.consequents.design is the same in torch, summed by a product of matrices: faster, other last digits.
    parts = [
        shares[:, group.place == t].sum(axis=1)[:, None] * (scaled if linear else scaled[:, -1:])
        for t, linear in enumerate(group.linear)
        if group.used[t]
    ]
    return np.concatenate(parts, axis=1)


def _solved(design: np.ndarray, target: np.ndarray, ridge: float) -> tuple[np.ndarray, int]:
    """The least-squares solution (parameters,) of least norm, and the rank; a ridge is one more row a parameter."""
    if ridge:
        samples, count = design.shape
        design = np.concatenate([design, np.sqrt(ridge * samples) * np.eye(count)])
        target = np.concatenate([target, np.zeros(count)])
    theta, _, rank, _ = np.linalg.lstsq(design, target, rcond=None)
    return theta, int(rank)


def _terms(
    terms: Mapping[str, Consequent],
    group: OutputGroup,
    theta: np.ndarray,
    mean: float,
    middle: np.ndarray,
    half: np.ndarray,
) -> dict[str, Consequent]:
    """An output's terms, those in use with their parameters from ``theta``, back in the units of the data."""
    width = len(middle) + 1
    full = np.zeros(len(group.linear) * width)
    full[group.columns] = theta
    fitted = dict(terms)
    for t, (label, linear) in enumerate(zip(terms, group.linear, strict=True)):
        if not group.used[t]:
            continue
        *slopes, constant = full[t * width : (t + 1) * width]
        if linear:
            slopes = np.asarray(slopes) / half
            fitted[label] = Linear(tuple(slopes.tolist()), float(constant + mean - slopes @ middle))
        else:
            fitted[label] = Constant(float(constant + mean))
    return fitted
