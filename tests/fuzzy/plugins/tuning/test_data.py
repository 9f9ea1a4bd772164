"""Tuning on data: a generating system is found again, consequents come to the least squares, what is held back counts.

The command ``fuzzy tune``, end to end.
"""

import json
from dataclasses import replace
from typing import Any

import numpy as np
import pandas as pd
import pytest

import fuzzy
from fuzzy.commands.application import main
from fuzzy.plugins.tuning.data import cross_validate_tuning, rmse


def system(widths, center, constants, weights=(1.0, 1.0, 1.0)) -> fuzzy.Sugeno:
    centers = dict(zip(("lo", "mid", "hi"), (0.0, center, 10.0), strict=True))
    terms = {n: fuzzy.Gaussian(w, c) for (n, c), w in zip(centers.items(), widths, strict=True)}
    rules = [f"if a is {n} then y is {o} with {w}" for n, o, w in zip(terms, "pqr", weights, strict=True)]
    a = fuzzy.Variable("a", (0, 10), terms, "m")
    return fuzzy.Sugeno([a], [fuzzy.Variable("y", (0, 30), dict(zip("pqr", constants, strict=True)), "N")], rules)


TRUE = system((1.8, 1.8, 1.8), 4.0, (5.0, 20.0, 10.0))
BENT = system((2.2, 1.5, 2.0), 5.0, (7.0, 14.0, 13.0))
X = np.linspace(0, 10, 60)[:, None]
Y = TRUE(X)


def test_a_generating_system_is_found_again():
    found = fuzzy.tune(BENT, X, Y, evaluations=1000)
    assert found.before == pytest.approx(np.sqrt(np.mean((BENT(X) - Y) ** 2)))
    assert found.after == pytest.approx(np.sqrt(np.mean((found.system(X) - Y) ** 2)))
    assert found.after < 0.005 * found.before
    for name, term in found.system.outputs[0].terms.items():
        assert term.value == pytest.approx(TRUE.outputs[0].terms[name].value, abs=0.1)
    assert found.system.inputs[0].terms["mid"].c == pytest.approx(4.0, abs=0.05)
    assert found.evaluations == 1000 == len(found.table())


@pytest.mark.parametrize("engine", ["cmaes", "random"])
def test_consequents_alone_come_to_the_least_squares(engine):
    best = rmse(fuzzy.fit_consequents(BENT, X, Y), X, Y)
    found = fuzzy.tune(BENT, X, Y, move=["consequents"], evaluations=400, engine=engine)
    assert best - 1e-12 <= found.after < 1.01 * best
    assert found.system.inputs == BENT.inputs


def test_consequents_that_follow_find_more():
    moved, solved = (fuzzy.tune(BENT, X, Y, evaluations=150, engine="random", solve=s) for s in (False, True))
    assert solved.after < 0.5 * moved.after
    again = fuzzy.fit_consequents(solved.system, X, Y)
    assert rmse(again, X, Y) == pytest.approx(solved.after)
    assert not any(p.name.startswith("y.") for p in solved.space.parameters)


def test_linear_consequents_that_are_zero_can_move():
    line = fuzzy.Variable("y", (-1, 1), {"p": fuzzy.Linear((0.0,), 0.0), "q": fuzzy.Linear((0.0,), 0.0)}, "N")
    fis = fuzzy.Sugeno([replace(TRUE.inputs[0])], [line], ["if a is lo then y is p", "if a is hi then y is q"])
    target = 2.0 + 0.3 * X
    found = fuzzy.tune(fis, X, target, move=["consequents"], evaluations=800)
    assert found.before > 3
    assert found.after < 0.05


def test_choices_and_rules_are_found_again():
    wrong = system((1.8, 1.8, 1.8), 4.0, (5.0, 10.0, 20.0))  # the constants of two rules exchanged
    found = fuzzy.tune(wrong, X, Y, move=["choices"], evaluations=200, engine="random")
    assert found.after < 1e-12 < found.before
    double = replace(
        TRUE, rules=[*TRUE.rules, fuzzy.parse_rule("if a is mid then y is p", {"a": ["mid"]}, {"y": ["p"]})]
    )
    assert fuzzy.tune(double, X, Y, move=["rules"], evaluations=100, engine="random").system.rules == TRUE.rules


def test_weights_come_back():
    start = system((1.8, 1.8, 1.8), 4.0, (5.0, 20.0, 10.0), (0.4, 1.0, 0.7))
    found = fuzzy.tune(start, X, Y, move=["weights"], evaluations=400, engine="random")
    assert found.after < 0.02 * found.before


def test_checking_data_choose_among_the_best_so_far():
    noisy = Y + 3 * np.random.default_rng(3).normal(size=Y.shape)
    few, rest = slice(0, None, 8), slice(1, None, 2)
    options: dict[str, Any] = {"evaluations": 300, "engine": "random", "seed": 2}
    plain = fuzzy.tune(BENT, X[few], noisy[few], **options)
    found = fuzzy.tune(BENT, X[few], noisy[few], check=(X[rest], Y[rest]), **options)
    assert found.evaluated.costs.tolist() == plain.evaluated.costs.tolist()
    assert found.check_after == pytest.approx(rmse(found.system, X[rest], Y[rest]))
    assert found.check_after < rmse(plain.system, X[rest], Y[rest])
    assert found.after > plain.after
    assert found.check_before == pytest.approx(rmse(BENT, X[rest], Y[rest]))


def test_folds_do_not_see_what_they_hold_back():
    options: dict[str, Any] = {"folds": 3, "evaluations": 60, "engine": "random"}
    folds = cross_validate_tuning(BENT, X, Y, **options)
    bent = Y.copy()
    bent[folds[0].held] += 50
    again = cross_validate_tuning(BENT, X, bent, **options)
    assert again[0].tuned.system == folds[0].tuned.system
    assert again[0].after > 40 > folds[0].after
    assert again[1].tuned.system != folds[1].tuned.system
    np.testing.assert_array_equal(np.sort(np.concatenate([f.held for f in folds])), np.arange(60))


def test_it_stops_and_goes_on_to_the_same_end(tmp_path):
    options: dict[str, Any] = {"evaluations": 120, "engine": "random"}
    whole = fuzzy.tune(BENT, X, Y, **options)

    def stop(found):
        if len(found) > 50:
            raise KeyboardInterrupt

    part = fuzzy.tune(BENT, X, Y, folder=tmp_path, progress=stop, **options)
    assert part.stopped == "interrupted"
    assert part.evaluations < 120
    assert part.after == part.evaluated.costs.min()
    assert fuzzy.tune(BENT, X, Y, folder=tmp_path, **options).system == whole.system
    with pytest.raises(fuzzy.InputError, match="holds another search: data changed"):
        fuzzy.tune(BENT, X, Y + 1, folder=tmp_path, **options)


@pytest.mark.parametrize(
    ("settings", "message"),
    [
        ({"move": ["consequent"]}, "did you mean 'consequents'"),
        ({"engine": "cma"}, "did you mean 'cmaes'"),
        ({"evaluations": 0}, "evaluations must be"),
        ({"check": (X, Y[:5])}, r"x has the shape \(60, 1\) and y \(5, 1\)"),
        ({"check": (np.hstack([X, X]), Y)}, "1 inputs and 1 outputs"),
    ],
)
def test_what_cannot_be_tuned(settings, message):
    with pytest.raises(fuzzy.InputError, match=message):
        fuzzy.tune(BENT, X, Y, **settings)


@pytest.fixture
def files(tmp_path):
    fuzzy.write_fis(BENT, tmp_path / "bent.fis")
    for name, rows in (("data", slice(0, None, 2)), ("check", slice(1, None, 2))):
        table = pd.DataFrame({"y [N]": Y[rows, 0], "a [m]": X[rows, 0]})
        table.to_csv(tmp_path / f"{name}.csv", index=False)
    return tmp_path


def test_the_command(files, capsys):
    common = [
        "tune",
        str(files / "data.csv"),
        str(files / "bent.fis"),
        "--evaluations",
        "150",
        "--engine",
        "random",
        "-q",
    ]
    options = ["--check", str(files / "check.csv"), "--folds", "3", "--history", str(files / "h.csv"), "--json"]
    assert main([*common, *options, "-o", str(files / "tuned.fis")]) == 0
    found = json.loads(capsys.readouterr().out)
    tuned = fuzzy.read_fis(files / "tuned.fis")
    assert found["after"] == pytest.approx(rmse(tuned, X[::2], Y[::2]))
    assert found["check"]["after"] == pytest.approx(rmse(tuned, X[1::2], Y[1::2]))
    assert found["check"]["after"] < found["check"]["before"]
    assert found["evaluations"] == len(pd.read_csv(files / "h.csv")) == 150
    assert found["folds"]["mean"] == pytest.approx(np.mean([f["after"] for f in found["folds"]["each"]]))
    assert "tuned on data.csv, chosen on check.csv" in (files / "tuned.fis").read_text()
    assert main([*common, "--move", "consequents", "--folds", "2", "-o", str(files / "b.fis")]) == 0
    said = capsys.readouterr().out
    assert " N after 150 evaluations of 3 parameters" in said
    assert "mean " in said


@pytest.mark.parametrize(
    ("arguments", "fragment"),
    [
        (["--move", "memberhsips"], "did you mean 'memberships'"),
        (["--move", ","], "at least one of"),
        (["--folds", "99"], "from 2 to the number of samples (30), got 99"),
        (["--check", "none.csv"], "none.csv"),
    ],
)
def test_bad_options_of_the_command_are_one_message(files, arguments, fragment, capsys):
    common = ["tune", str(files / "data.csv"), str(files / "bent.fis"), "-o", str(files / "x.fis"), "-q"]
    assert main([*common, "--engine", "random", *arguments]) == 2
    said = capsys.readouterr().err
    assert fragment in said
    assert "Traceback" not in said
    assert not (files / "x.fis").exists()
