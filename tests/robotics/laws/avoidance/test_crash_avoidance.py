"""Crash avoidance of thesis 6.1: (6.4) and (6.5) on made observations, and its two tests."""

from dataclasses import replace

import numpy as np
import pytest

from fuzzy.compiled.jit import kernel
from robotics.laws.avoidance.crash_avoidance import CrashAvoidance, CrashMessage, CrashWork, turn_at
from robotics.laws.catalogue import make_controller
from robotics.laws.law import ControllerError, Observation
from robotics.measures.arrival import arrival_time, spread
from robotics.measures.teams import nearest_distance
from robotics.simulation.loop import simulate
from robotics.simulation.scenario.reading import load_scenario
from robotics.world.environment.collision import footprints, robot_contacts
from robotics.world.radio.channel import Heard


@pytest.fixture(scope="module")
def crossing():
    return load_scenario("three-cross")


def seen(crossing, poses, time=10.0):
    """What three robots at ``poses`` (3, 3) hear of each other; each hears all, without delay."""
    poses = np.asarray(poses, dtype=float)
    values = np.zeros((6, 1, 3, 3))
    values[4], values[5] = poses[:, 0], poses[:, 1]
    hears = ~np.eye(3, dtype=bool)
    heard = Heard(CrashMessage.leaves(), values, age=np.zeros((1, 3, 3)), hears=hears)
    still = np.zeros((1, 3))
    x, y, heading = poses.T[:, None]
    return Observation(time, x, y, heading, still, still, crossing.trajectory.at(0.0), crossing.trajectory, heard)


def decide(law, crossing, poses):
    command, _ = law.control(seen(crossing, poses), law.init(crossing.setting, 1), 0.05)
    return command.v[0], command.w[0]


@kernel
def turns_at(distances, d_min, factor, eta, work):
    found = np.empty(len(distances))
    for n in range(len(distances)):
        found[n] = turn_at(distances[n], d_min, factor, eta, CrashWork(work))
    return found


@pytest.mark.parametrize("d_min", [0.5, 0.6, 1.0])
def test_the_turn_is_the_formula_also_where_robots_overlap(d_min):
    """1.2 rad (d_min − d) / (d_min − 0.3 m), and 0 from d_min on."""
    law = CrashAvoidance(d_min=d_min)
    least = max(0.0, d_min - 2 * (d_min - 0.3))  # the rule base ends at 2.4 rad
    d = np.linspace(least, d_min, 50)
    given = d_min, law.eta, law.turn.system, np.empty(law.working)
    np.testing.assert_allclose(turns_at(d, *given), 1.2 * (d_min - d) / (d_min - 0.3), atol=1e-9)
    np.testing.assert_allclose(turns_at(np.array([d_min + 0.01, 7.0, np.nan]), *given), 0.0, atol=1e-9)


def test_the_robot_of_higher_number_stops_and_only_while_it_is_near(crossing):
    """(6.5): j > i stands with v = ω = 0 at d_min and goes on beyond it; robot 1 never stops."""
    law = CrashAvoidance(d_min=0.6)
    apart = [(0.0, 2.0, 0.0), (-1.0, 0.0, 0.0), (0.0, -2.0, 0.0)]
    # Behind their starts, so that all have somewhere to go
    back = np.array(apart) - [0.3, 0.0, 0.0]
    v, _ = decide(law, crossing, back)
    assert (v > 0).all()
    for moved, beside, stands in ((2, 0, 2), (0, 1, 1)):  # who is put beside whom, both with the target ahead
        near = back.copy()
        near[moved] = back[beside] + [0.0, -0.59 if moved == 2 else 0.59, 0.0]
        v, w = decide(law, crossing, near)
        assert (v[stands], w[stands]) == (0.0, 0.0)
        assert (np.delete(v, stands) > 0).all()
        near[moved] = back[beside] + [0.0, -0.61 if moved == 2 else 0.61, 0.0]
        v, _ = decide(law, crossing, near)
        assert (v > 0).all()


@pytest.mark.parametrize(("side", "sign"), [(1.0, -1.0), (-1.0, 1.0)])
def test_the_robot_of_lower_number_turns_away(crossing, side, sign):
    """(6.4): a robot to the left makes it turn right, the more the nearer."""
    law = CrashAvoidance(d_min=0.6)
    base = np.array([(-0.3, 2.0, 0.0), (-5.0, 0.0, 0.0), (-0.3, -2.0, 0.0)])
    turns = []
    for d in (0.7, 0.55, 0.45, 0.35):
        base[1] = (base[0, 0] + 0.1, base[0, 1] + side * np.sqrt(d**2 - 0.01), 0.0)
        turns.append(sign * decide(law, crossing, base)[1][0])
    assert abs(turns[0]) < 0.05  # nothing but the noise of the arithmetic, the target being straight ahead
    assert turns[0] < turns[1] < turns[2] < turns[3]


@pytest.mark.parametrize("name", ["crash-literal", "crash-lag-clock"])
def test_as_printed_lambda_is_added_for_the_global_y(crossing, name):
    """(6.4) with (2.36): λ = 0.2 rad at 0.15 m, and ω = 2 (λ + α) / 0.4 s; robots 1 and 3 are 3 cm to the right."""
    places = np.array([(-0.3, 1.97, 0.0), (-5.0, 0.0, 0.0), (-0.3, -2.03, 0.0)])
    starts = crossing.trajectory.at(0.0)
    with_it = decide(make_controller(name), crossing, places)
    without = decide(make_controller(f"{name}:lateral=none"), crossing, places)
    y_err = starts.y - places[:, 1]
    np.testing.assert_allclose((with_it[1] - without[1])[[0, 2]], (5 * 0.2 / 0.15 * y_err)[[0, 2]], rtol=0.02)
    np.testing.assert_array_equal(with_it[0], without[0])


def drive(name, controller, duration=56.0):
    """Least distance of centers [m], contact, spread of arrivals [s], arrival over duration."""
    scenario = replace(load_scenario(name), duration=duration)
    run = simulate(scenario, make_controller(controller), [0])
    sizes = footprints([member.robot for member in scenario.robots])
    x, y, heading = (np.ascontiguousarray(run[name][0].T) for name in ("x", "y", "heading"))
    contact = (robot_contacts(x, y, heading, sizes) >= 0).any()
    arrivals = arrival_time(run)
    ends = scenario.trajectory.ends.max()
    return nearest_distance(run).min(), contact, spread(arrivals)[0], arrivals.max() / ends


@pytest.mark.parametrize(
    ("scenario", "controller", "least", "ratio"),
    [
        ("two-meetings", "right-of-way", 0.40, 1.1),
        ("three-cross", "right-of-way", 0.45, 1.1),
        ("three-cross", "crash-yielding", 0.36, 1.25),
    ],
)
def test_the_thesis_tests_end_without_contact_and_together(scenario, controller, least, ratio):
    """Chapter 6.1.3's two tests with the numbers that an honest implementation reaches."""
    distance, contact, apart, late = drive(scenario, controller)
    assert not contact
    assert distance >= least
    assert apart <= 0.2
    assert late <= ratio


@pytest.mark.parametrize(("d_min", "duration"), [(0.6, 56.0), (0.8, 90.0)])
def test_as_printed_the_second_test_collides_or_never_ends(d_min, duration):
    _, contact, apart, _ = drive("three-cross", f"crash-literal:d_min={d_min}", duration)
    assert contact or np.isinf(apart)


def test_a_distance_below_contact_is_refused():
    with pytest.raises(ControllerError, match=r"d_min must be"):
        CrashAvoidance(d_min=0.3)
    with pytest.raises(ControllerError, match="one input"):
        CrashAvoidance(eta_rule_base="tracking")
