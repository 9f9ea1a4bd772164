"""The picture of an ablation: a panel for each number that some part changes, in it a row for each variant."""

from collections.abc import Mapping
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from fuzzy.figures.drawing import COLORS, styled_figure
from robotics.plugins.ablation.ablation import Ablation
from robotics.plugins.ablation.tasks import MEASURED
from robotics.show.figures.drawing import panel_grid

_WIDTH, _COLUMNS = 10.0, 4  # inches; panels side by side
_ROW, _FRAME = 0.17, 0.75  # inches


def plot_ablation(found: Ablation) -> Figure:
    """Draw how much worse the law drives without each of its parts, with 95 % intervals; what is worse is filled."""
    table = found.table
    every = list(table.groupby(["task", "measured"], sort=False))
    panels = [panel for panel in every if (panel[1]["difference"] != 0).any()] or every
    names = list(dict.fromkeys(table["variant"]))
    lines = -(-len(panels) // _COLUMNS)
    with styled_figure(_WIDTH, lines * (_ROW * len(names) + _FRAME) + 0.2) as figure:
        axes = panel_grid(figure, len(panels), _COLUMNS)
        for ax, ((task, measured), rows) in zip(axes, panels, strict=True):
            for row in rows.to_dict("records"):
                _draw(ax, names.index(row["variant"]), row)
            ax.axvline(0.0, color="0.7", linewidth=0.8, zorder=0)
            ax.set_ylim(len(names) - 0.5, -0.5)
            ax.set_yticks(range(len(names)), names, fontsize=6.5)
            ax.set_title(str(task), fontsize=8)
            ax.set_xlabel(f"{measured}, more by\n[{MEASURED[str(measured)]}]", fontsize=7)
            ax.tick_params(axis="x", labelsize=6.5)
        return figure


def _draw(ax: Axes, place: int, row: Mapping[Any, Any]) -> None:
    worse = row["worse"] == "yes"
    color = COLORS[1] if worse else "0.45"
    low, high = (row[end] if np.isfinite(row[end]) else row["difference"] for end in ("low", "high"))
    ax.plot([low, high], [place, place], color=color, linewidth=1.0)
    face = color if worse else "white"
    ax.plot([row["difference"]], [place], "o", color=color, markersize=3.5, markerfacecolor=face, markeredgewidth=0.8)
