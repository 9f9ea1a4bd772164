"""Sugeno systems as text in the FuzzyLite Language; :mod:`fuzzy.plugins.mamdani.fllfile` reads it."""

import math
import os
import re
import unicodedata
from collections.abc import Sequence
from dataclasses import replace
from itertools import pairwise

from fuzzy.files.atomic import write_whole
from fuzzy.membership import LinearZ
from fuzzy.membershipfunction import MembershipError, MembershipFunction, as_number
from fuzzy.plugins.mamdani.fllfile import AND_METHODS, OR_METHODS, TERMS, FllFileError, check_difference
from fuzzy.rule import KEYWORDS, Rule, hedge_words, renamed_rule
from fuzzy.system import Constant, Sugeno, Variable

# How a membership function is written, as TERMS reads it; of several terms that are equal the first.
_WRITTEN: dict[type[MembershipFunction], tuple[str, tuple[int, ...]]] = {
    LinearZ: ("Ramp", (1, 0)),
    **{function: (kind, order) for kind, (function, order) in reversed(TERMS.items())},
}


def write_fll(fis: Sugeno, path: str | os.PathLike[str]) -> None:
    """Write a system as a FuzzyLite file, whole or not at all.

    Args:
        fis: The system.
        path: The file.

    Raises:
        FllFileError: As of :func:`format_fll`.
        OSError: The file cannot be written.
    """
    text = format_fll(fis)
    write_whole(os.fsdecode(path), text)


def format_fll(fis: Sugeno) -> str:
    """A system as a text in FuzzyLite's language; numbers keep all their digits.

    Names become letters, digits and _, as FuzzyLite's are: "Very close" is Very_close. Units are left out.

    Args:
        fis: The system.

    Raises:
        FllFileError: A hedge that FuzzyLite does not have, and functions whose vertices cross.
    """
    fis = _named_plainly(fis)
    rows = [f"Engine: {fis.name}"]
    for variable in fis.inputs:
        rows += ["InputVariable: " + variable.name, "  enabled: true", f"  range: {_numbers(variable.universe)}"]
        rows.append(f"  lock-range: {str(fis.out_of_range == 'clip').lower()}")
        rows += [f"  term: {name} {_written(fis, variable, name, term)}" for name, term in variable.terms.items()]
    kind = "WeightedSum" if fis.defuzzification == "wtsum" else "WeightedAverage"
    for variable in fis.outputs:
        default = variable.midrange if fis.no_rule_fires == "midrange" else math.nan
        rows += ["OutputVariable: " + variable.name, "  enabled: true", f"  range: {_numbers(variable.universe)}"]
        rows += ["  lock-range: false", "  aggregation: none", f"  defuzzifier: {kind} TakagiSugeno"]
        rows += [f"  default: {_numbers([default])}", "  lock-previous: false"]
        for name, term in variable.terms.items():
            what = "Constant" if isinstance(term, Constant) else "Linear"
            rows.append(f"  term: {name} {what} {_numbers([as_number(p) for p in term.parameters])}")
    rows += ["RuleBlock: rules", "  enabled: true"]
    rows.append(f"  conjunction: {_named(AND_METHODS, fis.and_method)}")
    rows.append(f"  disjunction: {_named(OR_METHODS, fis.or_method)}")
    rows += ["  implication: AlgebraicProduct", "  activation: General"]
    rows += [f"  rule: {_rule_text(fis, k, rule)}" for k, rule in enumerate(fis.rules)]
    return "\n".join(rows) + "\n"


def _named_plainly(fis: Sugeno) -> Sugeno:
    """The system with names that FuzzyLite can hold, all different."""
    taken: list[str] = []
    names: dict[str, tuple[str, dict[str, str]]] = {}  # by variable: its name, and those of its terms
    for variable in (*fis.inputs, *fis.outputs):
        if variable.name not in names:
            names[variable.name] = _plain(variable.name, taken), {}
        name, terms = names[variable.name]
        taken.append(name)
        inside: list[str] = []
        for term in variable.terms:
            terms[term] = _plain(term, inside)
            inside.append(terms[term])

    def renamed(variable: Variable) -> Variable:
        name, terms = names[variable.name]
        return replace(variable, name=name, terms={terms[label]: term for label, term in variable.terms.items()})

    rules = [renamed_rule(rule, names, names) for rule in fis.rules]
    inputs, outputs = ([renamed(v) for v in variables] for variables in (fis.inputs, fis.outputs))
    return replace(fis, inputs=inputs, outputs=outputs, rules=rules, name=re.sub(r"[\r\n#]", " ", fis.name))


def _plain(name: str, taken: Sequence[str]) -> str:
    spelt = unicodedata.normalize("NFKD", name).encode("ascii", "ignore").decode()
    plain = first = re.sub(r"\W+", "_", spelt, flags=re.ASCII).strip("_") or "unnamed"
    if first[0].isdigit() or first.casefold() in KEYWORDS:
        plain = first = f"{'t_' if first[0].isdigit() else ''}{first}{'_' if first.casefold() in KEYWORDS else ''}"
    number = 2
    while plain in taken:
        plain, number = f"{first}_{number}", number + 1
    return plain


def _named(known: dict[str, str], method: str) -> str:
    return next(name for name, ours in known.items() if ours == method)


def _numbers(values: Sequence[float]) -> str:
    return " ".join("nan" if math.isnan(v) else repr(float(v)) for v in values)


def _written(fis: Sugeno, variable: Variable, label: str, function: MembershipFunction) -> str:
    p = list(function.numbers)
    name = type(function).__name__
    crossed = {"SShape": p[:2], "ZShape": p[:2], "Trapezoid": p, "PiShape": p}.get(name, [])
    if any(b < a for a, b in pairwise(crossed)) or (
        name in ("SShape", "ZShape", "PiShape") and (p[0] == p[1] or p[-2] == p[-1])
    ):
        raise FllFileError(fis.name, None, f"{variable.name} is {label}: FuzzyLite has no {name} whose vertices cross")
    if name in ("LinearS", "LinearZ") and p[0] == p[1]:
        raise FllFileError(fis.name, None, f"{variable.name} is {label}: FuzzyLite has no ramp without width")
    kind, order = _WRITTEN.get(type(function), (name, tuple(range(len(p)))))
    values = [p[order.index(k)] for k in range(len(p))]
    if kind == "SigmoidDifference":
        try:
            check_difference(*values)
        except MembershipError as error:
            raise FllFileError(fis.name, None, f"{variable.name} is {label}: {error}") from None
    return f"{kind} {_numbers(values)}"


def _rule_text(fis: Sugeno, k: int, rule: Rule) -> str:
    clauses = []
    for clause in rule.when:
        hedges = hedge_words(clause.power)
        if hedges is None or "extremely" in hedges:
            raise FllFileError(
                fis.name,
                None,
                f"rule {k + 1}: FuzzyLite has no hedge for the power {clause.power:g}",
            )
        words = ["not"] * clause.negated + hedges.split()
        clauses.append(" ".join([clause.variable, "is", *words, clause.term]))
    then = " and ".join(f"{output} is {term}" for output, term in rule.then)
    weight = "" if rule.weight == 1 else f" with {rule.weight!r}"
    return f"if {f' {rule.connective} '.join(clauses)} then {then}{weight}"
