"""Accuracy against size, against all candidates of a small space, scikit-learn, and data whose rules are known."""

import json
import sys
from itertools import product

import numpy as np
import pytest
from sklearn.linear_model import Ridge

import fuzzy
from fuzzy.commands.application import main
from fuzzy.extras import MissingPackageError
from fuzzy.fitting.consequents import IdentificationError
from fuzzy.fitting.folds import fold_rows
from fuzzy.fitting.identification import checked
from fuzzy.inference import infer_quietly
from fuzzy.insight.interpretability import interpretability
from fuzzy.plugins.front.figures import plot_rule_front
from fuzzy.plugins.front.search import RuleFront, RuleFrontPoint, point_of, search_rules
from fuzzy.plugins.front.space import RuleSpace

RIDGE = 1e-3


def step_and_noise(samples: int = 240, seed: int = 0) -> tuple[np.ndarray, np.ndarray]:
    """Five inputs (samples, 5), of which the second and the fourth tell the output, and 5 % of noise."""
    rng = np.random.default_rng(seed)
    x = rng.uniform(-1, 1, (samples, 5))
    y = np.tanh(4 * x[:, 1]) * (1 + x[:, 3])
    return x, y + 0.05 * y.std() * rng.standard_normal(samples)


def space_of(x: np.ndarray, y: np.ndarray, **settings: object) -> RuleSpace:
    data = checked(x, y)
    whole = {"terms": (2, 3), "orders": (0, 1), "rules": 4, "ridge": RIDGE, **settings}
    return RuleSpace(data, held=fold_rows(len(x), 4), **whole)  # type: ignore[arg-type]


def undominated(points: list[RuleFrontPoint]) -> list[tuple[int, float]]:
    return sorted(
        {
            (p.operations, p.error)
            for p in points
            if not any(
                q.operations <= p.operations
                and q.error <= p.error
                and (q.operations, q.error) != (p.operations, p.error)
                for q in points
            )
        }
    )


def test_it_finds_what_all_candidates_of_a_small_space_have():
    rng = np.random.default_rng(3)
    x = rng.uniform(0, 1, (60, 1))
    y = np.sin(3 * x[:, 0]) + 0.1 * rng.standard_normal(60)
    space = space_of(x, y, terms=(2, 3), rules=3)
    genes = product(*(range(n + 1) for n in space.upper))
    every = {space.candidate(np.array(g)) for g in genes}
    points = [p for c in every if c.rules and (p := point_of(space, c)) is not None]
    found = search_rules(x, y, rules=3, terms=(2, 3), ridge=RIDGE, folds=4, generations=40)
    best = undominated(points)
    assert len(best) > 3
    assert [p.operations for p in found.points] == [size for size, _ in best]
    np.testing.assert_allclose([p.error for p in found.points], [error for _, error in best], rtol=1e-9)
    assert found.evaluated <= len(every)


def test_the_size_that_is_searched_by_is_that_of_the_system_and_the_errors_are_near():
    x, y = step_and_noise()
    space = space_of(x, np.column_stack([y, x[:, 0] ** 2]))
    rng = np.random.default_rng(1)
    seen = 0
    for _ in range(60):
        candidate = space.candidate(rng.integers(0, space.upper + 1))
        point = point_of(space, candidate) if candidate.rules else None
        if point is not None:
            error, operations = space.objectives(candidate)
            assert operations == point.operations == interpretability(point.system).operations
            # The fits of the end scale inputs by the samples of their fold, the search by all.
            assert error == pytest.approx(point.error, rel=0.02)
            seen += 1
    assert seen > 30


def test_errors_are_those_of_ridge_regression_on_the_rules_shares():
    x, y = step_and_noise()
    found = search_rules(x, y, orders=(0,), rules=4, ridge=RIDGE, folds=4, generations=5, seed=2)
    for point in found.points:
        names = [int(v.name.removeprefix("input")) - 1 for v in point.system.inputs]
        shares = np.asarray(fuzzy.infer(point.system, x[:, names]).weights)
        squares = []
        for rows in fold_rows(len(x), 4, seed=2):
            rest = np.setdiff1d(np.arange(len(x)), rows)
            fit = Ridge(RIDGE * len(rest), fit_intercept=False).fit(shares[rest], y[rest] - y[rest].mean())
            squares.append(np.mean((fit.predict(shares[rows]) + y[rest].mean() - y[rows]) ** 2) / y.var())
        assert point.error == pytest.approx(np.sqrt(np.mean(squares)), rel=1e-6)


def test_only_what_tells_the_output_is_asked_for():
    x, y = step_and_noise()
    found = search_rules(x, y, rules=5, generations=40)
    chosen = found.points[found.chosen]
    assert {v.name for v in chosen.system.inputs} == {"input2", "input4"}
    assert chosen.error < 0.15  # the noise alone is 0.05
    sizes, errors = ([getattr(p, name) for p in found.points] for name in ("operations", "error"))
    assert sizes == sorted(set(sizes))
    assert errors == sorted(set(errors), reverse=True)
    unseen, told = step_and_noise(seed=9)
    residual = infer_quietly(chosen.system, unseen[:, [1, 3]]).output[:, 0] - told
    assert np.sqrt(np.mean(residual**2)) / told.std() < 1.3 * chosen.error


def test_of_noise_nothing_is_learnt():
    x, y = step_and_noise()
    found = search_rules(x, np.random.default_rng(5).permutation(y), rules=5, generations=15)
    assert found.points[found.chosen].rules == 1
    assert found.points[found.chosen].error > 0.93


def test_the_same_seed_gives_the_same_front():
    x, y = step_and_noise(80)
    first, second = (search_rules(x, y, rules=3, generations=4, seed=7) for _ in range(2))
    assert [p.system for p in first.points] == [p.system for p in second.points]
    assert first.table().equals(second.table())


@pytest.mark.parametrize(
    ("settings", "said"),
    [
        ({"rules": 0}, "rules must be a whole number >= 1, got 0"),
        ({"terms": (1, 3)}, "terms must be whole numbers >= 2, got 1"),
        ({"terms": ()}, "terms must be whole numbers >= 2, got none"),
        ({"orders": (2,)}, r"orders must be of 0 \(constants\) and 1 \(linear\), got \(2,\)"),
        ({"ridge": 0.0}, "ridge must be a number > 0, got 0.0"),
        ({"generations": 0}, "generations must be a whole number >= 1, got 0"),
    ],
)
def test_settings_out_of_range_are_told(settings, said):
    with pytest.raises(IdentificationError, match=said):
        search_rules(*step_and_noise(20), **settings)


def test_without_pymoo_it_says_what_to_install(monkeypatch):
    monkeypatch.setitem(sys.modules, "pymoo", None)
    with pytest.raises(MissingPackageError, match="pip install pymoo"):
        search_rules(*step_and_noise(20))


def test_the_picture_shows_every_point_and_marks_the_chosen_one():
    x, y = step_and_noise(80)
    found: RuleFront = search_rules(x, y, rules=3, generations=4)
    (ax,) = plot_rule_front(found).axes
    drawn = [np.asarray(line.get_xdata()).tolist() for line in ax.lines]
    assert [p.operations for p in found.points] in drawn
    assert [found.points[found.chosen].operations] in drawn


def test_the_command_writes_systems_that_err_as_it_says(tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    x, y = step_and_noise(100)
    unseen, told = step_and_noise(100, seed=1)
    for name, table in (("data", np.column_stack([x, y])), ("kept", np.column_stack([unseen, told]))):
        np.savetxt(f"{name}.csv", table, delimiter=",", header="a,b,c,d,e,v", comments="")
    options = ["--rules", "3", "--generations", "5", "--test", "kept.csv", "--plot", "front.png", "--json"]
    assert main(["front", "data.csv", "-o", "found", *options]) == 0
    said = json.loads(capsys.readouterr().out)
    assert (tmp_path / "front.png").read_bytes().startswith(b"\x89PNG")
    assert said["samples"] == 100
    for row in said["points"]:
        system = fuzzy.read_fis(row["file"])
        places = ["abcde".index(v.name) for v in system.inputs]
        assert len(system.rules) == row["rules"]
        error = np.sqrt(np.mean((infer_quietly(system, unseen[:, places]).output[:, 0] - told) ** 2)) / y.std()
        assert row["test"] == pytest.approx(error, rel=1e-9)
    assert len((tmp_path / "found" / "front.csv").read_text().splitlines()) == len(said["points"]) + 1
    assert 1 <= said["chosen"] <= len(said["points"])


def test_a_table_to_test_on_is_read_before_the_search(tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr("fuzzy.plugins.front.search.search_rules", None)  # which would fail
    x, y = step_and_noise(20)
    np.savetxt("data.csv", np.column_stack([x, y]), delimiter=",", header="a,b,c,d,e,v", comments="")
    np.savetxt("kept.csv", x, delimiter=",", header="a,b,c,d,e", comments="")
    assert main(["front", "data.csv", "-o", "found", "--test", "kept.csv"]) == 2
    assert "kept.csv" in capsys.readouterr().err
