"""The page docs/howto/own-formation.md: its commands run as written, and six robots drive together as it says."""

import json
import shutil
from pathlib import Path

import pytest

import robotics
from robotics.commands.application import main
from tests.snippets import run_commands, snippets

DOCS = Path(__file__).parent.parent / "docs"
EXAMPLE = DOCS / "examples" / "wedge-on-eight"


@pytest.mark.long
def test_a_wedge_on_an_eight_is_learnt_by_the_page_and_keeps_within_three_centimetres(tmp_path, monkeypatch, capsys):
    """Noise of 3 mm and 3 mrad, the dynamic plant, 20 seeds; from 10 s on."""
    shutil.copytree(EXAMPLE, tmp_path, dirs_exist_ok=True)
    monkeypatch.chdir(tmp_path)
    found = snippets(DOCS / "howto" / "own-formation.md", changed=False)
    assert [kind for kind, _ in found] == ["sh"] * 4
    for _, text in found:
        run_commands(text)
    assert "Traceback" not in capsys.readouterr().err
    assert len(robotics.load_scenario("mine.toml").robots) == 6
    assert {f.name for f in Path("networks").iterdir()} == {f"{name}_{n}.fis" for name in "vw" for n in range(1, 7)}
    pictures = Path("page.html").read_text(encoding="utf-8").count("data:image/")
    assert pictures == 12 * 3 + 2  # of each network, of the data and of the drive
    for data in ("mine", "wedge", "check"):
        assert Path(f"{data}.card.md").is_file()
    learnt = ["run", "wedge-on-eight.toml", "-c", "formation:networks=networks", "--seeds", "20", "--json", "-q"]
    assert main(learnt) == 0
    said = json.loads(capsys.readouterr().out)
    assert max(map(max, said["metrics"]["max_place_error_m"])) < 0.03
    assert max(map(max, said["metrics"]["rms_place_error_m"])) < 0.01
    assert not any(map(any, said["metrics"]["contacts"]))
    assert said["outside"] == []


@pytest.mark.long
def test_robots_abreast_learn_from_a_law_of_tracking(tmp_path, monkeypatch, capsys):
    """A circle, two followers, another teacher, from options to the drive; small, so that it is quick."""
    monkeypatch.chdir(tmp_path)
    options = "--path circle:radius=2 --followers 2 --arrangement abreast --spacing 0.5 --speed 0.2 --teacher lyapunov"
    made = f"dataset formation {options} --samples 150 --save-scenario ring.toml -o ring.csv"
    assert main(made.split()) == 0
    header = Path("ring.csv").read_text(encoding="utf-8").partition("\n")[0].split(",")
    assert [name for name in header if name[-1] == "3"] == [
        *("x_err_3", "y_err_3", "heading_err_3", "target_v_3", "target_w_3", "v_3", "w_3")
    ]
    assert main(["learn", "formation", "ring.csv", "-o", "nets", "--rules", "4", "--epochs", "5", "-q"]) == 0
    capsys.readouterr()
    assert main(["run", "ring.toml", "-c", "formation:networks=nets", "--json", "-q"]) == 0
    said = json.loads(capsys.readouterr().out)
    assert max(map(max, said["metrics"]["rms_cross_track_m"])) < 0.05
