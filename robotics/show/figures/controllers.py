"""Pictures of runs: paths, errors and speeds of several controllers on one scenario.

Every function returns a matplotlib figure in the project's style; a controller looks the same in all of them. One seed
of each run is drawn, by default the first. These are the thesis's Figs 2.6-2.14 and 2.25-2.32.
"""

from collections.abc import Mapping, Sequence

import numpy as np
from matplotlib.artist import setp
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.patches import Patch

from fuzzy.figures.drawing import DOUBLE, PAGE_WIDTH, figure_of, styled_figure
from robotics.laws.catalogue import law_title
from robotics.measures.tracking import cross_track_error, tracking_error, under_way
from robotics.show.figures.drawing import (
    TARGET,
    Look,
    PlotError,
    cut_axis,
    draw_band,
    draw_common_legend,
    draw_line,
    looks_of,
    mark_contacts,
    only,
    room_for,
    unjumped,
)
from robotics.show.figures.faults import FEW_ROBOTS
from robotics.show.figures.robots import START, draw_path, draw_way, mark_stop
from robotics.simulation.run import Run
from robotics.world.vehicle.robot import Robot


def plot_paths(
    runs: Run | Sequence[Run],
    seed: int | None = None,
    looks: Mapping[str, Look] | None = None,
    width: float = DOUBLE,
) -> Figure:
    """Draw the reference and the driven paths from above, below them each controller's cross-track error over time.

    From above one seed is drawn. The errors are those of all seeds and robots: their median, and the band from the 5th
    to the 95th percentile, while the reference moves. All have one axis, set by the errors under way, as
    :func:`robotics.measures.tracking.under_way` says; where a start lies beyond it, a mark says how far.

    Args:
        runs: A run, or those of several controllers on one scenario.
        seed: The seed that is drawn from above, by default the first.
        looks: How each controller is drawn, by its specification.
        width: The width of the figure in inches.

    Raises:
        PlotError: No run, runs of several scenarios, or a seed or robot that was not run.
    """
    runs, drawn, chosen = _chosen(runs, seed, looks)
    top = _overview_height(drawn, width)
    columns = min(len(runs), 2 if width <= PAGE_WIDTH else 3)
    rows = -(-len(runs) // columns)
    legend = -(-(len(runs) + 3) // (2 if width <= PAGE_WIDTH else 4)) * 0.15
    with styled_figure(width, top + 0.5 + legend + rows * 0.95 + 0.3) as figure:
        grid = figure.add_gridspec(rows + 1, columns, height_ratios=[top + 0.3, *[0.95] * rows])
        overview = figure.add_subplot(grid[0, :])
        overview.set_aspect("equal", adjustable="datalim")
        for depth, run in enumerate(drawn):
            _draw_paths(overview, run, chosen[run.controller], len(drawn) - depth)
        for i in range(len(drawn[0].paths)):
            draw_path(overview, drawn[0], i, name="reference", zorder=2.1)
            _mark_start(overview, drawn[0], i)
        overview.set(xlabel="x [m]", ylabel="y [m]")
        _draw_cross_tracks([figure.add_subplot(grid[1 + k // columns, k % columns]) for k in range(len(runs))],
                           runs, chosen, columns)  # fmt: skip
        draw_common_legend(
            figure, [overview], loc="outside upper center", ncol=2 if width <= PAGE_WIDTH else 4, handlelength=2.8
        )
        return figure


def _overview_height(runs: Sequence[Run], width: float) -> float:
    """The height of the top view [in]: the paths' own proportions, within what a page has."""
    driven = [np.stack([run[axis].ravel() for axis in "xy"]) for run in runs]
    references = [np.stack([run.target(axis).ravel() for axis in "xy"]) for run in runs]
    everything = np.concatenate([*driven, *references], axis=1)
    across, up = np.maximum(np.nanmax(everything, axis=1) - np.nanmin(everything, axis=1), 1e-6)
    return float(np.clip(width * 0.85 * (up + 0.1 * across) / across, 0.25 * width, 0.6 * width))


def _draw_cross_tracks(axes: Sequence[Axes], runs: Sequence[Run], chosen: Mapping[str, Look], columns: int) -> None:
    """A panel for each controller: the cross-track errors of its seeds and robots as median and band."""
    time = runs[0].time
    errors = [cross_track_error(run).reshape(-1, len(time)) for run in runs]
    way = under_way(runs[0])
    seeds = max(len(run.seeds) for run in runs)
    end = int(np.flatnonzero(way.any(axis=0)).max(initial=1)) + 1  # beyond a path's end there is no cross-track error
    low, high = room_for(np.concatenate([np.where(way, cross_track_error(run), np.nan).ravel() for run in runs]))
    scale, prefix = _milli(np.array([low, high]))
    several = len(runs[0].paths) > 1
    for k, (ax, run, rows) in enumerate(zip(axes, runs, errors, strict=True)):
        ax.axhline(0.0, **TARGET)
        draw_band(ax, time[:end], scale * rows[:, :end], chosen[run.controller])
        cut_axis(ax, time[:end], scale * rows[:, :end], scale * low, scale * high)
        ax.margins(x=0)
        ax.set_title(law_title(run.controller), loc="left", pad=2.0, fontsize=7.5, parse_math=False)
        ax.tick_params(labelbottom=k >= len(runs) - columns, labelleft=k % columns == 0)
        if k >= len(runs) - columns:
            ax.set_xlabel("time [s]")
        if k % columns == 0:
            ax.set_ylabel(f"off path [{prefix}m]")
    if any(ax.collections for ax in axes):
        of = f"{seeds} seeds" + (f" and {len(runs[0].paths)} robots" if several else "")
        handles = [Line2D([], [], color="0.3", linestyle="-"), Patch(facecolor="0.3", alpha=0.3)]
        figure_of(axes[0]).legend(handles, ["median", f"5–95 % of {of}"], loc="outside lower right", ncol=2)


def _chosen(
    runs: Run | Sequence[Run], seed: int | None, looks: Mapping[str, Look] | None, robot: int = 0
) -> tuple[Sequence[Run], list[Run], Mapping[str, Look]]:
    """The runs of a figure, of each the one seed that is drawn, and how each is drawn, by its controller."""
    runs = [runs] if isinstance(runs, Run) else runs
    if not runs:
        raise PlotError("a figure of runs needs at least one run")
    if len({run.scenario for run in runs}) > 1:
        raise PlotError("the runs of one figure must be those of one scenario")
    if not 0 <= robot < len(runs[0].paths):
        last = len(runs[0].paths)
        raise PlotError(f"{runs[0].scenario} has the robots 1 to {last}, there is no robot {robot + 1}")
    return runs, [only(run, seed) for run in runs], looks_of((run.controller for run in runs), looks)


def _named(run: Run, robot: int) -> str:
    """The law, and which of several robots it drives."""
    return law_title(run.controller) + (f", robot {robot + 1}" if len(run.paths) > 1 else "")


def _draw_paths(ax: Axes, run: Run, look: Look, above: int) -> None:
    """The paths of one controller; those with more ``above`` them are wider, and are seen beside what covers them."""
    for i in range(len(run.paths)):
        wide = 0.9 + 0.35 * (above - 1)
        draw_way(ax, run, 0, i, **look.of_line, linewidth=wide, label=law_title(run.controller))
    mark_contacts(ax, run, 0)


def _mark_start(ax: Axes, run: Run, robot: int) -> None:
    """A ring where a robot starts, with a stroke along its heading."""
    robots = len(run.paths)
    x, y, heading = (float(run[channel][0, robot, 0]) for channel in ("x", "y", "heading"))
    ax.plot([x], [y], **START, label="start", zorder=5)
    number = f"robot {robot + 1}" if 1 < robots <= FEW_ROBOTS else str(robot + 1) if robots > FEW_ROBOTS else ""
    ax.annotate(number, (x, y), (-6, 4), textcoords="offset points", ha="right", fontsize=7)
    tip = (14 * np.cos(heading), 14 * np.sin(heading))
    arrow = {"arrowstyle": "<-", "lw": 0.8}
    ax.annotate("", (x, y), xytext=tip, textcoords="offset points", arrowprops=arrow, zorder=6)


def plot_errors(
    runs: Run | Sequence[Run],
    seed: int | None = None,
    robot: int = 0,
    looks: Mapping[str, Look] | None = None,
    width: float = DOUBLE,
) -> Figure:
    """Draw the errors of (5.9) in x, y and heading over time, those of the true posture.

    Where the first half of the run dwarfs the second, the second is drawn once more beside it, magnified.

    Args:
        runs: A run, or those of several controllers on one scenario.
        seed: The seed that is drawn, by default the first.
        robot: The robot that is drawn, from 0.
        looks: How each controller is drawn, by its specification.
        width: The width of the figure in inches.

    Raises:
        PlotError: No run, runs of several scenarios, or a seed or robot that was not run.
    """
    _, drawn, chosen = _chosen(runs, seed, looks, robot)
    time = drawn[0].time
    found = [tracking_error(run) for run in drawn]
    errors = np.array([[e.x[0, robot], e.y[0, robot], unjumped(e.heading[0, robot])] for e in found])  # by run
    late, size = time >= time[-1] / 2, np.where(np.isfinite(errors), np.abs(errors), 0.0)
    peaks = [float(size[..., part].max(initial=0.0)) for part in (~late, late)]
    magnify = peaks[0] > 4 * peaks[1] > 0
    with styled_figure(width, 4.6) as figure:
        grid = figure.subplots(3, 2 if magnify else 1, sharex="col", squeeze=False)
        for row, (name, unit) in enumerate((("x error", "m"), ("y error", "m"), ("heading error", "rad"))):
            for column, ax in enumerate(grid[row]):
                shown = late if column else np.full(len(time), True)
                scale, prefix = _milli(errors[:, row][:, shown])
                # The line that moves most is drawn under the others.
                depths = np.argsort(np.argsort(-np.nansum(np.abs(np.diff(errors[:, row])), axis=-1)))
                for run, error, depth in zip(drawn, errors[:, row], depths, strict=True):
                    look, line = chosen[run.controller], scale * error[shown]
                    above = {"zorder": 2 + 0.01 * depth, "label": _named(run, robot)}
                    draw_line(ax, time[shown], line, **look.of_line, linewidth=1.0, **above)
                    mark_stop(ax, run, 0, robot, time[shown], line, look.color)
                ax.axhline(0.0, **TARGET)
                ax.set_ylabel(f"{name} [{prefix}{unit}]")
                ax.margins(x=0)
        setp(grid[-1], xlabel="time [s]")
        if magnify:
            grid[0, 0].set_title("whole run")
            grid[0, 1].set_title("second half, magnified")
        beside = 3 if width > PAGE_WIDTH else 2
        draw_common_legend(figure, grid[0, :1], loc="outside upper center", ncol=beside, handlelength=2.8)
        return figure


def _milli(values: np.ndarray) -> tuple[float, str]:
    """The factor and the SI prefix with which the values are easiest to read."""
    known = np.abs(values[np.isfinite(values)])
    return (1000.0, "m") if known.size and known.max() < 0.1 else (1.0, "")


def plot_velocities(
    runs: Run | Sequence[Run],
    seed: int | None = None,
    robot: int = 0,
    machine: Robot | None = None,
    looks: Mapping[str, Look] | None = None,
    width: float = DOUBLE,
) -> Figure:
    """Draw linear speed, turn rate and demanded turn rate over time, one row for each controller.

    The axes of turn rates are set by those under way, as :func:`robotics.measures.tracking.under_way` says; where a
    start lies beyond, a mark says how far. Over a demanded turn rate stands its total variation a second under way.

    Args:
        runs: A run, or those of several controllers on one scenario.
        seed: The seed that is drawn, by default the first.
        robot: The robot that is drawn, from 0.
        machine: A robot whose limits are drawn where a speed comes within a fifth of them.
        looks: How each controller is drawn, by its specification.
        width: The width of the figure in inches.

    Raises:
        PlotError: No run, runs of several scenarios, or a seed or robot that was not run.
    """
    _, drawn, chosen = _chosen(runs, seed, looks, robot)
    v_limit, w_limit = _limits(machine)
    with styled_figure(width, 0.84 + 0.78 * len(drawn), constrained=False) as figure:
        limits = {"v": v_limit, "w": w_limit, "w_demand": w_limit}
        spans = {channel: _span(drawn, channel, robot, limit) for channel, limit in limits.items()}
        grid = figure.subplots(len(drawn), len(limits), sharex=True, squeeze=False)
        for axes, run in zip(grid, drawn, strict=True):
            for ax, channel in zip(axes, limits, strict=True):
                _draw_speed(ax, run, robot, channel, chosen[run.controller])
                low, high, near = spans[channel]
                for at in near:
                    ax.axhline(at, color="0.2", linewidth=0.7, linestyle=(0, (1, 1.5)), label="limit")
                cut_axis(ax, run.time, run[channel][0, robot][None], low, high)
            axes[0].set_title(_named(run, robot), loc="left", pad=2.0, parse_math=False)
            axes[2].set_title(f"changes {_change(run, robot):.2g} rad/s²", loc="right", pad=2.0, fontsize=7)
        setp(grid[-1], xlabel="time [s]")
        _place_rows(figure, len(drawn))
        for ax, name in zip(grid[0], ("speed v [m/s]", "turn rate ω [rad/s]", "demanded ω [rad/s]"), strict=True):
            box = ax.get_position()
            figure.text((box.x0 + box.x1) / 2, box.y1 + 0.2 / figure.get_figheight(), name, ha="center", va="bottom")
        draw_common_legend(figure, grid[0], loc="upper right", ncol=2, handlelength=2.8, borderaxespad=0.2)
        return figure


def _limits(machine: Robot | None) -> tuple[float | None, float | None]:
    """The highest |v| [m/s] at ω = 0 and |ω| [rad/s] at v = 0 that both the command and the wheels allow."""
    if machine is None:
        return None, None
    wheels = machine.wheel_speed_limit
    return min(machine.v_max, wheels), min(machine.w_max, wheels / machine.half_axle)


def _span(runs: Sequence[Run], channel: str, robot: int, limit: float | None) -> tuple[float, float, list[float]]:
    """The least and greatest speed that are shown, and where the limit is drawn, on one side, both or none."""
    shown = under_way(runs[0])[robot] | (channel == "v")
    speeds = np.stack([run[channel][0, robot][shown] for run in runs])
    reach = limit if limit is not None else np.inf
    near = [side * reach for side in (-1.0, 1.0) if np.nanmax(side * speeds, initial=0.0) > 0.8 * reach]
    known = [speeds.ravel(), runs[0].target(channel.removesuffix("_demand"))[robot], np.array(near)]
    return (*room_for(np.concatenate(known)), near)


def _change(run: Run, robot: int) -> float:
    """The total variation a second [rad/s²] of the demanded turn rate, without the start."""
    demanded = run["w_demand"][0, robot][under_way(run)[robot]]
    known = demanded[np.isfinite(demanded)]
    return float(np.abs(np.diff(known)).sum() / (max(len(known) - 1, 1) * (run.time[1] - run.time[0])))


def _draw_speed(ax: Axes, run: Run, robot: int, channel: str, look: Look) -> None:
    speed = run[channel][0, robot]
    draw_line(ax, run.time, speed, color=look.color, linestyle="-", linewidth=0.8)
    draw_line(ax, run.time, run.target(channel.removesuffix("_demand"))[robot], **TARGET, label="reference")
    mark_stop(ax, run, 0, robot, run.time, speed, look.color)
    ax.margins(x=0)


def _place_rows(figure: Figure, rows: int) -> None:
    """Set fixed margins: the layout engine would take long over that many panels, which all look alike."""
    width, height = figure.get_size_inches()
    panel = (height - 0.84) / rows
    figure.subplots_adjust(
        left=0.5 / width,
        right=1 - 0.08 / width,
        bottom=0.4 / height,
        top=1 - 0.52 / height,
        wspace=0.42 * 3 / (width - 0.58 - 2 * 0.42),
        hspace=0.36 * 0.78 / max(panel - 0.2, 0.1) * 0.8,
    )
