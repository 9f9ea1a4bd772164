"""The thesis's figures: of its laws and rule bases, of recovery after an outage, and of how coordination scales.

Of laws they are its Figs 2.3, 2.19, 2.20, 2.23, 2.24, 6.4, 6.5, 6.20 and 6.21.
"""

import textwrap
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from typing import Any

import numpy as np
from matplotlib.artist import setp
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.ticker import FuncFormatter

from fuzzy.figures.drawing import COLORS, DOUBLE, LINES, PAGE_WIDTH, number, styled_figure
from fuzzy.figures.plot import plot_memberships, plot_surface
from robotics.laws.catalogue import law_title
from robotics.laws.tracking.fuzzy_tracking import load_rule_base
from robotics.laws.tracking.sliding_mode import attraction
from robotics.measures.evidence import Estimate, rate_of
from robotics.plugins.thesis.recovery import Recovery, Scaling
from robotics.show.figures.drawing import TARGET, draw_common_legend, panel_grid, scale_values

_ALPHA, _REACH = 3.0, 2.0  # s/m: α in the exponent of Q(S); m/s: the largest |S|
_UNITS = {"x_err": "m", "alpha": "rad", "distance": "m", "heading_err": "rad"}  # of the inputs of fuzzy tracking
# The turns: what they are called, and what they are over
_TURNS = {"lateral": ("λ", "y_err"), "eta": ("η", "d_ij"), "theta": ("Θ", "ro")}
# (K, μ0) of each panel: the same K with the law ever steeper, and the thesis's μ0 with other K beside its CSM
_SETTINGS = (((0.2, 1.0), (0.2, 0.5), (0.2, 0.2), (0.2, 0.1)), ((0.4, 0.1), (0.2, 0.1), (0.1, 0.1), (1.0, 1.0)))


def plot_switching(width: float = DOUBLE) -> Figure:
    """Draw the push K/Q(S) sign S of (2.22) over S, thesis Fig 2.3.

    ``width`` is that of the figure in inches; narrow ones have the panels below each other.
    """
    # Both sides of 0 are on the grid, so that the jump is drawn upright.
    half = np.concatenate([[1e-9], np.linspace(0, _REACH, 201)[1:]])
    s = np.concatenate([-half[::-1], half])
    steep = list(dict.fromkeys(pair for group in _SETTINGS for pair in group if pair[1] < 1))
    rows, columns = (1, len(_SETTINGS)) if width > PAGE_WIDTH else (len(_SETTINGS), 1)
    with styled_figure(width, 2.6 * rows) as figure:
        for n, group in enumerate(_SETTINGS):
            ax = figure.add_subplot(rows, columns, n + 1)
            for k, mu0 in sorted(group, key=lambda pair: -pair[0] / pair[1]):  # as the curves end, from above
                push = k / attraction(s, mu0, _ALPHA) * np.sign(s)
                i = steep.index((k, mu0)) if mu0 < 1 else -1
                color, line = (COLORS[i % 6], LINES[1 + i % 6]) if mu0 < 1 else ("black", "-")
                name = f"K = {number(k)}, μ₀ = {number(mu0)}" + ("" if mu0 < 1 else ": conventional")
                ax.plot(s, push, color=color, linestyle=line, label=name)
            ax.set(xlabel="S [m/s]", ylabel="push K/Q(S) sign S [m/s²]", xlim=(-_REACH, _REACH))
            ax.legend(loc="upper left", handlelength=2.8, borderaxespad=0.2)  # a push never opposes S: nothing is there
        return figure


def plot_tracking_memberships(width: float = DOUBLE) -> Figure:
    """Draw the membership functions of distance and α, thesis Fig 2.19; ``width`` is that of the figure in inches."""
    fis = load_rule_base("tracking")
    with _pair(width) as (figure, left, right):
        plot_memberships(fis, "distance", ax=left)
        plot_memberships(fis, "alpha", ax=right)
        right.set_xlabel("α [rad]")
        return figure


def plot_tracking_velocities(width: float = DOUBLE) -> Figure:
    """Draw v over the distance and ω over α with the target ahead; below, both over x_err. Thesis Fig 2.20.

    ``width`` is that of the figure in inches.
    """
    fis = load_rule_base("tracking")
    ahead = {"x_err": 0.1, "alpha": 0.0, "distance": 0.15, "heading_err": 0.0}
    ahead = {name: ahead[name] for name in ahead if name in {v.name for v in fis.inputs}}
    with styled_figure(width, 4.6) as figure:
        axes = figure.subplots(2, 2)
        pictures = ((("distance",), "v"), (("alpha",), "w"), (("distance", "x_err"), "v"), (("alpha", "x_err"), "w"))
        for ax, (inputs, output) in zip(axes.flat, pictures, strict=True):
            fixed = {name: value for name, value in ahead.items() if name not in inputs}
            plot_surface(fis, inputs, output, fixed, ax=ax)
            said = [f"{'α' if n == 'alpha' else n} = {number(v)} {_UNITS[n]}" for n, v in fixed.items()]
            ax.set_title(f"at {', '.join(said)}", fontsize=7)
        setp(axes[:, 1], xlabel="α [rad]")
        axes[0, 1].set_ylabel("ω [rad/s]")
        figure.axes[-1].set_ylabel("ω [rad/s]")  # the colour bar
        return figure


def plot_turn(rule_base: str, width: float = DOUBLE) -> Figure:
    """Draw a rule base of one input: its membership functions, and the turn over the input.

    Args:
        rule_base: "lateral", with λ over y_err, thesis Figs 2.23 and 2.24; "eta", with η of (6.4) over d_ij, Figs 6.4
            and 6.5; or "theta", with Θ of (6.7) over ro, Figs 6.20 and 6.21. The thesis uses these two numbers twice;
            meant are those of ro and Θ.
        width: The width of the figure in inches.
    """
    fis, (symbol, argument) = load_rule_base(rule_base), _TURNS[rule_base]
    with _pair(width) as (figure, left, right):
        plot_memberships(fis, 0, ax=left)
        plot_surface(fis, 0, 0, ax=right)
        for ax in (left, right):
            ax.set_xlabel(f"{argument} [m]")
        right.set_ylabel(f"{symbol} [rad]")
        return figure


@contextmanager
def _pair(width: float) -> Iterator[tuple[Figure, Axes, Axes]]:
    """A figure of two panels beside each other, or below each other where it is narrow."""
    rows, columns = (1, 2) if width > PAGE_WIDTH else (2, 1)
    with styled_figure(width, 2.0 * rows) as figure:
        axes = figure.subplots(rows, columns)
        figure.draw_without_rendering()
        yield figure, *axes


# Of many team runs -----------------------------------------------------------------------------------------------

_MARKERS = "os^Dv"


def plot_recovery(recoveries: Sequence[Recovery], width: float = DOUBLE) -> Figure:
    """Draw the share of runs that recover, with Wilson's interval, and the largest distance from the path.

    Controllers stand side by side at each length of an outage, so that none covers another.

    Args:
        recoveries: What is drawn, by controller and outage.
        width: The width of the figure in inches.
    """
    names = list(dict.fromkeys(r.controller for r in recoveries))
    with styled_figure(width, 2.3 + 0.15 * len(names)) as figure:
        left, right = figure.subplots(1, 2)
        for i, name in enumerate(names):
            mine = [r for r in recoveries if r.controller == name]
            at = np.array([r.outage for r in mine]) + 0.5 * (i - (len(names) - 1) / 2)
            look = {"color": COLORS[i], "linestyle": LINES[i], "marker": _MARKERS[i], "markersize": 4, "linewidth": 0.9}
            shares = [rate_of(r.recovered) for r in mine]
            ends = np.array([[s.value - s.low, s.high - s.value] for s in shares]).T
            values = [100 * s.value for s in shares]
            left.errorbar(at, values, 100 * ends, label=law_title(name), capsize=2, elinewidth=0.8, **look)
            right.plot(at, [float(r.deviation.mean()) for r in mine], **look)
        left.axvline(15.0, color="0.45", linewidth=0.8, linestyle=(0, (4, 2)))
        left.text(14.7, 3, "limit in\nthe thesis", fontsize=7, color="0.3", ha="right")
        left.set(ylim=(-3, 103), ylabel="teams that recover [%]")
        right.set_ylim(bottom=0)
        right.set_ylabel("largest distance from\nthe path, mean [m]")
        for ax in (left, right):
            ax.set_xticks(sorted({r.outage for r in recoveries}))
            ax.set_xlabel("length of the outage [s]")
        counts = sorted({len(r.recovered) for r in recoveries})
        columns, title = 3 if width > PAGE_WIDTH else 1, f"{' or '.join(map(str, counts))} runs a point"
        figure.legend(loc="outside upper left", ncol=columns, title_fontsize=7, title=title)
        return figure


def plot_robot_errors(
    means: Mapping[str, Sequence[Sequence[Estimate]]], titles: Sequence[str], width: float = DOUBLE
) -> Figure:
    """Draw errors of several laws, a panel for each kind of error, in it a row for each law and a dot for each robot.

    Bars are the intervals of the means. An axis whose values span more than a decade is logarithmic, and says so.

    Args:
        means: By the law's title, for each kind of error the means of the robots.
        titles: The kinds of errors, with their units.
        width: The width of the figure in inches.
    """
    columns = 4 if width > PAGE_WIDTH else 2
    with styled_figure(width, 0.3 + -(-len(titles) // columns) * (0.55 + 0.34 * len(means))) as figure:
        axes = panel_grid(figure, len(titles), columns)
        for k, (ax, title) in enumerate(zip(axes, titles, strict=True)):
            _draw_robot_errors(ax, [kinds[k] for kinds in means.values()], title)
        axes[0].set_yticks(range(len(means)), [textwrap.fill(name, 22) for name in means], parse_math=False)
        axes[0].set_ylim(len(means) - 0.5, -0.5)
        draw_common_legend(figure, axes[:1], loc="outside upper right")
        return figure


def _draw_robot_errors(ax: Axes, rows: Sequence[Sequence[Estimate]], title: str) -> None:
    known = np.array([mean.value for row in rows for mean in row])
    logarithmic = scale_values(ax, known)
    for row, robots in enumerate(rows):
        for i, mean in enumerate(robots):
            at = row + 0.22 * (i - (len(robots) - 1) / 2)
            low = max(mean.low, known.min() / 2) if logarithmic else mean.low
            ax.plot([low, mean.high], [at, at], color=COLORS[i], linestyle="-", linewidth=0.9)
            look: dict[str, Any] = {"color": COLORS[i], "marker": _MARKERS[i], "markersize": 3.5, "linestyle": "none"}
            ax.plot([mean.value], [at], **look, label=f"robot {i + 1}")
    if not logarithmic:
        ax.set_xlim(0.0, 1.1 * max(mean.high for row in rows for mean in row if np.isfinite(mean.high)))
    ax.xaxis.set_major_formatter(FuncFormatter(lambda value, _: number(value)))
    ax.yaxis.grid(False)
    ax.set_xlabel(f"{title}\n← better{'; logarithmic' if logarithmic else ''}", parse_math=False)


def plot_scaling(scaling: Sequence[Scaling], width: float = DOUBLE) -> Figure:
    """Draw spread and delay of the arrivals over the number of robots, a line for each share of lost messages.

    A point is one team. Below the grey line arrivals differ by less than a sample.

    Args:
        scaling: The teams.
        width: The width of the figure in inches.
    """
    losses = sorted({s.loss for s in scaling})
    sizes = sorted({s.robots for s in scaling})
    with styled_figure(width, 2.5) as figure:
        left, right = figure.subplots(1, 2)
        for i, loss in enumerate(losses):
            mine = [s for s in scaling if s.loss == loss]
            at = np.array([s.robots for s in mine]) * 1.02 ** (i - (len(losses) - 1) / 2)
            look = {"color": COLORS[i], "linestyle": LINES[i], "marker": _MARKERS[i], "markersize": 4}
            look |= {"linewidth": 1.0 + 0.8 * (len(losses) - 1 - i)}  # lines below others are wider
            left.plot(at, [s.spread for s in mine], label=f"{100 * loss:g} % of messages lost", **look)
            right.plot(at, [s.late for s in mine], **look)
        step = max(s.step for s in scaling)
        left.axhline(step, **TARGET)
        left.text(0.02, step, f" a sample: {step:g} s", transform=left.get_yaxis_transform(), va="bottom", fontsize=6.5)
        for ax in (left, right):
            ax.set_xscale("log")
            ax.set_xticks(sizes, [str(n) for n in sizes])
            ax.minorticks_off()
            ax.set_xlabel("robots, logarithmic")
        left.set(ylim=(0.0, 1.15 * max(2 * step, *(s.spread for s in scaling))), ylabel="spread of the arrivals [s]")
        right.set_ylabel("arrival of the last\nafter the reference's end [s]")
        figure.legend(loc="outside upper center", ncol=len(losses), title="one team a point", title_fontsize=7)
        return figure
