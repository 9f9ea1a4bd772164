"""Hedged clauses as plain ones, for programs that know no hedges: "very left" becomes a term, "very_left"."""

from dataclasses import replace
from typing import Any

from fuzzy.rule import Clause, hedge_words
from fuzzy.system import FuzzySystemError, Sugeno
from fuzzy.words import listed

_LISTED = 5  # clauses that a message names


def without_hedges(fis: Sugeno) -> Sugeno:
    """Make the same system without hedges: each hedged term becomes one more term, whose function is exactly that.

    A power of a Gaussian, one- or two-sided, is one of another width, and the square of a sigmoid is a product of two.

    Args:
        fis: The system.

    Returns:
        The system, which answers the same; one without hedges as it is.

    Raises:
        FuzzySystemError: Hedges of other functions, of which no power is a membership function.
    """
    terms: dict[str, dict[str, Any]] = {v.name: dict(v.terms) for v in fis.inputs}
    inexact: dict[str, None] = {}

    def plain(clause: Clause) -> Clause:
        known = terms[clause.variable]
        function = known[clause.term].powered(clause.power) if clause.power != 1 else known[clause.term]
        if function is None:
            inexact[f"'{clause}' ({known[clause.term].matlab})"] = None
        if function is None or clause.power == 1:
            return clause
        words = hedge_words(clause.power)
        name = f"{words} {clause.term}".replace(" ", "_") if words else f"{clause.term}_{clause.power:g}"
        while known.setdefault(name, function) != function:
            name += "_2"
        return replace(clause, term=name, power=1.0)

    rules = [replace(rule, when=tuple(map(plain, rule.when))) for rule in fis.rules]
    if inexact:
        more = " and others" if len(inexact) > _LISTED else ""
        raise FuzzySystemError(
            f"{fis.name}: no membership function is exactly that of {listed([*inexact][:_LISTED])}{more}; "
            "give the variable a term for it and name that in the rule"
        )
    return replace(fis, inputs=tuple(replace(v, terms=terms[v.name]) for v in fis.inputs), rules=rules)
