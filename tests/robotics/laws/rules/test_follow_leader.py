"""The law leader-follower against closed forms, on paths that close."""

from math import pi

import numpy as np
import pytest

from robotics.laws.catalogue import make_controller
from robotics.laws.law import ControllerError
from robotics.measures.formations import (
    abscissae,
    largest_place_error,
    last_samples,
    lateral_error,
    leads,
    rms_place_error,
)
from robotics.simulation.loop import simulate
from robotics.simulation.scenario.reading import load_scenario, parse_scenario
from tests.robotics.laws.rules.formations import RADII, circling


def test_on_concentric_circles_speeds_are_as_the_radii():
    run = simulate(circling(), make_controller("leader-follower"))
    v, w = run["command_1"][0, :, -1], run["command_2"][0, :, -1]
    assert v == pytest.approx(0.2 * np.array(RADII) / RADII[0], rel=1e-4)
    assert w == pytest.approx([0.2 / RADII[0]] * 3, rel=1e-3)
    assert leads(run)[0, -1] == pytest.approx(0.0, abs=1e-4)
    radius = np.hypot(run["x"], run["y"])[0, :, -1]
    assert radius == pytest.approx(RADII, abs=2e-4)


def test_a_lead_decays_as_the_head_of_the_module_says():
    angle = 0.02  # robot 2 is 0.04 m too far, as the leader's path counts
    run = simulate(circling(second=angle, duration=20.0), make_controller("leader-follower"))
    turned = np.unwrap(np.arctan2(run["y"], run["x"]))[0]
    ahead = (turned[1] - turned[2]) * RADII[0]  # of the two followers one more than the other
    k = 200  # samples: 10 s
    assert ahead[k] / ahead[0] == pytest.approx(np.exp(-1.5 * 0.2 * 10.0), rel=0.05)
    mean = (turned[0] - (turned[1] + turned[2]) / 2) * RADII[0]
    assert mean[k] / mean[0] == pytest.approx(np.exp(-2.5 * 0.2 * 10.0), abs=0.02)


def test_all_stop_where_the_leaders_path_ends_and_not_where_it_begins():
    law = make_controller("leader-follower:speed=0.5")
    run = simulate(circling(duration=30.0), law)
    last = last_samples(run)[0]
    assert run.time[last] == pytest.approx(2 * pi * RADII[0] / 0.5, abs=0.3)
    assert (run["command_1"][0, :, last + 5 :] == 0).all()
    assert abscissae(run)[0, :, -1] == pytest.approx(2 * pi * np.array(RADII), abs=0.03)
    assert largest_place_error(run).max() < 0.02
    assert (rms_place_error(run) <= largest_place_error(run)).all()


def test_it_drives_the_thesis_formations_too():
    run = simulate(load_scenario("formation-behind"), make_controller("leader-follower"))
    assert abs(leads(run)[0, 1200]) < 0.01
    assert lateral_error(run).max() < 0.01
    alone = parse_scenario(
        'duration = 1.0\n[[robots]]\nstart = [0.0, 0.0, 0.0]\npath = { shape = "line", start = [0, 0], end = [1, 0] }\n'
        "timing = { speed = 0.1 }\n",
        "alone",
    )
    with pytest.raises(ControllerError, match="at least two robots"):
        make_controller("leader-follower").init(alone.setting, 1)
