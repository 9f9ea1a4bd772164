"""Pictures of the control laws themselves: the reaching law's push, and the fuzzy rule bases.

These are the thesis's Figs 2.3, 2.19, 2.20, 2.23, 2.24, 6.4, 6.5, 6.20 and 6.21.
"""

from collections.abc import Iterator
from contextlib import contextmanager

import numpy as np
from matplotlib.artist import setp
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from fuzzy.figures.drawing import COLORS, DOUBLE, LINES, PAGE_WIDTH, number, styled_figure
from fuzzy.figures.plot import plot_memberships, plot_surface
from robotics.laws.tracking.fuzzy_tracking import load_rule_base
from robotics.laws.tracking.sliding_mode import attraction

_ALPHA, _REACH = 3.0, 2.0  # s/m: α in the exponent of Q(S); m/s: the largest |S|
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
        pictures = (
            ("distance", "v"),
            ("alpha", "w"),
            (("distance", "x_err"), "v"),
            (("alpha", "x_err"), "w"),
        )
        for ax, (inputs, output) in zip(axes.flat, pictures, strict=True):
            fixed = {name: value for name, value in ahead.items() if name not in inputs}
            plot_surface(fis, inputs, output, fixed, ax=ax)
            ax.set_title(_held(fixed), fontsize=7)
        setp(axes[:, 1], xlabel="α [rad]")
        axes[0, 1].set_ylabel("ω [rad/s]")
        figure.axes[-1].set_ylabel("ω [rad/s]")  # the colour bar
        return figure


def _held(fixed: dict[str, float]) -> str:
    names = {"x_err": "x_err", "alpha": "α", "distance": "distance", "heading_err": "heading_err"}
    units = {"x_err": "m", "alpha": "rad", "distance": "m", "heading_err": "rad"}
    return "at " + ", ".join(f"{names[name]} = {number(value)} {units[name]}" for name, value in fixed.items())


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
