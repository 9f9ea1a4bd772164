"""A system as a source of C in Q16.16 fixed point: no floating point at run time, no library."""

import math
from typing import Any

import numpy as np

from fuzzy.plugins.ccode.identifier import comment
from fuzzy.plugins.ccode.numbertype import LARGEST_FIXED, ONE, ExportError
from fuzzy.plugins.ccode.phrases import called, limited_to, rendered, rule_tables, signature, table
from fuzzy.plugins.ccode.plan import CodePlan, CodeTerm

_DEGREE = 30  # binary places of a degree
_LOG = 20  # binary places of a logarithm
_MOST = 2**31 - 1


def check_range(plan: CodePlan) -> None:
    """See that every number that comes in or out fits. Raises ExportError for one that does not."""
    fis = plan.fis
    for variable in (*fis.inputs, *fis.outputs):
        if max(map(abs, variable.universe)) > LARGEST_FIXED:
            raise ExportError(
                f"{fis.name}: {variable.name} goes from {variable.universe[0]:g} to {variable.universe[1]:g}, and "
                "Q16.16 has the numbers from -32768 to 32768: scale the variable, or export to float"
            )
    for o, name in enumerate(plan.outputs):
        for numbers in (plan.constants[o], plan.slopes[o]):
            if len(numbers) and np.abs(numbers).max() > LARGEST_FIXED:
                raise ExportError(
                    f"{fis.name}: a consequent of {name} has the number {np.abs(numbers).max():g}, and Q16.16 has the "
                    "numbers from -32768 to 32768: export to float"
                )


def fixed_source(plan: CodePlan) -> str:
    """The whole text. Raises ExportError for numbers that Q16.16 does not have."""
    check_range(plan)
    return _Writer(plan).source()


def q16(value: float) -> int:
    """A number in Q16.16, the nearest; saturated."""
    if math.isnan(value):
        return 0
    return round(max(-(2.0**31), min(float(_MOST), max(-1e9, min(1e9, value)) * ONE)))


def line(slope: float, offset: float, places: int) -> str:
    """The arguments of `line` in C for ``slope`` x + ``offset``, with ``places`` binary places."""
    scaled = abs(slope) * 2.0 ** (places - 16)
    bits = 0 if scaled == 0 else max(0, min(62, 30 - math.floor(math.log2(scaled))))
    number = min(round(scaled * 2.0**bits), _MOST)
    if number == _MOST and bits > 0:
        bits -= 1
        number = round(scaled * 2.0**bits)
    limit = 2.0**60
    at = round(max(-limit, min(limit, offset * 2.0**places)))
    long = f"{at}" if abs(at) < 2**31 else f"INT64_C({at})"
    return f"{math.copysign(1, slope) * number:.0f}, {bits}, {long}"


class _Writer:
    def __init__(self, plan: CodePlan) -> None:
        self.plan = plan

    def source(self) -> str:
        plan = self.plan
        function = rendered(
            "fixed_infer.c.j2",
            plan,
            one=ONE,
            width=self._width,
            signature=signature(plan.name, "int32_t"),
            inputs=[self._input(k) for k in range(len(plan.inputs))],
            outputs=[
                {"name": name, "rules": np.flatnonzero(part).tolist(), "default": q16(variable.midrange)}
                for name, part, variable in zip(plan.outputs, plan.takes_part, plan.fis.outputs, strict=True)
            ],
            degree=self._logarithm if plan.logs else self._degree,
            has_slopes=lambda o, i: (plan.slopes[o, :, i] != 0).any(),
        )
        parts = [
            f"/* {comment(plan.fis.name)}, in Q16.16: see {plan.name}.h. Made of the system: change that, not this.\n"
            " * Shifting a negative number to the right keeps its sign, as every compiler for these machines does. */",
            f'#include "{plan.name}.h"\n',
            called("fixed.c", f"ONE\n{function}"),
            "\n".join(self._tables()) + "\n",
            function,
        ]
        return "\n".join(parts)

    def _input(self, k: int) -> dict[str, Any]:
        """An input by its name, limited or not, and whether the function needs it."""
        plan, (low, high) = self.plan, (q16(end) for end in self.plan.fis.inputs[k].universe)
        taken = limited_to(f"x[{k}]", low, high) if plan.fis.out_of_range == "clip" else f"x[{k}]"
        used = any(term.input == k for term in plan.terms) or bool((plan.slopes[:, :, k] != 0).any())
        return {"place": k, "name": plan.inputs[k], "low": low, "high": high, "taken": taken, "used": used}

    # Degrees of membership ----------------------------------------------------------------------------------

    def _line(self, term: CodeTerm, slope: float, offset: float, places: int) -> str:
        return f"line({term.variable}, {line(slope, offset, places)})"

    def _side(self, term: CodeTerm, slope: float, offset: float, spline: bool) -> str:
        """From 0 to 1 along a straight line, or by a spline."""
        return f"{'spline' if spline else 'limited'}({self._line(term, slope, offset, _DEGREE)})"

    def _up(self, term: CodeTerm, a: float, b: float, *, spline: bool = False) -> str:
        if b > a and math.isfinite(b - a):
            return self._side(term, 1 / (b - a), -a / (b - a), spline)
        at = (a + b) / 2 if spline else b
        return f"({term.variable} >= {self._edge(at)} ? ONE : 0)"

    def _down(self, term: CodeTerm, c: float, d: float, *, spline: bool = False) -> str:
        if d > c and math.isfinite(d - c):
            return self._side(term, -1 / (d - c), d / (d - c), spline)
        at = (c + d) / 2 if spline else c
        return f"({term.variable} <= {self._edge(at, down=True)} ? ONE : 0)"

    def _edge(self, at: float, down: bool = False) -> int:
        """A vertical edge: the first number at or above it, or the last at or below it."""
        scaled = max(-(2.0**31), min(float(_MOST), at * ONE))
        return math.floor(scaled) if down else math.ceil(scaled)

    def _sigmoid(self, term: CodeTerm, a: float, c: float) -> str:
        return self._line(term, a, -a * c, _LOG)

    def _degree(self, term: CodeTerm) -> str:
        """A degree that may be faint, as an expression of C."""
        p, name = term.parameters, term.function
        if name == "dsigmf":
            return f"difference(sigmoid({self._sigmoid(term, *p[:2])}), sigmoid({self._sigmoid(term, *p[2:])}))"
        if name == "psigmf":
            return f"product(sigmoid({self._sigmoid(term, *p[:2])}), sigmoid({self._sigmoid(term, *p[2:])}))"
        if name in ("gaussmf", "gauss2mf"):
            return f"decaying({self._logarithm(term)})"
        if name in ("sigmf", "gbellmf"):
            return f"sigmoid({self._sigmoid(term, *p) if name == 'sigmf' else self._bell(term)})"
        return f"strength_of({self._edges(term)}, 0)"

    def _edges(self, term: CodeTerm) -> str:
        """A degree that is made of straight lines or parabolas."""
        p, name = term.parameters, term.function
        if name in ("trimf", "trapmf"):
            return f"least({self._up(term, p[0], p[1])}, {self._down(term, p[-2], p[-1])})"
        if name == "linsmf":
            return self._up(term, *p)
        if name == "linzmf":
            return f"ONE - {self._up(term, *p)}"
        if name == "smf":
            return self._up(term, *p, spline=True)
        if name == "zmf":
            return self._down(term, *p, spline=True)
        return f"times({self._up(term, *p[:2], spline=True)}, {self._down(term, *p[2:], spline=True)})"

    def _bell(self, term: CodeTerm) -> str:
        a, b, c = term.parameters
        return f"bell({self._line(term, 1 / abs(a), -c / abs(a), _LOG)}, {q16(2 * b)})"

    def _logarithm(self, term: CodeTerm) -> str:
        p, name = term.parameters, term.function
        if name == "gaussmf":
            return f"log_gauss({self._line(term, 1 / abs(p[0]), -p[1] / abs(p[0]), _LOG)})"
        if name == "gauss2mf":
            low, high = self._edge(p[1], down=True), self._edge(p[3])
            left = f"log_gauss({self._line(term, 1 / abs(p[0]), -p[1] / abs(p[0]), _LOG)})"
            right = f"log_gauss({self._line(term, 1 / abs(p[2]), -p[3] / abs(p[2]), _LOG)})"
            x = term.variable
            return f"({x} <= {low} ? {left} : 0)\n        + ({x} >= {high} ? {right} : 0)"
        if name == "sigmf":
            return f"log_sigmoid({self._sigmoid(term, *p)})"
        if name == "psigmf":
            first, second = self._sigmoid(term, p[0], p[1]), self._sigmoid(term, p[2], p[3])
            return f"log_sigmoid({first})\n        + log_sigmoid({second})"
        return f"log_sigmoid({self._bell(term)})"

    # Rules ------------------------------------------------------------------------------------------------------

    def _tables(self) -> list[str]:
        plan = self.plan
        if not plan.rules:
            return []
        powers = [q16(clause.power) for clause in plan.all_clauses]
        rows = rule_tables(plan, "int32_t", powers, [round(w * 2**30) for w in plan.weights], "uint8_t")
        for o, name in enumerate(plan.outputs):
            if not plan.takes_part[o].any():
                continue
            if not plan.takes_part[o].all():
                rows.append(table("uint8_t", f"{name}_part", plan.takes_part[o].astype(int).tolist()))
            rows.append(table("int32_t", f"{name}_of", [q16(value) for value in plan.constants[o]]))
            if plan.is_linear(o):
                rows += self._slopes(o, name)
        return rows

    def _slopes(self, o: int, name: str) -> list[str]:
        """The slopes of an output: numbers of 31 bits, and one shift for each input."""
        slopes, bits = self.plan.slopes[o], []
        for i in range(slopes.shape[1]):
            largest = float(np.abs(slopes[:, i]).max())
            bits.append(0 if largest == 0 else max(0, min(46, 30 - math.floor(math.log2(largest)) - 1)))
        numbers = [
            max(-_MOST, min(_MOST, round(slope * 2.0**b))) for row in slopes for slope, b in zip(row, bits, strict=True)
        ]
        return [table("int32_t", f"{name}_slope", numbers), table("uint8_t", f"{name}_bits", bits)]

    @property
    def _width(self) -> int:
        """How many bits a strength may have, so that the sum of all times a consequent has 62."""
        return min(30, 31 - math.ceil(math.log2(max(1, self.plan.rules))))
