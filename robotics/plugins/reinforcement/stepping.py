"""A step of all episodes in compiled code: obey, pay, move, sense, look, observe; each lane has a clock of its own.

A lane is an episode: a run of one robot. The steps are those of :mod:`robotics.simulation.steps`, lane by lane, with
the same functions below them, so that the same commands give the same run to the last bit.
"""

from typing import NamedTuple

import numpy as np

from fuzzy.compiled.columns import Floats2
from fuzzy.compiled.jit import compiled_only, without_refcounts
from robotics.laws.equation import CommandColumns, SeenColumns
from robotics.plugins.reinforcement.observed import observe
from robotics.plugins.reinforcement.reward import EpisodeNotes, pay
from robotics.simulation.lanes import PlantLanes
from robotics.simulation.observer import Moment
from robotics.simulation.steps import VELOCITY, move_lanes, on_course
from robotics.world.paths.road import Road, moving
from robotics.world.sensing.carried import look_of, some_due, tell
from robotics.world.sensing.posture import Senses, encoders_of, measure_of
from robotics.world.vehicle.plant import TruthColumns


class EpisodeLanes(NamedTuple):
    """All episodes as columns, and what does not change; the arrays of one lane are its column."""

    moment: Moment  # of the step; its period is nobody's
    notes: EpisodeNotes
    body: PlantLanes
    senses: Senses  # of one robot; its random numbers are (lanes, samples, 3, 1)
    road: Road  # a path for each scenario
    most: Floats2  # (2, scenarios): the command of an action 1, or 1 where actions are in units
    highs: Floats2  # (entries, scenarios): the limits of an observation
    ranges: Floats2  # (sensors, lanes) m
    observed: Floats2  # (lanes, entries)


@without_refcounts
def advance(lanes, chosen, turn, actions, high, observes, scratch):  # type: ignore[no-untyped-def]
    """Take a step in ``chosen`` lanes, up to looking around.

    Args:
        lanes: All lanes.
        chosen: Lanes that follow each other, from a multiple of the plant's block on to another, or to the last.
        turn: How many steps were taken before, by whichever lane.
        actions: (lanes, 2).
        high: The limits of an action (2,).
        observes: Whether to write what is observed, too: nobody looks around.
        scratch: The plant works in it.
    """
    moment, notes, order = lanes.moment, lanes.notes, lanes.moment.order
    for i in chosen:
        command, aim = CommandColumns(moment.command, i), SeenColumns(moment.seen, i).aim
        one = _clipped(actions[i, 0], high[0]) * lanes.most[0, notes.robot[i]]
        two = _clipped(actions[i, 1], high[1]) * lanes.most[1, notes.robot[i]]
        stays = on_course(one, two, TruthColumns(moment.truth, i), aim, notes.divergence)
        command.first, command.second = one, two
        order[0, i], order[1, i] = (one, two) if stays else (0.0, 0.0)
    first, last = chosen[0], chosen[-1] + 1
    pay(first, last, moment, notes)
    move_lanes(first, last, turn, lanes.body, order, scratch)
    sense_lanes(lanes, chosen)
    if observes:
        observe_lanes(lanes, chosen)


@compiled_only
def _clipped(value, high):  # type: ignore[no-untyped-def]
    """A value between -``high`` and ``high``; not-a-number stays."""
    return value if not abs(value) > high else (high if value > 0 else -high)


@without_refcounts
def sense_lanes(lanes, chosen):  # type: ignore[no-untyped-def]
    """Measure in some lanes, and look up where their references are."""
    body, senses, seen, period = lanes.body, lanes.senses, lanes.moment.seen, lanes.moment.period
    posture, velocity = seen[:VELOCITY], seen[VELOCITY : VELOCITY + 2]
    drawn = max(senses.draws.shape[1], senses.relative_draws.shape[1])
    for i in chosen:
        encoders_of(i, body.parameters, body.truth, senses.counts, period, velocity)
    for i in chosen:
        k = lanes.notes.clock[i]
        measure_of(i, i, 0, senses, body.parameters, body.truth, posture, velocity, k, min(k, drawn - 1), period)
    for i in chosen:
        aim, time = SeenColumns(seen, i).aim, lanes.notes.clock[i] * period
        aim.x, aim.y, aim.heading, aim.v, aim.w, aim.s = moving(lanes.road, lanes.notes.robot[i], time)


@without_refcounts
def look_around(lanes, looks, chosen):  # type: ignore[no-untyped-def]
    """Read the range sensors of some lanes that are due by their clocks."""
    truth, here = lanes.body.truth, TruthColumns(lanes.body.truth)
    for i in chosen:
        if some_due(looks, lanes.notes.clock[i]):
            looks.turned[0, i], looks.turned[1, i] = np.cos(here.heading[i]), np.sin(here.heading[i])
            look_of(looks, lanes.notes.clock[i], i, 1, truth)
        tell(looks, i, lanes.ranges)


@without_refcounts
def observe_lanes(lanes, chosen):  # type: ignore[no-untyped-def]
    """Write what is observed in some lanes."""
    for i in chosen:
        seen, s = SeenColumns(lanes.moment.seen, i), lanes.notes.robot[i]
        last, time = CommandColumns(lanes.moment.command, i), lanes.notes.clock[i] * lanes.moment.period
        observe(seen.robot, seen.aim, last, time, lanes.ranges, i, lanes.road, s, lanes.highs[:, s], lanes.observed[i])
