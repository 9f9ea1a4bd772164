"""A rule: which terms its antecedent joins, which consequents it proposes, and how much it weighs.

``str(rule)`` is an English sentence; :func:`fuzzy.language.parse_rule` reads it back to an equal rule.
"""

import re
from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Any, Literal

# Words with a meaning in a sentence: a name that is one of them is written in quotes.
KEYWORDS = frozenset({"if", "then", "and", "or", "is", "not", "with", "weight", "very", "somewhat", "extremely"})
HEDGES = {"somewhat": 0.5, "very": 2.0, "extremely": 3.0}  # as exponents of the degree of membership
PLAIN_NAME = re.compile(r"[^\W\d][\w-]*")


def quoted(name: str) -> str:
    """Write ``name`` as a sentence holds it: in single quotes (doubled inside) unless it is a plain word."""
    if PLAIN_NAME.fullmatch(name) and name.casefold() not in KEYWORDS:
        return name
    return "'" + name.replace("'", "''") + "'"


def hedge_words(power: float) -> str | None:
    """Find the fewest hedges whose powers multiply to ``power``; None if there are none.

    >>> hedge_words(4.0), hedge_words(0.5), hedge_words(1.0), hedge_words(1.3)
    ('very very', 'somewhat', '', None)
    """
    words: list[str] = []
    rest = power
    for word in ("extremely", "very"):
        while rest / HEDGES[word] >= 1 and (rest / HEDGES[word]).is_integer():
            rest /= HEDGES[word]
            words.append(word)
    while rest <= 0.5 and len(words) < 8:
        rest /= 0.5
        words.append("somewhat")
    # Beyond a few words the quotients may be rounded, and the sentence is better off with a number.
    return " ".join(words) if rest == 1.0 and len(words) <= 8 else None


@dataclass(frozen=True)
class Clause:
    """A clause of an antecedent, "variable is [not] [hedges] term".

    "not" acts after the hedges: not very far = 1 − far².

    Attributes:
        variable: The name of an input.
        term: The name of one of its terms.
        negated: Whether "not" stands before it.
        power: The hedge as an exponent of the degree of membership, > 0: 1/2 for somewhat, 2 for very, 3 for extremely,
            and products of these.
    """

    variable: str
    term: str
    negated: bool = False
    power: float = 1.0

    def degree(self, membership: Any) -> Any:
        """How far the clause holds: the hedges act first, then "not".

        Args:
            membership: The degree of membership in its term, or an array of degrees of any shape.

        Returns:
            The degree in [0, 1], or an array of the same shape.
        """
        hedged = membership**self.power
        return 1 - hedged if self.negated else hedged

    def __str__(self) -> str:
        hedges = hedge_words(self.power)
        term = f"{quoted(self.term)}^{float(self.power)!r}" if hedges is None else quoted(self.term)
        words = [quoted(self.variable), "is", "not" if self.negated else "", hedges or "", term]
        return " ".join(word for word in words if word)


@dataclass(frozen=True)
class Rule:
    """A rule, "if ... then ...", whose clauses are all joined by the same connective.

    Attributes:
        when: The antecedent: at least one clause, at most one per input.
        then: The consequents: (output, term), at most one per output.
        connective: Of a single clause always "and".
        weight: In [0, 1]; multiplies the firing strength.
    """

    when: tuple[Clause, ...]
    then: tuple[tuple[str, str], ...]
    connective: Literal["and", "or"] = "and"
    weight: float = 1.0

    def __post_init__(self) -> None:
        # One clause alone is joined by nothing: its sentence has no connective, and reads back as "and".
        if self.connective == "or" and len(self.when) == 1:
            object.__setattr__(self, "connective", "and")

    def __str__(self) -> str:
        when = f" {self.connective} ".join(map(str, self.when))
        then = " and ".join(f"{quoted(output)} is {quoted(term)}" for output, term in self.then)
        return f"if {when} then {then}" + (f" with {float(self.weight)!r}" if self.weight != 1.0 else "")


# What variables are called now, by their names, and those of their terms that are called otherwise.
NewNames = Mapping[str, tuple[str, Mapping[str, str]]]


def renamed_rule(rule: Rule, inputs: NewNames, outputs: NewNames) -> Rule:
    """The rule with other names of inputs, outputs and their terms."""

    def now(names: NewNames, variable: str, term: str) -> tuple[str, str]:
        name, terms = names.get(variable, (variable, {}))
        return name, terms.get(term, term)

    when = [(c, *now(inputs, c.variable, c.term)) for c in rule.when]
    then = tuple(now(outputs, *pair) for pair in rule.then)
    return replace(rule, when=tuple(replace(c, variable=name, term=term) for c, name, term in when), then=then)
