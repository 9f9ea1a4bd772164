"""Lanes of obstacle courses: those that cross keep what they promise, and those beside each other are as ever."""

import numpy as np
import pytest

from robotics.plugins.stress.obstaclecourse import obstacle_ensemble, random_course
from robotics.simulation.scenario.description import ScenarioError
from robotics.world.paths.path import PathColumns
from tests.robotics.plugins.stress.equalprogress import samples


@pytest.mark.parametrize("kind", ["A", "B", "U"])
def test_crossing_lanes_keep_what_they_promise(kind):
    """From 1.5 m apart to another order, one pair in conflict, ends clear of the other lanes and of obstacles."""
    for seed in range(6):
        tables, world = random_course(np.random.default_rng(seed), kind, 3, lanes="crossing")
        points = samples(tables)
        starts, ends = points[:, 0], points[:, -1]
        np.testing.assert_allclose(starts, [[0.0, 1.5], [0.0, 0.0], [0.0, -1.5]], atol=1e-9)
        np.testing.assert_allclose(ends[:, 0], 7.0, atol=1e-9)
        assert (np.diff(ends[:, 1]) > 0).any()  # not from the left to the right
        np.testing.assert_allclose(np.sort(ends[:, 1]), [-1.5, 0.0, 1.5], atol=0.4)
        assert max(np.abs(PathColumns(t).curvature).max() for t in tables) < 1 / 0.34
        gaps = np.hypot(*np.moveaxis(points[:, None] - points[None], -1, 0))  # robots, robots, samples
        assert min(gaps[i, j].min() for i in range(3) for j in range(i)) < 0.41
        for i in range(3):
            for j in {0, 1, 2} - {i}:
                for end in (starts[i], ends[i]):
                    assert np.hypot(*(points[j] - end).T).min() > 0.58
        for corners in map(placed, world.obstacles):
            for end in (*starts, *ends):
                assert distance(end, corners) >= 0.6


def placed(polygon):
    """The corners (n, 2) [m] of a polygon where it stands."""
    c, s = np.cos(polygon.heading), np.sin(polygon.heading)
    return np.array(polygon.corners) @ np.array([[c, s], [-s, c]]) + polygon.position


def distance(point, corners):
    """The distance [m] of a point from the sides of a polygon, to a millimetre from above."""
    share = np.linspace(0.0, 1.0, 400)[:, None]
    sides = [a + share * (b - a) for a, b in zip(corners, np.roll(corners, -1, axis=0), strict=True)]
    return min(np.hypot(*(side - point).T).min() for side in sides)


def test_class_a_leaves_a_gap_between_obstacles_where_lanes_cross():
    for seed in range(10):
        _, world = random_course(np.random.default_rng(seed), "A", 3, lanes="crossing")
        bodies = [placed(polygon) for polygon in world.obstacles]
        for i, one in enumerate(bodies):
            for other in bodies[:i]:
                assert min(distance(corner, other) for corner in one) >= 0.7
                assert min(distance(corner, one) for corner in other) >= 0.7


def test_a_crossing_course_depends_on_its_seed_alone():
    alone, beside = (obstacle_ensemble(seeds, "A", 3, moving=1, lanes="crossing") for seeds in ((7,), (2, 7)))
    np.testing.assert_array_equal(alone.references.joined.lengths[0], beside.references.joined.lengths[1])
    count = alone.world.rest.counts[0]
    np.testing.assert_array_equal(alone.world.rest.circles[0, :count], beside.world.rest.circles[1, :count])
    assert alone.name == "obstacles-3-A-crossing"


ENDS = [1.2347583271684468, -0.3056801389150027, -1.5384394626488818]
CIRCLES = [
    [3.7398706214904864, -0.3152769878445505, 0.29682020268290843],
    [5.239892047667253, -2.298191027106495, 0.2190700273711831],
]


def test_lanes_beside_each_other_are_as_they_were_before_there_were_others():
    """The numbers were drawn of seed 7 by the version before."""
    course = obstacle_ensemble((7,), "A", 3, moving=1)
    paths = course.references.joined
    assert paths.at(paths.lengths).y[0].tolist() == ENDS
    assert course.world.rest.circles[0, :2].tolist() == CIRCLES


def test_one_lane_crosses_none():
    with pytest.raises(ScenarioError, match="2 robots or more, got 1"):
        obstacle_ensemble((7,), "A", 1, lanes="crossing")
