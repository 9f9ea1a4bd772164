"""Where paths meet: crossings computed by hand, and straight paths at random against a closed form."""

from typing import NamedTuple

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from robotics.laws.rules.meetings import CELL, INSIDE, LOOK, NO_MEETING, Meetings, _first_taken
from robotics.world.paths.joined import join_paths, join_tables
from robotics.world.paths.path import Line, compile_path
from tests.robotics.laws.rules.arrayform.meetings import in_the_way, next_meetings

RADIUS, MARGIN = 0.15, 0.2  # m
APART = 2 * RADIUS + MARGIN  # 0.5 m
Point = tuple[float, float]


def meetings_of(*lines: tuple[Point, Point]) -> Meetings:
    paths = join_paths([compile_path(Line(start=a, end=b)) for a, b in lines])
    return Meetings.of(paths, len(lines), np.full(len(lines), RADIUS), MARGIN)


def told(meetings: Meetings, *places: float) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """``way``, ``through`` and ``theirs`` (robots, others) of robots that know each other's places exactly."""
    place = np.array([places])
    others = np.where(np.eye(len(places), dtype=bool), np.nan, place[:, None, :])
    way, through, theirs = next_meetings(meetings, np.full(len(places), 2 * RADIUS), place, others)
    return way[0], through[0], theirs[0]


# Robot 1 drives along the x axis, robot 2 across it at x = 3: the meeting is |s - 3| < 0.5 on both paths.
CROSS = meetings_of(((0.0, 0.0), (6.0, 0.0)), ((3.0, -3.0), (3.0, 3.0)))
CLOSE = pytest.approx
EDGE = 1.5 * CELL  # m: an edge lies in a cell or the next


def test_meetings_of_many_runs_are_those_of_each_alone() -> None:
    """Runs are shared out over threads."""
    rng = np.random.default_rng(2)
    tables = [
        [compile_path(Line(start=(a, b), end=(c, d))).table for a, b, c, d in team]
        for team in (8 * rng.random((150, 3, 4))).tolist()
    ]
    radii = np.array([0.15, 0.1, 0.3])
    together = Meetings.of(join_tables(tables), 3, radii, MARGIN)
    for r in (0, 63, 64, 149):
        alone = Meetings.of(join_tables([tables[r]]), 3, radii, MARGIN)
        np.testing.assert_array_equal(together.first[r], alone.first[0])
        cells = alone.last.shape[-1]
        np.testing.assert_array_equal(together.last[r, ..., :cells], alone.last[0])
        np.testing.assert_array_equal(together.points[r, :, :cells], alone.points[0])
        full = cells // 8
        np.testing.assert_array_equal(together.peaks[r, :, :, :full], alone.peaks[0, :, :, :full])


def test_before_a_crossing_both_know_their_ways_to_it_and_through_it() -> None:
    way, through, theirs = told(CROSS, 1.0, 0.5)
    assert way[0, 1] == CLOSE(1.5, abs=EDGE)
    assert way[1, 0] == CLOSE(2.0, abs=EDGE)
    assert through[0, 1] == CLOSE(2 * APART, abs=2 * CELL)
    assert theirs[0, 1] == CLOSE(way[1, 0], abs=1e-6)
    assert theirs[1, 0] == CLOSE(way[0, 1], abs=1e-6)
    assert (np.diag(way) == NO_MEETING).all()


def test_one_that_is_in_it_is_told_so_and_the_other_waits_before_it() -> None:
    way, through, theirs = told(CROSS, 3.0, 1.0)
    assert way[0, 1] == INSIDE
    assert theirs[1, 0] == INSIDE
    assert through[0, 1] == CLOSE(APART, abs=2 * CELL)
    assert way[1, 0] == CLOSE(1.5, abs=EDGE)


def test_one_that_has_left_it_meets_the_other_no_more() -> None:
    for places in ((3.6, 1.0), (1.0, 3.6)):
        way, through, theirs = told(CROSS, *places)
        assert (way == NO_MEETING).all()
        assert (theirs == NO_MEETING).all()
        assert (through == 0).all()


def test_one_that_is_leaving_it_leaves_a_narrower_meeting() -> None:
    """Robot 2 is 0.3 m beyond the crossing: robot 1 has to keep away from what remains, |s - 3| <= 0.4."""
    way, through, _ = told(CROSS, 1.0, 3.3)
    assert way[0, 1] == CLOSE(1.6, abs=EDGE)
    assert through[0, 1] == CLOSE(0.8, abs=2 * CELL)


def test_a_robot_that_is_not_heard_is_met_nowhere() -> None:
    way, _, theirs = next_meetings(CROSS, np.full(2, 2 * RADIUS), np.array([[1.0, 0.5]]), np.full((1, 2, 2), np.nan))
    assert (way == NO_MEETING).all()
    assert (theirs == NO_MEETING).all()


def test_a_meeting_farther_ahead_than_one_looks_is_none_yet() -> None:
    far = meetings_of(((0.0, 0.0), (9.0, 0.0)), ((6.0, -3.0), (6.0, 3.0)))
    assert told(far, 5.4 - LOOK, 0.5)[0][0, 1] == NO_MEETING
    assert told(far, 5.7 - LOOK, 0.5)[0][0, 1] == CLOSE(LOOK - 0.2, abs=EDGE)


def three(between: float) -> Meetings:
    """Robot 1 crosses robot 2 at x = 3 and robot 3 so much later that ``between`` [m] lies between the meetings."""
    x = 3.0 + 2 * APART + between
    return meetings_of(((0.0, 0.0), (8.0, 0.0)), ((3.0, -3.0), (3.0, 3.0)), ((x, -3.0), (x, 3.0)))


def test_without_room_between_two_meetings_the_line_is_before_both() -> None:
    way, through, _ = told(three(0.1), 1.0, 0.5, 0.5)
    assert way[0, 1] == CLOSE(1.5, abs=EDGE)
    assert way[0, 2] == CLOSE(1.5, abs=EDGE)
    assert through[0, 2] == CLOSE(1.0 + 0.1 + 1.0, abs=3 * CELL)


def test_with_room_between_two_meetings_each_has_a_line_of_its_own() -> None:
    way, through, _ = told(three(2 * RADIUS + 0.15), 1.0, 0.5, 0.5)
    assert way[0, 1] == CLOSE(1.5, abs=EDGE)
    assert way[0, 2] == CLOSE(1.5 + 1.0 + 2 * RADIUS + 0.15, abs=EDGE)
    assert through[0, 2] == CLOSE(1.0, abs=2 * CELL)


def test_a_meeting_that_is_over_needs_no_room() -> None:
    assert told(three(0.1), 1.0, 3.6, 0.5)[0][0, 2] == CLOSE(1.5 + 1.1, abs=EDGE)


@pytest.mark.parametrize("before", [0.6, 0.4, 0.2, 0.1])
def test_the_line_before_both_stays_while_one_comes_up_to_it(before: float) -> None:
    way, _, _ = told(three(0.1), 2.5 - before, 0.5, 0.5)
    assert way[0, 2] == CLOSE(before, abs=EDGE)


def test_in_the_first_of_two_meetings_the_line_is_the_one_before_the_second() -> None:
    way, _, _ = told(three(0.1), 3.0, 0.5, 0.5)
    assert way[0, 1] == INSIDE
    assert way[0, 2] == CLOSE(0.6, abs=EDGE)


# Robot 2 starts 1 m ahead on the same line and goes 1 m farther
CONVOY = meetings_of(((0.0, 0.0), (6.0, 0.0)), ((1.0, 0.0), (7.0, 0.0)))


@pytest.mark.parametrize(("behind", "ahead"), [(0.2, 0.0), (1.0, 1.5), (3.3, 2.9)])
def test_one_that_follows_on_the_same_path_keeps_a_distance(behind: float, ahead: float) -> None:
    way, _, theirs = told(CONVOY, behind, ahead)
    assert max(way[0, 1], 0.0) == CLOSE(max(1 + ahead - APART - behind, 0.0), abs=2 * CELL)
    assert theirs[0, 1] == INSIDE


def test_the_ends_of_the_paths_demand_who_goes_first() -> None:
    """Robot 2 starts in the way of robot 1, which ends in the way of robot 2; of the others nothing is demanded."""
    np.testing.assert_array_equal(CONVOY.first, [[[False, False], [True, False]]])
    assert not CROSS.first.any()
    stops = meetings_of(((0.0, 0.0), (3.0, 0.0)), ((3.0, -3.0), (3.0, 3.0)))
    np.testing.assert_array_equal(stops.first, [[[False, False], [True, False]]])


def test_the_distance_of_the_others_from_the_way_ahead() -> None:
    x, y = np.array([[[np.nan, 2.0], [0.0, np.nan]]]), np.array([[[np.nan, 0.7], [-3.0, np.nan]]])
    off = in_the_way(CROSS, np.array([[1.0, 0.0]]), x, y, 1.2)
    assert off[0, 0, 1] == CLOSE(0.7, abs=0.01)
    assert off[0, 1, 0] == CLOSE(3.0, abs=0.01)
    assert np.isinf(np.diag(off[0])).all()
    off = in_the_way(CROSS, np.array([[2.5, 0.0]]), x, y, 1.2)  # it is behind by now
    assert off[0, 0, 1] == CLOSE(np.hypot(0.5, 0.7), abs=0.02)


class Straight(NamedTuple):
    start: Point
    heading: float  # rad
    length: float  # m

    def at(self, s: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        return self.start[0] + np.cos(self.heading) * s, self.start[1] + np.sin(self.heading) * s

    @property
    def ends(self) -> tuple[Point, Point]:
        x, y = self.at(np.array(self.length))
        return self.start, (float(x), float(y))


def way_in_closed_form(mine: Straight, other: Straight, apart: float, place: float, theirs: float) -> float:
    """The way to the first place, 1 mm by 1 mm, that is nearer than ``apart`` to a place the other has not left."""
    s = np.arange(place, mine.length, 0.001)
    x, y = mine.at(s)
    dx, dy = x - other.start[0], y - other.start[1]
    along = np.cos(other.heading) * dx + np.sin(other.heading) * dy
    across = np.cos(other.heading) * dy - np.sin(other.heading) * dx
    half = np.sqrt(np.maximum(apart**2 - across**2, 0.0))
    meets = (np.abs(across) < apart) & (along + half >= theirs) & (along - half <= other.length)
    return float(s[meets.argmax()] - place) if meets.any() else np.inf


coordinate = st.floats(-1.5, 1.5)
straights = st.builds(
    Straight, st.tuples(coordinate, coordinate), st.floats(-3.1, 3.1), st.floats(1.0, 3.5)
)  # shorter than one looks


@settings(max_examples=150)
@given(straights, straights, st.floats(0, 0.9), st.floats(0, 0.9))
def test_on_straight_paths_the_way_is_that_of_a_closed_form(
    mine: Straight, other: Straight, at: float, theirs_at: float
) -> None:
    place, theirs = at * mine.length, theirs_at * other.length
    way = told(meetings_of(mine.ends, other.ends), place, theirs)[0][0, 1]
    way = np.inf if way == NO_MEETING else max(way, 0.0)
    # Cells err by no more than one, along either path: a circle smaller by one, or a cell behind, is the other bound
    least = way_in_closed_form(mine, other, APART + CELL, place, theirs - CELL)
    most = way_in_closed_form(mine, other, APART - CELL, place, theirs + CELL)
    assert way >= least - CELL - 0.001
    assert way <= most + CELL + 0.001


def test_no_conflict_is_passed_over_with_its_block():
    meetings = meetings_of(((0.0, 0.0), (2.3, 0.1)), ((1.0, 1.0), (1.1, -1.2)), ((0.0, 0.5), (2.0, -0.5)))
    last, peaks = meetings.last[0], meetings.peaks[0].ravel()
    rng = np.random.default_rng(1)
    found = []
    for _ in range(2000):
        i, j = rng.permutation(3)[:2]
        begin, end = np.sort(rng.integers(0, last.shape[-1] + 1, 2))
        until = rng.choice([-2.0, last[i, j].max(), rng.uniform(0.0, 2.5)])
        taken = begin + np.flatnonzero(last[i, j, begin:end] >= until)
        found.append(_first_taken.py_func(last.ravel(), peaks, 3, i, j, until, begin, end))
        assert found[-1] == (taken[0] if len(taken) else -1)
    assert {-1, *range(5)} < set(found)
