"""A term in float: its distances from the input keep the digits that a rounded parameter would lose.

A parameter is two floats, the nearest and the rest: x - a is then exact where x is near a, so that a foot, a step and
the side of a narrow function stand where they do for float64.
"""

import math
from collections.abc import Callable

import numpy as np

from fuzzy.plugins.ccode.numbertype import Floating
from fuzzy.plugins.ccode.plan import CodeTerm


class FloatTerm:
    """The writer of one term."""

    def __init__(self, number: Floating, term: CodeTerm, logs: bool) -> None:
        self.number, self.term, self.logs = number, term, logs
        self.zero, self.one = number.constant(0.0), number.constant(1.0)

    def text(self) -> str:
        """Its degree, or the logarithm of it, as an expression."""
        p, name = self.term.parameters, self.term.function
        writers: dict[str, Callable[[], str]] = {
            "trimf": lambda: self._of("least", self._up(p[0], p[1]), self._down(p[1], p[2])),
            "trapmf": lambda: self._of("least", self._up(p[0], p[1]), self._down(p[2], p[3])),
            "linsmf": lambda: self._up(p[0], p[1]),
            "linzmf": lambda: f"{self.one} - {self._up(p[0], p[1])}",
            "smf": lambda: self._up(p[0], p[1], "spline"),
            "zmf": lambda: self._down(p[0], p[1], "spline"),
            "pimf": lambda: f"{self._up(p[0], p[1], 'spline')} * {self._down(p[2], p[3], 'spline')}",
            "dsigmf": lambda: self._of("difference", self._sigmoid(p[0], p[1]), self._sigmoid(p[2], p[3])),
        }
        if name in writers:
            return writers[name]()
        return self._logarithm() if self.logs else f"exp{self.number.suffix}({self._logarithm()})"

    def _logarithm(self) -> str:
        p, name = self.term.parameters, self.term.function
        if name == "gaussmf":
            return self._of("log_gauss", self._from(p[1]), p[0])
        if name == "gauss2mf":
            return self._of("log_shoulders", self._from(p[1]), p[0], self._from(p[3]), p[2])
        if name == "gbellmf":
            return self._of("log_bell", self._from(p[2]), *p[:2])
        if name == "sigmf":
            return self._of("log_sigmoid", self._sigmoid(*p))
        return f"{self._of('log_sigmoid', self._sigmoid(*p[:2]))} + {self._of('log_sigmoid', self._sigmoid(*p[2:]))}"

    def _of(self, function: str, *arguments: str | float) -> str:
        texts = (a if isinstance(a, str) else self.number.constant(a) for a in arguments)
        return f"{function}({', '.join(texts)})"

    def _from(self, at: float) -> str:
        """How far the input lies above ``at``."""
        nearest = float(np.float32(at)) if math.isfinite(at) else at
        rest = at - nearest if math.isfinite(at) else 0.0
        first = f"{self.term.variable} - {self.number.constant(nearest)}".replace("- -", "+ ")
        if float(np.float32(rest)) == 0:
            return first
        return f"({first}) - {self.number.constant(rest)}".replace("- -", "+ ")

    def _sigmoid(self, slope: float, at: float) -> str:
        return f"{self.number.constant(slope)} * ({self._from(at)})"

    def _up(self, a: float, b: float, shape: str = "ramp") -> str:
        if b > a:
            return self._of(shape, self._from(a), b - a)
        side = f"{self._from((a + b) / 2 if shape == 'spline' else b)} >= {self.zero}"
        return f"({side} ? {self.one} : {self.zero})"

    def _down(self, c: float, d: float, shape: str = "ramp") -> str:
        if d > c:
            return self._of(shape, f"-({self._from(d)})", d - c)
        side = f"{self._from((c + d) / 2 if shape == 'spline' else c)} <= {self.zero}"
        return f"({side} ? {self.one} : {self.zero})"
