"""Who stops before whom: the rule by which every robot brakes for another that is ahead of it."""

from typing import NamedTuple

import numpy as np

from robotics.laws.law import Observation
from robotics.paths.posture import wrapped

CONE = 0.9  # rad: what is ahead
BRAKING = 1.0  # m/s²
MOVES = 0.01  # m/s: a robot that is slower faces nobody


class Others(NamedTuple):
    """Where the others are by now, as each robot sees it from what it heard; each field is (runs, robots, others)."""

    dx: np.ndarray  # m, in the world's axes
    dy: np.ndarray  # m
    v_x: np.ndarray  # m/s, in the world's axes
    v_y: np.ndarray  # m/s
    distance: np.ndarray  # m, between centers
    bearing: np.ndarray  # rad in [-π, π), from the robot's own heading


def others(seen: Observation) -> Others:
    """The others' places by their messages "x", "y" [m] and "v_x", "v_y" [m/s]; not-a-number before the first."""
    heard = seen.heard
    dx = heard.now("x", by="v_x") - seen.x[:, :, None]
    dy = heard.now("y", by="v_y") - seen.y[:, :, None]
    bearing = wrapped(np.arctan2(dy, dx) - seen.heading[:, :, None])
    return Others(dx, dy, heard["v_x"], heard["v_y"], np.hypot(dx, dy), bearing)


def blocked(seen: Observation, them: Others, near: float) -> np.ndarray:
    """(runs, robots) bool: is another robot ahead, nearer than ``near`` [m] and the braking distance?

    Of two robots that drive towards each other the one with the lower number goes on.
    """
    speed = np.abs(seen.v)
    limit = (near + speed**2 / (2 * BRAKING) + 0.1 * speed)[:, :, None]
    ahead = (them.distance < limit) & (np.abs(them.bearing) < CONE) & seen.heard.hears
    # The other's heading is that of its speed.
    other = np.hypot(them.v_x, them.v_y)
    towards = -(them.dx * them.v_x + them.dy * them.v_y) > np.cos(CONE) * them.distance * other
    number = np.arange(seen.x.shape[1])
    goes_on = (number[:, None] < number) & towards & (other > MOVES)
    return np.asarray((ahead & ~goes_on).any(axis=-1))
