"""Edits of rules, as sentences and in a table: each takes the design and a message, gives design and edit's name.

Those that can be made of several rules at once take ``keys``, a list, in the place of ``key``.
"""

from collections.abc import Callable
from dataclasses import replace
from itertools import product
from math import prod

import numpy as np

from fuzzy.plugins.designer.design import POWERS, Design, RuleLine, holds_power, read, sentence, with_lines
from fuzzy.plugins.designer.message import EditError, Message
from fuzzy.rule import Clause, Rule
from fuzzy.system import Sugeno
from fuzzy.words import counted

Antecedent = frozenset[tuple[str, str]]  # the inputs with the terms that a rule asks for
MOST_RULES = 1000  # more rules are for data, not for a table to look at


def _line(design: Design, message: Message) -> tuple[int, RuleLine]:
    """Place and line that the message's key names."""
    place = design.place(message.whole("key"))
    return place, design.lines[place]


def _places(design: Design, message: Message) -> list[int]:
    """The places of the lines that the message names by ``key`` or ``keys``, ascending."""
    if not message.has("keys"):
        return [design.place(message.whole("key"))]
    keys = message.wholes("keys")
    if not keys:
        raise EditError("no rule is selected")
    known = {line.key: place for place, line in enumerate(design.lines)}
    # design.place says what is wrong with a key that is not there.
    return sorted({known[key] if key in known else design.place(key) for key in keys})


def _named(places: list[int]) -> str:
    return f"rule {places[0] + 1}" if len(places) == 1 else f"{len(places)} rules"


def _each(design: Design, places: list[int], change: Callable[[int, RuleLine], RuleLine]) -> Design:
    """The design with the lines at some places changed."""
    lines = list(design.lines)
    for place in places:
        lines[place] = change(place, lines[place])
    return with_lines(design, lines)


def _put(design: Design, place: int, line: RuleLine) -> Design:
    return with_lines(design, (*design.lines[:place], line, *design.lines[place + 1 :]))


def of_rule(line: RuleLine, rule: Rule) -> RuleLine:
    """The line with a rule from the table: its sentence follows, and a misspelt one is given up."""
    _check_read(line)
    return replace(line, rule=rule, text=str(rule), problem=None)


def _check_read(line: RuleLine) -> None:
    """Raise EditError for a line of the file that is no rule, of which there is nothing to change but its text."""
    if line.source is not None:
        raise EditError(f"{line.text!r} is no rule yet: mend its sentence, or remove it")


def _room(design: Design, more: int) -> None:
    if len(design.lines) + more > MOST_RULES:
        raise EditError(
            f"{len(design.lines)} rules and {more} more exceed the limit of {MOST_RULES} rules; "
            "use fewer terms, or learn the rules from data"
        )


def rule_text(design: Design, message: Message) -> tuple[Design, str]:
    """rule_text {key, text}: a sentence that is no rule stays with its problem; the last good rule counts."""
    place, line = _line(design, message)
    changed = read(design.system, line, message.text("text"))
    return _put(design, place, changed), f"sentence of rule {place + 1}"


def add_rule(design: Design, message: Message) -> tuple[Design, str]:
    """add_rule {after, text?}: below the line with the key ``after``, or at the end.

    Without a sentence it is the first combination of terms that no rule has yet.
    """
    _room(design, 1)
    place = design.place(message.whole("after")) + 1 if message.has("after") else len(design.lines)
    rule = sentence(design.system, message.text("text")) if message.has("text") else _next_rule(design)
    line = RuleLine(design.next_key, rule, str(rule))
    return with_lines(design, (*design.lines[:place], line, *design.lines[place:])), "add a rule"


def copy_rule(design: Design, message: Message) -> tuple[Design, str]:
    """copy_rule {key}: the copy stands below."""
    _room(design, 1)
    place, line = _line(design, message)
    copied = replace(line, key=design.next_key)
    lines = (*design.lines[: place + 1], copied, *design.lines[place + 1 :])
    return with_lines(design, lines), f"copy rule {place + 1}"


def remove_rule(design: Design, message: Message) -> tuple[Design, str]:
    """remove_rule {key | keys}."""
    places = _places(design, message)
    gone = set(places)
    left = [line for place, line in enumerate(design.lines) if place not in gone]
    return with_lines(design, left), f"remove {_named(places)}"


def move_rule(design: Design, message: Message) -> tuple[Design, str]:
    """move_rule {key | keys, to}: to the place ``to``, from 0; several stand together there, in their order."""
    places = _places(design, message)
    to, last = message.whole("to"), len(design.lines) - len(places)
    if not 0 <= to <= last:
        what = "a rule" if len(places) == 1 else f"{len(places)} rules"
        raise EditError(f"{what} can be moved to the places 0 to {last}, got {to}")
    moved = [design.lines[place] for place in places]
    gone = set(places)
    lines = [line for place, line in enumerate(design.lines) if place not in gone]
    return with_lines(design, [*lines[:to], *moved, *lines[to:]]), f"move {_named(places)} to {to + 1}"


def rule_weight(design: Design, message: Message) -> tuple[Design, str]:
    """rule_weight {key | keys, weight}, in [0, 1]."""
    places = _places(design, message)
    weight = message.number("weight")
    if not 0 <= weight <= 1:
        raise EditError(f"{_named(places)}: the weight must lie in [0, 1], got {weight:g}")
    changed = _each(design, places, lambda _, line: of_rule(line, replace(line.rule, weight=weight)))
    return changed, f"weight of {_named(places)}"


def rule_enabled(design: Design, message: Message) -> tuple[Design, str]:
    """rule_enabled {key | keys, enabled}: a rule that is off does nothing and stays in the table."""
    places = _places(design, message)
    enabled = message.flag("enabled")
    for place in places:
        _check_read(design.lines[place])
    changed = _each(design, places, lambda _, line: replace(line, enabled=enabled))
    return changed, f"{_named(places)} {'on' if enabled else 'off'}"


def rule_clause(design: Design, message: Message) -> tuple[Design, str]:
    """rule_clause {key, variable, term | null, negated?, power?}: null leaves the input out."""
    place, line = _line(design, message)
    inputs = {v.name: v for v in design.system.inputs}
    name = message.one_of("variable", tuple(inputs), "input")
    when = {clause.variable: clause for clause in line.rule.when}
    if message.has("term"):
        term = message.one_of("term", tuple(inputs[name].terms), f"term of {name!r}")
        power = message.number("power") if message.has("power") else 1.0
        if not holds_power(power):
            raise EditError(f"rule {place + 1}: {POWERS}, got {power:g}")
        new = name not in when
        when[name] = Clause(name, term, message.flag("negated", False), power)
        if new:  # where the inputs' order puts it
            when = {n: when[n] for n in inputs if n in when}
    else:
        when.pop(name, None)
        if not when:
            raise EditError(f"rule {place + 1} needs at least one clause: {name} is its only one")
    changed = of_rule(line, replace(line.rule, when=tuple(when.values())))
    return _put(design, place, changed), f"{name} in rule {place + 1}"


def rule_then(design: Design, message: Message) -> tuple[Design, str]:
    """rule_then {key | keys, variable, term | null}: null leaves the output out."""
    places = _places(design, message)
    outputs = {v.name: v for v in design.system.outputs}
    name = message.one_of("variable", tuple(outputs), "output")
    term = message.one_of("term", tuple(outputs[name].terms), f"term of {name!r}") if message.has("term") else None

    def change(place: int, line: RuleLine) -> RuleLine:
        then = proposing(design.system, line.rule, name, term)
        if not then:
            raise EditError(f"rule {place + 1} needs at least one consequent: {name} is its only one")
        return of_rule(line, replace(line.rule, then=then))

    return _each(design, places, change), f"{name} in {_named(places)}"


def proposing(system: Sugeno, rule: Rule, output: str, term: str | None) -> tuple[tuple[str, str], ...]:
    """The rule's consequents with ``term`` for an output (None: without it); a new one in the outputs' order."""
    then = dict(rule.then)
    if term is None:
        then.pop(output, None)
    elif output in then:
        then[output] = term
    else:
        then = {v.name: term if v.name == output else then[v.name] for v in system.outputs if v.name in {output, *then}}
    return tuple(then.items())


def rule_connective(design: Design, message: Message) -> tuple[Design, str]:
    """rule_connective {key, connective}: "and" or "or"."""
    place, line = _line(design, message)
    connective = message.one_of("connective", ("and", "or"), "connective")
    rule = replace(line.rule, connective="or" if connective == "or" else "and")
    return _put(design, place, of_rule(line, rule)), f"{connective} in rule {place + 1}"


def add_all_rules(design: Design, message: Message) -> tuple[Design, str]:
    """add_all_rules {}: a rule for each combination of the inputs' terms that has none, on or off.

    Its consequents are those of the nearest rule that asks for plain terms with "and" (the fewest steps in the terms'
    order, the first of equals), and the first term of each output that this leaves out.
    """
    system = design.system
    names, terms = _axes(system)
    count = prod(len(t) for t in terms)
    if count - len(design.lines) > MOST_RULES:
        raise EditError(f"there are {count} combinations of terms, more than the limit of {MOST_RULES} rules")
    present = _present(design)
    missing = [c for c in product(*terms) if frozenset(zip(names, c, strict=True)) not in present]
    if not missing:
        raise EditError("there is a rule for every combination of terms already")
    _room(design, len(missing))
    consequents = _nearest(design, names, terms, missing)
    lines = list(design.lines)
    for key, (combination, then) in enumerate(zip(missing, consequents, strict=True), start=design.next_key):
        rule = Rule(tuple(map(Clause, names, combination)), then)
        lines.append(RuleLine(key, rule, str(rule)))
    return with_lines(design, lines), f"add {counted(len(missing), 'rule')}"


def _axes(system: Sugeno) -> tuple[list[str], list[list[str]]]:
    """The inputs that have terms, and these; EditError where there is nothing to make rules of."""
    named = [v for v in system.inputs if v.terms]
    if not named:
        raise EditError("no input has a term, so there is nothing that a rule could ask for")
    if not any(v.terms for v in system.outputs):
        raise EditError("no output has a term, so there is nothing that a rule could propose")
    return [v.name for v in named], [list(v.terms) for v in named]


def antecedent(rule: Rule) -> Antecedent:
    """The inputs with the terms that a rule without "not", hedges and "or" asks for."""
    return frozenset((clause.variable, clause.term) for clause in rule.when)


def _present(design: Design) -> set[Antecedent]:
    """The combinations of terms that have a rule, on or off."""
    return {antecedent(line.rule) for line in design.lines if is_plain(line.rule)}


def is_plain(rule: Rule) -> bool:
    """Does the rule ask for terms as they are, joined by "and"?"""
    joined = rule.connective == "and" or len(rule.when) == 1
    return joined and not any(clause.negated or clause.power != 1 for clause in rule.when)


def _nearest(
    design: Design, names: list[str], terms: list[list[str]], wanted: list[tuple[str, ...]]
) -> list[tuple[tuple[str, str], ...]]:
    """The consequents for each combination of terms that is wanted."""
    first = {v.name: next(iter(v.terms)) for v in design.system.outputs if v.terms}
    rules = [line.rule for line in design.lines if is_plain(line.rule)]
    if not rules:
        return [tuple(first.items())] * len(wanted)
    steps = [{term: place for place, term in enumerate(t)} for t in terms]
    places = np.full((len(rules), len(names)), -1)
    for r, rule in enumerate(rules):
        for variable, term in antecedent(rule):
            i = names.index(variable)
            places[r, i] = steps[i][term]
    chosen = []
    for combination in wanted:
        at = np.array([steps[i][term] for i, term in enumerate(combination)])
        distance = np.where(places >= 0, np.abs(places - at), 0).sum(axis=1)
        then = first | dict(rules[int(np.argmin(distance))].then)
        chosen.append(tuple(then.items()))
    return chosen


def _next_rule(design: Design) -> Rule:
    """The first combination of terms that no rule has yet, or the very first."""
    names, terms = _axes(design.system)
    present = _present(design)
    # More combinations than there are rules cannot all be taken: the search ends soon.
    for combination in product(*terms):
        if frozenset(zip(names, combination, strict=True)) not in present:
            break
    else:
        combination = tuple(t[0] for t in terms)
    (then,) = _nearest(design, names, terms, [combination])
    return Rule(tuple(map(Clause, names, combination)), then)
