"""Networks of single robots against their own formulas, and the thesis's four as before."""

from dataclasses import replace
from importlib import resources

import numpy as np
import pytest

from fuzzy.files.fisfile import write_fis
from fuzzy.membership import Gaussian
from fuzzy.system import Linear, Sugeno, Variable
from robotics.laws.catalogue import make_controller
from robotics.laws.formation.leader_follower import LeaderFollower
from robotics.laws.law import ControllerError
from robotics.laws.rules.formation_networks import FormationNetworks
from robotics.measures.explained import explain_decision
from robotics.measures.outside import is_of_data, outside, outside_sentence
from robotics.simulation.loop import simulate
from robotics.simulation.scenario.reading import load_scenario
from tests.robotics.laws.rules.formations import RADII, circling

SPEED = 0.2  # m/s


def network(output, inputs, slopes, constant, low=-1.0, high=1.0):
    """One rule, so that the output is a plane: constant + slopes · inputs."""
    variables = [Variable(name, (low, high), {"any": Gaussian(1.0, 0.0)}) for name in inputs]
    said = Variable(output, (-2, 2), {"plane": Linear(tuple(slopes), constant)})
    rule = "if " + " and ".join(f"{name} is any" for name in inputs) + f" then {output} is plane"
    return Sugeno(variables, [said], [rule], name=output, out_of_range="clip")


def team(reach=1.0):
    """For three robots: v = ratio (0.2 ± lead), and ω = 2 v β/0.3 at that speed."""
    found = []
    for i, radius in enumerate(RADII, start=1):
        ratio, sign = radius / RADII[0], -1.0 if i == 1 else 1.0
        found.append(network(f"v_{i}", ["leader_ahead"], [0.3 * sign * ratio], SPEED * ratio, -reach, reach))
        found.append(network(f"w_{i}", ["onward_bearing"], [2 * SPEED * ratio / 0.3], 0.0))
    return tuple(found)


def test_each_robot_is_driven_by_its_own_two():
    run = simulate(circling(second=0.05), FormationNetworks(networks=team()[::-1]), (1,))  # in any order
    assert list(run.about.rule_bases) == ["v_1", "w_1", "v_2", "w_2", "v_3", "w_3"]
    inputs = run.inputs[:, :, 0]  # (samples, inputs, robots)
    for row in range(6):
        robot = row // 2
        others = [i for i in range(3) if i != robot]
        assert np.isnan(inputs[:, row][:, others]).all()
        own, ratio = inputs[:, row, robot].astype(float), RADII[robot] / RADII[0]
        if row % 2:
            assert run["command_2"][0, robot] == pytest.approx(2 * SPEED * ratio / 0.3 * own, abs=1e-6)
        else:
            wanted = ratio * (SPEED + (-0.3 if robot == 0 else 0.3) * own)
            assert run["command_1"][0, robot] == pytest.approx(wanted, abs=1e-6)
    assert inputs[0, 2, 1] == pytest.approx(-0.05 * RADII[0], abs=1e-5)  # robot 1 is behind what is level with robot 2
    assert inputs[0, 0, 0] == pytest.approx(-0.05 * RADII[0] / 2, abs=1e-5)  # and behind the mean of the others
    assert abs(inputs[-1, 2, 1]) < 0.01


def test_sets_that_do_not_suit_are_refused(tmp_path):
    two = FormationNetworks(networks=team()[:4])
    with pytest.raises(ControllerError, match="circling has 3 robots, and these networks drive 2: v_1, w_1, v_2, w_2"):
        two.init(circling().setting, 1)
    for fis in team()[1:]:
        write_fis(fis, tmp_path / f"{fis.name}.fis")
    with pytest.raises(ControllerError, match=r"each robot needs the networks v and w; got .*: v_1 missing"):
        make_controller(f"formation:networks={tmp_path}")
    write_fis(team()[0], tmp_path / "v_1.fis")
    law = make_controller(f"formation:networks={tmp_path}")
    assert isinstance(law, FormationNetworks)
    assert law.robots == 3
    assert law.idle == {"correction", "look_ahead", "ky", "kpsi"}
    with pytest.raises(ControllerError, match=r"gap is told of each other robot; .* such as robot1_gap"):
        FormationNetworks(networks=(network("v_1", ["gap"], [0.0], 0.1), *team()[1:]))
    with pytest.raises(ControllerError, match="did you mean 'leader_ahead'"):
        FormationNetworks(networks=(network("v_1", ["leader_ahed"], [0.0], 0.1), *team()[1:]))
    other = law.with_fuzzy_system("formation", network("v_2", ["stretch"], [0.0], 0.1))
    assert [v.name for v in other.fuzzy_systems["v_2"].inputs] == ["stretch"]


def test_what_is_told_by_radio_makes_robots_tell_it():
    networks = (*team()[:2], network("v_2", ["robot1_ahead"], [0.1], 0.2), *team()[3:])
    law = FormationNetworks(networks=networks)
    assert law.message
    assert not FormationNetworks(networks=team()).message
    run = simulate(circling(duration=3.0), law)
    place = list(run.about.rule_bases).index("v_2")
    x, y, heading = run["x"][0], run["y"][0], run["heading"][0, 1]
    ahead = np.cos(heading) * (x[0] - x[1]) + np.sin(heading) * (y[0] - y[1])
    assert run.inputs[5:, place, 0, 1] == pytest.approx(ahead[5:], abs=2e-3)  # told a period ago, and predicted


def test_the_thesis_four_drive_as_before_to_the_last_bit():
    scenario = replace(load_scenario("formation-ahead"), duration=20.0)
    now = simulate(scenario, make_controller("formation"), (3,))
    before = simulate(scenario, LeaderFollower(), (3,))
    assert np.array_equal(now.samples, before.samples)
    assert list(now.about.rule_bases) == ["v_l", "w_l", "v_f", "w_f"]
    assert now.inputs is not None
    assert now.inputs[0, 0, 0, 0] == pytest.approx(now["x"][0, 0, 0] - now["x"][0, 1:, 0].mean())  # dx
    assert np.isnan(now.inputs[0, 0, 0, 1:]).all()  # v_l tells the followers nothing


def test_a_run_outside_the_data_says_so_once(tmp_path, capsys):
    from robotics.commands.application import main

    inside = simulate(circling(second=0.05), FormationNetworks(networks=team()))
    assert outside(inside) == []
    run = simulate(circling(second=0.05), FormationNetworks(networks=team(reach=0.06)), name="mine")
    found = outside(run)
    assert [(one.task, one.robot) for one in found] == [("v_2", 2)]  # the leader is 0.05 m behind the mean
    values = run.inputs[:, 2, 0, 1].astype(float)
    assert found[0].farthest == pytest.approx(values.min())
    assert found[0].share == pytest.approx((values < -0.06 - 0.0012).mean())
    assert "leader_ahead of robot 2 (v_2) came to -0.1, its range is -0.06 to 0.06" in outside_sentence(found)
    for fis in team(reach=0.06):
        write_fis(fis, tmp_path / f"{fis.name}.fis")
    text = (resources.files("robotics") / "data" / "scenarios" / "formation-behind.toml").read_text(encoding="utf-8")
    short = tmp_path / "short.toml"  # the leader is 3 m behind
    short.write_text(text.replace("duration = 100.0", "duration = 2.0"), encoding="utf-8")
    assert main(["run", str(short), "-c", f"formation:networks={tmp_path}", "-q"]) == 0
    said = capsys.readouterr().err
    assert said.count("left the data that it knows") == 1


def test_designed_rule_bases_may_be_left():
    law = make_controller("fuzzy-team")
    known = [is_of_data(v) for system in law.fuzzy_systems.values() for v in system.inputs]
    assert len(known) > 10
    assert not any(known)
    assert all(is_of_data(v) for fis in make_controller("formation").fuzzy_systems.values() for v in fis.inputs)


def test_a_robot_is_explained_by_its_own_networks():
    run = simulate(circling(duration=2.0), FormationNetworks(networks=team()))
    assert list(explain_decision(run, 2, 1.0).rule_bases) == ["v_2", "w_2"]
