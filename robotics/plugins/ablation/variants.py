"""A law without parts of it: rule bases emptied, their consequents shuffled, rules left out, no emergency rule."""

from collections.abc import Collection, Iterator
from dataclasses import replace
from typing import Any, NamedTuple

import numpy as np

from fuzzy.errors import InputError
from fuzzy.naming import check_known
from fuzzy.system import Sugeno
from robotics.laws.catalogue import gains_of, with_gains
from robotics.laws.law import Law

WHOLE = "whole"
_EMPTY = " without rules"
_GUARD = "guard.on"  # the gain of an emergency rule below the rule bases


class AblationError(InputError):
    """A law, or a choice, of which nothing can be taken away."""


class Variant(NamedTuple):
    """A law without something."""

    name: str
    base: str  # the task of the rule base that is another; "": none is
    rule: int  # the number of the rule that is left out, from 1; 0: none
    law: Law[Any]


def variants(law: Law[Any], each_rule: Collection[str] = (), shuffles: int = 2, seed: int = 0) -> list[Variant]:
    """The law as it is, and without what can be taken away.

    Args:
        law: A law with rule bases.
        each_rule: The tasks of the rule bases of which every rule is left out, too, one at a time.
        shuffles: How often each rule base's consequents are dealt out anew.
        seed: Of these.

    Raises:
        AblationError: A law without rule bases, or a task that it does not have.
    """
    bases = law.fuzzy_systems
    if not bases:
        raise AblationError(f"{type(law).__name__} has no rule base")
    for task in each_rule:
        check_known(task, list(bases), "rule base of the law", AblationError)
    found = [Variant(WHOLE, "", 0, law)]
    for task, fis in bases.items():
        found += [
            Variant(name, task, rule, law.with_fuzzy_system(task, other))
            for name, rule, other in _without(task, fis, task in each_rule, shuffles, seed)
        ]
    if gains_of(law).get(_GUARD):
        # What the rules do shows where nothing catches what they leave
        alone = [v for v in found if v.name == WHOLE or v.name.endswith(_EMPTY)]
        found += [
            v._replace(
                name=f"{v.name}, no emergency rule".removeprefix(f"{WHOLE}, "), law=with_gains(v.law, {_GUARD: 0.0})
            )
            for v in alone
        ]
    return found


def _without(task: str, fis: Sugeno, each: bool, shuffles: int, seed: int) -> Iterator[tuple[str, int, Sugeno]]:
    """The name, the number of a rule that is left out or 0, and the rule base."""
    yield f"{task}{_EMPTY}", 0, replace(fis, rules=())
    generator = np.random.default_rng(seed)
    for k in range(shuffles if len(fis.rules) > 1 else 0):
        dealt = [fis.rules[i].then for i in generator.permutation(len(fis.rules))]
        rules = [replace(rule, then=then) for rule, then in zip(fis.rules, dealt, strict=True)]
        yield f"{task} shuffled, {k + 1}", 0, replace(fis, rules=rules)
    for k in range(len(fis.rules) if each else 0):
        yield f"{task} without rule {k + 1}", k + 1, fis.without_rule(k)
