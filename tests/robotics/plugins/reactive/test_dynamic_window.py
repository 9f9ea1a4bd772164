"""The dynamic window: how far an arc is free, in closed form and by driving it; and what it does before an obstacle."""

import math

import numpy as np
import pytest

from fuzzy.compiled.jit import kernel
from robotics.laws.catalogue import as_law
from robotics.plugins.reactive.dynamic_window import free_way
from robotics.plugins.stress.single import single_run


@kernel
def way(v, w, radius, x, y):
    return free_way(v, w, radius, x, y)


def driven(v, w, radius, x, y, most=6.0, step=1e-3):
    """The way along the arc until the disc touches the point, by small steps."""
    s = np.arange(0, most, step)
    angle = s * w / v
    px = s if w == 0 else v / w * np.sin(angle)
    py = np.zeros_like(s) if w == 0 else v / w * (1 - np.cos(angle))
    touching = np.hypot(px - x, py - y) <= radius
    return s[np.argmax(touching)] if touching.any() else math.inf


@pytest.mark.parametrize("seed", range(40))
def test_the_free_way_of_an_arc_is_that_of_driving_it(seed):
    rng = np.random.default_rng(seed)
    v, w, radius = rng.uniform(0.1, 0.5), rng.choice([0.0, *rng.uniform(-1.5, 1.5, 4)]), 0.2
    x, y = rng.uniform(-1.5, 1.5, 2)
    if math.hypot(x, y) < radius + 0.05:
        x += 0.5
    once_round = 6.0 if w == 0 else min(6.0, 2 * math.pi * v / abs(w))
    found, expected = way(v, w, radius, x, y), driven(v, w, radius, x, y, once_round)
    if math.isinf(expected):
        assert found > once_round - 0.01
    else:
        assert found == pytest.approx(expected, abs=0.01)


def test_a_point_that_is_too_near_holds_no_robot_that_drives_away_from_it():
    assert way(0.2, 0.0, 0.2, -0.1, 0.0) == math.inf
    assert way(0.2, 0.0, 0.2, 0.1, 0.0) < 0.02


def test_it_goes_round_an_obstacle_that_stops_who_only_waits():
    (_, waits), (_, goes) = (
        single_run("obstacles", as_law(name), 5, 1) for name in ("stop-and-wait", "dynamic-window")
    )
    assert waits.deadlocked.all()
    assert not waits.caused.any()
    assert goes.arrived.all()
    assert not goes.caused.any()
