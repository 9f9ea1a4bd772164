"""A system as a header and a source of C."""

from textwrap import fill
from typing import NamedTuple

import numpy as np

from fuzzy.plugins.ccode.fixedpoint import fixed_source
from fuzzy.plugins.ccode.floatterm import FloatTerm
from fuzzy.plugins.ccode.identifier import comment, identifiers
from fuzzy.plugins.ccode.numbertype import FIXED_POINT, FLOATING, Floating, c_type, checked_number
from fuzzy.plugins.ccode.phrases import called, guarded, limited_to, rule_tables, signature, table
from fuzzy.plugins.ccode.plan import CodeClause, CodePlan, CodeTerm, planned
from fuzzy.shown import shown
from fuzzy.system import Sugeno, Variable


class CSources(NamedTuple):
    """A system in C: two texts, and what they are called."""

    name: str  # of the files, without ending, and of the functions' prefix
    header: str
    source: str


def c_sources(fis: Sugeno, name: str = "", number: str = "double") -> CSources:
    """Write a system in C99.

    Args:
        fis: The system.
        name: The prefix of everything public, and the files' name; by default the system's own.
        number: "double", "float" or "q16.16", fixed point without floating point at run time.

    Raises:
        ExportError: A membership function or a number that C, or the type of numbers, does not have.
    """
    checked_number(number)
    plan = planned(fis, name)
    if number == FIXED_POINT:
        return CSources(plan.name, header(plan, c_type(number)), fixed_source(plan))
    kind = FLOATING[number]
    return CSources(plan.name, header(plan, kind.name), _Writer(plan, kind).source())


def header(plan: CodePlan, real: str) -> str:
    """The header: what goes in and comes out, in which units, and how it is called."""
    fis, name, upper = plan.fis, plan.name, plan.name.upper()
    fixed = real == c_type(FIXED_POINT)
    kind = "Q16.16 fixed point: 65536 is 1" if fixed else real
    declared = [
        f"#define {upper}_INPUTS {len(plan.inputs)}",
        f"#define {upper}_OUTPUTS {len(plan.outputs)}",
        *([_CONSTANT.format(upper)] if fixed else []),
        "",
        f"enum {{{', '.join(f'{upper}_IN_{n}' for n in identifiers(map(str.upper, plan.inputs)))}}};",
        f"enum {{{', '.join(f'{upper}_OUT_{n}' for n in identifiers(map(str.upper, plan.outputs)))}}};",
        "",
        "/* What the function tells, to be added; 0 when all is well. */",
        f"enum {{{upper}_OUTSIDE = 1 /* an input is outside its range, and is not limited to it */,",
        f"      {upper}_NO_RULE = 2 /* no rule fires for one of the outputs: {_no_rule(plan, fixed)} */}};",
        "",
        f"{signature(name, real)};",
    ]
    rows = [
        f"/* {comment(fis.name)}: a Takagi-Sugeno system of {plan.rules} rules, in {kind}.",
        " *",
        " * Inputs, in this order:",
        *(_row(k, v.name, v.universe, v.unit) for k, v in enumerate(fis.inputs)),
        " * Outputs:",
        *(_row(k, v.name, v.universe, v.unit) for k, v in enumerate(fis.outputs)),
        " *",
        " * Use:",
        f" *     {real} x[{upper}_INPUTS] = {{{', '.join(_example(v, fixed, upper) for v in fis.inputs)}}};",
        f" *     {real} y[{upper}_OUTPUTS];",
        f" *     {name}_infer(x, y);",
        " *",
        *([_FIXED] if fixed else []),
        " * It allocates nothing, keeps no state and may be called from an interrupt. */",
        *guarded(name, declared, ["#include <stdint.h>", ""] if fixed else []),
    ]
    return "\n".join(rows)


_FIXED = """ * Numbers beyond -32768 to 32768 stay there. A degree below 1e-9 counts as 0 in "or" and "not".
 *"""
_CONSTANT = """/* A constant in Q16.16; the compiler does the arithmetic. */
#define {}_Q16(value) ((int32_t)((value) * 65536.0 + ((value) < 0 ? -0.5 : 0.5)))"""


def _row(place: int, name: str, universe: tuple[float, float], unit: str) -> str:
    low, high = (shown(end) for end in universe)
    return f" *     {place}  {comment(name)}, {low} to {high}{' ' + comment(unit) if unit else ''}"


def _example(variable: Variable, fixed: bool, upper: str) -> str:
    value = FLOATING["double"].constant(float(f"{variable.midrange:.3g}"))
    return f"{upper}_Q16({value})" if fixed else value


def _no_rule(plan: CodePlan, fixed: bool) -> str:
    if plan.fis.no_rule_fires == "midrange" or fixed:
        return "the middle of its range stands there"
    return "not-a-number stands there"


def sentence(plan: CodePlan, rule: int) -> str:
    """A rule's sentence, as a comment."""
    text = f"{rule + 1}: {comment(str(plan.fis.rules[rule]))}"
    return "    /* " + fill(text, 108, subsequent_indent="     * ", break_long_words=False) + " */"


class _Writer:
    """The source in double or float."""

    def __init__(self, plan: CodePlan, number: Floating) -> None:
        self.plan, self.number, self.real = plan, number, number.name
        self.zero, self.one = number.constant(0.0), number.constant(1.0)

    def source(self) -> str:
        """The whole text."""
        plan = self.plan
        tables = [] if plan.unrolled else [*self._rule_tables(), *self._consequent_tables()]
        body = [*self._inputs(), *self._degrees(), *self._strengths(), *self._consequents(), "    return told;"]
        function = "\n".join([signature(plan.name, self.real) + " {", *body, "}", ""])
        includes = [f'#include "{plan.name}.h"', "", "#include <math.h>"]
        parts = [
            f"/* {comment(plan.fis.name)}, in {self.real}: see {plan.name}.h. Made of the system: change that. */",
            "\n".join(includes) + "\n",
            self.number.typed(called("floating.c", function)),
            *(["\n".join(tables) + "\n"] if tables else []),
            function,
        ]
        return "\n".join(part for part in parts if part)

    def _inputs(self) -> list[str]:
        """Inputs by their names, limited or not, and whether one is not-a-number."""
        plan, upper, clips = self.plan, self.plan.name.upper(), self.plan.fis.out_of_range == "clip"
        rows = [
            "    int told = 0;",
            f"    {self.real} unknown = {self.zero}; /* not-a-number if an input or a degree is */",
        ]
        tests = []
        for k, (name, variable) in enumerate(zip(plan.inputs, plan.fis.inputs, strict=True)):
            low, high = self.number.bounds(variable.universe)
            rows.append(f"    const {self.real} {name} = {limited_to(f'x[{k}]', low, high) if clips else f'x[{k}]'};")
            if not clips:
                tests.append(f"    if ({name} < {low} || {name} > {high}) told = {upper}_OUTSIDE;")
            tests.append(f"    if (isnan({name})) unknown = {self.number.unknown};")
        return [*rows, *tests, ""]

    def _call(self, term: CodeTerm) -> str:
        """A degree, or its logarithm, as an expression."""
        if self.real == "float":
            return FloatTerm(self.number, term, self.plan.logs).text()
        function = f"{'log_' if self.plan.logs else ''}{term.function}"
        return f"{function}({term.variable}, {', '.join(map(self.number.constant, term.parameters))})"

    def _degrees(self) -> list[str]:
        """Layer 1: degrees of membership, or their logarithms."""
        plan = self.plan
        what = "logarithms of the degrees of membership" if plan.logs else "degrees of membership"
        rows = [f"    /* Layer 1: {what} */"]
        for k, term in enumerate(plan.terms):
            left = f"const {self.real} {term.name} = " if plan.unrolled else f"degree[{k}] = "
            rows.append(f"    {left}{self._call(term)};{'' if plan.unrolled else f' /* {comment(term.name)} */'}")
        if not plan.unrolled:
            rows.insert(1, f"    {self.real} degree[{len(plan.terms)}];")
        for k, term in enumerate(plan.terms):
            if term.function != "gaussmf" or not np.isfinite(term.parameters).all():
                degree = term.name if plan.unrolled else f"degree[{k}]"
                rows.append(f"    if (isnan({degree})) unknown = {self.number.unknown};")
        return [*rows, ""]

    def _clause(self, clause: CodeClause) -> str:
        """What a clause asks for, of a rule that is a line of its own."""
        name = self.plan.terms[clause.term].name
        if self.plan.logs:
            return name if clause.power == 1 else f"{self.number.constant(clause.power)} * {name}"
        if clause.power == 2:
            name = f"{name} * {name}"
        elif clause.power == 0.5:
            name = f"sqrt{self.number.suffix}({name})"
        elif clause.power != 1:
            name = f"hedged({name}, {self.number.constant(clause.power)})"
        if clause.negated:
            return f"({self.one} - {name})"
        return f"({name})" if clause.power == 2 else name

    def _joined(self, rule: int) -> str:
        """A rule's firing strength without its weight, or the logarithm of it."""
        fis, parts = self.plan.fis, [self._clause(clause) for clause in self.plan.clauses[rule]]
        if self.plan.logs:
            return " + ".join(parts)
        if fis.rules[rule].connective == "or":
            function = "both" if fis.or_method == "probor" else "most"
        elif fis.and_method == "prod":
            return " * ".join(parts)
        else:
            function = "least"
        joined = parts[0]
        for part in parts[1:]:
            joined = f"{function}({joined}, {part})"
        return joined

    def _strengths(self) -> list[str]:
        """Layers 2 and 3: firing strengths, of logarithms those relative to the strongest."""
        plan = self.plan
        if not plan.rules:
            return []
        rows = ["    /* Layer 2: firing strengths */", f"    {self.real} w[{plan.rules}];"]
        if plan.unrolled:
            for r in range(plan.rules):
                weight = plan.weights[r]
                factor = "" if plan.logs or weight == 1 else f" * {self.number.constant(weight)}"
                rows += [sentence(plan, r), f"    w[{r}] = {self._joined(r)}{factor};"]
        else:
            rows += self._strength_loop()
        return [*rows, "", *(self._relative() if plan.logs else self._normalised())]

    def _relative(self) -> list[str]:
        """Strengths from logarithms: relative to the strongest, so that none is lost far from all rules."""
        plan, n, suffix = self.plan, self.plan.rules, self.number.suffix
        sums, weighted, rows = plan.sums, plan.is_weighted, []
        if weighted and plan.unrolled:
            listed = ", ".join(map(self.number.constant, plan.weights))
            rows = [f"    static const {self.real} weight_of[{n}] = {{{listed}}};"]
        target = "share" if sums else "w"
        factor = " * weight_of[r]" if weighted else ""
        counts = "weight_of[r] > " + self.zero + " && " if weighted else ""
        least = self.number.constant(self.number.never / 1e6)
        rows += [
            *(
                [f"    {self.real} share[{n}]; /* relative to the strongest: whether a rule fires at all */"]
                if sums
                else []
            ),
            f"    {self.real} top = -{self.number.infinity}; /* the strongest */",
            f"    for (int r = 0; r < {n}; r++) if ({counts}w[r] > top) top = w[r];",
            f"    if (!(top > {least})) top = {self.zero};",
        ]
        relative = f"w[r] < top ? w[r] - top : {self.zero}" if weighted else "w[r] - top"
        rows.append(f"    for (int r = 0; r < {n}; r++) {target}[r] = exp{suffix}({relative}){factor};")
        if sums:
            rows.append(f"    for (int r = 0; r < {n}; r++) w[r] = exp{suffix}(w[r]){factor};")
        return [*rows, ""]

    def _normalised(self) -> list[str]:
        """Layer 3: the strengths as shares of their sum, in the order of the compiled inference: the same bits."""
        plan, n = self.plan, self.plan.rules
        if plan.sums:
            return []
        return [
            "    /* Layer 3: their shares */",
            f"    {self.real} total = {self.zero};",
            f"    for (int r = 0; r < {n}; r++) total += w[r];",
            f"    for (int r = 0; r < {n}; r++) w[r] /= total > {self.zero} ? total : {self.one};",
            "",
        ]

    @property
    def _fires(self) -> str:
        """The array that says whether a rule fires."""
        return "share" if self.plan.logs and self.plan.sums else "w"

    def _consequents(self) -> list[str]:
        """Layers 4 and 5: what the rules propose, and the outputs."""
        rows = ["    /* Layers 4 and 5: consequents and outputs */"]
        for o in range(len(self.plan.outputs)):
            rows += self._output(o)
        return rows

    def _output(self, o: int) -> list[str]:
        plan, upper, name = self.plan, self.plan.name.upper(), self.plan.outputs[o]
        variable = plan.fis.outputs[o]
        default = (
            self.number.constant(variable.midrange) if plan.fis.no_rule_fires == "midrange" else self.number.unknown
        )
        part = np.flatnonzero(plan.takes_part[o]).tolist()
        nobody = [f"    told |= {upper}_NO_RULE;", f"    y[{o}] = {default} + unknown;"]
        if not len(part):
            return nobody
        if plan.unrolled:
            fired = " + ".join(f"{self._fires}[{r}]" for r in part)
            said = [f"w[{r}] * {self._consequent(o, r)}" for r in part]
            rows = [f"    const {self.real} {name}_fired = {fired};"]
            rows.append(f"    const {self.real} {name}_said = {(chr(10) + '        + ').join(said)};")
        else:
            rows = self._output_loop(o)
        whole = plan.sums or (not plan.logs and bool(plan.takes_part[o].all()))
        value = f"{name}_said" if whole else f"{name}_said / {name}_fired"
        # 0 times infinity is not-a-number: an input that some plane leaves out must not be infinite.
        left_out = (plan.slopes[o][plan.takes_part[o]] == 0).any(axis=0) if plan.has_planes(o) else []
        finite = "".join(f" + ({i} - {i})" for i, out in zip(plan.inputs, left_out, strict=False) if out)
        return [
            *rows,
            f"    if ({name}_fired > {self.zero}) y[{o}] = {value} + unknown{finite};",
            "    else {",
            *("    " + row for row in nobody),
            "    }",
        ]

    def _consequent(self, o: int, r: int) -> str:
        plan = self.plan
        constant = self.number.constant(plan.constants[o, r])
        slopes = [
            f"{self.number.constant(slope)} * {name}"
            for name, slope in zip(plan.inputs, plan.slopes[o, r], strict=True)
            if slope != 0
        ]
        if not slopes:
            return f"({constant})" if constant.startswith("-") else constant
        return f"({' + '.join([constant, *slopes])})".replace("+ -", "- ")

    # Tables and loops, for systems of many rules ------------------------------------------------------------

    def _rule_tables(self) -> list[str]:
        plan, constant = self.plan, self.number.constant
        powers = [constant(clause.power) for clause in plan.all_clauses]
        return rule_tables(plan, self.real, powers, [constant(w) for w in plan.weights], "unsigned char")

    def _strength_loop(self) -> list[str]:
        plan, suffix = self.plan, self.number.suffix
        powers, negations, ors = plan.has_powers, plan.has_negations, plan.has_ors
        start = self.zero if plan.logs else self.one
        head = start if not ors else f"rule_or[r] ? {self.zero} : {self.one}"
        rows = [
            f"    for (int r = 0, k = 0; r < {plan.rules}; r++) {{",
            f"        {self.real} strength = {head};",
            "        for (; k < rule_end[r]; k++) {",
        ]
        degree = "degree[clause_term[k]]"
        if plan.logs:
            factor = " * clause_power[k]" if powers else ""
            rows.append(f"            strength += {degree}{factor};")
        else:
            changes = powers or negations
            rows.append(f"            {'' if changes else 'const '}{self.real} value = {degree};")
            if powers:
                rows.append(f"            if (clause_power[k] == {self.number.constant(2.0)}) value *= value;")
                rows.append(
                    f"            else if (clause_power[k] == {self.number.constant(0.5)}) value = sqrt{suffix}(value);"
                )
                rows.append(
                    f"            else if (clause_power[k] != {self.one}) value = hedged(value, clause_power[k]);"
                )
            if negations:
                rows.append(f"            if (clause_negated[k]) value = {self.one} - value;")
            conjunction = "strength * value" if plan.fis.and_method == "prod" else "least(strength, value)"
            if ors:
                function = "both" if plan.fis.or_method == "probor" else "most"
                conjunction = f"rule_or[r] ? {function}(strength, value) : {conjunction}"
            rows.append(f"            strength = {conjunction};")
        weighted = not plan.logs and plan.is_weighted
        rows += ["        }", f"        w[r] = strength{' * weight_of[r]' if weighted else ''};", "    }"]
        return rows

    def _consequent_tables(self) -> list[str]:
        """The consequents of each output, those of a rule one after the other: slopes where it has any, constant."""
        plan, rows = self.plan, []
        for o, name in enumerate(plan.outputs):
            part = plan.takes_part[o]
            if not part.any():
                continue
            if not part.all():
                rows.append(table("unsigned char", f"{name}_part", part.astype(int).tolist()))
            numbers = (
                np.concatenate([plan.slopes[o], plan.constants[o][:, None]], axis=1).ravel()
                if plan.is_linear(o)
                else plan.constants[o]
            )
            rows.append(table(self.real, f"{name}_of", [self.number.constant(value) for value in numbers]))
        return rows

    def _output_loop(self, o: int) -> list[str]:
        plan, name = self.plan, self.plan.outputs[o]
        rows = [
            f"    {self.real} {name}_fired = {self.zero}, {name}_said = {self.zero};",
            f"    for (int r = 0; r < {plan.rules}; r++) {{",
        ]
        if not plan.takes_part[o].all():
            rows.append(f"        if (!{name}_part[r]) continue;")
        if plan.is_linear(o):
            width = len(plan.inputs) + 1
            terms = [f"p[{i}] * {input_}" for i, input_ in enumerate(plan.inputs)]
            rows.append(f"        const {self.real} *const p = {name}_of + {width} * r;")
            proposal = f"({' + '.join([f'p[{width - 1}]', *terms])})"
        else:
            proposal = f"{name}_of[r]"
        rows += [f"        {name}_fired += {self._fires}[r];", f"        {name}_said += w[r] * {proposal};", "    }"]
        return rows
