"""Inputs of rule bases that left the ranges for which these were made.

A learnt system knows nothing beyond its data, which its universes hold; there it is evaluated at the nearer end. A
designed rule base is meant to be left: its outermost terms hold on beyond the universe, as shoulders do ("far is far"),
or it covers all there is, such as angles from -π to π. Which of the two it is can be seen from the terms: an input is
one of data where all its terms are bells, which are positive everywhere and fade away beyond both ends, as clusters and
learning make them.
"""

from collections.abc import Sequence
from typing import Any, NamedTuple

import numpy as np

from fuzzy.shown import shown
from fuzzy.system import Variable
from robotics.laws.rules.situation import NOTHING_NEAR
from robotics.simulation.run import Run

_TOLERANCE = 0.01  # of the universe: what lies beyond its end by less is noise
SELDOM = 0.002  # of the time: a universe that leaves out the rarest of the data is left as seldom
_FAR = 10.0  # times the universe: so far beyond its end it is looked whether a term holds on


class OutsideInput(NamedTuple):
    """One input of one robot that left its universe, over all seeds of a run."""

    controller: str
    scenario: str
    task: str  # of the rule base
    input: str
    unit: str
    robot: int  # from 1
    universe: tuple[float, float]
    farthest: float  # the value farthest outside
    share: float  # of the robot's samples

    def row(self) -> dict[str, Any]:
        """It as JSON's types."""
        return {**self._asdict(), "universe": list(self.universe)}


def outside(run: Run) -> list[OutsideInput]:
    """The inputs of data that left their universes by more than _TOLERANCE, the farthest first."""
    if run.inputs is None or not run.about.rule_bases:
        return []
    found, row = [], 0
    for task, system in run.about.rule_bases.items():
        for variable in system.inputs:
            values = run.inputs[:, row]  # (samples, runs, robots)
            row += 1
            for robot in range(values.shape[-1] if is_of_data(variable) else 0):
                one = _left(values[..., robot], variable.universe)
                if one is not None:
                    names = (run.controller, run.scenario, task, variable.name, variable.unit, robot + 1)
                    found.append(OutsideInput(*names, variable.universe, *one))
    return sorted(found, key=_how_far, reverse=True)


def merged(found: Sequence[Sequence[OutsideInput]], runs: Sequence[int]) -> tuple[OutsideInput, ...]:
    """What :func:`outside` found of several parts of the ``runs`` of one controller and scenario, as of one run.

    An input that left its universe too seldom in a part counts there as if it had not.
    """
    if len(found) == 1:
        return tuple(found[0])
    by_input: dict[Any, list[tuple[OutsideInput, int]]] = {}
    for part, count in zip(found, runs, strict=True):
        for one in part:
            by_input.setdefault((one.task, one.input, one.robot), []).append((one, count))
    whole = (
        max((one for one, _ in ones), key=_how_far)._replace(share=sum(one.share * n for one, n in ones) / sum(runs))
        for ones in by_input.values()
    )
    return tuple(sorted(whole, key=_how_far, reverse=True))


def is_of_data(variable: Variable) -> bool:
    """Whether an input's universe is where something is known, and not one that is meant to be left."""
    low, high = variable.universe
    if high <= low or not variable.terms:
        return False
    if any(type(term).log_formula is None for term in variable.terms.values()):
        return False
    for end, way in ((low, -1.0), (high, 1.0)):
        places = np.array([end, end + way * _FAR * (high - low)])
        near, far = np.array([np.asarray(term(places), dtype=float) for term in variable.terms.values()]).max(axis=0)
        if far > near / 2:  # a term holds on: a shoulder
            return False
    return True


def _left(values: np.ndarray, universe: tuple[float, float]) -> tuple[float, float] | None:
    """The value farthest outside, and the share of the samples outside; None where none is."""
    low, high = universe
    # What is told where there is nothing to tell has no place of its own beyond the others
    known = values[np.isfinite(values) & ((np.abs(values) < NOTHING_NEAR) | (values <= high))]
    slack = _TOLERANCE * (high - low)
    out = known[(known < low - slack) | (known > high + slack)]
    if not len(out) or len(out) < SELDOM * len(known):
        return None
    return float(out[np.argmax(np.maximum(low - out, out - high))]), len(out) / len(known)


def _how_far(one: OutsideInput) -> float:
    low, high = one.universe
    return max(low - one.farthest, one.farthest - high) / (high - low)


def outside_sentence(found: Sequence[OutsideInput]) -> str:
    """One sentence of what :func:`outside` found of a run: the input that went farthest, and how many others did."""
    one = found[0]
    low, high = one.universe
    far, least, most = (shown(value, high - low, 3) for value in (one.farthest, low, high))
    more = len(found) - 1
    others = f"; so did {more} more input{'s' * (more > 1)}" if more else ""
    unit = f" {one.unit}" if one.unit and one.unit != "1" else ""
    share = f"{100 * one.share:.0f} %" if one.share >= 0.01 else "less than 1 %"
    return (
        f"controller {one.controller!r} on {one.scenario!r} left the data that it knows: {one.input} of robot "
        f"{one.robot} ({one.task}) came to {far}{unit}, its range is {least} to {most}{unit}; it "
        f"was outside {share} of the time{others}"
    )
