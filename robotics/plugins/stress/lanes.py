"""The lanes of an obstacle course: quintics from x = 0 to x = 7 m that start side by side.

Lanes that stay beside each other end about where they start. Lanes that cross end in another order: at least one pair
of robots that keep their timing would come nearer than 0.4 m to each other, and starts and ends are at least 0.6 m
clear of the other lanes, as in the random crossings of class A.
"""

from typing import Literal

import numpy as np

from robotics.plugins.stress.conflict import ends_clear, evenly, in_conflict
from robotics.world.paths.path import Quintic

Lanes = Literal["beside", "crossing"]
LENGTH = 7.0  # m, along x
_APART = 1.5  # m between the starts of lanes
_BEND = {1: 1.5, 3: 0.4}  # m, by the number of robots: the most by which a lane ends beside its start
_USUAL_BEND = 0.4  # m, of any other number
TURN = 0.6  # rad: the most by which a crossing lane begins or ends aslant to the straight line between its ends


def lanes_beside(rng: np.random.Generator, robots: int) -> list[Quintic]:
    """Lanes that stay beside each other, the first one at the left.

    Args:
        rng: The generator from which they are drawn.
        robots: Number of lanes.
    """
    bend = _BEND.get(robots, _USUAL_BEND)
    return [Quintic(start=(0.0, float(y)), end=(LENGTH, float(y + rng.uniform(-bend, bend)))) for y in _places(robots)]


def lanes_crossing(rng: np.random.Generator, robots: int) -> list[Quintic]:
    """Lanes of which some cross; the arguments are as of :func:`lanes_beside`, and there are two robots or more."""
    bend = _BEND.get(robots, _USUAL_BEND)
    starts = _places(robots)
    while True:
        order = rng.permutation(robots)
        if (order == np.arange(robots)).all():
            continue
        drawn = [
            _aslant(rng, (0.0, float(start)), (LENGTH, float(end)))
            for start, end in zip(starts, starts[order] + rng.uniform(-bend, bend, robots), strict=True)
        ]
        points = [found for lane in drawn if (found := evenly(lane)) is not None]
        pairs = [(a, b) for i, a in enumerate(points) for b in points[:i]]
        if len(points) == robots and all(ends_clear(*pair) for pair in pairs) and in_conflict(np.array(points)):
            return drawn


def _places(robots: int) -> np.ndarray:
    """Where lanes start, along y [m]."""
    return _APART * ((robots - 1) / 2 - np.arange(robots))


def _aslant(rng: np.random.Generator, start: tuple[float, float], end: tuple[float, float]) -> Quintic:
    """A lane that begins and ends aslant to the straight line between its ends."""
    x, y = end[0] - start[0], end[1] - start[1]
    courses = np.arctan2(y, x) + rng.uniform(-TURN, TURN, 2)
    out, into = ((float(np.hypot(x, y) * np.cos(a)), float(np.hypot(x, y) * np.sin(a))) for a in courses)
    return Quintic(start=start, end=end, start_tangent=out, end_tangent=into)
