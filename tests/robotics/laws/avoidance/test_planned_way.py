"""The plan as references: where it has each robot, and how fast; against brute force."""

import numpy as np
import pytest
from scipy.spatial.distance import pdist

from robotics.laws.avoidance.planned_way import PlannedTiming, planned_timing
from robotics.plugins.stress.crossings import crossing_ensemble
from robotics.simulation.scenario.reading import load_scenario
from robotics.world.paths.joined import join_paths
from robotics.world.paths.path import Line, compile_path
from robotics.world.paths.road import TIMED, road_of
from tests.robotics.laws.rules.arrayform.neighbours import planned_share


def nearest(references, end, robots):
    """The least distance [m] between two robots that drive as the references say, in each run."""
    places = [references.at(time) for time in np.linspace(0.0, end, 400)]
    points = np.stack([np.stack([p.x, p.y], axis=-1).reshape(-1, robots, 2) for p in places])
    return np.array([[pdist(run).min() for run in at] for at in points]).min(axis=0)


@pytest.fixture(scope="module")
def crossings():
    setting = crossing_ensemble(3, range(8))
    return setting, planned_timing(setting, 0.5)


def test_the_planned_references_keep_apart_where_the_even_ones_meet(crossings):
    setting, plan = crossings
    assert plan.found.all()
    assert (nearest(setting.references, 60.0, 3) < 0.4).all()
    assert (nearest(plan, 60.0, 3) > 0.5 - 1e-3).all()
    end = plan.at(1e3)
    goals = setting.references.joined.at(setting.references.joined.lengths)
    np.testing.assert_allclose([end.x, end.y], [goals.x, goals.y], atol=1e-6)
    np.testing.assert_array_equal(end.v, 0.0)


def test_the_speed_is_the_derivative_of_the_place(crossings):
    _, plan = crossings
    middle = (np.arange(0, 200) + 0.5) * (plan.durations.max() / 160)
    step = 1e-4
    for time in middle:
        times = np.full(plan.joined.lengths.shape, time)
        tick = times / plan.durations * 160 % 1
        inside = (tick > 0.05) & (tick < 0.95) & (times < plan.ends - 0.1)
        slope = (plan.each_at(times + step).s - plan.each_at(times - step).s) / (2 * step)
        np.testing.assert_allclose(plan.each_at(times).v[inside], slope[inside], atol=1e-6)


def test_the_plan_of_a_scenario_has_the_shape_of_its_robots():
    setting = load_scenario("three-cross").setting
    plan = planned_timing(setting, 0.5)
    assert plan.ends.shape == plan.at(1.0).x.shape == (3,)
    assert plan.each_at(np.zeros((1, 3))).x.shape == (1, 3)
    assert nearest(plan, plan.ends.max(), 3)[0] > 0.5 - 1e-3


def test_a_place_is_reached_when_the_robot_comes_there_and_not_when_it_leaves():
    """Five metres in five ticks, of which one is a wait at 2.5 m."""
    path = join_paths([compile_path(Line(start=(0.0, 0.0), end=(5.0, 0.0)))])
    progress = np.concatenate([[0.0, 0.25, 0.5, 0.5, 0.75], np.ones(200)])[None, None]
    duration = np.array([[160.0]])  # a tick is one second
    road = road_of(path, TIMED.planned, duration[0])
    plan = PlannedTiming(path, duration[0], road, progress, duration, np.array([[True]]))
    np.testing.assert_allclose(plan.reached(1.0, 7)[0, 0], [0, 0.8, 1.6, 3.4, 4.2, 5, 5], atol=1e-6)
    np.testing.assert_allclose(planned_share(plan, np.array([[[2.5]]])), 0.5)
