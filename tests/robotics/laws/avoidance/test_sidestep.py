"""Side-steps and roundabouts: swaps along straight lines are planned, drivable, and nobody touches."""

import numpy as np
import pytest
from scipy.spatial.distance import pdist

from benchmarks.avoidance import circle_swap, ensemble
from robotics.laws.avoidance.right_of_way import RightOfWay
from robotics.laws.avoidance.sidestep import SHARPEST, roundabout, sidestepped
from robotics.laws.law import ControllerError
from robotics.plugins.stress.outcome import StressOutcome
from robotics.plugins.stress.quintic_table import quintic_table
from robotics.plugins.stress.tally import run_ensemble
from robotics.world.paths.path import PathColumns, Quintic

CLEAR = 0.6


def line(start, end):
    chord = (end[0] - start[0], end[1] - start[1])
    return quintic_table(Quintic(start=start, end=end, start_tangent=chord, end_tangent=chord))


def swap(robots):
    starts, goals = circle_swap(robots, range(1))
    pairs = zip(starts[0].tolist(), goals[0].tolist(), strict=True)
    return [line(tuple(start), tuple(goal)) for start, goal in pairs]


def assert_drivable(table, original):
    """It starts and ends as before, its heading and curvature are those of its points, and no bend is too sharp."""
    for k in (0, -1):
        np.testing.assert_allclose(table[:2, k], original[:2, k], atol=1e-6)
        np.testing.assert_allclose(PathColumns(table).heading[k], PathColumns(original).heading[k], atol=2e-3)
    assert np.abs(PathColumns(table).curvature).max() <= SHARPEST
    nodes = PathColumns(table)
    along = np.arctan2(np.diff(nodes.y), np.diff(nodes.x))
    middle = (nodes.heading[1:] + nodes.heading[:-1]) / 2
    np.testing.assert_allclose(np.angle(np.exp(1j * (along - middle))), 0.0, atol=0.01)
    length = np.hypot(np.diff(nodes.x), np.diff(nodes.y))
    turned = np.diff(nodes.heading) / length
    np.testing.assert_allclose(turned, (nodes.curvature[1:] + nodes.curvature[:-1]) / 2, atol=0.2)


@pytest.mark.parametrize("length", [1.5, 2.5, 6.0])
def test_two_on_one_line_keep_to_the_right_of_each_other(length):
    tables = [line((0.0, 0.0), (length, 0.0)), line((length, 0.0), (0.0, 0.0))]
    bent = sidestepped(tables, CLEAR)
    for table, original in zip(bent, tables, strict=True):
        assert_drivable(table, original)
    assert PathColumns(bent[0]).y.min() < -0.3  # it goes east, so that its right is south
    assert PathColumns(bent[1]).y.max() > 0.3
    middle = [PathColumns(table).y[np.argmin(np.abs(PathColumns(table).x - length / 2))] for table in bent]
    assert middle[1] - middle[0] >= CLEAR


@pytest.mark.parametrize("robots", [4, 10])
def test_a_crowd_goes_round_its_middle(robots):
    tables = swap(robots)
    bent = roundabout(tables, CLEAR)
    for table, original in zip(bent, tables, strict=True):
        assert_drivable(table, original)
        nodes = PathColumns(table)
        cross = nodes.x * np.sin(nodes.heading) - nodes.y * np.cos(nodes.heading)
        nearest = np.argmin(np.hypot(nodes.x, nodes.y))
        assert cross[nearest] > 0  # counterclockwise, the middle to the left
    # half-way, all are on the ring at once
    halfway = np.array([table[:2, table.shape[1] // 2] for table in bent])
    assert pdist(halfway).min() >= min(CLEAR, 1.25 * CLEAR * np.sinc(1 / robots))


def test_three_are_no_crowd():
    assert roundabout(swap(3), CLEAR) is None


@pytest.mark.parametrize(("robots", "longest"), [(2, 1.2), (10, 1.6)])
def test_a_circle_swap_on_straight_lines_succeeds(robots, longest):
    starts, goals = circle_swap(robots, range(1))
    outcome = run_ensemble(StressOutcome, ensemble(starts, goals), RightOfWay(), range(1))
    assert not outcome.refused.any()
    assert not outcome.collided.any()
    assert outcome.arrived.all()
    assert outcome.min_distance.min() > 0.4
    assert outcome.arrivals.max() <= longest * 4.0 / 0.22


def test_the_margin_is_in_seconds():
    with pytest.raises(ControllerError, match=r"margin must be a finite number in s, >= 0 and <= 60; got -1"):
        RightOfWay(margin=-1)
