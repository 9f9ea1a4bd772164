"""The picture at the head of a report: who leads in which scenario, by how much, and how sure that is."""

import textwrap
from collections.abc import Sequence
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D

from fuzzy.figures.drawing import COLORS, styled_figure
from robotics.laws.catalogue import law_title
from robotics.measures.leading import Lead, Standing
from robotics.show.figures.drawing import panel_grid, write_log_ticks

_WIDTH, _COLUMNS = 10.0, 3  # inches; panels side by side
_LEADS, _OTHER, _TOUCHED = COLORS[0], "0.35", COLORS[1]
_MOST = 1000.0  # times the leader's: what is more is drawn at the edge
_TICKS = (0.2, 0.5, 1, 1.5, 2, 3, 5, 10, 20, 50, 100, 200, 500, 1000)


def plot_leads(leads: Sequence[Lead], width: float = _WIDTH, columns: int = _COLUMNS) -> Figure:
    """Draw a panel for each scenario, in it a row for each law: its mean over the leader's, with the 95 % interval.

    Laws that lead, or cannot be told from the leader, are filled; a law with contacts is crossed out; one that never
    arrives or settles in some run stands at the right edge.

    Args:
        leads: Who leads in each scenario.
        width: The width of the picture [inches].
        columns: How many panels stand side by side.
    """
    columns = min(columns, len(leads))
    rows = [leads[k : k + columns] for k in range(0, len(leads), columns)]
    heights = [max(len(lead.standings) for lead in row) for row in rows]
    legend = 0.17 * (3 - min(columns, 3))  # inches: its three entries stand below each other where it is narrow
    with styled_figure(width, sum(0.155 * n + 0.52 for n in heights) + 0.35 + legend) as figure:
        for ax, lead in zip(panel_grid(figure, len(leads), columns, [n + 2 for n in heights]), leads, strict=True):
            _draw(ax, lead)
        figure.supxlabel("times the leader's mean, with the 95 % interval over the seeds", fontsize=8)
        figure.legend(
            [
                Line2D([], [], color=_LEADS, marker="o", markersize=5, linestyle="none"),
                Line2D([], [], color=_OTHER, marker="o", markersize=4, markerfacecolor="white", linestyle="none"),
                Line2D([], [], color=_TOUCHED, marker="X", markersize=6, linestyle="none"),
            ],
            ["leads, or cannot be told from who does", "behind", "contact: does not count"],
            loc="outside upper right",
            ncol=min(columns, 3),
            fontsize=7.5,
        )
        return figure


def _draw(ax: Axes, lead: Lead) -> None:
    best = lead.best if lead.best > 0 else np.nan
    reach = 1.0
    for row, standing in enumerate(lead.standings):
        value, color = standing.value, _TOUCHED if standing.contacts else _LEADS if standing.leads else _OTHER
        if words := _beside(standing):
            ax.text(0.99, row, words, transform=ax.get_yaxis_transform(), ha="right", va="center", fontsize=6.3,
                    color=_TOUCHED if standing.contacts else "0.25",
                    bbox={"facecolor": "white", "edgecolor": "none", "alpha": 0.75, "pad": 0.4}, zorder=5)  # fmt: skip
        ratio = value.value / best
        if not np.isfinite(ratio) or ratio <= 0:  # on a logarithmic axis: a robot inside another has no place there
            continue
        low, high = (np.clip(v / best, 0.02, _MOST) if np.isfinite(v) else ratio for v in (value.low, value.high))
        reach = max(reach, min(ratio, _MOST), high)
        ax.plot([low, high], [row, row], color=color, linestyle="-", linewidth=1.2)
        filled = standing.leads or standing.contacts
        look: dict[str, Any] = {"marker": "X", "markersize": 6} if standing.contacts else {"marker": "o"}
        look = {"markersize": 5 if standing.leads else 4, "markerfacecolor": color if filled else "white"} | look
        ax.plot([min(ratio, _MOST)], [row], color=color, linestyle="none", zorder=4, **look)
    ax.axvline(1.0, color="0.6", linewidth=0.7, zorder=0)
    ax.set_xscale("log")
    left = 0.9 if np.isnan(best) else min(0.9, _least(lead) / best / 1.15)
    right = reach * (1.35 if reach < 3 else 2.2)
    ax.set_xlim(left, max(right, 1.35))
    ticks = [t for t in _TICKS if left <= t <= right and (reach > 3 or t <= 3)]
    write_log_ticks(ax.xaxis, ticks[:: 1 + len(ticks) // 6] if reach > 3 else ticks, "{:g}×".format)
    names = [textwrap.shorten(law_title(s.law), 34, placeholder="…") for s in lead.standings]
    ax.set_yticks(range(len(names)), names, fontsize=6.5)
    for tick, standing in zip(ax.get_yticklabels(), lead.standings, strict=True):
        tick.set_parse_math(False)
        tick.set_fontweight("bold" if standing.leads else "normal")
    ax.tick_params(axis="x", labelsize=6.5)
    ax.set_ylim(len(names) - 0.4, -0.6)
    ax.yaxis.grid(False)
    ax.set_title(f"{lead.scenario}: {lead.title}", fontsize=7.5, loc="right", parse_math=False)


def _least(lead: Lead) -> float:
    """The least mean that is drawn: one with contacts may lie below the leader's, and others where larger is better."""
    return min((v for s in lead.standings if np.isfinite(v := s.value.value) and v > 0), default=lead.best)


def _beside(standing: Standing) -> str:
    """What is written at the edge of a law's row."""
    if standing.contacts:
        return f"contact in {standing.contacts} of {standing.value.runs}"
    if not np.isfinite(standing.value.value):
        return "never, in some run"
    return ""
