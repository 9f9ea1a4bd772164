"""The pictures of an arena: every number stands where it should, failures are said, and nothing overlaps."""

from dataclasses import replace

import numpy as np
import pytest
from matplotlib.colors import same_color
from matplotlib.figure import Figure
from matplotlib.text import Text

from fuzzy.figures.drawing import COLORS
from robotics.measures.statistics.intervals import Interval, wilson
from robotics.plugins.arena.figures import (
    Entrant,
    Standings,
    plot_budget,
    plot_improvement,
    plot_pareto,
    plot_ranking,
    plot_robustness,
)
from robotics.show.figures.drawing import PlotError
from tests.drawn import faults_of, x_of, y_of

LAWS = (
    Entrant("Fuzzy", "fuzzy"),
    Entrant("Fuzzy, with λ(y_err)", "fuzzy"),
    Entrant("Parallel compensation", "fuzzy"),
    Entrant("Lyapunov", "lyapunov"),
    Entrant("Conventional SM", "lyapunov"),
    Entrant("Arbitrary 2nd-order SM", "lyapunov"),
    Entrant("Quasi-continuous SM", "lyapunov"),
    Entrant("Exponential SM", "lyapunov"),
    Entrant("Pure pursuit", "geometric"),
    Entrant("PID", "linear"),
    Entrant("LQR", "linear"),
    Entrant("NMPC", "predictive"),
    Entrant("MPPI", "predictive"),
)
COUNT, NMPC = len(LAWS), 11
RATIOS = np.array([1.2, 1.25, 1.3, 1.15, 1.6, 1.55, np.inf, 1.22, 1.4, 1.8, 1.06, 1.0, 1.1])


def about(value: np.ndarray, width: float = 0.03) -> Interval:
    return Interval(value, value * (1 - width), value * (1 + width))


def standings() -> Standings:
    published = RATIOS * 1.3
    published[3], published[4] = 55.0, np.nan
    return Standings(
        LAWS, "NMPC", about(published), about(RATIOS), wilson(np.arange(COUNT) * 3, 1600),
        np.linspace(0.5, 8.0, COUNT), np.geomspace(0.2, 300.0, COUNT),
        np.array([42, 43, 12, 5, 4, 4, 5, 6, 3, 6, 4, 0, 8]),
    )  # fmt: skip


def written(figure: Figure) -> list[str]:
    return [text.get_text() for text in figure.findobj(Text) if text.get_visible() and text.get_text()]


def test_the_ranking_has_every_law_in_order_with_both_costs_and_its_columns():
    figure = plot_ranking(standings())
    assert faults_of(figure) == []
    ax = figure.axes[0]
    names = [label.get_text().split("  ") for label in ax.get_yticklabels()]
    order = np.argsort(RATIOS)
    assert [name for name, _ in names] == [LAWS[k].title for k in order]
    assert [rank for _, rank in names] == [*map(str, range(1, COUNT)), "–"]
    points = {(round(float(x_of(line)[0]), 4), line.get_markerfacecolor()) for line in ax.lines if len(x_of(line)) == 1}
    filled = {x for x, face in points if face != "white"}
    hollow = {x for x, face in points if face == "white"}
    assert filled == set(RATIOS[np.isfinite(RATIOS)].round(4))
    assert hollow == {round(1.3 * r, 4) for k, r in enumerate(RATIOS) if np.isfinite(r) and k not in (3, 4)}
    bars = [x_of(line).tolist() for line in ax.lines if len(x_of(line)) == 2 and y_of(line)[0] == y_of(line)[1]]
    assert [1.2 * 0.97, 1.2 * 1.03] in bars
    words = written(figure)
    assert "fails ▸" in words
    assert "published: 55× ▸" in words
    assert "0 (≤ 0.24)" in words  # none of 1,600 failed: up to 0.24 % may
    for law, label in zip(order, ax.get_yticklabels(), strict=True):
        assert same_color(label.get_color(), COLORS[0]) == (LAWS[law].family == "fuzzy")


def test_a_ranking_without_a_finite_cost_is_refused():
    nothing = Interval(*[np.full(COUNT, np.inf)] * 3)
    with pytest.raises(PlotError, match="no law has a finite cost"):
        plot_ranking(replace(standings(), tuned=nothing, published=nothing))


def test_the_budget_names_its_lines_at_their_ends_and_names_stay_apart():
    budgets = np.array([50, 100, 200, 500, 1000])
    ends = np.where(np.isfinite(RATIOS), RATIOS, 1.21)  # three laws end within 2 %
    value = ends[:, None] * np.linspace(1.5, 1.0, 5)
    value[6] = np.inf
    figure = plot_budget(LAWS, budgets, about(value))
    assert faults_of(figure) == []
    ax = figure.axes[0]
    labels = {text.get_text(): text for text in ax.texts}
    assert set(labels) == {law.title for law in LAWS if law.title != "Quasi-continuous SM"} | {
        "Quasi-continuous SM: fails"
    }
    boxes = [Text.get_window_extent(label) for label in labels.values()]  # without the line that leads there
    assert not any(a.overlaps(b) for k, a in enumerate(boxes) for b in boxes[:k])
    # From bottom to top as the lines end
    heights = [labels[LAWS[k].title].get_position()[1] for k in np.argsort(RATIOS)[:-1]]
    assert heights == sorted(heights)
    drawn = [y_of(line) for line in ax.lines if len(x_of(line)) == 5]
    assert any(np.allclose(row, value[0]) for row in drawn)


def test_the_matrix_says_how_often_and_what_that_means():
    chances = np.linspace(0.02, 0.98, COUNT**2).reshape(COUNT, COUNT)
    verdicts = np.full((COUNT, COUNT), "undecided", dtype="<U10")
    verdicts[0, 1], verdicts[1, 0], verdicts[2, 3] = "better", "worse", "equivalent"
    figure = plot_improvement(LAWS, Interval(chances, chances, chances), verdicts)
    assert faults_of(figure) == []
    cells = {text.get_position(): text.get_text() for text in figure.axes[0].texts}
    assert len(cells) == COUNT * (COUNT - 1)
    assert cells[1, 0] == f"{100 * chances[0, 1]:.0f} ▲"
    assert cells[0, 1] == f"{100 * chances[1, 0]:.0f} ▼"
    assert cells[3, 2] == f"{100 * chances[2, 3]:.0f} ="


def test_the_heat_map_has_numbers_brackets_and_failures():
    changes = ("mass +20 %", "mass −20 %", "latency ×2")
    value = np.tile([1.3, 1.01, 2.5], (COUNT, 1))
    value[3, 2] = np.inf
    value[4, 0] = np.nan
    figure = plot_robustness(LAWS, changes, about(value))
    assert faults_of(figure) == []
    cells = {text.get_position(): text.get_text() for text in figure.axes[0].texts}
    assert [cells[0, 0], cells[1, 0], cells[2, 0]] == ["1.30", "(1.01)", "2.50"]
    assert cells[2, 3] == "fails"
    assert cells[0, 4] == "–"
    assert [label.get_text() for label in figure.axes[0].get_xticklabels()] == [
        "mass\n+20 %",
        "mass\n−20 %",
        "latency\n×2",
    ]


def test_the_front_joins_what_none_beats_and_names_do_not_overlap():
    random = np.random.default_rng(3)
    effort, error = np.exp(random.normal(size=(2, COUNT)))
    effort[0], error[0] = 0.01, 9.0
    effort[1], error[1] = 0.02, 0.01  # beats all but the first
    error[2] = np.inf
    published = 1.4 * np.column_stack([effort, error])
    figure = plot_pareto(LAWS, effort, error, ("effort [rad/s²]", "error [cm]"), published)
    assert faults_of(figure) == []
    ax = figure.axes[0]
    front = next(line for line in ax.lines if line.get_drawstyle() == "steps-post")
    assert x_of(front).tolist() == [0.01, 0.02]
    names = [text.get_text() for text in ax.texts]
    assert names == [law.title for k, law in enumerate(LAWS) if k != 2]
    boxes = [Text.get_window_extent(text).shrunk(0.98, 0.9) for text in ax.texts]
    assert not any(a.overlaps(b) for k, a in enumerate(boxes) for b in boxes[:k])
    with pytest.raises(PlotError, match="nothing to draw"):
        plot_pareto(LAWS, np.full(COUNT, np.inf), error, ("effort [rad/s²]", "error [cm]"), published)
