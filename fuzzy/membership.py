"""Membership functions: one formula each, written once for every array library.

A membership function is a frozen dataclass of its parameters, in MATLAB's order and with MATLAB's letters,
named in words. Calling it evaluates it: ``Triangle(0, 1, 2)(x)`` has the shape of ``x``.

Each class states its formula in one of two ways:

- ``formula(x, *parameters)``: the degree of membership in [0, 1];
- ``log_formula(x, *parameters)`` for functions that are positive everywhere: the logarithm of the degree.
  Products of many such degrees underflow where the sum of their logarithms does not, so inference uses it.

Both take arrays that broadcast, ask ``x`` for its namespace and never write into an array; they serve numpy,
torch (with gradients, on any device) and every other array of the array-API standard. At the joints the
gradient is that of one of the two sides, or between them: never NaN.

Sources: [MATLAB fismf] for names, order and the degenerate cases; [Jang 1993] for the bell.
"""

from collections.abc import Callable
from dataclasses import dataclass, fields
from typing import Any, ClassVar, Literal

import numpy as np
from array_api_compat import array_namespace, device, is_array_api_obj

from fuzzy.errors import InputError
from fuzzy.naming import expected

Role = Literal["location", "width", "slope", "shape"]
Array = Any  # any array of the array-API standard: numpy.ndarray, torch.Tensor, ...


class MembershipError(InputError):
    """Parameters that make no membership function. The message names the function and the parameter."""


def like(x: Array, value: Any) -> Array:
    """``value`` (a number, a sequence of numbers or an array) as an array of ``x``'s kind, type and device."""
    xp = array_namespace(x)
    if is_array_api_obj(value):
        # An array of the same library keeps its graph; one of another library is read as numbers.
        if array_namespace(value) is xp:
            return value
        value = np.asarray(value)
    return xp.asarray(value, dtype=x.dtype, device=device(x))


def as_float(x: Any) -> Array:
    """``x`` as a floating-point array: sequences and integers become float64, float arrays stay as they are."""
    if not is_array_api_obj(x):
        return np.asarray(x, dtype=np.float64)
    xp = array_namespace(x)
    return x if xp.isdtype(x.dtype, "real floating") else xp.astype(x, xp.float64)


@dataclass(frozen=True)
class MembershipFunction:
    """What every membership function is: its parameters, which are numbers or arrays (scalars) of one library."""

    matlab: ClassVar[str]  # MATLAB's name
    roles: ClassVar[tuple[Role, ...]]  # what each parameter is: how it changes when x is measured in other units
    log_formula: ClassVar[Callable[..., Array] | None] = None  # only where the degree is positive everywhere

    def __post_init__(self) -> None:
        for field, value in zip(fields(self), self.parameters, strict=True):
            number = as_number(value)
            if not np.isfinite(number):
                raise MembershipError(f"{self._call()}: {field.name} must be a finite number, got {number}")
            if not is_array_api_obj(value):
                object.__setattr__(self, field.name, number)
        if self.parameters:
            self._validate(*map(as_number, self.parameters))

    def _validate(self, *parameters: float) -> None:
        """Raise MembershipError where MATLAB accepts no such parameters."""

    def _call(self) -> str:
        return f"{type(self).__name__}({', '.join(f'{as_number(p):g}' for p in self.parameters)})"

    def _require(self, condition: bool, what: str) -> None:
        if not condition:
            raise MembershipError(f"{self._call()} ({self.matlab}): {what}")

    @property
    def parameters(self) -> tuple[Any, ...]:
        """The parameters in MATLAB's order."""
        return tuple(getattr(self, f.name) for f in fields(self))

    @classmethod
    def formula(cls, x: Array, *parameters: Array) -> Array:
        """Degree of membership in [0, 1]; ``x`` and the parameters broadcast."""
        assert cls.log_formula is not None
        with np.errstate(under="ignore"):
            return array_namespace(x).exp(cls.log_formula(x, *parameters))

    def __call__(self, x: Any) -> Array:
        """Degree of membership of ``x`` (any shape, in the unit of its variable), in [0, 1]; shape of ``x``."""
        x = as_float(x)
        return self.formula(x, *(like(x, p) for p in self.parameters))


def as_number(value: Any) -> float:
    """A parameter (a number or an array scalar, also one in training) as a float; MembershipError for others."""
    if is_array_api_obj(value):
        if value.ndim != 0:
            raise MembershipError(f"a parameter is one number, got an array of shape {tuple(value.shape)}")
        # torch warns of a conversion that drops a gradient; here that is meant.
        return float(value.detach() if hasattr(value, "detach") else value)
    if isinstance(value, bool) or not isinstance(value, (int, float, np.number)):
        raise MembershipError(f"a parameter is a number, got {value!r}")
    return float(value)


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


# The functions ------------------------------------------------------------------------------------------------


@dataclass(frozen=True)
class Triangle(MembershipFunction):
    """trimf [a b c]: max(0, min((x − a)/(b − a), (c − x)/(c − b))), with a ≤ b ≤ c.

    a = b or b = c makes a vertical edge, where the value is 1 (a shoulder's foot).
    """

    a: Any  # left foot, in the unit of x
    b: Any  # peak
    c: Any  # right foot
    matlab: ClassVar[str] = "trimf"
    roles: ClassVar[tuple[Role, ...]] = ("location",) * 3

    def _validate(self, *parameters: float) -> None:
        a, b, c = parameters
        self._require(a <= b <= c, "the feet and the peak must be in order, a <= b <= c")

    @classmethod
    def formula(cls, x: Array, *parameters: Array) -> Array:  # noqa: D102
        a, b, c = parameters
        return array_namespace(x).minimum(_rise(x, a, b), _fall(x, b, c))


@dataclass(frozen=True)
class Trapezoid(MembershipFunction):
    """trapmf [a b c d]: max(0, min((x − a)/(b − a), 1, (d − x)/(d − c))), with a ≤ b and c ≤ d.

    a = b or c = d makes a vertical edge with the value 1. b > c is legal, as in MATLAB: a triangle whose peak
    lies below 1.
    """

    a: Any  # left foot, in the unit of x
    b: Any  # left shoulder
    c: Any  # right shoulder
    d: Any  # right foot
    matlab: ClassVar[str] = "trapmf"
    roles: ClassVar[tuple[Role, ...]] = ("location",) * 4

    def _validate(self, *parameters: float) -> None:
        a, b, c, d = parameters
        self._require(a <= b, "the left foot must not lie right of the left shoulder, a <= b")
        self._require(c <= d, "the right shoulder must not lie right of the right foot, c <= d")

    @classmethod
    def formula(cls, x: Array, *parameters: Array) -> Array:  # noqa: D102
        a, b, c, d = parameters
        return array_namespace(x).minimum(_rise(x, a, b), _fall(x, c, d))


@dataclass(frozen=True)
class LinearS(MembershipFunction):
    """linsmf [a b]: 0 up to a, 1 from b on, straight between; a = b is a step that is 1 for x ≥ a."""

    a: Any  # foot, in the unit of x
    b: Any  # shoulder
    matlab: ClassVar[str] = "linsmf"
    roles: ClassVar[tuple[Role, ...]] = ("location",) * 2

    def _validate(self, *parameters: float) -> None:
        a, b = parameters
        self._require(a <= b, "the foot must not lie right of the shoulder, a <= b")

    @classmethod
    def formula(cls, x: Array, *parameters: Array) -> Array:  # noqa: D102
        return _rise(x, *parameters)


@dataclass(frozen=True)
class LinearZ(MembershipFunction):
    """linzmf [a b] = 1 − linsmf [a b]: 1 up to a, 0 from b on; a = b is a step that is 0 for x ≥ a."""

    a: Any  # shoulder, in the unit of x
    b: Any  # foot
    matlab: ClassVar[str] = "linzmf"
    roles: ClassVar[tuple[Role, ...]] = ("location",) * 2

    def _validate(self, *parameters: float) -> None:
        a, b = parameters
        self._require(a <= b, "the shoulder must not lie right of the foot, a <= b")

    @classmethod
    def formula(cls, x: Array, *parameters: Array) -> Array:  # noqa: D102
        return 1 - _rise(x, *parameters)


@dataclass(frozen=True)
class Gaussian(MembershipFunction):
    """gaussmf [sigma c]: exp(−(x − c)² / 2σ²), with σ ≠ 0 (only its square counts)."""

    sigma: Any  # standard deviation, in the unit of x
    c: Any  # center
    matlab: ClassVar[str] = "gaussmf"
    roles: ClassVar[tuple[Role, ...]] = ("width", "location")
    log_formula: ClassVar[Callable[..., Array]] = staticmethod(_log_gauss)

    def _validate(self, *parameters: float) -> None:
        self._require(parameters[0] != 0, "sigma must not be 0")


def _log_two_sided_gauss(x: Array, s1: Array, c1: Array, s2: Array, c2: Array) -> Array:
    # clip instead of where: beyond the center the deviation is 0, and so is its gradient.
    xp = array_namespace(x)
    zero = xp.zeros_like(x - c1)
    return _log_gauss(xp.minimum(x - c1, zero), s1, zero) + _log_gauss(xp.maximum(x - c2, zero), s2, zero)


@dataclass(frozen=True)
class TwoSidedGaussian(MembershipFunction):
    """gauss2mf [s1 c1 s2 c2]: Gaussian shoulders left of c1 and right of c2, 1 between.

    c1 > c2 is legal, as in MATLAB: the product of the two shoulders, whose maximum lies below 1.
    """

    s1: Any  # standard deviation of the left shoulder, in the unit of x
    c1: Any  # where the left shoulder ends
    s2: Any  # standard deviation of the right shoulder
    c2: Any  # where the right shoulder begins
    matlab: ClassVar[str] = "gauss2mf"
    roles: ClassVar[tuple[Role, ...]] = ("width", "location") * 2
    log_formula: ClassVar[Callable[..., Array]] = staticmethod(_log_two_sided_gauss)

    def _validate(self, *parameters: float) -> None:
        s1, _, s2, _ = parameters
        self._require(s1 != 0 and s2 != 0, "s1 and s2 must not be 0")


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


@dataclass(frozen=True)
class Bell(MembershipFunction):
    """gbellmf [a b c]: 1 / (1 + |(x − c)/a|^2b), with a ≠ 0   [Jang 1993, layer 1].

    |a| is the half-width at 0.5; the slope there is −b/2a. A negative b turns the bell upside down, as in MATLAB.
    """

    a: Any  # half-width at degree 0.5, in the unit of x
    b: Any  # steepness
    c: Any  # center, in the unit of x
    matlab: ClassVar[str] = "gbellmf"
    roles: ClassVar[tuple[Role, ...]] = ("width", "shape", "location")
    log_formula: ClassVar[Callable[..., Array]] = staticmethod(_log_bell)

    def _validate(self, *parameters: float) -> None:
        self._require(parameters[0] != 0, "a must not be 0")


@dataclass(frozen=True)
class Sigmoid(MembershipFunction):
    """sigmf [a c]: 1 / (1 + exp(−a (x − c))); a < 0 opens to the left."""

    a: Any  # slope, in 1 / the unit of x
    c: Any  # where the degree is 0.5
    matlab: ClassVar[str] = "sigmf"
    roles: ClassVar[tuple[Role, ...]] = ("slope", "location")
    log_formula: ClassVar[Callable[..., Array]] = staticmethod(_log_sigmoid)


@dataclass(frozen=True)
class SigmoidDifference(MembershipFunction):
    """dsigmf [a1 c1 a2 c2]: sigmf[a1 c1] − sigmf[a2 c2], not below 0 (a degree cannot be negative)."""

    a1: Any  # slope of the first sigmoid, in 1 / the unit of x
    c1: Any  # its crossover
    a2: Any  # slope of the second sigmoid
    c2: Any  # its crossover
    matlab: ClassVar[str] = "dsigmf"
    roles: ClassVar[tuple[Role, ...]] = ("slope", "location") * 2

    @classmethod
    def formula(cls, x: Array, *parameters: Array) -> Array:  # noqa: D102
        a1, c1, a2, c2 = parameters
        with np.errstate(under="ignore"):
            return array_namespace(x).clip(_sigmoid(x, a1, c1) - _sigmoid(x, a2, c2), 0.0, 1.0)


def _log_sigmoid_product(x: Array, a1: Array, c1: Array, a2: Array, c2: Array) -> Array:
    return _log_sigmoid(x, a1, c1) + _log_sigmoid(x, a2, c2)


@dataclass(frozen=True)
class SigmoidProduct(MembershipFunction):
    """psigmf [a1 c1 a2 c2]: sigmf[a1 c1] · sigmf[a2 c2]."""

    a1: Any  # slope of the first sigmoid, in 1 / the unit of x
    c1: Any  # its crossover
    a2: Any  # slope of the second sigmoid
    c2: Any  # its crossover
    matlab: ClassVar[str] = "psigmf"
    roles: ClassVar[tuple[Role, ...]] = ("slope", "location") * 2
    log_formula: ClassVar[Callable[..., Array]] = staticmethod(_log_sigmoid_product)


@dataclass(frozen=True)
class SShape(MembershipFunction):
    """smf [a b]: quadratic spline from 0 at a to 1 at b, 0.5 in the middle; a ≥ b is a step at the middle."""

    a: Any  # foot, in the unit of x
    b: Any  # shoulder
    matlab: ClassVar[str] = "smf"
    roles: ClassVar[tuple[Role, ...]] = ("location",) * 2

    @classmethod
    def formula(cls, x: Array, *parameters: Array) -> Array:  # noqa: D102
        return _s(x, *parameters)


@dataclass(frozen=True)
class ZShape(MembershipFunction):
    """zmf [a b]: quadratic spline from 1 at a to 0 at b, 0.5 in the middle; a ≥ b is a step at the middle."""

    a: Any  # shoulder, in the unit of x
    b: Any  # foot
    matlab: ClassVar[str] = "zmf"
    roles: ClassVar[tuple[Role, ...]] = ("location",) * 2

    @classmethod
    def formula(cls, x: Array, *parameters: Array) -> Array:  # noqa: D102
        a, b = parameters
        return _s(-x, -b, -a)


@dataclass(frozen=True)
class PiShape(MembershipFunction):
    """pimf [a b c d]: smf[a b] · zmf[c d]."""

    a: Any  # left foot, in the unit of x
    b: Any  # left shoulder
    c: Any  # right shoulder
    d: Any  # right foot
    matlab: ClassVar[str] = "pimf"
    roles: ClassVar[tuple[Role, ...]] = ("location",) * 4

    @classmethod
    def formula(cls, x: Array, *parameters: Array) -> Array:  # noqa: D102
        a, b, c, d = parameters
        return _s(x, a, b) * _s(-x, -d, -c)


FUNCTIONS: tuple[type[MembershipFunction], ...] = (
    Triangle,
    Trapezoid,
    LinearS,
    LinearZ,
    Gaussian,
    TwoSidedGaussian,
    Bell,
    Sigmoid,
    SigmoidDifference,
    SigmoidProduct,
    SShape,
    ZShape,
    PiShape,
)
MATLAB_NAMES: dict[str, type[MembershipFunction]] = {f.matlab: f for f in FUNCTIONS}

# MATLAB's names as aliases: trimf(0, 1, 2) is Triangle(0, 1, 2).
trimf, trapmf, linsmf, linzmf, gaussmf, gauss2mf = (
    Triangle,
    Trapezoid,
    LinearS,
    LinearZ,
    Gaussian,
    TwoSidedGaussian,
)
gbellmf, sigmf, dsigmf, psigmf = Bell, Sigmoid, SigmoidDifference, SigmoidProduct
smf, zmf, pimf = SShape, ZShape, PiShape


def membership_function(name: str, parameters: Any) -> MembershipFunction:
    """The function of a MATLAB name (``"gaussmf"``) with its parameters in MATLAB's order.

    Raises MembershipError for an unknown name, a wrong number of parameters, or parameters that MATLAB refuses.
    """
    if name not in MATLAB_NAMES:
        raise MembershipError(expected(name, MATLAB_NAMES, "membership function"))
    function = MATLAB_NAMES[name]
    letters = [f.name for f in fields(function)]
    if len(parameters) != len(letters):
        raise MembershipError(f"{name} takes {len(letters)} parameters [{' '.join(letters)}], got {len(parameters)}")
    return function(*parameters)
