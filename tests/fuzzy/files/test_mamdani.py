"""Mamdani files as Sugeno systems: centroids against an independent integration, and what is said of the changes."""

import itertools
from pathlib import Path

import numpy as np
import pytest
from scipy.integrate import quad

import fuzzy
from fuzzy.files.fisfile import FisFileError, MamdaniError, format_fis, parse_fis, read_fis, read_mamdani
from fuzzy.files.mamdani import centroid
from fuzzy.membership import Bell, Gaussian, PiShape, Sigmoid, SShape, Trapezoid, Triangle, TwoSidedGaussian

CORPUS = Path(__file__).parents[2] / "data" / "fis-corpus"
MAMDANI = sorted(CORPUS.glob("m*.fis"))
SETS = [
    Triangle(7.5, 22.5, 30), Triangle(-1.333, -1, 5), Trapezoid(0, 0, 2, 3), Gaussian(0.398813206688577, 0.0471),
    Gaussian(4.90382229928202, 15), TwoSidedGaussian(1, 2, 0.3, 4), PiShape(0, 1, 3, 9), SShape(2, 2), Bell(0.1, 2, 4),
    Sigmoid(50, 5), Gaussian(1e-4, 3.3), Triangle(4, 4.0001, 4.0002),
]  # fmt: skip


@pytest.mark.parametrize("negated", [False, True])
@pytest.mark.parametrize("function", SETS, ids=str)
def test_the_centroid_is_that_of_an_adaptive_integration(function, negated):
    low, high = 0.0, 15.0

    def degree(x):
        mu = float(function(np.array(x)))
        return 1 - mu if negated else mu

    middle = [p for p, role in zip(function.numbers, function.roles, strict=True) if role == "location"]
    near = [m + d for m in middle for d in (-1e-3, -1e-4, 0, 1e-4, 1e-3)]
    cuts = sorted({low, high, *(c for c in near if low < c < high)})
    pieces = list(itertools.pairwise(cuts))
    area = sum(quad(degree, a, b, epsabs=1e-14, limit=200)[0] for a, b in pieces)
    moment = sum(quad(lambda x: x * degree(x), a, b, epsabs=1e-14, limit=200)[0] for a, b in pieces)
    assert centroid(function, (low, high), negated) == pytest.approx(moment / area, abs=1e-8 * (high - low))


def test_centroids_by_hand():
    assert centroid(Triangle(0, 1, 5), (0, 5)) == pytest.approx(2)  # (a + b + c) / 3
    assert centroid(Triangle(-1, 0, 1), (0, 5)) == pytest.approx(1 / 3)  # the right half alone
    assert centroid(Triangle(6, 7, 8), (0, 5)) is None
    assert centroid(Triangle(6, 7, 8), (0, 5), negated=True) == pytest.approx(2.5)
    assert centroid(Triangle(0, 1, 2), (1, 1)) == 1


@pytest.mark.parametrize("path", MAMDANI, ids=lambda path: path.stem)
def test_inputs_rules_and_weights_stay_and_the_changes_are_told(path, tmp_path):
    fis, changes = read_mamdani(path)
    lines = path.read_text().splitlines()
    sets = [line for line in lines[lines.index("[Output1]") :] if line.startswith("MF")]
    negations = {
        word for line in lines[lines.index("[Rules]") :] for word in line.partition(",")[2].split() if "-" in word
    }
    assert sum("became the constant" in change for change in changes) == len(sets) + len(negations)
    assert "DefuzzMethod 'centroid' became 'wtaver', as Sugeno systems have it" in changes
    assert (fis.implication, fis.aggregation, fis.defuzzification) == ("prod", "sum", "wtaver")
    # What is written is read back, and its rules are the lines of the Mamdani file but for "not" in a consequent.
    fuzzy.write_fis(fis, tmp_path / "new.fis")
    assert read_fis(tmp_path / "new.fis") == fis
    written = (tmp_path / "new.fis").read_text().splitlines()
    if not negations:
        assert written[written.index("[Rules]") :] == lines[lines.index("[Rules]") :]


# Points and outputs of an independent evaluator of the Mamdani systems. The third file is left out: its rules overlap
# much, and where the Mamdani system takes the greatest set, the Sugeno system takes the sum: up to 32 % of the range.
REFERENCE = {
    "m02_auvsl_rgator": ([[1.1366801123358483, -1.1513413075988728], [3.9868272866636705, 1.1074407575842975]],
                         [[19.89426214599942, 0.5], [15.253097480941687, -0.5]], 0.02),
    "m06_mjuston_probor": ([[-54.532795506566067, -1.1544224598285568, 1.8734023811962248, 1.1104044257311396],
                            [-21.778089879618207, -1.0532722544417776, 0.61934514759929593, -1.9735746306966058]],
                           [[-0.89536332179930778], [-0.89536332179930778]], 0.02),
}  # fmt: skip


@pytest.mark.parametrize("stem", REFERENCE)
def test_the_sugeno_system_comes_near_the_mamdani_system(stem):
    x, wanted, within = REFERENCE[stem]
    fis = read_mamdani(CORPUS / f"{stem}.fis").system
    span = np.array([v.universe[1] - v.universe[0] for v in fis.outputs])
    assert (np.abs(fis(np.array(x)) - wanted) / span).max() < within


SMALL = """\
[System]
Name='small'
Type='mamdani'
NumInputs=1
NumOutputs=1
NumRules=3
AndMethod='min'
OrMethod='max'
ImpMethod='min'
AggMethod='max'
DefuzzMethod='mom'
[Input1]
Name='x'
Range=[0 1]
NumMFs=2
MF1='low':'linzmf',[0 1]
MF2='high':'linsmf',[0 1]
[Output1]
Name='y'
%! Unit='m'
Range=[-1 1]
NumMFs=3
MF1='near':'trimf',[-1.5 0 1.5]
MF2='not near':'trimf',[0.5 1 1.5]
MF3='beyond':'trimf',[2 3 4]
[Rules]
1, -1 (1) : 1
2, 2 (0.5) : 1
0, 3 (1) : 1
"""


def test_not_in_a_consequent_and_a_set_outside_the_range(tmp_path):
    (tmp_path / "small.fis").write_text(SMALL.replace("0, 3 (1)", "-1, 3 (1)"))
    fis, changes = read_mamdani(tmp_path / "small.fis")
    output = fis["y"]
    assert list(output.terms) == ["near", "not near", "beyond", "not near (complement)"]
    assert [term.value for term in output.terms.values()] == pytest.approx([0, 5 / 6, 0, 0])
    assert output.unit == "m"
    assert [dict(rule.then)["y"] for rule in fis.rules] == ["not near (complement)", "not near", "beyond"]
    assert fis.and_method == "min"
    assert next(c for c in changes if "beyond" in c).endswith(
        "the constant 0, the middle of the range, where it is empty"
    )
    assert "DefuzzMethod 'mom' became 'wtaver', as Sugeno systems have it" in changes


def test_it_is_refused_where_it_is_not_asked_for(tmp_path):
    path = tmp_path / "small.fis"
    path.write_text(SMALL)
    for read in (lambda: read_fis(path), lambda: parse_fis(SMALL)):
        with pytest.raises(MamdaniError, match=r"3: this is a Mamdani system.*fuzzy convert.*read_mamdani"):
            read()
    for old, new, reason in (
        ("'trimf',[2", "'constant',[2", "constant"),
        ("1, -1 (1)", "1, 1.20 (1)", "no hedge"),
        ("'mom'", "'wtaver'", "DefuzzMethod.*centroid"),
    ):
        path.write_text(SMALL.replace(old, new).replace("0, 3 (1)", "1, 3 (1)"))
        with pytest.raises(FisFileError, match=reason):
            read_mamdani(path)


def test_a_sugeno_file_is_read_as_it_is(tmp_path):
    path = next(iter(sorted(CORPUS.glob("s01*.fis"))))
    assert read_mamdani(path) == (read_fis(path), ())
    assert format_fis(read_mamdani(path).system) == format_fis(read_fis(path))
