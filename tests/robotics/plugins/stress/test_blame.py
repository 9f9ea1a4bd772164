"""Blame for contacts, on motions made by hand: whose own motion led to them."""

import numpy as np
import pytest

from robotics.plugins.stress.tally import at_fault
from robotics.world.environment.swept import Watch
from robotics.world.environment.world import Disc, World, compile_worlds
from robotics.world.paths.path import Line
from robotics.world.paths.trajectory import Timing
from tests.robotics.world.vehicle.etsro import ETSRO

HALF, PERIOD = 0.115, 0.05  # m: half the length of a robot; s
UP = np.pi / 2


def moved(pose, v, w=0.0):
    """The pose (5,) at the end of a period of even motion, and at its begin."""
    x, y, heading = pose
    middle = heading + w * PERIOD / 2
    ends = (x + v * PERIOD * np.cos(middle), y + v * PERIOD * np.sin(middle), heading + w * PERIOD)
    return np.array([x, y, heading, v, w]), np.array([*ends, v, w])


def blamed(*motions, discs=(), run=0):
    """Who is to blame for contacts in a period (robots,) of robots with these ``motions``: pose, v [m/s] and ω [rad/s].

    It is the run at the place ``run`` of two; in the other the same robots stand far from each other and from discs.
    """
    steps = np.stack([moved(*motion) for motion in motions], axis=-1)  # begin and end, 5, robots
    far = steps[:1] + np.array([10.0, 10.0, 0.0, 0.0, 0.0])[:, None] * (1 + np.arange(len(motions)))
    far[:, 3:] = 0.0
    runs = [np.broadcast_to(far, steps.shape)] * 2
    runs[run] = steps
    poses = np.stack(runs, axis=2)
    world = compile_worlds([World(obstacles=tuple(discs))] * 2) if discs else None
    at = [None if world is None else world.at(time) for time in (0.0, PERIOD)]
    before = Watch.opened((ETSRO,) * len(motions), 0.0, poses[0], at[0])
    after, ended = before.to(PERIOD, poses[1], at[1])
    assert (after.known.counts[run] > before.known.counts[run]).any()
    found = at_fault(before, after, ended)
    assert not found[1 - run].any()
    return found[run].tolist()


HERE = (0.0, 0.0, 0.0)
BEHIND = (-2 * HALF - 0.002, 0.0, 0.0)  # 2 mm behind one that is here
FACING = (2 * HALF + 0.002, 0.0, np.pi)  # 2 mm ahead of it, and turned to it
CLOSER = (2 * HALF + 0.0018, 0.0, np.pi)
ASIDE = (0.1 + HALF + 0.002, 0.0, np.pi)  # 2 mm beside one that is here and looks up, and turned to it
ABREAST = (0.0, 0.216, 0.0)  # with 16 mm between their sides: of a robot turned by 0.2 rad a corner is 20.8 mm out


@pytest.mark.parametrize("run", [0, 1])
@pytest.mark.parametrize(
    ("first", "second", "guilty"),
    [
        ((BEHIND, 0.2), (HERE, 0.0), [True, False]),  # into one that stands
        ((HERE, 0.0), (FACING, 0.2), [False, True]),  # likewise
        ((BEHIND, 0.3), (HERE, 0.1), [True, False]),  # into one that drives away
        ((HERE, 0.1), (FACING, 0.3), [True, True]),  # head on
        ((HERE, -0.1), (BEHIND, 0.0), [True, False]),  # backwards into one that stands
        ((HERE, 0.019), (CLOSER, 0.019), [True, True]),  # 1.8 mm, by 0.95 mm each: neither alone would have
        (((0.0, 0.0, UP), 0.2), (ASIDE, 0.2), [False, True]),  # into the side of one that passes
        ((HERE, 0.0, 4.0), (ABREAST, 0.0), [True, False]),  # one that turns about itself
    ],
)
def test_whose_motion_led_to_a_contact_of_two(first, second, guilty, run):
    assert blamed(first, second, run=run) == guilty


def test_a_third_robot_has_nothing_to_do_with_it():
    assert blamed((BEHIND, 0.2), ((3.0, 3.0, 0.0), 0.2), (HERE, 0.0)) == [True, False, False]


def disc(gap, v):
    """A disc ``gap`` [m] before the nose of a robot that is here, which comes with ``v`` [m/s]."""
    x = HALF + 0.2 + gap
    path = Line(start=(x, 0.0), end=(x - 1.0, 0.0))
    return Disc(radius=0.2, path=path, timing=Timing(speed=v))


COMING = Disc(radius=0.2, path=Line(start=(-HALF - 0.202, 0.0), end=(1.0, 0.0)), timing=Timing(speed=0.1))  # behind
STILL = Disc(radius=0.2, position=(HALF + 0.2 + 0.002, 0.0))


@pytest.mark.parametrize("run", [0, 1])
@pytest.mark.parametrize(
    ("robot", "discs", "guilty"),
    [
        ((HERE, 0.2), [STILL], True),
        ((HERE, 0.2), [disc(0.002, 0.1)], True),
        ((HERE, 0.0), [disc(0.002, 0.1)], False),  # a disc drove into one that stands
        ((HERE, -0.05), [disc(0.002, 0.2)], False),  # and into one that backs away
        ((HERE, 0.001), [disc(1e-5, 0.1)], False),  # and into one that has not quite come to rest
        ((HERE, 0.001), [Disc(radius=0.2, position=(HALF + 0.2 + 1e-5, 0.0))], True),  # which a still one is not
        # One disc is in it already, and does not hide that it stands still when another comes
        ((HERE, 0.0), [disc(-0.05, 0.1), COMING], False),
        ((HERE, 0.2), [Disc(radius=0.2, position=(0.0, 0.25)), STILL], True),  # nor that it drives into another
    ],
)
def test_whose_motion_led_to_a_contact_with_an_obstacle(robot, discs, guilty, run):
    assert blamed(robot, discs=discs, run=run) == [guilty]


def test_a_contact_that_goes_on_is_judged_when_it_begins_only():
    """A robot is hit by a disc while it stands, and then drives on into it."""
    world = compile_worlds([World(obstacles=(disc(0.002, 0.1),))])
    steps = [np.array([*HERE, 0.0, 0.0]), np.array([*HERE, 0.0, 0.0]), moved(HERE, 0.2)[1]]
    watch = Watch.opened((ETSRO,), 0.0, steps[0].reshape(5, 1, 1), world.at(0.0))
    for k in (1, 2):
        before = watch
        watch, ended = before.to(k * PERIOD, steps[k].reshape(5, 1, 1), world.at(k * PERIOD))
        assert watch.known.counts.item() == 1
        assert not at_fault(before, watch, ended).any()


def test_a_robot_that_was_run_into_is_judged_anew_only_when_it_has_been_apart():
    """It jerks free for some milliseconds and deeper into the disc, then drives away, and back into it."""
    world = compile_worlds([World(obstacles=(disc(0.002, 0.06),))])
    ways = [(0.0, 0.0), (0.0, 0.0), (0.002, 1.0), (-0.05, 0.0), (-0.05, 0.0), (0.0, 0.0)]  # m, m/s
    steps = [np.array([x, 0.0, 0.0, v, 0.0]).reshape(5, 1, 1) for x, v in ways]
    watch, found = Watch.opened((ETSRO,), 0.0, steps[0], world.at(0.0)), []
    for k, step in enumerate(steps[1:], start=1):
        before = watch
        watch, ended = before.to(k * PERIOD, step, world.at(k * PERIOD))
        found.append((watch.known.counts.item(), bool(at_fault(before, watch, ended).any())))
    assert found == [(1, False), (2, False), (2, False), (2, False), (3, True)]
