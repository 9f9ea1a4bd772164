"""The search over clustering settings, its table and its figure, against identification setting by setting."""

import math
import re
from dataclasses import replace

import numpy as np
import pytest
from matplotlib.figure import Figure

import fuzzy
from fuzzy.figures.search import plot_rules_error
from fuzzy.fitting import search
from fuzzy.fitting.clustering import ClusteringError, ClusteringOptions, DataWarning
from fuzzy.fitting.consequents import IdentificationError
from fuzzy.fitting.identification import identify
from fuzzy.fitting.search import ACCEPTS, RADII, REJECTS, SQUASHES, SearchResult, search_clusters, search_table
from tests.drawn import xy_of

RNG = np.random.default_rng(8)
X = RNG.uniform([-2, 0], [2, 5], (250, 2))
Y = np.sin(2 * X[:, 0]) * np.exp(-0.3 * X[:, 1])
# Table 5.1 of the thesis: radius, squash, accept, reject.
TABLE = [(0.9, 0.5, 0.5, 0.1), (0.5, 0.1, 0.9, 0.7), (0.9, 0.5, 0.5, 0.3)]


@pytest.fixture(scope="module")
def result() -> SearchResult:
    return search_clusters(X, Y, 5, limit=15, output_units=["m/s"], output_names=["v"])


def test_there_are_108_settings_with_those_of_the_thesis_and_matlab(result) -> None:
    tried = [(t.radius, t.options.squash, t.options.accept, t.options.reject) for t in result.trials]
    assert len(tried) == len(set(tried)) == 108
    assert {*TABLE, (0.5, 1.25, 0.5, 0.15)} <= set(tried)
    expected = [(a, b, c, d) for a in RADII for b in SQUASHES for c in ACCEPTS for d in REJECTS if d <= c]
    assert tried == expected


@pytest.mark.parametrize("order", [0, 1])
@pytest.mark.filterwarnings("ignore:the 250 samples determine")
def test_every_trial_is_the_identified_system(order) -> None:
    y = np.column_stack([Y, 100 * X[:, 0] * X[:, 1]])
    result = search_clusters(X, y, 4, radii=[0.5, 0.501, 0.9], squashes=[1.25], order=order)
    assert len(result.trials) == 27
    span = np.ptp(y, axis=0)
    for trial in result.trials:
        fis = identify(X, y, "subtractive", radius=trial.radius, options=trial.options, order=order)
        rmse = np.sqrt(np.mean((np.asarray(fis(X)) - y) ** 2, axis=0))
        assert len(fis.rules) == trial.rules
        assert trial.rmse == pytest.approx(rmse, rel=1e-7, abs=1e-11)
        assert trial.error == pytest.approx(np.sqrt(np.mean((rmse / span) ** 2)), rel=1e-7, abs=1e-11)
        assert trial.parameters == trial.rules * (3 if order else 1) * 2
        assert trial.rank <= trial.parameters


def test_the_error_of_one_output_is_its_rmse(result) -> None:
    for trial in result.trials:
        if trial.rules <= result.limit:
            assert trial.rmse == (trial.error,)


def test_equal_centers_are_fitted_once(result, monkeypatch) -> None:
    calls = []
    real = search.least_squares
    monkeypatch.setattr(search, "least_squares", lambda *a: calls.append(a) or real(*a))
    again = search_clusters(X, Y, 5, limit=15, output_units=["m/s"], output_names=["v"])
    assert len(calls) == again.fitted == result.fitted < 108
    assert np.array([t.error for t in again.trials]) == pytest.approx(
        np.array([t.error for t in result.trials]), rel=0, nan_ok=True
    )


def test_the_best_is_the_best(result) -> None:
    for rules, best in result.by_rules.items():
        same = [t.error for t in result.trials if t.rules == rules]
        assert best.rules == rules
        assert best.error == pytest.approx(min(same), rel=1e-9)
    assert list(result.by_rules) == sorted({t.rules for t in result.trials if t.rules <= result.limit})
    assert result.best == result.by_rules[5]


def test_a_system_is_found_that_fits_exactly_what_such_a_system_made() -> None:
    options = ClusteringOptions(1.25, 0.5, 0.15)
    made = identify(X, Y, "subtractive", radius=0.5, options=options)
    y = np.asarray(made(X))[:, 0]
    # Clustering sees [x y]: the same centers appear again because the fit is close.
    result = search_clusters(X, y, len(made.rules), radii=[0.5], squashes=[1.25], accepts=[0.5], rejects=[0.15])
    assert result.best.rules == len(made.rules)
    assert result.best.error < 0.05 * np.sqrt(np.mean((y - Y) ** 2)) or result.best.error < 0.05 * np.std(y)


def test_too_many_rules_are_not_fitted() -> None:
    result = search_clusters(X, Y, 2, radii=[0.15], limit=3)
    many = [t for t in result.trials if math.isnan(t.error)]
    assert many
    assert {t.rules for t in many} == {4}
    assert all(t.rank == 0 and math.isnan(t.rmse[0]) for t in many)
    assert 4 not in result.by_rules


def test_a_number_of_rules_that_no_setting_gives() -> None:
    result = search_clusters(X, Y, 7, radii=[5.0], squashes=[1.25])
    assert list(result.by_rules) == [1]
    with pytest.raises(IdentificationError, match=r"none of the 9 settings gives 7 rules; found: 1. Try other radii"):
        _ = result.best
    with pytest.raises(IdentificationError, match="gives 7 rules"):
        search_table(result)


def test_progress_counts_the_settings() -> None:
    seen: list[tuple[int, int]] = []
    search_clusters(X, Y, 2, radii=[0.9], squashes=[1.25], progress=lambda *a: seen.append(a))
    assert seen == [(i, 9) for i in range(1, 10)]


def test_the_table_has_the_form_of_table_5_1(result) -> None:
    lines = search_table({"Fuzzy Network 1": result, "Fuzzy Network 2": result}).splitlines()
    assert lines[0].split("  ")[-1].strip() == "Fuzzy Network 2"
    labels = ["Rule Number", "Training Data Error", "Radius", "Squash factor", "Accept ratio", "Reject ratio"]
    assert [re.split(r"  +", line)[0] for line in lines[1:]] == labels
    best = result.best
    values = [
        best.rules,
        float(f"{best.error:.3e}"),
        best.radius,
        best.options.squash,
        best.options.accept,
        best.options.reject,
    ]
    for line, value in zip(lines[1:], values, strict=True):
        assert [float(text) for text in line.split()[-2:]] == pytest.approx([value, value])


def test_a_constant_column_is_told_once() -> None:
    x = np.column_stack([X, np.ones(len(X))])
    with pytest.warns(DataWarning) as said:
        search_clusters(x, Y, 3, radii=[0.9], squashes=[1.25])
    assert len(said) == 1


@pytest.mark.parametrize(
    ("error", "arguments", "message"),
    [
        (IdentificationError, {"rules": 0}, "rules must be a whole number >= 1, got 0"),
        (IdentificationError, {"rules": 8, "limit": 7}, "limit (7) must not be less than rules (8)"),
        (IdentificationError, {"radii": []}, "no setting to try"),
        (IdentificationError, {"accepts": [0.1], "rejects": [0.5]}, "no setting to try"),
        (ClusteringError, {"radii": [0.0]}, "radius must be >= 1e-06 and <= 1e+06"),
        (ClusteringError, {"squashes": [-1.0]}, "squash must be a number >= 0"),
        (ClusteringError, {"y": np.full(250, np.nan)}, "y: row 1, column 1 is nan"),
        (IdentificationError, {"y": Y[:3]}, "x has 250 samples, y 3"),
        (IdentificationError, {"order": 3}, "order must be 0"),
    ],
)
def test_refusals_say_what_is_wrong(error, arguments, message) -> None:
    with pytest.raises(error, match=re.escape(message)):
        search_clusters(**{"x": X, "y": Y, **arguments})


# The figure -------------------------------------------------------------------------------------------------


def texts(figure: Figure) -> list[str]:
    (ax,) = figure.axes
    legend = ax.get_legend()
    assert legend is not None
    return [text.get_text() for text in legend.get_texts()]


def test_the_figure_shows_every_setting_the_best_and_the_wanted(result, tmp_path) -> None:
    figure = plot_rules_error(result)
    (ax,) = figure.axes
    assert ax.get_xlabel() == "number of rules"
    assert ax.get_ylabel() == "training RMSE [m/s]"
    assert ax.get_yscale() == "log"
    dots, line, ring = ax.get_lines()
    fitted = [t for t in result.trials if t.rules <= result.limit]
    assert xy_of(dots).tolist() == [[t.rules, t.error] for t in fitted]
    assert xy_of(line).tolist() == [[k, t.error] for k, t in result.by_rules.items()]
    assert xy_of(ring).tolist() == [[5, result.best.error]]
    assert texts(figure)[-1] == f"5 rules: {result.best.error:.3g} m/s"
    fuzzy.save_figure(figure, tmp_path / "error.png")
    assert (tmp_path / "error.png").stat().st_size > 5000


def test_several_searches_share_the_axes(result) -> None:
    other = replace(result, wanted=10**6)
    figure = plot_rules_error({"leader": result, "follower": other})
    assert [text for text in texts(figure) if "rules" not in text] == ["leader", "follower"]
    assert sum("5 rules" in text for text in texts(figure)) == 1
    with pytest.raises(IdentificationError, match="errors of one kind"):
        plot_rules_error({"a": result, "b": replace(result, outputs=(("w", "rad/s"),))})
    with pytest.raises(IdentificationError, match="no search"):
        plot_rules_error({})


def test_an_error_of_zero_has_no_logarithm(result) -> None:
    exact = replace(result, trials=tuple(t._replace(error=0.0) for t in result.trials))
    assert plot_rules_error(exact).axes[0].get_yscale() == "linear"
    nothing = replace(result, trials=tuple(t._replace(error=math.nan) for t in result.trials))
    with pytest.raises(IdentificationError, match="no setting was fitted"):
        plot_rules_error(nothing)
