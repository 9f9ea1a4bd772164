"""The fuzzy team on a plan: what planning brings, what the rules bring, and where there is no plan."""

from dataclasses import replace
from itertools import islice

import numpy as np
import pytest

from benchmarks.avoidance import circle_swap, ensemble
from robotics.laws.avoidance.planned_way import planned_timing
from robotics.laws.catalogue import make_controller
from robotics.laws.rules.fuzzy_team import FuzzyTeam
from robotics.laws.rules.meetings import CELL, Meetings
from robotics.laws.rules.situation import turning_circles
from robotics.measures.tracking import cross_track_error
from robotics.plugins.stress.crossings import crossing_ensemble
from robotics.plugins.stress.obstaclecourse import stress_obstacles
from robotics.plugins.stress.outcome import StressOutcome
from robotics.plugins.stress.single import single_run
from robotics.plugins.stress.tally import run_ensemble
from robotics.simulation.loop import drive, simulate
from robotics.simulation.scenario.reading import load_scenario
from tests.robotics.laws.rules.arrayform.laws import InterpretedTeam
from tests.robotics.laws.rules.arrayform.meetings import planned_order

PLANNED = make_controller("fuzzy-team-planned")


def crossed_lines():
    """Two straight paths of 6 m: robot 1 goes east, robot 2 goes north, and they cross at the middles."""
    return ensemble(np.array([[[-3.0, 0.0], [0.0, -3.0]]]), np.array([[[3.0, 0.0], [0.0, 3.0]]]))


@pytest.mark.parametrize("first", [0, 1])
def test_who_crosses_first_by_the_plan_has_right_of_way_whatever_the_numbers(first):
    setting = crossed_lines()
    paths = setting.references.joined
    meetings = Meetings.of(paths, 2, turning_circles(setting), 0.2)
    seconds = np.arange(meetings.last.shape[-1]) * CELL / 0.2  # at 0.2 m/s; the other starts 5 s later
    reached = np.stack([seconds + 5.0 * (robot != first) for robot in range(2)])[None]

    def order(*places):
        place = np.array([places])
        return planned_order(meetings, reached, place, np.broadcast_to(place[:, None], (1, 2, 2)))[0, first]

    mine = np.zeros(2)
    mine[1 - first] = 1.0
    np.testing.assert_array_equal(order(0.0, 0.0), mine)
    np.testing.assert_array_equal(order(*np.where(np.arange(2) == first, 1.0, 2.4)), mine)  # the other came too soon
    np.testing.assert_array_equal(order(*np.where(np.arange(2) == first, 4.0, 2.0)), [0.0, 0.0])  # passed
    unknown = planned_order(meetings, reached, np.zeros((1, 2)), np.full((1, 2, 2), np.nan))
    np.testing.assert_array_equal(unknown, 0.0)


def test_two_robots_agree_on_the_order_of_a_plan_wherever_they_are():
    """The plan itself says who passed: from its own samples, without tables of conflicts."""
    setting = crossed_lines()
    plan = planned_timing(setting, 0.5)
    meetings = Meetings.of(plan.joined, 2, turning_circles(setting), 0.2)
    reached = plan.reached(CELL, meetings.last.shape[-1])
    middle = [next(t for t in np.linspace(0, 60, 2001) if plan.at(t).s[0, i] > 3.0) for i in range(2)]
    earlier = int(np.argmin(middle))
    for places in np.random.default_rng(0).uniform(0.0, 2.6, (50, 2)):
        order = planned_order(meetings, reached, places[None], np.broadcast_to(places, (1, 2, 2)))[0]
        assert order[earlier, 1 - earlier] == 1.0
        assert order[1 - earlier, earlier] == -1.0


@pytest.mark.long
def test_what_planning_brings_four_robots_swap_their_places_on_a_roundabout():
    """Without the plan they meet in the middle, and sort themselves out."""
    starts, goals = circle_swap(4, range(1))
    planned, alone = (
        run_ensemble(StressOutcome, ensemble(starts, goals), law, range(1)) for law in (PLANNED, FuzzyTeam())
    )
    assert planned.arrived.all()
    assert not planned.collided.any()
    assert planned.arrivals.max() < 0.95 * alone.arrivals.max()
    assert planned.emergency_share == 0.0 < alone.emergency_share
    assert planned.min_distance.min() > 0.5 > alone.min_distance.min()


@pytest.mark.long
def test_a_robot_that_waits_by_the_plan_is_no_obstacle_to_drive_round():
    """The plan of this crossing has robots 2 and 6 wait near each other; nobody leaves the path for them."""
    told = InterpretedTeam(plan="reservation")  # the same, whose memory has the plan
    *_, state = islice(drive(crossing_ensemble(10, [5]), told, [5]), 560)
    plan, recall = state.memory.fixed.plan, state.memory.recall
    assert (plan.each_at(recall.clock).v[0, [1, 5]] == 0.0).all()
    run, outcome = single_run("crossing", PLANNED, 5, robots=10, name="fuzzy-team-planned")
    assert outcome.arrived.all()
    assert np.nanmax(np.abs(cross_track_error(run))) < 0.1


@pytest.mark.long
@pytest.mark.filterwarnings("ignore:obstacles. no rule fires for output keep")
def test_what_the_rules_bring_the_planned_team_drives_round_what_no_plan_knows():
    """The right of way drives the same plan blind."""
    planned, blind = (
        stress_obstacles(law, [1], "A", 3, lanes="crossing") for law in (PLANNED, make_controller("right-of-way"))
    )
    assert planned.succeeded.all()
    assert blind.hit.all()


def test_runs_without_a_plan_are_refused_and_stay_and_the_others_drive():
    states = list(islice(drive(crossing_ensemble(3, [0, 203], "B"), PLANNED, [0, 203]), 60))
    for state in states:
        np.testing.assert_array_equal(state.command.refused, [False, True])
    moved = np.hypot(*(states[-1].truth[:2] - states[0].truth[:2]))
    assert (moved[0] > 0.1).all()
    assert (moved[1] < 1e-9).all()


def test_a_robot_that_is_alone_needs_no_plan():
    scenario = replace(load_scenario("fuzzy-off-path"), duration=3.0)
    planned, alone = (simulate(scenario, law).recorded["samples"].values for law in (PLANNED, FuzzyTeam()))
    np.testing.assert_array_equal(planned, alone)
