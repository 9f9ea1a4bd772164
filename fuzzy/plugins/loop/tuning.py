"""A loop that is tuned: scale factors, membership functions and consequents, towards a cost, over several plants.

The cost is the mean over the plant and, for robustness, plants with another gain, dead time and speed beside it, all of
them at each operating point where the plant has such, of

    ISE / ISE of the PID + overshoot / 10 % + (total variation of u) / that of the PID

each with its weight; the PID is the one by rule, or the loop as it began where no rule gives one. A loop that runs away
costs RUNAWAY_COST.
"""

import math
from collections.abc import Callable, Collection, Iterator, Mapping
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np

from fuzzy.naming import check_known
from fuzzy.plugins.loop.controller import FACTOR_OF, LoopError, Roles, Scale, factor_of, roles_of
from fuzzy.plugins.loop.plant import LoopPlant, Sampled, TransferFunction
from fuzzy.plugins.loop.response import Figures, Loop, respond
from fuzzy.plugins.loop.rival import tuned_pid
from fuzzy.plugins.loop.scheduledplant import along, operating_points
from fuzzy.plugins.loop.scheduledrules import loop_at
from fuzzy.system import Sugeno
from fuzzy.tuning.parameter import SearchParameter, TuningError
from fuzzy.tuning.search import Evaluations, search
from fuzzy.tuning.systemspace import MOVABLE, SystemSpace

SCALE_FACTORS = "factors"  # what may move beside the parts of a system
LOOP_PARTS = (SCALE_FACTORS, *MOVABLE)
DEFAULT_MOVE = (SCALE_FACTORS, "memberships", "consequents")
WEIGHTS = {"ise": 1.0, "overshoot": 1.0, "variation": 0.2}  # of the cost's terms
RUNAWAY_COST = 100.0
_OVERSHOOT = 10.0  # %: what counts as one
_REACH = 20.0  # by which a scale factor may grow or shrink


@dataclass(frozen=True, eq=False)
class TunedLoop:
    """What a search for a better loop has found.

    Attributes:
        fis: The rule base.
        scale: Its scale factors.
        evaluations: All that was evaluated; the first is what it began with.
        before: The figures of the plant itself before the search; of a scheduled one along its operating variable.
        after: And after it.
    """

    fis: Sugeno
    scale: Scale
    evaluations: Evaluations = field(repr=False)
    before: Figures
    after: Figures


@dataclass(frozen=True)
class _Amplified:
    """A plant whose input counts ``gain`` times."""

    plant: LoopPlant
    gain: float

    def sampled(self, sample_time: float) -> Sampled:
        return _AmplifiedSampled(self.plant.sampled(sample_time), self.gain)


class _SampledOnce:
    """A plant at the sample time of its loop, of which it is made once for all candidates."""

    def __init__(self, plant: LoopPlant, sample_time: float) -> None:
        self._sampled = plant.sampled(sample_time)

    def sampled(self, _: float) -> Sampled:
        return self._sampled


class _AmplifiedSampled:
    def __init__(self, sampled: Sampled, gain: float) -> None:
        self._sampled, self._gain = sampled, gain
        self.initial, self.dead_samples = sampled.initial, sampled.dead_samples

    def output(self, state: Any, held: float) -> float:
        return self._sampled.output(state, held * self._gain)

    def advance(self, state: Any, older: float, newer: float, time: float) -> Any:
        return self._sampled.advance(state, older * self._gain, newer * self._gain, time)


def plants_around(plant: LoopPlant, spread: float) -> list[LoopPlant]:
    """The plant, and what it may be besides: a gain so much larger and smaller, more dead time, and slower.

    Dead time and speed change where the plant is a transfer function. ``spread`` is a share, such as 0.25; 0: the plant
    alone.
    """
    if not spread:
        return [plant]
    found: list[LoopPlant] = [plant, _Amplified(plant, 1 + spread), _Amplified(plant, 1 / (1 + spread))]
    if isinstance(plant, TransferFunction):
        slow = 1 + spread  # s becomes s (1 + spread)
        b, a = (
            [c * slow ** (len(row) - 1 - k) for k, c in enumerate(row)] for row in (plant.numerator, plant.denominator)
        )
        found += [replace(plant, dead_time=plant.dead_time * slow), TransferFunction(b, a, plant.dead_time)]
    return found


@dataclass(frozen=True)
class _Cost:
    """The cost of a loop, from the figures of its responses."""

    cases: tuple[tuple[LoopPlant, Loop, Mapping[str, float]], ...]  # and what counts as one of each term
    roles: Roles
    weights: Mapping[str, float]

    def figures(self, fis: Sugeno, scale: Scale, cases: int | None = None) -> list[Figures]:
        return [
            respond(fis, plant, replace(loop, scale=scale), self.roles).figures for plant, loop, _ in self.cases[:cases]
        ]

    def of(self, figures: Collection[Figures]) -> float:
        return float(np.mean([self._one(*pair) for pair in zip(figures, self.cases, strict=True)]))

    def _one(self, figures: Figures, case: tuple[LoopPlant, Loop, Mapping[str, float]]) -> float:
        values = {name: getattr(figures, name) for name in self.weights}
        if figures.ise is None:
            return RUNAWAY_COST
        parts = [w * (values[name] or 0.0) / case[2][name] for name, w in self.weights.items()]
        return min(RUNAWAY_COST, math.fsum(parts))


def tune_loop(
    fis: Sugeno,
    plant: LoopPlant,
    loop: Loop | None = None,
    *,
    roles: Mapping[str, str] | None = None,
    move: Collection[str] = DEFAULT_MOVE,
    weights: Mapping[str, float] | None = None,
    spread: float = 0.25,
    evaluations: int = 300,
    seed: int = 1,
    engine: str = "cmaes",
    progress: Callable[[Evaluations], bool | None] | None = None,
) -> TunedLoop:
    """Tune a rule base and its scale factors in its loop.

    >>> import fuzzy
    >>> from fuzzy.plugins.designer.starts.control import rule_table
    >>> plant = fuzzy.TransferFunction([1], [1, 1], 0.2)
    >>> tuned = fuzzy.tune_loop(rule_table("pi", 3), plant, move=["factors"], evaluations=60)
    >>> tuned.after.ise < tuned.before.ise
    True

    Args:
        fis: The rule base.
        plant: The plant. With operating points it is tuned at each, and as its variable moves if the loop says how.
        loop: What happens to it, and the scale factors to begin with.
        roles: What variables are, by their names, where those do not say it.
        move: What may move: "factors", and the parts of a system that :class:`fuzzy.tuning.systemspace.SystemSpace`
            knows: "memberships", "consequents", "weights", "choices", "rules".
        weights: Of the cost's terms: "ise", "overshoot", "variation".
        spread: How far the plant may be another, see :func:`plants_around`.
        evaluations: The budget.
        seed: That of the search.
        engine: "cmaes" or "random".
        progress: Is called after each generation; True ends the search.

    Returns:
        The rule base and factors with the least cost, and all that was evaluated.

    Raises:
        LoopError: A rule base or settings that make no loop.
        TuningError: What cannot be tuned so.
    """
    loop = Loop() if loop is None else loop
    known = roles_of(fis, roles)
    for part in move:
        check_known(part, LOOP_PARTS, "part of a loop that can move", TuningError)
    for name in weights or {}:
        check_known(name, WEIGHTS, "term of the cost", TuningError)
    if not 0 <= spread <= 3:
        raise TuningError(f"spread must be a share from 0 to 3; got {spread:g}")
    space = SystemSpace(fis, [part for part in move if part != SCALE_FACTORS])
    factors = _factors(known, loop.scale) if SCALE_FACTORS in move else []
    terms = {**WEIGHTS, **(weights or {})}
    cost = _Cost(tuple(_cases(fis, plant, loop, known, spread)), known, terms)

    def made(row: np.ndarray) -> tuple[Sugeno, Scale]:
        scale = replace(loop.scale, **dict(zip((p.name for p in factors), map(float, row), strict=False)))
        return space.made(row[len(factors) :]), scale

    def costs(rows: np.ndarray) -> np.ndarray:
        return np.array([cost.of(cost.figures(*made(row))) for row in rows])

    found = search(
        costs, [*factors, *space.parameters], evaluations=evaluations, seed=seed, engine=engine, after=progress
    )
    best, scale = made(found.values[found.best])
    [before], [after] = cost.figures(fis, loop.scale, 1), cost.figures(best, scale, 1)
    return TunedLoop(best, scale, found, before, after)


def _cases(
    fis: Sugeno, plant: LoopPlant, loop: Loop, roles: Roles, spread: float
) -> Iterator[tuple[LoopPlant, Loop, Mapping[str, float]]]:
    """The plants and loops that the cost is of: of a scheduled plant the way of its variable first, then its points."""
    points = operating_points(plant)
    if not points or (loop.operating is not None and not loop.operating.constant):
        whole = [along(plant, loop.operating)] if points else plants_around(plant, spread)
        units = _units(fis, plant, loop, roles)
        yield from ((_SampledOnce(each, loop.period), loop, units) for each in whole)
    for value in points:
        there, at = plant.at(value), loop_at(loop, value)  # type: ignore[attr-defined]
        units = _units(fis, there, at, roles)
        yield from ((_SampledOnce(each, loop.period), at, units) for each in plants_around(there, spread))


def _factors(roles: Roles, scale: Scale) -> list[SearchParameter]:
    """The scale factors that act, as parameters of a search; they keep their sign."""
    found = []
    for role in (*roles.inputs, *roles.outputs):
        start = factor_of(scale, role)
        if start > 0 and role in FACTOR_OF:
            lower, upper = start / _REACH, start * _REACH
            found.append(SearchParameter(name=FACTOR_OF[role], start=start, lower=lower, upper=upper, scale="log"))
    return found


def _units(fis: Sugeno, plant: LoopPlant, loop: Loop, roles: Roles) -> dict[str, float]:
    """What counts as one of each term."""
    figures = Figures()
    try:
        if isinstance(plant, TransferFunction):
            figures = respond(tuned_pid(plant, loop.period), plant, loop).figures
    except LoopError:
        pass
    if figures.ise is None:
        figures = respond(fis, plant, loop, roles).figures
    step = max(abs(loop.reference), abs(loop.disturbance), 1e-300)
    return {
        "ise": figures.ise or step**2 * loop.duration / 10,
        "overshoot": _OVERSHOOT,
        "variation": figures.variation or step,
    }
