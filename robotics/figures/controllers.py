"""Pictures of runs: paths, errors and speeds of several controllers on one scenario.

Every function returns a matplotlib figure in the project's style; a controller looks the same in all of them. One seed
of each run is drawn, by default the first. These are the thesis's Figs 2.6-2.14 and 2.25-2.32.
"""

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from fuzzy.figures.drawing import DOUBLE, new_figure, style
from robotics.figures.comparison import plot_comparison
from robotics.figures.drawing import (
    TARGET,
    Look,
    PlotError,
    draw_line,
    last_known,
    looks,
    looks_of,
    mark_contacts,
    mark_stop,
    only,
    strided,
)
from robotics.figures.faults import FEW
from robotics.figures.run import plot_run
from robotics.laws.catalogue import law_title
from robotics.measures.tracking import cross_track_error, tracking_error
from robotics.simulation.run import Run
from robotics.vehicle.robot import Robot

__all__ = ["looks", "plot_comparison", "plot_errors", "plot_paths", "plot_run", "plot_velocities"]


def plot_paths(runs: Run | Sequence[Run], seed: int | None = None, looks: Mapping[str, Look] | None = None) -> Figure:
    """Draw the reference and the driven paths from above, and magnified where they lie furthest apart.

    That place is searched for in the second half of the run, while the reference moves: it shows how accurately the
    controllers track once they have reached the path.

    Args:
        runs: A run, or those of several controllers on one scenario.
        seed: The seed that is drawn, by default the first.
        looks: How each controller is drawn, by its specification.

    Raises PlotError for no run, runs of several scenarios, or a seed or robot that was not run.
    """
    runs = _some(runs)
    chosen, drawn = looks_of((run.controller for run in runs), looks), [only(run, seed) for run in runs]
    with style():
        everything = np.concatenate([_points(run) for run in drawn])
        low, high = np.nanmin(everything, axis=0), np.nanmax(everything, axis=0)
        width, height = np.maximum(high - low, 0.05 * float(np.max(high - low)) + 1e-6)
        figure = new_figure(DOUBLE, float(np.clip(4.2 * height / width, 1.9, 3.4)) + 0.85)
        overview, detail = figure.subplots(1, 2, width_ratios=(2.2, 1))
        overview.set_aspect("equal", adjustable="datalim")
        for run in drawn:
            _draw_paths(overview, run, chosen[run.controller], 1.0)
        _draw_references(overview, drawn[0], 1.0)
        _mark_starts(overview, drawn[0])
        overview.set_xlabel("x [m]")
        overview.set_ylabel("y [m]")
        place = _furthest(drawn)
        if place is None:
            detail.remove()
        else:
            _draw_detail(overview, detail, drawn, chosen, *place)
        handles, names = overview.get_legend_handles_labels()
        unique = dict(zip(names, handles, strict=True))
        figure.legend(unique.values(), unique.keys(), loc="outside upper center", ncol=4, handlelength=2.8)
        return figure


def _some(runs: Run | Sequence[Run], robot: int = 0) -> Sequence[Run]:
    runs = [runs] if isinstance(runs, Run) else runs
    if not runs:
        raise PlotError("a figure of runs needs at least one run")
    if len({run.scenario for run in runs}) > 1:
        raise PlotError("the runs of one figure must be those of one scenario")
    if not 0 <= robot < len(runs[0].paths):
        last = len(runs[0].paths)
        raise PlotError(f"{runs[0].scenario} has the robots 1 to {last}, there is no robot {robot + 1}")
    return runs


def _named(run: Run, robot: int) -> str:
    """The law, and which of several robots it drives."""
    return law_title(run.controller) + (f", robot {robot + 1}" if len(run.paths) > 1 else "")


def _points(run: Run) -> np.ndarray:
    """Driven and reference positions (points, 2) [m]."""
    driven = np.stack([run["x"].ravel(), run["y"].ravel()], axis=1)
    return np.concatenate([driven, np.stack([run.target("x").ravel(), run.target("y").ravel()], axis=1)])


def _draw_paths(ax: Axes, run: Run, look: Look, scale: float, center: tuple[float, float] = (0.0, 0.0)) -> None:
    for i in range(len(run.paths)):
        x, y = (scale * (run[axis][0, i] - c) for axis, c in zip("xy", center, strict=True))
        ax.plot(*strided(x, y), color=look.color, linestyle=look.line, label=law_title(run.controller))
        if run.diverged[0, i] and (k := last_known(x)) >= 0:
            mark_stop(ax, x[k], y[k], look.color)
    mark_contacts(ax, run, 0, scale=scale, center=center)


def _draw_references(ax: Axes, run: Run, scale: float, center: tuple[float, float] = (0.0, 0.0)) -> None:
    for nodes in run.paths:
        x, y = (scale * (row - c) for row, c in zip(nodes, center, strict=True))
        ax.plot(*strided(x, y), **TARGET, label="reference", zorder=2.1)  # type: ignore[arg-type]


def _mark_starts(ax: Axes, run: Run) -> None:
    """A ring where each robot starts, with a stroke along its heading."""
    robots = len(run.paths)
    for i in range(len(run.paths)):
        x, y, heading = (float(run[channel][0, i, 0]) for channel in ("x", "y", "heading"))
        ax.plot([x], [y], marker="o", markerfacecolor="white", color="black", linestyle="none", label="start", zorder=5)
        ax.annotate(
            f"robot {i + 1}" if 1 < robots <= FEW else str(i + 1) if robots > FEW else "",
            (x, y),
            xytext=(-6, 4),
            textcoords="offset points",
            ha="right",
            fontsize=7,
        )
        tip = (14 * np.cos(heading), 14 * np.sin(heading))
        arrow = {"arrowstyle": "<-", "lw": 0.8}
        ax.annotate("", (x, y), xytext=tip, textcoords="offset points", arrowprops=arrow, zorder=6)


def _furthest(runs: Sequence[Run]) -> tuple[float, float, float, float] | None:
    """The place where paths lie furthest from their reference in the second half: x, y, distance [m], time [s]."""
    best: tuple[float, float, float, float] | None = None
    for run in runs:
        moving = run.target("v") > 1e-6
        moving[:, : len(run.time) // 2] = False
        distance = np.where(moving, np.abs(cross_track_error(run)[0]), np.nan)
        if not np.isfinite(distance).any():
            continue
        i, k = np.unravel_index(np.nanargmax(distance), distance.shape)
        if best is None or distance[i, k] > best[2]:
            x, y = (float(run.target(axis)[i, k]) for axis in "xy")
            best = (x, y, float(distance[i, k]), float(run.time[k]))
    return best


def _draw_detail(
    overview: Axes,
    ax: Axes,
    runs: Sequence[Run],
    chosen: Mapping[str, Look],
    x: float,
    y: float,
    distance: float,
    time: float,
) -> None:
    half = max(1.4 * distance, 1e-6)
    scale, unit = (1000.0, "mm") if half < 0.1 else (1.0, "m")
    for run in runs:
        _draw_paths(ax, run, chosen[run.controller], scale, (x, y))
    _draw_references(ax, runs[0], scale, (x, y))
    ax.set_aspect("equal")
    ax.set_xlim(-scale * half, scale * half)
    ax.set_ylim(-scale * half, scale * half)
    ax.locator_params(nbins=5)
    ax.set_xlabel(f"Δx [{unit}]")
    ax.set_ylabel(f"Δy [{unit}]")
    where = f"□ magnified: round ({x:.2f}, {y:.2f}) m,\nwhere the reference is at {time:.1f} s"
    ax.set_title(where.replace("-", "−"), fontsize=7)
    overview.plot([x], [y], marker="s", markersize=8, markerfacecolor="none", color="black", markeredgewidth=0.8)


def plot_errors(
    runs: Run | Sequence[Run], seed: int | None = None, robot: int = 0, looks: Mapping[str, Look] | None = None
) -> Figure:
    """Draw the errors of (5.9) in x, y and heading over time, those of the true posture.

    Where the first half of the run dwarfs the second, the second is drawn once more beside it, magnified.

    Args:
        runs: A run, or those of several controllers on one scenario.
        seed: The seed that is drawn, by default the first.
        robot: The robot that is drawn, from 0.
        looks: How each controller is drawn, by its specification.

    Raises PlotError for no run, runs of several scenarios, or a seed or robot that was not run.
    """
    runs = _some(runs, robot)
    chosen, drawn = looks_of((run.controller for run in runs), looks), [only(run, seed) for run in runs]
    time = drawn[0].time
    errors = np.array([[field[0, robot] for field in tracking_error(run)] for run in drawn])  # (runs, 3, samples)
    late = time >= time[-1] / 2
    peaks = [max((float(np.max(part, initial=0.0))) for part in _finite(np.abs(errors[..., s]))) for s in (~late, late)]
    magnify = peaks[0] > 4 * peaks[1] > 0
    with style():
        figure = new_figure(DOUBLE, 4.6)
        grid = figure.subplots(3, 2 if magnify else 1, sharex="col", squeeze=False)
        for row, (name, unit) in enumerate((("x error", "m"), ("y error", "m"), ("heading error", "rad"))):
            for column, ax in enumerate(grid[row]):
                shown = late if column else np.full(len(time), True)
                scale, prefix = _milli(errors[:, row][:, shown])
                # The line that moves most is drawn under the others.
                depths = np.argsort(np.argsort(-np.nansum(np.abs(np.diff(errors[:, row])), axis=-1)))
                for run, error, depth in zip(drawn, errors[:, row], depths, strict=True):
                    look = chosen[run.controller]
                    draw_line(
                        ax,
                        time[shown],
                        scale * error[shown],
                        color=look.color,
                        linestyle=look.line,
                        linewidth=1.0,
                        zorder=2 + 0.01 * depth,
                        label=_named(run, robot),
                    )
                    k = last_known(error)
                    if run.diverged[0, robot] and k >= 0 and shown[k]:
                        mark_stop(ax, time[k], scale * error[k], look.color)
                ax.axhline(0.0, **TARGET)
                ax.set_ylabel(f"{name} [{prefix}{unit}]")
                ax.margins(x=0)
        for column, ax in enumerate(grid[2]):
            ax.set_xlabel("time [s]")
            if magnify:
                grid[0, column].set_title("second half, magnified" if column else "whole run")
        handles, names = grid[0, 0].get_legend_handles_labels()
        figure.legend(handles, names, loc="outside upper center", ncol=3, handlelength=2.8)
        return figure


def _finite(values: np.ndarray) -> list[np.ndarray]:
    """Each row's finite values."""
    return [row[np.isfinite(row)] for row in values.reshape(-1, values.shape[-1])]


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
) -> Figure:
    """Draw the linear and the angular speed over time, one row for each controller.

    Args:
        runs: A run, or those of several controllers on one scenario.
        seed: The seed that is drawn, by default the first.
        robot: The robot that is drawn, from 0.
        machine: A robot whose limits are drawn where a speed comes within a fifth of them.
        looks: How each controller is drawn, by its specification.

    Raises PlotError for no run, runs of several scenarios, or a seed or robot that was not run.
    """
    runs = _some(runs, robot)
    chosen, drawn = looks_of((run.controller for run in runs), looks), [only(run, seed) for run in runs]
    v_limit, w_limit = _limits(machine)
    with style():
        figure = new_figure(DOUBLE, 0.62 + max(0.78 * len(drawn), 1.7), constrained=False)  # the labels are that long
        grid = figure.subplots(len(drawn), 2, sharex=True, sharey="col", squeeze=False)
        for axes, run in zip(grid, drawn, strict=True):
            for ax, channel, limit in zip(axes, "vw", (v_limit, w_limit), strict=True):
                _draw_speed(ax, run, robot, channel, chosen[run.controller])
                speeds = np.concatenate([r[channel][0, robot] for r in drawn])
                for side in (-1, 1):
                    if limit is not None and np.nanmax(side * speeds) > 0.8 * limit:
                        ax.axhline(side * limit, color="0.2", linewidth=0.7, linestyle=(0, (1, 1.5)), label="limit")
            axes[0].set_title(_named(run, robot), loc="left", pad=2.0, parse_math=False)
        for ax in grid[-1]:
            ax.set_xlabel("time [s]")
        _place_rows(figure, len(drawn))
        for ax, name in zip(grid[0], ("linear speed v [m/s]", "angular speed ω [rad/s]"), strict=True):
            box, top = ax.get_position(), grid[-1, 0].get_position()
            place = (box.x0 - 0.41 / DOUBLE, (box.y1 + top.y0) / 2)
            figure.text(*place, name, rotation=90, ha="right", va="center")
        pairs: dict[str, Any] = {}
        for ax in grid[0]:
            handles, names = ax.get_legend_handles_labels()
            pairs |= dict(zip(names, handles, strict=True))
        figure.legend(pairs.values(), pairs.keys(), loc="upper right", ncol=2, handlelength=2.8, borderaxespad=0.2)
        return figure


def _limits(machine: Robot | None) -> tuple[float | None, float | None]:
    """The highest |v| [m/s] at ω = 0 and |ω| [rad/s] at v = 0 that both the command and the wheels allow."""
    if machine is None:
        return None, None
    wheels = machine.wheel_speed_limit
    return min(machine.v_max, wheels), min(machine.w_max, wheels / machine.half_axle)


def _draw_speed(ax: Axes, run: Run, robot: int, channel: str, look: Look) -> None:
    speed = run[channel][0, robot]
    draw_line(ax, run.time, speed, color=look.color, linestyle="-", linewidth=0.8)
    draw_line(ax, run.time, run.target(channel)[robot], **TARGET, label="reference")
    if run.diverged[0, robot] and (k := last_known(speed)) >= 0:
        mark_stop(ax, run.time[k], speed[k], look.color)
    ax.margins(x=0)


def _place_rows(figure: Figure, rows: int) -> None:
    """Set fixed margins: the layout engine would take long over that many panels, which all look alike."""
    width, height = figure.get_size_inches()
    panel = (height - 0.62) / rows
    figure.subplots_adjust(
        left=0.58 / width,
        right=1 - 0.08 / width,
        bottom=0.4 / height,
        top=1 - 0.22 / height - 0.08 / height,
        wspace=0.25,
        hspace=0.36 * 0.78 / max(panel - 0.2, 0.1) * 0.8,
    )
