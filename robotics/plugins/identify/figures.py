"""The pictures of an identified robot: what it was told, what it did, what the model does, and how sure that is."""

import io
from pathlib import Path

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from fuzzy.figures.drawing import COLORS, DOUBLE, style, styled_figure
from fuzzy.figures.palette import stylesheet
from fuzzy.files.atomic import write_whole
from fuzzy.shown import shown, typeset
from robotics.plugins.identify.identified import Identified
from robotics.plugins.identify.model import COORDINATE_NAMES

_SHOWN = 15.0  # s: the stretch in which commands change most
_LAGS = 30
_TEMPLATE = Path(__file__).with_name("identify.html.j2")


def plot_identified(found: Identified) -> Figure:
    """Draw commands, measured and modelled velocities, the correlation of residuals, and the intervals."""
    with styled_figure(DOUBLE, 5.2) as figure:
        grid = figure.add_gridspec(3, 2, width_ratios=(1.6, 1.0))
        speed = figure.add_subplot(grid[0, 0])
        turn = figure.add_subplot(grid[1, 0], sharex=speed)
        _draw_fit(speed, found, 0, "v [m/s]")
        _draw_fit(turn, found, 1, "ω [rad/s]")
        speed.tick_params(labelbottom=False)
        speed.legend(fontsize=6, loc="upper right", ncols=3)
        _draw_left(figure.add_subplot(grid[2, 0], sharex=speed), found)
        _draw_correlations(figure.add_subplot(grid[2, 1]), found)
        _draw_intervals(figure.add_subplot(grid[:2, 1]), found)
        figure.suptitle(f"{found.signals.log}: measured and modelled", parse_math=False)
        return figure


def _stretch(found: Identified) -> tuple[float, float]:
    """The times between which commands change most."""
    given, time = found.signals.commands, found.motion.time
    change = np.abs(np.diff(given.v)) / max(np.ptp(given.v), 1e-9) + np.abs(np.diff(given.w)) / max(
        np.ptp(given.w), 1e-9
    )
    begins = np.arange(time[0], max(time[-1] - _SHOWN, time[0]) + 1.0, 1.0)
    sums = [change[(given.time[1:] >= t) & (given.time[1:] < t + _SHOWN)].sum() for t in begins]
    begin = float(begins[int(np.argmax(sums))])
    return begin, begin + _SHOWN


def _draw_fit(ax: Axes, found: Identified, k: int, label: str) -> None:
    given, motion = found.signals.commands, found.motion
    ax.step(given.time, given[1 + k], where="post", color="0.6", linestyle="-", linewidth=0.8, label="commanded")
    ax.plot(motion.time, motion.measured[k], ".", color=COLORS[0], markersize=2.5, linestyle="none", label="measured")
    ax.plot(motion.time, motion.modelled[k], color=COLORS[1], linestyle="-", linewidth=1.0, label="model")
    ax.set(ylabel=label, xlim=_stretch(found))


def _draw_left(ax: Axes, found: Identified) -> None:
    for k, name in enumerate(("v", "ω")):
        left = found.motion.residuals[k]
        ax.plot(
            found.motion.time,
            left / max(left.std(), 1e-12),
            color=COLORS[k],
            linestyle=("-", "--")[k],
            linewidth=0.6,
            label=name,
        )
    ax.set(ylabel="residual / deviation", xlabel="time [s]", ylim=(-6, 6))
    ax.legend(fontsize=6, loc="upper right", ncols=2)


def _draw_correlations(ax: Axes, found: Identified) -> None:
    n = found.motion.residuals.shape[1]
    for k, name in enumerate(("v", "ω")):
        left = found.motion.residuals[k] - found.motion.residuals[k].mean()
        power = max(float(left @ left), 1e-300)
        rows = [float(left[lag:] @ left[: n - lag]) / power for lag in range(1, _LAGS + 1)]
        ax.plot(
            range(1, _LAGS + 1),
            rows,
            "o-" if k == 0 else "s--",
            color=COLORS[k],
            markersize=2.5,
            linewidth=0.6,
            label=name,
        )
    for side in (-1.96, 1.96):
        ax.axhline(side / np.sqrt(n), color="0.4", linewidth=0.7, linestyle=":")
    ax.set(xlabel="samples apart", ylabel="correlation of residuals", ylim=(-1, 1))


def _draw_intervals(ax: Axes, found: Identified) -> None:
    """Half the width of each interval of the motion in percent of its value; a side that is open reaches the edge."""
    rows = [each for each in found.numbers if each.name in COORDINATE_NAMES and each.value > 0]
    for place, each in enumerate(rows):
        width = 50 * (each.ends.high - each.ends.low) / each.value
        sure = each.known == "yes"
        shown_width = float(np.clip(width if np.isfinite(width) else 1e9, 1.2e-2, 200.0))
        ax.barh(-place, shown_width, height=0.6, left=1e-2, color=COLORS[0] if sure else "0.75")
    ax.set_xscale("log")
    ax.set(xlim=(1e-2, 200.0), yticks=-np.arange(len(rows)), xlabel="half of the 95 % interval [%]; grey: not known")
    ax.set_xticks([0.01, 0.1, 1, 10, 100], ["0.01", "0.1", "1", "10", "100"])
    ax.minorticks_off()
    ax.set_yticklabels(
        [f"{each.name} {typeset(shown(each.value, digits=3))} {each.unit}" for each in rows], fontsize=5.5
    )


def write_page(found: Identified, target: Path) -> None:
    """Write a page of the fits, all numbers, what the log cannot tell, and what to drive next. Raises OSError."""
    from jinja2 import Environment, StrictUndefined

    picture = io.StringIO()
    with style():
        plot_identified(found).savefig(picture, format="svg", metadata={"Date": None})
    svg = picture.getvalue()
    text = Environment(undefined=StrictUndefined, autoescape=True).from_string(_TEMPLATE.read_text(encoding="utf-8"))
    page = text.render(
        found=found,
        looks=stylesheet(),
        picture=svg[svg.index("<svg") :],
        rows=[
            (each.name, each.title, typeset(shown(each.value)), typeset(each.interval), each.unit, each.field)
            for each in found.numbers
        ],
        prediction={name: shown(value, digits=3) for name, value in found.prediction.items()},
    )
    write_whole(target, page)
