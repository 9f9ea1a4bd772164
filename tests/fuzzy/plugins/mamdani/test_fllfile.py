"""FuzzyLite's files: what pyfuzzylite answers to them, there and back, and what is refused."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings

import fuzzy
from fuzzy import membership as mf
from fuzzy.commands.application import main
from fuzzy.plugins.mamdani.fllfile import FllFileError, parse_fll, read_fll
from fuzzy.plugins.mamdani.flltext import format_fll, write_fll
from tests.fuzzy.random_systems import systems

REFERENCE = sorted((Path(__file__).parents[3] / "data" / "fll").glob("*.fll"))


@pytest.mark.parametrize("file", REFERENCE, ids=lambda f: f.stem)
def test_answers_are_those_of_pyfuzzylite(file):
    """The script beside the data made them; our text, pyfuzzylite 8.0.6."""
    fis = read_fll(file)
    table = np.loadtxt(file.with_suffix(".csv"), delimiter=",", ndmin=2)
    x, y = table[:, : len(fis.inputs)], table[:, len(fis.inputs) :]
    span = np.maximum(np.ptp(y, axis=0), 1)
    assert (np.abs(fis(x) - y) <= 1e-12 * span).all()


def carried(fis: fuzzy.Sugeno) -> fuzzy.Sugeno:
    """The system without what FuzzyLite has no equal of: crossed vertices, signed differences, powers 1.3 and 3."""

    def bent(function: mf.MembershipFunction) -> mf.MembershipFunction:
        p = sorted(function.numbers)
        match function:
            case mf.Trapezoid() | mf.SShape() | mf.ZShape() | mf.PiShape() | mf.LinearS() | mf.LinearZ():
                return type(function)(*(value + 0.25 * k for k, value in enumerate(p)))
            case mf.SigmoidDifference():
                steep = abs(function.a1)
                return mf.SigmoidDifference(steep, min(function.c1, function.c2), steep, max(function.c1, function.c2))
        return function

    def bent_variable(variable: fuzzy.Variable) -> fuzzy.Variable:
        return replace(variable, terms={label: bent(function) for label, function in variable.terms.items()})

    rules = [
        replace(rule, when=tuple(replace(c, power=2.0) if c.power in (1.3, 3) else c for c in rule.when))
        for rule in fis.rules
    ]
    return replace(fis, inputs=tuple(map(bent_variable, fis.inputs)), rules=rules)


@settings(max_examples=60)
@given(fis=systems().map(carried))
def test_random_systems_there_and_back(fis):
    text = format_fll(fis)
    back = parse_fll(text)
    assert back.rules == fis.rules
    assert [v.terms for v in back.outputs] == [v.terms for v in fis.outputs]
    for one, other in zip(back.inputs, fis.inputs, strict=True):
        assert [repr(term) for term in one.terms.values()] == [repr(term) for term in other.terms.values()]
    assert (back.and_method, back.or_method, back.defuzzification) == (
        fis.and_method,
        fis.or_method,
        fis.defuzzification,
    )
    assert format_fll(back) == text


def test_names_become_what_fuzzylite_has(tmp_path):
    here = fuzzy.Variable("İrtifa [m]", (0, 1), {"very": fuzzy.trimf(0, 0, 1), "2 near": fuzzy.trimf(0, 1, 1)})
    y = fuzzy.Variable("y", (0, 1), {"a b": 0.25, "a-b": 0.75})
    rules = ["if 'İrtifa [m]' is 'very' then y is 'a b'", "if 'İrtifa [m]' is '2 near' then y is a-b"]
    fis = fuzzy.Sugeno([here], [y], rules)
    write_fll(fis, tmp_path / "x.fll")
    back = read_fll(tmp_path / "x.fll")
    assert [v.name for v in back.inputs] == ["Irtifa_m"]
    assert list(back.inputs[0].terms) == ["very_", "t_2_near"]
    assert list(back.outputs[0].terms) == ["a_b", "a_b_2"]
    x = np.linspace(0, 1, 7)[:, None]
    np.testing.assert_array_equal(back(x), fis(x))


GOOD = """Engine: car  # a comment
InputVariable: d
  enabled: true
  range: 0.000 1.000
  lock-range: false
  term: near Ramp 1.000 0.000
  term: far Rectangle 0.5 1.0
OutputVariable: v
  enabled: true
  range: 0.000 1.000
  lock-range: false
  aggregation: none
  defuzzifier: WeightedAverage TakagiSugeno
  default: nan
  lock-previous: false
  term: slow Constant 0.100
  term: plane Linear 2.0 0.5
RuleBlock: one
  enabled: true
  conjunction: Minimum
  disjunction: Maximum
  implication: none
  activation: General
  rule: if d is near then v is slow with 0.5
  rule: if d is not very far then v is plane
"""


def test_a_file_of_somebody_else():
    fis = parse_fll(GOOD)
    assert (fis.name, fis.and_method, fis.or_method, fis.no_rule_fires) == ("car", "min", "max", "nan")
    assert fis.inputs[0].terms["near"] == fuzzy.linzmf(0, 1)
    # Far from "far" the plane 2 d + 0.5 counts 1, "near" its degree times a half
    near = 0.75 * 0.5
    assert float(fis([0.25])[0]) == pytest.approx((near * 0.1 + (2 * 0.25 + 0.5)) / (near + 1))


@pytest.mark.parametrize(
    ("before", "after", "line", "said"),
    [
        ("term: near Ramp 1.000 0.000", "term: near Spike 0 1", 6, "one of|unknown|Spike"),
        ("term: near Ramp 1.000 0.000", "term: near Ramp 1.0", 6, "Ramp has 2 parameters, got 1"),
        ("term: near Ramp 1.000 0.000", "term: near Ramp a 0", 6, "expected a number, got 'a'"),
        ("range: 0.000 1.000\n  lock-range: false\n  term", "range: 0\n  term", 4, "2 finite numbers"),
        ("Linear 2.0 0.5", "Linear 2.0", 17, "Linear has 2 numbers here, got 1"),
        ("Constant 0.100", "Triangle 0 1 2", 16, "Mamdani"),
        ("WeightedAverage TakagiSugeno", "Centroid 100", 13, "WeightedAverage or WeightedSum"),
        ("aggregation: none", "aggregation: Maximum", 12, "aggregation must be none"),
        ("default: nan", "default: 0.3", 14, "nan or the middle of the range, 0.5"),
        ("lock-previous: false", "lock-previous: true", 8, "depend"),
        ("not very far", "extremely far", 25, "'extremely' has no equal here"),
        ("d is near then", "d is near and d is far or d is near then", 24, "mixes|both|and|or"),
        ("conjunction: Minimum", "conjunction: EinsteinProduct", 20, "conjunction"),
        ("d is near", "e is near", 24, "e"),
    ],
)
def test_what_has_no_equal_is_refused_with_its_line(before, after, line, said):
    assert before in GOOD
    with pytest.raises(FllFileError, match=said) as caught:
        parse_fll(GOOD.replace(before, after), "car.fll")
    assert caught.value.line == line
    assert str(caught.value).startswith(f"car.fll:{line}: ")


def test_what_fuzzylite_does_not_have_is_not_written():
    x = fuzzy.Variable("x", (0, 1), {"a": fuzzy.smf(0.6, 0.4), "b": fuzzy.trimf(0, 0, 1)})
    y = fuzzy.Variable("y", (0, 1), {"c": 1})
    with pytest.raises(FllFileError, match="x is a: FuzzyLite has no SShape whose vertices cross"):
        format_fll(fuzzy.Sugeno([x], [y], ["if x is b then y is c"]))
    plain = fuzzy.Variable("x", (0, 1), {"b": fuzzy.trimf(0, 0, 1)})
    with pytest.raises(FllFileError, match="rule 1: FuzzyLite has no hedge for the power 3"):
        format_fll(fuzzy.Sugeno([plain], [y], ["if x is extremely b then y is c"]))


def test_the_command_converts_both_ways(tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    assert main(["convert", "tracking", "t.fll"]) == 0
    assert main(["convert", "t.fll", "t.fis"]) == 0
    ours, back = fuzzy.read_fis(fuzzy.find_fis("tracking")), fuzzy.read_fis("t.fis")
    x = np.random.default_rng(1).uniform(-1, 1, (50, 4)) * [1, 3, 0.1, 3]
    np.testing.assert_array_equal(ours(np.abs(x)), back(np.abs(x)))
    (tmp_path / "bad.fll").write_text("nothing")
    assert main(["convert", "bad.fll", "b.fis"]) == 2
    assert "bad.fll:1: expected 'key: value'" in capsys.readouterr().err
    assert not (tmp_path / "b.fis").exists()
    assert main(["convert", "none.fll", "b.fis"]) == 2
    assert "none.fll: cannot be read" in capsys.readouterr().err
