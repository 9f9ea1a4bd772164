"""Faults in figures: their words and hatches."""

from collections.abc import Sequence
from typing import Any

from matplotlib import rc_context
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from fuzzy.figures.drawing import figure_of, text_width
from robotics.show.figures.drawing import on_white

FEW_ROBOTS = 8  # robots that are drawn boldly, with their numbers
WORDS = {"failure": "failure", "delay": "delay", "silence": "silent", "stall": "stalled"}
HATCHES = {"failure": "xxxx", "delay": "////", "silence": "----", "stall": "||||"}


def shade_faults(ax: Axes, faults: Any, start: float, end: float, named: bool = True) -> None:
    """Shade the time during which robots are at fault, hatched by kind.

    Args:
        ax: The axes, with time along x.
        faults: The spans of the faults, as :func:`robotics.simulation.spans.fault_spans` gives them.
        start: The time [s] at which the axis begins.
        end: The time [s] at which it ends.
        named: Whether the robots' numbers and faults are written in words.
    """
    taken: list[tuple[float, int]] = []
    shown = [f for f in faults if f.start < end and f.end > start]
    wide = float(figure_of(ax).get_figwidth() * ax.get_position().width)  # inches
    for f in sorted(shown, key=lambda f: f.start):
        a, b = max(f.start, start), min(f.end, end)
        with rc_context({"hatch.color": "0.75"}):
            ax.axvspan(a, b, facecolor=(0, 0, 0, 0.07), hatch=HATCHES[f.kind][:2], linewidth=0, zorder=0)
        if not named:
            continue
        text = f"{f.robot + 1}: {WORDS[f.kind]}"
        busy = {level for until, level in taken if until > a}
        level = next(n for n in range(len(shown)) if n not in busy)
        taken.append((a + (text_width(text, 6.5) + 0.08) / wide * (end - start), level))
        if level < 4:
            ax.text(a, 0.97 - 0.13 * level, text, transform=ax.get_xaxis_transform(), va="top", **on_white(0.6))


def shade_panels(
    figure: Figure, axes: Sequence[Axes], faults: Any, span: tuple[float, float], named: Axes | None
) -> None:
    """Shade faults in all panels of a page, in words only in the panel ``named``; then nothing is arranged any more.

    Args:
        figure: The page.
        axes: Its panels, with time along x.
        faults: The spans of the faults.
        span: The times [s] at which the axes begin and end.
        named: The panel in which faults are written in words, if there is one.
    """
    figure.draw_without_rendering()  # words need the widths of the panels
    figure.set_layout_engine("none")  # which then stay
    for ax in axes:
        shade_faults(ax, faults, *span, named=ax is named)
