"""Regulated pure pursuit: its arcs, its regulation, its kinship with the fuzzy rules near the path, and its runs."""

from dataclasses import replace
from math import cos, hypot, pi, sin

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from robotics.laws.catalogue import make_controller
from robotics.laws.law import Observation
from robotics.laws.tracking.pure_pursuit import PurePursuit
from robotics.measures.tracking import METRICS, settling_time, tracking_error
from robotics.simulation.loop import simulate
from robotics.simulation.scenario.reading import load_scenario, parse_scenario
from tests.robotics.laws.tracking.courses import from_random_starts

LAW = PurePursuit()
LINE = """
duration = 28.0
[sensing]
posture = "pose"
position_noise = 0.003
heading_noise = 0.003
[[robots]]
start = [0.0, 0.0, 0.0]
path = { shape = "line", start = [0.0, 0.0], end = [6.0, 0.0] }
timing = { speed = 0.3 }
"""
ON_A_LINE = parse_scenario(LINE, "line")


def decide(law, y, heading, behind=0.0, v=0.3, time=5.0, scenario=ON_A_LINE):
    """The command to a robot ``y`` beside a line along x, ``behind`` its reference."""
    one = np.ones((1, 1))
    at = scenario.setting.references.at(np.array(time))
    pose = one * (float(at.x[0]) - behind), one * y, one * heading
    seen = Observation(time, *pose, one * v, 0 * one, at, scenario.setting.references)
    command, _ = law.control(seen, law.init(scenario.setting, 1), 0.05)
    return float(command.first[0, 0]), float(command.second[0, 0])


@given(st.floats(-0.25, 0.25), st.floats(-0.15, 0.15))
@settings(max_examples=25)
def test_the_arc_leads_through_the_carrot(y, heading):
    """Driven for as long as it is, in small steps, the commanded arc ends where the look-ahead circle cuts the path."""
    v, w = decide(LAW, y, heading)
    reach = 1.5 * 0.3
    carrot = np.array([np.sqrt(reach**2 - y**2), 0.0])
    x, psi, best, h = np.array([0.0, y]), heading, np.inf, 2e-3
    for _ in range(1200):
        best = min(best, hypot(*(carrot - x)))
        x = x + v * h * np.array([cos(psi + w * h / 2), sin(psi + w * h / 2)])
        psi += w * h
    assert best < 4e-4


def slopes(law, v=0.3):
    """How ω answers to what lies aside and to the heading, on the path."""
    h = 1e-4
    pairs = [(decide(law, h, 0, v=v), decide(law, -h, 0, v=v)), (decide(law, 0, h, v=v), decide(law, 0, -h, v=v))]
    return [(up[1] - down[1]) / (2 * h) for up, down in pairs]


def test_near_the_path_it_is_the_fuzzy_rules_with_the_same_look_ahead():
    """ω = −(2/T) (ψ + y / (T v)), the poles of s² + (2/T) s + 2/T², of pursuit and of the rules without their D.

    What the rules add near the path is D, the least distance of the point that they steer towards: ω answers a third as
    much to what lies aside.
    """
    time, v = 0.4, 0.3
    expected = [-2 / (time**2 * v), -2 / time]
    np.testing.assert_allclose(slopes(make_controller("pursuit:look_ahead=0.4,look_ahead_least=0.05")), expected, 1e-6)
    np.testing.assert_allclose(slopes(make_controller("fuzzy:steering_distance=0")), expected, 1e-6)
    np.testing.assert_allclose(slopes(make_controller("fuzzy")), [-2 / (time * 0.35), -2 / time], 1e-6)


def test_near_the_path_it_drives_as_the_fuzzy_rules_with_noise():
    """With the same poles the same error and the same variation of ω within 10 %; the rules' D halves that."""
    scenario = replace(load_scenario("lyapunov-circle"), latency=0.03)
    scenario = replace(scenario, robots=(replace(scenario.robots[0], start=(0.0, 1.0, 0.0)),))
    laws = ("pursuit:look_ahead=0.4,look_ahead_least=0.05", "fuzzy:steering_distance=0", "fuzzy")
    runs = [simulate(scenario, make_controller(law), range(20)) for law in laws]
    for metric in ("rms_cross_track_under_way_m", "w_variation_radps2"):
        pursuit, bare, fuzzy = (METRICS[metric].measure(run).mean() for run in runs)
        assert pursuit == pytest.approx(bare, rel=0.1), metric
    assert fuzzy < 0.55 * bare


def test_speed_follows_the_timing_and_is_regulated_where_the_arc_is_tight():
    assert decide(LAW, 0.0, 0.0) == pytest.approx((0.3, 0.0))
    assert decide(LAW, 0.0, 0.0, behind=0.2)[0] == pytest.approx(0.3 + 0.2)
    assert decide(LAW, 0.0, 0.0, behind=-0.9)[0] == 0.0  # it waits
    assert decide(replace(LAW, feed_forward="none"), 0.0, 0.0, behind=0.2)[0] == pytest.approx(0.2)
    # The carrot at (√(0.45² − 0.2²), −0.2): r = 0.45² / 0.4, and of 0.8 m/s there remains r / r_min
    v, w = decide(LAW, 0.2, 0.0, behind=0.5)
    radius = 0.45**2 / 0.4
    assert (v, w) == pytest.approx((0.8 * radius / 0.9, -0.8 / 0.9))
    assert decide(LAW, 0.2, 0.0)[0] == pytest.approx(0.3)  # but what the timing asks for is not taken away


def test_it_turns_in_place_towards_what_lies_far_aside_and_keeps_its_side():
    assert decide(LAW, 0.0, 0.8) == (0.0, -1.8)
    assert decide(LAW, 0.0, -0.8) == (0.0, 1.8)
    assert decide(LAW, 0.0, 0.75)[0] > 0
    # A carrot exactly behind: the turn has one direction, whichever, and is over in the time that half a turn takes
    scenario = replace(ON_A_LINE, latency=0.03, robots=(replace(ON_A_LINE.robots[0], start=(0.0, 0.0, pi)),))
    run = simulate(scenario, LAW, range(20))
    assert (np.abs(run["heading"][..., 50] - pi) > 2.0).all()
    assert METRICS["settling_time_s"].measure(run).max() < 12.0


@pytest.mark.parametrize(
    ("scenario", "within", "rms"),
    [("lyapunov-sine", 5.5, 0.015), ("lyapunov-circle", 5.0, 0.003), ("fuzzy-off-path", 5.5, 0.006)],
)
def test_it_tracks_with_noise_from_off_the_path_and_stops(scenario, within, rms):
    """The look-ahead of Nav2's numbers, 0.45 m at 0.3 m/s, cuts the corners of the sine by a centimetre."""
    run = simulate(replace(load_scenario(scenario), latency=0.03), LAW, range(20))
    assert METRICS["settling_time_s"].measure(run).max() < within
    assert METRICS["rms_cross_track_under_way_m"].measure(run).max() < rms
    assert METRICS["w_variation_radps2"].measure(run).max() < 0.5
    e = tracking_error(run)
    assert np.hypot(e.x, e.y)[..., -1].max() < 0.03


def test_it_stops_at_the_end():
    run = simulate(ON_A_LINE, LAW, range(20))
    assert np.abs(run["v"][..., -20:]).max() < 0.01
    assert np.abs(run["x"][..., -1] - 6.0).max() < 0.02
    assert np.abs(run["y"][..., -1]).max() < 0.005


def test_every_random_start_converges():
    scenario = from_random_starts("fuzzy-off-path", (-1.5, -2.5, -pi), (1.5, 0.5, pi))
    e = tracking_error(run := simulate(scenario, LAW))
    assert settling_time(run, np.hypot(e.x, e.y)).max() < 15.0


def test_the_look_ahead_goes_with_the_speed_between_its_bounds():
    """From y = h the arc's ω is 2 v h / L²; the least look-ahead holds where it exceeds the most."""
    h = 1e-3
    for v, law, reach in (
        (0.4, LAW, 0.6),
        (0.1, LAW, 0.3),
        (0.8, LAW, 0.9),
        (0.4, replace(LAW, look_ahead_least=1.5), 1.5),
    ):
        _, w = decide(law, -h, 0.0, v=v)
        assert w == pytest.approx(2 * 0.3 * h / reach**2, rel=1e-4)
