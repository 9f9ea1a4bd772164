"""The consequents by least squares: batch, blocked and recursive   [Jang 1993, hybrid rule, forward pass].

The formulation is that of :mod:`fuzzy.fitting.consequents`: the design matrix, who shares it, what a ridge means, the
rank. Here it is solved in every epoch, in torch, by normal equations, block by block. What looks alike in both, the
design matrix and the way back to the inputs' own units, cannot be one function without other last digits: here terms
are summed and slopes moved by products of matrices, there by sums of columns and products of vectors (they part from
five inputs on, in single precision from three). For the same reason the norm that is least where the samples do not
determine the consequents is that of inputs in units of their universes, not of their range.
"""

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
import torch

from anfis.point import Solution
from fuzzy.files.table import DataError
from fuzzy.fitting.consequents import output_groups
from fuzzy.system import Sugeno


@dataclass(frozen=True, eq=False)
class Group:
    """Outputs whose consequents share one design matrix: same rules on the same terms, same orders."""

    outputs: tuple[int, ...]
    share: torch.Tensor  # (rules, terms): 1 where a rule proposes a term
    columns: torch.Tensor  # (parameters,) int: which of the terms × (inputs + 1) columns are free
    everyone: bool  # does every rule have a say in these outputs?
    own: bool  # does rule k propose term k, for every k? Then the terms' weights are the rules'


def groups(fis: Sugeno, dtype: torch.dtype, device: str) -> tuple[Group, ...]:
    """The outputs of ``fis`` by design matrix, as :func:`fuzzy.fitting.consequents.output_groups` finds them."""
    result = []
    for found in output_groups(fis):
        terms = np.arange(len(found.linear))
        result.append(
            Group(
                found.outputs,
                torch.tensor(found.place[:, None] == terms, dtype=dtype, device=device),
                torch.tensor(found.columns, dtype=torch.long, device=device),
                min(found.place) >= 0,
                found.place.tolist() == terms.tolist(),
            )
        )
    return tuple(result)


def term_weights(group: Group, weights: torch.Tensor, normalise: bool) -> torch.Tensor:
    """The weight of each term (samples, terms), from the rules' weights (samples, rules)."""
    if group.own:
        return weights
    shared = weights @ group.share
    return shared / _total(shared) if normalise and not group.everyone else shared


def _total(shared: torch.Tensor) -> torch.Tensor:
    total = shared.sum(dim=1, keepdim=True)
    return torch.where(total > 0, total, 1.0)


def design(group: Group, weights: torch.Tensor, x1: torch.Tensor, normalise: bool) -> torch.Tensor:
    """The design matrix (samples, parameters): weights (samples, rules), ``x1`` = [x, 1] (samples, inputs + 1).

    In memory a column is in one piece: products run along the samples, which are many.
    """
    columns = term_weights(group, weights, normalise).T.contiguous()
    full = (columns[:, None, :] * x1.T[None, :, :]).flatten(0, 1)
    return (full if full.shape[0] == len(group.columns) else full[group.columns]).T


def weights_gradient(
    group: Group, weights: torch.Tensor, x1: torch.Tensor, values: torch.Tensor, error: torch.Tensor, normalise: bool
) -> torch.Tensor:
    """∂ Σ error · output / ∂ weights, (samples, rules): of a sum over samples and the group's outputs.

    ``error`` (samples, outputs) and the consequents ``values`` (parameters, outputs) are held. An output is linear in
    the weights, so this is what the terms propose, times the error; a sum that is normalised again over the rules that
    take part loses the output itself.
    """
    terms, outputs, width = group.share.shape[1], values.shape[1], x1.shape[1]
    full = values
    if len(group.columns) != terms * width:
        full = values.new_zeros(terms * width, outputs)
        full[group.columns] = values
    # (inputs + 1, outputs × terms): the slopes and the constants, a column a term of an output.
    proposed = x1 @ full.reshape(terms, width, outputs).permute(1, 2, 0).reshape(width, -1)
    pull = proposed * error if outputs == 1 else (proposed.reshape(-1, outputs, terms) * error[:, :, None]).sum(dim=1)
    if group.own:
        return pull
    gradient = pull @ group.share.T
    if not normalise or group.everyone:
        return gradient
    shared = weights @ group.share
    total = _total(shared)
    lost = (shared * pull).sum(dim=1, keepdim=True) / total
    return (gradient - lost * group.share.sum(dim=1)) / total


class NormalEquations(NamedTuple):
    """A least-squares problem summed over blocks of samples: it needs no more memory than one block."""

    gram: torch.Tensor  # (parameters, parameters): Σ aᵀa
    moment: torch.Tensor  # (parameters, outputs): Σ aᵀy

    def plus(self, a: torch.Tensor, y: torch.Tensor) -> "NormalEquations":
        """The equations with one more block: ``a`` (samples, parameters), ``y`` (samples, outputs)."""
        gram, moment = equations(a, y)
        return NormalEquations(self.gram + gram, self.moment + moment)


def equations(a: torch.Tensor, y: torch.Tensor) -> NormalEquations:
    """The normal equations of one block, ``a`` (samples, parameters) and ``y`` (samples, outputs).

    Summed in double precision, also for samples in single: squares need twice the digits. (Apple's GPUs have none.)
    """
    dtype = a.dtype if a.device.type == "mps" else torch.float64
    a, y = a.to(dtype), y.to(dtype)
    return NormalEquations(a.T @ a, a.T @ y)


def range_of(a: torch.Tensor) -> tuple[torch.Tensor, torch.Tensor, torch.Tensor]:
    """The singular value decomposition U, s, Vᵀ of a design matrix, without the singular values that count as 0."""
    u, s, vt = torch.linalg.svd(a, full_matrices=False)
    kept = s > s[0] * max(a.shape) * torch.finfo(a.dtype).eps if len(s) else s > 0
    return u[:, kept], s[kept], vt[kept]


def solve(normal: NormalEquations, rows: tuple[torch.Tensor, torch.Tensor] | None = None) -> Solution:
    """The least-squares solution; of minimum norm where the equations do not determine it.

    Cholesky where that is safe. Else, if all ``rows`` (design matrix, targets) are at hand, their singular value
    decomposition, which loses nothing by squaring; else the eigenvectors of the Gram matrix with the eigenvalues above
    2·10⁻¹³ (float64; 1000 rounding errors) of the largest.

    Raises DataError where the sums are too large for the type of number.
    """
    gram, moment = normal
    n = gram.shape[0]
    if n == 0:
        return Solution(moment, 0)
    # No entry of a Gram matrix is larger than its diagonal.
    if not bool(torch.isfinite(gram.diagonal()).all() & torch.isfinite(moment).all()):
        raise DataError("the least squares overflow: check the data's and the universes' magnitudes")
    factor, failed = torch.linalg.cholesky_ex(gram)
    pivots = factor.diagonal() ** 2
    tolerance = 1e3 * torch.finfo(gram.dtype).eps
    if not failed and bool((pivots > (1e4 if rows is not None else 1.0) * tolerance * gram.diagonal()).all()):
        values = torch.cholesky_solve(moment, factor)
        # One step of refinement gives back most of what forming the Gram matrix lost.
        values = values + torch.cholesky_solve(moment - gram @ values, factor)
        return Solution(values, n)
    if rows is not None:
        a, y = (part.to(gram.dtype) for part in rows)
        u, s, vt = range_of(a)
        return Solution(vt.T @ ((u.T @ y) / s[:, None]), len(s))
    eigenvalues, vectors = torch.linalg.eigh(gram)
    kept = eigenvalues > tolerance * eigenvalues[-1].clamp_min(torch.finfo(gram.dtype).tiny)
    inverse = torch.where(kept, 1 / torch.where(kept, eigenvalues, 1.0), 0.0)
    return Solution(vectors @ (inverse[:, None] * (vectors.T @ moment)), int(kept.sum()))


class Recursive(NamedTuple):
    """The state of recursive least squares, for learning on line: what is known after the samples so far.

    Attributes:
        values: (parameters, outputs), in the units of the consequents.
        covariance: (parameters, parameters).
    """

    values: torch.Tensor
    covariance: torch.Tensor


def recursive_start(values: torch.Tensor, confidence: float = 1e-6) -> Recursive:
    """The state of recursive least squares before the first sample, with little confidence in its values.

    Args:
        values: The consequents to begin with (parameters, outputs).
        confidence: A positive number; the covariance is the identity over it.
    """
    n = values.shape[0]
    return Recursive(values, torch.eye(n, dtype=values.dtype, device=values.device) / confidence)


def recursive_step(state: Recursive, a: torch.Tensor, y: torch.Tensor, forgetting: float = 1.0) -> Recursive:
    """The state after one more sample   [Jang 1993, (17)].

    Args:
        state: The state before it.
        a: The sample's row of the design matrix (parameters,).
        y: Its targets (outputs,).
        forgetting: The factor in (0, 1] by which all earlier samples lose weight.
    """
    gain = state.covariance @ a / (forgetting + a @ state.covariance @ a)
    values = state.values + gain[:, None] * (y - a @ state.values)[None, :]
    covariance = (state.covariance - gain[:, None] * (a @ state.covariance)[None, :]) / forgetting
    return Recursive(values, (covariance + covariance.T) / 2)
