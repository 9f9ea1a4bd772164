"""Pictures of formation data and of the networks learnt from them: thesis Figs 5.3-5.5, 5.8, 5.9, 5.12 and 5.13."""

from collections.abc import Mapping, Sequence
from typing import NamedTuple

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.markers import MarkerStyle
from matplotlib.path import Path as Outline

from anfis.state import Epoch
from fuzzy.figures.drawing import COLORS, DOUBLE, LINES, new_figure, style
from robotics.experiments.learning.formationdata import FormationRun

_NARROWEST = 2e-3  # m/s or rad/s: an axis shows at least so much, or rounding would fill it
_ARROW = Outline([(1.0, 0.0), (-0.8, 0.6), (-0.35, 0.0), (-0.8, -0.6), (1.0, 0.0)], closed=True)
_MARKS = 7  # equal times at which a formation's poses are drawn


class Fit(NamedTuple):
    """An output over samples, each array (samples,): the data, and what networks give, by stage of learning."""

    label: str  # of the output, with its unit
    target: np.ndarray
    found: Mapping[str, np.ndarray]


def plot_formation_paths(runs: Mapping[str, FormationRun]) -> Figure:
    """Draw where leader and followers drive, a panel for each formation   [thesis, Fig 5.3].

    Arrow heads show the poses at seven equal times; a grey line joins the robots of one time.
    """
    with style():
        rows = (len(runs) + 1) // 2
        figure = new_figure(DOUBLE, 0.3 + 1.45 * rows)
        axes = figure.subplots(rows, 2, sharex=True, sharey=True, squeeze=False).ravel()
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
        for ax in axes[max(len(runs) - 2, 0) : len(runs)]:
            ax.set_xlabel("x [m]")
            ax.tick_params(labelbottom=True)
        figure.legend(*axes[0].get_legend_handles_labels(), loc="outside upper left", ncols=2)
        return figure


def plot_formation_signals(runs: Mapping[str, FormationRun], turns: Mapping[str, np.ndarray]) -> Figure:
    """Draw the leader's posture and all velocities over time, a line for each formation   [thesis, Figs 5.4, 5.5].

    ``turns`` holds w_l and w_f (2, samples) [rad/s] of each formation of ``runs``.
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
    with style():
        figure = new_figure(DOUBLE, 6.2)
        axes = figure.subplots(4, 2, sharex=True)
        for ax, (label, values) in zip(axes.ravel(), panels, strict=True):
            for name in runs:
                ax.plot(runs[name].time, values(name), linewidth=0.9, label=name)
            ax.set_ylabel(label, parse_math=False)
            _widen(ax)
            ax.locator_params(nbins=4)
        for ax in axes[-1]:
            ax.set_xlabel("time [s]")
        figure.align_ylabels()
        figure.legend(*axes[0, 0].get_legend_handles_labels(), loc="outside upper left", ncols=len(runs))
        return figure


def plot_fits(columns: Mapping[str, Sequence[Fit]]) -> Figure:
    """Draw networks' outputs over data, a row for each output, a column for each set   [thesis, Figs 5.8, 5.9, 5.12].

    The root mean square of each difference from the data stands over its panel, in the order of the legend.
    """
    with style():
        rows = max(len(fits) for fits in columns.values())
        figure = new_figure(DOUBLE, 0.4 + 1.3 * rows)
        axes = figure.subplots(rows, len(columns), sharex="col", squeeze=False)
        for (title, fits), column in zip(columns.items(), axes.T, strict=True):
            for ax, fit in zip(column, fits, strict=True):
                ax.plot(fit.target, color="0.6", linestyle="-", linewidth=2.0, label="data")
                errors = []
                for k, (stage, found) in enumerate(fit.found.items()):
                    ax.plot(found, color=COLORS[k], linestyle=LINES[1 - k % 2], linewidth=0.9, label=stage)
                    errors.append(f"{np.sqrt(np.mean((found - fit.target) ** 2)):.1e}")
                ax.set_ylabel(fit.label, parse_math=False)
                _widen(ax)
                ax.locator_params(nbins=4)
                ax.set_title(f"RMSE {', '.join(errors)}", fontsize=7, loc="right", pad=2)
            column[0].set_title(title, fontsize=8, loc="left", pad=2)
            column[-1].set_xlabel("sample")
        figure.align_ylabels()
        handles, labels = axes[0, 0].get_legend_handles_labels()
        figure.legend(handles, labels, loc="outside upper left", ncols=len(labels))
        return figure


def plot_epochs(histories: Mapping[str, Sequence[Epoch]]) -> Figure:
    """Draw training and checking error of several networks over the epochs, logarithmic   [thesis, Fig 5.13]."""
    with style():
        figure = new_figure(DOUBLE, 2.9)
        axes = figure.subplots(1, 2, sharex=True, sharey=True)
        for ax, what in zip(axes, ("train", "check"), strict=True):
            for name, history in histories.items():
                ax.plot([row.epoch for row in history], [getattr(row, what) for row in history], label=name)
            ax.set_yscale("log")
            ax.set_title({"train": "training error", "check": "checking error"}[what], fontsize=8)
            ax.set_xlabel("epoch")
        axes[0].set_ylabel("RMSE [m/s, rad/s]")
        figure.legend(*axes[0].get_legend_handles_labels(), loc="outside upper left", ncols=len(histories))
        return figure


def _widen(ax: Axes) -> None:
    low, high = ax.get_ylim()
    if high - low < _NARROWEST:
        ax.set_ylim((low + high - _NARROWEST) / 2, (low + high + _NARROWEST) / 2)
        ax.ticklabel_format(axis="y", useOffset=False)
