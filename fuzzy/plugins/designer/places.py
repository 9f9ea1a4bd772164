"""Variables and terms in a design: found by a message's names, put in place, and followed into the rules."""

import math
from collections.abc import Callable, Collection, Sequence
from dataclasses import replace
from typing import Any, NamedTuple

from fuzzy.naming import expected
from fuzzy.plugins.designer.design import Design, with_variables
from fuzzy.plugins.designer.message import EditError, Message
from fuzzy.rule import Rule, renamed_rule
from fuzzy.system import Constant, Linear, Terms, Variable
from fuzzy.words import counted

CONSEQUENTS = ("constant", "linear")


class Place(NamedTuple):
    """A variable of the design."""

    kind: str  # "input" or "output"
    at: int  # among the variables of its kind
    variable: Variable


def found(design: Design, message: Message) -> Place:
    """The place of the variable that a message names; its "kind" decides where two share the name."""
    kinds = (message.one_of("kind", ("input", "output"), "kind"),) if message.has("kind") else ("input", "output")
    name = message.text("variable")
    for kind in kinds:
        for index, variable in enumerate(variables_of(design, kind)):
            if variable.name == name:
                return Place(kind, index, variable)
    raise EditError(expected(name, [v.name for kind in kinds for v in variables_of(design, kind)], " or ".join(kinds)))


def term_of(message: Message, variable: Variable) -> str:
    """The name of the term of ``variable`` that a message names."""
    return message.one_of("term", tuple(variable.terms), f"term of {variable.name!r}")


def variables_of(design: Design, kind: str) -> tuple[Variable, ...]:
    """The variables of a ``kind``, "input" or "output"."""
    return tuple(design.system.inputs if kind == "input" else design.system.outputs)


def put(design: Design, place: Place, variable: Variable, rules: Sequence[Rule | None] | None = None) -> Design:
    """A design with ``variable`` at ``place``.

    Args:
        design: The design.
        place: The place.
        variable: The variable.
        rules: The rules that take the place of the lines' rules (None: the line goes); by default they stay.
    """
    variables = list(variables_of(design, place.kind))
    variables[place.at] = variable
    if place.kind == "input":
        return with_variables(design, variables, design.system.outputs, rules)
    return with_variables(design, design.system.inputs, variables, rules)


def with_terms(variable: Variable, terms: Sequence[tuple[str, Any]]) -> Variable:
    """The variable with other terms."""
    return replace(variable, terms=Terms(terms))


def with_term(variable: Variable, label: str, term: Any) -> Variable:
    """A variable with another term in the place of one.

    Args:
        variable: The variable.
        label: The name of the term that is replaced.
        term: The new term, which keeps the name.
    """
    return with_terms(variable, [(name, term if name == label else old) for name, old in variable.terms.items()])


def consequent(kind: str, parameters: Sequence[float], inputs: int, label: str) -> Constant | Linear:
    """A consequent of the kind "constant" or "linear"; EditError where the numbers make none."""
    wanted = 1 if kind == "constant" else inputs + 1
    if len(parameters) != wanted:
        what = "one number" if wanted == 1 else f"{inputs} slopes, one per input, and a constant"
        raise EditError(f"{label}: a {kind} consequent has {what}, got {len(parameters)} numbers")
    if not all(map(math.isfinite, parameters)):
        raise EditError(f"{label}: the numbers of a consequent must be finite, got {list(parameters)}")
    return Constant(parameters[0]) if kind == "constant" else Linear(tuple(parameters[:-1]), parameters[-1])


def without(design: Design, place: Place, gone: Callable[[str], bool]) -> tuple[list[Rule | None], str]:
    """The rules without the clauses about terms that go, None where nothing is left; and a note on what went.

    Args:
        design: The design.
        place: The variable.
        gone: Says of a term's name whether the term goes.
    """
    rules: list[Rule | None] = []
    changed = removed = 0
    for line in design.lines:
        rule, name = line.rule, place.variable.name
        if line.source is not None:  # the rule is a stand-in
            rules.append(rule)
            continue
        if place.kind == "input":
            when = tuple(c for c in rule.when if not (c.variable == name and gone(c.term)))
            left = replace(rule, when=when)
        else:
            left = replace(rule, then=tuple(t for t in rule.then if not (t[0] == name and gone(t[1]))))
        whole = bool(left.when and left.then)
        removed += not whole
        changed += whole and left != rule
        rules.append(left if whole else None)
    parts = [f"from {counted(changed, 'rule')}"] if changed else []
    parts += [f"with {counted(removed, 'rule')} that had nothing else"] if removed else []
    return rules, "".join(f", {part}" for part in parts)


def renamed(design: Design, place: Place, name: str, terms: dict[str, str]) -> list[Rule | None]:
    """The rules with another name for a variable and for some of its terms.

    Args:
        design: The design.
        place: The variable.
        name: Its new name.
        terms: The new names of terms, by the old ones.
    """
    names = {place.variable.name: (name, terms)}
    of, to = (names, {}) if place.kind == "input" else ({}, names)
    return [renamed_rule(line.rule, of, to) for line in design.lines]


def new_name(name: str, taken: Collection[str], what: str) -> str:
    """A name that is not yet taken. Raises EditError for one that is.

    Args:
        name: The name.
        taken: The names that are taken.
        what: What has the name, for the message.
    """
    if name in taken:
        raise EditError(f"there is already a {what} named {name!r}")
    return name


def numbered(stem: str, number: int, taken: Collection[str]) -> str:
    """The first name of a ``stem`` with a number that is not taken.

    Args:
        stem: The beginning of the name.
        number: The first number to try.
        taken: The names that are taken.
    """
    while f"{stem}{number}" in taken:
        number += 1
    return f"{stem}{number}"


def given_name(message: Message, stem: str, taken: Collection[str], what: str, present: int) -> str:
    """The new name that a message gives, or the first free one of ``stem`` and a number after the ``present`` ones."""
    if message.has("name"):
        return new_name(message.label("name"), taken, what)
    return numbered(stem, present + 1, taken)


def room(present: int, most: int, what: str) -> None:
    """Raise EditError where there is no room for another.

    Args:
        present: The number that is there.
        most: The largest number.
        what: What is counted, in the plural, for the message.
    """
    if present >= most:
        raise EditError(f"there are {present} {what} already, the most that the designer shows")
