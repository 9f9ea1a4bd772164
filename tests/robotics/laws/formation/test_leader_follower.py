"""The leader-follower law and networks in closed loop, on the full plant."""

from dataclasses import replace
from types import SimpleNamespace
from typing import Any, get_args

import numpy as np
import pytest

from fuzzy.files.fisfile import write_fis
from fuzzy.fitting.clustering import ClusteringOptions, subtractive_clusters
from fuzzy.membership import Gaussian
from fuzzy.rule import Clause, Rule
from fuzzy.system import Linear, Sugeno, Terms, Variable
from robotics.laws.catalogue import CATALOGUE, gains_of, make_controller
from robotics.laws.formation.leader_follower import (
    FormationTeacher,
    LeaderFollower,
    bearings,
    correction,
    law,
    lead,
    literal_speed,
    pace,
)
from robotics.laws.law import ControllerError
from robotics.laws.setting import Kind
from robotics.measures.formations import alignment_time, final_spread, last_samples, lateral_error
from robotics.plugins.learning.formationdata import FormationRecipe, formation_data
from robotics.plugins.learning.formations import leader_path
from robotics.simulation.loop import simulate
from robotics.simulation.scenario.reading import load_scenario, scenario_names
from robotics.studies.comparison import compare
from robotics.world.paths.path import Circle, Line, compile_path
from robotics.world.sensing.posture import Sensing

PATH = compile_path(leader_path())


def test_lead_is_over_the_followers_mean():
    assert lead(np.array([[3.0, 0.0, 1.0], [0.0, 1.0, 1.0]])).tolist() == [2.5, -1.0]


def test_beside_is_the_point_with_that_x():
    x = np.array([[-4.0, -1.0], [0.5, np.pi]])
    point = PATH.beside(x)
    np.testing.assert_allclose(point.x, x, atol=1e-9)
    np.testing.assert_allclose(point.y, 0.5 * np.cos(np.maximum(x, 0)), atol=1e-9)
    assert point.curvature[1, 1] == pytest.approx(0.5, abs=1e-5)
    assert PATH.beside(np.array(99.0)).x == pytest.approx(2 * np.pi)


def test_pace_runs_between_its_limits_through_1():
    dx = np.linspace(-1e4, 1e4, 20001)
    for behind, ahead, rate in ((3.0, 0.0, 1.5), (0.5, 1.2, 1.2)):
        values = pace(dx, behind, ahead, rate)  # no overflow, which would be an error here
        assert (values[0], values[-1]) == (behind, ahead)
        assert pace(np.zeros(1), behind, ahead, rate)[0] == pytest.approx(1.0, abs=1e-15)
        assert (np.diff(values) * (ahead - behind) >= 0).all()
    # half way between the limits where q e^(−r dx) = 1
    assert pace(np.array([-np.log(2) / 1.5]), 3.0, 0.0, 1.5)[0] == pytest.approx(1.5)


def test_law_by_hand():
    dx = np.array([-3.0, 0.0, 3.0])
    wish = law(dx, np.array([0.0, np.pi / 6, -np.pi / 6]), np.array([0.2, -0.5, 0.4]), 0.1, 0.5)
    np.testing.assert_allclose(wish.v_l, 0.3 / (1 + 2 * np.exp([-4.5, 0.0, 4.5])))
    np.testing.assert_allclose(wish.v_f, 0.05 + 0.07 / (1 + 0.4 * np.exp([3.6, 0.0, -3.6])))
    np.testing.assert_allclose(wish.w_l, [0.0, 0.1 / 0.5, -wish.v_l[2] / 0.5])  # 2 sin 30° = 1
    np.testing.assert_allclose(wish.w_f, [0.2 * wish.v_f[0], -0.05, 0.4 * wish.v_f[2]])


def test_bearing_of_the_path_ahead():
    straight = compile_path(Line(start=(0.0, 0.0), end=(4.0, 3.0)))  # its direction is atan(3/4)
    x, y = np.array([0.8, 0.8 - 0.06, 4.0]), np.array([0.6, 0.6 + 0.08, 3.0])
    slope = np.arctan2(3, 4)
    # On it; 0.1 m to the left, where the point with the same x lies 0.075 m further back; at its end, which goes on
    expected = [-0.2, np.arctan2(-0.1, 0.5 - 0.1 * 0.75), 0.1]
    found = bearings(straight, x, y, slope + np.array([0.2, 0.0, -0.1]), 0.5)
    np.testing.assert_allclose(found, expected, atol=1e-6)
    # A chord of a circle of radius 1 leaves the tangent by half the angle of its arc, whatever the turns of the heading
    arc = compile_path(Circle(center=(0.0, 1.0), start_angle=-np.pi / 2, turns=0.2))
    angle = 0.3
    found = bearings(arc, np.array([np.sin(angle)]), np.array([1 - np.cos(angle)]), np.array([angle + 2 * np.pi]), 0.5)
    assert found[0] == pytest.approx(0.25, abs=1e-5)


def test_correction_turns_back_to_the_path():
    path = PATH.beside(np.array(np.pi))
    y, heading = float(path.y), float(path.heading)
    for at, turned, ky, kpsi, wanted in [
        (-0.4, 0.0, 4.0, 0.0, -0.04),  # left of it: to the right
        (-0.5, 0.1 + 2 * np.pi, 4.0, 0.8, -0.08),
    ]:
        robot, gain = SimpleNamespace(y=at, heading=turned), SimpleNamespace(ky=ky, kpsi=kpsi)
        turn = getattr(correction, "py_func", correction)(robot, y, heading, 0.1, gain)
        assert turn == pytest.approx(wanted)


def test_literal_speeds_are_those_of_5_2_1():
    starts = (-4.0, -2.0, 0.0, 2.0, 4.0)
    np.testing.assert_allclose([literal_speed(dx, False, 0.1) for dx in starts], [0.3, 0.2, 0.1, 0.0, 0.0])
    np.testing.assert_allclose([literal_speed(dx, True, 0.1) for dx in starts], 0.1)


def aligned_by_hand(start):
    """The time [s] from which |dx| < 0.1 m, by Euler's method: points on y = 0.5 cos x that have the law's speeds."""
    x_l, x_f, last, step = start, 0.0, 0.0, 0.05
    for k in range(4000):
        dx = x_l - x_f
        if x_l >= 2 * np.pi:
            break
        last = k * step if abs(dx) >= 0.1 else last
        share_l, share_f = (1 / np.sqrt(1 + (0.5 * np.sin(max(x, 0.0))) ** 2) for x in (x_l, x_f))
        x_l += step * 0.3 / (1 + 2 * np.exp(1.5 * dx)) * share_l
        x_f += step * (0.05 + 0.07 / (1 + 0.4 * np.exp(-1.2 * dx))) * share_f
    return last


@pytest.mark.parametrize(("name", "start"), [("formation-behind", -3.0), ("formation-ahead", 3.0)])
@pytest.mark.parametrize("own", ["none", "own-pose"])
def test_teacher_does_both_experiments(name, start, own):
    aligned = aligned_by_hand(start)
    run = simulate(load_scenario(name), FormationTeacher(correction=own))
    assert not run.diverged.any()
    assert alignment_time(run)[0] == pytest.approx(aligned, abs=0.5)
    assert final_spread(run)[0] < 0.02
    lateral = lateral_error(run)[0]
    assert lateral[0] < 0.013  # pure pursuit cuts the corner where the curvature jumps, by κ' L³/6 elsewhere
    assert lateral[1:].max() < (0.04 if own == "none" else 0.01)
    over = int(np.argmax(run["x"][0, 0] >= 2 * np.pi))
    assert 0 <= over - last_samples(run)[0] <= 3
    assert (run["command_1"][0, :, over:] == 0).all()  # all stand still at the end
    assert (run["command_1"][0, :, over - 1] > 0).all()


def test_leader_hurries_from_behind_and_waits_in_front():
    behind = simulate(load_scenario("formation-behind"), FormationTeacher())
    assert behind["v"][0, 0].max() == pytest.approx(0.3, abs=0.02)
    assert behind["v"][0, 1][20:60].max() < 0.06  # the followers slow down
    ahead = simulate(load_scenario("formation-ahead"), FormationTeacher())
    assert np.abs(ahead["x"][0, 0][: 10 * 20] - 3.0).max() < 0.05  # it creeps while they come
    assert ahead["v"][0, 1][20:200].mean() == pytest.approx(0.117, abs=0.003)


def least_squares_systems():
    """A first-order system for each output of the well-posed data: clusters, then one lstsq; no learning."""
    table = formation_data(FormationRecipe(kind="well-posed"))
    x, systems = table.values[:, : len(table.inputs)], []
    for j, name in enumerate(table.names[len(table.inputs) :], start=len(table.inputs)):
        z = table.values[:, j]
        found = subtractive_clusters(
            np.column_stack([x, z]), 0.5, options=ClusteringOptions(squash=0.8, accept=0.5, reject=0.1)
        )
        c, sigma = found.centers[:, :-1], found.sigma[:-1]
        w = np.exp(-(((x[:, None] - c) / sigma) ** 2).sum(-1) / 2)
        w /= w.sum(1, keepdims=True)
        design = (w[..., None] * np.column_stack([x, np.ones(len(x))])[:, None]).reshape(len(x), -1)
        p = np.linalg.lstsq(design, z, rcond=None)[0].reshape(len(c), -1).tolist()
        inputs = [
            Variable(
                n,
                (x[:, i].min(), x[:, i].max()),
                Terms([(f"{name}{r}", Gaussian(sigma[i], m)) for r, m in enumerate(c[:, i])]),
            )
            for i, n in enumerate(table.inputs)
        ]
        terms = Terms([(f"{name}{r}", Linear(row[:-1], row[-1])) for r, row in enumerate(p)])
        rules = [
            Rule(tuple(Clause(v.name, f"{name}{r}") for v in inputs), ((name, f"{name}{r}"),)) for r in range(len(c))
        ]
        systems.append(Sugeno(inputs, [Variable(name, (z.min(), z.max()), terms)], rules, name=name))
    return systems


def together(systems):
    """The same in one system with four outputs; every rule speaks for one of them."""
    inputs = [
        Variable(v.name, v.universe, Terms([t for fis in systems for t in fis.inputs[i].terms.items()]))
        for i, v in enumerate(systems[0].inputs)
    ]
    return Sugeno(inputs, [fis.outputs[0] for fis in systems], [r for fis in systems for r in fis.rules], name="all")


@pytest.fixture(scope="module")
def networks(tmp_path_factory):
    folder = tmp_path_factory.mktemp("networks")
    systems = least_squares_systems()
    for fis in systems:
        write_fis(fis, folder / f"{fis.name}.fis")
    write_fis(together(systems), folder / "all.fis")
    return folder


def test_identified_networks_do_both_experiments(networks):
    """With each follower corrected by its own pose; bounds are those set for trained networks of 8 rules."""
    law = make_controller(f"formation:networks={networks},correction=own-pose")
    for name, latest in (("formation-behind", 32.0), ("formation-ahead", 50.0)):
        run = simulate(load_scenario(name), law)
        assert alignment_time(run)[0] <= latest, name
        assert final_spread(run)[0] <= 0.03, name
        lateral = lateral_error(run)[0]
        assert lateral[0] <= 0.10, name
        assert lateral[1:].max() <= 0.03, name


@pytest.mark.parametrize(("name", "latest"), [("formation-behind", 32.0), ("formation-ahead", 50.0)])
def test_packaged_networks_do_both_experiments_within_the_limits(name, latest):
    """Chapters 5-6, I, of 20 seeds with 3 mm and 3 mrad of posture noise, which the scenarios do not have."""
    sensing = Sensing(posture="pose", position_noise=0.003, heading_noise=0.003)
    run = simulate(replace(load_scenario(name), sensing=sensing), make_controller("formation"), range(20))
    assert alignment_time(run).max() <= latest
    assert final_spread(run).max() <= 0.03
    lateral = lateral_error(run)
    assert lateral[:, 0].max() <= 0.02
    assert lateral[:, 1:].max() <= 0.003


def wider(path):
    return replace(path, amplitude=0.6, wavenumber=0.9)


def test_packaged_networks_bring_a_displaced_leader_back_and_know_no_curve():
    """0.3 m beside its path, which no sample was; and along another sine than that of the data."""
    scenario = load_scenario("formation-behind")
    leader = replace(scenario.robots[0], start=(-3.0, 0.8, 0.5))
    run = simulate(replace(scenario, robots=(leader, *scenario.robots[1:])), make_controller("formation"))
    assert alignment_time(run)[0] <= 35
    assert np.abs(run["y"][0, 0, run["x"][0, 0] > -1.0] - np.asarray(0.5)).min() < 0.01
    other = tuple(replace(m, start=(m.start[0], m.start[1] + 0.1, 0.0), path=wider(m.path)) for m in scenario.robots)
    run = simulate(replace(scenario, robots=other), make_controller("formation"))
    assert alignment_time(run)[0] <= 35
    assert lateral_error(run)[0].max() <= 0.02


def test_open_loop_followers_leave_their_paths_but_stay_level(networks):
    run = simulate(load_scenario("formation-behind"), LeaderFollower(networks=str(networks), correction="none"))
    assert alignment_time(run)[0] <= 35
    assert final_spread(run)[0] <= 0.06
    lateral = lateral_error(run)[0]
    assert lateral[0] <= 0.15
    corrected = simulate(load_scenario("formation-behind"), LeaderFollower(networks=str(networks)))
    assert 2 * lateral_error(corrected)[0, 1:].max() < lateral[1:].max() <= 0.7  # what the correction is for
    assert lateral[1] == pytest.approx(lateral[2], abs=0.02)  # both get the same command


def test_noise_on_every_posture(networks):
    sensing = Sensing(posture="pose", position_noise=0.003, heading_noise=0.003)
    scenario = replace(load_scenario("formation-behind"), sensing=sensing)
    run = simulate(scenario, LeaderFollower(networks=str(networks)), seeds=(1, 2))
    assert (alignment_time(run) <= 35).all()
    assert (final_spread(run) <= 0.06).all()
    alone = simulate(scenario, LeaderFollower(networks=str(networks)), seeds=(2,))
    np.testing.assert_array_equal(alone.samples[:, :, 0], run.samples[:, :, 1])


def test_one_file_and_four_are_the_same(networks):
    short = replace(load_scenario("formation-ahead"), duration=20.0)
    four = simulate(short, LeaderFollower(networks=str(networks)))
    one = simulate(short, LeaderFollower(networks=str(networks / "all.fis")))
    np.testing.assert_allclose(one.samples, four.samples, atol=1e-9)


def test_wrong_networks_say_what_is_wrong(networks, tmp_path):
    with pytest.raises(ValueError, match="nowhere"):
        make_controller("formation:networks=nowhere")
    with pytest.raises(ControllerError, match="the outputs of formation networks are v_l, w_l, v_f, w_f; got v_l"):
        LeaderFollower(networks=str(networks / "v_l.fis"))
    with pytest.raises(ControllerError, match="tracking: unknown formation input 'distance'"):
        LeaderFollower(networks="tracking")
    with pytest.raises(ValueError, match=r"v_l\.fis"):
        LeaderFollower(networks=str(tmp_path))
    with pytest.raises(ControllerError, match="correction must be one of 'own-pose', 'none'"):
        make_controller("formation:correction=all")
    with pytest.raises(ControllerError, match="reference: a formation needs a leader and followers"):
        simulate(load_scenario("reference"), FormationTeacher())
    circle = load_scenario("lyapunov-circle")
    with pytest.raises(ControllerError, match="robot 1: x must grow along the path"):
        simulate(replace(circle, robots=circle.robots * 2), FormationTeacher())


def test_presets_and_gains():
    assert {n for n, p in CATALOGUE.items() if p.kind == "formation"} == {
        "formation",
        "formation-teacher",
        "leader-follower",
    }
    assert gains_of(make_controller("formation-teacher:ky=5"))["ky"] == 5.0
    assert "ky" not in gains_of(make_controller("formation:correction=none"))
    law: Any = make_controller("formation")
    assert law.correction == "own-pose"


def test_formation_scenarios_are_told_apart():
    assert scenario_names("formation") == ["formation-ahead", "formation-behind"]
    assert sorted(n for kind in get_args(Kind) for n in scenario_names(kind)) == scenario_names()
    starts = {n: [m.start for m in load_scenario(n).robots] for n in scenario_names("formation")}
    followers = [(0.0, 1.5, 0.0), (0.0, -0.5, 0.0)]
    assert starts["formation-behind"] == [(-3.0, 0.5, 0.0), *followers]  # thesis 5.2.3
    assert starts["formation-ahead"] == [(3.0, -0.5, 0.0), *followers]


def test_a_tracking_controller_can_drive_a_formation_scenario():
    """Each robot then tracks its own reference: what a comparison with names gives."""
    short = replace(load_scenario("formation-behind"), duration=5.0)
    table = compare([short], ["lyapunov", "formation-teacher"], [0]).table
    assert len(table) == 6
    assert not table["diverged"].any()
