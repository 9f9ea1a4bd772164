"""The picture of step responses: output and control over time."""

from collections.abc import Mapping

from matplotlib.figure import Figure

from fuzzy.figures.drawing import COLUMN, new_figure, style
from fuzzy.figures.palette import COLORS, ROLES
from fuzzy.plugins.loop.response import BAND, StepResponse

_DASHES = ("-", "-.", "--", ":")


def plot_step_response(responses: Mapping[str, StepResponse]) -> Figure:
    """Draw responses to one and the same loop over time: the output above, the control below.

    The reference is a line in a band of 2 %, a disturbance a dotted line.

    Args:
        responses: The responses by the names that the legend shows.
    """
    with style():
        figure = new_figure(COLUMN, 3.6)
        above, below = figure.subplots(2, 1, sharex=True, height_ratios=(3, 2))
        first = next(iter(responses.values()))
        reference = first.loop.reference
        reach = BAND * abs(reference - first.output[0])
        above.axhspan(reference - reach, reference + reach, color=COLORS[2], alpha=0.2, linewidth=0)
        above.axhline(reference, color=ROLES["quiet"].light, linewidth=0.7, linestyle="-")
        for k, (name, done) in enumerate(responses.items()):
            about = {"color": COLORS[k % len(COLORS)], "linestyle": _DASHES[k % len(_DASHES)]}
            above.plot(done.time, done.output, label=name, **about)
            below.step(done.time, done.control, where="post", **about)
        if first.loop.disturbed <= first.loop.steps:
            for ax in (above, below):
                ax.axvline(
                    first.loop.disturbed * first.loop.period, color=ROLES["quiet"].light, linestyle=":", linewidth=0.8
                )
        above.set_ylabel("output y")
        below.set(ylabel="control u", xlabel="time [s]")
        above.legend(loc="lower right")
    return figure
