"""Telling names for the terms of a system that was made from data: small, neg-large, and so on, by where they stand.

A term of an input is named by the middle of its core. Where the universe lies on both sides of zero, that is
counted from zero in shares of its own side, elsewhere from the low end in shares of the universe.
"""

from collections import Counter
from dataclasses import replace

from fuzzy.rule import renamed_rule
from fuzzy.system import Sugeno, Variable

_SIGNED = ((0.1, "zero"), (0.4, "small"), (0.75, "medium"), (float("inf"), "large"))
_ONE_SIDED = ((0.1, "least"), (0.35, "small"), (0.65, "medium"), (0.9, "large"), (float("inf"), "most"))


def with_telling_names(fis: Sugeno) -> Sugeno:
    """The same system with other names: its inputs' terms by where they stand, its outputs' by their rule's number.

    Where several terms of an input would have one name they are numbered from the lowest on. A consequent that no rule
    or more than one uses is called ``z`` and its own number.
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
    return replace(variable, terms={names[name]: term for name, term in variable.terms.items()})


def _numbers(output: Variable, used: list[int]) -> dict[str, str]:
    """The new name of each term of an output, by the places of the terms that the rules use."""
    return {
        name: f"rule-{used.index(t) + 1}" if used.count(t) == 1 else f"z{t + 1}" for t, name in enumerate(output.terms)
    }


def _names(variable: Variable) -> dict[str, str]:
    """The new name of each term of an input."""
    low, high = variable.universe
    middles = {name: f.profile(high - low).closed(low, high).center for name, f in variable.terms.items()}
    words = {name: _word(middle, low, high) for name, middle in middles.items()}
    often, count = Counter(words.values()), Counter[str]()
    found = {}
    for name in sorted(middles, key=middles.__getitem__):
        word = words[name]
        count[word] += 1
        found[name] = f"{word}-{count[word]}" if often[word] > 1 else word
    return found


def _word(middle: float, low: float, high: float) -> str:
    if low < 0 < high:
        share = middle / high if middle > 0 else middle / low
        word = next(word for most, word in _SIGNED if share < most)
        return word if word == "zero" else f"{'pos' if middle > 0 else 'neg'}-{word}"
    share = (middle - low) / (high - low)
    return next(word for most, word in _ONE_SIDED if share < most)
