"""The brake for others: the scalar functions of one robot against the arrays of all robots."""

from typing import NamedTuple

import numpy as np

from fuzzy.compiled.columns import within
from fuzzy.compiled.jit import kernel
from robotics.laws.avoidance.priority import (
    BRAKING,
    CONE,
    MOVES,
    WhereaboutsColumns,
    stops_for,
    tell_whereabouts,
)
from robotics.laws.equation import HeardColumns, RobotColumns
from robotics.laws.law import Observation
from robotics.world.paths.posture import wrapped
from robotics.world.paths.references import Reference
from robotics.world.radio.channel import Heard

RUNS, ROBOTS, NEAR = 200, 4, 0.6


class Others(NamedTuple):
    """The others' present places as each robot predicts them from messages; each field is (runs, robots, others)."""

    dx: np.ndarray  # m, in the world's axes
    dy: np.ndarray  # m
    v_x: np.ndarray  # m/s, in the world's axes
    v_y: np.ndarray  # m/s
    distance: np.ndarray  # m, between centers
    bearing: np.ndarray  # rad in [-π, π), from the robot's own heading


def others(seen: Observation) -> Others:
    """The others' places by the WhereaboutsColumns of their messages; not-a-number before the first message."""
    heard = seen.heard
    dx = heard.now("x", by="v_x") - seen.x[:, :, None]
    dy = heard.now("y", by="v_y") - seen.y[:, :, None]
    bearing = wrapped(np.arctan2(dy, dx) - seen.heading[:, :, None])
    return Others(dx, dy, heard["v_x"], heard["v_y"], np.hypot(dx, dy), bearing)


def blocked(seen: Observation, them: Others, near: float) -> np.ndarray:
    """Whether each robot must stop for another ahead of it (runs, robots) bool.

    It must for a robot that is nearer than ``near`` [m] and its own braking distance. Where two robots drive towards
    each other, the one with the lower number goes on. ``them`` is what :func:`others` makes of ``seen``.
    """
    speed = np.abs(seen.v)
    limit = (near + speed**2 / (2 * BRAKING) + 0.1 * speed)[:, :, None]
    ahead = (them.distance < limit) & (np.abs(them.bearing) < CONE) & seen.heard.hears
    # The other is taken to head where its velocity points.
    other = np.hypot(them.v_x, them.v_y)
    towards = -(them.dx * them.v_x + them.dy * them.v_y) > np.cos(CONE) * them.distance * other
    number = np.arange(seen.x.shape[1])
    goes_on = (number[:, None] < number) & towards & (other > MOVES)
    return np.asarray((ahead & ~goes_on).any(axis=-1))


def crowd() -> Observation:
    """Robots in a small field, some of whom have not been heard, and one of whom not everybody hears."""
    rng = np.random.default_rng(5)
    shape = (RUNS, ROBOTS, ROBOTS)
    values = np.stack([*rng.uniform(0.0, 1.5, (2, *shape)), *rng.normal(0.0, 0.2, (2, *shape))])
    age = rng.choice([0.05, 0.3, 0.9, np.inf], shape)
    values[:, np.isinf(age)] = np.nan
    hears = ~np.eye(ROBOTS, dtype=bool)
    hears[0, 3] = False
    x, y = rng.uniform(0.0, 1.5, (2, RUNS, ROBOTS))
    heading, v = rng.uniform(-4.0, 4.0, (RUNS, ROBOTS)), rng.uniform(-0.3, 0.3, (RUNS, ROBOTS))
    reference = Reference(*(np.zeros((RUNS, ROBOTS)) for _ in range(6)))
    heard = Heard(WhereaboutsColumns.leaves(), values, age, hears)
    return Observation(1.0, x, y, heading, v, np.zeros_like(v), reference, None, heard, None)


class Met(HeardColumns):
    """What one robot has heard of another."""

    said = within(WhereaboutsColumns)


@kernel
def of_each(robots, heard, told):
    """Whether each robot (rows, lanes) must stop; its message is written into ``told`` (rows, lanes)."""
    stops = np.zeros(robots.shape[1], dtype=np.bool_)
    for i in range(robots.shape[1]):
        robot = RobotColumns(robots, i)
        tell_whereabouts(WhereaboutsColumns(told, i), robot)
        for j in range(ROBOTS):
            one = Met(heard, i, j)
            if one.hears > 0 and stops_for(one.said, one.age, robot, NEAR, i % ROBOTS < j):
                stops[i] = True
    return stops


def test_one_robot_stops_where_the_arrays_say_so() -> None:
    seen = crowd()
    lanes = RUNS * ROBOTS
    heard, robots, told = Met.zeros(lanes, ROBOTS), RobotColumns.zeros(lanes), WhereaboutsColumns.zeros(lanes)
    heard.age, heard.hears = seen.heard.age.reshape(lanes, -1), np.tile(seen.heard.hears, (RUNS, 1))
    heard.said.array[...] = seen.heard.values.reshape(-1, lanes, ROBOTS)
    robots.x, robots.y, robots.heading, robots.v = (row.ravel() for row in (seen.x, seen.y, seen.heading, seen.v))
    found = of_each(robots.array, heard.array, told.array)
    expected = blocked(seen, others(seen), NEAR)
    assert found.tolist() == expected.ravel().tolist()
    assert 0.05 < expected.mean() < 0.95
    rows = seen.x, seen.y, seen.v * np.cos(seen.heading), seen.v * np.sin(seen.heading)
    np.testing.assert_allclose(told.array, [row.ravel() for row in rows], rtol=1e-15, atol=1e-17)
