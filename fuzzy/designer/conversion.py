"""A membership function of another type at the same place and of the same width.

Between the types stands the equivalent trapezoid: it has the function's half-degree points (where the degree is 0.5)
and its slopes there; the vertices of piecewise functions are its own.
"""

import math
from typing import NamedTuple

from fuzzy.membership import (
    MATLAB_NAMES,
    Bell,
    Gaussian,
    LinearS,
    LinearZ,
    MembershipFunction,
    PiShape,
    Sigmoid,
    SigmoidDifference,
    SigmoidProduct,
    SShape,
    Trapezoid,
    Triangle,
    TwoSidedGaussian,
    ZShape,
    as_number,
    membership_function,
)

_HALF = math.sqrt(2 * math.log(2))  # a Gaussian's half-width at degree 0.5, in standard deviations
_OUTWARD = 4.0  # how many edges' widths an open side's crossover lies outside the universe


class Profile(NamedTuple):
    """The equivalent trapezoid; an open side has no vertices (None) and the degree 1 as far as one looks."""

    a: float | None  # left foot
    b: float | None  # left shoulder
    c: float | None  # right shoulder
    d: float | None  # right foot


def converted(function: MembershipFunction, kind: str, universe: tuple[float, float]) -> MembershipFunction:
    """``function`` as the function of the MATLAB name ``kind``.

    - Feet and shoulders stay where both types have them; a triangle's peak is the middle of the core, and curves keep
      the points of degree 0.5, about the middle of the core if they are symmetric.
    - A side that is open (linzmf to the left, say) is closed at the end of ``universe``, with the value 1 there.
    - A function with two sides becomes the one with one side that it has: linsmf, smf the left, linzmf, zmf the right,
      sigmf the one nearer the middle of the universe.

    Raises MembershipError for an unknown name.
    """
    if kind == type(function).matlab:
        return function
    if kind not in MATLAB_NAMES:
        return membership_function(kind, ())  # raises, with the names that there are
    low, high = universe
    span = (high - low) or 1.0
    profile = profile_of(function, span)
    new = MATLAB_NAMES[kind]
    parameters = _parameters(new, profile, low, high, span)
    # Computed widths and slopes need no more digits than a designer reads.
    tidy = [p if role == "location" else float(f"{p:.6g}") for p, role in zip(parameters, new.roles, strict=True)]
    return new(*tidy)


def profile_of(function: MembershipFunction, span: float) -> Profile:
    """The equivalent trapezoid of ``function``; ``span`` (> 0, unit of x) stands for widths that are without end."""
    p = [as_number(value) for value in function.parameters]
    match function:
        case Triangle():
            return Profile(p[0], p[1], p[1], p[2])
        case Trapezoid() | PiShape():
            return _ordered(*p)
        case LinearS() | SShape():
            return Profile(min(p), max(p), None, None)
        case LinearZ() | ZShape():
            return Profile(None, None, min(p), max(p))
        case Gaussian():
            half = _HALF * abs(p[0])
            return Profile(p[1] - 2 * half, p[1], p[1], p[1] + 2 * half)
        case TwoSidedGaussian():
            return _ordered(p[1] - 2 * _HALF * abs(p[0]), p[1], p[3], p[3] + 2 * _HALF * abs(p[2]))
        case Bell():
            half = abs(p[0])
            edge = min(2 * half / abs(p[1]) if p[1] else 2 * half, 2 * half)
            return _between(p[2] - half, p[2] + half, edge, edge)
        case Sigmoid():
            edge = _edge(p[0], span)
            if p[0] < 0:
                return Profile(None, None, p[1] - edge / 2, p[1] + edge / 2)
            return Profile(p[1] - edge / 2, p[1] + edge / 2, None, None)
        case SigmoidDifference():
            p[2] = -p[2]  # less a rising sigmoid is, near its edge, times a falling one
    rising = [(p[k + 1], _edge(p[k], span)) for k in (0, 2) if p[k] >= 0]
    falling = [(p[k + 1], _edge(p[k], span)) for k in (0, 2) if p[k] < 0]
    if len(rising) == 2:
        at, edge = max(rising)
        return Profile(at - edge / 2, at + edge / 2, None, None)
    if len(falling) == 2:
        at, edge = min(falling)
        return Profile(None, None, at - edge / 2, at + edge / 2)
    (left, up), (right, down) = rising[0], falling[0]
    return _between(min(left, right), max(left, right), up, down)


def _edge(slope: float, span: float) -> float:
    """The width of the straight edge that is as steep as a sigmoid at its crossover, where that is slope / 4."""
    return min(4 / abs(slope), span) if abs(slope) > 1e-300 else span


def _ordered(a: float, b: float, c: float, d: float) -> Profile:
    """Shoulders that cross (legal in MATLAB) meet in their middle; feet stay outside."""
    if b > c:
        b = c = min(max((b + c) / 2, a), max(a, d))
    return Profile(min(a, b), b, c, max(d, c))


def _between(left: float, right: float, up: float, down: float) -> Profile:
    """The trapezoid with the half-degree points left and right and edges of the widths up and down."""
    a, b, c, d = left - up / 2, left + up / 2, right - down / 2, right + down / 2
    if b > c:
        b = c = min(max((b + c) / 2, left), right)
        a, d = 2 * left - b, 2 * right - c
    return Profile(a, b, c, d)


def _parameters(
    kind: type[MembershipFunction], profile: Profile, low: float, high: float, span: float
) -> tuple[float, ...]:
    left, right = profile[:2], profile[2:]
    open_left, open_right = left[0] is None, right[0] is None
    # With both sides closed: a vertical edge at the end of the universe, or at the other side where that lies beyond.
    a, b = (min(low, right[0]),) * 2 if open_left else left  # type: ignore[type-var]
    c, d = (max(high, left[1]),) * 2 if open_right else right  # type: ignore[type-var]
    assert a is not None
    assert b is not None
    assert c is not None
    assert d is not None
    smallest = max(span / 1000, 1e-300)
    if kind is Triangle:
        return a, a if open_left else d if open_right else (b + c) / 2, d
    if kind in (Trapezoid, PiShape):
        return a, b, c, d
    if kind in (LinearS, SShape):
        return (c, d) if open_left else (a, b)
    if kind in (LinearZ, ZShape):
        return (a, b) if open_right else (c, d)
    up, down = max(b - a, smallest), max(d - c, smallest)
    if kind is Sigmoid:
        falls = open_left or (
            not open_right and abs((c + d) / 2 - (low + high) / 2) < abs((a + b) / 2 - (low + high) / 2)
        )
        return (-4 / down, (c + d) / 2) if falls else (4 / up, (a + b) / 2)
    if kind in (SigmoidDifference, SigmoidProduct):
        # An open side's edge lies so far outside that the degree is 1 in the universe.
        up, down = (span / 4 if open_left else up), (span / 4 if open_right else down)
        at = min(low, c) - _OUTWARD * up if open_left else (a + b) / 2
        to = max(high, b) + _OUTWARD * down if open_right else (c + d) / 2
        # Edges wider than half the way between would keep the degree far below 1.
        widest = max((to - at) / 2, smallest)
        up, down = min(up, widest), min(down, widest)
        return 4 / up, at, (4 if kind is SigmoidDifference else -4) / down, to
    if kind is TwoSidedGaussian:
        up, down = (down if open_left else up), (up if open_right else down)
        return up / (2 * _HALF), b, down / (2 * _HALF), c
    center = b if open_left else c if open_right else (b + c) / 2
    half = (d + c) / 2 - center if open_left else center - (a + b) / 2 if open_right else (c + d - a - b) / 4
    half = max(half, smallest)
    if kind is Gaussian:
        return half / _HALF, center
    assert kind is Bell
    edge = down if open_left else up if open_right else (up + down) / 2
    return half, 2 * half / edge, center
