"""The consequents by least squares: batch, blocked and recursive   [Jang 1993, hybrid rule, forward pass].

With the premises held, an output is linear in its consequents: y = Σ_t W_t (p_t · x + c_t), where W_t is the summed
weight of the rules that propose the term t. One row of the design matrix is W ⊗ [x, 1].
"""

from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np
import torch

from fuzzy.files.table import DataError
from fuzzy.system import Constant, Linear, Sugeno


@dataclass(frozen=True, eq=False)
class Group:
    """Outputs whose consequents share one design matrix: same rules on the same terms, same orders."""

    outputs: tuple[int, ...]
    share: torch.Tensor  # (rules, terms): 1 where a rule proposes a term
    columns: torch.Tensor  # (parameters,) int: which of the terms × (inputs + 1) columns are free
    used: tuple[bool, ...]  # (terms,): does a rule propose the term? If not, it is not learnt
    everyone: bool  # does every rule have a say in these outputs?
    own: bool  # does rule k propose term k, for every k? Then the terms' weights are the rules'


def groups(fis: Sugeno, dtype: torch.dtype, device: str) -> tuple[Group, ...]:
    """The outputs of ``fis`` by design matrix."""
    found: dict[Any, list[int]] = {}
    for o, output in enumerate(fis.outputs):
        key = (tuple(fis.structure.consequent[o]), tuple(isinstance(t, Linear) for t in output.terms.values()))
        found.setdefault(key, []).append(o)
    result = []
    width = len(fis.inputs) + 1
    for (consequent, linear), outputs in found.items():
        share = np.zeros((len(fis.rules), len(linear)))
        for r, t in enumerate(consequent):
            if t >= 0:
                share[r, t] = 1.0
        used = tuple(t in consequent for t in range(len(linear)))
        # The term's columns are its slopes, then its constant; a constant term has the last one only.
        columns = [
            t * width + k
            for t, is_linear in enumerate(linear)
            for k in range(width)
            if used[t] and (is_linear or k == width - 1)
        ]
        result.append(
            Group(
                tuple(outputs),
                torch.tensor(share, dtype=dtype, device=device),
                torch.tensor(columns, dtype=torch.long, device=device),
                used,
                min(consequent) >= 0,
                list(consequent) == list(range(len(linear))),
            )
        )
    return tuple(result)


def term_weights(group: Group, weights: torch.Tensor, normalise: bool) -> torch.Tensor:
    """How much each term counts (samples, terms), from the rules' weights (samples, rules)."""
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
        """With one more block: ``a`` (samples, parameters), ``y`` (samples, outputs)."""
        gram, moment = equations(a, y)
        return NormalEquations(self.gram + gram, self.moment + moment)


def equations(a: torch.Tensor, y: torch.Tensor) -> NormalEquations:
    """Those of one block, ``a`` (samples, parameters) and ``y`` (samples, outputs).

    Summed in double precision, also for samples in single: squares need twice the digits. (Apple's GPUs have none.)
    """
    dtype = a.dtype if a.device.type == "mps" else torch.float64
    a, y = a.to(dtype), y.to(dtype)
    return NormalEquations(a.T @ a, a.T @ y)


class Solution(NamedTuple):
    """Least-squares consequents, and how well they are determined."""

    values: torch.Tensor  # (parameters, outputs)
    rank: int


def range_of(a: torch.Tensor) -> tuple[torch.Tensor, torch.Tensor, torch.Tensor]:
    """The singular value decomposition U, s, Vᵀ of a design matrix, without the singular values that are rounding."""
    u, s, vt = torch.linalg.svd(a, full_matrices=False)
    kept = s > s[0] * max(a.shape) * torch.finfo(a.dtype).eps if len(s) else s > 0
    return u[:, kept], s[kept], vt[kept]


def solve(
    normal: NormalEquations, ridge: float = 0.0, rows: tuple[torch.Tensor, torch.Tensor] | None = None
) -> Solution:
    """The least-squares solution; of minimum norm where the equations do not determine it.

    ``ridge`` is relative to the mean diagonal of the Gram matrix. Cholesky where that is safe. Else, if all ``rows``
    (design matrix, targets) are at hand and there is no ridge, their singular value decomposition, which loses nothing
    by squaring; else the eigenvectors of the Gram matrix with the eigenvalues above 2·10⁻¹³ (float64; 1000 rounding
    errors) of the largest.

    Raises DataError where the sums are too large for the type of number.
    """
    gram, moment = normal
    n = gram.shape[0]
    if n == 0:
        return Solution(moment, 0)
    # No entry of a Gram matrix is larger than its diagonal.
    if not bool(torch.isfinite(gram.diagonal()).all() & torch.isfinite(moment).all()):
        raise DataError("the least squares overflow: check the data's and the universes' magnitudes")
    if ridge:
        gram = gram + ridge * gram.diagonal().mean() * torch.eye(n, dtype=gram.dtype, device=gram.device)
    factor, failed = torch.linalg.cholesky_ex(gram)
    pivots = factor.diagonal() ** 2
    tolerance = 1e3 * torch.finfo(gram.dtype).eps
    precise = rows is not None and not ridge
    if not failed and bool((pivots > (1e4 if precise else 1.0) * tolerance * gram.diagonal()).all()):
        values = torch.cholesky_solve(moment, factor)
        # One step of refinement gives back most of what forming the Gram matrix lost.
        values = values + torch.cholesky_solve(moment - gram @ values, factor)
        return Solution(values, n)
    if rows is not None and precise:
        a, y = (part.to(gram.dtype) for part in rows)
        u, s, vt = range_of(a)
        return Solution(vt.T @ ((u.T @ y) / s[:, None]), len(s))
    eigenvalues, vectors = torch.linalg.eigh(gram)
    kept = eigenvalues > tolerance * eigenvalues[-1].clamp_min(torch.finfo(gram.dtype).tiny)
    inverse = torch.where(kept, 1 / torch.where(kept, eigenvalues, 1.0), 0.0)
    return Solution(vectors @ (inverse[:, None] * (vectors.T @ moment)), int(kept.sum()))


def consequent_terms(
    fis: Sugeno, parts: tuple[Group, ...], solutions: list[torch.Tensor], low: torch.Tensor, span: torch.Tensor
) -> list[list[Any]]:
    """The consequents of every output, in the inputs' own units, from solutions in scaled units (x − low)/span.

    A term that no rule proposes stays as it is.
    """
    result: list[list[Any]] = [[] for _ in fis.outputs]
    width = len(fis.inputs) + 1
    for group, values in zip(parts, solutions, strict=True):
        full = values.new_zeros(group.share.shape[1] * width, values.shape[1])
        full[group.columns] = values
        for column, o in enumerate(group.outputs):
            rows = full[:, column].reshape(-1, width)
            slopes = rows[:, :-1] / span
            constants = rows[:, -1] - slopes @ low
            for t, term in enumerate(fis.outputs[o].terms.values()):
                if not group.used[t]:
                    result[o].append(term)
                    continue
                constant = float(constants[t])
                result[o].append(
                    Linear(tuple(slopes[t].tolist()), constant) if isinstance(term, Linear) else Constant(constant)
                )
    return result


def present_values(fis: Sugeno, parts: tuple[Group, ...], low: torch.Tensor, span: torch.Tensor) -> list[torch.Tensor]:
    """The consequents that ``fis`` has now, in scaled units: the inverse of :func:`consequent_terms`."""
    result = []
    for group in parts:
        columns = []
        for o in group.outputs:
            rows = []
            for term in fis.outputs[o].terms.values():
                *slopes, constant = [float(p) for p in term.parameters]
                slope = low.new_tensor(slopes or [0.0] * len(fis.inputs))
                rows.append(torch.cat([slope * span, (low.new_tensor(constant) + slope @ low)[None]]))
            columns.append(torch.cat(rows)[group.columns] if rows else low.new_zeros(0))
        result.append(torch.stack(columns, dim=1))
    return result


class Recursive(NamedTuple):
    """Recursive least squares for learning on line: what is known after the samples so far."""

    values: torch.Tensor  # (parameters, outputs)
    covariance: torch.Tensor  # (parameters, parameters)


def recursive_start(values: torch.Tensor, confidence: float = 1e-6) -> Recursive:
    """Before the first sample: ``values`` (parameters, outputs) are believed only a little."""
    n = values.shape[0]
    return Recursive(values, torch.eye(n, dtype=values.dtype, device=values.device) / confidence)


def recursive_step(state: Recursive, a: torch.Tensor, y: torch.Tensor, forgetting: float = 1.0) -> Recursive:
    """After one more sample: ``a`` (parameters,) a row of the design matrix, ``y`` (outputs,)   [Jang 1993, (17)].

    ``forgetting`` in (0, 1] is the weight of the past.
    """
    gain = state.covariance @ a / (forgetting + a @ state.covariance @ a)
    values = state.values + gain[:, None] * (y - a @ state.values)[None, :]
    covariance = (state.covariance - gain[:, None] * (a @ state.covariance)[None, :]) / forgetting
    return Recursive(values, (covariance + covariance.T) / 2)
