"""The base of all membership functions: a frozen dataclass of parameters, a formula and the facts about it.

A class states each fact about its function once: the words and the role of each parameter, which parameters are
vertices that stand in order, its terms of a grid, how it becomes another function and how another becomes it.
:func:`register` makes the function known by its MATLAB name to files, learning and the designer.
"""

from collections.abc import Callable
from dataclasses import dataclass, fields
from itertools import pairwise
from typing import Any, ClassVar, Literal, TypeVar

import numpy as np
from array_api_compat import array_namespace, device, is_array_api_obj

from fuzzy.errors import InputError
from fuzzy.profile import Outline, Profile
from fuzzy.words import listed

# What a parameter is, and so its unit: a place on the axis of x and a length there (unit of x; a length is never 0),
# a slope (1 / unit of x), or a number without a unit.
Role = Literal["location", "width", "slope", "shape"]
# The parameters of a term of a grid, from its center, the half distance of the centers, and a steep slope.
Grid = Callable[[float, float, float], tuple[float, ...]]
Array = Any  # any array of the array-API standard: numpy.ndarray, torch.Tensor, ...


class MembershipError(InputError):
    """The error for parameters that make no membership function. It names the function and the parameter."""


def like(x: Array, value: Any) -> Array:
    """Make ``value`` (a number, a sequence of numbers or an array) an array of ``x``'s library, type and device."""
    xp = array_namespace(x)
    if is_array_api_obj(value):
        # An array of the same library keeps its graph; one of another library is read as numbers.
        if array_namespace(value) is xp:
            return value
        value = np.asarray(value)
    return xp.asarray(value, dtype=x.dtype, device=device(x))


def as_float(x: Any) -> Array:
    """Make ``x`` a floating-point array: sequences and integers become float64, float arrays stay as they are."""
    if not is_array_api_obj(x):
        return np.asarray(x, dtype=np.float64)
    xp = array_namespace(x)
    return x if xp.isdtype(x.dtype, "real floating") else xp.astype(x, xp.float64)


@dataclass(frozen=True)
class MembershipFunction:
    """A membership function: its parameters, which are numbers or array scalars of one library.

    It is called with places of any shape, in the unit of its variable, and gives their degrees in [0, 1]. A subclass
    has a field for each parameter, made with :func:`parameter`; ``words`` and ``roles`` follow from these.

    Raises:
        MembershipError: Parameters that are not finite, out of order, or a width of 0.
    """

    matlab: ClassVar[str]  # MATLAB's name
    title: ClassVar[str]  # the function in words
    words: ClassVar[tuple[str, ...]]  # what each parameter is called
    roles: ClassVar[tuple[Role, ...]]  # what each parameter is
    vertices: ClassVar[tuple[int, ...]] = ()  # the parameters, by place, that stand from left to right
    may_cross: ClassVar[tuple[int, ...]] = ()  # the vertices, by place, that may lie right of the next
    log_formula: ClassVar[Callable[..., Array] | None] = None  # only where the degree is positive everywhere
    grid: ClassVar[Grid | None] = None  # only for functions that a grid can be made of, see fuzzy.fitting

    def __post_init__(self) -> None:
        for each, value in zip(fields(self), self.parameters, strict=True):
            number = as_number(value)
            if not np.isfinite(number):
                raise MembershipError(f"{self._call()}: {each.name} must be a finite number, got {number}")
            if not is_array_api_obj(value):
                object.__setattr__(self, each.name, number)
        self._validate()

    def _validate(self) -> None:
        """Raise MembershipError where MATLAB accepts no such parameters."""
        numbers, letters = self.numbers, [f.name for f in fields(self)]
        for group in self.ascending():
            if any(numbers[i] > numbers[j] for i, j in pairwise(group)):
                order = " <= ".join(letters[i] for i in group)
                raise MembershipError(
                    f"{self._call()} ({self.matlab}): {listed(self.words[i] for i in group)} must be in order, {order}"
                )
        widths = [i for i, role in enumerate(self.roles) if role == "width"]
        if any(numbers[i] == 0 for i in widths):
            raise MembershipError(
                f"{self._call()} ({self.matlab}): {' and '.join(letters[i] for i in widths)} must not be 0"
            )

    @classmethod
    def ascending(cls) -> list[tuple[int, ...]]:
        """The groups of parameters, by place, that must ascend: neighbouring vertices that may not cross each other."""
        groups: list[tuple[int, ...]] = []
        for i, j in pairwise(cls.vertices):
            if i in cls.may_cross:
                continue
            if groups and groups[-1][-1] == i:
                groups[-1] += (j,)
            else:
                groups.append((i, j))
        return groups

    def _call(self) -> str:
        return f"{type(self).__name__}({', '.join(f'{as_number(p):g}' for p in self.parameters)})"

    @property
    def parameters(self) -> tuple[Any, ...]:
        """The parameters in MATLAB's order."""
        return tuple(getattr(self, f.name) for f in fields(self))

    @property
    def numbers(self) -> tuple[float, ...]:
        """The parameters as floats."""
        return tuple(as_number(p) for p in self.parameters)

    def profile(self, span: float) -> Profile:
        """The trapezoid that stands for this function while its type changes.

        ``span`` (> 0, in the unit of x) is the width of an edge that never ends.

        Raises:
            MembershipError: A class that states none.
        """
        raise MembershipError(f"{self.matlab} states no profile, so it cannot become another function")

    @classmethod
    def fitted(cls, outline: Outline) -> tuple[float, ...]:
        """The parameters with which a function of this class has the half-degree points of ``outline``.

        Raises:
            MembershipError: A class that does not say how it is fitted.
        """
        raise MembershipError(f"{cls.matlab} does not say how it is fitted, so no other function can become one")

    @classmethod
    def formula(cls, x: Array, *parameters: Array) -> Array:
        """The degree of membership, in [0, 1]. ``x``, of any shape, and the ``parameters`` broadcast."""
        assert cls.log_formula is not None
        with np.errstate(under="ignore"):
            return array_namespace(x).exp(cls.log_formula(x, *parameters))

    def powered(self, power: float) -> "MembershipFunction | None":
        """The function that is exactly this one to a ``power`` everywhere; None where there is none."""
        return None

    def __call__(self, x: Any) -> Array:
        """Compute the degree of membership, in [0, 1], at each of ``x`` (any shape, in the unit of its variable)."""
        x = as_float(x)
        return self.formula(x, *(like(x, p) for p in self.parameters))


def as_number(value: Any) -> float:
    """Read a parameter (a number or an array scalar, also one in training) as a float; MembershipError for others."""
    if is_array_api_obj(value):
        if value.ndim != 0:
            raise MembershipError(f"a parameter is one number, got an array of shape {tuple(value.shape)}")
        # torch warns of a conversion that drops a gradient; here that is meant.
        return float(value.detach() if hasattr(value, "detach") else value)
    if isinstance(value, bool) or not isinstance(value, (int, float, np.number)):
        raise MembershipError(f"a parameter is a number, got {value!r}")
    return float(value)


def parameter(role: Role, words: str) -> dict[str, str]:
    """Make the metadata of a parameter's field: what the parameter is, and what it is called."""
    return {"role": role, "words": words}


MATLAB_NAMES: dict[str, type[MembershipFunction]] = {}
Class = TypeVar("Class", bound=type[MembershipFunction])


def register(function: Class) -> Class:
    """Make a membership function known by its MATLAB name, as a decorator above ``@dataclass(frozen=True)``.

    Raises MembershipError if another function has the name.
    """
    function.words = tuple(f.metadata["words"] for f in fields(function))
    function.roles = tuple(f.metadata["role"] for f in fields(function))
    if MATLAB_NAMES.setdefault(function.matlab, function) is not function:
        raise MembershipError(f"{function.matlab} is the name of {MATLAB_NAMES[function.matlab].__name__} already")
    return function
