"""Outputs of a Mamdani system as those of a Sugeno system: every set becomes a constant at its centroid.

This is what MATLAB's ``convertToSugeno`` does. :func:`fuzzy.files.fisfile.read_mamdani` reads the files.
"""

from collections.abc import Mapping
from typing import Any, NamedTuple

import numpy as np

from fuzzy.membershipfunction import MembershipFunction
from fuzzy.rule import Rule
from fuzzy.system import Constant, Terms, Variable

DEFUZZIFICATIONS = ("centroid", "bisector", "mom", "lom", "som")  # of a Mamdani system, as files name them
_PIECES = 200  # of a range, at least, each integrated on its own
_NODES, _WEIGHTS = np.polynomial.legendre.leggauss(8)  # exact for polynomials up to degree 15 between the cuts
_ROUNDING = 1e-12  # of the range: what integration leaves of a centroid at 0
_SPREADS = np.array([0.5, 1.0, 2.0, 3.0, 4.0, 6.0, 8.0, 16.0, 32.0])  # widths about a location that need cuts


class MamdaniParts(NamedTuple):
    """What a file says of a Mamdani system."""

    inputs: tuple[Variable, ...]
    outputs: tuple[Variable, ...]  # their terms are sets
    rules: tuple[Rule, ...]
    settings: dict[str, Any]  # name and methods, as the fields of a system are called
    complements: dict[str, dict[str, str]]  # by output: the sets that rules negate, and what the complement is called


def centroid(function: MembershipFunction, universe: tuple[float, float], negated: bool = False) -> float | None:
    """The centroid ∫ x μ dx / ∫ μ dx of a set over a universe; None where the set is empty there.

    Args:
        function: The membership function μ.
        universe: The lowest and the highest value.
        negated: Whether the set is the complement, 1 - μ.
    """
    low, high = universe
    if low == high:
        return low
    cuts = _cuts(function, low, high)
    half = np.diff(cuts) / 2
    x = cuts[:-1, None] + half[:, None] * (1 + _NODES)
    degree = np.asarray(function(x))
    # NaN-free and at most 1, whatever the parameters: an extreme one may overflow in a formula.
    degree = np.nan_to_num(1 - degree if negated else degree) * half[:, None] * _WEIGHTS
    area = float(degree.sum())
    if not area > 0:
        return None
    middle = (low + high) / 2  # moments about it cancel less
    return middle + float((degree * (x - middle)).sum()) / area


def _cuts(function: MembershipFunction, low: float, high: float) -> np.ndarray:
    """Where the pieces begin and end: evenly spread, at kinks, and close to where a narrow function stands."""
    locations, widths = [], [0.0]
    for role, number in zip(function.roles, function.numbers, strict=True):
        if role == "location":
            locations.append(number)
        elif role == "width":
            widths.append(abs(number))
        elif role == "slope" and number != 0:
            widths.append(1 / abs(number))
    places = np.array(sorted(locations))
    middles = (places[1:] + places[:-1]) / 2  # splines have a kink there
    spread = np.multiply.outer(widths, _SPREADS).ravel()
    near = np.add.outer(places, np.concatenate([spread, -spread])).ravel()
    cuts = np.concatenate([np.linspace(low, high, _PIECES + 1), places, middles, near])
    return np.unique(cuts[np.isfinite(cuts) & (cuts >= low) & (cuts <= high)])


def as_constants(variable: Variable, complements: Mapping[str, str]) -> tuple[Variable, list[str]]:
    """A Mamdani system's output as a Sugeno system's, and what was changed, a sentence a term.

    Args:
        variable: The output, whose terms are sets.
        complements: The sets that rules negate ("not slow"), and what the complement's term is called.
    """
    span = variable.universe
    terms: dict[str, Any] = {}
    changes = []
    wanted = [(label, label, False) for label in variable.terms]
    wanted += [(new, label, True) for label, new in complements.items()]
    for new, label, negated in wanted:
        function = variable.terms[label]
        place = centroid(function, span, negated)
        where = "its centroid"
        if place is None:
            place, where = variable.midrange, "the middle of the range, where it is empty"
        place = float(f"{place:.12g}") if abs(place) > _ROUNDING * (span[1] - span[0]) else 0.0
        terms[new] = Constant(place)
        numbers = " ".join(f"{number:g}" for number in function.numbers)
        kind = f"1 - {function.matlab}" if negated else function.matlab
        changes.append(f"{variable.name} is {new}: the set {kind} [{numbers}] became the constant {place:.6g}, {where}")
    return Variable(variable.name, variable.universe, Terms(terms), variable.unit), changes


def renounced(settings: Mapping[str, Any]) -> tuple[dict[str, Any], list[str]]:
    """The settings of the Sugeno system, and what of the Mamdani system's they give up, in sentences."""
    new = {"implication": "prod", "aggregation": "sum", "defuzzification": "wtaver"}
    words = {"implication": "ImpMethod", "aggregation": "AggMethod", "defuzzification": "DefuzzMethod"}
    changes = [
        f"{words[name]} {settings[name]!r} became {value!r}, as Sugeno systems have it"
        for name, value in new.items()
        if name in settings and settings[name] != value
    ]
    return {**settings, **new}, changes
