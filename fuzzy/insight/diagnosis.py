"""Defects of a rule base: places where no rule fires, terms and rules that do nothing, rules that disagree."""

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from itertools import combinations
from typing import Literal, get_args

import numpy as np

from fuzzy.detached import detached
from fuzzy.inference import forgiving
from fuzzy.insight.coverage import gaps_of_variable, uncovered
from fuzzy.insight.universe import consequent_range, universe_grid
from fuzzy.rule import Rule
from fuzzy.shown import shown
from fuzzy.system import Linear, Sugeno, Variable
from fuzzy.words import listed

Severity = Literal["error", "warning", "note"]

_IDENTICAL = 0.02  # two terms whose degrees never differ by more are nearly the same


@dataclass(frozen=True)
class Finding:
    """A defect that :func:`check` found.

    Attributes:
        severity: "error": it makes no sense; "warning": it is probably unwanted; "note": it is worth knowing.
        kind: The sort of finding, in a few words, such as "no rule fires".
        sentence: What was found, with names and numbers.
        where: The names of variables and terms, the numbers of rules (from 1).
    """

    severity: Severity
    kind: str
    sentence: str
    where: tuple[str | int, ...] = ()

    def __str__(self) -> str:
        return f"{self.severity}: {self.sentence}"


def check(fis: Sugeno, points: int = 4096, seed: int = 0, numbers: Sequence[int] | None = None) -> list[Finding]:
    """Look for defects of ``fis``. The gravest come first.

    Terms and rules are compared exactly, or on a fine grid of their universe.

    Args:
        fis: The system.
        points: The number of quasi-random points at which places are sought where no rule fires.
        seed: A number that shifts these points.
        numbers: The rules' numbers (rules,) in the findings; 1, 2, ... by default.

    Returns:
        The findings, the gravest first; an empty list for a system without defects.

    Raises:
        ValueError: Fewer than one point, or numbers that are not one for each rule.
    """
    if points < 1:
        raise ValueError(f"the number of points must be at least 1, got {points}")
    named = list(range(1, len(fis.rules) + 1)) if numbers is None else list(numbers)
    if len(named) != len(fis.rules):
        raise ValueError(f"the {len(fis.rules)} rules need a number each, got {len(named)}")
    fis = forgiving(detached(fis))
    looks: list[Callable[[Sugeno], Iterator[Finding]]] = [
        _rules_missing,
        lambda system: _coverage(system, points, seed),
        _unused,
        lambda system: _same_antecedents(system, named),
        lambda system: _silent_rules(system, named),
        _terms,
        _consequents,
    ]
    findings = [finding for look in looks for finding in look(fis)]
    return sorted(findings, key=lambda finding: get_args(Severity).index(finding.severity))


def _rules_missing(fis: Sugeno) -> Iterator[Finding]:
    if not fis.rules:
        yield Finding("error", "no rules", "the system has no rules")
        return
    for output, consequent in zip(fis.outputs, fis.structure.consequent, strict=True):
        if (consequent < 0).all():
            yield Finding(
                "error", "no rule for an output", f"no rule proposes a value for {output.name}", (output.name,)
            )


def _coverage(fis: Sugeno, points: int, seed: int) -> Iterator[Finding]:
    if not fis.rules:
        return
    for output, share, box in uncovered(fis, points, seed):
        example = " and ".join(
            f"{v.name} is {_number(low, v)}{f' to {_number(high, v)}' if high > low else ''}"
            f"{f' {v.unit}' if v.unit else ''}"
            for v, (low, high) in zip(fis.inputs, box, strict=True)
        )
        part = f"about {share:.2g} %" if share >= 0.01 else "less than 0.01 %"
        where = f"in {part} of the input space, for example where {example}" if share < 100 else "anywhere"
        yield Finding("warning", "no rule fires", f"no rule for {output} fires {where}", (output,))
    for variable in fis.inputs:
        for low, high, harmless in gaps_of_variable(fis, variable):
            place = f"at {_number(low, variable, 6)}"
            if high > low:
                place = f"from {_number(low, variable, 6)} to {_number(high, variable, 6)}"
            yield Finding(
                "note" if harmless else "warning",
                "gap between terms",
                f"no term of {variable.name} applies {place}{f' {variable.unit}' if variable.unit else ''}"
                + (", but a rule that does not ask for it fires there" if harmless else ""),
                (variable.name,),
            )


def _unused(fis: Sugeno) -> Iterator[Finding]:
    s = fis.structure
    weighed = _weighed(fis)
    for kind, variables, places in (("input", fis.inputs, s.term), ("output", fis.outputs, s.consequent)):
        for variable, place in zip(variables, places, strict=True):
            if (place < 0).all():
                if kind == "input" and fis.rules and variable.name not in weighed:
                    yield Finding(
                        "warning", "unused input", f"no rule asks for the input {variable.name}", (variable.name,)
                    )
                continue
            unused = [name for t, name in enumerate(variable.terms) if not (place == t).any()]
            if unused:
                yield Finding(
                    "warning" if kind == "input" else "note",
                    "unused term",
                    f"no rule uses {listed(unused)} of {variable.name}",
                    (variable.name, *unused),
                )


def _weighed(fis: Sugeno) -> set[str]:
    """The inputs that a linear consequent of some rule weighs."""
    terms = [fis[output].terms[term] for rule in fis.rules for output, term in rule.then]
    slopes = [np.asarray(term.slopes) for term in terms if isinstance(term, Linear)]
    return {v.name for k, v in enumerate(fis.inputs) if any(row[k] != 0 for row in slopes)}


def _antecedent(rule: Rule) -> tuple[object, ...]:
    """What makes two antecedents the same: their clauses in any order, and the connective if it joins anything."""
    return (rule.connective if len(rule.when) > 1 else "and", frozenset(rule.when))


def _same_antecedents(fis: Sugeno, named: Sequence[int]) -> Iterator[Finding]:
    groups: dict[tuple[object, ...], list[int]] = {}
    for r, rule in enumerate(fis.rules):
        groups.setdefault(_antecedent(rule), []).append(r)
    for group in groups.values():
        same: dict[tuple[object, ...], list[int]] = {}
        for r in group:
            same.setdefault((frozenset(fis.rules[r].then), fis.rules[r].weight), []).append(r)
        for equal in same.values():
            if len(equal) > 1:
                yield Finding(
                    "warning",
                    "duplicate rules",
                    f"{_numbers(equal, named)} are the same: {fis.rules[equal[0]]}",
                    tuple(named[r] for r in equal),
                )
        for first, second in combinations([equal[0] for equal in same.values()], 2):
            yield from _compared(fis, first, second, named)


def _compared(fis: Sugeno, first: int, second: int, named: Sequence[int]) -> Iterator[Finding]:
    """What to say of two rules with the same antecedent that are not equal."""
    one, other = fis.rules[first], fis.rules[second]
    then, also = dict(one.then), dict(other.then)
    different = [v for v in then if v in also and then[v] != also[v]]
    numbers, pair = _numbers([first, second], named), (named[first], named[second])
    if then == also:
        yield Finding(
            "warning",
            "duplicate rules",
            f"{numbers} differ only in their weights, {one.weight:g} and {other.weight:g}: {one}",
            pair,
        )
    elif different and one.weight > 0 and other.weight > 0:
        values = " and ".join(f"{v} both {then[v]} and {also[v]}" for v in different)
        yield Finding(
            "warning",
            "contradictory rules",
            f"{numbers} have the same antecedent but make {values}: {_when(one)}",
            pair,
        )
    elif not different:
        yield Finding(
            "note", "same antecedent", f"{numbers} have the same antecedent and could be one: {_when(one)}", pair
        )


def _numbers(rules: Sequence[int], named: Sequence[int]) -> str:
    return f"rules {listed(str(named[r]) for r in rules)}"


def _when(rule: Rule) -> str:
    return "if " + f" {rule.connective} ".join(map(str, rule.when))


def _silent_rules(fis: Sugeno, named: Sequence[int]) -> Iterator[Finding]:
    for number, rule in zip(named, fis.rules, strict=True):
        if rule.weight == 0:
            yield Finding("warning", "weight 0", f"rule {number} has the weight 0 and never counts: {rule}", (number,))
        never = []
        for clause in rule.when:
            variable = fis[clause.variable]
            degree = clause.degree(np.asarray(variable.terms[clause.term](_grid(variable))))
            if degree.max() <= 0:
                never.append(str(clause))
        if never and (rule.connective == "and" or len(never) == len(rule.when)):
            yield Finding(
                "warning",
                "rule never fires",
                f"rule {number} can never fire, because never {listed(never)}: {rule}",
                (number,),
            )


def _terms(fis: Sugeno) -> Iterator[Finding]:
    for place, variable in enumerate(fis.inputs):
        low, high = variable.universe
        names = list(variable.terms)
        if not names:
            if any(isinstance(t, Linear) and t.slopes[place] for v in fis.outputs for t in v.terms.values()):
                continue  # linear consequents take it
            yield Finding("warning", "no terms", f"the input {variable.name} has no terms", (variable.name,))
            continue
        x = _grid(variable)
        degrees = np.array([np.asarray(function(x)) for function in variable.terms.values()])  # (terms, places)
        present = []
        for n, name in enumerate(names):
            if degrees[n].max() <= 0:
                yield Finding(
                    "warning",
                    "term out of range",
                    f"{name} of {variable.name} is 0 in all of its range [{low:g} {high:g}]",
                    (variable.name, name),
                )
                continue
            present.append(n)
            if degrees[n].max() < 0.5:
                yield Finding(
                    "note",
                    "low term",
                    f"{name} of {variable.name} is at most {shown(degrees[n].max(), 1, 2)} in its range "
                    f"[{low:g} {high:g}]",
                    (variable.name, name),
                )
        for a, b in combinations(present, 2):
            difference = np.abs(degrees[a] - degrees[b]).max()
            overlap = np.minimum(degrees[a], degrees[b]).max()
            where = (variable.name, names[a], names[b])
            if difference <= _IDENTICAL:
                yield Finding(
                    "warning",
                    "nearly identical terms",
                    f"{names[a]} and {names[b]} of {variable.name} are nearly the same: "
                    f"their degrees never differ by more than {shown(difference, 1, 2)}",
                    where,
                )
            elif overlap > 0.9:
                yield Finding(
                    "note",
                    "strong overlap",
                    f"{names[a]} and {names[b]} of {variable.name} overlap up to a degree of {shown(overlap, 1, 2)}",
                    where,
                )
        total = degrees.sum(axis=0)
        if total.min() < 0.5 or total.max() > 1.5:
            yield Finding(
                "note",
                "degrees do not sum to 1",
                f"the degrees of {variable.name} sum to between {shown(total.min(), 1, 2)} "
                f"(at {_number(x[total.argmin()], variable)}) and {shown(total.max(), 1, 2)} "
                f"(at {_number(x[total.argmax()], variable)})",
                (variable.name,),
            )


def _consequents(fis: Sugeno) -> Iterator[Finding]:
    for output in fis.outputs:
        low, high = output.universe
        slack = 1e-9 * max(abs(low), abs(high), high - low)
        constants, linear = {}, {}
        for name, term in output.terms.items():
            least, most = consequent_range(fis, term)
            if least >= low - slack and most <= high + slack:
                continue
            if least == most:
                constants[name] = f"{name} ({_number(least, output)})"
            else:
                linear[name] = f"{name} ({_number(least, output)} to {_number(most, output)})"
        severity: Severity
        # A plane that leaves the range in some corner may never be asked there.
        for severity, outside in (("warning", constants), ("note", linear)):
            if outside:
                yield Finding(
                    severity,
                    "consequent out of range",
                    f"{listed(outside.values())} of {output.name} {'leaves' if len(outside) == 1 else 'leave'} "
                    f"its range [{low:g} {high:g}]",
                    (output.name, *outside),
                )


def _number(value: float, variable: Variable, digits: int = 4) -> str:
    return shown(value, variable.span, digits)


def _grid(variable: Variable) -> np.ndarray:
    return universe_grid(variable, 1001)
