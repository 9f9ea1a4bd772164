"""The types of numbers that a system is written in: how each writes a constant."""

import math
import re
from dataclasses import dataclass
from typing import Literal

import numpy as np

from fuzzy.errors import InputError
from fuzzy.naming import check_known

FIXED_POINT = "q16.16"
_NUMBERS: tuple[str, ...] = ("double", "float", FIXED_POINT)
ONE = 1 << 16  # of Q16.16
LARGEST_FIXED = (2**31 - 1) / ONE


class ExportError(InputError):
    """The error for a system that cannot be written in C as it was asked for."""


@dataclass(frozen=True)
class Floating:
    """double or float: C's own arithmetic."""

    name: Literal["double", "float"]

    @property
    def suffix(self) -> str:
        """What a constant and a function of math.h end with."""
        return "f" if self.name == "float" else ""

    @property
    def infinity(self) -> str:
        """Infinity in this type: C's INFINITY is a float."""
        return "INFINITY" if self.name == "float" else "HUGE_VAL"

    @property
    def unknown(self) -> str:
        """Not-a-number in this type: C's NAN is a float."""
        return "NAN" if self.name == "float" else "(double)NAN"

    @property
    def never(self) -> float:
        """What stands for the logarithm of 0; see :func:`fuzzy.inference.never`."""
        return -float(np.finfo(np.float32 if self.name == "float" else np.float64).max) / 1e8

    def constant(self, value: float) -> str:
        """A number as C writes it, exactly; infinities are those of math.h."""
        if math.isnan(value):
            return self.unknown
        value = float(value)
        if self.name == "float" and math.isfinite(value) and abs(value) > float(np.finfo(np.float32).max):
            raise ExportError(f"{value:g} is too large for a float: export to double")
        kept = float(np.float32(value)) if self.name == "float" else value
        if math.isinf(kept):
            return self.infinity if kept > 0 else f"-{self.infinity}"
        text = repr(float(str(np.float32(value)))) if self.name == "float" else repr(float(value))
        return text + self.suffix

    def bounds(self, universe: tuple[float, float]) -> tuple[str, str]:
        """The ends of a range, rounded inwards: a number lies between them where it lies in the range."""
        low, high = universe
        if self.name == "double":
            return self.constant(low), self.constant(high)
        first, last = np.float32(low), np.float32(high)
        first = np.nextafter(first, np.float32(np.inf)) if float(first) < low else first
        last = np.nextafter(last, np.float32(-np.inf)) if float(last) > high else last
        return self.constant(float(first)), self.constant(float(last))

    def typed(self, text: str) -> str:
        """A text of C that is written for double, with ``REAL`` for the type, in this type."""
        text = text.replace("REAL", self.name).replace("INFINITY", self.infinity)
        if self.name == "float":
            text = re.sub(r"(?<![\w.])(\d+\.\d*(?:e[-+]?\d+)?)(?![\w.])", r"\1f", text)
            text = re.sub(r"\b(exp|log|log1p|pow|sqrt|fabs)\(", r"\1f(", text)
        return text


def c_type(number: str) -> str:
    """The type in C of a type of numbers."""
    return "int32_t" if number == FIXED_POINT else number


def in_q16(x: np.ndarray) -> np.ndarray:
    """Finite numbers in Q16.16, the nearest, saturated: an array of int32."""
    return np.clip(np.round(x * ONE), -(2.0**31), 2.0**31 - 1).astype(np.int32)


def checked_number(name: str) -> str:
    """The name of a type of numbers. Raises ExportError for one that there is not."""
    check_known(name, _NUMBERS, "number type", ExportError)
    return name
