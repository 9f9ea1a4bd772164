"""The edit of a rule matrix: consequents of one output for combinations of the inputs' terms."""

from collections.abc import Mapping
from dataclasses import replace
from typing import Any

from fuzzy.plugins.designer.design import Design, RuleLine, with_lines
from fuzzy.plugins.designer.message import EditError, Message
from fuzzy.plugins.designer.ruleedits import MOST_RULES, Antecedent, antecedent, is_plain, of_rule, proposing
from fuzzy.rule import Clause, Rule
from fuzzy.system import Sugeno, Variable
from fuzzy.words import counted


def fill_rules(design: Design, message: Message) -> tuple[Design, str]:
    """fill_rules {variable, cells}: what an output is for some combinations of terms, as one edit.

    Each of ``cells`` is a pair [{input: term, ...}, consequent], of which the last counts for a combination. It is
    about the rule that asks for exactly these terms, joined by "and", without "not" and hedges. A rule that there is
    keeps its place, its weight and its other outputs; one that there is not is added at the end with the weight 1. Null
    takes the output out of the rule, and with its last output the rule. Where several rules ask for the same terms,
    the first that is on and has the output keeps it, and the others lose it.
    """
    outputs = {v.name: v for v in design.system.outputs}
    name = message.one_of("variable", tuple(outputs), "output")
    cells = _cells(design.system, message, outputs[name])
    lines: list[RuleLine | None] = list(design.lines)
    there: dict[Antecedent, list[int]] = {}
    for place, line in enumerate(design.lines):
        if is_plain(line.rule):
            there.setdefault(antecedent(line.rule), []).append(place)
    fresh: list[RuleLine] = []
    for when, term in cells.items():
        places = there.get(when, [])
        first = min(places, key=lambda place: (*_rank(design.lines[place], name), place), default=None)
        for place in places:
            lines[place] = _proposing(design.system, design.lines[place], name, term if place == first else None)
        if first is None and term is not None:
            key = design.next_key + len(fresh)
            asked = dict(when)
            clauses = [Clause(v.name, asked[v.name]) for v in design.system.inputs if v.name in asked]
            rule = Rule(tuple(clauses), ((name, term),))
            fresh.append(RuleLine(key, rule, str(rule)))
    left = [line for line in lines if line is not None]
    if fresh and len(left) + len(fresh) > MOST_RULES:
        raise EditError(f"{len(left)} rules and {len(fresh)} more exceed the limit of {MOST_RULES} rules")
    verb = "clear" if all(term is None for term in cells.values()) else "fill"
    return with_lines(design, [*left, *fresh]), f"{verb} {counted(len(cells), 'cell')} of {name}"


def _rank(line: RuleLine, output: str) -> tuple[bool, bool]:
    """Which of several rules for the same terms keeps the output: one that has it, one that is on."""
    return output not in dict(line.rule.then), not line.enabled


def _proposing(system: Sugeno, line: RuleLine, output: str, term: str | None) -> RuleLine | None:
    """The line with a consequent for an output, itself where that changes nothing, None where none is left."""
    then = proposing(system, line.rule, output, term)
    if then == line.rule.then:
        return line
    return of_rule(line, replace(line.rule, then=then)) if then else None


def _cells(system: Sugeno, message: Message, output: Variable) -> dict[Antecedent, str | None]:
    inputs = {v.name: v for v in system.inputs}
    cells: dict[Antecedent, str | None] = {}
    pairs = message.items("cells", "a list of pairs [{input: term}, consequent]")
    if not pairs:
        raise EditError("no cell is chosen")
    for pair in pairs:
        if not isinstance(pair, (list, tuple)) or len(pair) != 2 or not isinstance(pair[0], Mapping):
            raise EditError("each of the 'cells' of the edit 'fill_rules' is a pair [{input: term, ...}, consequent]")
        when = _terms(pair[0], inputs, message.name)
        if not when:
            raise EditError("a rule needs at least one clause: choose a term of an input, not “any” of all")
        then = Message({"term": pair[1]}, message.name)
        accepted = tuple(output.terms)
        cells[when] = then.one_of("term", accepted, f"term of {output.name!r}") if then.has("term") else None
    return cells


def _terms(content: Mapping[Any, Any], inputs: Mapping[str, Variable], name: str) -> Antecedent:
    pairs = []
    for variable in content:
        asked = Message({"input": variable, "term": content[variable]}, name)
        found = inputs[asked.one_of("input", tuple(inputs), "input")]
        pairs.append((found.name, asked.one_of("term", tuple(found.terms), f"term of {found.name!r}")))
    return frozenset(pairs)
