"""Rule bases by name: what is found, what comes first, and what is said of other texts."""

import os
import re
import sys
from pathlib import Path

import pytest

from fuzzy.errors import InputError
from fuzzy.files.fisfile import FisFileError, read_fis, write_fis
from fuzzy.files.packaged import (
    RULE_BASE_GROUP,
    FisNameError,
    find_fis,
    fis_title,
    packaged_fis_files,
    unusable_rule_bases,
)
from robotics.laws.law import ControllerError
from robotics.laws.tracking.fuzzy_tracking import load_rule_base, rule_base_files
from tests.conftest import declare

OURS = Path(__file__).parents[3] / "robotics" / "data" / "rulebases"


def listed() -> dict[str, Path]:
    """The packaged files by their names, found by walking through the folder."""
    thesis = OURS.parents[1] / "plugins" / "thesis" / "data" / "rulebases"
    places = [(place, Path(at, file)) for place in (OURS, thesis) for at, _, names in os.walk(place) for file in names]
    return {str(file)[len(str(place)) + 1 : -len(".fis")].replace(os.sep, "/"): file for place, file in places}


@pytest.fixture
def boats(site):
    """A package that brings rule bases, one of them with a name of ours; whoever imports it is found out."""
    rules = site / "boats" / "rules"
    (rules / "deep").mkdir(parents=True)
    (site / "boats" / "__init__.py").write_text("raise RuntimeError('imported')\n", encoding="utf-8")
    for name in ("helm", "deep/keel", "tracking"):
        write_fis(load_rule_base("lateral"), rules / f"{name}.fis", f"The {name}.")
    declare(
        site,
        "boats",
        {RULE_BASE_GROUP: {"a-boats": "boats.rules", "gone": "boats.no.such", "void": "no_such_package.x"}},
    )
    return rules


def test_every_packaged_file_is_found_by_its_name(site, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    assert packaged_fis_files() == rule_base_files() == listed()
    assert list(packaged_fis_files()) == sorted(listed())
    assert {"tracking", "formation/v_l", "thesis/w_f"} <= set(listed())
    for name, file in listed().items():
        assert find_fis(name) == find_fis(Path(name)) == file
        assert load_rule_base(name) == read_fis(file)
    assert unusable_rule_bases() == []


def test_other_packages_add_theirs_and_ours_keep_their_names(boats):
    assert find_fis("helm") == boats / "helm.fis"
    assert find_fis("deep/keel") == boats / "deep" / "keel.fis"
    assert find_fis("tracking") == OURS / "tracking.fis"
    assert load_rule_base("helm").name == "lateral"
    assert set(packaged_fis_files()) == set(rule_base_files()) == {*listed(), "helm", "deep/keel"}
    assert "boats" not in sys.modules
    taken, gone, void = unusable_rule_bases()
    assert taken == ("the rule base 'tracking' of the package boats has the name of one of the package fuzzyfleet")
    assert gone == "the rule bases 'gone' of the package boats are not there: no folder boats.no.such"
    assert "no folder no_such_package.x" in void


def test_a_file_that_is_there_comes_before_a_name(site, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "lateral").mkdir()
    assert find_fis("lateral") == OURS / "lateral.fis"  # a folder is no rule base
    write_fis(load_rule_base("eta"), "theta")
    assert find_fis("theta") == Path("theta")
    assert load_rule_base("theta").name == "theta"  # a law's default is the same in every folder
    write_fis(load_rule_base("eta"), "mine")
    assert find_fis("mine") == Path("mine")
    assert load_rule_base("mine").name == "eta"


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("traking", "unknown rule base 'traking'; did you mean 'tracking'? Known: .*; or the path of a .fis file"),
        ("formation/v", "did you mean 'formation/v_[lf]'?"),
        ("tracking.fis", "no file 'tracking.fis'; the packaged rule base is called 'tracking', without .fis"),
    ],
)
def test_what_is_neither_is_one_sentence(text, message, site, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    pattern = re.sub(r"\?|\.(?!\*)", lambda found: rf"\{found[0]}", message)
    with pytest.raises(FisNameError, match=pattern) as caught:
        find_fis(text)
    assert "\n" not in str(caught.value)
    assert isinstance(caught.value, InputError)
    with pytest.raises(ControllerError, match=pattern):
        load_rule_base(text)


def test_a_path_without_a_file_is_told_by_the_reader(site, tmp_path):
    assert find_fis(tmp_path / "none.fis") == tmp_path / "none.fis"
    for path, reason in ((tmp_path / "none.fis", "No such file"), (tmp_path, "directory")):
        with pytest.raises(FisFileError, match=reason):
            read_fis(find_fis(path))
    for text in ("x" * 5000, "a\0b"):
        with pytest.raises(FisNameError):
            find_fis(text)


def test_no_package_no_names(monkeypatch):
    monkeypatch.setattr("fuzzy.files.packaged.entry_points", lambda group: [])
    with pytest.raises(FisNameError, match=r"unknown rule base 'tracking'. Known: \(none\)"):
        find_fis("tracking")
    assert load_rule_base("tracking").rules  # the robots' own need no metadata


def test_the_title_is_the_first_line_of_the_comment(tmp_path):
    file = tmp_path / "a.fis"
    for text, title in (
        ("\n%  One.\n% Two.\n[System]\n", "One."),
        ("\ufeff# One\n[System]\n", "One"),
        ("%! OutOfRange='clip'\n%\n// One\n", "One"),
        ("[System]\n% Late.\n", ""),
        ("", ""),
    ):
        file.write_text(text, encoding="utf-8")
        assert fis_title(file) == title
    write_fis(load_rule_base("eta"), file, "One.\nTwo.")
    assert file.read_text(encoding="utf-8").startswith("% One.\n% Two.\n[System]\n")
    assert fis_title(file) == "One."
    assert read_fis(file) == load_rule_base("eta")


def test_every_packaged_rule_base_has_a_title_and_units():
    titles = [fis_title(file) for file in listed().values()]
    assert all(title.endswith(".") for title in titles), titles
    assert len(set(titles)) == len(titles)
    for name in listed():
        fis = load_rule_base(name)
        units = {v.unit for v in (*fis.inputs, *fis.outputs)}
        assert units <= {"m", "rad", "s", "m/s", "rad/s", "1/m", ""}, name  # SI; none: a pure number
        assert units != {""}, name
