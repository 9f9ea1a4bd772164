"""Pictures of formation data and of the networks learnt from them: thesis Figs 5.3-5.5, 5.8, 5.9, 5.12 and 5.13."""

from collections.abc import Mapping, Sequence
from typing import Any, NamedTuple

import numpy as np
from matplotlib.artist import setp
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.markers import MarkerStyle
from matplotlib.path import Path as Outline
from matplotlib.ticker import FuncFormatter, MaxNLocator

from anfis.plot import draw_errors
from anfis.state import Epoch
from fuzzy.figures.drawing import COLORS, COLUMN, DOUBLE, LINES, PAGE_WIDTH, line_look, log_y, styled_figure
from fuzzy.figures.search import plot_rules_error
from fuzzy.fitting.search import SearchResult
from robotics.measures.statistics.ranking import pareto_front
from robotics.plugins.learning.formationdata import FormationRun
from robotics.plugins.learning.formationlearning import Errors
from robotics.show.figures.drawing import draw_common_legend, thinned

_NARROWEST = 2e-3  # m/s or rad/s: an axis shows at least so much, or rounding would fill it
_ARROW = Outline([(1.0, 0.0), (-0.8, 0.6), (-0.35, 0.0), (-0.8, -0.6), (1.0, 0.0)], closed=True)
_STEADY = 0.1  # of an output's range: samples that differ less from each to the next, on the mean, follow each other
_DOTS = ("x", "o")
_MARKS = 7  # equal times at which a formation's poses are drawn


class Fit(NamedTuple):
    """An output over samples, each array (samples,): the data, and what networks give, by stage of learning."""

    label: str  # of the output, with its unit
    target: np.ndarray
    found: Mapping[str, np.ndarray]
    time: np.ndarray | None = None  # s; without, samples are drawn over their number


def plot_formation_paths(runs: Mapping[str, FormationRun], width: float = DOUBLE) -> Figure:
    """Draw where leader and followers drive, a panel for each formation   [thesis, Fig 5.3].

    Arrow heads show the poses at seven equal times; a grey line joins the robots of one time. ``width`` is that of the
    figure in inches.
    """
    columns = 2 if width > PAGE_WIDTH else 1
    rows = -(-len(runs) // columns)
    with styled_figure(width, 0.3 + 1.45 * rows) as figure:
        axes = figure.subplots(rows, columns, sharex=True, sharey=True, squeeze=False).ravel()
        for ax, (title, run) in zip(axes, runs.items(), strict=False):
            at = np.linspace(0, len(run.time) - 1, _MARKS).round().astype(int)
            order = np.argsort(run.y[:, at[0]])  # joined from side to side
            ax.plot(run.x[order][:, at], run.y[order][:, at], color="0.75", linestyle="-", linewidth=0.7, zorder=1)
            for robot, (x, y, heading) in enumerate(zip(run.x, run.y, run.heading, strict=True)):
                color = COLORS[min(robot, 1)]
                label = "leader" if robot == 0 else "followers" if robot == 1 else None
                ax.plot(x, y, color=color, linestyle=LINES[min(robot, 1)], linewidth=0.9, label=label, zorder=2)
                for k in at:
                    head = MarkerStyle(_ARROW).rotated(rad=float(heading[k]))
                    ax.plot(x[k], y[k], marker=head, markersize=7, markeredgewidth=0, color=color, zorder=3)
            ax.set_title(title, fontsize=8, loc="left", pad=2)
            ax.set_aspect("equal")
        for ax in axes[len(runs) :]:
            ax.set_visible(False)
        for ax in axes[: len(runs)]:
            ax.set_ylabel("y [m]")
        for ax in axes[max(len(runs) - columns, 0) : len(runs)]:
            ax.set_xlabel("x [m]")
            ax.tick_params(labelbottom=True)
        draw_common_legend(figure, axes[:1], loc="outside upper left", ncol=2)
        return figure


def plot_formation_signals(
    runs: Mapping[str, FormationRun], turns: Mapping[str, np.ndarray], width: float = DOUBLE
) -> Figure:
    """Draw the leader's posture and all velocities over time, a line for each formation   [thesis, Figs 5.4, 5.5].

    ``turns`` holds w_l and w_f (2, samples) [rad/s] of each formation of ``runs``; ``width`` is that of the figure in
    inches.
    """
    panels = (
        ("x_l [m]", lambda name: runs[name].x[0]),
        ("v_l [m/s]", lambda name: runs[name].v[0]),
        ("y_l [m]", lambda name: runs[name].y[0]),
        ("w_l [rad/s]", lambda name: turns[name][0]),
        ("theta_l [rad]", lambda name: runs[name].heading[0]),
        ("v_f [m/s]", lambda name: runs[name].v[1]),
        ("lead dx [m]", lambda name: runs[name].dx),
        ("w_f [rad/s]", lambda name: turns[name][1]),
    )
    with styled_figure(width, 6.2) as figure:
        axes = figure.subplots(4, 2, sharex=True)
        for ax, (label, values) in zip(axes.ravel(), panels, strict=True):
            for below, name in zip(range(len(runs), 0, -1), runs, strict=True):  # lines below others are wider
                ax.plot(*thinned(runs[name].time, values(name)), linewidth=0.6 + 0.3 * below, label=name)
            ax.set_ylabel(label, parse_math=False)
            _widen(ax)
            ax.locator_params(nbins=4)
        setp(axes[-1], xlabel="time [s]")
        figure.align_ylabels()
        beside = len(runs) if width > PAGE_WIDTH else 2
        draw_common_legend(figure, axes[0, :1], loc="outside upper left", ncol=beside)
        return figure


def plot_fits(columns: Mapping[str, Sequence[Fit]], width: float = DOUBLE) -> Figure:
    """Draw networks' outputs over data, a row for each output, a column for each set   [thesis, Figs 5.8, 5.9, 5.12].

    The root mean square of each difference from the data stands over its panel, in the order of the legend. ``width``
    is that of the figure in inches.
    """
    rows = max(len(fits) for fits in columns.values())
    with styled_figure(width, 0.4 + 1.35 * rows) as figure:
        axes = figure.subplots(rows, len(columns), sharex="col", squeeze=False)
        for (title, fits), column in zip(columns.items(), axes.T, strict=True):
            for ax, fit in zip(column, fits, strict=True):
                time = np.arange(len(fit.target)) if fit.time is None else fit.time
                ax.plot(*thinned(time, fit.target), color="0.6", linestyle="-", linewidth=2.5, label="data")
                errors = []
                for k, (stage, found) in enumerate(fit.found.items()):
                    look = {"color": COLORS[k], "linestyle": LINES[1 - k % 2], "linewidth": 0.9}
                    ax.plot(*thinned(time, found), **look, label=stage)
                    errors.append(f"{rms(found - fit.target):.1e}")
                ax.set_ylabel(fit.label, parse_math=False)
                _widen(ax)
                ax.locator_params(nbins=4)
                ax.set_title(f"RMSE {', '.join(errors)}".replace("-", "−"), fontsize=7, loc="right", pad=2)
            column[0].annotate(
                title, (0.0, 1.0), (0, 11), xycoords="axes fraction", textcoords="offset points", fontsize=8
            )
            column[-1].set_xlabel("sample" if fits[0].time is None else "time [s]")
        figure.align_ylabels()
        draw_common_legend(figure, axes[0, :1], loc="outside upper left")
        return figure


def plot_searches(searches: Mapping[str, SearchResult], width: float = DOUBLE) -> Figure:
    """Draw the searches for clusters of several networks, a panel for each unit of their outputs   [thesis, Fig 5.6].

    Args:
        searches: The searches, one output each, by name; the ring marks the number of rules that is wanted.
        width: The width of the figure in inches.
    """
    units = list(dict.fromkeys(search.outputs[0][1] for search in searches.values()))
    with styled_figure(width, 3.0) as figure:
        for ax, unit in zip(figure.subplots(1, len(units), squeeze=False)[0], units, strict=True):
            plot_rules_error({n: s for n, s in searches.items() if s.outputs[0][1] == unit}, ax)
        return figure


def plot_stages(sets: Mapping[str, Fit]) -> Figure:
    """Draw one network over its data, each set in a row: over the samples, the difference, and against the data.

    Samples that follow each other stand in their order; of others, whose output jumps from each to the next, those
    with the least output come first. The root mean square of each difference stands over its panel.

    Args:
        sets: The set's title, and the output over it, by stage of learning.
    """
    with styled_figure(DOUBLE, 0.35 + 2.7 * len(sets)) as figure:
        grid = figure.add_gridspec(2 * len(sets), 2, width_ratios=(2.2, 1), height_ratios=(1.9, 0.8) * len(sets))
        for row, (title, fit) in enumerate(sets.items()):
            over = figure.add_subplot(grid[2 * row, 0])
            below = figure.add_subplot(grid[2 * row + 1, 0], sharex=over)
            _draw_stages(over, below, figure.add_subplot(grid[2 * row : 2 * row + 2, 1]), fit)
            errors = ", then ".join(f"{rms(found - fit.target):.2e}" for found in fit.found.values())
            over.set_title(f"{title}: RMSE {errors}", fontsize=8, loc="left", pad=3, parse_math=False)
        figure.align_ylabels()
        draw_common_legend(figure, figure.axes[:1], loc="outside upper left", markerscale=2)
        return figure


def _draw_stages(over: Axes, below: Axes, against: Axes, fit: Fit) -> None:
    run = _follow_each_other(fit.target)
    order = np.arange(len(fit.target)) if run else np.argsort(fit.target, kind="stable")
    ends = [float(fit.target.min()), float(fit.target.max())]
    against.plot(ends, ends, color="0.6", linestyle="-", linewidth=1.2)
    look: dict[str, Any] = {"linewidth": 2.0, "zorder": 2} if run else {"linewidth": 1.0, "zorder": 3}
    over.plot(fit.target[order], color="0.6", linestyle="-", label="data", **look)
    below.axhline(0.0, color="0.6", linestyle="-", linewidth=1.0)
    for k, (stage, found) in enumerate(fit.found.items()):
        dots: dict[str, Any] = {"linestyle": "none", "marker": _DOTS[k % 2], "color": COLORS[k], "alpha": 0.6}
        dots |= {"markersize": 2.5, "markeredgewidth": 0.0 if k % 2 else 0.5}
        line = {"color": COLORS[k], "linestyle": LINES[1 - k % 2], "linewidth": 0.9}
        over.plot(found[order], label=stage, **(line if run else dots))
        below.plot((found - fit.target)[order], **(line if run else dots))
        against.plot(fit.target, found, **dots)
    for ax in (over, against):
        _widen(ax)
    over.set_ylabel(fit.label, parse_math=False)
    over.margins(x=0)
    over.tick_params(labelbottom=False)
    below.set(ylabel="difference", xlabel="sample" if run else "sample, in the order of the data's output")
    against.set_xlabel(f"data: {fit.label}", parse_math=False)
    against.set_ylabel("network")


def rms(values: np.ndarray) -> float:
    """The root mean square of all values."""
    return float(np.sqrt(np.mean(values**2)))


def _follow_each_other(values: np.ndarray) -> bool:
    """Whether the samples (n,) hang together, as those along a run do."""
    return bool(np.abs(np.diff(values)).mean() <= _STEADY * np.ptp(values)) if len(values) > 1 else True


def plot_search_and_epochs(search: SearchResult, history: Sequence[Epoch], unit: str) -> Figure:
    """Draw how one network was found: errors over the number of rules   [thesis, Fig 5.6], then over the epochs [5.13].

    Args:
        search: The search over the settings of the clusters, of one output.
        history: The epochs of learning.
        unit: The unit of the output.
    """
    with styled_figure(DOUBLE, 3.1) as figure:
        left, right = figure.subplots(1, 2)
        plot_rules_error(search, left)
        draw_errors(right, history)
        if len(history) == 1:
            for line in right.get_lines():
                line.set_marker("o")
        right.xaxis.set_major_locator(MaxNLocator(integer=True, min_n_ticks=1))
        right.set_xlabel("epoch")
        right.set_ylabel(f"RMSE [{unit}]" if unit else "RMSE", parse_math=False)
        right.legend(loc="upper center", bbox_to_anchor=(0.5, -0.2), borderaxespad=0, ncols=2)
        return figure


def plot_front_of_rules(points: Sequence[tuple[int, float]]) -> Figure:
    """Draw what rule bases of several sizes lose against their teacher; filled is what no smaller one loses less than.

    Args:
        points: Numbers of rules, and errors as shares of the outputs' ranges.
    """
    rules, errors = np.array(points, dtype=float).T
    ahead = pareto_front(np.stack([rules, errors], axis=1))
    with styled_figure(COLUMN, 2.4) as figure:
        ax = figure.subplots()
        ax.plot(rules[ahead], 100 * errors[ahead], "o-", color=COLORS[0], label="fewer rules lose more")
        ax.plot(
            rules[~ahead], 100 * errors[~ahead], "o", color=COLORS[0], markerfacecolor="white", label="fewer do as well"
        )
        ax.xaxis.set_major_locator(MaxNLocator(6, integer=True))
        ax.set(xlabel="number of rules", ylabel="error [% of the range]", ylim=(0.0, 105 * errors.max()))
        ax.legend()
        return figure


def plot_shares(errors: Sequence[Errors]) -> Figure:
    """Draw the errors of networks beside each other, a row for each output, in per cent of the output's range.

    A grey bar shows how far the output scatters at equal inputs, as far as it is known.
    """
    looks: dict[str, dict[str, Any]] = {
        "after clustering": {"marker": "o", "markerfacecolor": "white", "color": COLORS[0]},
        "after learning, training": {"marker": "s", "color": COLORS[0], "markersize": 4.5},
        "after learning, checking": {"marker": "D", "color": COLORS[1], "markersize": 4.5},
    }
    spans = np.array([each.range or np.nan for each in errors])
    shares = 100 * (np.array([(e.clustering, e.training, e.checking) for e in errors]).T / spans)
    scattered = 100 * (np.array([each.scatter[1:] for each in errors]) / spans[:, None])
    known = shares[np.isfinite(shares)]
    with styled_figure(DOUBLE, 0.85 + 0.24 * len(errors)) as figure:
        ax = figure.add_subplot()
        rows = np.arange(len(errors))
        least = min(known[known > 0], default=1e-3)
        for row, (low, high) in zip(rows, scattered, strict=True):
            if high > 0:  # a bar of no length would not be seen
                ends = [max(low, least / 2), max(high, 1.1 * max(low, least / 2))]
                ax.plot(ends, [row, row], color="0.75", linewidth=7, linestyle="-", solid_capstyle="butt", zorder=1)
        ax.plot([], [], color="0.75", linewidth=7, linestyle="-", label="scatter of the data at equal inputs")
        for (name, look), values in zip(looks.items(), shares, strict=True):
            if np.isfinite(values).any():
                ax.plot(values, rows, linestyle="none", label=name, **look)
        if (known > 0).all():
            ax.set_xscale("log")
            for axis_formatter in (ax.xaxis.set_major_formatter, ax.xaxis.set_minor_formatter):
                axis_formatter(FuncFormatter(lambda value, _: f"{value:g}" if f"{value:.0e}"[0] in "125" else ""))
        ax.set_yticks(rows, [each.network.output for each in errors], parse_math=False)
        ax.set(ylim=(len(errors) - 0.5, -0.5), xlabel="RMSE [% of the output's range]")
        ax.set_xlim(left=least / 2 if ax.get_xscale() == "log" else 0.0)
        ax.grid(axis="x", color="0.9", linewidth=0.6)
        draw_common_legend(figure, [ax], loc="outside upper left", ncol=4, markerscale=0.9)
        return figure


def plot_epochs(histories: Mapping[str, Sequence[Epoch]], units: Mapping[str, str], width: float = DOUBLE) -> Figure:
    """Draw training and checking error of several networks over the epochs, logarithmic   [thesis, Fig 5.13].

    Args:
        histories: The epochs of learning, by the name of the output.
        units: The unit of each output; those of one unit share a row.
        width: The width of the figure in inches.
    """
    rows = {unit: [name for name in histories if units[name] == unit] for unit in dict.fromkeys(units.values())}
    with styled_figure(width, 0.7 + 1.6 * len(rows)) as figure:
        axes = figure.subplots(len(rows), 2, sharex=True, sharey="row", squeeze=False)
        for pair, (unit, names) in zip(axes, rows.items(), strict=True):
            for ax, what in zip(pair, ("train", "check"), strict=True):
                for k, name in enumerate(histories):
                    if name in names:
                        history = histories[name]
                        errors = [getattr(row, what) for row in history]
                        ax.plot([row.epoch for row in history], errors, **line_look(k), label=name)
                log_y(ax, "1235")
            pair[0].set_ylabel(f"RMSE [{unit}]", parse_math=False)
        for ax, title in zip(axes[0], ("training error", "checking error"), strict=True):
            ax.set_title(title, fontsize=8)
        setp(axes[-1], xlabel="epoch")
        draw_common_legend(figure, axes[:, 0], loc="outside upper left", ncol=len(histories))
        return figure


def _widen(ax: Axes) -> None:
    low, high = ax.get_ylim()
    if high - low < _NARROWEST:
        ax.set_ylim((low + high - _NARROWEST) / 2, (low + high + _NARROWEST) / 2)
        ax.ticklabel_format(axis="y", useOffset=False)
