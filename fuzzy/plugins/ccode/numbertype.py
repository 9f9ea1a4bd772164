"""The types of numbers that a system is written in: how each writes a constant."""

import math
import re
from typing import Any, NamedTuple

import numpy as np

from fuzzy.errors import InputError
from fuzzy.naming import check_known

FIXED_POINT = "q16.16"
ONE = 1 << 16  # of Q16.16
LARGEST_FIXED = (2**31 - 1) / ONE


class ExportError(InputError):
    """The error for a system that cannot be written in C as it was asked for."""


class Floating(NamedTuple):
    """double or float: C's own arithmetic."""

    name: str
    type: type[np.floating[Any]]
    suffix: str  # of a constant, and of a function of math.h
    infinity: str  # in this type: C's INFINITY is a float
    unknown: str  # not-a-number in this type: C's NAN is a float

    @property
    def never(self) -> float:
        """What stands for the logarithm of 0; see :func:`fuzzy.inference.never`."""
        return -float(np.finfo(self.type).max) / 1e8

    def constant(self, value: float) -> str:
        """A number as C writes it, exactly; infinities are those of math.h."""
        if math.isnan(value):
            return self.unknown
        if math.isfinite(value) and abs(value) > float(np.finfo(self.type).max):
            raise ExportError(f"{value:g} is too large for a float: export to double")
        kept = self.type(value)
        if math.isinf(kept):
            return self.infinity if kept > 0 else f"-{self.infinity}"
        return repr(float(str(kept))) + self.suffix

    def bounds(self, universe: tuple[float, float]) -> tuple[str, str]:
        """The ends of a range, rounded inwards: a number lies between them where it lies in the range."""
        low, high = universe
        first, last = self.type(low), self.type(high)
        first = np.nextafter(first, self.type(np.inf)) if float(first) < low else first
        last = np.nextafter(last, self.type(-np.inf)) if float(last) > high else last
        return self.constant(float(first)), self.constant(float(last))

    def typed(self, text: str) -> str:
        """A text of C that is written for double, with ``REAL`` for the type, in this type."""
        text = text.replace("REAL", self.name).replace("INFINITY", self.infinity)
        if self.name == "float":
            text = re.sub(r"(?<![\w.])(\d+\.\d*(?:e[-+]?\d+)?)(?![\w.])", r"\1f", text)
            text = re.sub(r"\b(exp|log|log1p|pow|sqrt|fabs)\(", r"\1f(", text)
        return text


FLOATING = {
    "double": Floating("double", np.float64, "", "HUGE_VAL", "(double)NAN"),
    "float": Floating("float", np.float32, "f", "INFINITY", "NAN"),
}
_NUMBERS = (*FLOATING, FIXED_POINT)


def c_type(number: str) -> str:
    """The type in C of a type of numbers."""
    return "int32_t" if number == FIXED_POINT else number


def given_in(x: np.ndarray, number: str) -> tuple[np.ndarray, np.ndarray]:
    """Numbers as C of a type of numbers gets them, and the same as float64."""
    if number == FIXED_POINT:
        whole = np.clip(np.round(x * ONE), -(2.0**31), 2.0**31 - 1).astype(np.int32)  # the nearest, saturated
        return whole, whole / ONE
    given = np.ascontiguousarray(x.astype(FLOATING[number].type))
    return given, given.astype(np.float64)


def read_from(data: bytes, number: str) -> np.ndarray:
    """Numbers (n,) as float64 from the bytes that C of a type of numbers has of them."""
    if number == FIXED_POINT:
        return np.frombuffer(data, np.int32) / ONE
    return np.frombuffer(data, FLOATING[number].type).astype(np.float64)


def checked_number(name: str) -> str:
    """The name of a type of numbers. Raises ExportError for one that there is not."""
    check_known(name, _NUMBERS, "number type", ExportError)
    return name
