"""The pictures of learning: what is on the axes, and that nothing is drawn of what has no picture."""

from dataclasses import replace

import numpy as np
import pytest
import torch
from matplotlib.patches import Rectangle

import anfis
import fuzzy
from anfis.data import DataError
from anfis.plot import TrainingPlotError, data_pictures
from tests.drawn import faults_of, x_of, y_of

torch.set_num_threads(1)
X = np.random.default_rng(4).uniform(-1, 1, (60, 3))
Y = np.sin(3 * X[:, 0]) + X[:, 1] * X[:, 2]
START = fuzzy.identify(X, Y, "grid", kind="gaussmf", fit=False)
RESULT = anfis.train(START, X, Y, anfis.Options(epochs=8), check=(X[:20] + 0.01, Y[:20] + 0.05))


def test_training_marks_the_least_checking_error(tmp_path):
    figure = anfis.plot_training(RESULT.history)
    errors, steps = figure.axes
    best = min(RESULT.history, key=lambda row: row.check)
    train, check, mark = errors.get_lines()
    assert errors.get_yscale() == "log"
    np.testing.assert_array_equal(train.get_ydata(), [row.train for row in RESULT.history])
    np.testing.assert_array_equal(check.get_ydata(), [row.check for row in RESULT.history])
    assert (x_of(mark)[0], y_of(mark)[0]) == (best.epoch, best.check)
    np.testing.assert_array_equal(steps.get_lines()[0].get_ydata(), [row.step for row in RESULT.history])
    fuzzy.save_figure(figure, tmp_path / "a.pdf")


def test_training_without_checking_data_and_with_a_perfect_fit():
    history = [anfis.Epoch(0, 1.0, float("nan"), 0.1, 3), anfis.Epoch(1, 0.0, float("nan"), 0.1, 3)]
    errors = anfis.plot_training(history).axes[0]
    assert errors.get_yscale() == "linear"
    assert [line.get_label() for line in errors.get_lines()] == ["training", "least training error: 0, epoch 1"]
    assert anfis.plot_training(history[:1]).axes[0].get_yscale() == "log"
    with pytest.raises(TrainingPlotError, match="no epoch"):
        anfis.plot_training([])


def test_premises_before_and_after(tmp_path):
    figure = anfis.plot_premises(START, RESULT.system)
    shown = [ax for ax in figure.axes if ax.get_visible()]
    assert [ax.get_xlabel() for ax in shown] == ["input1", "input2", "input3"]
    for ax, old, new in zip(shown, START.inputs, RESULT.system.inputs, strict=True):
        lines = ax.get_lines()
        assert len(lines) == 4
        for k, name in enumerate(old.terms):
            before, after = lines[2 * k : 2 * k + 2]
            assert before.get_linewidth() < after.get_linewidth()
            assert before.get_color() == after.get_color()
            np.testing.assert_allclose(y_of(before), old.terms[name](x_of(before)))
            np.testing.assert_allclose(y_of(after), new.terms[name](x_of(after)))
        looks = {(line.get_color(), str(line.get_linestyle())) for line in lines}
        assert len(looks) == len(old.terms)
    names = [text.get_text() for text in figure.legends[0].get_texts()]
    assert names == ["before learning", "after", "term 1", "term 2"]  # each input calls them otherwise
    assert not [fault for fault in faults_of(figure) if "has no unit" not in fault]  # these inputs have none
    fuzzy.save_figure(figure, tmp_path / "a.png")
    other = replace(START, inputs=[replace(START.inputs[0], name="else"), *START.inputs[1:]], rules=())
    with pytest.raises(TrainingPlotError, match="same inputs and terms"):
        anfis.plot_premises(START, other)


def test_fit_shows_data_output_and_residuals(tmp_path):
    figure = anfis.plot_fit(RESULT.system, X + 0.5, Y)  # outside the universes too, without a warning
    over, against, residuals = figure.axes
    data, found = over.get_lines()
    np.testing.assert_array_equal(data.get_ydata(), Y)
    expected = replace(RESULT.system, out_of_range="ignore")(X + 0.5)[:, 0]
    np.testing.assert_array_equal(found.get_ydata(), expected)
    np.testing.assert_array_equal(against.get_lines()[1].get_xdata(), Y)
    assert sum(bar.get_height() for bar in residuals.patches if isinstance(bar, Rectangle)) == len(Y)
    fuzzy.save_figure(figure, tmp_path / "a.svg")
    with pytest.raises(anfis.DataError, match=r"given inputs must be \(samples, 3\)"):
        anfis.plot_fit(RESULT.system, X[:, :2], Y)


def test_a_set_of_pictures_shows_the_rows_that_are_whole_and_the_outputs_that_are_measured() -> None:
    d = fuzzy.Variable("d", (0, 1), {"near": fuzzy.trimf(0, 0, 1), "far": fuzzy.trimf(0, 1, 1)})
    v, w = (fuzzy.Variable(name, (0, 1), {"slow": 0.0, "fast": 1.0}) for name in "vw")
    rules = ["if d is near then v is slow and w is fast", "if d is far then v is fast", "if d is far then w is slow"]
    fis = fuzzy.Sugeno([d], [v, w], rules)
    x, y = np.array([[0.0], [0.5], [np.nan], [1.0]]), np.array([[0.1], [0.5], [0.2], [np.nan]])
    y = np.hstack([y, np.full_like(y, np.nan)])  # w has no column
    (picture,) = data_pictures(fis, {"data": (x, y)})
    assert picture.caption.startswith("The outputs beside 2 rows of data")
    assert picture.draw is not None
    measured, found = picture.draw().axes[0].lines
    assert list(y_of(measured)) == [0.1, 0.5]
    assert list(y_of(found)) == list(fis(x[:2])[:, 0])
    assert data_pictures(fis, {"data": None}) == data_pictures(fis, {}) == []
    for inputs, outputs in ((x, np.full_like(y, np.nan)), (np.full_like(x, np.nan), y)):
        with pytest.raises(DataError, match="no row"):
            data_pictures(fis, {"data": (inputs, outputs)})
