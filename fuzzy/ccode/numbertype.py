"""The types of numbers that a system is written in: how each writes a constant."""

import math
import re
from dataclasses import dataclass
from typing import Literal

import numpy as np

from fuzzy.errors import InputError
from fuzzy.naming import expected

NumberName = Literal["double", "float", "q16.16"]
NUMBERS: tuple[str, ...] = ("double", "float", "q16.16")
ONE = 1 << 16  # of Q16.16
LARGEST = (2**31 - 1) / ONE


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
    def never(self) -> float:
        """What stands for the logarithm of 0; see :func:`fuzzy.inference.never`."""
        return -float(np.finfo(np.float32 if self.name == "float" else np.float64).max) / 1e8

    def constant(self, value: float) -> str:
        """A number as C writes it, exactly; infinities are those of math.h."""
        if math.isnan(value):
            return "NAN"
        kept = float(np.float32(value)) if self.name == "float" and not math.isinf(value) else value
        if math.isinf(kept):
            if not math.isinf(value):
                raise ExportError(f"{value:g} is too large for a float: export to double")
            return "INFINITY" if kept > 0 else "-INFINITY"
        text = repr(float(str(np.float32(value)))) if self.name == "float" else repr(float(value))
        return text + self.suffix

    def typed(self, text: str) -> str:
        """A text of C that is written for double, with ``REAL`` for the type, in this type."""
        text = text.replace("REAL", self.name)
        if self.name == "float":
            text = re.sub(r"(?<![\w.])(\d+\.\d*(?:e[-+]?\d+)?)(?![\w.])", r"\1f", text)
            text = re.sub(r"\b(exp|log|log1p|pow|sqrt|fabs)\(", r"\1f(", text)
        return text


def checked_number(name: str) -> str:
    """The name of a type of numbers. Raises ExportError for one that there is not."""
    if name not in NUMBERS:
        raise ExportError(expected(name, NUMBERS, "number type"))
    return name
