"""Telling names for the terms of a system that was made from data, which then stand in the order of their places.

A term of an input stands at the middle of its core. Where the universe lies on both sides of zero and that keeps terms
apart, it is named by its share of its own side (neg-large, zero, pos-small), else by its rank (low, middle, high), and
where there are too many for that by its place (about 3.2).
"""

from collections.abc import Sequence
from dataclasses import replace

from fuzzy.rule import renamed_rule
from fuzzy.shown import shown
from fuzzy.system import Sugeno, Variable

_SIGNED = ((0.1, "zero"), (0.4, "small"), (0.75, "medium"), (float("inf"), "large"))
_RANKS = ("lowest", "very-low", "low", "middle", "high", "very-high", "highest")
# Of so many terms: which ranks
_TAKEN = {1: (3,), 2: (2, 4), 3: (2, 3, 4), 4: (1, 2, 4, 5), 5: range(1, 6), 6: (0, 1, 2, 4, 5, 6), 7: range(7)}


def with_telling_names(fis: Sugeno) -> Sugeno:
    """The same system with other names: its inputs' terms by where they stand, its outputs' by their rule's number.

    The terms of each input are in the order of their places then. A consequent that no rule or more than one uses is
    called ``z`` and its own number.
    """
    # An input and an output may have the same name
    inputs = {v.name: _names(v) for v in fis.inputs}
    outputs = {v.name: _numbers(v, fis.structure.consequent[place].tolist()) for place, v in enumerate(fis.outputs)}
    asked, proposed = ({name: (name, terms) for name, terms in group.items()} for group in (inputs, outputs))
    return replace(
        fis,
        inputs=[_renamed(v, inputs[v.name]) for v in fis.inputs],
        outputs=[_renamed(v, outputs[v.name]) for v in fis.outputs],
        rules=[renamed_rule(rule, asked, proposed) for rule in fis.rules],
    )


def _renamed(variable: Variable, names: dict[str, str]) -> Variable:
    """The variable with new names for its terms, in the order of ``names``."""
    return replace(variable, terms={new: variable.terms[name] for name, new in names.items()})


def _numbers(output: Variable, used: list[int]) -> dict[str, str]:
    """The new name of each term of an output, by the places of the terms that the rules use."""
    return {
        name: f"rule-{used.index(t) + 1}" if used.count(t) == 1 else f"z{t + 1}" for t, name in enumerate(output.terms)
    }


def _names(variable: Variable) -> dict[str, str]:
    """The new name of each term of an input, in the order of their places."""
    low, high = variable.universe
    middles = {name: f.profile(high - low).closed(low, high).center for name, f in variable.terms.items()}
    ordered = sorted(middles, key=middles.__getitem__)
    return dict(zip(ordered, _words([middles[name] for name in ordered], low, high), strict=True))


def _words(middles: Sequence[float], low: float, high: float) -> Sequence[str]:
    """Names for terms that stand at ``middles``, ascending, in the unit of a universe from ``low`` to ``high``."""
    if low < 0 < high:
        words = [_word(middle, low, high) for middle in middles]
        if len(set(words)) == len(words):
            return words
    if len(middles) in _TAKEN:
        return [_RANKS[rank] for rank in _TAKEN[len(middles)]]
    for digits in (2, 3, 4, 6, 17):
        words = [f"about {shown(middle, high - low, digits)}" for middle in middles]
        if len(set(words)) == len(words):
            return words
    return [f"{word}, {k}" for k, word in enumerate(words, 1)]  # terms at one place


def _word(middle: float, low: float, high: float) -> str:
    share = middle / high if middle > 0 else middle / low
    word = next(word for most, word in _SIGNED if share < most)
    return word if word == "zero" else f"{'pos' if middle > 0 else 'neg'}-{word}"
