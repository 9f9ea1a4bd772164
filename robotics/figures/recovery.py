"""Pictures of many team runs: recovery against the length of an outage, and how coordination scales."""

from collections.abc import Sequence

import numpy as np
from matplotlib.figure import Figure

from fuzzy.figures.drawing import COLORS, DOUBLE, LINES, new_figure, style
from robotics.experiments.recovery import Recovery
from robotics.experiments.scaling import Scaling
from robotics.laws.catalogue import law_title
from robotics.measures.evidence import rate_of

_MARKERS = "os^Dv"


def plot_recovery(recoveries: Sequence[Recovery]) -> Figure:
    """Draw the share of runs that recover, with Wilson's interval, and the largest distance from the path."""
    names = list(dict.fromkeys(r.controller for r in recoveries))
    with style():
        figure = new_figure(DOUBLE, 2.6)
        left, right = figure.subplots(1, 2)
        for i, name in enumerate(names):
            mine = [r for r in recoveries if r.controller == name]
            outages = [r.outage for r in mine]
            look = {"color": COLORS[i], "linestyle": LINES[i], "marker": _MARKERS[i], "markersize": 4}
            shares = [rate_of(r.recovered) for r in mine]
            ends = np.array([[s.value - s.low, s.high - s.value] for s in shares]).T
            left.errorbar(
                outages,
                [100 * s.value for s in shares],
                100 * ends,
                label=law_title(name),
                capsize=2,
                elinewidth=0.8,
                **look,
            )
            right.plot(outages, [float(r.deviation.mean()) for r in mine], **look)
        left.axvline(15.0, color="0.45", linewidth=0.8, linestyle=(0, (4, 2)))
        left.text(15.2, 3, "limit in the thesis", fontsize=7, color="0.3")
        left.set_ylim(-3, 103)
        left.set_ylabel("teams that recover [%]")
        right.set_ylim(bottom=0)
        right.set_ylabel("mean of the largest\ndistance from the path [m]")
        for ax in (left, right):
            ax.set_xlabel("length of failure and delay [s]")
        figure.legend(loc="outside upper center", ncol=3)
        return figure


def plot_scaling(scaling: Sequence[Scaling]) -> Figure:
    """Draw spread and delay of the arrivals over the number of robots, a line for each share of lost messages."""
    losses = sorted({s.loss for s in scaling})
    with style():
        figure = new_figure(DOUBLE, 2.6)
        left, right = figure.subplots(1, 2)
        for i, loss in enumerate(losses):
            mine = [s for s in scaling if s.loss == loss]
            sizes = [s.robots for s in mine]
            look = {"color": COLORS[i], "linestyle": LINES[i], "marker": _MARKERS[i], "markersize": 4}
            left.plot(sizes, [s.spread for s in mine], label=f"{100 * loss:g} % lost", **look)
            right.plot(sizes, [s.late for s in mine], **look)
        for ax in (left, right):
            ax.set_xscale("log")
            ax.set_xticks(sizes, [str(n) for n in sizes])
            ax.minorticks_off()
            ax.set_xlabel("robots")
        left.set_ylim(bottom=0)
        left.set_ylabel("spread of the arrivals [s]")
        right.set_ylabel("arrival of the last\nafter the reference's end [s]")
        figure.legend(loc="outside upper center", ncol=len(losses))
        return figure
