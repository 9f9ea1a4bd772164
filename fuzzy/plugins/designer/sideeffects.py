"""What an edit did to rules that it did not name, as a sentence that is said at once."""

from collections.abc import Iterator, Mapping
from typing import Any

import numpy as np

from fuzzy.insight.universe import consequent_range, universe_grid
from fuzzy.plugins.designer.design import Design
from fuzzy.system import Linear, Variable
from fuzzy.words import counted, listed

# What changes a rule as it is asked to; nothing else happens to the rules.
_OF_A_RULE = ("rule_text", "rule_clause", "rule_then", "rule_connective", "rule_weight")
_LISTED = 4  # names of terms in a sentence


def broken(before: Design, after: Design, message: Mapping[str, Any]) -> str | None:
    """What an edit did to the rules besides what it was asked for, as sentences; None where there is nothing to say.

    A removal is always told. Of other edits: consequents and terms that a new range no longer reaches, linear
    consequents that follow a stretched input, rules that a matrix lost, and sentences that can be read now.

    Args:
        before: The design before the edit.
        after: The design after it.
        message: The edit.
    """
    op = message.get("edit") if isinstance(message, Mapping) else None
    if not isinstance(op, str) or op in _OF_A_RULE or before == after:
        return None
    parts = [*_told(before, after, message, op), *_read_now(before, after)]
    return " ".join(parts) or None


def _told(before: Design, after: Design, message: Mapping[str, Any], op: str) -> Iterator[str]:
    lines = {line.key: line.rule for line in after.lines}
    gone = [place for place, line in enumerate(before.lines) if line.key not in lines]
    if op in ("remove_rule", "fill_rules"):
        if gone:
            yield f"Rule {gone[0] + 1} removed." if len(gone) == 1 else f"{len(gone)} rules removed."
    elif op in ("remove_variable", "remove_term") or (op == "spread_terms" and _fewer_terms(before, after)):
        changed = sum(line.key in lines and lines[line.key] != line.rule for line in before.lines)
        parts = [f"{_rules(n)} {what}" for n, what in ((len(gone), "removed"), (changed, "changed")) if n]
        variable = message["variable"]
        of = {"remove_variable": variable, "spread_terms": f"Terms of {variable}"}
        name = of[op] if op in of else f"{message['term']} of {variable}"
        yield f"{name} removed; {' and '.join(parts) or 'no rule changed'}."
        yield from _alike_now(before, after)
        yield from _slopes(before, after)
    elif op == "universe":
        yield from _out_of_range(before, after)
    elif op == "add_all_rules":
        yield f"{_rules(len(after.lines) - len(before.lines))} added."


def _fewer_terms(before: Design, after: Design) -> bool:
    """Whether a variable has fewer terms than it had."""
    systems = before.system, after.system
    counts = [[len(v.terms) for v in (*system.inputs, *system.outputs)] for system in systems]
    return any(old > new for old, new in zip(*counts, strict=True))


def _rules(count: int) -> str:
    return counted(count, "rule")


def _listed(names: list[str]) -> str:
    if len(names) > _LISTED:
        names = [*names[: _LISTED - 1], f"{len(names) - _LISTED + 1} more"]
    return listed(names)


def _alike(design: Design) -> tuple[set[int], set[int]]:
    """The keys of the rules in force that contradict another of the same antecedent, and of those that repeat one."""
    groups: dict[Any, list[tuple[int, dict[str, str]]]] = {}
    for line in design.lines:
        if line.enabled:
            asked = (line.rule.connective, frozenset(line.rule.when))
            groups.setdefault(asked, []).append((line.key, dict(line.rule.then)))
    contradicting, repeating = set(), set()
    for group in groups.values():
        for key, then in group:
            others = [other for k, other in group if k != key]
            if any(other.get(output, term) != term for other in others for output, term in then.items()):
                contradicting.add(key)
            elif then in others:
                repeating.add(key)
    return contradicting, repeating


def _alike_now(before: Design, after: Design) -> Iterator[str]:
    old, new = _alike(before), _alike(after)
    contradicting, repeating = (len(now - then) for now, then in zip(new, old, strict=True))
    parts = [
        f"{_rules(n)} {one if n == 1 else several}"
        for n, one, several in (
            (contradicting, "contradicts another", "contradict each other"),
            (repeating, "repeats another", "repeat each other"),
        )
        if n
    ]
    if parts:
        yield f"Now {' and '.join(parts)}."


def _slopes(before: Design, after: Design) -> Iterator[str]:
    """How many linear consequents lost a slope that was not 0 with an input that was removed."""
    kept = {v.name for v in after.system.inputs}
    gone = [i for i, v in enumerate(before.system.inputs) if v.name not in kept]
    terms = [term for output in before.system.outputs for term in output.terms.values() if isinstance(term, Linear)]
    if count := sum(any(term.slopes[i] != 0 for i in gone) for term in terms):
        yield f"{count} linear {'consequent' if count == 1 else 'consequents'} lost a slope with it."


def _out_of_range(before: Design, after: Design) -> Iterator[str]:
    """Which consequents leave a new range, which terms are 0 in all of it, and what followed a stretched input."""
    followed = 0
    for old, new in zip(before.system.outputs, after.system.outputs, strict=True):
        if old.universe == new.universe:
            followed += sum(old.terms[t] != new.terms[t] for t in new.terms)
        elif left := [t for t in new.terms if _leaves(after, new, t) and not _leaves(before, old, t)]:
            count = sum((new.name, t) in line.rule.then for line in after.lines for t in left)
            lie = "lies" if len(left) == 1 else "lie"
            yield f"{_listed(left)} of {new.name} {lie} outside its new range now, in {_rules(count)}."
    for old, new in zip(before.system.inputs, after.system.inputs, strict=True):
        if left := [t for t in new.terms if _nowhere(new, t) and not _nowhere(old, t)]:
            asked = {(new.name, t) for t in left}
            count = sum(any((c.variable, c.term) in asked for c in line.rule.when) for line in after.lines)
            be = "is" if len(left) == 1 else "are"
            yield f"{_listed(left)} of {new.name} {be} 0 in all of its new range, in {_rules(count)}."
    if followed:
        yield f"{followed} linear {'consequent' if followed == 1 else 'consequents'} changed with the range."


def _leaves(design: Design, output: Variable, term: str) -> bool:
    low, high = output.universe
    slack = 1e-9 * max(abs(low), abs(high), high - low)
    least, most = consequent_range(design.system, output.terms[term])
    return bool(least < low - slack or most > high + slack)


def _nowhere(variable: Variable, term: str) -> bool:
    with np.errstate(all="ignore"):
        return bool(np.max(variable.terms[term](universe_grid(variable, 1001))) <= 0)


def _read_now(before: Design, after: Design) -> Iterator[str]:
    """Sentences that were no rules, and with the new names are."""
    wrong = {line.key for line in before.lines if line.problem}
    places = [place for place, line in enumerate(after.lines, 1) if line.key in wrong and not line.problem]
    if len(places) == 1:
        yield f"The sentence of rule {places[0]} can be read now, and is in force."
    elif places:
        yield f"The sentences of {len(places)} rules can be read now, and are in force."
