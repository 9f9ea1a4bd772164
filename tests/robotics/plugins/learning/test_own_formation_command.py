"""``robotics dataset formation`` for a formation of one's own, from its options to a scenario that runs."""

import json

import numpy as np
import pytest

from fuzzy.files.table import read_table
from robotics.commands.application import main
from robotics.plugins.learning.commands_dataset_formation import FormationPlan, formation_text, path_table
from robotics.plugins.learning.datacard import read_card
from robotics.simulation.scenario.description import Member
from robotics.simulation.scenario.reading import load_scenario, parse_scenario
from robotics.world.paths.offset import Offset

FEW = ["--samples", "30", "--displaced", "0", "--seeds", "1", "-q"]


def offset(member: Member) -> tuple[float, float]:
    assert isinstance(member.path, Offset)
    return member.path.offset


def test_a_wedge_of_ones_own_becomes_a_scenario_a_table_and_a_card(tmp_path, capsys):
    data, scenario = tmp_path / "mine.csv", tmp_path / "mine.toml"
    options = ["--path", "circle:radius=2,direction=clockwise", "--followers", "3", "--spacing", "0.5"]
    options += ["--speed", "0.5", "--save-scenario", str(scenario), *FEW, "-o", str(data), "--json"]
    assert main(["dataset", "formation", *options]) == 0
    said = json.loads(capsys.readouterr().out)
    assert (said["robots"], said["rows"], said["inputs"]) == (4, 30, ["leader_ahead", "stretch", "onward_bearing"])
    table = read_table(data)
    names, values = table.names, table.values
    assert list(names) == said["columns"]
    read = load_scenario(scenario)
    assert [offset(member) for member in read.robots] == [(0.0, 0.0), (-0.5, 0.5), (-0.5, -0.5), (-1.0, 1.0)]
    # A point fixed beside the leader of a circle to the right moves on a circle of this radius
    radius = np.hypot(2.0 + np.array([0.0, 0.5, -0.5, 1.0]), [0.0, -0.5, -0.5, -1.0])
    stretch = values[:, [names.index(f"stretch_{i}") for i in (1, 2, 3, 4)]]
    assert stretch == pytest.approx(np.tile(radius / 2.0, (30, 1)), abs=2e-6)
    facts = read_card(tmp_path / "mine.card.md").facts
    assert "--path circle:radius=2,direction=clockwise" in facts["made by"]
    assert facts["noise"] == "posture by pose, position_noise 0.003 m, heading_noise 0.003 rad"
    again = tmp_path / "again.csv"
    assert main(["dataset", "formation", "--scenario", str(scenario), *FEW, "-o", str(again)]) == 0
    assert again.read_bytes() == data.read_bytes()


@pytest.mark.parametrize(
    ("options", "says"),
    [
        (["--kind", "literal", "--followers", "3"], "is of a formation of one's own, --kind of the thesis's"),
        (["--scenario", "x.toml", "--spacing", "1"], "give --scenario or --spacing, not both"),
        (["--followers", "0"], "--followers must be a whole number >= 1 and <= 30; got 0"),
        (["--path", "circel"], "did you mean 'circle'"),
        (["--path", "circle:radius"], "a path is SHAPE:name=value"),
        (["--path", "circle:radius=0.2"], "offset"),
        (["--path", "eight:widht=2"], "did you mean 'width'"),
        (["--arrangement", "wedges"], "--arrangement: 'wedges' is not one of 'wedge', 'abreast'"),
        (["--followers", "2", "--save-scenario", "a.txt"], "must end in .toml"),
    ],
)
def test_options_that_make_no_formation(options, says, tmp_path, capsys):
    assert main(["dataset", "formation", *options, *FEW, "-o", str(tmp_path / "a.csv")]) == 2
    error = capsys.readouterr().err
    assert says in error
    assert "Traceback" not in error
    assert not (tmp_path / "a.csv").exists()


def test_a_path_can_be_that_of_a_file(tmp_path):
    plan = FormationPlan(amplitude=0.4, wavelength=5.0, arrangement="abreast", followers=1)
    text = formation_text(plan)
    (tmp_path / "mine.toml").write_text(text, encoding="utf-8")
    sine = path_table(str(tmp_path / "mine.toml"))
    assert sine == {"shape": "sine", "amplitude": 0.4, "wavenumber": pytest.approx(2 * np.pi / 5), "x_end": 10.0}
    assert formation_text(FormationPlan(path=str(tmp_path / "mine.toml"), followers=1))
    made = parse_scenario(text, "mine")
    assert offset(made.robots[1]) == (0.0, 0.6)
    assert made.duration > made.setting.references.ends.max()
