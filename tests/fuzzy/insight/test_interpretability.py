"""Measures of readability against closed forms, and by the command."""

import json

import numpy as np
import pytest

import fuzzy
from fuzzy.commands.application import main
from fuzzy.files.fisfile import write_fis


def system(terms, rules=("if u is low then y is none", "if u is high then y is much")):
    y = fuzzy.Variable("y", (0, 1), {"none": 0.0, "much": 1.0})
    return fuzzy.Sugeno([fuzzy.Variable("u", (0, 1), terms)], [y], rules)


RUSPINI = {"low": fuzzy.Triangle(-1, 0, 1), "high": fuzzy.Triangle(0, 1, 2)}


def test_two_ramps_have_the_closed_forms():
    found = fuzzy.interpretability(system(RUSPINI))
    (u,) = found.partitions
    assert (u.terms, u.alike) == (2, ("low", "high"))
    assert u.coverage == pytest.approx(0.5)
    assert u.complementarity == pytest.approx(1.0)
    # ∫ min = 1/4 and ∫ max = 3/4
    assert u.distinguishability == pytest.approx(2 / 3, abs=1e-6)
    assert u.normality == 1.0
    # Two consequents over two conditions, covered everywhere, two terms
    assert found.nauck == pytest.approx(1.0)
    # A degree each, no connective, no slopes, three for the sums; one division
    assert (found.rules, found.conditions, found.longest, found.operations) == (2, 2, 1, 9)


def test_equal_terms_gaps_and_low_terms_are_seen():
    twin = fuzzy.interpretability(system({"low": fuzzy.Triangle(-1, 0, 1), "high": fuzzy.Triangle(-1, 0, 1)}))
    assert twin.partitions[0].distinguishability == pytest.approx(0.0)
    gap = fuzzy.interpretability(system({"low": fuzzy.Triangle(-0.4, 0, 0.4), "high": fuzzy.Triangle(0.6, 1, 1.4)}))
    assert gap.partitions[0].coverage == 0.0
    assert gap.partitions[0].distinguishability == 1.0
    assert gap.partitions[0].complementarity == pytest.approx(0.4, abs=1e-6)  # two triangles of 0.2
    beyond = fuzzy.interpretability(system({"low": fuzzy.Triangle(-1, 0, 1), "high": fuzzy.Triangle(0.5, 2, 3)}))
    assert beyond.partitions[0].normality == pytest.approx(1 / 3)


def test_each_word_of_a_rule_counts():
    def operations(rule):
        return fuzzy.interpretability(system(RUSPINI, [rule])).operations

    plain = operations("if u is low then y is none")
    assert operations("if u is not low then y is none") == plain + 1
    assert operations("if u is very low then y is none") == plain + 1
    assert operations("if u is low then y is none with 0.5") == plain + 1
    fis = system(RUSPINI, ["if u is low then y is none"])
    y = fuzzy.Variable("y", (0, 1), {"none": fuzzy.Linear((2.0,), 1.0)})
    assert fuzzy.interpretability(fuzzy.Sugeno(fis.inputs, [y], fis.rules)).operations == plain + 2


def test_what_is_missing_is_no_error():
    found = fuzzy.interpretability(system(RUSPINI, []))
    assert (found.rules, found.longest, found.nauck) == (0, 0, 0.0)
    bare = fuzzy.Sugeno([fuzzy.Variable("u", (0, 1), {})], [fuzzy.Variable("y", (0, 1), {"none": 0.0})], [])
    assert fuzzy.interpretability(bare).partitions == ()


def test_the_command_prints_them_and_gives_them_as_json(tmp_path, capsys):
    write_fis(system(RUSPINI), tmp_path / "two.fis")
    assert main(["check", str(tmp_path / "two.fis"), "--measures"]) == 0
    assert "low, high" in capsys.readouterr().out
    assert main(["check", str(tmp_path / "two.fis"), "--measures", "--json"]) == 0
    told = json.loads(capsys.readouterr().out)["measures"]
    assert told["partitions"][0]["variable"] == "u"
    assert np.isclose(told["nauck"], 1.0)
    assert main(["check", str(tmp_path / "two.fis"), "--json"]) == 0
    assert "measures" not in json.loads(capsys.readouterr().out)
