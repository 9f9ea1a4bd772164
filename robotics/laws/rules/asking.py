"""Rule bases of named inputs asked in compiled code, over all other robots where an input is of pairs.

A rule base is data: where it begins among the packed ones, and which of the quantities that
:mod:`robotics.laws.rules.perception` found out its inputs are. One of pairs is asked once for each other robot.
"""

import math
from collections.abc import Mapping

import numpy as np

from fuzzy.compiled.columns import Columns, column, several
from fuzzy.compiled.jit import compiled_only
from fuzzy.compiled.packed import PackedColumns, evaluate_packed
from robotics.laws.law import ControllerError
from robotics.laws.rules.evaluation import ADDED, MOST_INPUTS, RuleBase
from robotics.laws.rules.of_reference import LATER, later
from robotics.laws.rules.perception import (
    FIRST_LATER,
    FIRST_NUMBERED,
    FIRST_PAIR,
    FIRST_READING,
    PLACES,
    TOLD,
    other_of,
)
from robotics.laws.rules.quantities import NUMBERED, numbered
from robotics.laws.rules.situation import TeamColumns
from robotics.world.paths.road import moving

MOST_OUTPUTS = 10  # likewise
_V, _W = (FIRST_LATER + LATER.index(name) for name in ("target_v", "target_w"))
_AHEAD, _LEFT, _SPEED, _GAP, _BEARING, _CLOSING, _LAG, _AGE = (
    FIRST_NUMBERED + [*NUMBERED].index(name)
    for name in ("ahead", "left", "v", "gap", "bearing", "closing", "lag", "age")
)


class AskColumns(Columns):
    """How a rule base is asked."""

    count = column("", "of its inputs; 0: there is none")
    begin = column("", "where it begins among the packed rule bases")
    rules = column("", "1: it has some")
    pairs = column("", "1: it is asked once for each other robot")
    outputs = column("", "how many it may have")
    places = several(MOST_INPUTS, "", "of its inputs in PLACES")
    numbers = several(MOST_INPUTS, "", "of each: seconds from now [s], the number of a robot from 0, or of a sensor")
    given = several(MOST_OUTPUTS, "", "where it gives each output; -1: it does not")
    neutral = several(MOST_OUTPUTS, "", "what holds where it does not, and of a robot that is not heard")
    adds = several(MOST_OUTPUTS, "", "1: over the other robots it adds up, 0: the least holds")
    least = column("", "the place of its output by which the most urgent robot is found; -1: the first, by its size")
    told = column("", "where its inputs begin among those of all rule bases")


class AnswerColumns(Columns):
    """What a rule base is asked in."""

    asked = several(MOST_INPUTS, "", "its inputs")
    said = several(MOST_OUTPUTS, "", "what it says")


def place_of(name: str, sensors: tuple[str, ...] = ()) -> tuple[int, float]:
    """The place of a quantity in PLACES, and its number. Raises ControllerError for one that came too late."""
    if name in PLACES[:FIRST_LATER]:
        return PLACES.index(name), 0.0
    if at := later(name):
        return FIRST_LATER + LATER.index(at[0]), at[1]
    if name.startswith("range:"):
        sensor = name.removeprefix("range:")
        return FIRST_READING, float(sensors.index(sensor)) if sensor in sensors else -1.0
    if found := numbered(name):
        return FIRST_NUMBERED + [*NUMBERED].index(found[1]), float(found[0])
    raise ControllerError(
        f"{name} was added to RULE_QUANTITIES after a law was imported; add it before that, as "
        "robotics/laws/rules/quantities.py says"
    )


def ask_numbers(
    base: RuleBase | None, neutral: Mapping[str, float], begin: int, told: int, sensors: tuple[str, ...]
) -> dict[str, object]:
    """The numbers of :class:`AskColumns`.

    Args:
        base: The rule base; None: there is none.
        neutral: Its outputs, and what holds where it does not give them.
        begin: Where it begins among the packed ones.
        told: Where its inputs begin among those of all.
        sensors: The range sensors that the equation is told of.
    """
    nothing = [0.0] * (MOST_OUTPUTS - len(neutral))
    rows: dict[str, object] = dict.fromkeys(AskColumns.columns, 0.0)
    rows |= {"places": [0.0] * MOST_INPUTS, "numbers": [0.0] * MOST_INPUTS, "given": [-1.0] * MOST_OUTPUTS}
    rows |= {
        "outputs": len(neutral),
        "neutral": [*neutral.values(), *nothing],
        "adds": [*(float(n in ADDED) for n in neutral), *nothing],
    }
    if base is None:
        return rows
    places = [place_of(v.name, sensors) for v in base.fis.inputs]
    rest = [0.0] * (MOST_INPUTS - len(places))
    least = [place for name, place in base.outputs.items() if name not in ADDED]
    return rows | {
        "count": len(places),
        "begin": begin,
        "rules": float(bool(base.fis.rules)),
        "pairs": float(base.of_pairs),
        "places": [*(place for place, _ in places), *rest],
        "numbers": [*(number for _, number in places), *rest],
        "given": [*(float(base.outputs.get(name, -1)) for name in neutral), *([-1.0] * len(nothing))],
        "least": least[0] if least else -1,
        "told": told,
    }


@compiled_only(forceinline=True)
def ask_rules(ask, rules, memory, known, i, table, now, work, rest, readings, inputs, out):  # type: ignore[no-untyped-def]
    """Write what a rule base says into ``out`` (outputs,), and its inputs where runs record them.

    Args:
        ask: AskColumns.
        rules: The packed rule bases.
        memory: RecallColumns, for the clock.
        known: What the law knows.
        i: The lane.
        table: What the team knows before the start.
        now: PerceivedColumns.
        work: AnswerColumns.
        rest: Where a rule base is evaluated.
        readings: What is told of the sensors and of the others.
        inputs: Where the inputs of all rule bases are recorded.
        out: Where the answer is written.
    """
    count, system, told = int(ask.count), rules[int(ask.begin) :], int(ask.told)
    for o in range(int(ask.outputs)):
        out[o] = ask.neutral[o]
    head, high, pairs = TeamColumns(table), int(PackedColumns(system).high), ask.pairs == 1
    nobody, urgent = True, np.inf
    for j in range((known.heard.shape[2] if pairs else 1) if count > 0 else 0):
        other = other_of(readings, head, known.heard.shape[2], j)
        if pairs and other.counts == 0:
            continue
        for n in range(count):
            value = told_of(other, int(ask.places[n]), ask.numbers[n], memory, known, i, head, now, readings)
            if math.isnan(value) or value == np.inf:  # what is not known is the end of its universe
                value = system[high + n]
            work.asked[n] = value
        urgency = 0.0
        if ask.rules == 1:
            evaluate_packed(system, work.asked, work.said, rest)
            urgency = work.said[int(ask.least)] if ask.least >= 0 else -abs(work.said[0])
            for o in range(int(ask.outputs)):
                if ask.given[o] >= 0:
                    said = work.said[int(ask.given[o])]
                    if pairs:
                        said = out[o] + said if ask.adds[o] == 1 else min(out[o], said)
                    out[o] = said
        if nobody or urgency < urgent:
            nobody, urgent = False, urgency
            for n in range(count):
                inputs[told + n] = work.asked[n]
    if nobody:
        for n in range(count):
            inputs[told + n] = np.nan


@compiled_only(forceinline=True)
def told_of(other, place, number, memory, known, i, head, now, readings):  # type: ignore[no-untyped-def]
    """What a robot knows of a quantity, by its ``place`` in PLACES and its number; one of pairs of an ``other``."""
    if place < FIRST_PAIR:
        return now.known[place]
    if place < FIRST_LATER:
        return other.told[place - FIRST_PAIR]
    return _numbered(place, number, memory, known, i, head, readings)


@compiled_only(forceinline=True)
def _numbered(place, number, memory, known, i, head, readings):  # type: ignore[no-untyped-def]
    """A quantity of a later time, of a robot by its number, or what a range sensor reads."""
    robots = known.heard.shape[2]
    if place == FIRST_READING:
        return known.ranges[int(number), i] if number >= 0 else np.inf
    if place < FIRST_NUMBERED:
        _, _, _, v, w, _ = moving(known.road, known.path[i], memory.clock + number)
        if place == _V:
            return v
        return w if place == _W else w / v if v != 0 else 0.0
    if int(number) == i % robots:
        return 0.0
    other = other_of(readings, head, robots, int(number))
    if place == _AHEAD:
        return other.ahead
    if place == _LEFT:
        return other.left
    if place == _SPEED:
        return other.speed
    if place == _GAP:
        return other.gap
    if place == _BEARING:
        return other.bearing
    if place == _CLOSING:
        return other.closing
    return other.told[TOLD.their_lag] if place == _LAG else other.told[TOLD.age]
