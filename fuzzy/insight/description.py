"""A system as text for people and as plain data for JSON."""

from typing import Any

from fuzzy.membershipfunction import MembershipFunction
from fuzzy.shown import shown
from fuzzy.system import Constant, Sugeno, Variable, sizes

_DIGITS = 6


def describe(fis: Sugeno) -> str:
    """Describe the system in words: its choices, its variables with their terms, and its rules, one on each line."""
    lines = [
        f"{fis.name}: {sizes(fis)}",
        f"and = {fis.and_method}, or = {fis.or_method}, defuzzification = {fis.defuzzification}, "
        f"no rule fires = {fis.no_rule_fires}, out of range = {fis.out_of_range}",
    ]
    for kind, variables in (("input", fis.inputs), ("output", fis.outputs)):
        for variable in variables:
            low, high = variable.universe
            limits = f"[{shown(low, 0, _DIGITS)} {shown(high, 0, _DIGITS)}]"
            lines += ["", f"{kind} {variable.name} {limits} {variable.unit}".rstrip()]
            width = max((len(name) for name in variable.terms), default=0)
            lines += [f"  {name:{width}}  {_term(fis, variable, term)}" for name, term in variable.terms.items()]
    lines += ["", "rules"]
    digits = len(str(len(fis.rules)))
    lines += [f"  {number:{digits}}. {rule}" for number, rule in enumerate(fis.rules, 1)]
    return "\n".join(lines)


def as_dict(fis: Sugeno) -> dict[str, Any]:
    """Describe the system as dictionaries, lists, strings and floats. Terms have MATLAB's types and parameters."""
    return {
        "name": fis.name,
        "type": "sugeno",
        "and_method": fis.and_method,
        "or_method": fis.or_method,
        "defuzzification": fis.defuzzification,
        "no_rule_fires": fis.no_rule_fires,
        "out_of_range": fis.out_of_range,
        "inputs": [_variable(v) for v in fis.inputs],
        "outputs": [_variable(v) for v in fis.outputs],
        "rules": [_rule(number, rule) for number, rule in enumerate(fis.rules, 1)],
    }


def _term(fis: Sugeno, variable: Variable, term: Any) -> str:
    low, high = variable.universe
    span = high - low
    if isinstance(term, MembershipFunction):
        return f"{term.matlab} [{' '.join(shown(float(p), span, _DIGITS) for p in term.parameters)}]"
    if isinstance(term, Constant):
        return shown(float(term.value), span, _DIGITS)
    # Only the inputs that count: "2 distance - 0.5 bearing + 1".
    parts = [(float(slope), f" {v.name}") for slope, v in zip(term.parameters[:-1], fis.inputs, strict=True) if slope]
    constant = float(term.constant)
    if constant or not parts:
        parts.append((constant, ""))
    first, *others = parts
    text = f"{shown(first[0], 0, _DIGITS)}{first[1]}"
    return text + "".join(
        f" {'-' if value < 0 else '+'} {shown(abs(value), 0, _DIGITS)}{name}" for value, name in others
    )


def _variable(variable: Variable) -> dict[str, Any]:
    return {
        "name": variable.name,
        "unit": variable.unit,
        "range": list(variable.universe),
        "terms": [
            {"name": name, "type": term.matlab, "parameters": [float(p) for p in term.parameters]}
            for name, term in variable.terms.items()
        ],
    }


def _rule(number: int, rule: Any) -> dict[str, Any]:
    return {
        "number": number,
        "rule": str(rule),
        "connective": rule.connective,
        "weight": rule.weight,
        "when": [{"input": c.variable, "term": c.term, "not": c.negated, "power": c.power} for c in rule.when],
        "then": dict(rule.then),
    }
