"""The certificate of a law behind a low-pass, whose V is also of the commands on their way to the wheels.

Candidates for V come from a semidefinite program about the loop linearised near the path [Boyd et al. 1994]; what they
are worth says the proof alone (:mod:`robotics.plugins.certificates.statedecrease`).
"""

import itertools
import math
import time
import warnings
from dataclasses import dataclass
from typing import Any

import numpy as np

from robotics.plugins.certificates.certificate import CertificateError, cvxpy_module
from robotics.plugins.certificates.certificatefile import numbers_of
from robotics.plugins.certificates.checker import RefutedError
from robotics.plugins.certificates.loopcolumns import LoopColumns
from robotics.plugins.certificates.loopmodel import ClosedLoop
from robotics.plugins.certificates.regions import LoopCertificate, SearchEffort, cells_of, certify_loop, where
from robotics.plugins.certificates.starts import asked
from robotics.plugins.certificates.statechecker import FALL_SLACK, check_states
from robotics.plugins.certificates.statedecrease import StateLoop, check_cell
from robotics.plugins.certificates.wheels import WINDOW, Drives

_FALLS = (0.955, 0.965, 0.975)  # of √V in a period, of candidates
_SIZES = (0.5, 0.42, 0.35, 0.3, 0.25, 0.2, 0.16, 0.12, 0.09)  # rad: how far the heading error may reach
_ENDS = (0.9, 0.75, 0.55, 0.4)  # √V in the end, of the region's
_GAINS = (1.0, 1.0), (1.3, 1.1)  # by how much more of a and b the law may ask for, too, in what it must fall for
_ASIDE = 0.13  # of v_r: by how much more or less a robot may drive in what a candidate must fall for
_USUAL = (0.08, 0.12, 0.5, 0.1, 1.0)  # X [m], Y [m], ψ [rad], corrections [m/s] and [rad/s] that count as much
_NOISE = 1.25  # times what noise is seen to change of what the law asks for
_INNER = 0.03  # √V, of the region's, below which the checker asks for no fall
_TOO_SLOW = "no quadratic function of the errors and of the commands on their way is seen to fall"


@dataclass(frozen=True, eq=False)
class StateCertificate:
    """A region V <= 1 of errors and of commands on their way that no trajectory leaves.

    For each range of the reference's speed there is a V of its own: √V(k+1) <= fall √V(k) + past max √V + added, the
    greatest of the last :data:`.wheels.WINDOW` + 1 samples.

    Attributes:
        loop: The law under its assumptions.
        cells: Of each range: speed [m/s] (2,), P (n, n), fall and inner, as the file has them.
        past: Of each.
        added: Of each.
        boxes: How many boxes the proof looked at.
    """

    loop: ClosedLoop
    cells: tuple[dict[str, Any], ...]
    past: np.ndarray
    added: np.ndarray
    boxes: int

    region = 1.0  # V on the region's boundary
    from_reference = True  # where the robot drives as its reference does before the start

    @property
    def _falls(self) -> np.ndarray:
        return np.array([cell["fall"] for cell in self.cells]) + FALL_SLACK

    @property
    def ultimate(self) -> float:
        """V below which every trajectory comes, of all speeds."""
        return float(np.maximum(self.added / (1 - self._falls - self.past), _INNER).max() ** 2)

    @property
    def rate(self) -> float:
        """The decay rate of √V towards its end [1/s]: by r with r^(N + 1) = fall r^N + past."""
        low, high, samples = np.zeros(len(self.past)), np.ones(len(self.past)), WINDOW + 1
        for _ in range(60):
            r = (low + high) / 2
            enough = r ** (samples + 1) >= self._falls * r**samples + self.past
            low, high = np.where(enough, low, r), np.where(enough, r, high)
        return -math.log(float(high.max())) / self.loop.model.period

    @property
    def P(self) -> np.ndarray:
        """z'Pz of z = (X, Y, ψ) is at least V, of all speeds, where the robot drives as its reference does (3, 3)."""
        return _outside([np.array(cell["P"])[:3, :3] for cell in self.cells])

    def half_widths(self, level: float | None = None) -> np.ndarray:
        """How far V <= level reaches (3,), whatever was told; without a level, where starts as the reference may be."""
        if level is None:
            return np.sqrt(np.diag(np.linalg.inv(self.P)))
        return np.sqrt(level * np.max([np.diag(np.linalg.inv(cell["P"]))[:3] for cell in self.cells], axis=0))

    def level(self, errors: np.ndarray) -> np.ndarray:
        """A bound of V (...) of errors (..., 3) of a robot that drives as its reference does."""
        return np.asarray(np.einsum("...i,ij,...j->...", errors, self.P, errors))

    def levels(self, errors: np.ndarray, drives: Drives) -> np.ndarray:
        """V (samples, starts) of errors (samples, starts, 3) and of the commands before them, told since rest."""
        steady = drives.commands[0]
        told, groups = drives.commands - steady, int(LoopColumns(self.loop.numbers).groups)
        ages = [told[WINDOW + 1 - age : WINDOW + 1 - age + len(errors)] for age in range(1, groups)]
        z = np.concatenate([errors, *(np.stack([e[:, i] for e in ages], axis=-1) for i in range(2))], axis=-1)
        found = np.empty(z.shape[:2])
        for cell in self.cells:
            here = (steady[0] >= cell["speed"][0]) & (steady[0] <= cell["speed"][1])
            found[:, here] = np.einsum("ksi,ij,ksj->ks", z[:, here], np.array(cell["P"]), z[:, here])
        return found


def _outside(forms: list[np.ndarray]) -> np.ndarray:
    """A form that is at least each of some: the greatest by eigenvalues beside their mean."""
    root = np.linalg.cholesky(sum(forms) / len(forms))
    inverse = np.linalg.inv(root)
    most = max(float(np.linalg.eigvalsh(inverse @ form @ inverse.T)[-1]) for form in forms)
    return np.asarray(most * (1 + 1e-9) * root @ root.T)


def certified(loop: ClosedLoop, effort: SearchEffort) -> tuple[LoopCertificate | StateCertificate | None, str]:
    """The certificate of a loop, of the commands' states where it has a low-pass; or None, and what is in the way."""
    why = ""
    if LoopColumns(loop.numbers).fresh < 1:
        found = certify_states(loop, effort.seconds)
        if isinstance(found, StateCertificate):
            return found, ""
        why = f"{found}; with V of the errors alone: "
    other, failure = certify_loop(loop, effort)
    return other, "" if failure is None else why + where(failure)


def certify_states(loop: ClosedLoop, seconds: float) -> StateCertificate | str:
    """The largest region that is found, speeds one after another; or why there is none.

    Args:
        loop: The law under its assumptions.
        seconds: After which no better one is looked for.
    """
    ends, cells, added, boxes = time.monotonic() + seconds, [], [], 0
    try:
        cvxpy_module()
    except CertificateError as error:
        return str(error)
    numbers = numbers_of(loop)
    ranges = [(float(cell[0, 0]), float(cell[0, 1])) for cell in cells_of(loop)]
    for k, speed in enumerate(ranges):
        found = _cell(loop, numbers, speed, time.monotonic() + (ends - time.monotonic()) / (len(ranges) - k))
        if isinstance(found, str):
            return f"{found}, v_r {speed[0]:.3g} to {speed[1]:.3g} m/s"
        cells.append(found[0])
        added.append(found[1])
        boxes += found[2]
    if loop.model.noise.any():  # what it changes is proven by the checker alone
        try:
            check_states(numbers | {"V": cells})
        except RefutedError as error:
            return str(error)
    past, off = np.array(added).T
    return StateCertificate(loop, tuple(cells), past, off, boxes)


def _cell(
    loop: ClosedLoop, numbers: dict[str, Any], speed: tuple[float, float], until: float
) -> tuple[dict[str, Any], tuple[float, float], int] | str:
    """The best V of one range of speeds, with κ, what is added, and the boxes that it took; or why there is none."""
    best, greatest, why = None, 0.0, _TOO_SLOW
    for most, fall in itertools.product(_GAINS, _FALLS):
        steps = [
            _step(loop, v, s * v * loop.model.curvature, o * _ASIDE * v, np.array([[p], [q]]))
            for v, s, o in itertools.product(speed, (-1, 1), (-1, 1))
            for p, q in {(1.0, 1.0), (most[0], 1.0), (1.0, most[1]), most}
        ]
        P = None if best and time.monotonic() > until else _candidate(steps, fall)
        if P is None:
            continue
        for size in _SIZES:
            scaled = P * np.linalg.inv(P[:3, :3])[2, 2] / size**2
            volume = np.linalg.det(scaled[:3, :3]) ** -0.5
            if volume < 1.1 * greatest or (best and time.monotonic() > until):
                break
            noise = _noise_asked(loop, scaled, speed)
            for end in _ENDS:
                cell = {"speed": list(speed), "P": scaled.tolist(), "fall": fall, "inner": _INNER, "noise": noise}
                try:
                    near = StateLoop(numbers["loop"], cell)
                    cell["fall"] = 1 - FALL_SLACK - near.past - near.off / end
                    boxes, near = check_cell(numbers, cell)
                except RefutedError as error:
                    why = str(error) if best is None else why
                    break
                best, greatest = (cell, (near.past, near.off), boxes), volume
            if greatest == volume:
                break
    return best or why


def _noise_asked(loop: ClosedLoop, P: np.ndarray, speed: tuple[float, float]) -> list[float]:
    """By how much noise is seen to change what the law asks for in V <= 1, v [m/s] and ω [rad/s], and more."""
    if not (noise := loop.model.noise).any():
        return [0.0, 0.0]
    rng, corners = np.random.default_rng(0), np.array([*itertools.product((-1.0, 1.0), repeat=3)]) * noise
    z = rng.standard_normal((500, 3))
    z *= rng.random((500, 1)) ** (1 / 3) / np.linalg.norm(z, axis=1, keepdims=True)
    z = z @ np.linalg.cholesky(np.linalg.inv(P)[:3, :3]).T
    v = rng.choice(speed, 500)
    w = v * rng.choice([-1, 1], 500) * loop.model.curvature
    there = np.array(asked(loop, z, v, w))
    return (_NOISE * np.max([abs(asked(loop, z + n, v, w) - there) for n in corners], axis=(0, 2))).tolist()


def _step(loop: ClosedLoop, v: float, w: float, off: float, gain: np.ndarray) -> np.ndarray:
    """The linearised loop ζ(k+1) = A ζ (n, n), with other gains, of a robot so much faster than its reference."""
    k = LoopColumns(loop.numbers)
    groups, t, s, h = int(k.groups), float(k.period), float(k.fresh), 1e-5
    near = np.vstack([np.eye(3), -np.eye(3)]) * h
    said = np.array(asked(loop, near, np.full(6, v), np.full(6, w)))
    said, n = gain * (said[:, :3] - said[:, 3:]) / (2 * h), 2 * groups + 1
    told = np.zeros((2, groups, n))
    for i in range(2):
        first = 3 + i * (groups - 1)
        told[i, 0, :3], told[i, 0, first] = s * said[i], 1 - s
        told[i, 1:, first : first + groups - 1] = np.eye(groups - 1)
    a, b = np.asarray(k.v_weight[:groups], float) @ told[0], np.asarray(k.w_weight[:groups], float) @ told[1]
    step, unit = np.empty((n, n)), np.eye(n)
    cos, sin = math.cos(w * t), math.sin(w * t)
    step[0] = cos * unit[0] + sin * unit[1] - t * a
    step[1] = cos * unit[1] - sin * unit[0] + (v + off) * t * unit[2] - v * t * t / 2 * b
    step[2] = unit[2] - t * b
    step[3:] = np.vstack([told[0, :-1], told[1, :-1]])
    return step


def _candidate(steps: list[np.ndarray], fall: float) -> np.ndarray | None:
    """P (n, n), by which √V falls by ``fall`` in each of some linear loops, or None."""
    cp, n = cvxpy_module(), len(steps[0])
    scale = np.array([*_USUAL[:3], *np.repeat(_USUAL[3:], (n - 3) // 2)])
    P = cp.Variable((n, n), symmetric=True)
    scaled = [step * scale / scale[:, None] for step in steps]
    falls = [fall**2 * P - A.T @ P @ A >> 0 for A in scaled]
    problem = cp.Problem(cp.Minimize(cp.trace(P)), [P >> np.eye(n), *falls])
    with warnings.catch_warnings(action="ignore"):
        try:
            problem.solve(solver="CLARABEL")
        except cp.error.SolverError:
            return None
    if P.value is None or not np.isfinite(P.value).all():
        return None
    value = P.value / np.outer(scale, scale)
    return np.asarray((value + value.T) / 2)
