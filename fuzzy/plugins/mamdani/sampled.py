"""Membership functions recognised in samples, as toolkits with sampled universes hold them."""

import warnings
from collections.abc import Iterator
from typing import Any, NamedTuple

import numpy as np

from fuzzy.membership import membership_function
from fuzzy.membershipfunction import MembershipError, MembershipFunction
from fuzzy.system import FuzzySystemError

EXACT = 1e-7  # of a degree; a greater error is told


class Recognised(NamedTuple):
    """A membership function, and its greatest error at the samples."""

    function: MembershipFunction
    error: float


def recognise(x: np.ndarray, degrees: np.ndarray) -> Recognised:
    """The membership function whose samples at ascending ``x`` (points,) are ``degrees`` (points,), or the nearest.

    Straight edges, Gaussians and sigmoids are found in closed form; bells, splines and Gaussians with two sides by
    least squares. Raises FuzzySystemError for samples that are no membership function.
    """
    x, degrees = np.asarray(x, dtype=float), np.asarray(degrees, dtype=float)
    if x.shape != degrees.shape or x.ndim != 1 or len(x) < 3 or not (np.diff(x) > 0).all():
        raise FuzzySystemError("a sampled membership function needs three or more ascending places, and a degree each")
    if not (np.isfinite(degrees).all() and degrees.max() > 0):
        raise FuzzySystemError("a sampled membership function must be finite and somewhere above 0")
    best: Recognised | None = None
    for kind, parameters in _candidates(x, degrees):
        try:
            with warnings.catch_warnings(action="ignore", category=RuntimeWarning), np.errstate(all="ignore"):
                function = membership_function(kind, [float(p) for p in parameters])
                error = float(np.abs(np.asarray(function(x)) - degrees).max())
        except MembershipError:
            continue
        if np.isfinite(error) and (best is None or error < best.error):
            best = Recognised(function, error)
            if error <= EXACT:
                break
    if best is None:
        raise FuzzySystemError("no membership function comes near the samples")
    return best


def _candidates(x: np.ndarray, y: np.ndarray) -> Iterator[tuple[str, Any]]:
    """Kinds and parameters, the simplest and exact ones first."""
    yield from _straight(x, y)
    inside = (y > 1e-8) & (y < 1)
    if inside.sum() >= 3:
        with np.errstate(all="ignore"):
            square, slope, _ = np.polyfit(x[inside], np.log(y[inside]), 2, w=y[inside])
            if square < 0:
                yield "gaussmf", (np.sqrt(-1 / (2 * square)), -slope / (2 * square))
            steep, level = np.polyfit(
                x[inside], np.log(y[inside] / (1 - y[inside])), 1, w=y[inside] * (1 - y[inside]) + 1e-12
            )
            if steep != 0:
                yield "sigmf", (steep, -level / steep)
    yield from _fitted(x, y)


def _straight(x: np.ndarray, y: np.ndarray) -> Iterator[tuple[str, Any]]:
    """Triangles and trapezoids whose vertices are samples, or where lines through the edges' samples meet 0 and 1."""
    top = np.flatnonzero(y >= y.max() - 1e-12)
    left, right = top[0], top[-1]
    zeros = np.flatnonzero(y <= 1e-12)
    before, after = zeros[zeros < left], zeros[zeros > right]
    a = x[before[-1]] if len(before) else x[left]
    d = x[after[0]] if len(after) else x[right]
    if left == right:
        yield "trimf", (a, x[left], d)
    yield "trapmf", (a, x[left], x[right], d)
    rising = [i for i in range(left) if 1e-12 < y[i] < 1]
    falling = [i for i in range(right + 1, len(x)) if 1e-12 < y[i] < 1]
    up, down = (_line(x[part], y[part]) if len(part) >= 2 else None for part in (rising, falling))
    a, b = (-up[1] / up[0], (1 - up[1]) / up[0]) if up else (a, x[left])
    c, d = ((1 - down[1]) / down[0], -down[1] / down[0]) if down else (x[right], d)
    if up and down and up[0] > 0 > down[0]:
        yield "trimf", (a, (b + c) / 2, d)
    yield "trapmf", (a, b, c, d)


def _line(x: np.ndarray, y: np.ndarray) -> tuple[float, float] | None:
    slope, level = np.polyfit(x, y, 1)
    return (float(slope), float(level)) if slope != 0 else None


def _fitted(x: np.ndarray, y: np.ndarray) -> Iterator[tuple[str, Any]]:
    from scipy.optimize import least_squares

    half = np.flatnonzero(y >= y.max() / 2)
    low, high = x[half[0]], x[half[-1]]
    width, middle, span = max((high - low) / 2, (x[-1] - x[0]) / 50), (low + high) / 2, x[-1] - x[0]
    edges = (low - width / 2, low + width / 2, high - width / 2, high + width / 2)
    starts: dict[str, Any] = {
        "gbellmf": (width, 2.0, middle),
        "smf": (low - span / 10, low + span / 10),
        "zmf": (high - span / 10, high + span / 10),
        "pimf": edges,
        "gauss2mf": (width / 2, low + width / 2, width / 2, high - width / 2),
        "dsigmf": (4 / width, low, 4 / width, high),
        "psigmf": (4 / width, low, -4 / width, high),
    }
    for kind, start in starts.items():

        def residual(parameters: np.ndarray, kind: str = kind) -> np.ndarray:
            try:
                return np.asarray(membership_function(kind, [float(p) for p in parameters])(x)) - y
            except MembershipError:
                return np.ones_like(y)

        with np.errstate(all="ignore"):
            try:
                yield kind, least_squares(residual, start, x_scale=np.abs(start) + 1e-3, xtol=1e-15, ftol=1e-15).x
            except ValueError:
                continue
