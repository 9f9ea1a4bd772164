"""``robotics copy``: packaged files as one's own, and ``robotics list``, which says what there is."""

import json
import re
from importlib.resources import files
from pathlib import Path

import pytest

from fuzzy.files.fisfile import read_fis, write_fis
from fuzzy.files.packaged import RULE_BASE_GROUP
from robotics.commands.application import main
from robotics.laws.formation.leader_follower import load_networks
from robotics.laws.tracking.fuzzy_tracking import load_rule_base, rule_base_files
from robotics.simulation.scenario.copying import copy_packaged
from robotics.simulation.scenario.reading import load_scenario, scenario_file, scenario_names
from tests.conftest import declare

DATA = Path(str(files("robotics"))) / "data"


@pytest.fixture(autouse=True)
def here(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    return tmp_path


def present() -> list[str]:
    return sorted(path.as_posix() for path in Path().rglob("*") if path.is_file())


def fails(capsys, *arguments: str) -> str:
    """Run the command line, which must end with 2, print one sentence, and leave the folder as it was."""
    before = {name: Path(name).read_bytes() for name in present()}
    assert main(arguments) == 2
    out, err = capsys.readouterr()
    assert (out, err.count("\n")) == ("", 1)
    assert {name: Path(name).read_bytes() for name in present()} == before
    return err


def test_copies_and_how_they_are_used(capsys):
    assert main(["copy", "tracking", "three-cross", "tracking"]) == 0
    out, err = capsys.readouterr()
    assert err == ""
    assert out.splitlines() == [
        "tracking.fis",
        "  robotics run my.toml --controller fuzzy:rule_base=tracking.fis",
        "three-cross.toml",
        "  robotics run three-cross.toml",
    ]
    assert present() == ["three-cross.toml", "tracking.fis"]
    assert Path("tracking.fis").read_bytes() == (DATA / "rulebases" / "tracking.fis").read_bytes()


@pytest.mark.long
def test_every_scenario_and_rule_base_is_the_same_when_copied(here):
    copies = copy_packaged([*scenario_names(), *rule_base_files()], here / "a" / "b")
    assert len(copies) == len(scenario_names()) + len(rule_base_files())
    for copied in copies:
        if copied.file.suffix == ".fis":
            assert read_fis(copied.file) == load_rule_base(copied.name)
            assert copied.use.startswith(("robotics run my.toml --controller ", "fuzzy show "))
        else:
            original = scenario_file(copied.name).path
            assert copied.file.read_bytes() == original.read_bytes()
            assert copied.use == f"robotics run {copied.file}"
            assert load_scenario(copied.file) == load_scenario(copied.name)


def test_a_copied_scenario_runs_as_the_original(capsys):
    Path("tiny").mkdir()
    assert main(["copy", "fuzzy-on-path", "tracking", "--to", "tiny", "--json"]) == 0
    scenario, rules = json.loads(capsys.readouterr().out)["copies"]
    assert [scenario["file"], rules["file"]] == ["tiny/fuzzy-on-path.toml", "tiny/tracking.fis"]
    assert main(["run", "fuzzy-on-path", "--json", "-q"]) == 0
    original = json.loads(capsys.readouterr().out)
    words = rules["use"].replace("my.toml", scenario["file"]).split()
    assert words[0] == "robotics"
    assert main([*words[1:], "--json", "-q"]) == 0
    assert json.loads(capsys.readouterr().out)["metrics"] == original["metrics"]


def test_a_folder_of_networks_is_copied_whole(capsys):
    assert main(["copy", "formation"]) == 0
    out = capsys.readouterr().out
    assert present() == [f"formation/{name}.fis" for name in ("v_f", "v_l", "w_f", "w_l")]
    assert out.splitlines() == [*present(), "  robotics run my.toml --controller formation:networks=formation/"]
    changed = Path("formation/v_l.fis")
    changed.write_text(changed.read_text(encoding="utf-8").replace("Name='v_l'", "Name='changed'", 1), encoding="utf-8")
    assert [fis.name for fis in load_networks("formation/")] == ["changed", "w_l", "v_f", "w_f"]
    assert main(["copy", "thesis/v_l"]) == 0  # alone it drives nobody
    assert capsys.readouterr().out == "thesis/v_l.fis\n  fuzzy show thesis/v_l.fis\n"


def test_nothing_is_overwritten_without_force_and_nothing_is_half_done(capsys):
    Path("reference.toml").write_text("mine", encoding="utf-8")
    said = fails(capsys, "copy", "tracking", "reference")
    assert said == "robotics: reference.toml exists already, nothing was copied; --force overwrites\n"
    assert present() == ["reference.toml"]
    assert main(["copy", "tracking", "reference", "--force"]) == 0
    assert present() == ["reference.toml", "tracking.fis"]
    assert load_scenario("reference.toml") == load_scenario("reference")
    Path("formation.fis").mkdir()
    Path("eta.fis").mkdir()
    assert main(["copy", "lateral", "eta", "theta", "--force"]) == 2  # what cannot be written is found out half-way
    assert "eta.fis" in capsys.readouterr().err
    assert present() == ["reference.toml", "tracking.fis"]


def test_the_packaged_files_themselves_are_never_written(capsys):
    before = {file: file.read_bytes() for file in (DATA / "rulebases").glob("*.fis")}
    said = fails(capsys, "copy", "tracking", "--force", "--to", str(DATA / "rulebases"))
    assert "tracking.fis is the packaged file itself" in said
    Path("tracking.fis").symlink_to(DATA / "rulebases" / "tracking.fis")
    assert "the packaged file itself" in fails(capsys, "copy", "tracking", "--force")
    assert {file: file.read_bytes() for file in before} == before


def test_unknown_names_and_names_of_two_things(site, capsys):
    (site / "boats").mkdir()
    (site / "boats" / "__init__.py").touch()
    write_fis(load_rule_base("eta"), site / "boats" / "reference.fis", "Steer a boat.")
    declare(site, "boats", {RULE_BASE_GROUP: {"boats": "boats"}})
    assert "did you mean 'tracking'? Known: " in fails(capsys, "copy", "eta", "trakking")
    assert "unknown rule base, scenario or robot 'tracking.toml'" in fails(capsys, "copy", "tracking.toml")
    said = fails(capsys, "copy", "reference")
    assert said == "robotics: 'reference' is a rule base and a scenario: write reference.fis or reference.toml\n"
    assert main(["copy", "reference.toml", "reference.fis"]) == 0
    assert capsys.readouterr().out.splitlines()[2:] == ["reference.fis", "  fuzzy show reference.fis"]
    assert read_fis("reference.fis") == load_rule_base("eta")
    assert main(["list", "rule-bases"]) == 0
    assert "Steer a boat.\n" in capsys.readouterr().out


def test_list_shows_rule_bases_with_titles_units_and_rules(capsys):
    assert main(["list", "rule-bases", "--json"]) == 0
    listed = json.loads(capsys.readouterr().out)
    assert set(listed) == {"rule_bases"}
    rows = {row["name"]: row for row in listed["rule_bases"]}
    assert list(rows) == sorted(rule_base_files())
    assert rows["tracking-literal"]["rules"] == 11  # Table 5.6
    assert rows["eta"]["inputs"] == [{"name": "distance", "unit": "m", "universe": [0.0, 0.6]}]
    assert rows["formation/v_l"]["outputs"][0]["unit"] == "m/s"
    assert main(["list"]) == 0
    out = capsys.readouterr().out
    assert max(map(len, out.splitlines())) <= 100
    words = " ".join(out.split())
    for row in rows.values():
        assert f"{row['name']} {row['title']}" in words
    assert "distance [m], alpha [rad], x_err [m] → v [m/s], w [rad/s]; 11 rules" in words


def test_list_shows_one_section(capsys):
    assert main(["list", "scenarios"]) == 0
    out = capsys.readouterr().out
    assert sorted(re.findall(r"(?m)^    ([a-z]\S+)  ", out)) == scenario_names()
    assert main(["list", "fuzzy"]) == 2
    assert "rule-bases" in capsys.readouterr().err
