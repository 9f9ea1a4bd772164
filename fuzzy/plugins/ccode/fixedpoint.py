"""A system as a source of C in Q16.16 fixed point: no floating point at run time, no library."""

import math

import numpy as np

from fuzzy.plugins.ccode.identifier import comment
from fuzzy.plugins.ccode.numbertype import LARGEST_FIXED, ONE, ExportError
from fuzzy.plugins.ccode.phrases import called, limited_to, rule_tables, signature, table
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
        body = [*self._inputs(), *self._degrees(), *self._strengths()]
        for o in range(len(plan.outputs)):
            body += self._output(o)
        function = "\n".join([signature(plan.name, "int32_t") + " {", *body, "    return told;", "}", ""])
        parts = [
            f"/* {comment(plan.fis.name)}, in Q16.16: see {plan.name}.h. Made of the system: change that, not this.\n"
            " * Shifting a negative number to the right keeps its sign, as every compiler for these machines does. */",
            f'#include "{plan.name}.h"\n',
            called("fixed.c", f"ONE\n{function}"),
            "\n".join(self._tables()) + "\n",
            function,
        ]
        return "\n".join(parts)

    def _inputs(self) -> list[str]:
        plan, upper, clips = self.plan, self.plan.name.upper(), self.plan.fis.out_of_range == "clip"
        rows = ["    int told = 0;"]
        tests = []
        for k, (name, variable) in enumerate(zip(plan.inputs, plan.fis.inputs, strict=True)):
            low, high = (q16(end) for end in variable.universe)
            used = any(term.input == k for term in plan.terms) or bool((plan.slopes[:, :, k] != 0).any())
            if used:
                rows.append(f"    const int32_t {name} = {limited_to(f'x[{k}]', low, high) if clips else f'x[{k}]'};")
            if not clips:
                tests.append(f"    if (x[{k}] < {low} || x[{k}] > {high}) told = {upper}_OUTSIDE;")
        return [*rows, *tests, ""]

    # Degrees of membership ----------------------------------------------------------------------------------

    def _degrees(self) -> list[str]:
        plan = self.plan
        kind, what = ("int64_t", "logarithms of the degrees") if plan.logs else ("strength_t", "degrees of membership")
        rows = [f"    /* Layer 1: {what} */", f"    {kind} degree[{max(1, len(plan.terms))}];"]
        for k, term in enumerate(plan.terms):
            call = self._logarithm(term) if plan.logs else self._degree(term)
            rows.append(f"    degree[{k}] = {call}; /* {comment(term.name)} */")
        return [*rows, ""]

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

    def _strengths(self) -> list[str]:
        plan = self.plan
        if not plan.rules:
            return []
        meaning = "1 is all of them" if plan.sums else "relative to the strongest"
        rows = [f"    /* Layer 2: firing strengths; in the end {self._width} bits, {meaning} */"]
        return [*rows, *(self._of_logarithms() if plan.logs else self._of_degrees()), ""]

    @property
    def _width(self) -> int:
        """How many bits a strength may have, so that the sum of all times a consequent has 62."""
        return min(30, 31 - math.ceil(math.log2(max(1, self.plan.rules))))

    def _of_logarithms(self) -> list[str]:
        n, sums = self.plan.rules, self.plan.sums
        power = " * clause_power[k] >> 16" if self.plan.has_powers else ""
        weight = f" * weight_of[r] >> {60 - self._width}" if self.plan.is_weighted else f" >> {30 - self._width}"
        counts = "weight_of[r] > 0 && " if self.plan.is_weighted else ""
        rows = [
            f"    int64_t w[{n}], top = INT64_MIN;",
            f"    for (int r = 0, k = 0; r < {n}; r++) {{",
            "        w[r] = 0;",
            f"        for (; k < rule_end[r]; k++) w[r] += degree[clause_term[k]]{power};",
            f"        if ({counts}w[r] > top) top = w[r];",
            "    }",
        ]
        if sums:
            rows.append(f"    for (int r = 0; r < {n}; r++) w[r] = (int64_t)exponential(w[r]){weight};")
            return [row.replace(", top = INT64_MIN", "") for row in rows if "top = w[r]" not in row]
        return [
            *rows,
            f"    for (int r = 0; r < {n}; r++)",
            f"        w[r] = (int64_t)exponential(w[r] < top ? w[r] - top : 0){weight};",
        ]

    def _of_degrees(self) -> list[str]:
        n, fis = self.plan.rules, self.plan.fis
        sums, changes = self.plan.sums, self.plan.has_powers or self.plan.has_negations
        conjunction = "product" if fis.and_method == "prod" else "lesser"
        rows = [
            f"    strength_t fires[{n}];",
            f"    int32_t w[{n}];",
            *([] if sums else ["    int fewest = 1 << 20;"]),
            f"    for (int r = 0, k = 0; r < {n}; r++) {{",
            "        strength_t whole = {ONE, 0};",
            *(["        int32_t either = 0;"] if self.plan.has_ors else []),
            "        for (; k < rule_end[r]; k++) {",
            f"            {'' if changes else 'const '}strength_t clause = degree[clause_term[k]];",
        ]
        if self.plan.has_powers:
            rows += [
                f"            if (clause_power[k] == {2 * ONE}) clause = product(clause, clause);",
                f"            else if (clause_power[k] == {ONE // 2}) clause = root(clause);",
                f"            else if (clause_power[k] != {ONE}) clause = hedged(clause, clause_power[k]);",
            ]
        if self.plan.has_negations:
            rows.append("            if (clause_negated[k]) clause = strength_of(ONE - plain(clause), 0);")
        joined = f"whole = {conjunction}(whole, clause);"
        if self.plan.has_ors:
            function = "both" if fis.or_method == "probor" else "most"
            rows += [
                f"            if (rule_or[r]) either = {function}(either, plain(clause));",
                f"            else {joined}",
                "        }",
                "        if (rule_or[r]) whole = strength_of(either, 0);",
            ]
        else:
            rows += [f"            {joined}", "        }"]
        if self.plan.is_weighted:
            rows += [
                "        whole.value = (int32_t)(((int64_t)whole.value * weight_of[r]) >> 30);",
                "        whole = strength_of(whole.value, whole.halvings);",
            ]
        rows.append("        fires[r] = whole;")
        if not sums:
            rows.append("        if (whole.value > 0 && whole.halvings < fewest) fewest = whole.halvings;")
        drop, behind = 30 - self._width, "fires[r].halvings" if sums else "fires[r].halvings - fewest"
        return [
            *rows,
            "    }",
            f"    for (int r = 0; r < {n}; r++) {{",
            f"        const int behind = {behind} + {drop};",
            "        w[r] = fires[r].value == 0 || behind > 30 ? 0 : fires[r].value >> behind;",
            "    }",
        ]

    # Outputs ------------------------------------------------------------------------------------------------------

    def _output(self, o: int) -> list[str]:
        plan, upper, name, n = self.plan, self.plan.name.upper(), self.plan.outputs[o], self.plan.rules
        default = q16(plan.fis.outputs[o].midrange)
        if not plan.takes_part[o].any():
            return [f"    y[{o}] = {default};", f"    told |= {upper}_NO_RULE;"]
        proposal = f"{name}_of[r]"
        rows = [
            f"    {{ /* Layers 4 and 5: {comment(plan.fis.outputs[o].name)} */",
            "        int64_t fired = 0, said = 0;",
        ]
        rows.append(f"        for (int r = 0; r < {n}; r++) {{")
        if not plan.takes_part[o].all():
            rows.append(f"            if (!{name}_part[r]) continue;")
        if plan.is_linear(o):
            inputs = [i for i in range(len(plan.inputs)) if (plan.slopes[o, :, i] != 0).any()]
            rows.append(f"            int64_t proposal = {proposal};")
            for i in inputs:
                place = f"{len(plan.inputs)} * r + {i}" if len(plan.inputs) > 1 else "r"
                product = f"(int64_t){plan.inputs[i]} * {name}_slope[{place}]"
                rows.append(f"            proposal += shifted({product}, {name}_bits[{i}]);")
            rows.append("            if (proposal > INT32_MAX) proposal = INT32_MAX;")
            rows.append("            if (proposal < -INT32_MAX) proposal = -INT32_MAX;")
            proposal = "proposal"
        rows += ["            fired += w[r];", f"            said += (int64_t)w[r] * {proposal};", "        }"]
        if plan.sums:
            rows += [
                f"        said = shifted(said, {self._width});",
                "        if (said > INT32_MAX) said = INT32_MAX;",
                "        if (said < -INT32_MAX) said = -INT32_MAX;",
            ]
            value = "(int32_t)said"
        else:
            value = "(int32_t)((said + (said < 0 ? -fired : fired) / 2) / fired)"
        return [
            *rows,
            f"        if (fired > 0) y[{o}] = {value};",
            f"        else {{ y[{o}] = {default}; told |= {upper}_NO_RULE; }}",
            "    }",
        ]
