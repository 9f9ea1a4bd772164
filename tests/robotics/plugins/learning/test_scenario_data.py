"""Formation data from a scenario, their card, and networks learnt from them that drive it."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.special import expit

import anfis
from fuzzy.errors import InputError
from robotics.laws.catalogue import make_controller
from robotics.measures.formations import largest_place_error
from robotics.measures.outside import outside
from robotics.plugins.learning.datacard import read_card, robot_facts, write_set
from robotics.plugins.learning.formationlearning import (
    FormationLearningError,
    learn_networks,
    outputs_of,
    write_networks,
)
from robotics.plugins.learning.scatter import scatter
from robotics.plugins.learning.scenariodata import (
    ScenarioRecipe,
    checking_set,
    default_inputs,
    passes,
    scenario_data,
)
from robotics.simulation.loop import simulate
from tests.robotics.laws.rules.formations import RADII, circling

SMALL = ScenarioRecipe(samples=400, runs=1, places=6, starts=4, span=2.0)


@pytest.fixture(scope="module")
def table():
    return scenario_data(circling(duration=8.0), SMALL)


def test_columns_are_named_by_robot_and_say_what_they_are(table):
    assert table.names[:5] == ("leader_ahead_1", "stretch_1", "onward_bearing_1", "v_1", "w_1")
    assert table.names[5:10] == tuple(name[:-1] + "2" for name in table.names[:5])
    assert tuple(c.unit for c in table.columns[:5]) == ("m", "1", "rad", "m/s", "rad/s")
    assert table.values.shape == (400, 15)
    assert (table.values == np.round(table.values, 6)).all()


def test_rows_are_the_law_of_its_own_inputs(table):
    """S(d) with the logistic function of scipy, and pure pursuit; robots within their limits."""
    for robot, radius in enumerate(RADII):
        lead, stretch, bearing, v, w = table.values[:, 5 * robot : 5 * robot + 5].T
        behind, ahead, rate = (1.5, 0.0, 2.0) if robot == 0 else (0.25, 1.75, 4.0)
        q = (ahead - 1) / (1 - behind)
        wanted = 0.2 * radius / RADII[0] * (behind + (ahead - behind) * expit(rate * lead - np.log(q)))
        assert stretch == pytest.approx(radius / RADII[0], abs=1e-6)
        assert v == pytest.approx(wanted, abs=2e-6)
        assert w == pytest.approx(2 * wanted * np.sin(bearing) / 0.3, abs=2e-5)
        assert np.ptp(lead) > 0.4  # as displaced robots have it
        assert np.ptp(bearing) > 0.4


def test_the_same_recipe_gives_the_same_rows_and_the_checking_set_others(table):
    again = scenario_data(circling(duration=8.0), SMALL)
    assert np.array_equal(again.values, table.values)
    check = checking_set(SMALL)
    assert set(check.seeds).isdisjoint(SMALL.seeds)
    held = scenario_data(circling(duration=8.0), check)
    assert len(held.values) == 100
    assert not (held.values[:, None, :5] == table.values[None, :, :5]).all(axis=2).any()


def test_any_teacher_that_commands_velocities():
    assert default_inputs("lyapunov") == ("x_err", "y_err", "heading_err", "target_v", "target_w")
    called = []
    recipe = replace(SMALL, teacher="lyapunov", samples=60, places=2)
    found = scenario_data(circling(duration=4.0), recipe, lambda: called.append(1))
    assert len(called) == passes(recipe) == 3
    x, y, turned, v_d, w_d, v, w = found.values[:, :7].T
    kx, ky, kpsi = 1.0, 10.0, 5.0  # (2.30) with the package's gains
    assert v == pytest.approx(v_d * np.cos(turned) + kx * x, abs=1e-4)
    assert np.ptp(y) > 0.05
    assert w_d == pytest.approx(0.2 / RADII[0], abs=1e-6)
    assert np.isfinite(w).all()
    assert ky > kpsi


@pytest.mark.parametrize(
    ("changes", "says"),
    [
        ({"teacher": "csm"}, "csm commands torques"),
        ({"inputs": ("gap",)}, "gap is told of each other robot; .* such as robot1_gap"),
        ({"inputs": ("robot7_gap",)}, "robot7_gap is of robot 7, and the scenario has 3"),
        ({"inputs": ("leader_ahaed",)}, "did you mean 'leader_ahead'"),
        ({"inputs": ("stretch", "stretch")}, "each quantity once"),
        ({"samples": 1}, "samples must be a whole number >= 2"),
        ({"displaced": 1.2}, "displaced must be a finite number, >= 0 and <= 1"),
        ({"runs": 0}, "displaced must be 1"),
    ],
)
def test_what_cannot_be_made_is_said(changes, says):
    with pytest.raises(InputError, match=says):
        scenario_data(circling(duration=2.0), replace(SMALL, **changes))


def test_the_card_says_what_is_in_the_file(table, tmp_path):
    scenario = circling(duration=8.0)
    facts = robot_facts(scenario, SMALL, "robotics dataset formation | made by hand")
    path = write_set(tmp_path / "a.csv", facts, table.columns, table.values)
    assert path == tmp_path / "a.card.md"
    card = read_card(path)
    assert card.facts["rows"] == "400"
    assert card.facts["made by"] == "robotics dataset formation | made by hand"
    assert card.facts["teacher"] == "leader-follower: speed = 0, leader_rate = 2, rate = 4"
    assert card.facts["seeds"].startswith("runs from the scenario's starts: 0 to 0; displaced: 1 to 24")
    assert list(card.columns) == list(table.names)
    for name, column in zip(table.names, table.values.T, strict=True):
        said = card.columns[name]
        for word, number in (("min", column.min()), ("max", column.max()), ("mean", column.mean())):
            assert float(said[word]) == pytest.approx(number, rel=1e-5, abs=1e-12)
        assert said["role"] == ("output" if name[0] in "vw" else "input")
    rms = scatter(table.values[:, 10:13], table.values[:, 13:]).rms
    assert card.columns["w_3"]["scatter at equal inputs"] == f"{rms[1]:.2g} rad/s"
    assert card.columns["stretch_1"]["scatter at equal inputs"] == ""


@pytest.mark.long
def test_networks_of_a_scenario_drive_it(table, tmp_path):
    networks = learn_networks(table.names, table.values[::2], rules=4, options=anfis.Options(epochs=5))
    assert [n.output for n in networks] == ["v_1", "w_1", "v_2", "w_2", "v_3", "w_3"]
    assert [v.name for v in networks[2].after.inputs] == ["leader_ahead"]  # on a circle the stretch says nothing
    assert [v.name for v in networks[3].after.inputs] == ["leader_ahead", "onward_bearing"]
    assert networks[3].after.inputs[1].universe == (table.values[::2, 7].min(), table.values[::2, 7].max())
    write_networks(networks, tmp_path / "nets", "a.csv")
    assert "turn rate w_2 of robot 2, learnt from a.csv" in (tmp_path / "nets" / "w_2.fis").read_text(encoding="utf-8")
    run = simulate(circling(second=0.05), make_controller(f"formation:networks={tmp_path / 'nets'}"))
    assert largest_place_error(run).max() < 0.02
    assert outside(run) == []


def test_tables_without_robots_are_refused():
    assert outputs_of(["a_1", "v_1", "w_1"]) == ("v_1", "w_1")
    with pytest.raises(FormationLearningError, match="or the outputs v_1, w_1"):
        outputs_of(["a_1", "v_1", "w_1", "v_3", "w_3"])
    with pytest.raises(FormationLearningError, match="v_1 has no inputs"):
        learn_networks(["a_2", "v_1", "w_1"], np.ones((20, 3)))
