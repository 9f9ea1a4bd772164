"""The mirror symmetry of a system: what it answers to the left, it answers to the right with the other sign.

A rule base for steering has such a symmetry; a search that keeps it has half as many parameters, and a result that
does not steer differently to both sides because of the noise of a few runs.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from itertools import product
from typing import Any

import numpy as np

from fuzzy.rule import Rule
from fuzzy.system import Sugeno, Variable

_POINTS = 201  # at which memberships are compared
_NEAR = 1e-9


@dataclass(frozen=True)
class Mirror:
    """What changes its sign, and what becomes of each term and each rule."""

    inputs: tuple[int, ...]  # 1, or −1 for an input that changes its sign
    outputs: tuple[int, ...]  # likewise
    terms: tuple[tuple[int, ...], ...]  # an input: the place of each term's mirror image
    rules: tuple[int, ...]  # the place of each rule's mirror image


def mirror_of(fis: Sugeno) -> Mirror | None:
    """Find the symmetry of a system, of several the one in which most inputs change their sign; None: there is none."""
    images = [_mirrored_terms(variable) for variable in fis.inputs]
    able = [k for k, image in enumerate(images) if image is not None]
    for signs in sorted(product((1, -1), repeat=len(able)), key=sum):
        if all(sign > 0 for sign in signs):
            continue
        inputs = [1] * len(fis.inputs)
        for k, sign in zip(able, signs, strict=True):
            inputs[k] = sign
        terms = [images[k] if sign < 0 else tuple(range(len(fis.inputs[k].terms))) for k, sign in enumerate(inputs)]
        found = _mirrored_rules(fis, inputs, terms)
        if found is not None:
            outputs, rules = found
            return Mirror(tuple(inputs), outputs, tuple(t for t in terms if t is not None), rules)
    return None


def _mirrored_terms(variable: Variable) -> tuple[int, ...] | None:
    """The place of each term's mirror image about 0; None where one has none."""
    low, high = variable.universe
    if not variable.terms or abs(low + high) > _NEAR * (high - low):
        return None
    x = np.linspace(-high, high, _POINTS)
    degrees = [term(x) for term in variable.terms.values()]
    found = []
    for one in degrees:
        same = [k for k, other in enumerate(degrees) if np.allclose(one[::-1], other, rtol=0, atol=_NEAR)]
        if not same:
            return None
        found.append(same[0])
    return tuple(found) if sorted(found) == list(range(len(found))) else None


def _mirrored_rules(
    fis: Sugeno, inputs: Sequence[int], terms: Sequence[Sequence[int] | None]
) -> tuple[tuple[int, ...], tuple[int, ...]] | None:
    """The signs of the outputs, and the place of each rule's mirror image; None where there are none."""
    where = {_antecedent(rule): k for k, rule in enumerate(fis.rules)}
    names = [list(variable.terms) for variable in fis.inputs]
    place = {variable.name: k for k, variable in enumerate(fis.inputs)}
    rules = []
    for rule in fis.rules:
        image = []
        for clause in rule.when:
            k = place[clause.variable]
            mapped = terms[k]
            assert mapped is not None
            image.append(replace(clause, term=names[k][mapped[names[k].index(clause.term)]]))
        found = where.get((frozenset(image), rule.connective, rule.weight))
        if found is None:
            return None
        rules.append(found)
    if len(where) < len(fis.rules):
        return None  # two rules with the same antecedent: which of them is whose image is open
    outputs = []
    for variable in fis.outputs:
        fits = [s for s in (1, -1) if all(_is_image(fis, variable, k, rules[k], s, inputs) for k in range(len(rules)))]
        if not fits:
            return None
        outputs.append(fits[0])
    return tuple(outputs), tuple(rules)


def _antecedent(rule: Rule) -> tuple[Any, ...]:
    return frozenset(rule.when), rule.connective, rule.weight


def _is_image(fis: Sugeno, output: Variable, rule: int, image: int, sign: int, inputs: Sequence[int]) -> bool:
    """Whether the consequent of the rule ``image`` is that of ``rule`` with the ``sign`` of the output."""
    one, other = (_consequent(fis, output, k) for k in (rule, image))
    if one is None or other is None:
        return one is other
    signs = np.array([*(sign * s for s in inputs), sign])
    return bool(np.allclose(signs * one, other, rtol=_NEAR, atol=0))


def _consequent(fis: Sugeno, output: Variable, rule: int) -> np.ndarray | None:
    """The slopes and the constant (inputs + 1,) of a rule's consequent."""
    term = dict(fis.rules[rule].then).get(output.name)
    return None if term is None else coefficients(output.terms[term], len(fis.inputs))


def coefficients(consequent: Any, inputs: int) -> np.ndarray:
    """The slopes and the constant (inputs + 1,) of a consequent; a constant one has slopes of 0."""
    numbers = [float(p) for p in consequent.parameters]
    return np.array([*([0.0] * (inputs + 1 - len(numbers))), *numbers])
