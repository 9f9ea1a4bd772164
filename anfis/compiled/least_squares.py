"""Least squares from sums over samples, in numpy: what :func:`anfis.consequents.solve` is in torch.

The rank and the solution of least norm are those of the singular values of the design matrix. They are computed only
where they are needed: where Cholesky's factor of the normal equations is sound, the rank is full.
"""

import math
from collections.abc import Callable
from typing import Any, NamedTuple

import numpy as np

from anfis.point import Solution
from fuzzy.compiled.jit import kernel
from fuzzy.files.table import DataError

_TOLERANCE = 1e3 * np.finfo(np.float64).eps  # of a pivot, relative to the diagonal
_SOUND = 1e4  # times that a pivot must be where the samples are at hand, for one more pass over them is dear
_NEAR_ONE = 0.1  # how far columns that Cholesky's factor made orthonormal may be from that
_SETTLED = 1e-12  # a change of the fitted outputs, relative to them, after which there is no other
_LANES = 128  # samples that are transformed together


class Equations(NamedTuple):
    """The normal equations of some samples: sums, so that samples may come in portions."""

    gram: np.ndarray  # (parameters, parameters): Σ aᵀa
    moment: np.ndarray  # (parameters, outputs): Σ aᵀy


@kernel(nogil=True)
def solve_triangles(lower: np.ndarray, values: np.ndarray) -> None:
    """Replace ``values`` (n, outputs) by the solution of L Lᵀ · solution = values, L ``lower`` (n, n)."""
    n, outputs = values.shape
    for k in range(outputs):
        for i in range(n):
            rest, row = values[i, k], lower[i]
            for j in range(i):
                rest -= row[j] * values[j, k]
            values[i, k] = rest / row[i]
        for i in range(n - 1, -1, -1):
            row = lower[i]
            found = values[i, k] / row[i]
            values[i, k] = found
            for j in range(i):
                values[j, k] -= row[j] * found


@kernel(nogil=True)
def divide_columns(lower: np.ndarray, design: np.ndarray, found: np.ndarray) -> None:
    """``found`` (n, samples) ← L⁻¹ · ``design`` (n, samples), with ``lower`` L (n, n)."""
    n, samples = design.shape
    row = np.empty(_LANES)
    for start in range(0, samples, _LANES):
        count = min(_LANES, samples - start)
        for i in range(n):
            for p in range(count):
                row[p] = design[i, start + p]
            for j in range(i):
                factor, other = lower[i, j], found[j, start:]
                for p in range(count):
                    row[p] -= factor * other[p]
            factor, own = lower[i, i], found[i, start:]
            for p in range(count):
                own[p] = row[p] / factor


def cholesky(gram: np.ndarray, least: float) -> np.ndarray | None:
    """Cholesky's factor L (n, n) of ``gram``, if it has one with all squared pivots above ``least`` of the diagonal."""
    try:
        lower = np.linalg.cholesky(gram)
    except np.linalg.LinAlgError:
        return None
    pivots = lower.diagonal()
    return lower if bool((pivots * pivots > least * gram.diagonal()).all()) else None


class Orthonormal(NamedTuple):
    """A basis of the columns of a design matrix A: Aᵀ = L K Q with lower triangular L, K and orthonormal rows Q."""

    factor: np.ndarray  # K (parameters, parameters), near the unit matrix
    nearly: np.ndarray  # K Q (parameters, samples)


def orthonormal(gram: np.ndarray, transposed: np.ndarray) -> Orthonormal | None:
    """The rows of ``transposed``, Aᵀ (parameters, samples), made orthonormal; None where that would not be exact.

    Twice Cholesky [Yamamoto et al. 2015] is as exact as Householder's reflections where the condition of A is below
    some 1e7. Then the pivots are sound and the rows nearly orthonormal at the first try, and the rank is full.
    ``gram`` is Aᵀ A.
    """
    first = cholesky(gram, _TOLERANCE)
    if first is None:
        return None
    nearly = np.empty_like(transposed)
    divide_columns(first, transposed, nearly)
    again = nearly @ nearly.T
    if not float(abs(again - np.eye(len(again))).max()) < _NEAR_ONE:
        return None
    second = cholesky(again, 0.0)
    return None if second is None else Orthonormal(second, nearly)


def eliminated(transposed: np.ndarray, parameters: int) -> np.ndarray:
    """BᵀB, of the columns B beside the first ``parameters`` ones A, less what A can make up for: B − A A⁺ B.

    ``transposed`` is [A B]ᵀ (columns, samples). What is squared is orthonormal, which keeps what squares would lose.
    """
    a, rest = np.ascontiguousarray(transposed[:parameters]), transposed[parameters:]
    gram = transposed @ transposed.T
    if not parameters:
        return gram
    made = orthonormal(gram[:parameters, :parameters], a)
    if made is not None:
        part = np.linalg.solve(made.factor, made.nearly @ rest.T)
        return np.asarray(gram[parameters:, parameters:] - part.T @ part)
    triangle: Any = np.linalg.qr(transposed.T, mode="r")
    basis, _, _ = singular(triangle[:, :parameters], max(len(triangle), parameters))
    own = triangle[:, parameters:] - basis @ (basis.T @ triangle[:, parameters:])
    return np.asarray(own.T @ own)


def solve(equations: Equations, samples: Callable[[], tuple[np.ndarray, np.ndarray]] | None = None) -> Solution:
    """The least-squares solution; of minimum norm where the equations do not determine it.

    Args:
        equations: The normal equations.
        samples: Gives the design matrix, transposed (parameters, samples), and the targets (samples, outputs), if all
            are at hand. Without them what does not determine the consequents is found less sharply, from eigenvalues
            above 2·10⁻¹³ (1000 rounding errors) of the largest.

    Raises DataError where the sums are too large for the type of number.
    """
    gram, moment = equations
    n = len(gram)
    if n == 0:
        return Solution(moment, 0)
    # No entry of a Gram matrix is larger than its diagonal.
    if not (np.isfinite(gram.diagonal()).all() and np.isfinite(moment).all()):
        raise DataError("the least squares overflow: check the data's and the universes' magnitudes")
    lower = cholesky(gram, _TOLERANCE * (_SOUND if samples is not None else 1.0))
    if lower is not None:
        values = np.array(moment)
        solve_triangles(lower, values)
        # One step of refinement gives back most of what forming the Gram matrix lost.
        rest = moment - gram @ values
        solve_triangles(lower, rest)
        return Solution(values + rest, n)
    if samples is not None:
        return _of_samples(equations, *samples())
    eigenvalues, vectors = np.linalg.eigh(gram)
    kept = eigenvalues > _TOLERANCE * max(eigenvalues[-1], np.finfo(np.float64).tiny)
    vectors = vectors[:, kept]
    return Solution(vectors @ ((vectors.T @ moment) / eigenvalues[kept, None]), int(kept.sum()))


def refined(equations: Equations, transposed: np.ndarray, targets: np.ndarray) -> np.ndarray | None:
    """The solution by Cholesky's factor, made exact by the residuals of the samples; None where that fails.

    Corrected seminormal equations [Björck 1987]. An error falls each time by the square of the condition times the
    precision of numbers; where it falls to a tenth or less the rank is full, and three times bring it to its end.
    """
    lower = cholesky(equations.gram, _TOLERANCE)
    if lower is None:
        return None
    values = np.array(equations.moment)
    solve_triangles(lower, values)
    before = math.inf
    for _ in range(3):
        change = transposed @ (targets - (values.T @ transposed).T)
        solve_triangles(lower, change)
        values += change
        # Both by what they change of the fitted outputs.
        size, whole = (float(np.linalg.norm(lower.T @ part)) for part in (change, values))
        if size <= _SETTLED * whole:
            return values
        if not size <= _NEAR_ONE * before:
            return None
        before = size
    return values


def _of_samples(equations: Equations, transposed: np.ndarray, targets: np.ndarray) -> Solution:
    """The solution from the design matrix itself, which loses nothing by squaring."""
    values = refined(equations, transposed, targets)
    if values is not None:
        return Solution(values, len(values))
    parameters, samples = transposed.shape
    triangle: Any = np.linalg.qr(np.concatenate([transposed, targets.T]).T, mode="r")
    a, y = triangle[:, :parameters], triangle[:, parameters:]
    u, s, vt = singular(a, max(samples, parameters))
    return Solution(vt.T @ ((u.T @ y) / s[:, None]), len(s))


def singular(triangle: np.ndarray, longer: int) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """The singular value decomposition U, s, Vᵀ of the triangle of a design matrix, without values that count as 0.

    ``longer`` is the longer side of the design matrix.
    """
    u, s, vt = np.linalg.svd(triangle, full_matrices=False)
    kept = s > s[0] * longer * np.finfo(np.float64).eps if len(s) else s > 0
    return u[:, kept], s[kept], vt[kept]


def plus(equations: Equations, a: np.ndarray, y: np.ndarray) -> Equations:
    """The equations with more samples: ``a`` (samples, parameters), ``y`` (samples, outputs)."""
    return Equations(equations.gram + a.T @ a, equations.moment + a.T @ y)


def joined(sums: np.ndarray, parameters: int) -> Any:
    """The equations in a Gram matrix (parameters + outputs, ...) of [A y]."""
    return Equations(np.ascontiguousarray(sums[:parameters, :parameters]), sums[:parameters, parameters:].copy())
