"""Membership functions: one formula each, written once for every array library.

A membership function is a frozen dataclass of its parameters, in MATLAB's order and with MATLAB's letters.
Calling it evaluates it: ``Triangle(0, 1, 2)(x)`` has the shape of ``x``.

Each class states its formula in one of two ways:

- ``formula(x, *parameters)``: the degree of membership in [0, 1];
- ``log_formula(x, *parameters)`` for functions that are positive everywhere: the logarithm of the degree.
  Products of many such degrees underflow where the sum of their logarithms does not, so inference uses it.

Both formulas take arrays that broadcast, ask ``x`` for its namespace and never write into an array. They serve
numpy, torch (with gradients, on any device) and every other array of the array-API standard. At a joint the
gradient is that of one of the two sides, or lies between them; it is never NaN.

The other facts that a class states are those of :class:`fuzzy.membershipfunction.MembershipFunction`. Only the last
digits of compiled code, C and pictures need more than the class: CONTRIBUTING.md names the files.

Sources: [MATLAB fismf] for names, order and the degenerate cases; [Jang 1993] for the bell.
"""

from collections.abc import Callable
from dataclasses import dataclass, field, fields, replace
from typing import Any, ClassVar

import numpy as np
from array_api_compat import array_namespace

from fuzzy.membershipfunction import (
    MATLAB_NAMES,
    Array,
    Grid,
    MembershipError,
    MembershipFunction,
    parameter,
    register,
)
from fuzzy.naming import check_known
from fuzzy.profile import HALF_WIDTH, Outline, Profile

# The building blocks ------------------------------------------------------------------------------------------


def _rise(x: Array, a: Array, b: Array) -> Array:
    """0 up to a, 1 from b on, straight between; a = b is a vertical edge with the value 1 at the edge."""
    xp = array_namespace(x)
    steep = b > a
    width = xp.where(steep, b - a, xp.ones_like(b - a))
    slope = xp.clip((x - a) / width, 0.0, 1.0)
    edge = xp.astype(x >= b, x.dtype)
    return xp.where(steep, slope, edge)


def _fall(x: Array, c: Array, d: Array) -> Array:
    """1 up to c, 0 from d on; the mirror image of :func:`_rise`, with the value 1 at a vertical edge."""
    return _rise(-x, -d, -c)


def _s(x: Array, a: Array, b: Array) -> Array:
    """Quadratic spline from 0 at a to 1 at b; a >= b is a step, 1 from the middle on."""
    xp = array_namespace(x)
    smooth = b > a
    width = xp.where(smooth, b - a, xp.ones_like(b - a))
    z = xp.clip((x - a) / width, 0.0, 1.0)
    spline = xp.where(z < 0.5, 2 * z**2, 1 - 2 * (1 - z) ** 2)
    step = xp.astype(x >= (a + b) / 2, x.dtype)
    return xp.where(smooth, spline, step)


def _log_gauss(x: Array, sigma: Array, c: Array) -> Array:
    with np.errstate(over="ignore"):  # far away the logarithm is -inf
        return -0.5 * ((x - c) / sigma) ** 2


def _log_sigmoid(x: Array, a: Array, c: Array) -> Array:
    # log(1 / (1 + e^-z)) as -logaddexp(0, -z): neither the value nor the gradient overflows.
    xp = array_namespace(x)
    z = a * (x - c)
    return -xp.logaddexp(xp.zeros_like(z), -z)


def _sigmoid(x: Array, a: Array, c: Array) -> Array:
    return array_namespace(x).exp(_log_sigmoid(x, a, c))


def _log_two_sided_gauss(x: Array, s1: Array, c1: Array, s2: Array, c2: Array) -> Array:
    # clip instead of where: beyond the center the deviation is 0, and so is its gradient.
    xp = array_namespace(x)
    zero = xp.zeros_like(x - c1)
    return _log_gauss(xp.minimum(x - c1, zero), s1, zero) + _log_gauss(xp.maximum(x - c2, zero), s2, zero)


def _log_bell(x: Array, a: Array, b: Array, c: Array) -> Array:
    # 1 + |z|^2b = exp(logaddexp(0, 2b log|z|)). At z = 0 the logarithm's own gradient would be infinite, and
    # inf · 0 = NaN: the center is set apart, with the gradient 0 of a smooth bell.
    xp = array_namespace(x)
    z = xp.abs((x - c) / a)
    away = z > 0
    exponent = 2 * b * xp.log(xp.where(away, z, xp.ones_like(z)))
    infinite = xp.full_like(b, xp.inf)
    center = xp.where(b > 0, -infinite, xp.where(b < 0, infinite, xp.zeros_like(b)))
    exponent = xp.where(away, exponent, center)
    return -xp.logaddexp(xp.zeros_like(exponent), exponent)


def _log_sigmoid_product(x: Array, a1: Array, c1: Array, a2: Array, c2: Array) -> Array:
    return _log_sigmoid(x, a1, c1) + _log_sigmoid(x, a2, c2)


# The scales of profiles and grids
_WIDTH = 1 / HALF_WIDTH  # the standard deviation of a Gaussian that is 0.5 at the distance 1
_OUTWARD = 4.0  # how many edges' widths an open side's crossover lies outside the universe


# The functions ------------------------------------------------------------------------------------------------


@register
@dataclass(frozen=True)
class Triangle(MembershipFunction):
    """trimf [a b c]: max(0, min((x − a)/(b − a), (c − x)/(c − b))), with a ≤ b ≤ c.

    a = b or b = c makes a vertical edge, where the value is 1 (a shoulder's foot).
    """

    a: Any = field(metadata=parameter("location", "left foot"))
    b: Any = field(metadata=parameter("location", "peak"))
    c: Any = field(metadata=parameter("location", "right foot"))
    matlab: ClassVar[str] = "trimf"
    title: ClassVar[str] = "triangle"
    vertices: ClassVar[tuple[int, ...]] = (0, 1, 2)
    grid: ClassVar[Grid] = staticmethod(lambda c, h, slope: (c - 2 * h, c, c + 2 * h))

    @classmethod
    def formula(cls, x: Array, *parameters: Array) -> Array:  # noqa: D102
        a, b, c = parameters
        return array_namespace(x).minimum(_rise(x, a, b), _fall(x, b, c))

    def profile(self, span: float) -> Profile:  # noqa: D102
        a, b, c = self.numbers
        return Profile(a, b, b, c)

    @classmethod
    def fitted(cls, outline: Outline) -> tuple[float, ...]:  # noqa: D102
        a, b, c, d = outline.a, outline.b, outline.c, outline.d
        return a, a if outline.open_left else d if outline.open_right else (b + c) / 2, d


@dataclass(frozen=True)
class _FourVertices(MembershipFunction):
    """Two edges with a core between them."""

    a: Any = field(metadata=parameter("location", "left foot"))
    b: Any = field(metadata=parameter("location", "left shoulder"))
    c: Any = field(metadata=parameter("location", "right shoulder"))
    d: Any = field(metadata=parameter("location", "right foot"))
    vertices: ClassVar[tuple[int, ...]] = (0, 1, 2, 3)
    grid: ClassVar[Grid] = staticmethod(lambda c, h, slope: (c - 1.4 * h, c - 0.6 * h, c + 0.6 * h, c + 1.4 * h))

    def profile(self, span: float) -> Profile:
        return Profile.ordered(*self.numbers)

    @classmethod
    def fitted(cls, outline: Outline) -> tuple[float, ...]:
        return outline.a, outline.b, outline.c, outline.d


@dataclass(frozen=True)
class _Rising(MembershipFunction):
    """One edge, with the degree 1 to its right."""

    a: Any = field(metadata=parameter("location", "foot"))
    b: Any = field(metadata=parameter("location", "shoulder"))
    vertices: ClassVar[tuple[int, ...]] = (0, 1)

    def profile(self, span: float) -> Profile:
        return Profile(min(self.numbers), max(self.numbers), None, None)

    @classmethod
    def fitted(cls, outline: Outline) -> tuple[float, ...]:
        return (outline.c, outline.d) if outline.open_left else (outline.a, outline.b)


@dataclass(frozen=True)
class _Falling(MembershipFunction):
    """One edge, with the degree 1 to its left."""

    a: Any = field(metadata=parameter("location", "shoulder"))
    b: Any = field(metadata=parameter("location", "foot"))
    vertices: ClassVar[tuple[int, ...]] = (0, 1)

    def profile(self, span: float) -> Profile:
        return Profile(None, None, min(self.numbers), max(self.numbers))

    @classmethod
    def fitted(cls, outline: Outline) -> tuple[float, ...]:
        return (outline.a, outline.b) if outline.open_right else (outline.c, outline.d)


@register
@dataclass(frozen=True)
class Trapezoid(_FourVertices):
    """trapmf [a b c d]: max(0, min((x − a)/(b − a), 1, (d − x)/(d − c))), with a ≤ b and c ≤ d.

    a = b or c = d makes a vertical edge with the value 1. b > c is legal, as in MATLAB: a triangle whose peak
    lies below 1.
    """

    matlab: ClassVar[str] = "trapmf"
    title: ClassVar[str] = "trapezoid"
    may_cross: ClassVar[tuple[int, ...]] = (1,)

    @classmethod
    def formula(cls, x: Array, *parameters: Array) -> Array:  # noqa: D102
        a, b, c, d = parameters
        return array_namespace(x).minimum(_rise(x, a, b), _fall(x, c, d))


@register
@dataclass(frozen=True)
class LinearS(_Rising):
    """linsmf [a b]: 0 up to a, 1 from b on, straight between, with a ≤ b; a = b is a step that is 1 for x ≥ a."""

    matlab: ClassVar[str] = "linsmf"
    title: ClassVar[str] = "straight ramp up"

    @classmethod
    def formula(cls, x: Array, *parameters: Array) -> Array:  # noqa: D102
        return _rise(x, *parameters)


@register
@dataclass(frozen=True)
class LinearZ(_Falling):
    """linzmf [a b] = 1 − linsmf [a b]: 1 up to a, 0 from b on; a = b is a step that is 0 for x ≥ a."""

    matlab: ClassVar[str] = "linzmf"
    title: ClassVar[str] = "straight ramp down"

    @classmethod
    def formula(cls, x: Array, *parameters: Array) -> Array:  # noqa: D102
        return 1 - _rise(x, *parameters)


@register
@dataclass(frozen=True)
class Gaussian(MembershipFunction):
    """gaussmf [sigma c]: exp(−(x − c)² / 2σ²), with σ ≠ 0 (only its square counts)."""

    sigma: Any = field(metadata=parameter("width", "width σ"))  # standard deviation
    c: Any = field(metadata=parameter("location", "centre"))
    matlab: ClassVar[str] = "gaussmf"
    title: ClassVar[str] = "Gaussian"
    log_formula: ClassVar[Callable[..., Array]] = staticmethod(_log_gauss)
    grid: ClassVar[Grid] = staticmethod(lambda c, h, slope: (h * _WIDTH, c))

    def profile(self, span: float) -> Profile:  # noqa: D102
        sigma, c = self.numbers
        half = HALF_WIDTH * abs(sigma)
        return Profile(c - 2 * half, c, c, c + 2 * half)

    @classmethod
    def fitted(cls, outline: Outline) -> tuple[float, ...]:  # noqa: D102
        return outline.half / HALF_WIDTH, outline.center

    def powered(self, power: float) -> MembershipFunction:  # noqa: D102
        return replace(self, sigma=self.sigma / power**0.5)


@register
@dataclass(frozen=True)
class TwoSidedGaussian(MembershipFunction):
    """gauss2mf [s1 c1 s2 c2]: Gaussian shoulders left of c1 and right of c2, 1 between.

    c1 > c2 is legal, as in MATLAB: the product of the two shoulders, whose maximum lies below 1.
    """

    s1: Any = field(metadata=parameter("width", "left width σ₁"))  # standard deviation of the left shoulder
    c1: Any = field(metadata=parameter("location", "left end c₁"))
    s2: Any = field(metadata=parameter("width", "right width σ₂"))
    c2: Any = field(metadata=parameter("location", "right end c₂"))
    matlab: ClassVar[str] = "gauss2mf"
    title: ClassVar[str] = "two-sided Gaussian"
    vertices: ClassVar[tuple[int, ...]] = (1, 3)
    may_cross: ClassVar[tuple[int, ...]] = (1,)
    log_formula: ClassVar[Callable[..., Array]] = staticmethod(_log_two_sided_gauss)
    grid: ClassVar[Grid] = staticmethod(
        lambda c, h, slope: (0.4 * h * _WIDTH, c - 0.6 * h, 0.4 * h * _WIDTH, c + 0.6 * h)
    )

    def profile(self, span: float) -> Profile:  # noqa: D102
        s1, c1, s2, c2 = self.numbers
        return Profile.ordered(c1 - 2 * HALF_WIDTH * abs(s1), c1, c2, c2 + 2 * HALF_WIDTH * abs(s2))

    @classmethod
    def fitted(cls, outline: Outline) -> tuple[float, ...]:  # noqa: D102
        up = outline.down if outline.open_left else outline.up
        down = outline.up if outline.open_right else outline.down
        return up / (2 * HALF_WIDTH), outline.b, down / (2 * HALF_WIDTH), outline.c

    def powered(self, power: float) -> MembershipFunction:  # noqa: D102
        return replace(self, s1=self.s1 / power**0.5, s2=self.s2 / power**0.5)


@register
@dataclass(frozen=True)
class Bell(MembershipFunction):
    """gbellmf [a b c]: 1 / (1 + |(x − c)/a|^2b), with a ≠ 0   [Jang 1993, layer 1].

    |a| is the half-width at 0.5; the slope there is −b/2a. A negative b turns the bell upside down, as in MATLAB.
    """

    a: Any = field(metadata=parameter("width", "half-width a"))  # at degree 0.5
    b: Any = field(metadata=parameter("shape", "steepness b"))
    c: Any = field(metadata=parameter("location", "centre c"))
    matlab: ClassVar[str] = "gbellmf"
    title: ClassVar[str] = "bell"
    log_formula: ClassVar[Callable[..., Array]] = staticmethod(_log_bell)
    grid: ClassVar[Grid] = staticmethod(lambda c, h, slope: (h, 2, c))

    def profile(self, span: float) -> Profile:  # noqa: D102
        a, b, c = self.numbers
        half = abs(a)
        edge = min(2 * half / abs(b) if b else 2 * half, 2 * half)
        return Profile.between(c - half, c + half, edge, edge)

    @classmethod
    def fitted(cls, outline: Outline) -> tuple[float, ...]:  # noqa: D102
        up, down = outline.up, outline.down
        edge = down if outline.open_left else up if outline.open_right else (up + down) / 2
        return outline.half, 2 * outline.half / edge, outline.center


def _edge(slope: float, span: float) -> float:
    """The width of the straight edge that is as steep as a sigmoid at its crossover, where that is slope / 4."""
    return min(4 / abs(slope), span) if abs(slope) > 1e-300 else span


@register
@dataclass(frozen=True)
class Sigmoid(MembershipFunction):
    """sigmf [a c]: 1 / (1 + exp(−a (x − c))); a < 0 opens to the left."""

    a: Any = field(metadata=parameter("slope", "slope a"))
    c: Any = field(metadata=parameter("location", "crossover c"))  # where the degree is 0.5
    matlab: ClassVar[str] = "sigmf"
    title: ClassVar[str] = "sigmoid"
    log_formula: ClassVar[Callable[..., Array]] = staticmethod(_log_sigmoid)

    def profile(self, span: float) -> Profile:  # noqa: D102
        a, c = self.numbers
        edge = _edge(a, span)
        sides = c - edge / 2, c + edge / 2
        return Profile(None, None, *sides) if a < 0 else Profile(*sides, None, None)

    @classmethod
    def fitted(cls, outline: Outline) -> tuple[float, ...]:  # noqa: D102
        left, right = (outline.a + outline.b) / 2, (outline.c + outline.d) / 2
        middle = (outline.low + outline.high) / 2
        # Of two edges it becomes the one that is nearer the middle of the universe.
        falls = outline.open_left or (not outline.open_right and abs(right - middle) < abs(left - middle))
        return (-4 / outline.down, right) if falls else (4 / outline.up, left)

    def powered(self, power: float) -> MembershipFunction | None:  # noqa: D102
        return SigmoidProduct(self.a, self.c, self.a, self.c) if power == 2 else None


@dataclass(frozen=True)
class _TwoSigmoids(MembershipFunction):
    """Two sigmoids, the second of which counts with the sign ``second`` of its slope."""

    a1: Any = field(metadata=parameter("slope", "slope a₁"))
    c1: Any = field(metadata=parameter("location", "crossover c₁"))
    a2: Any = field(metadata=parameter("slope", "slope a₂"))
    c2: Any = field(metadata=parameter("location", "crossover c₂"))
    second: ClassVar[int]

    def profile(self, span: float) -> Profile:
        a1, c1, a2, c2 = self.numbers
        sides = [(a1, c1), (self.second * a2, c2)]
        rising = [(c, _edge(a, span)) for a, c in sides if a >= 0]
        falling = [(c, _edge(a, span)) for a, c in sides if a < 0]
        if len(rising) == 2:
            at, edge = max(rising)
            return Profile(at - edge / 2, at + edge / 2, None, None)
        if len(falling) == 2:
            at, edge = min(falling)
            return Profile(None, None, at - edge / 2, at + edge / 2)
        (left, up), (right, down) = rising[0], falling[0]
        return Profile.between(min(left, right), max(left, right), up, down)

    @classmethod
    def fitted(cls, outline: Outline) -> tuple[float, ...]:
        # The edge of a side that was open lies so far outside that the degree is 1 in the universe.
        up = outline.span / 4 if outline.open_left else outline.up
        down = outline.span / 4 if outline.open_right else outline.down
        at, to = (outline.a + outline.b) / 2, (outline.c + outline.d) / 2
        if outline.open_left:
            at = min(outline.low, outline.c) - _OUTWARD * up
        if outline.open_right:
            to = max(outline.high, outline.b) + _OUTWARD * down
        # Edges wider than half the way between would keep the degree far below 1.
        widest = max((to - at) / 2, outline.smallest)
        return 4 / min(up, widest), at, -4 * cls.second / min(down, widest), to


@register
@dataclass(frozen=True)
class SigmoidDifference(_TwoSigmoids):
    """dsigmf [a1 c1 a2 c2]: sigmf[a1 c1] − sigmf[a2 c2], not below 0 (a degree cannot be negative)."""

    matlab: ClassVar[str] = "dsigmf"
    title: ClassVar[str] = "difference of sigmoids"
    second: ClassVar[int] = -1  # near its edge, minus a rising sigmoid is like times a falling one
    grid: ClassVar[Grid] = staticmethod(lambda c, h, slope: (slope, c - h, slope, c + h))

    @classmethod
    def formula(cls, x: Array, *parameters: Array) -> Array:  # noqa: D102
        a1, c1, a2, c2 = parameters
        with np.errstate(under="ignore"):
            return array_namespace(x).clip(_sigmoid(x, a1, c1) - _sigmoid(x, a2, c2), 0.0, 1.0)


@register
@dataclass(frozen=True)
class SigmoidProduct(_TwoSigmoids):
    """psigmf [a1 c1 a2 c2]: sigmf[a1 c1] · sigmf[a2 c2]."""

    matlab: ClassVar[str] = "psigmf"
    title: ClassVar[str] = "product of sigmoids"
    second: ClassVar[int] = 1
    log_formula: ClassVar[Callable[..., Array]] = staticmethod(_log_sigmoid_product)
    grid: ClassVar[Grid] = staticmethod(lambda c, h, slope: (slope, c - h, -slope, c + h))


@register
@dataclass(frozen=True)
class SShape(_Rising):
    """smf [a b]: quadratic spline from 0 at a to 1 at b, 0.5 in the middle; a ≥ b is a step at the middle."""

    matlab: ClassVar[str] = "smf"
    title: ClassVar[str] = "S-shape"
    may_cross: ClassVar[tuple[int, ...]] = (0,)

    @classmethod
    def formula(cls, x: Array, *parameters: Array) -> Array:  # noqa: D102
        return _s(x, *parameters)


@register
@dataclass(frozen=True)
class ZShape(_Falling):
    """zmf [a b]: quadratic spline from 1 at a to 0 at b, 0.5 in the middle; a ≥ b is a step at the middle."""

    matlab: ClassVar[str] = "zmf"
    title: ClassVar[str] = "Z-shape"
    may_cross: ClassVar[tuple[int, ...]] = (0,)

    @classmethod
    def formula(cls, x: Array, *parameters: Array) -> Array:  # noqa: D102
        a, b = parameters
        return _s(-x, -b, -a)


@register
@dataclass(frozen=True)
class PiShape(_FourVertices):
    """pimf [a b c d]: smf[a b] · zmf[c d]."""

    matlab: ClassVar[str] = "pimf"
    title: ClassVar[str] = "π-shape"
    may_cross: ClassVar[tuple[int, ...]] = (0, 1, 2)

    @classmethod
    def formula(cls, x: Array, *parameters: Array) -> Array:  # noqa: D102
        a, b, c, d = parameters
        return _s(x, a, b) * _s(-x, -d, -c)


FUNCTIONS: tuple[type[MembershipFunction], ...] = tuple(MATLAB_NAMES.values())  # MATLAB's thirteen

# MATLAB's names as aliases: trimf(0, 1, 2) is Triangle(0, 1, 2).
trimf, trapmf, linsmf, linzmf = Triangle, Trapezoid, LinearS, LinearZ
gaussmf, gauss2mf, gbellmf = Gaussian, TwoSidedGaussian, Bell
sigmf, dsigmf, psigmf = Sigmoid, SigmoidDifference, SigmoidProduct
smf, zmf, pimf = SShape, ZShape, PiShape


def membership_function(name: str, parameters: Any) -> MembershipFunction:
    """Make the function of a MATLAB name with its parameters in MATLAB's order.

    Args:
        name: The name, such as "gaussmf".
        parameters: Its numbers, such as [sigma, c].

    Returns:
        The function.

    Raises:
        MembershipError: An unknown name, a wrong number of parameters, or parameters that MATLAB refuses.
    """
    check_known(name, MATLAB_NAMES, "membership function", MembershipError)
    function = MATLAB_NAMES[name]
    letters = [f.name for f in fields(function)]
    if len(parameters) != len(letters):
        raise MembershipError(f"{name} takes {len(letters)} parameters [{' '.join(letters)}], got {len(parameters)}")
    return function(*parameters)
