"""Edits of terms: each takes the design and a message, and gives the new design and the edit's name."""

from itertools import pairwise
from typing import Any

import numpy as np

from fuzzy.designer.conversion import converted
from fuzzy.designer.design import Design
from fuzzy.designer.message import EditError, Message
from fuzzy.designer.places import (
    CONSEQUENTS,
    consequent,
    found,
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
from fuzzy.membership import Triangle, membership_function
from fuzzy.membershipfunction import MATLAB_NAMES, MembershipFunction
from fuzzy.system import Constant, Linear, Variable

MOST_TERMS = 200  # the largest number of terms of a variable


def move_term(design: Design, message: Message) -> tuple[Design, str]:
    """term {variable, term, parameters}: vertices do not pass each other."""
    place = found(design, message)
    label = term_of(message, place.variable)
    old, parameters = place.variable.terms[label], message.numbers("parameters")
    if place.kind == "output":
        new = consequent(type(old).__name__.casefold(), parameters, len(design.system.inputs), label)
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
    """term_type {variable, term, type}: place and width stay, see :func:`fuzzy.designer.conversion.converted`.

    A linear consequent becomes the constant that it has in the middle of the inputs; a constant one gets no slopes.
    """
    place = found(design, message)
    label = term_of(message, place.variable)
    old = place.variable.terms[label]
    new: Any
    if place.kind == "input":
        kind = message.one_of("type", tuple(MATLAB_NAMES), "membership function")
        new = converted(old, kind, place.variable.universe)
    else:
        kind = message.one_of("type", CONSEQUENTS, "consequent")
        new = old
        if kind == "linear" and isinstance(old, Constant):
            new = consequent(kind, (*[0.0] * len(design.system.inputs), old.value), len(design.system.inputs), label)
        elif kind == "constant" and isinstance(old, Linear):
            middle = sum(p * v.midrange for p, v in zip(old.slopes, design.system.inputs, strict=True))
            new = consequent(kind, (float(middle + old.constant),), len(design.system.inputs), label)
    return put(design, place, with_term(place.variable, label, new)), f"make {label} a {kind}"


def add_term(design: Design, message: Message) -> tuple[Design, str]:
    """add_term {variable, type?, name?}: an input's where the others leave most room, an output's in the middle."""
    place = found(design, message)
    variable = place.variable
    room(len(variable.terms), MOST_TERMS, f"terms of {variable.name!r}")
    if message.has("name"):
        label = new_name(message.label("name"), variable.terms, f"term of {variable.name!r}")
    else:
        label = numbered("mf", len(variable.terms) + 1, variable.terms)
    new: Any
    if place.kind == "input":
        kind = message.one_of("type", tuple(MATLAB_NAMES), "membership function") if message.has("type") else "trimf"
        new = converted(_in_the_gap(variable), kind, variable.universe)
    else:
        kind = message.one_of("type", CONSEQUENTS, "consequent") if message.has("type") else "constant"
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
