"""Edits of terms: each takes the design and a message, and gives the new design and the edit's name.

Between two types of membership functions stands a trapezoid (:mod:`fuzzy.profile`): each class says which one stands
for its functions, and which of its functions is fitted to one.
"""

from itertools import pairwise
from typing import Any

import numpy as np

from fuzzy.fitting.identification import grid_terms
from fuzzy.membership import Triangle, membership_function
from fuzzy.membershipfunction import MATLAB_NAMES, MembershipFunction
from fuzzy.plugins.designer.design import Design
from fuzzy.plugins.designer.message import EditError, Message
from fuzzy.plugins.designer.places import (
    CONSEQUENTS,
    Place,
    consequent,
    found,
    given_name,
    new_name,
    numbered,
    put,
    renamed,
    room,
    term_of,
    with_term,
    with_terms,
    without,
)
from fuzzy.system import Constant, Linear, Variable

_MOST_TERMS = 200  # the largest number of terms of a variable


def move_term(design: Design, message: Message) -> tuple[Design, str]:
    """term {variable, term, parameters}: vertices do not pass each other."""
    place = found(design, message)
    label = term_of(message, place.variable)
    old, parameters = place.variable.terms[label], message.numbers("parameters")
    if place.kind == "output":
        new = consequent(old.matlab, parameters, len(design.system.inputs), label)
        return put(design, place, with_term(place.variable, label, new)), f"set {label}"
    if len(parameters) == len(old.parameters):
        _check_moved(label, old, parameters)
    moved = membership_function(old.matlab, parameters)
    return put(design, place, with_term(place.variable, label, moved)), f"move {label}"


def _check_moved(label: str, old: MembershipFunction, new: tuple[float, ...]) -> None:
    """Raise EditError, in the words beside the fields, where the parameters ``new`` of a term make no function.

    Vertices that were in order stay so; where MATLAB's file had them crossed, they may be moved as one likes.
    """
    for i, j in pairwise(old.vertices):
        if new[i] > new[j] and not old.parameters[i] > old.parameters[j]:
            one, other = old.words[i], old.words[j]
            raise EditError(f"the {one} of {label}, {new[i]:g}, must not lie right of its {other}, {new[j]:g}")
    for value, role, words in zip(new, old.roles, old.words, strict=True):
        if role == "width" and value == 0:
            raise EditError(f"the {words} of {label} must not be 0")


def change_type(design: Design, message: Message) -> tuple[Design, str]:
    """term_type {variable, term, type}: place and width stay, see :func:`fuzzy.plugins.designer.termedits.converted`.

    A linear consequent becomes the constant that it has in the middle of the inputs; a constant one gets no slopes.
    """
    place = found(design, message)
    label = term_of(message, place.variable)
    kind = _wanted_type(place, message)
    new = _as_type(design, place, label, kind)
    return put(design, place, with_term(place.variable, label, new)), f"make {label} a {kind}"


def change_types(design: Design, message: Message) -> tuple[Design, str]:
    """term_types {variable, type}: all terms of a variable; each keeps its place and width as for term_type."""
    place = found(design, message)
    kind = _wanted_type(place, message)
    terms = [(label, _as_type(design, place, label, kind)) for label in place.variable.terms]
    return put(design, place, with_terms(place.variable, terms)), f"make all of {place.variable.name} {kind}"


def _wanted_type(place: Place, message: Message) -> str:
    if place.kind == "input":
        return message.one_of("type", tuple(MATLAB_NAMES), "membership function")
    return message.one_of("type", CONSEQUENTS, "consequent")


def _as_type(design: Design, place: Place, label: str, kind: str) -> Any:
    """The term ``label`` as a function or consequent of another type."""
    old = place.variable.terms[label]
    if place.kind == "input":
        return converted(old, kind, place.variable.universe)
    inputs = design.system.inputs
    if kind == "linear" and isinstance(old, Constant):
        return consequent(kind, (*[0.0] * len(inputs), old.value), len(inputs), label)
    if kind == "constant" and isinstance(old, Linear):
        middle = sum(p * v.midrange for p, v in zip(old.slopes, inputs, strict=True))
        return consequent(kind, (float(middle + old.constant),), len(inputs), label)
    return old


def spread_terms(design: Design, message: Message) -> tuple[Design, str]:
    """spread_terms {variable, count}: ``count`` terms whose middles are spread evenly over the universe.

    Neighbours cross at 0.5. The terms that there are keep their order, names and functions; more are put between them,
    and where fewer are wanted those between are removed, with their clauses and the rules that keep nothing. An
    output's constants are spread likewise.
    """
    place = found(design, message)
    variable, count = place.variable, message.whole("count")
    if not 2 <= count <= _MOST_TERMS:
        raise EditError(f"the number of terms must be >= 2 and <= {_MOST_TERMS}, got {count}")
    low, high = variable.universe
    if not low < high:
        raise EditError(f"{variable.name} has no range over which terms could be spread")
    if place.kind == "output" and any(isinstance(term, Linear) for term in variable.terms.values()):
        raise EditError(f"{variable.name} has linear consequents; make all constant before they are spread")
    order = sorted(variable.terms, key=lambda label: _middle(variable, label))
    kept = _kept_places(len(order), count)
    labels = {kept[k]: label for k, label in enumerate(order) if k in kept}
    at = {label: k for k, label in labels.items()}
    names = [label for label in variable.terms if label in at]
    for k in range(count):
        if k not in labels:
            labels[k] = numbered("mf", len(variable.terms) + 1, [*variable.terms, *names])
            at[labels[k]] = k
            names.insert(names.index(labels[k - 1]) + 1 if k else 0, labels[k])
    made = _even_functions(variable, [labels[k] for k in range(count)], place.kind)
    changed = with_terms(variable, [(label, made[at[label]]) for label in names])
    rules, told = without(design, place, lambda term: term not in at)
    return put(design, place, changed, rules), f"spread {count} terms of {variable.name}{told}"


def _middle(variable: Variable, label: str) -> float:
    """Where a term stands: the middle of its core, or its constant."""
    term, (low, high) = variable.terms[label], variable.universe
    if isinstance(term, Constant):
        return float(term.value)
    return float(term.profile(high - low).closed(low, high).center)


def _kept_places(present: int, count: int) -> dict[int, int]:
    """The place among ``count`` of each of the ``present`` terms that stay; the first and the last stay at the ends."""
    few, many = sorted((present, count))
    if few < 2:
        return {0: (count - 1) // 2} if present else {}
    places = {k: (k * (many - 1) + (few - 1) // 2) // (few - 1) for k in range(few)}
    return places if present <= count else {old: k for k, old in places.items()}


def _even_functions(variable: Variable, labels: list[str], kind: str) -> list[Any]:
    """A term for each of ``labels`` from the lowest to the highest; new ones as most of the others are."""
    (low, high), count = variable.universe, len(labels)
    if kind == "output":
        step = (high - low) / (count - 1)
        return [Constant(low + k * step) for k in range(count - 1)] + [Constant(high)]
    types = [type(term) for term in variable.terms.values() if type(term).grid is not None]
    usual = max(types, key=types.count).matlab if types else "trimf"
    spread = grid_terms("trimf", low, high, count)
    made: list[Any] = []
    for k, label in enumerate(labels):
        old = variable.terms.get(label)
        wanted = usual if old is None else type(old).matlab
        new = MATLAB_NAMES[wanted]
        if new.grid is not None:
            made.append(grid_terms(wanted, low, high, count)[k])
            continue
        # A ramp belongs to an end of the universe.
        ramp = converted(spread[k], wanted, variable.universe)
        ends = [round(float(ramp(np.array([x]))[0])) for x in (low, high)]
        fits = (k == 0 and ends == [1, 0]) or (k == count - 1 and ends == [0, 1])
        made.append(ramp if fits else grid_terms(usual, low, high, count)[k])
    return made


def add_term(design: Design, message: Message) -> tuple[Design, str]:
    """add_term {variable, type?, name?}: an input's where the others leave most room, an output's in the middle."""
    place = found(design, message)
    variable = place.variable
    room(len(variable.terms), _MOST_TERMS, f"terms of {variable.name!r}")
    label = given_name(message, "mf", variable.terms, f"term of {variable.name!r}", len(variable.terms))
    new: Any
    if place.kind == "input":
        kind = _wanted_type(place, message) if message.has("type") else "trimf"
        new = converted(_in_the_gap(variable), kind, variable.universe)
    else:
        kind = _wanted_type(place, message) if message.has("type") else "constant"
        slopes = [0.0] * len(design.system.inputs) if kind == "linear" else []
        new = consequent(kind, (*slopes, variable.midrange), len(design.system.inputs), label)
    changed = with_terms(variable, [*variable.terms.items(), (label, new)])
    return put(design, place, changed), f"add {label} to {variable.name}"


def _in_the_gap(variable: Variable) -> Triangle:
    """A triangle in the middle of the longest stretch where the terms' degrees are lowest."""
    low, high = variable.universe
    with np.errstate(all="ignore"):  # terms and universes may be of any size
        x = np.linspace(low, high, 101)
        degrees = np.max([np.zeros_like(x), *(term(x) for term in variable.terms.values())], axis=0)
    degrees = np.round(np.nan_to_num(degrees), 2)
    lowest = degrees == np.min(degrees)
    ends = np.flatnonzero(np.diff(np.concatenate([[0], lowest.astype(int), [0]])))
    first, last = max(zip(ends[::2], ends[1::2], strict=True), key=lambda run: run[1] - run[0])
    center = float(x[(first + last - 1) // 2])
    half = (high - low) / max(2, len(variable.terms))
    return Triangle(center - half, center, center + half)


def remove_term(design: Design, message: Message) -> tuple[Design, str]:
    """remove_term {variable, term}: its clauses go, and with them the rules that keep nothing."""
    place = found(design, message)
    label = term_of(message, place.variable)
    changed = with_terms(place.variable, [pair for pair in place.variable.terms.items() if pair[0] != label])
    rules, told = without(design, place, lambda term: term == label)
    return put(design, place, changed, rules), f"remove {label}{told}"


def rename_term(design: Design, message: Message) -> tuple[Design, str]:
    """rename_term {variable, term, name}: in the rules too."""
    place = found(design, message)
    variable = place.variable
    old, new = term_of(message, variable), message.label("name")
    others = [label for label in variable.terms if label != old]
    new_name(new, others, f"term of {variable.name!r}")
    changed = with_terms(variable, [(new if name == old else name, term) for name, term in variable.terms.items()])
    return put(design, place, changed, renamed(design, place, variable.name, {old: new})), f"rename {old} to {new}"


def converted(function: MembershipFunction, kind: str, universe: tuple[float, float]) -> MembershipFunction:
    """``function`` as the function of the MATLAB name ``kind``, over ``universe`` (lowest and highest value).

    - Feet and shoulders stay where both types have them. A triangle's peak is the middle of the core. Curves keep
      the points of degree 0.5, about the middle of the core if they are symmetric.
    - A side that is open (linzmf to the left, say) is closed at the end of ``universe``, with the value 1 there.
    - A function with two sides becomes the one with one side that it has: linsmf, smf the left, linzmf, zmf the right,
      sigmf the one nearer the middle of the universe.

    Raises MembershipError for an unknown name, and for functions that state no profile.
    """
    if kind == type(function).matlab:
        return function
    if kind not in MATLAB_NAMES:
        return membership_function(kind, ())  # raises, with the names that there are
    low, high = universe
    new = MATLAB_NAMES[kind]
    parameters = new.fitted(function.profile((high - low) or 1.0).closed(low, high))
    # Computed widths and slopes need no more digits than a designer reads.
    tidy = [p if role == "location" else float(f"{p:.6g}") for p, role in zip(parameters, new.roles, strict=True)]
    return new(*tidy)
