"""A stability certificate of the Lyapunov (Kanayama) law: a common quadratic function by linear matrix inequalities.

With the errors of (5.9) and the law of thesis 2.2 the tracking error obeys, exactly and without linearisation,

    e' = A(v_r, a, s, ω) e,   e = (x, y, ψ),   s = sin ψ / ψ,   ω = ω_r + a_y K_y y + a_ψ K_ψ sin ψ

        | −K_x      ω            0       |
    A = |  −ω       0          v_r s     |      (2.32): a_y = a_ψ = max(v_r, min(|v|, catch_up))
        |   0    −a_y K_y   −a_ψ K_ψ s   |      (2.31): a_y = v_r, a_ψ = 1

a Takagi-Sugeno model by sector nonlinearity [Tanaka & Wang 2001]: A is affine in ω, in s and in (v_r, a), so while
these premises stay in their ranges A stays in the convex hull of its values at the corners, the rules' A^j − B K^j of
(2.42). B is common to all rules, so the cross terms Q^jk of the thesis do not arise. A common P > 0 with
A'P + PA + 2αP <= 0 at every corner makes V = e'Pe fall as e^(−2αt) or faster.

The thesis concludes "globally" from such a P. That holds only where the premises do. ψ and ω are no inputs but follow
from the error, so a region is needed that no trajectory leaves: the largest ellipsoid e'Pe <= 1 in which
|ψ| <= ``heading``, and |ω| <= ``turn`` for every reference with |ω_r| <= ``reference_turn``. In Q = P⁻¹ both are
linear inequalities, and V falls on its boundary: with v_r in its range, what starts inside stays inside.
"""

import warnings
from dataclasses import dataclass
from typing import Any

import numpy as np

from fuzzy.errors import InputError
from fuzzy.extras import install_command
from fuzzy.quantity import check_quantities, described, quantity
from robotics.laws.tracking.lyapunov import Lyapunov
from robotics.world.vehicle.robot import Robot

_SHARE = 0.99  # of the greatest decay rate is asked by default: the last percent costs the region much of its size


class CertificateError(InputError):
    """A question that has no certificate or cannot be asked. The message says what would help."""


@dataclass(frozen=True, kw_only=True)
class SectorModel:
    """The tracking error under a law, and the ranges of its premises.

    Raises CertificateError for ranges that contradict each other.
    """

    law: Lyapunov = described("The law.", default_factory=Lyapunov)
    speed_low: float = quantity(0.2, "m/s", above=0, doc="Least v_r of the reference; none is certified at rest.")
    speed_high: float = quantity(0.4, "m/s", above=0, doc="Greatest v_r of the reference.")
    reference_turn: float = quantity(1.0, "rad/s", least=0, doc="Bound of the reference's |ω_r|.")
    turn: float = quantity(5.74, "rad/s", above=0, doc="Bound of the commanded |ω|.")  # 5.74: the robot's limit
    # At π the law has another equilibrium
    heading: float = quantity(1.2, "rad", above=0, most=3.1, doc="Bound of the heading error.")

    def __post_init__(self) -> None:
        check_quantities(self, CertificateError)
        if self.speed_low > self.speed_high:
            raise CertificateError(
                f"speed_low must be at most speed_high, {self.speed_high:g} m/s; got {self.speed_low:g} m/s"
            )
        if self.reference_turn >= self.turn:
            raise CertificateError(
                f"reference_turn must be below turn, {self.turn:g} rad/s, or nothing is left to correct with; "
                f"got {self.reference_turn:g} rad/s"
            )
        if self.law.signs != "corrected":
            raise CertificateError("law: signs must be 'corrected'; with the literal ones the error grows")

    def matrix(self, v: Any, ay: Any, apsi: Any, s: Any, w: Any) -> np.ndarray:
        """The matrices A (..., 3, 3) at given premises, arrays that broadcast together.

        Args:
            v: The reference's speed v_r [m/s].
            ay: The factor a_y [m/s].
            apsi: The factor a_ψ, in m/s or, in the form (2.31), 1.
            s: The sector sin ψ / ψ.
            w: The turn rate ω [rad/s].
        """
        v, ay, apsi, s, w = np.broadcast_arrays(*(np.asarray(p, dtype=float) for p in (v, ay, apsi, s, w)))
        a = np.zeros((*v.shape, 3, 3))
        a[..., 0, 0] = -self.law.kx
        a[..., 0, 1], a[..., 1, 0] = w, -w
        a[..., 1, 2] = v * s
        a[..., 2, 1] = -ay * self.law.ky
        a[..., 2, 2] = -apsi * self.law.kpsi * s
        return a

    def speeds(self) -> list[tuple[float, float, float]]:
        """The corners of (v_r, a_y, a_ψ), whose convex hull holds all values that these take together."""
        low, high = self.speed_low, self.speed_high
        if self.law.form == "2.31":
            return [(v, v, 1.0) for v in dict.fromkeys((low, high))]
        # v_r <= a <= max(v_r, catch_up): a triangle or a quadrangle over the line a = v_r
        pairs = [(low, low), (high, high), (low, max(low, self.law.catch_up)), (high, max(high, self.law.catch_up))]
        return [(v, a, a) for v, a in dict.fromkeys(pairs)]

    def sectors(self) -> tuple[float, float]:
        """The least and the greatest s = sin ψ / ψ for |ψ| <= heading."""
        return float(np.sin(self.heading) / self.heading), 1.0

    def vertices(self) -> np.ndarray:
        """The matrices A at the corners of the premises (corners, 3, 3): 8, or 12 where the law catches up."""
        corners = [(*p, s, w) for p in self.speeds() for s in self.sectors() for w in (-self.turn, self.turn)]
        return self.matrix(*np.array(corners).T)

    def feedback(self) -> np.ndarray:
        """The rows k (corners, 3) [rad/s per m, m, rad] whose products k e enclose ω − ω_r by their convex hull."""
        ky, kpsi = self.law.ky, self.law.kpsi
        return np.array([(0, ay * ky, apsi * kpsi * s) for _, ay, apsi in self.speeds() for s in self.sectors()])

    def grid(self, points: int) -> np.ndarray:
        """The matrices A (n, 3, 3) on a dense grid of the premises, with ``points`` values of each premise.

        There are three premises, four where the law catches up: n is points³ or points⁴.
        """
        share = np.linspace(0, 1, points)
        v = self.speed_low + (self.speed_high - self.speed_low) * share
        heading, w = self.heading * share, self.turn * (2 * share - 1)
        more = share if self.law.form == "2.32" and self.law.catch_up > self.speed_low else share[:1]
        v, more, heading, w = np.meshgrid(v, more, heading, w, indexing="ij")
        if self.law.form == "2.31":
            ay, apsi = v, np.ones_like(v)
        else:
            ay = apsi = v + more * (np.maximum(v, self.law.catch_up) - v)
        return self.matrix(v, ay, apsi, np.sinc(heading / np.pi), w).reshape(-1, 3, 3)


@dataclass(frozen=True, kw_only=True, eq=False)
class Certificate:
    """A region e'Pe <= 1 that no trajectory leaves, in which V = e'Pe falls as e^(−2 decay t) or faster.

    Attributes:
        model: The law, and the ranges of the premises.
        P: The matrix of V, (3, 3), symmetric, > 0; of errors in m, m and rad.
        decay: The rate that this P proves [1/s].
        fastest: The greatest rate that any common P gives [1/s].
    """

    model: SectorModel
    P: np.ndarray  # (3, 3), symmetric, > 0
    decay: float  # 1/s, of this P: √V falls as e^(−decay t)
    fastest: float  # 1/s, the greatest that any common P gives (found by bisection, to 0.01 %)

    @property
    def half_widths(self) -> np.ndarray:
        """The distances from 0 to which the region reaches (3,): x [m], y [m], ψ [rad]."""
        return np.sqrt(np.diag(np.linalg.inv(self.P)))

    @property
    def worst_eigenvalue(self) -> float:
        """The greatest eigenvalue [1/s] of A'P + PA over the corners, < 0."""
        return worst_eigenvalue(self.model.vertices(), self.P)

    @property
    def largest_turn(self) -> float:
        """A bound of the commanded |ω| [rad/s] in the region; it uses up to all of ``turn``."""
        return self.model.reference_turn + float(_reach(self.P, self.model.feedback()).max())

    @property
    def largest_speed(self) -> float:
        """A bound of the commanded |v| [m/s] in the region."""
        return self.model.speed_high + self.model.law.kx * float(self.half_widths[0])

    def level(self, e: np.ndarray) -> np.ndarray:
        """The values V = e'Pe (...) of errors ``e`` (..., 3)."""
        return np.einsum("...i,ij,...j->...", e, self.P, e)

    def boundary(self, directions: np.ndarray) -> np.ndarray:
        """The errors (..., 3) with V = 1 to which ``directions`` (..., 3) other than 0 are mapped."""
        unit = directions / np.linalg.norm(directions, axis=-1, keepdims=True)
        return unit @ np.linalg.cholesky(np.linalg.inv(self.P)).T

    def unsaturated(self, robot: Robot) -> float:
        """The share of the half-widths within which no command meets a limit of ``robot``, in [0, 1].

        No trajectory leaves the smaller ellipsoid V <= share² either, so saturation plays no part in it.
        """
        law, model = self.model.law, self.model
        k = self.model.feedback()
        along = np.array([[law.kx, 0.0, 0.0]])
        wheels = np.concatenate([along + robot.half_axle * k, along - robot.half_axle * k])
        of_wheels = robot.wheel_speed_limit - model.speed_high - robot.half_axle * model.reference_turn
        limits = (  # what the reference leaves of a limit, and what of it the feedback takes at V = 1
            (robot.v_max - model.speed_high, _reach(self.P, along)),
            (robot.w_max - model.reference_turn, _reach(self.P, k)),
            (of_wheels, _reach(self.P, wheels)),
        )
        return float(np.clip(min(left / taken.max() for left, taken in limits), 0.0, 1.0))


def certify(model: SectorModel, decay: float | None = None) -> Certificate:
    """Find the certificate with the largest region for a decay rate.

    The solver proposes; the rate and the region of what it proposes are then computed from P alone.

    Args:
        model: The law, and the ranges of the premises.
        decay: The decay rate [1/s] that is asked for; None: 99 % of the greatest one.

    Returns:
        The certificate.

    Raises CertificateError where no common P exists or none has this rate, and without the extra ``certify``.
    """
    cvxpy_module()
    vertices = model.vertices()
    fastest, _ = fastest_decay(vertices, _scale(model))
    asked = "" if decay is None else f" with the decay rate {decay:g} 1/s"
    if not fastest > 0:
        raise CertificateError(
            f"no common quadratic Lyapunov function was found for {_premises(model)}; narrow the range of v_r, "
            "lower the bounds of |ω| or |ψ|, or change the gains"
        )
    most = fastest / (1 + 3e-4)
    if decay is not None and not 0 < decay <= most:
        raise CertificateError(
            f"no certificate{asked} for {_premises(model)}: accepted are rates > 0 and <= {most:.4g} 1/s"
        )
    for wanted in (_SHARE * fastest, 0.9 * fastest) if decay is None else (decay,):
        p = _largest(model, vertices, wanted * (1 + 1e-4))  # a little more, so that the solver's tolerance is covered
        rate = 0.0 if p is None else decay_rate(vertices, p)
        if p is not None and rate >= wanted:
            break
    else:
        raise CertificateError(f"the solver found no region{asked} for {_premises(model)}; ask for a lower decay rate")
    heading, turn = _reach(p, np.array([[0.0, 0.0, 1.0]])).max(), _reach(p, model.feedback()).max()
    p = p * max(heading / model.heading, turn / (model.turn - model.reference_turn)) ** 2
    return Certificate(model=model, P=p, decay=rate, fastest=max(fastest, rate))


def worst_eigenvalue(a: np.ndarray, p: np.ndarray) -> float:
    """The greatest eigenvalue of A'P + PA over the matrices ``a`` (n, 3, 3)."""
    return float(np.linalg.eigvalsh(_lyapunov(a, p))[:, -1].max())


def decay_rate(a: np.ndarray, p: np.ndarray) -> float:
    """The greatest α [1/s] with A'P + PA + 2αP <= 0 for all matrices ``a`` (n, 3, 3), and ``p`` > 0."""
    inverse = np.linalg.inv(np.linalg.cholesky(p))
    return -float(np.linalg.eigvalsh(inverse @ _lyapunov(a, p) @ inverse.T)[:, -1].max()) / 2


def _lyapunov(a: np.ndarray, p: np.ndarray) -> np.ndarray:
    product = p @ a
    return product + product.swapaxes(-1, -2)


def _reach(p: np.ndarray, rows: np.ndarray) -> np.ndarray:
    """The maximum of k e over e'Pe <= 1, for each row k (n, 3)."""
    return np.sqrt(np.einsum("ci,ij,cj->c", rows, np.linalg.inv(p), rows))


def _premises(model: SectorModel) -> str:
    return (
        f"v_r in [{model.speed_low:g}, {model.speed_high:g}] m/s, |ω| <= {model.turn:g} rad/s, "
        f"|ψ| <= {model.heading:g} rad"
    )


# The semidefinite programs. ---------------------------------------------------------------------------------------


def cvxpy_module() -> Any:
    """The package cvxpy; raises CertificateError without it."""
    try:
        import cvxpy
    except ImportError:
        raise CertificateError(f"a certificate needs cvxpy: {install_command('certify')}") from None
    return cvxpy


def _scale(model: SectorModel) -> np.ndarray:
    """Units (3,) that make the three errors alike, as (2.33) weighs them: V = (x² + y²)/2 + (1 − cos ψ)/K_y."""
    return np.array([model.law.ky**-0.5, model.law.ky**-0.5, 1.0])


def _inequalities(cp: Any, vertices: np.ndarray, scale: np.ndarray) -> tuple[Any, list[Any], list[Any], Any]:
    """The unknown Q = P⁻¹ in scaled errors, the matrices QA' + AQ + 2αQ, the constraints of Q, and α.

    (x, ω) -> (−x, −ω) maps the corners onto themselves, and the mean of P and its mirror image is no worse than P:
    x stands alone in it.
    """
    q = cp.Variable((3, 3), symmetric=True)
    rate = cp.Parameter(nonneg=True)
    matrices = [a @ q + q @ a.T + 2 * rate * q for a in vertices * scale / scale[:, None]]
    return q, matrices, [q[0, 1] == 0, q[0, 2] == 0], rate


def _solved(problem: Any) -> bool:
    """Solve it; what comes out is judged by its own eigenvalues, so an inexact answer is no cause for a warning."""
    with warnings.catch_warnings(action="ignore"):
        try:
            problem.solve(solver="CLARABEL")
        except cvxpy_module().error.SolverError:
            return False
    return problem.status in ("optimal", "optimal_inaccurate")


def _inverse(q: np.ndarray) -> np.ndarray | None:
    """P = Q⁻¹, symmetric and with x alone to the last bit; None where it is not positive."""
    q = (q + q.T) / 2
    q[0, 1:] = q[1:, 0] = 0.0
    if not np.linalg.eigvalsh(q)[0] > 0:
        return None
    p = np.linalg.inv(q)
    return (p + p.T) / 2 + 0.0  # no −0


def fastest_decay(vertices: np.ndarray, scale: np.ndarray) -> tuple[float, np.ndarray | None]:
    """The greatest decay rate [1/s] of any common P, by bisection to 0.01 %, and such a P; 0 and None: there is none.

    Args:
        vertices: Matrices A (n, 3, 3), mirror images of each other in two of the states, so that the first stands
            alone in P.
        scale: Units of the states (3,) that make them alike.

    Raises CertificateError without the extra ``certify``.
    """
    cp = cvxpy_module()
    q, matrices, constraints, rate = _inequalities(cp, vertices, scale)
    margin = cp.Variable()
    constraints += [cp.trace(q) == 3, q >> 1e-6 * np.eye(3), *(m << -margin * np.eye(3) for m in matrices)]
    problem = cp.Problem(cp.Maximize(margin), constraints)

    def found_near(alpha: float) -> tuple[float, np.ndarray | None]:
        rate.value = alpha
        p = _inverse(q.value * scale * scale[:, None]) if _solved(problem) else None
        return (0.0 if p is None else decay_rate(vertices, p)), p

    # No quadratic function falls faster than the slowest pole of a corner.
    (low, best), high = found_near(0.0), -float(np.linalg.eigvals(vertices).real.max())
    if not low > 1e-6 * abs(high):
        return 0.0, None
    while high - low > 1e-4 * high:
        middle = (low + high) / 2
        found, p = found_near(middle)
        if found > low:
            low, best = found, p
        if found < middle:
            high = middle
    return low, best


def _largest(model: SectorModel, vertices: np.ndarray, alpha: float) -> np.ndarray | None:
    """The P with the rate ``alpha`` whose ellipsoid e'Pe <= 1 keeps the premises and is the largest by volume."""
    cp, scale = cvxpy_module(), _scale(model)
    q, matrices, constraints, rate = _inequalities(cp, vertices, scale)
    # |k e| <= 1 in the region for each row k, all of them at most 1 long: what the solver seeks has size 1.
    rows = np.concatenate([[[0.0, 0.0, 1 / model.heading]], model.feedback() / (model.turn - model.reference_turn)])
    size = float(np.linalg.norm(rows * scale, axis=1).max())
    constraints += [m << 0 for m in matrices] + [k @ q @ k <= 1 for k in rows * scale / size]
    rate.value = alpha
    if not _solved(cp.Problem(cp.Maximize(cp.log_det(q)), constraints)):
        return None
    return _inverse(q.value * scale * scale[:, None] / size**2)


# The nonlinear error dynamics, by the law itself. -----------------------------------------------------------------


def error_rates(law: Lyapunov, e: np.ndarray, v_r: np.ndarray, w_r: np.ndarray) -> np.ndarray:
    """The rates of change e' (n, 3) of tracking errors under the commands of a law.

    x' = v_r cos ψ − v + y ω, y' = v_r sin ψ − x ω, ψ' = ω_r − ω   (2.29) with the errors of (5.9).

    Args:
        law: The law.
        e: The errors (n, 3): x [m], y [m], ψ [rad].
        v_r: The reference's speeds (n,) [m/s].
        w_r: The reference's turn rates (n,) [rad/s].
    """
    x, y, psi = e.T
    v, w = law.velocities(e, v_r, w_r)
    return np.stack([v_r * np.cos(psi) - v + y * w, v_r * np.sin(psi) - x * w, w_r - w], axis=-1)


@dataclass(frozen=True, kw_only=True, eq=False)
class CertificateTrial:
    """Trajectories of the nonlinear error dynamics from the region's boundary, under references that keep changing."""

    time: np.ndarray  # (steps + 1,) s
    errors: np.ndarray  # (steps + 1, starts, 3): x [m], y [m], ψ [rad]
    levels: np.ndarray  # (steps + 1, starts): V

    @property
    def steps(self) -> int:
        """The number of steps that were made, of all trajectories together."""
        return self.levels[1:].size

    @property
    def increases(self) -> int:
        """The number of steps in which V did not fall."""
        return int(np.count_nonzero(~(self.levels[1:] < self.levels[:-1])))

    @property
    def slowest(self) -> float:
        """The lowest decay rate of a step [1/s]."""
        return float((-np.diff(np.log(self.levels), axis=0) / (2 * np.diff(self.time)[:, None])).min())


def try_out(
    certificate: Certificate, starts: int = 1000, steps: int = 100, step: float = 0.01, hold: int = 5, seed: int = 0
) -> CertificateTrial:
    """Simulate trajectories of the nonlinear error dynamics from V = 1 (Runge-Kutta, order 4).

    v_r and ω_r jump to random places in their ranges, in a third of the cases to an end of them.

    Args:
        certificate: The certificate to try out.
        starts: Number of trajectories; they begin anywhere on the region's boundary.
        steps: Number of steps of each.
        step: Length of a step [s].
        hold: Number of steps between two jumps of v_r and ω_r.
        seed: Seed of the starts and of the jumps.
    """
    model, rng = certificate.model, np.random.default_rng(seed)
    e = certificate.boundary(rng.standard_normal((starts, 3)))
    errors = [e]
    for n in range(steps):
        if n % hold == 0:
            share = np.clip(rng.uniform(-0.25, 1.25, (2, starts)), 0, 1)
            v_r = model.speed_low + (model.speed_high - model.speed_low) * share[0]
            w_r = model.reference_turn * (2 * share[1] - 1)
        k = [error_rates(model.law, e, v_r, w_r)]
        for part in (0.5, 0.5, 1.0):
            k.append(error_rates(model.law, e + part * step * k[-1], v_r, w_r))
        e = e + step / 6 * (k[0] + 2 * k[1] + 2 * k[2] + k[3])
        errors.append(e)
    path = np.stack(errors)
    return CertificateTrial(time=step * np.arange(steps + 1), errors=path, levels=certificate.level(path))
