"""What theorems 3.1 and 4.1 and the proof of 5.3.2 rest on, each as a number that must lie on one side of a bound.

Theorem 3.1: on S = 0, e'' = −λ_d e' − λ_p e − C e' (3.6) with C = L in (3.7). (3.5) sums K_ij (e_i − e_j) with K_ij
"the elements of the Laplacian", l_ij = −a_ij, which makes C = −L; with K_ij = −l_ij it is L.

Theorem 4.1: V' = −x'Qx with Q of (4.16), which is positive definite for κ > 1/(4 γ (1 − γ²) λ_min(L + B)); printed is
λ_max. ι_ij of (4.10) as "elements of the Laplacian" makes (4.14)'s H = −L + B; with ι_ij = −l_ij it is L + B.

5.3.2: V of (5.13) needs a P with (Q^jj)'P + P Q^jj < 0 for the loops Q^jj of all rules, (2.42). Such a P does for all
mixtures of them, too, so that one mixture that is not stable shows that there is none.
"""

import numpy as np

from robotics.laws.catalogue import make_controller
from robotics.laws.tracking.pdc import ParallelCompensation
from robotics.world.radio.graph import adjacency, laplacian

_DAMPING, _STIFFNESS = 2.0, 1.0  # λ_d [1/s] and λ_p [1/s²] of the laws of chapter 3
_DOMINANT = 4.0  # 1/s: a λ_d above the eigenvalues of L
_GAMMA = 0.5  # γ
_ABOVE = 1.001  # κ over its bound
_SIGNS = {"K_ij = l_ij": -1.0, "K_ij = −l_ij": 1.0, "ι_ij = l_ij": -1.0, "ι_ij = −l_ij": 1.0}  # of L in the loop


def theorem_number(on: str, of: str) -> float:
    """The number of a part of a claim, by what it is ``on`` and ``of`` in claims.toml."""
    everybody = laplacian(adjacency("complete", 3))
    if of == "a ring in which each hears one":
        return _asymmetry(np.eye(3) - np.roll(np.eye(3), 1, axis=1))
    if of == "all hear each other":
        return _asymmetry(everybody)
    if on.startswith("theorem 3.1"):
        return _coupled(_SIGNS[of] * everybody, _DOMINANT if "λ_d" in on else _DAMPING)
    if on == "theorem 4.1":
        star, informed = laplacian(adjacency("star", 3)), np.diag([1.0, 0.0, 0.0])
        if of in _SIGNS:
            return _consensus(_SIGNS[of] * star + informed, 1.0)
        return _least_of_q(star + informed, by_largest=of == "κ by λ_max")
    return _compensated(of, mixed="two" in on)


def _asymmetry(matrix: np.ndarray) -> float:
    return float(np.abs(matrix - matrix.T).max())


def _largest_real_part(matrices: np.ndarray) -> float:
    return float(np.linalg.eigvals(matrices).real.max())


def _coupled(coupling: np.ndarray, damping: float) -> float:
    """Of (3.7): the largest real part of an eigenvalue [1/s]."""
    n = len(coupling)
    one = np.eye(n)
    return _largest_real_part(np.block([[np.zeros((n, n)), one], [-_STIFFNESS * one, -damping * one - coupling]]))


def _consensus(h: np.ndarray, kappa: float) -> float:
    """Of (4.14), whose second row lost its κ: the same [1/s]."""
    n = len(h)
    return _largest_real_part(np.block([[-kappa * h, np.eye(n)], [-_GAMMA * kappa * h, np.zeros((n, n))]]))


def _least_of_q(h: np.ndarray, by_largest: bool) -> float:
    """The least eigenvalue of Q of (4.16), with κ just above its bound by one of the eigenvalues of H."""
    values, one = np.linalg.eigvalsh(h), np.eye(len(h))
    kappa = _ABOVE / (4 * _GAMMA * (1 - _GAMMA**2) * values[-1 if by_largest else 0])
    q = np.block([[2 * kappa * (1 - _GAMMA**2) * h, -one], [-one, 2 * _GAMMA * one]])
    return float(np.linalg.eigvalsh(q)[0])


def _compensated(law: str, mixed: bool) -> float:
    """The largest real part [1/s] of an eigenvalue of the rules' loops, or of the means of any two of them."""
    made = make_controller(law)
    assert isinstance(made, ParallelCompensation)
    (a, b), k = made.model(), made.gains
    loops = (a - b @ k).reshape(-1, 3, 3)
    return _largest_real_part((loops[:, None] + loops) / 2 if mixed else loops)
