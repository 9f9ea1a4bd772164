"""Formation data against closed forms and the figures of the thesis; metrics against runs made by hand."""

import subprocess
import sys
from dataclasses import replace

import numpy as np
import pytest

from robotics.measures.formations import alignment_time, final_spread, last_samples, lateral_error, measure_formation
from robotics.plugins.learning.datatable import write_data
from robotics.plugins.learning.formationdata import (
    FILES,
    FormationDataError,
    FormationRecipe,
    checking_recipe,
    formation_data,
)
from robotics.plugins.learning.formations import formation_scenario, leader_path
from robotics.simulation.run import CHANNELS
from robotics.world.paths.path import Sine, compile_path
from tests.robotics.handmade import handmade


def curve(x):
    """y, heading and curvature of y = 0.5 cos x after a straight lead-in, in closed form."""
    u = np.maximum(x, 0.0)
    slope = -0.5 * np.sin(u)
    return 0.5 * np.cos(u), np.arctan(slope), np.where(x < 0, 0.0, -0.5 * np.cos(u) / (1 + slope**2) ** 1.5)


def away_from_the_jump(*x):
    """The curvature jumps at x = 0; the path's table is between the two within a node of it."""
    return np.all([np.abs(v) > 0.01 for v in x], axis=0)


@pytest.fixture(scope="module")
def literal():
    return formation_data(FormationRecipe())


@pytest.fixture(scope="module")
def well_posed():
    return formation_data(FormationRecipe(kind="well-posed"))


def test_literal_set_is_what_5_2_1_describes(literal):
    assert literal.names == ("x_l", "y_l", "theta_l", "v_l", "w_l", "v_f", "w_f")
    assert literal.inputs == ("x_l", "y_l", "theta_l")
    x, y, theta, v_l, w_l, v_f, _ = literal.values.T
    assert literal.values.shape == (2000, 7)
    # the extents that the printed widths of the clusters stand for: 10.04 m, 1.06 m, 0.84 rad
    np.testing.assert_allclose(np.ptp(literal.values[:, :3], axis=0), [10, 1, 2 * np.arctan(0.5)], atol=2e-3)
    blocks = literal.values.reshape(5, 400, 7)
    np.testing.assert_allclose(blocks[:, 0, 0], [-4, -2, 0, 2, 4], atol=1e-9)
    np.testing.assert_allclose(blocks[:, -1, 0], 6.0, atol=1e-6)
    np.testing.assert_allclose(blocks[:, 0, 3], [0.3, 0.2, 0.1, 0, 0], atol=1e-9)
    np.testing.assert_allclose(blocks[:, -1, 3], 0.1, atol=1e-9)
    assert (v_f == 0.1).all()
    expected_y, expected_theta, curvature = curve(x)
    np.testing.assert_allclose(y, expected_y, atol=1e-3)
    np.testing.assert_allclose(theta, expected_theta, atol=5e-3)
    good = away_from_the_jump(x)
    np.testing.assert_allclose(w_l[good], (v_l * curvature)[good], atol=3e-6)
    # evenly in time: along the straight lead-in at 0.3 m/s every step is the same
    steps = np.diff(blocks[0, :, 0])[blocks[0, 1:, 0] < 0]
    assert len(steps) > 20
    assert np.ptp(steps) < 3e-6


def test_literal_followers_turn_as_their_own_place_asks(literal):
    """w_f = v_f κ(x_f), with x_f from its own closed form: 0.1 m/s along the arc of the cosine."""
    block = literal.values.reshape(5, 400, 7)[2]  # level with the leader: x_f = x_l
    good = away_from_the_jump(block[:, 0])
    np.testing.assert_allclose(block[good, 6], 0.1 * curve(block[good, 0])[2], atol=2e-4)
    waiting = literal.values.reshape(5, 400, 7)[4]
    assert np.ptp(waiting[waiting[:, 3] == 0, 6]) > 0.09  # the leader stands, the followers go through half the curve


def test_well_posed_outputs_are_the_law_in_closed_form(well_posed):
    assert well_posed.names == ("dx", "alpha_l", "kappa_f", "v_l", "w_l", "v_f", "w_f")
    assert well_posed.inputs == ("dx", "alpha_l", "kappa_f")
    assert well_posed.values.shape == (2000, 7)
    dx, alpha, kappa, v_l, w_l, v_f, w_f = well_posed.values.T
    # logistic curves through 1 at dx = 0: 3 to 0, and 1/2 to 1.2
    np.testing.assert_allclose(v_l, 0.3 / (1 + 2 * np.exp(1.5 * dx)), atol=2e-6)
    np.testing.assert_allclose(v_f, 0.05 + 0.07 / (1 + 0.4 * np.exp(-1.2 * dx)), atol=2e-6)
    np.testing.assert_allclose(w_l, v_l * np.sin(alpha) / 0.25, atol=5e-6)
    np.testing.assert_allclose(w_f, v_f * kappa, atol=2e-6)


def test_well_posed_rows_leave_the_path_and_cover_the_plane(well_posed):
    dx, alpha, kappa = well_posed.values[:, :3].T
    # Beside the path half a metre ahead stands at atan(0.1/0.5) + 0.15 at most, and the curve bends by 0.13 more
    assert 0.4 < np.abs(alpha).max() < np.arctan(0.2) + 0.15 + 0.5 * 0.5 / 2
    assert abs(alpha.mean()) < 0.02
    assert kappa.min() == pytest.approx(-0.5, abs=2e-3)
    assert kappa.max() == pytest.approx(0.5, abs=2e-3)
    # Even over (x_l, dx), x_l in [−4, 2π], with the followers in [0, 2π]: so many x_l are left for each dx
    counts, edges = np.histogram(dx, bins=8, range=(-4, 4))
    middle = (edges[1:] + edges[:-1]) / 2
    room = np.minimum(2 * np.pi, 2 * np.pi + middle) - np.maximum(-4.0, middle)
    np.testing.assert_allclose(counts, 2000 * room / room.sum(), rtol=0.2)
    # Where a displaced leader is not: the bearing on the path itself, by its own geometry
    still = formation_data(FormationRecipe(kind="well-posed", jitter=0.0)).values[:, 1]
    assert np.abs(still).max() < 0.5 * 0.5 / 2 + 0.01


def test_the_seed_decides_everything(tmp_path):
    recipe = FormationRecipe(kind="well-posed", samples=20, starts=(-1.0, 1.0))
    once, again = formation_data(recipe), formation_data(recipe)
    np.testing.assert_array_equal(once.values, again.values)
    assert (once.values != formation_data(replace(recipe, seed=1)).values).any()
    write_data(tmp_path / "a.csv", once.names, once.values)
    read = np.loadtxt(tmp_path / "a.csv", delimiter=",", skiprows=1)
    np.testing.assert_array_equal(read, once.values)
    assert "-0\n" not in (tmp_path / "a.csv").read_text(encoding="utf-8")


def test_without_jitter_and_cover_the_leader_stays_on_its_path():
    table = formation_data(FormationRecipe(kind="well-posed", samples=30, starts=(3.0,), jitter=0.0, coverage=0.0))
    dx, alpha, kappa = table.values[:, :3].T
    assert dx[0] == pytest.approx(3.0)
    assert abs(dx[-1]) < 0.05
    assert kappa.min() == pytest.approx(-0.5, abs=0.01)  # the followers begin at the crest
    # Pure pursuit drives the arc through the point ahead: its curvature is the path's, but for the change ahead
    assert 0.4 < np.abs(2 * np.sin(alpha) / 0.5).max() < 0.5 + 0.06


def test_checking_sets_hold_another_formation():
    for name, recipe in FILES.items():
        assert (recipe.starts == (-1.0,)) == ("check" in name)
        assert recipe.coverage == (0.0 if "check" in name else 1.0)
    table = formation_data(checking_recipe(FormationRecipe()))
    assert len(table.values) == 400
    assert table.values[0, 0] == -1.0
    assert table.values[0, 3] == pytest.approx(0.15)  # between level (1) and two metres behind (2)


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ({"samples": 1}, "samples must be a whole number >= 2"),
        ({"seed": -1}, "seed must be a whole number >= 0"),
        ({"starts": ()}, "formations are the leader's x"),
        ({"starts": (6.0,)}, "< 5.9; got [6.0]"),
        ({"starts": (float("nan"),)}, "formations are the leader's x"),
        ({"coverage": 1.5}, "coverage must be a finite number, >= 0 and <= 1; got 1.5"),
        ({"speed": 0.0}, "speed must be a finite number in m/s, > 0"),
        ({"kind": "other"}, "kind must be 'literal' or 'well-posed'"),
    ],
)
def test_options_that_make_no_data(options, message):
    with pytest.raises(FormationDataError) as caught:
        FormationRecipe(**options)
    assert message in str(caught.value)


def test_a_sine_may_have_a_straight_lead_in():
    plain, path = compile_path(Sine(amplitude=0.5, phase=np.pi / 2)), compile_path(leader_path(lead_in=4.0))
    assert path.length == pytest.approx(plain.length + 4.0, abs=1e-6)
    s = np.linspace(0, path.length, 500)
    point = path.at(s)
    y, heading, curvature = curve(point.x)
    np.testing.assert_allclose(point.y, y, atol=1e-6)
    np.testing.assert_allclose(point.heading, heading, atol=1e-5)
    good = away_from_the_jump(point.x)
    np.testing.assert_allclose(point.curvature[good], curvature[good], atol=1e-5)
    # backwards, and along a tangent that is not horizontal: a sine from x = 0 to −1 led in from (1, 1)
    back = compile_path(Sine(x_end=-1.0, lead_in=1.0)).at(np.array([0.0, 1.0, np.sqrt(2)]))
    np.testing.assert_allclose(back.x, [1, 1 - np.sqrt(0.5), 0], atol=1e-6)
    np.testing.assert_allclose(back.y, [1, 1 - np.sqrt(0.5), 0], atol=1e-6)


def test_a_path_can_be_evaluated_after_its_trajectory(capsys):
    """In a process whose compiled functions come from Numba's cache."""
    code = (
        "from robotics.plugins.learning.formations import formation_scenario; s = formation_scenario(0.0); "
        "s.trajectory.at(0.0);"
        "print(float(s.trajectory.paths[0].at(0.0).y))"
    )
    exec(code)  # which may fill the cache
    assert float(capsys.readouterr().out) == 0.5
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True, timeout=120)
    assert float(done.stdout) == 0.5


def run_by_hand(leader, followers):
    """Three robots on straight lines; leader and followers are lists of x, the end is at x = 3."""
    n = len(leader)
    samples = np.zeros((n, len(CHANNELS), 1, 3))
    samples[:, 0, 0] = np.stack([leader, followers, followers], axis=1)
    samples[:, 1, 0] = [0.0, 1.0, -0.8]
    paths = tuple(np.stack([np.linspace(0, 3, 31), np.full(31, y)]) for y in (0.0, 1.0, -1.0))
    return handmade((0,), np.arange(n) * 0.5, samples, np.zeros((6, n, 3)), paths, np.full((1, 3), -1))


def test_figures_of_merit_by_hand():
    #                   apart, level, apart, level, level, end, beyond it: not counted
    run = run_by_hand([0.0, 1.0, 1.5, 2.0, 2.5, 2.995, 9.0], [0.5, 0.95, 1.2, 1.98, 2.45, 2.965, 3.0])
    assert last_samples(run).tolist() == [5]
    assert alignment_time(run).tolist() == [1.5]
    assert final_spread(run) == pytest.approx(0.03)
    assert lateral_error(run)[0] == pytest.approx([0.0, 0.0, 0.2])
    assert {k: v.shape for k, v in measure_formation(run).items()} == dict.fromkeys(
        ("alignment_time_s", "final_spread_m", "max_lateral_error_m", "max_place_error_m", "rms_place_error_m"), (1, 3)
    )
    short = run_by_hand([0.0, 1.0, 2.0], [0.0, 1.0, 2.0])  # never arrives
    assert last_samples(short).tolist() == [-1]
    assert np.isinf([alignment_time(short), final_spread(short)]).all()
    apart = run_by_hand([0.0, 3.0], [0.0, 2.5])
    assert np.isinf(alignment_time(apart)).all()
    assert final_spread(apart) == pytest.approx(0.5)
    level = run_by_hand([0.0, 3.0], [0.0, 3.0])
    assert alignment_time(level).tolist() == [0.0]


def test_formation_scenarios_begin_on_the_path():
    for start in (-4.0, 0.0, 3.0):
        scenario = formation_scenario(start)
        leader = scenario.robots[0].start
        y, heading, _ = curve(np.array(start))
        assert leader == pytest.approx((start, y, heading))
        target = scenario.trajectory.at(0.0)  # the references start level, where the followers are
        np.testing.assert_allclose(target.x, 0.0, atol=1e-6)
        np.testing.assert_allclose(target.y, [0.5, 1.5, -0.5], atol=1e-6)
