"""The commands scenario, new and check."""

import json
from pathlib import Path

import pytest

from robotics.commands.application import main
from robotics.simulation.scenario.reading import load_scenario


def test_explain_prints_keys_as_text_and_json(capsys):
    assert main(["scenario", "--explain", "robots.timing.speed"]) == 0
    out = capsys.readouterr().out
    assert "m/s, > 0" in out
    assert "[robots.timing] speed = 0.3" in out
    assert main(["scenario", "--explain", "timing", "--json"]) == 0
    rows = {row["key"]: row for row in json.loads(capsys.readouterr().out)["keys"]}
    assert rows["robots.timing.ramp"]["unit"] == "s"
    assert main(["scenario", "--explain"]) == 0
    assert "burst_loss" in capsys.readouterr().out
    assert main(["scenario", "sped"]) == 2
    assert "did you mean 'speed'" in capsys.readouterr().err


def test_the_schema_is_one_json_document(capsys):
    assert main(["scenario", "--schema", "sweep"]) == 0
    printed = capsys.readouterr()
    assert json.loads(printed.out)["properties"]["seeds"]["minimum"] == 1
    assert "#:schema ./sweep.schema.json" in printed.err
    assert main(["scenario", "--schema", "swep"]) == 2
    assert "did you mean 'sweep'" in capsys.readouterr().err


def test_a_new_file_is_checked_and_never_overwritten_unasked(tmp_path, capsys):
    file = tmp_path / "mine.toml"
    assert main(["new", "scenario", "--kind", "team", "--minimal", "-o", str(file)]) == 0
    assert len(load_scenario(file).robots) == 3
    before = file.read_bytes()
    assert main(["new", "scenario", "-o", str(file)]) == 2
    assert file.read_bytes() == before
    assert "--force" in capsys.readouterr().err
    assert main(["new", "scenario", "--kind", "teem", "-o", str(tmp_path / "x.toml")]) == 2
    assert main(["check", str(file)]) == 0
    assert "nothing found" in capsys.readouterr().out


def test_check_tells_all_draws_and_exits_with_one(tmp_path, capsys):
    file, picture = tmp_path / "mine.toml", tmp_path / "mine.png"
    file.write_text(
        "duration = 20.0\nlatncy = 0.1\n[[robots]]\nstart = [0.0, 0.0, 0.0]\n"
        'path = { shape = "line", start = [0.0, 0.0], end = [5.0, 0.0] }\ntiming = { speed = 2.0 }\n',
        encoding="utf-8",
    )
    assert main(["check", str(file), "-o", str(picture)]) == 1
    out = capsys.readouterr().out
    assert f"{file}:2: unknown key 'latncy'; did you mean 'latency'?" in out
    assert f"{file}:6: robot 1: the reference is infeasible" in out
    assert picture.read_bytes().startswith(b"\x89PNG")
    assert main(["check", str(file), "--json"]) == 1
    made = json.loads(capsys.readouterr().out)
    assert not made["ok"]
    assert [f["line"] for f in made["findings"]][:2] == [2, 6]


@pytest.mark.parametrize("text", ["duration = ", None])
def test_what_is_no_toml_is_an_error_of_usage(tmp_path: Path, capsys, text):
    file = tmp_path / "mine.toml"
    if text is not None:
        file.write_text(text, encoding="utf-8")
    assert main(["check", str(file)]) == 2
    assert str(file) in capsys.readouterr().err


def test_what_a_file_names_is_looked_for_beside_it(tmp_path, monkeypatch, capsys):
    folder = tmp_path / "mine"
    folder.mkdir()
    assert main(["new", "robot", "-o", str(folder / "cart.toml")]) == 0
    assert main(["new", "rule-base", "-o", str(folder / "mine.fis")]) == 0
    assert main(["new", "scenario", "-o", str(folder / "course.toml")]) == 0
    text = (folder / "course.toml").read_text(encoding="utf-8").replace('"fuzzy"', '"mine.fis"')
    (folder / "course.toml").write_text(f'robot = "cart.toml"\n{text}', encoding="utf-8")
    monkeypatch.chdir(tmp_path)
    capsys.readouterr()
    for command in (["check"], ["run", "-q"]):
        assert main([command[0], "mine/course.toml", *command[1:]]) in (0, 1)
        said = capsys.readouterr()
        assert "cannot be read" not in said.out + said.err
        assert "Traceback" not in said.err
    assert main(["check", "corse"]) == 2
    assert "or the path of a .toml file" in capsys.readouterr().err


@pytest.mark.parametrize(
    ("text", "wanted"),
    [
        (
            'scenarios = ["lyapunov-sin", "lyapunov-circle"]\ncontrollers = ["fuzzy", "lyapunow"]\nseeds = "many"\n'
            'questions = ["leeds"]\n[[claims]]\nname = "a"\nmetric = "final_error_m"\nof = "lyapunow"\nbelow = "x"\n',
            {1: "'lyapunov-sine'", 2: "'lyapunov'", 3: "whole number", 4: "'leads'", 9: "below must be"},
        ),
        (
            'title = 3\nlaw = "lyapunov"\nmove = 3\n[[cost]]\nmetric = "final_eror_m"\nscale = 0.1\n',
            {1: "title must be", 2: "unknown key 'law'", 3: "move must be", 5: "'final_error_m'"},
        ),
    ],
)
def test_all_that_is_wrong_with_the_file_of_a_plan_is_told_at_once(tmp_path, capsys, text, wanted):
    file = tmp_path / "plan.toml"
    file.write_text(text, encoding="utf-8")
    assert main(["check", str(file), "--json"]) == 1
    found = {f["line"]: f["sentence"] for f in json.loads(capsys.readouterr().out)["findings"]}
    assert [*sorted(found)] == [*wanted]
    assert all(words in found[line] for line, words in wanted.items())
    assert main(["check", str(file)]) == 1
    assert f"{file}:{min(wanted)}: " in capsys.readouterr().out
