"""Pictures of a system: membership functions, surfaces, the rule viewer and the structure.

Every function returns a matplotlib figure (``figure.savefig("a.pdf")``, :func:`save_figure`), in the project's style
and without touching pyplot's. MATLAB's names are aliases: plotmf, gensurf, ruleview, plotfis.
"""

from collections.abc import Mapping, Sequence
from typing import Any, Literal

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.patches import Patch

from fuzzy.figures.drawing import COLUMN, DOUBLE, figure_of, new_figure, number, quantity, style
from fuzzy.figures.drawing import save_figure as save_figure
from fuzzy.figures.memberships import plot_memberships as plot_memberships
from fuzzy.figures.palette import COLORS
from fuzzy.figures.ruleviewer import plot_rules as plot_rules
from fuzzy.figures.structure import plot_structure as plot_structure
from fuzzy.insight.surfacegrid import Surface as Surface
from fuzzy.insight.surfacegrid import surface as surface
from fuzzy.insight.surfacegrid import surface_axes
from fuzzy.insight.universe import place_of, point_of
from fuzzy.system import FuzzySystemError, Sugeno


def plot_surface(
    fis: Sugeno,
    inputs: Sequence[str | int] | str | int | None = None,
    output: str | int = 0,
    fixed: Mapping[Any, float] | None = None,
    points: int | Sequence[int] | None = None,
    kind: Literal["contour", "3d", "both"] = "contour",
    ax: Any = None,
) -> Figure:
    """Draw :func:`surface`: a contour picture, a 3-D surface or both; over a single input a curve.

    A hatched area is one where no rule fires (the 3-D surface leaves it out).

    Args:
        fis: The system.
        inputs: One or two inputs for the axes, by name or place; the first two by default.
        output: The output, by name or place.
        fixed: The values of the other inputs, by name or place; the middle of the universe where none is given.
        points: The number of points along each axis.
        kind: "contour", "3d" or "both".
        ax: The axes to draw on, 3-D axes for "3d"; "both" makes its own.

    Raises:
        FuzzySystemError: As :func:`surface` does.
    """
    if kind not in ("contour", "3d", "both"):
        raise FuzzySystemError(f"kind must be 'contour', '3d' or 'both', got {kind!r}")
    if kind == "both" and ax is not None:
        raise FuzzySystemError("kind 'both' draws two pictures and takes no axes")
    places = surface_axes(fis, inputs)
    data = surface(fis, places, output, fixed, points or (61 if len(places) == 2 else 401))
    j = place_of(output, fis.outputs, "output")
    held = _held(fis, places, fixed)
    with style():
        if data.y is None:
            if ax is None:
                ax = new_figure(COLUMN, 2.4).add_subplot()
            _curve(ax, fis, data, places[0], j)
            _title(ax, held)
            return figure_of(ax)
        if ax is not None:
            figure = figure_of(ax)
        else:
            figure = new_figure(DOUBLE if kind == "both" else COLUMN, 2.8)
        kinds = ("contour", "3d") if kind == "both" else (kind,)
        for place, each in enumerate(kinds, start=1):
            projection = "3d" if each == "3d" else None
            axes = ax if ax is not None else figure.add_subplot(1, len(kinds), place, projection=projection)
            draw = _solid if each == "3d" else _contour
            draw(axes, fis, data, places, j)
            if place == 1:
                _title(axes, held)
        return figure


def _held(fis: Sugeno, places: Sequence[int], fixed: Mapping[Any, float] | None) -> str:
    point = point_of(fis, fixed)
    return ", ".join(
        f"{v.name} = {quantity(value, v)}"
        for i, (v, value) in enumerate(zip(fis.inputs, point, strict=True))
        if i not in places
    )


def _title(ax: Any, held: str) -> None:
    if held:
        ax.set_title(f"at {held}", parse_math=False, wrap=True)


def _nothing_fires(fis: Sugeno, j: int) -> str:
    if fis.upper.no_rule_fires != "midrange":
        return "no rule fires"
    return f"no rule fires: {number(fis.outputs[j].midrange)} stands there"


def _curve(ax: Axes, fis: Sugeno, data: Surface, i: int, j: int) -> None:
    # Only where a rule fires is the line the rules' own.
    ax.plot(data.x, np.where(data.fired, data.z, np.nan), color=COLORS[0], linestyle="-")
    if not data.fired.all():
        ax.plot(data.x, np.where(data.fired, np.nan, data.z), color="0.5", linestyle=":")
        ax.fill_between(
            data.x,
            0,
            1,
            where=~data.fired,
            step="mid",
            transform=ax.get_xaxis_transform(),
            facecolor="none",
            edgecolor="0.6",
            hatch="////",
            linewidth=0,
            label=_nothing_fires(fis, j),
        )
        ax.legend(loc="upper center", bbox_to_anchor=(0.5, -0.22), borderaxespad=0)
    ax.margins(x=0)
    ax.set_xlabel(fis.inputs[i].label, parse_math=False)
    ax.set_ylabel(fis.outputs[j].label, parse_math=False)


def _levels(z: np.ndarray) -> np.ndarray:
    from matplotlib.ticker import MaxNLocator

    known = z[np.isfinite(z)]
    low, high = (known.min(), known.max()) if known.size else (0.0, 0.0)
    if high - low <= 1e-12 * max(abs(low), abs(high), 1e-300):
        # A flat surface still needs two levels round its one value.
        half = 0.05 * abs(low) or 1.0
        return np.array([low - half, low + half])
    return np.asarray(MaxNLocator(16).tick_values(low, high))


def _contour(ax: Axes, fis: Sugeno, data: Surface, places: Sequence[int], j: int) -> None:
    assert data.y is not None
    z = np.ma.masked_where(~data.fired | ~np.isfinite(data.z), data.z)
    levels = _levels(z.compressed())
    # A plateau's rounding errors must not draw contours of their own, nor fall out of the highest level.
    digits = 10 - int(np.floor(np.log10(levels[-1] - levels[0])))
    z = np.ma.clip(np.ma.round(z, digits), levels[0], levels[-1])
    filled = ax.contourf(data.x, data.y, z, levels=levels, cmap="viridis")
    filled.set_edgecolor("face")  # no white hairlines between the levels in a PDF
    ax.contour(data.x, data.y, z, levels=levels[1:-1], colors="white", linewidths=0.3, alpha=0.5, linestyles="-")
    figure = ax.figure
    bar = figure.colorbar(filled, ax=ax)
    bar.set_label(fis.outputs[j].label, parse_math=False)
    bar.outline.set_linewidth(0.4)
    if not data.fired.all():
        # A cell with a corner where no rule fires is masked above and hatched here, under the surface: no white gap.
        ax.contourf(
            data.x, data.y, _grown(~data.fired), levels=[0.5, 1.5], colors="none", hatches=["/////"], zorder=0.5
        )
        patch = Patch(facecolor="white", edgecolor="0.4", hatch="/////", label=_nothing_fires(fis, j))
        ax.legend(handles=[patch], loc="upper center", bbox_to_anchor=(0.5, -0.2), borderaxespad=0)
    ax.grid(False)
    ax.set_xlabel(fis.inputs[places[0]].label, parse_math=False)
    ax.set_ylabel(fis.inputs[places[1]].label, parse_math=False)


def _grown(mask: np.ndarray) -> np.ndarray:
    """The mask as numbers, with its neighbours, so that the contour at 0.5 meets the masked surface's rim."""
    padded = np.pad(mask, 1)
    rows, columns = mask.shape
    shifts = [padded[a : a + rows, b : b + columns] for a in range(3) for b in range(3)]
    return np.any(shifts, axis=0).astype(float)


def _solid(ax: Any, fis: Sugeno, data: Surface, places: Sequence[int], j: int) -> None:
    z = np.where(data.fired, data.z, np.nan)
    levels = _levels(z)
    ax.plot_surface(
        data.x,
        data.y,
        z,
        cmap="viridis",
        vmin=levels[0],
        vmax=levels[-1],
        rcount=61,
        ccount=61,
        edgecolor="0.2",
        linewidth=0.1,
        antialiased=True,
    )
    ax.set_zlim(levels[0], levels[-1])
    ax.view_init(elev=28, azim=-128)
    ax.set_xlabel(fis.inputs[places[0]].label, parse_math=False, labelpad=0)
    ax.set_ylabel(fis.inputs[places[1]].label, parse_math=False, labelpad=0)
    ax.zaxis.set_rotate_label(False)
    ax.set_zlabel(fis.outputs[j].label, parse_math=False, labelpad=0, rotation=90)
    ax.locator_params(nbins=5)
    ax.tick_params(pad=-1)
    # A tenth of the axes' room for the labels, which stand outside the cube.
    ax.set_box_aspect(None, zoom=0.85)
    if not data.fired.all():
        ax.text2D(
            0.5, 0.98, f"gap: {_nothing_fires(fis, j)}", transform=ax.transAxes, ha="center", va="top", fontsize=7
        )


plotmf, gensurf, ruleview, plotfis = plot_memberships, plot_surface, plot_rules, plot_structure
