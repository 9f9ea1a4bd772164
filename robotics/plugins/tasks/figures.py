"""The picture of an arena of tasks: contacts, deadlocks and time of every law, ranked in classes of knowledge."""

from collections.abc import Sequence
from itertools import pairwise
from typing import NamedTuple

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D

from fuzzy.figures.drawing import COLORS, styled_figure
from fuzzy.figures.palette import ROLES
from robotics.measures.statistics.intervals import Interval
from robotics.plugins.arena.figures import WIDTH

_MARKS = ("o", "s", "D")  # of the classes, each with a colour of its own
_PER = 1000  # runs that shares are told of


class TaskRow(NamedTuple):
    """A law as the picture shows it."""

    title: str
    knowledge: int  # the number of its class
    rank: int  # in it, from 1


def plot_tasks(
    rows: Sequence[TaskRow],
    classes: Sequence[str],
    caused: Interval,
    unguarded: Interval,
    deadlocks: Interval,
    time: Interval,
) -> Figure:
    """Draw the one look: a row a law, the classes below each other, the first of each class on top.

    Filled marks are laws as they are, hollow ones the same without their emergency rule, each with its 95 % interval.

    Args:
        rows: The laws, in the order in which they stand below each other.
        classes: The names of the classes.
        caused: The shares of runs with a contact caused (laws,).
        unguarded: The same without the emergency rule; not-a-number: there is none.
        deadlocks: The shares of deadlocks (laws,).
        time: The mean time over nominal (laws,).
    """
    gaps = np.cumsum([0, *(a.knowledge != b.knowledge for a, b in pairwise(rows))])
    places = np.arange(len(rows)) + 0.9 * gaps + 0.9
    with styled_figure(WIDTH, 1.0 + 0.21 * float(places[-1] + 1)) as figure:
        axes = figure.subplots(1, 3, sharey=True, width_ratios=[1.35, 1.0, 1.0])
        for ax, found in zip(axes, (caused, deadlocks, time), strict=True):
            scale = 1.0 if found is time else float(_PER)
            for place, row, value, low, high in zip(places, rows, found.value, found.low, found.high, strict=True):
                _draw(ax, place, row.knowledge, scale * np.array([value, low, high]), hollow=False)
            ax.grid(axis="x", alpha=0.4, linewidth=0.4)
        for place, row, *ends in zip(places, rows, unguarded.value, unguarded.low, unguarded.high, strict=True):
            if np.isfinite(ends[0]):
                _draw(axes[0], place + 0.28, row.knowledge, _PER * np.array(ends), hollow=True)
        for ax in axes[:2]:
            ax.set_xscale("symlog", linthresh=10, linscale=0.6)
            ax.set_xlim(-1.5, _PER * 1.15)
            ax.set_xticks([0, 10, 100, _PER], ["0", "10", "100", "1000"])
            ax.minorticks_off()
        axes[0].set_xlabel("contacts caused\n[per 1000 runs]  ← better")
        axes[1].set_xlabel("deadlocks\n[per 1000 runs]  ← better")
        axes[2].set_xlabel("time over nominal [1]\n← better")
        axes[2].set_xlim(left=min(1.0, float(np.nanmin(time.low))) - 0.08)
        if np.isfinite(unguarded.value).any():
            hollow = Line2D([], [], linestyle="", marker="o", color="0.3", markerfacecolor="white", markersize=4)
            axes[0].legend(
                [hollow],
                ["without its emergency rule"],
                loc="upper right",
                fontsize=6,
                borderpad=0.1,
                handletextpad=0.1,
            )
        axes[0].set_yticks(places, [f"{row.title}  {row.rank}" for row in rows])
        axes[0].set_ylim(places[-1] + 0.7, -0.4)
        axes[0].tick_params(axis="y", length=0)
        for number, name in enumerate(classes):
            own = [place for place, row in zip(places, rows, strict=True) if row.knowledge == number]
            if own:
                axes[0].text(
                    -0.02,
                    min(own) - 0.85,
                    name,
                    transform=axes[0].get_yaxis_transform(),
                    color=COLORS[number],
                    fontweight="bold",
                    fontsize=7,
                    ha="right",
                    va="center",
                )
                for ax in axes:
                    ax.axhspan(min(own) - 0.5, max(own) + 0.5, color=ROLES["band"].light, linewidth=0, zorder=0)
    return figure


def _draw(ax: Axes, place: float, number: int, ends: np.ndarray, *, hollow: bool) -> None:
    """Draw a value with its interval (3,), the value first."""
    color = COLORS[number]
    ax.plot(ends[1:], [place, place], color=color, linestyle="-", linewidth=1.0, zorder=2)
    ax.plot(
        ends[0],
        place,
        _MARKS[number],
        color=color,
        markersize=4,
        markerfacecolor="white" if hollow else color,
        zorder=3,
    )
