"""ORCA: its linear programs against a grid, two robots head on, and what it is without its radio."""

import numpy as np
import pytest

from fuzzy.compiled.jit import kernel
from robotics.laws.catalogue import as_law
from robotics.plugins.reactive.orca import best_within, half_plane, least_violation
from robotics.plugins.stress.crossings import crossing_ensemble
from robotics.plugins.stress.disturbance import Disturbance
from robotics.plugins.stress.outcome import StressOutcome
from robotics.plugins.stress.tally import run_ensemble

MOST = 0.4


@kernel
def best(planes, count, x, y):
    return best_within(planes, count, MOST, x, y, False)


@kernel
def least(planes, count, begin, x, y):
    return least_violation(planes, count, begin, MOST, x, y)


@kernel
def avoiding(row, dx, dy, u_x, u_y, radius, horizon):
    half_plane(row, 0, dx, dy, u_x, u_y, radius, horizon, 0.05, 1.0)


def inside(planes, v):
    """By how much velocities (..., 2) are within each half-plane (..., planes) [m/s]."""
    p, e = planes[:, :2], planes[:, 2:]
    d = v[..., None, :] - p
    return e[:, 0] * d[..., 1] - e[:, 1] * d[..., 0]


def grid(n=801):
    x, y = np.meshgrid(*[np.linspace(-MOST, MOST, n)] * 2)
    v = np.stack([x, y], axis=-1).reshape(-1, 2)
    return v[np.hypot(*v.T) <= MOST]


@pytest.mark.parametrize("seed", range(25))
def test_the_velocity_found_is_the_best_of_a_grid(seed):
    rng = np.random.default_rng(seed)
    count = int(rng.integers(1, 6))
    angle = rng.uniform(0, 2 * np.pi, count)
    planes = np.concatenate([rng.uniform(-0.25, 0.25, (count, 2)), np.stack([np.cos(angle), np.sin(angle)], 1)], axis=1)
    work = np.concatenate([planes.ravel(), np.zeros(4 * count + 4)])
    wish = rng.uniform(-0.3, 0.3, 2)
    reached, x, y = best(work, count, *wish)
    every = grid()
    worst = inside(planes, every).min(axis=1)
    if (worst >= 0).sum() > 20:
        assert reached == count
        assert inside(planes, np.array([x, y])).min() > -1e-9
        nearest = np.hypot(*(every[worst >= 0] - wish).T).min()
        assert np.hypot(x - wish[0], y - wish[1]) <= nearest + 1e-9
        assert np.hypot(x - wish[0], y - wish[1]) == pytest.approx(nearest, abs=2e-3)
    elif worst.max() < -2e-3:
        assert reached < count
        x, y = least(work, count, reached, x, y)
        assert np.hypot(x, y) <= MOST + 1e-9
        assert inside(planes, np.array([x, y])).min() == pytest.approx(worst.max(), abs=3e-3)


@pytest.mark.parametrize("seed", range(25))
def test_a_velocity_in_the_half_plane_of_a_thing_at_rest_does_not_meet_it(seed):
    rng = np.random.default_rng(seed)
    radius, horizon = 0.4, 3.0
    distance, angle = rng.uniform(0.45, 1.5), rng.uniform(0, 2 * np.pi)
    at = distance * np.array([np.cos(angle), np.sin(angle)])
    own = rng.uniform(-0.3, 0.3, 2)
    row = np.zeros(4)
    avoiding(row, *at, *own, radius, horizon)
    row[:2] += own  # the caller adds the robot's own velocity
    times = np.linspace(0, horizon, 400)[:, None]
    for v in grid(41):
        if inside(row[None], v).min() > 1e-6:
            assert np.hypot(*(times * v - at).T).min() > radius - 1e-3


def runs(disturbance):
    seeds = range(12)
    ensemble = crossing_ensemble(3, seeds, disturbance=disturbance)
    return run_ensemble(StressOutcome, ensemble, as_law("orca"), seeds)


def test_it_is_the_radio_by_which_robots_keep_apart():
    heard, deaf = runs(Disturbance(latency=0.1)), runs(Disturbance(loss=1.0))
    assert heard.caused.any(axis=1).sum() == 0
    assert heard.arrived.all()
    assert deaf.caused.any(axis=1).sum() >= 6
