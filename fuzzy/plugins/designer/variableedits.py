"""Edits of variables: each takes the design and a message, and gives the new design and the edit's name."""

from collections.abc import Callable
from dataclasses import replace

from fuzzy.membership import Triangle
from fuzzy.membershipfunction import MembershipFunction
from fuzzy.plugins.designer.design import Design, with_variables
from fuzzy.plugins.designer.message import EditError, Message
from fuzzy.plugins.designer.places import (
    consequent,
    found,
    given_name,
    new_name,
    put,
    renamed,
    room,
    variables_of,
    with_terms,
    without,
)
from fuzzy.system import Constant, Linear, Terms, Variable

_MOST_VARIABLES = 50  # the largest number of inputs, and of outputs


def add_variable(design: Design, message: Message) -> tuple[Design, str]:
    """add_variable {kind, name?}: with three terms on [0 1], in no rule yet; linear consequents get a slope 0."""
    kind = message.one_of("kind", ("input", "output"), "kind")
    taken = [v.name for k in ("input", "output") for v in variables_of(design, k)]
    present = variables_of(design, kind)
    room(len(present), _MOST_VARIABLES, f"{kind}s")
    name = given_name(message, kind, taken, "variable", len(present))
    variable = new_variable(kind, name)
    inputs, outputs = design.system.inputs, design.system.outputs
    if kind == "output":
        return with_variables(design, inputs, (*outputs, variable)), f"add {name}"
    longer = [_with_slopes(output, lambda slopes: (*slopes, 0.0)) for output in outputs]
    return with_variables(design, (*inputs, variable), longer), f"add {name}"


def new_variable(kind: str, name: str) -> Variable:
    """An input or output on [0 1] with the terms low, medium and high."""
    if kind == "output":
        return Variable(name, (0.0, 1.0), {"low": 0.0, "medium": 0.5, "high": 1.0})
    terms = {"low": Triangle(-0.5, 0.0, 0.5), "medium": Triangle(0.0, 0.5, 1.0), "high": Triangle(0.5, 1.0, 1.5)}
    return Variable(name, (0.0, 1.0), terms)


def _with_slopes(output: Variable, change: Callable[[tuple[float, ...]], tuple[float, ...]]) -> Variable:
    changed = {
        name: Linear(change(tuple(term.slopes)), term.constant) if isinstance(term, Linear) else term
        for name, term in output.terms.items()
    }
    return replace(output, terms=changed)


def remove_variable(design: Design, message: Message) -> tuple[Design, str]:
    """remove_variable {variable}: from the rules too; the slopes for an input go with it."""
    place = found(design, message)
    left = [v for i, v in enumerate(variables_of(design, place.kind)) if i != place.at]
    if not left:
        raise EditError(f"{place.variable.name} cannot be removed: a system needs at least one {place.kind}")
    rules, told = without(design, place, lambda term: True)
    name = f"remove {place.variable.name}{told}"
    if place.kind == "output":
        return with_variables(design, design.system.inputs, left, rules), name
    i = place.at
    shorter = [_with_slopes(output, lambda slopes: slopes[:i] + slopes[i + 1 :]) for output in design.system.outputs]
    return with_variables(design, left, shorter, rules), name


def rename_variable(design: Design, message: Message) -> tuple[Design, str]:
    """rename_variable {variable, name}: in the rules too."""
    place = found(design, message)
    new = message.label("name")
    taken = [
        v.name
        for kind in ("input", "output")
        for i, v in enumerate(variables_of(design, kind))
        if (kind, i) != (place.kind, place.at)
    ]
    new_name(new, taken, "variable")
    rules = renamed(design, place, new, {})
    changed = replace(place.variable, name=new)
    return put(design, place, changed, rules), f"rename {place.variable.name} to {new}"


def change_unit(design: Design, message: Message) -> tuple[Design, str]:
    """unit {variable, unit}: a label; no number changes."""
    place = found(design, message)
    unit = message.label("unit", empty=True)
    return put(design, place, replace(place.variable, unit=unit)), f"unit of {place.variable.name}"


def change_universe(design: Design, message: Message) -> tuple[Design, str]:
    """universe {variable, low, high, scale?}: the terms stay where they are, or are stretched with the universe.

    With ``scale`` the system does the same as before at the places that correspond: an input's functions are mapped
    and linear consequents compensate; an output's consequents are mapped.
    """
    place = found(design, message)
    variable = place.variable
    low, high = message.number("low"), message.number("high")
    if not low < high:
        raise EditError(f"the range of {variable.name} must be ascending: {low:g} does not lie below {high:g}")
    if not message.flag("scale", False):
        return put(design, place, replace(variable, universe=(low, high))), f"universe of {variable.name}"
    old_low, old_high = variable.universe
    if old_low == old_high or not 1e-100 < (factor := (high - low) / (old_high - old_low)) < 1e100:
        raise EditError(
            f"{variable.name}: [{old_low:g} {old_high:g}] cannot be stretched to [{low:g} {high:g}]; keep the terms"
        )
    name = f"stretch {variable.name}"
    offset = low - factor * old_low
    if place.kind == "output":
        terms = [(label, _mapped_consequent(label, t, factor, offset)) for label, t in variable.terms.items()]
        return put(design, place, replace(variable, universe=(low, high), terms=Terms(terms))), name
    functions = [(label, _mapped(t, factor, offset)) for label, t in variable.terms.items()]
    inputs = list(design.system.inputs)
    inputs[place.at] = replace(variable, universe=(low, high), terms=Terms(functions))
    outputs = [
        with_terms(
            output, [(label, _compensated(label, t, place.at, factor, offset)) for label, t in output.terms.items()]
        )
        for output in design.system.outputs
    ]
    point = list(design.point)
    point[place.at] = factor * point[place.at] + offset
    return replace(with_variables(design, inputs, outputs), point=tuple(point)), name


def _mapped(function: MembershipFunction, factor: float, offset: float) -> MembershipFunction:
    how = {
        "location": lambda p: factor * p + offset,
        "width": lambda p: factor * p,
        "slope": lambda p: p / factor,
        "shape": lambda p: p,
    }
    return type(function)(*(how[role](p) for role, p in zip(function.roles, function.parameters, strict=True)))


def _mapped_consequent(label: str, term: Constant | Linear, factor: float, offset: float) -> Constant | Linear:
    *slopes, constant = (factor * p for p in term.parameters)
    return consequent(term.matlab, (*slopes, constant + offset), len(slopes), label)


def _compensated(label: str, term: Constant | Linear, i: int, factor: float, offset: float) -> Constant | Linear:
    """The consequent with the value that it had, for an input that became factor · input + offset."""
    if isinstance(term, Constant):
        return term
    slopes = list(term.slopes)
    slopes[i] = slopes[i] / factor
    return consequent("linear", (*slopes, term.constant - slopes[i] * offset), len(slopes), label)
