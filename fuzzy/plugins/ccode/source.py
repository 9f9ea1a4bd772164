"""A system as a header and a source of C."""

from textwrap import fill
from typing import Any, NamedTuple

import numpy as np

from fuzzy.plugins.ccode.fixedpoint import fixed_source
from fuzzy.plugins.ccode.floatterm import FloatTerm
from fuzzy.plugins.ccode.identifier import comment, identifiers
from fuzzy.plugins.ccode.numbertype import FIXED_POINT, FLOATING, Floating, c_type, checked_number
from fuzzy.plugins.ccode.phrases import called, limited_to, rendered, rule_tables, signature, table
from fuzzy.plugins.ccode.plan import CodeClause, CodePlan, CodeTerm, planned
from fuzzy.shown import shown
from fuzzy.system import Sugeno, Variable


class CSources(NamedTuple):
    """A system in C: two texts, and what they are called."""

    name: str  # of the files, without ending, and of the functions' prefix
    header: str
    source: str

    @property
    def texts(self) -> dict[str, str]:
        """The texts by their files' names."""
        return {f"{self.name}.h": self.header, f"{self.name}.c": self.source}


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
    return CSources(plan.name, header(plan, kind.name), FloatWriter(plan, kind).source())


def header(plan: CodePlan, real: str, kind: str = "", no_rule: str = "") -> str:
    """The header: what goes in and comes out, in which units, and how it is called.

    Args:
        plan: The system.
        real: The type of its numbers in C.
        kind: What it is, by default a system of so many rules.
        no_rule: What stands where no rule fires, by default what the system says.
    """
    upper, fixed = plan.name.upper(), real == c_type(FIXED_POINT)

    def example(variable: Variable) -> str:
        value = FLOATING["double"].constant(float(f"{variable.midrange:.3g}"))
        return f"{upper}_Q16({value})" if fixed else value

    def described(variable: Variable) -> str:
        low, high = (shown(end) for end in variable.universe)
        return f"{comment(variable.name)}, {low} to {high}{' ' + comment(variable.unit) if variable.unit else ''}"

    midrange = plan.fis.no_rule_fires == "midrange" or fixed
    return rendered(
        "header.h.j2",
        plan,
        real=real,
        fixed=fixed,
        kind=kind or f"a Takagi-Sugeno system of {plan.rules} rules",
        example=example,
        described=described,
        numbered=lambda names: identifiers(map(str.upper, names)),
        no_rule=no_rule or ("the middle of its range" if midrange else "not-a-number"),
        signature=signature(plan.name, real),
    )


def sentence(plan: CodePlan, rule: int) -> str:
    """A rule's sentence, as a comment."""
    text = f"{rule + 1}: {comment(str(plan.fis.rules[rule]))}"
    return "    /* " + fill(text, 108, subsequent_indent="     * ", break_long_words=False) + " */"


class FloatWriter:
    """The source in double or float."""

    template = "floating_infer.c.j2"

    def __init__(self, plan: CodePlan, number: Floating) -> None:
        self.plan, self.number, self.real = plan, number, number.name
        self.zero, self.one = number.constant(0.0), number.constant(1.0)

    def source(self) -> str:
        """The whole text."""
        plan, number = self.plan, self.number
        tables = self.tables()
        function = rendered(
            self.template,
            plan,
            number=number,
            real=self.real,
            zero=self.zero,
            one=self.one,
            constant=number.constant,
            signature=signature(plan.name, self.real),
            inputs=[self._input(k) for k in range(len(plan.inputs))],
            outputs=[self._output(o) for o in range(len(plan.outputs))],
            fires="share" if plan.logs and plan.sums else "w",
            degree=self._degree,
            **self.more(),
            is_finite=lambda term: np.isfinite(term.parameters).all(),
            sentence=sentence,
            strength=self._strength,
            consequent=self._consequent,
        )
        includes = [f'#include "{plan.name}.h"', "", "#include <math.h>"]
        parts = [
            f"/* {comment(plan.fis.name)}, in {self.real}: see {plan.name}.h. Made of the system: change that. */",
            "\n".join(includes) + "\n",
            number.typed(called("floating.c", function)),
            *(["\n".join(tables) + "\n"] if tables else []),
            function,
        ]
        return "\n".join(part for part in parts if part)

    def tables(self) -> list[str]:
        """The tables of a system that is written as loops."""
        return [] if self.plan.unrolled else [*self._rule_tables(), *self._consequent_tables()]

    def more(self) -> dict[str, Any]:
        """What the template names besides."""
        return {}

    def _input(self, k: int) -> dict[str, str]:
        """An input by its name, limited or not, and the ends of its range."""
        low, high = self.number.bounds(self.plan.fis.inputs[k].universe)
        taken = limited_to(f"x[{k}]", low, high) if self.plan.fis.out_of_range == "clip" else f"x[{k}]"
        return {"name": self.plan.inputs[k], "low": low, "high": high, "taken": taken}

    def _degree(self, term: CodeTerm) -> str:
        """A degree, or its logarithm, as an expression."""
        if self.real == "float":
            return FloatTerm(self.number, term, self.plan.logs).text()
        function = f"{'log_' if self.plan.logs else ''}{term.function}"
        return f"{function}({term.variable}, {', '.join(map(self.number.constant, term.parameters))})"

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

    def _strength(self, rule: int) -> str:
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

    def _output(self, o: int) -> dict[str, Any]:
        """An output by its name: the rules that speak of it, and what stands where none fires."""
        plan, number, variable = self.plan, self.number, self.plan.fis.outputs[o]
        part = plan.takes_part[o]
        # 0 times infinity is not-a-number: an input that some plane leaves out must not be infinite.
        left_out = (plan.slopes[o][part] == 0).any(axis=0) if part.any() and plan.has_planes(o) else []
        return {
            "name": plan.outputs[o],
            "rules": np.flatnonzero(part).tolist(),
            "default": number.constant(variable.midrange) if plan.fis.no_rule_fires == "midrange" else number.unknown,
            "whole": plan.sums or (not plan.logs and part.all()),
            "left_out": [i for i, out in zip(plan.inputs, left_out, strict=False) if out],
        }

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
