"""A system with plain numbers for parameters, as pictures and explanations need it."""

from collections.abc import Mapping
from dataclasses import replace
from typing import Any

from fuzzy.membershipfunction import MembershipFunction, as_number
from fuzzy.system import AnySystem, Constant, Linear, Sugeno, Variable


def detached(fis: AnySystem) -> AnySystem:
    """Copy ``fis`` with floats in place of array scalars, so that a system in training can be drawn and explained.

    Of an interval type-2 system its upper one is copied so.
    """
    made: AnySystem = fis.mapped(_detached)  # type: ignore[attr-defined]
    return made


def _detached(fis: Sugeno) -> Sugeno:
    return replace(fis, inputs=[_variable(v) for v in fis.inputs], outputs=[_variable(v) for v in fis.outputs])


def _variable(variable: Variable) -> Variable:
    terms: Mapping[str, Any] = {name: _term(term) for name, term in variable.terms.items()}
    return replace(variable, terms=terms)


def _term(term: Any) -> Any:
    if isinstance(term, MembershipFunction):
        return type(term)(*(as_number(p) for p in term.parameters))
    numbers = [as_number(p) for p in term.parameters]
    return Constant(numbers[-1]) if isinstance(term, Constant) else Linear(numbers[:-1], numbers[-1])
