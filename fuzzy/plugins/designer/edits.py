"""Messages from a page as pure functions: :func:`apply` takes a design and a message and gives the next design.

The table :data:`EDITS` says which function serves which ``{"edit": ...}``; their docstrings say what each needs.
"""

from collections.abc import Callable, Mapping
from dataclasses import replace
from typing import Any, NamedTuple, get_args

from fuzzy.naming import expected
from fuzzy.plugins.designer import matrixedits, ruleedits, termedits, variableedits
from fuzzy.plugins.designer.design import CHOICES, TYPE_REDUCTION, Design, Footprint
from fuzzy.plugins.designer.message import EditError, Message
from fuzzy.plugins.designer.places import found, term_of, variables_of
from fuzzy.plugins.type2.reduction import Reduction
from fuzzy.plugins.type2.system import Lower

__all__ = ["EDITS", "EditError", "Edited", "apply", "edited"]
_RENAMED = 8  # renamings that a page may not have heard of yet


class Edited(NamedTuple):
    """The design that an edit leads to, and the edit's name."""

    design: Design
    name: str  # for the history, in a few words: "move near", "remove near, from 2 rules"


def apply(design: Design, message: Mapping[str, Any]) -> Design:
    """The design after a message: an edit ``{"edit": ..., ...}`` or ``{"look": "point", "point": [...]}``.

    Raises EditError or another InputError, with a sentence, for a message that is none, names what is not there, or
    asks for what makes no system; never anything else.
    """
    return edited(design, message).design


def edited(design: Design, message: Mapping[str, Any]) -> Edited:
    """The design after a message, as :func:`apply` gives it, with the edit's name."""
    if not isinstance(message, Mapping):
        raise EditError(f"a message is a mapping with 'edit' or 'look', got {type(message).__name__}")
    if "edit" not in message and message.get("look") == "point":
        return Edited(_look(design, Message(message, "point")), "look elsewhere")
    op = message.get("edit")
    if not isinstance(op, str):
        raise EditError("a message names its edit: {'edit': 'term', ...}")
    if op not in EDITS:
        raise EditError(expected(Message(message, "edit").text("edit", 100), EDITS, "edit"))
    message = _named_now(design, message)
    new, name = EDITS[op](design, Message(message, op))
    if new.footprint is not None and new.system is not design.system:
        new = replace(new, footprint=_followed(design, new, op.startswith("rename_")))
    new.shown  # noqa: B018  raises where the edit makes no type-2 system
    if op in ("rename_variable", "rename_term"):
        of = {key: message.get(key) for key in ("kind", "variable", "term")}
        to = {op.removeprefix("rename_"): Message(message, op).label("name")}
        new = replace(new, renamed=(*design.renamed, (of, to))[-_RENAMED:])
    return Edited(new, name)


def _followed(before: Design, after: Design, renamed: bool) -> Footprint:
    """The footprint of the terms that are there still, which have other names in the same places if ``renamed``."""
    assert before.footprint is not None
    assert after.footprint is not None
    olds = before.system.inputs if renamed else after.system.inputs
    lower = {}
    for old, variable in zip(olds, after.system.inputs, strict=True):
        known = before.footprint.lower.get(old.name, {})
        pairs = zip(old.terms, variable.terms, strict=True)
        lower[variable.name] = {new: known[term] for term, new in pairs if term in known}
    return replace(after.footprint, lower=lower)


def _footprint(design: Design, message: Message) -> tuple[Design, str]:
    """footprint {variable, term, lower}: scale, left and right lag of a term's lower function, in a type-2 system."""
    if design.footprint is None:
        raise EditError("this is a type-1 system; `fuzzy type2` makes a type-2 system of its file")
    place = found(design, message)
    label, numbers = term_of(message, place.variable), message.numbers("lower")
    if place.kind != "input" or len(numbers) != 3:
        raise EditError("a footprint is an input's, of three numbers: the scale, the left and the right lag")
    lower, name = design.footprint.lower, place.variable.name
    new = {**lower, name: {**lower.get(name, {}), label: Lower(numbers[0], numbers[1:])}}
    return replace(design, footprint=replace(design.footprint, lower=new)), f"set the footprint of {label}"


def _named_now(design: Design, message: Mapping[str, Any]) -> Mapping[str, Any]:
    """The message with the names of now, where it was sent before its page heard of a renaming."""
    for of, to in design.renamed:
        kind, name = message.get("kind"), message.get("variable")
        kinds = ("input", "output") if kind is None else (kind,)
        there = next((v for k in kinds for v in variables_of(design, k) if v.name == name), None)
        gone = there is None if "variable" in to else there is not None and message.get("term") not in there.terms
        if gone and all(message.get(key) == of[key] for key in of if key != "term" or "term" in to):
            message = {**message, **to}
    return message


def _look(design: Design, message: Message) -> Design:
    point = message.numbers("point")
    if len(point) != len(design.system.inputs):
        names = ", ".join(v.name for v in design.system.inputs)
        raise EditError(f"a point needs one number per input ({names}), got {len(point)}")
    return replace(design, point=point)


def _choose(design: Design, message: Message) -> tuple[Design, str]:
    """choice {name, value}: a method or what to do in doubt, see :data:`fuzzy.plugins.designer.design.CHOICES`."""
    names = CHOICES if design.footprint is None else {**CHOICES, TYPE_REDUCTION: get_args(Reduction)}
    name = message.one_of("name", names, "choice")
    if name == TYPE_REDUCTION and design.footprint is not None:
        kind: Any = message.one_of("value", names[name], name)
        return replace(design, footprint=replace(design.footprint, reduction=kind)), f"type reduction: {kind}"
    value = message.one_of("value", CHOICES[name], name)
    changes: dict[str, Any] = {name: value}
    return replace(design, system=replace(design.system, **changes)), f"{name.replace('_', ' ')}: {value}"


def _rename(design: Design, message: Message) -> tuple[Design, str]:
    """rename {name}: the system."""
    name = message.label("name")
    return replace(design, system=replace(design.system, name=name)), f"rename to {name}"


def _loop(design: Design, message: Message) -> tuple[Design, str]:
    """loop {text, what}: the control loop that goes with the system, and the edit's name; see ``Sugeno.loop``."""
    text = message.text("text")
    if not text.isprintable():
        raise EditError("a loop is kept in one line")
    return replace(design, system=replace(design.system, loop=text)), f"loop: {message.label('what')}"


EDITS: dict[str, Callable[[Design, Message], tuple[Design, str]]] = {
    "term": termedits.move_term,
    "footprint": _footprint,
    "term_type": termedits.change_type,
    "term_types": termedits.change_types,
    "spread_terms": termedits.spread_terms,
    "add_term": termedits.add_term,
    "remove_term": termedits.remove_term,
    "rename_term": termedits.rename_term,
    "add_variable": variableedits.add_variable,
    "remove_variable": variableedits.remove_variable,
    "rename_variable": variableedits.rename_variable,
    "universe": variableedits.change_universe,
    "unit": variableedits.change_unit,
    "choice": _choose,
    "rename": _rename,
    "loop": _loop,
    "rule_text": ruleedits.rule_text,
    "add_rule": ruleedits.add_rule,
    "copy_rule": ruleedits.copy_rule,
    "remove_rule": ruleedits.remove_rule,
    "move_rule": ruleedits.move_rule,
    "rule_weight": ruleedits.rule_weight,
    "rule_enabled": ruleedits.rule_enabled,
    "rule_clause": ruleedits.rule_clause,
    "rule_then": ruleedits.rule_then,
    "rule_connective": ruleedits.rule_connective,
    "add_all_rules": ruleedits.add_all_rules,
    "fill_rules": matrixedits.fill_rules,
}
