"""The interval type-2 Sugeno system: every term lies between a lower and an upper membership function.

    fis2 = to_type2(read_fis("tipper.fis"), lag=0.2, scale=0.9)
    fis2([3.0, 8.0])

The upper one is a type-1 system's own. The lower one follows from it as MATLAB's ``fismftype2`` says: it is 0 until the
upper one reaches the lag, and its greatest value is the scale. MATLAB prints no formula. Here it is the straight one,

    lower = scale · max(0, upper − lag) / (1 − lag)                                                            (1)

with which the lower function of a triangle or a trapezoid is one as well, whose feet have moved inwards.

Each rule fires with a strength between two bounds, so that the weighted average is an interval. Its ends are the least
and the greatest average that any strengths within the bounds make [Karnik & Mendel 2001], and the output is the middle
between them. "karnikmendel", "ekm", "iasc" and "eiasc" are MATLAB's names of four ways to find the same two ends [Wu
2013]; one of them is computed, whatever the name, and kept in the file. "nietan" is another reduction: the average
weighted by the mean of both bounds [Nie & Tan 2008], which MATLAB does not have.

The ends are found by iteration: rules that propose less than the average so far get their upper strength, the others
their lower one, and the average is taken anew. Each step brings it down until it is the least. That is exact, as are
Karnik and Mendel's steps, and needs no order of the rules.
"""

from collections.abc import Callable, Collection, Mapping
from dataclasses import dataclass, field, replace
from itertools import pairwise
from typing import Any, NamedTuple, get_args

import numpy as np
from array_api_compat import array_namespace

from fuzzy.compiled.tables import LEAST_STRENGTH
from fuzzy.inference import (
    check_points,
    columns_of,
    degrees_of,
    firing_strengths,
    premise_parameters,
    rule_outputs,
    settled,
    stacked,
    within_universe,
)
from fuzzy.membershipfunction import Array, MembershipError, as_float, as_number, like
from fuzzy.naming import check_known
from fuzzy.plugins.type2.reduction import Reduction
from fuzzy.plugins.type2.space import Type2Space, type2_space
from fuzzy.rule import Rule
from fuzzy.system import FuzzySystemError, Sugeno, Variable


@dataclass(frozen=True)
class Lower:
    """How the lower membership function of a term follows from the upper one, equation (1).

    Attributes:
        scale: MATLAB's ``LowerScale``, in (0, 1]: the greatest value.
        lag: MATLAB's ``LowerLag``, in [0, 1): the degree of the upper function from which on the lower one is positive;
            one number, or two for the left and the right side of the peak.

    Raises:
        MembershipError: Numbers that are out of range.
    """

    scale: Any = 1.0
    lag: Any = 0.2

    def __post_init__(self) -> None:
        pair = tuple(self.lag) if isinstance(self.lag, (tuple, list)) else (self.lag, self.lag)
        object.__setattr__(self, "lag", pair)
        if not 0 < as_number(self.scale) <= 1:
            raise MembershipError(f"the scale of a lower membership function must lie in (0, 1], got {self.scale!r}")
        if len(pair) != 2 or not all(0 <= as_number(lag) < 1 for lag in pair):
            raise MembershipError(
                f"the lag of a lower membership function must be one number or two in [0, 1), got {pair!r}"
            )


class Type2Inference(NamedTuple):
    """Every layer from the inputs to the output.

    Attributes:
        lower: (..., rules): the least firing strengths, with the rules' weights.
        upper: (..., rules): the greatest ones.
        rule_outputs: (..., rules, outputs): what the rules propose; 0 where a rule leaves an output out.
        low: (..., outputs): the lower end of the type-reduced set, in the outputs' units.
        high: (..., outputs): the upper end. With "nietan" both are the output.
        output: (..., outputs): the middle.
        fired: (..., outputs) bool: does any rule for that output fire at all?
    """

    lower: Array
    upper: Array
    rule_outputs: Array
    low: Array
    high: Array
    output: Array
    fired: Array


@dataclass(frozen=True)
class Type2Sugeno:
    """An interval type-2 Sugeno system, of order zero or one. It is called as a Sugeno system is.

    Attributes:
        upper: The type-1 system of the upper membership functions, with rules and consequents; a weighted average.
        lower: By input and by term, how the lower function follows. A term that is not named is of type 1.
        reduction: The type reduction.
        peaks: By input, where the left side of each term ends, in the unit of the input; found on construction.

    Raises:
        FuzzySystemError: Parts that do not fit together; the message names the place.
    """

    upper: Sugeno
    lower: Mapping[str, Mapping[str, Lower]] = field(default_factory=dict)
    reduction: Reduction = "karnikmendel"
    peaks: tuple[tuple[float, ...], ...] = field(init=False, repr=False, compare=False)
    _premises: Sugeno = field(init=False, repr=False, compare=False)

    def __post_init__(self) -> None:
        fis = self.upper
        check_known(self.reduction, get_args(Reduction), "type reduction", FuzzySystemError, where=fis.name)
        if fis.defuzzification != "wtaver":
            raise FuzzySystemError(
                f"{fis.name}: a type-2 system takes the weighted average, 'wtaver', got {fis.defuzzification!r}"
            )
        known = {v.name: v for v in fis.inputs}
        for name, terms in self.lower.items():
            check_known(name, known, "input", FuzzySystemError, where=fis.name)
            for term in terms:
                check_known(term, known[name].terms, f"term of {name!r}", FuzzySystemError, where=fis.name)
        exact = Lower(1.0, 0.0)
        lower = {v.name: {t: self.lower.get(v.name, {}).get(t, exact) for t in v.terms} for v in fis.inputs}
        object.__setattr__(self, "lower", lower)
        object.__setattr__(self, "peaks", tuple(tuple(self._peak(v, t) for t in v.terms) for v in fis.inputs))
        # "not" turns the bounds round: in rows of the lower terms followed by the upper ones it takes the other half.
        premises, s = replace(fis), fis.structure
        counts = np.array([[len(v.terms)] for v in fis.inputs])
        turned = replace(s, term=s.term + s.negated * counts) if s.negated.any() else s
        object.__setattr__(premises, "structure", turned)
        object.__setattr__(self, "_premises", premises)

    def _peak(self, variable: Variable, term: str) -> float:
        """Where a term is greatest. Raises FuzzySystemError where two lags would make a step there."""
        function, (left, right) = variable.terms[term], self.lower[variable.name][term].lag
        plain = type(function)(*function.numbers)
        places = [p for p, role in zip(plain.numbers, plain.roles, strict=True) if role == "location"]
        places += [(a + b) / 2 for a, b in pairwise(places)] + list(variable.universe)
        degrees = np.asarray(plain(np.array(places)))
        if as_number(left) != as_number(right) and not degrees.max() > 1 - 1e-9:
            raise FuzzySystemError(
                f"{variable.name} is {term}: {plain.matlab} does not reach the degree 1: one lag for both sides"
            )
        return places[int(np.argmax(degrees))]

    @property
    def inputs(self) -> tuple[Variable, ...]:
        """The inputs, whose terms are the upper membership functions."""
        return tuple(self.upper.inputs)

    @property
    def outputs(self) -> tuple[Variable, ...]:
        """The outputs."""
        return tuple(self.upper.outputs)

    @property
    def rules(self) -> tuple[Rule, ...]:
        """The rules, those of the upper system."""
        return tuple(self.upper.rules)

    @property
    def name(self) -> str:
        """The name of the system."""
        return self.upper.name

    def mapped(self, change: Callable[[Sugeno], Sugeno]) -> "Type2Sugeno":
        """The system with its upper one as ``change`` makes it."""
        return replace(self, upper=change(self.upper))

    def __call__(self, x: Any) -> Array:
        """Evaluate the outputs (..., outputs) at ``x`` (..., inputs), numpy or torch; see :func:`infer_type2`."""
        return infer_type2(self, x).output

    def infer(self, x: Any) -> Type2Inference:
        """Every layer at ``x`` (..., inputs), see :func:`infer_type2`."""
        return infer_type2(self, x)

    def search_space(
        self, move: Collection[str] | None = None, symmetric: bool = True, data: tuple[Array, Array] | None = None
    ) -> Type2Space:
        """What a search may move: the upper system (:class:`fuzzy.tuning.systemspace.SystemSpace`), and footprints.

        Args:
            move: The parts that may move; None: memberships, consequents and footprints.
            symmetric: Whether a symmetry is kept.
            data: Inputs (samples, inputs) and outputs (samples, outputs), which say how far consequents may move.

        Raises TuningError for an unknown part.
        """
        return type2_space(self, move, symmetric, data)

    def degrees(self, variable: str, term: str, x: Any) -> tuple[Array, Array]:
        """The lower and the upper degrees (...) of a term.

        Args:
            variable: The input, by its name.
            term: Its term, by its name.
            x: Places (...), in the unit of the input.
        """
        x = as_float(x)
        i = [v.name for v in self.inputs].index(variable)
        upper, lower = self.inputs[i].terms[term](x), self.lower[variable][term]
        peak = self.peaks[i][list(self.inputs[i].terms).index(term)]
        return lowered(x, upper, *(like(x, value) for value in (lower.scale, *lower.lag, peak))), upper


def lowered(x: Array, upper: Array, scale: Array, left: Array, right: Array, peak: Array) -> Array:
    """The lower degrees, equation (1), from the upper ones at ``x``; all broadcast."""
    xp = array_namespace(x)
    lag = xp.where(x < peak, left, right)
    above = upper - lag
    return scale * xp.where(above > 0, above, xp.zeros_like(above)) / (1 - lag)


def to_type2(
    system: Sugeno,
    lag: float | tuple[float, float] | Mapping[str, Any] = 0.2,
    scale: float | Mapping[str, Any] = 1.0,
    reduction: Reduction = "karnikmendel",
) -> Type2Sugeno:
    """Make an interval type-2 system of a type-1 one, whose membership functions become the upper ones.

    MATLAB's ``convertToType2``. A lag of 0 and a scale of 1 leave every answer as it is.

    Args:
        system: The system.
        lag: Of all lower functions, see :class:`Lower`; or by input, of all its terms, or again by term.
        scale: Likewise.
        reduction: The type reduction.

    Returns:
        The type-2 system.

    Raises:
        FuzzySystemError: Names that the system does not have.
        MembershipError: Numbers that are out of range.
    """

    def of(value: Any, variable: Variable, term: str, usual: float) -> Any:
        for name, known, what in ((variable.name, system.inputs, "input"), (term, variable.terms, "term")):
            if not isinstance(value, Mapping):
                break
            names = [getattr(each, "name", each) for each in known]
            for given in value:
                check_known(given, names, what, FuzzySystemError, where=system.name)
            value = value.get(name, usual)
        return value

    lower = {v.name: {t: Lower(of(scale, v, t, 1.0), of(lag, v, t, 0.0)) for t in v.terms} for v in system.inputs}
    return Type2Sugeno(system, lower, reduction)


def infer_type2(fis: Type2Sugeno, x: Any) -> Type2Inference:
    """Evaluate a type-2 system at a point or a batch of any shape, numpy or torch, and give every layer.

    Warns as :func:`fuzzy.infer` does. Gradients reach membership functions, lags, scales and consequents.
    Firing strengths are products, not sums of logarithms: where all are below 1e-300 no rule fires.

    Args:
        fis: The system.
        x: The points (..., inputs), in the inputs' units.

    Returns:
        Bounds of firing strengths, proposals, intervals and outputs; arrays are of the library of ``x``.

    Raises:
        FuzzySystemError: A wrong number of inputs; also in place of a warning, if the system says so.
    """
    system, x = fis.upper, as_float(x)
    check_points(fis, x)
    x = within_universe(system, x)
    xp = array_namespace(x)
    with np.errstate(over="ignore", invalid="ignore", under="ignore"):
        degrees = degrees_of(system, x, premise_parameters(system, x), False)
        lower, upper = _strengths(fis, x, degrees)
        proposed = rule_outputs(system, x)
        bounds = lower[..., None, :], upper[..., None, :]  # (..., outputs, rules) from here on
        takes_part = like(x, (system.structure.consequent >= 0).astype(float))
        bounds = bounds[0] * takes_part, bounds[1] * takes_part
        fired = xp.any(bounds[1] >= LEAST_STRENGTH, axis=-1)
        low, high = reduced(xp.moveaxis(proposed, -1, -2), *bounds, fis.reduction)
    output = settled(system, x, degrees, (low + high) / 2, fired)
    lost = ~fired | xp.isnan(output)
    low, high = (xp.where(lost, output, end) for end in (low, high))
    return Type2Inference(lower, upper, proposed, low, high, output, fired)


def _strengths(fis: Type2Sugeno, x: Array, degrees: Array) -> tuple[Array, Array]:
    """The lower and the upper firing strengths (..., rules), from the upper degrees (..., terms)."""
    xp, system, premises = array_namespace(x), fis.upper, fis._premises
    sides: list[list[Array]] = [[], []]
    for i, (first, last) in enumerate(columns_of(system)):
        upper = degrees[..., first:last]
        lower = list(fis.lower[system.inputs[i].name].values())
        rows = [[each.scale for each in lower], *([each.lag[k] for each in lower] for k in (0, 1)), fis.peaks[i]]
        below = lowered(x[..., i : i + 1], upper, *(stacked(x, row) for row in rows))
        for side, pair in zip(sides, ((below, upper), (upper, below)), strict=True):
            side.append(xp.concat(pair, axis=-1) if premises.structure is not system.structure else pair[0])
    least, most = (firing_strengths(premises, side) for side in sides)
    return least, most


def reduced(proposed: Array, lower: Array, upper: Array, reduction: str) -> tuple[Array, Array]:
    """The ends (...) of the type-reduced set, from what rules propose and their bounds (..., rules)."""
    xp = array_namespace(proposed)
    lower, upper = (xp.where(each < LEAST_STRENGTH, xp.zeros_like(each), each) for each in (lower, upper))

    def average(strength: Array, about: Array) -> Array:
        total = xp.sum(strength, axis=-1)
        off = xp.sum((proposed - about[..., None]) * strength, axis=-1)  # of which weak rules are no rounding errors
        return about + xp.where(total > 0, off / xp.where(total > 0, total, xp.ones_like(total)), xp.zeros_like(total))

    middle = average((lower + upper) / 2, xp.zeros_like(proposed[..., 0]))
    if reduction == "nietan":
        return middle, middle
    ends = []
    for sign in (1, -1):
        end, better = middle, True
        while better:
            near = sign * (proposed - end[..., None]) < 0
            new = average(xp.where(near, upper, lower), end)
            closer = sign * (new - end) < 0
            end = xp.where(closer, new, end)
            better = bool(xp.any(closer))
        ends.append(end)
    return ends[0], ends[1]
