"""The rules that decided in a run: what its rule bases were asked, and how strongly each rule fired.

A run keeps the inputs of its law's rule bases in single precision; the firing strengths are those of
:func:`fuzzy.insight.explanation.explain` at these inputs.
"""

from typing import NamedTuple

import numpy as np

from fuzzy.errors import InputError
from fuzzy.insight.explanation import firing_strengths
from fuzzy.system import Sugeno
from robotics.simulation.run import Run
from robotics.simulation.spans import span

_POINTS = 20_000  # at which firing strengths are found at a time, about
NONE, UNKNOWN = 0, -1  # in place of a rule's number: no rule fired; an input was not a number


class DecisionError(InputError):
    """A run whose rules cannot be told, or a robot or a time that it does not have."""


class Decisions(NamedTuple):
    """What one rule base was asked in the run of one seed."""

    task: str  # of the rule base
    system: Sugeno
    inputs: np.ndarray  # (samples, robots, inputs): each in the unit of its variable; NaN after a robot was stopped

    def firing(self) -> np.ndarray:
        """The firing strengths (samples, robots, rules); not-a-number where an input is."""
        # Few robots at a time: the inference of all samples of a large team at once would be large.
        samples, robots = self.inputs.shape[:2]
        each = max(1, _POINTS // max(samples, 1))
        parts = [firing_strengths(self.system, self.inputs[:, n : n + each]) for n in range(0, robots, each)]
        return np.concatenate(parts, axis=1)


class RuleSpan(NamedTuple):
    """A span of time in which one rule of a rule base was the strongest."""

    task: str  # of the rule base
    start: float  # s
    end: float  # s
    rule: int  # its number from 1; or NONE, UNKNOWN
    least: float  # firing strength in the span
    most: float


def decisions(run: Run, place: int, samples: np.ndarray | slice = slice(None)) -> tuple[Decisions, ...]:
    """What each rule base of the law was asked in the run of the seed at ``place``, at these ``samples``.

    Raises DecisionError where the run does not say.
    """
    bases = run.about.rule_bases
    if bases is None:
        raise DecisionError(
            f"the run of {run.controller!r} on {run.scenario!r} comes from an older version, which did not keep what "
            "the rule bases were asked; run it anew"
        )
    if not bases:
        raise DecisionError(f"the controller {run.controller!r} of this run has no rule bases that could be explained")
    if run.inputs is None:
        raise DecisionError(f"the controller {run.controller!r} of this run did not say what its rule bases were asked")
    asked = np.moveaxis(run.inputs[samples, :, place], 1, -1)
    ends = np.cumsum([len(system.inputs) for system in bases.values()])[:-1]
    return tuple(Decisions(*each) for each in zip(bases, bases.values(), np.split(asked, ends, axis=-1), strict=True))


def strongest(firing: np.ndarray, most: int) -> tuple[np.ndarray, np.ndarray]:
    """The numbers (..., most) of the rules that fire most strongly, from 1, and their firing strengths (..., most).

    Of equally strong rules the first comes first. Beyond the rules that fire the number is NONE and the strength 0;
    where the strengths ``firing`` (..., rules) are not numbers it is UNKNOWN.
    """
    order = np.argsort(-firing, axis=-1, kind="stable")[..., :most]
    strength = np.take_along_axis(firing, order, axis=-1)
    unknown = np.isnan(firing).any(axis=-1, keepdims=True)
    number = np.where(unknown, UNKNOWN, np.where(strength > 0, order + 1, NONE))
    strength = np.where(strength > 0, strength, 0.0)
    missing = [(0, 0)] * (firing.ndim - 1) + [(0, most - number.shape[-1])]
    return np.pad(number, missing), np.pad(strength, missing)


def shares(firing: np.ndarray) -> np.ndarray:
    """Each rule's share (..., rules) in the output, by the firing strengths (..., rules): strength over sum of all.

    All are 0 where no rule fires, and not-a-number where a strength is.
    """
    whole = firing.sum(axis=-1, keepdims=True)
    return firing / np.where(whole > 0, whole, 1.0)


def rule_spans(
    run: Run, place: int, robot: int, start: float | None = None, end: float | None = None
) -> list[RuleSpan]:
    """The spans in which one rule of each rule base was the strongest, by rule base and time.

    Args:
        run: The run.
        place: The place of the seed in the run.
        robot: The robot, from 0.
        start: The time [s] from which on, by default the run's first.
        end: The time [s] up to which, by default the run's last.

    Raises DecisionError where the run does not say, ReplayError for a span that the run does not have.
    """
    begin, until = span(run, start, end)
    # What was decided at a sample holds until the next one.
    first = int(np.searchsorted(run.time, begin + 1e-9, side="right")) - 1
    last = int(np.searchsorted(run.time, until - 1e-9))
    found = []
    for asked in decisions(run, place, slice(first, last)):
        numbers, strengths = strongest(firing_strengths(asked.system, asked.inputs[:, robot]), 1)
        changes = np.flatnonzero(np.diff(numbers[:, 0])) + 1
        for a, b in zip([0, *changes], [*changes, last - first], strict=True):
            times = max(begin, float(run.time[first + a])), min(until, float(run.time[first + b]))
            part = strengths[a:b]
            found.append(RuleSpan(asked.task, *times, int(numbers[a, 0]), float(part.min()), float(part.max())))
    return found
