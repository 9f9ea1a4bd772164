"""The stability of parallel distributed compensation, thesis (2.42) as corrected: a common P for all rules.

    X̃' = Σ_j Σ_k h_j h_k (A^j − B^j K^k) X̃
    Q^jk = ½ [(A^j − B^j K^k) + (A^k − B^k K^j)],   (Q^jk)' P + P Q^jk + 2 α P <= 0   for all j <= k

The thesis prints X for X̃, B^j K^j for the crossed product, and Q^jk with a stray transpose. Pairs of rules that never
fire together have h_j h_k = 0 and are left out [Tanaka and Wang 2001]. The A^j are linearisations, so such a P proves
at most that the error shrinks near the operating points of its rules: local stability, where the thesis says global.
"""

from dataclasses import dataclass
from math import inf

import numpy as np

from robotics.laws.tracking.pdc import ParallelCompensation
from robotics.plugins.certificates.certificate import CertificateError, fastest_decay, worst_eigenvalue

_GRID = 401  # points of each input by which it is seen which sets overlap


@dataclass(frozen=True, kw_only=True, eq=False)
class Compensation:
    """The closed loop of some rules: the Q^jk of all pairs that fire together, and the common P, if there is one."""

    law: ParallelCompensation
    points: np.ndarray  # (rules, 2): d [m] and α [rad] of the operating points
    A: np.ndarray  # (rules, 3, 3)
    B: np.ndarray  # (rules, 3, 2)
    K: np.ndarray  # (rules, 2, 3)
    pairs: tuple[tuple[int, int], ...]  # j <= k, places in ``points``
    Q: np.ndarray  # (pairs, 3, 3)
    P: np.ndarray | None  # (3, 3); None: there is no common one
    decay: float  # 1/s: √(X̃'PX̃) falls as e^(−decay t) or faster; 0 without a P

    @property
    def slowest_pole(self) -> float:
        """The greatest real part [1/s] of an eigenvalue of any Q^jk; below 0 each alone is stable."""
        return float(np.linalg.eigvals(self.Q).real.max())

    @property
    def worst_eigenvalue(self) -> float:
        """The greatest eigenvalue of Q'P + PQ over all pairs, < 0; infinite without a P."""
        return inf if self.P is None else worst_eigenvalue(self.Q, self.P)


def certify_compensation(
    law: ParallelCompensation, least: float = 0.0, most: float = inf, turn: float = inf
) -> Compensation:
    """Look for a common P for those rules of ``law`` whose operating points lie in a range.

    Args:
        law: The law; the sets of α of its rule base must be mirror images of each other.
        least: The least distance of an operating point [m].
        most: The greatest [m].
        turn: The greatest |α| of an operating point [rad].

    Raises CertificateError where no rule is left, where the sets are not symmetric, and without the extra ``certify``.
    """
    if not np.allclose(law.alphas, -law.alphas[::-1], atol=1e-3):
        raise CertificateError(f"{law.rule_base}: the sets of alpha must be mirror images of each other")
    far = [i for i, d in enumerate(law.distances) if least <= d <= most]
    rules = [(i, j) for i in far for j, alpha in enumerate(law.alphas) if abs(alpha) <= turn]
    if not rules:
        peaks = ", ".join(f"{d:g}" for d in law.distances)
        raise CertificateError(
            f"no rule has its operating point there; the distances are {peaks} m, the least |alpha| is "
            f"{np.abs(law.alphas).min():g} rad"
        )
    i, j = np.array(rules).T
    (a, b), k = law.model(), law.gains
    a, b, k = a[i, j], b[i, j], k[i, j]
    together = _together(law, rules)
    pairs = tuple((m, n) for m in range(len(rules)) for n in range(m, len(rules)) if together[m, n])
    m, n = np.array(pairs).T
    q = ((a[m] - b[m] @ k[n]) + (a[n] - b[n] @ k[m])) / 2  # (2.42)
    decay, p = fastest_decay(q, law.scales)
    points = np.stack([law.distances[i], law.alphas[j]], axis=1)
    return Compensation(law=law, points=points, A=a, B=b, K=k, pairs=pairs, Q=q, P=p, decay=decay)


def _together(law: ParallelCompensation, rules: list[tuple[int, int]]) -> np.ndarray:
    """Which two rules fire at one time anywhere (rules, rules) bool."""
    d = np.linspace(law.distances[0], law.distances[-1], _GRID)
    alpha = np.linspace(law.alphas[0], law.alphas[-1], _GRID)
    h = law.strengths(d[:, None], alpha[None, :])[..., [i for i, _ in rules], [j for _, j in rules]]
    fires = (h > 0).reshape(-1, len(rules)).astype(float)
    return np.asarray(fires.T @ fires > 0)
