"""The predictive law in the loop: what it gains by knowing lag and latency, noise, bounds, plans that go on."""

from dataclasses import replace
from functools import cache

import numpy as np
import pytest

from robotics.laws.catalogue import gains_of, make_controller
from robotics.laws.law import KNOWLEDGE, ControllerError, Observation
from robotics.measures.tracking import METRICS
from robotics.plugins.predictive.nmpc import PredictiveControl
from robotics.simulation.loop import drive, simulate
from robotics.simulation.scenario.reading import load_scenario

UNDER_WAY, TURNING = "rms_cross_track_under_way_m", "w_variation_radps2"


@cache
def driven(scenario, law, latency=None, seeds=20):
    about = load_scenario(scenario)
    about = about if latency is None else replace(about, latency=latency)
    return simulate(about, make_controller(law), range(seeds))


def mean(run, metric):
    return float(METRICS[metric].measure(run).mean())


@pytest.mark.parametrize("scenario", ["lyapunov-sine", "lyapunov-circle"])
def test_it_tracks_closer_than_the_law_without_preview_and_noise_moves_its_wheels_no_more(scenario):
    ours, other = driven(scenario, "nmpc"), driven(scenario, "lyapunov")
    assert not ours.diverged.any()
    assert mean(ours, UNDER_WAY) < 0.55 * mean(other, UNDER_WAY)
    assert mean(ours, TURNING) < 1.3 * mean(other, TURNING)


def test_without_noise_it_stays_within_a_tenth_of_a_millimetre():
    assert mean(driven("reference", "nmpc", seeds=1), UNDER_WAY) < 1e-4


@pytest.mark.parametrize(("latency", "ratio"), [(0.1, 0.1), (0.2, 0.06)])
def test_to_know_the_latency_pays(latency, ratio):
    knowing, ignorant = (
        driven("reference", law, latency, 1) for law in ("nmpc", "nmpc:wheel_lag=ignored,latency=ignored")
    )
    assert mean(knowing, UNDER_WAY) < ratio * mean(ignorant, UNDER_WAY)
    only = driven("reference", "nmpc:latency=ignored", latency, 1)
    assert mean(knowing, UNDER_WAY) < 2 * ratio * mean(only, UNDER_WAY)


def test_to_know_the_lag_of_the_wheels_pays():
    assert mean(driven("reference", "nmpc", seeds=1), UNDER_WAY) < 0.4 * mean(
        driven("reference", "nmpc:wheel_lag=ignored", seeds=1), UNDER_WAY
    )


def test_a_few_iterations_are_as_good_as_the_converged_plan():
    """In the loop each plan starts from the last one."""
    few, many = driven("lyapunov-sine", "nmpc", seeds=4), driven("lyapunov-sine", "nmpc:iterations=100", seeds=4)
    np.testing.assert_allclose(few["x"], many["x"], atol=2e-3)
    assert mean(few, UNDER_WAY) == pytest.approx(mean(many, UNDER_WAY), rel=0.02)


def test_commands_stay_within_what_the_plant_makes_of_them_and_change_no_faster_than_the_motors():
    about = load_scenario("lyapunov-circle")
    run = driven("lyapunov-circle", "nmpc:along_scale=0.01,cross_scale=0.01,change_scale=1", seeds=4)
    robot = about.setting.robots[0]
    v, w = run["command_1"], run["command_2"]
    right, left = v + robot.half_axle * w, v - robot.half_axle * w
    limit = robot.wheel_speed_limit
    assert max(np.abs(right).max(), np.abs(left).max()) <= limit + 1e-9
    assert np.abs(w).max() <= robot.w_max + 1e-9
    most = np.abs(np.diff(np.stack([right, left]), axis=-1)).max()
    assert most == pytest.approx(0.05 * 2 * (0.35 - 0.02) / (0.045 * robot.effective_mass), rel=1e-6)


def test_a_robot_with_bounds_of_its_own_acceleration_keeps_them():
    """(5.1): the plan has them, so that the plant need not cut anything off."""
    about = load_scenario("lyapunov-circle")
    slow = replace(about.robots[0].robot, v_rate_max=0.4, w_rate_max=1.5)
    bounded = replace(about, robots=(replace(about.robots[0], robot=slow),))
    run = simulate(bounded, make_controller("nmpc"), (1,))
    assert np.abs(np.diff(run["command_1"])).max() <= 0.4 * 0.05 + 1e-9
    assert np.abs(np.diff(run["command_2"])).max() == pytest.approx(1.5 * 0.05, rel=1e-6)
    assert mean(run, UNDER_WAY) < 2e-3


def test_a_run_does_not_depend_on_those_beside_it():
    together, alone = (
        driven("lyapunov-sine", "nmpc", seeds=20),
        simulate(load_scenario("lyapunov-sine"), make_controller("nmpc"), (7,)),
    )
    for name in ("x", "y", "heading", "command_1", "command_2"):
        assert together[name][7].tobytes() == alone[name][0].tobytes()


def test_called_by_hand_it_commands_the_same():
    """Its memory, plan and sent commands, is handed back and forth."""
    about = replace(load_scenario("lyapunov-sine"), duration=1.0, latency=0.13)
    law, whole = make_controller("nmpc"), simulate(about, make_controller("nmpc"), (3,))
    memory = law.init(about.setting, 1)
    for state in drive(about.setting, law, (3,)):
        x, y, heading = state.posture
        seen = Observation(state.time, x, y, heading, state.v, state.w, state.reference, about.setting.references)
        command, memory = law.control(seen, memory, about.setting.period)
        assert command.first.item() == whole["command_1"][0, 0, state.k]
        assert command.second.item() == whole["command_2"][0, 0, state.k]


def test_it_says_what_it_knows_and_takes_gains():
    law = make_controller("nmpc:horizon=15,wheel_lag=ignored")
    assert law == PredictiveControl(horizon=15, wheel_lag="ignored")
    assert set(make_controller("nmpc").knows) == set(KNOWLEDGE)
    assert set(KNOWLEDGE) - set(law.knows) == {"wheel speeds", "wheel lag"}
    assert {"along_scale", "cross_scale", "heading_scale", "v_scale", "w_scale", "change_scale"} <= set(gains_of(law))
    with pytest.raises(ControllerError, match="horizon must be a whole number >= 2 and <= 200; got 1"):
        make_controller("nmpc:horizon=1")
    with pytest.raises(ControllerError, match=r"cross_scale must be a finite number in m, >= 0\.001 and <= 1000"):
        make_controller("nmpc:cross_scale=0")


@pytest.mark.parametrize("scenario", ["table-2-1", "kinematic-sine"])
def test_it_drives_other_plants(scenario):
    about = load_scenario("reference") if scenario == "kinematic-sine" else load_scenario(scenario)
    about = replace(about, plant="kinematic") if scenario == "kinematic-sine" else about
    run = simulate(about, make_controller("nmpc"), (1,))
    assert not run.diverged.any()
    assert mean(run, UNDER_WAY) < 0.01
