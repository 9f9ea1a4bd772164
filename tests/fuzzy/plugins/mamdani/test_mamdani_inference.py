"""Mamdani systems against Octave's toolkit and sums by hand, and how near a Sugeno system comes."""

import shutil
import subprocess
import warnings
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import fuzzy
from fuzzy.inference import InferenceWarning
from fuzzy.plugins.mamdani.likeness import fit_to_mamdani, input_grid, mamdani_difference, read_mamdani_original
from fuzzy.plugins.mamdani.system import Mamdani
from fuzzy.system import FuzzySystemError

DATA = Path(__file__).parents[3] / "data"
MAMDANI = DATA / "mamdani"
CORPUS = DATA / "fis-corpus"
REFERENCES = sorted(MAMDANI.glob("*.csv"))


def original(name: str) -> Mamdani:
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", fuzzy.FisFileWarning)  # of Octave's hedges
        return read_mamdani_original(next(DATA.glob(f"*/{name}.fis")))


def compared(path: Path) -> None:
    """The system's outputs, or the sums of its joint sets, are those in the file."""
    stem, *methods = path.stem.split("-")
    system = original(stem)
    if methods:
        keys = ("and_method", "or_method", "implication", "aggregation", "defuzzification")
        chosen: dict[str, Any] = dict(zip(keys, methods, strict=True))
        system = replace(system, **chosen)
    table = np.loadtxt(path, delimiter=",")
    count = len(system.inputs)
    x, wanted = table[:, :count], table[:, count:]
    assert len(x) >= 30
    if system.defuzzification in ("centroid", "bisector"):
        sums = [
            [(m.sum(), m @ p) for j in range(len(system.outputs)) for p, m in [system.joint_set(row, j)]] for row in x
        ]
        np.testing.assert_allclose(np.reshape(sums, wanted.shape), wanted, rtol=1e-12, atol=1e-12)
        if system.defuzzification == "centroid":
            np.testing.assert_allclose(system(x), wanted[:, 1::2] / wanted[:, ::2], rtol=1e-11, atol=1e-12)
    else:
        np.testing.assert_allclose(system(x), wanted, rtol=1e-12, atol=1e-12)


@pytest.mark.parametrize("path", REFERENCES, ids=lambda path: path.stem)
def test_outputs_are_those_of_octave(path):
    compared(path)


@pytest.mark.long
@pytest.mark.skipif(shutil.which("octave-cli") is None, reason="octave-cli is not installed")
def test_octave_says_the_same_today(tmp_path):
    command = ["octave-cli", "--quiet", str(MAMDANI / "reference.m"), str(tmp_path)]
    done = subprocess.run(command, capture_output=True, text=True, timeout=300, check=False)
    if "package" in done.stderr and "not" in done.stderr and not list(tmp_path.glob("*.csv")):
        pytest.skip("Octave has no fuzzy-logic-toolkit")
    made = sorted(tmp_path.glob("*.csv"))
    assert [path.name for path in made] == [path.name for path in REFERENCES]
    for path in made:
        compared(path)


def tipper(**settings) -> Mamdani:
    """MATLAB's documented example, with its documented outputs."""
    return Mamdani(
        [
            fuzzy.Variable("service", (0, 10), {"poor": fuzzy.gaussmf(1.5, 0), "good": fuzzy.gaussmf(1.5, 5),
                                                "excellent": fuzzy.gaussmf(1.5, 10)}),
            fuzzy.Variable("food", (0, 10), {"rancid": fuzzy.trapmf(-2, 0, 1, 3),
                                             "delicious": fuzzy.trapmf(7, 9, 10, 12)}),
        ],
        [fuzzy.Variable("tip", (0, 30), {"cheap": fuzzy.trimf(0, 5, 10), "average": fuzzy.trimf(10, 15, 20),
                                         "generous": fuzzy.trimf(20, 25, 30)})],
        ["if service is poor or food is rancid then tip is cheap", "if service is good then tip is average",
         "if service is excellent or food is delicious then tip is generous"],
        **settings,
    )  # fmt: skip


def test_the_documented_values_of_the_tipper():
    x = [[2, 1], [4, 5], [7, 8]]
    np.testing.assert_allclose(tipper()(x)[:, 0], [7.0169, 14.4585, 20.3414], atol=5e-5)


def test_every_defuzzification_by_hand():
    low = fuzzy.Variable("x", (0, 1), {"low": fuzzy.linzmf(0, 1), "high": fuzzy.linsmf(0, 1)})
    y = fuzzy.Variable("y", (0, 4), {"left": fuzzy.trapmf(0, 1, 1, 2), "right": fuzzy.trapmf(2, 3, 3, 4)})
    rules = ["if x is low then y is left", "if x is high then y is right with 0.5"]
    # Places 0 1 2 3 4; at x = 0.2 the joint set is 0 0.8 0 0.1 0.
    method: Any
    for method, wanted in {"centroid": (0.8 + 0.3) / 0.9, "bisector": 1, "mom": 1, "lom": 1, "som": 1}.items():
        assert Mamdani([low], [y], rules, defuzzification=method, points=5)([0.2])[0] == pytest.approx(wanted)
    # Both sets have 0.3 there: 0 0.3 0 0.3 0.
    equal = [rules[0] + " with 0.5", rules[1]]
    for method, wanted in {"centroid": 2, "bisector": 1, "mom": 2, "lom": 3, "som": 1}.items():
        assert Mamdani([low], [y], equal, defuzzification=method, points=5)([0.5])[0] == pytest.approx(wanted)


def test_where_no_rule_fires_the_middle_is_given_and_said():
    x = fuzzy.Variable("x", (0, 10), {"low": fuzzy.trimf(0, 1, 2)})
    system = Mamdani([x], [fuzzy.Variable("y", (0, 6), {"some": fuzzy.trimf(0, 1, 2)})], ["if x is low then y is some"])
    with pytest.warns(InferenceWarning, match="no rule fires for output y"):
        assert system([5.0])[0] == 3.0


@pytest.mark.parametrize(
    ("settings", "said"),
    [
        ({"aggregation": "mean"}, "aggregation"),
        ({"implication": "max"}, "implication"),
        ({"defuzzification": "wtaver"}, "defuzzification"),
        ({"points": 1}, "points must be from 2"),
    ],
)
def test_settings_that_there_are_not_are_refused(settings, said):
    with pytest.raises(FuzzySystemError, match=said):
        tipper(**settings)


def test_the_order_of_rules_does_not_matter():
    system = original("brake")
    x = input_grid(system.inputs, 200)
    for aggregation in ("max", "sum", "probor"):
        one = replace(system, aggregation=aggregation)
        other = replace(one, rules=one.rules[::-1])
        np.testing.assert_allclose(one.evaluate(x)[0], other.evaluate(x)[0], rtol=1e-12)


def test_the_grid_of_the_difference_and_that_of_the_fit_share_no_place():
    system = original("brake")
    ends, middles = input_grid(system.inputs), input_grid(system.inputs, offset=True)
    assert len(ends) == 4096
    assert not {tuple(row) for row in ends} & {tuple(row) for row in middles}
    assert ends.min(axis=0).tolist() == [0, -1]
    assert ends.max(axis=0).tolist() == [10, 3]


def test_a_difference_is_a_share_of_the_range():
    system = tipper()
    sugeno, _ = system.as_sugeno()
    moved = replace(sugeno.outputs[0], terms={label: term.value + 3 for label, term in sugeno.outputs[0].terms.items()})
    x = input_grid(system.inputs)
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", InferenceWarning)
        gap = np.abs(system.evaluate(x)[0] - replace(sugeno, outputs=[moved])(x))[:, 0] / 30
    (found,) = mamdani_difference(system, replace(sugeno, outputs=[moved]))
    assert (found.greatest, found.mean) == pytest.approx((gap.max(), gap.mean()))
    assert found.points == len(x)


@pytest.mark.parametrize("name", ["m02_auvsl_rgator", "m05_kzafeiroudi_smf", "m06_mjuston_probor"])
def test_fitted_consequents_come_nearer_in_the_mean_square(name):
    system = original(name)
    centroids, _ = system.as_sugeno()
    apart = [mamdani_difference(system, centroids)]
    apart += [mamdani_difference(system, fit_to_mamdani(system, centroids, kind)) for kind in ("constants", "planes")]
    for before, constants, planes in zip(*apart, strict=True):
        assert constants.root_mean_square <= 1.01 * before.root_mean_square  # at places that the fit did not see
        assert planes.root_mean_square <= constants.root_mean_square + 1e-8  # what the small ridge leaves
        if before.root_mean_square > 0.02:
            assert planes.root_mean_square < 0.75 * before.root_mean_square


def test_systems_of_other_inputs_are_refused():
    with pytest.raises(FuzzySystemError, match="the inputs of the two systems differ: service, food and d, phi"):
        mamdani_difference(tipper(), fuzzy.read_mamdani(CORPUS / "m02_auvsl_rgator.fis").system)
    with pytest.raises(FuzzySystemError, match="consequents"):
        fit_to_mamdani(tipper(), tipper().as_sugeno()[0], "curves")  # type: ignore[arg-type]


def test_a_sugeno_file_is_no_mamdani_system():
    with pytest.raises(fuzzy.FisFileError, match="holds a Sugeno system"):
        read_mamdani_original(next(CORPUS.glob("s01*.fis")))
