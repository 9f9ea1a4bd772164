"""Sampled basins beside certified regions."""

from math import pi

import numpy as np
import pytest

from robotics.commands.application import main
from robotics.plugins.certificates.basins import START_BOX, plot_basins, sampled_basin
from robotics.plugins.certificates.loopmodel import LoopModel
from robotics.simulation.scenario.robots import standard_robot

MODEL = LoopModel(speed_low=0.2, speed_high=0.4, curvature=0.5)


@pytest.fixture(scope="module")
def lyapunov():
    return sampled_basin("lyapunov", standard_robot().robot, MODEL, 60)


def test_starts_lie_in_the_box_and_those_in_the_region_come(lyapunov):
    assert lyapunov.starts.shape == (30, 3)
    assert (np.abs(lyapunov.starts) <= START_BOX).all()
    assert np.abs(lyapunov.starts).max(axis=0) == pytest.approx(START_BOX, rel=0.3)  # and fill it
    assert len(np.unique(lyapunov.slice, axis=0)) == len(lyapunov.slice) == 30
    assert lyapunov.why == ""
    assert lyapunov.came.all()
    assert lyapunov.slice_came.all()


def test_shares_are_those_of_points_drawn_in_the_box(lyapunov):
    points = np.random.default_rng(0).uniform(-1, 1, (2_000_000, 3)) * START_BOX
    inside = np.mean(lyapunov.found.level(points) <= lyapunov.found.region)
    flat = points * (0, 1, 1)
    share = np.mean(lyapunov.found.level(flat) <= lyapunov.found.region)
    assert lyapunov.shares == pytest.approx((inside, share), rel=0.08)


def test_a_law_that_does_not_come_is_seen_and_one_that_is_not_covered_says_why():
    robot = standard_robot().robot
    lost = sampled_basin("lyapunov:kx=0.001,ky=0.001,kpsi=0.001", robot, MODEL, 12)
    assert lost.found is None
    assert not lost.came.any()
    assert lost.shares == (0.0, 0.0)
    esm = sampled_basin("esm", robot, MODEL, 12)
    assert "no certificate is known for this law" in esm.why
    assert esm.came.all()
    figure = plot_basins([lost, esm])
    assert [ax.get_title() for ax in figure.axes] == ["Lyapunov (kx=0.001,ky=0.001,kpsi=0.001)", "Exponential SM"]
    assert figure.axes[0].get_xlim()[1] <= 1.2 < pi


@pytest.mark.long
def test_the_command_draws_the_region_beside_the_starts(tmp_path, capsys):
    picture = tmp_path / "loop.svg"
    words = ["certify", "lyapunov", "--speed", "0.3", "0.32", "--curvature", "0.2", "--quick", "--plot"]
    assert main([*words, str(picture)]) == 0
    assert "region: z'Pz" in capsys.readouterr().out
    assert picture.read_text(encoding="utf-8").count("<use") > 300  # a mark for each start with X = 0
    assert main([*words, str(tmp_path / "loop.doc")]) == 2
    assert "loop.doc" in capsys.readouterr().err
