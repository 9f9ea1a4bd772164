"""Intervals on what a learnt system says: their coverage, against the definition, and through the command line."""

import csv
import io
import json
import math
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import anfis
import fuzzy
from anfis.commands.application import main
from anfis.data import DataError
from fuzzy.fitting.clustering import ClusteringError


def drawn(rng, count):
    """Noise that grows with x, so that no normal distribution of one width fits."""
    x = rng.uniform(-1, 1, (count, 2))
    return x, np.sin(3 * x[:, 0]) * x[:, 1] + (0.05 + 0.2 * np.abs(x[:, 0])) * rng.standard_t(4, count)


def made(x, y):
    return fuzzy.identify(x, y, "grid", mfs=2)


@pytest.mark.parametrize("level", [0.5, 0.9])
def test_split_intervals_hold_the_share_that_they_promise(level):
    held = []
    for seed in range(60):
        rng = np.random.default_rng(seed)
        learnt, kept, new = drawn(rng, 60), drawn(rng, 199), drawn(rng, 400)
        told = anfis.calibrate(made(*learnt), *kept).interval(new[0], level)
        held.append(np.mean((new[1][:, None] >= told.low) & (new[1][:, None] <= told.high)))
    # Of 60 the mean has a standard deviation of 0.3 % (0.9) and 0.5 % (0.5)
    assert np.mean(held) == pytest.approx(level, abs=0.02)


def test_intervals_of_folds_hold_it_with_all_samples_learnt_from():
    held, widths, split = [], [], []
    for seed in range(25):
        rng = np.random.default_rng(100 + seed)
        (x, y), new = drawn(rng, 80), drawn(rng, 400)
        folds = anfis.cross_validate(made, x, y, anfis.Options(epochs=1), folds=8, seed=seed)
        told = anfis.calibrate(folds, x, y).interval(new[0], 0.9)
        held.append(np.mean((new[1][:, None] >= told.low) & (new[1][:, None] <= told.high)))
        half = anfis.calibrate(made(x[:40], y[:40]), x[40:], y[40:]).interval(new[0], 0.9)
        widths.append(np.mean(told.high - told.low))
        split.append(np.mean(half.high - half.low))
    assert 0.88 <= np.mean(held) <= 0.93
    assert np.median(widths) < np.median(split)  # what half of the samples cost


def test_without_held_back_samples_the_intervals_are_too_narrow():
    # That the promise rests on them: samples that were learnt from tell less than the errors are
    held = []
    for seed in range(20):
        rng = np.random.default_rng(seed)
        learnt, new = drawn(rng, 40), drawn(rng, 400)
        told = anfis.calibrate(fuzzy.identify(learnt[0], learnt[1], "grid", mfs=3), *learnt).interval(new[0], 0.9)
        held.append(np.mean((new[1][:, None] >= told.low) & (new[1][:, None] <= told.high)))
    assert np.mean(held) < 0.8


@settings(max_examples=60, deadline=None)
@given(st.integers(0, 2**32 - 1), st.integers(2, 30), st.floats(0.05, 0.95))
def test_folds_are_ranked_as_barber_and_others_define_it(seed, count, level):
    rng = np.random.default_rng(seed)
    x, y = rng.uniform(-1, 1, (count, 1)), rng.normal(size=(count, 1))
    fold_of = rng.permutation(np.arange(count) % 2)
    ends = [rng.normal(size=2) for _ in range(2)]
    systems = [
        fuzzy.Sugeno(
            [fuzzy.Variable("x", (-1, 1), {"low": fuzzy.Triangle(-3, -1, 1), "high": fuzzy.Triangle(-1, 1, 3)})],
            [fuzzy.Variable("y", (-9, 9), {"a": fuzzy.Constant(a), "b": fuzzy.Constant(b)})],
            ["if x is low then y is a", "if x is high then y is b"],
        )
        for a, b in ends
    ]
    trained: list[Any] = [SimpleNamespace(system=fis) for fis in systems]
    folds = anfis.CrossValidation(
        tuple(anfis.Fold(np.flatnonzero(fold_of == k), 0.0, each) for k, each in enumerate(trained))
    )
    new = rng.uniform(-1, 1, (3, 1))
    told = anfis.calibrate(folds, x, y).interval(new, level)
    errors = np.array([abs(float(systems[fold_of[i]](x[i])[0]) - y[i, 0]) for i in range(count)])
    for j, point in enumerate(new):
        said = np.array([float(systems[fold_of[i]](point)[0]) for i in range(count)])
        rank = math.ceil((count + 1) * level - 1e-9)
        high = np.sort(said + errors)[rank - 1] if rank <= count else math.inf
        low = np.sort(said - errors)[count - rank] if rank <= count else -math.inf
        assert (told.low[j, 0], told.high[j, 0]) == pytest.approx((low, high))


def test_few_samples_promise_nothing_for_a_high_level():
    x, y = drawn(np.random.default_rng(0), 8)
    told = anfis.calibrate(made(*drawn(np.random.default_rng(1), 40)), x, y)
    assert np.isinf(told.interval(x, 0.95).high).all()
    assert np.isfinite(told.interval(x, 0.8).high).all()


def test_outside_is_where_no_data_are():
    rng = np.random.default_rng(2)
    x, y = drawn(rng, 300)
    x[:, 1] *= 1000  # units do not matter
    told = anfis.calibrate(made(x, y), x, y)
    assert told.outside(np.array([[3.0, 0.0], [0.0, 3000.0]])).all()
    assert not told.outside(np.array([[0.0, 0.0], [0.5, -500.0]])).any()
    again = drawn(rng, 2000)[0] * [1, 1000]
    assert told.outside(again).mean() < 0.03
    ring = x[np.hypot(x[:, 0], x[:, 1] / 1000) > 0.6]  # a hole in the middle of the data
    assert anfis.calibrate(made(x, y), ring, np.zeros(len(ring))).outside([[0.0, 0.0]])[0]


@pytest.mark.parametrize(
    ("x", "y", "error"),
    [
        ([[0.0]], [1.0], DataError),
        ([[0.0, 0.0], [1.0, 1.0]], [1.0], DataError),
        ([[0.0, 0.0], [1.0, math.nan]], [1.0, 1.0], ClusteringError),
        ([[0.0, 0.0]], [1.0], DataError),
    ],
)
def test_samples_that_do_not_suit_are_refused(x, y, error):
    with pytest.raises(error):
        anfis.calibrate(made(*drawn(np.random.default_rng(0), 40)), x, y)


@pytest.mark.parametrize("level", [0.0, 1.0, -1.0, 90.0])
def test_a_level_is_a_share(level):
    x, y = drawn(np.random.default_rng(0), 40)
    with pytest.raises(DataError, match="between 0 and 1"):
        anfis.calibrate(made(x, y), x, y).interval(x, level)


def test_the_command_adds_the_ends_of_each_output(tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    rng = np.random.default_rng(3)
    for name, count in (("learnt", 80), ("kept", 99), ("new", 30)):
        x, y = drawn(rng, count)
        rows = "\n".join(f"{a},{b},{c}" for (a, b), c in zip(x, y, strict=True))
        (tmp_path / f"{name}.csv").write_text(f"p [m],q,y [m/s]\n{rows}\n", encoding="utf-8")
    assert main(["train", "learnt.csv", "--rules", "4", "--epochs", "2", "-o", "net.fis"]) == 0
    capsys.readouterr()
    assert main(["predict", "net.fis", "new.csv", "--interval", "0.9", "--held-out", "kept.csv"]) == 0
    header, *lines = csv.reader(io.StringIO(capsys.readouterr().out))
    assert header == ["y [m/s]", "y low [m/s]", "y high [m/s]", "outside"]
    found = np.array(lines, dtype=float)
    told = anfis.calibrate(fuzzy.read_fis("net.fis"), *_columns("kept.csv")).interval(_columns("new.csv")[0], 0.9)
    np.testing.assert_array_equal(found[:, 1:3], np.hstack([told.low, told.high]))
    assert main(["predict", "net.fis", "new.csv", "--interval", "0.9", "--held-out", "kept.csv", "--json"]) == 0
    assert {*json.loads(capsys.readouterr().out)["outputs"]} == {"y", "y low", "y high", "outside"}
    assert main(["predict", "net.fis", "new.csv", "--interval", "0.9"]) != 0
    assert "--held-out" in capsys.readouterr().err


def _columns(name):
    table = np.loadtxt(name, delimiter=",", skiprows=1)
    return table[:, :2], table[:, 2]
