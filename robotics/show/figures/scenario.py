"""A scenario drawn to scale before it runs: paths, robots in true size, sensors, obstacles, and what was found."""

from collections.abc import Sequence
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.collections import PolyCollection
from matplotlib.figure import Figure
from matplotlib.patches import Wedge

from fuzzy.figures.drawing import COLORS, DOUBLE, LINES, styled_figure
from robotics.show.figures.drawing import draw_obstacles, draw_patches, rectangles, strided
from robotics.simulation.scenario.description import Scenario
from robotics.studies.inspection import ScenarioFinding
from robotics.world.environment.world import outlines

MARKS = 5  # times that are written along a path
_FEW = 8  # robots whose sensors and times are drawn
_BEAMS = 12  # sensors of a robot that are drawn each by itself; of more only the outermost reach
_SIGNS = {"error": ("X", "black"), "warning": ("^", "black"), "note": ("d", "0.35")}
_CENTERED: dict[str, Any] = {"textcoords": "offset points", "ha": "center", "va": "center"}
_TIME: dict[str, Any] = _CENTERED | {"fontsize": 6, "color": "0.25", "zorder": 4}  # along a path


def plot_scenario(scenario: Scenario, findings: Sequence[ScenarioFinding] = ()) -> Figure:
    """Draw a scenario in a top view, to scale.

    A robot is solid where it starts and an outline at its goal; the cones of its range sensors are faint. Arrows on a
    path say which way it is driven, numbers at what time [s]. Findings that have a place are numbered there in the
    order in which they are given, by a cross (error), a triangle (warning) or a diamond (note).

    Args:
        scenario: The scenario.
        findings: What ``robotics check`` finds in it.
    """
    low, high = _extent(scenario)
    width, height = high - low
    with styled_figure(DOUBLE, float(np.clip(6.6 * height / max(width, 1e-9), 2.2, 7.0)) + 0.6) as figure:
        ax = figure.add_subplot()
        _draw_obstacles(ax, scenario)
        times = np.linspace(0.0, min(scenario.duration, float(scenario.trajectory.ends.max())), 1201)
        on = scenario.trajectory.sampled(times)
        few, written = len(scenario.robots) <= _FEW, list[tuple[float, float]]()
        for i, path in enumerate(scenario.trajectory.paths):
            color = COLORS[i % len(COLORS)]
            look = {"color": color, "linestyle": LINES[i % 7] if few else "-", "linewidth": 1.1 if few else 0.6}
            ax.plot(*strided(path.table[0], path.table[1]), **look, label=f"robot {i + 1}" if few else None)  # type: ignore[arg-type]
            if few:
                way, end = (times, on.x[:, i], on.y[:, i]), float(scenario.trajectory.ends[i])
                _draw_times(ax, way, end, color, written, 0.03 * float(max(high - low)))
        _draw_robots(ax, scenario, sensors=few)
        _draw_findings(ax, findings)
        ax.set(xlim=(low[0], high[0]), ylim=(low[1], high[1]))
        ax.set_aspect("equal", adjustable="box")
        ax.set(xlabel="x [m]", ylabel="y [m]")
        if ax.get_legend_handles_labels()[0]:
            ax.legend(loc="lower center", bbox_to_anchor=(0.5, 1.0), ncol=6)
        figure.suptitle(f"{scenario.name}: solid at the start, outline at the goal", parse_math=False, fontsize=9)
        return figure


def _extent(scenario: Scenario) -> tuple[np.ndarray, np.ndarray]:
    """The lower left and the upper right corner (2,) [m] of all that is drawn, with a margin."""
    parts = [path.table[:2].T for path in scenario.trajectory.paths] + [scenario.starts[:, :2]]
    if scenario.setting.world is not None:
        parts += outlines(scenario.setting.world.at(0.0))
    parts += [patch.outline() for patch in scenario.patches]
    points = np.concatenate(parts)
    low, high = points.min(axis=0), points.max(axis=0)
    margin = max(float((high - low).max()) * 0.04, 0.4)
    return low - margin, high + margin


def _draw_obstacles(ax: Axes, scenario: Scenario) -> None:
    """Draw patches and obstacles; one that moves is faint at the end of the run, and its way dotted."""
    draw_patches(ax, scenario.patches)
    world = scenario.setting.world
    if world is None:
        return
    draw_obstacles(ax, outlines(world.at(0.0)))
    if world.motion is not None:
        draw_obstacles(ax, outlines(world.at(scenario.duration)), alpha=0.4)
        for path in world.motion.paths:
            ax.plot(path.table[0], path.table[1], color="0.3", linestyle=":", linewidth=0.8)


def _draw_times(
    ax: Axes, way: Sequence[np.ndarray], end: float, color: str, written: list[tuple[float, float]], apart: float
) -> None:
    """Draw arrows along the ``way`` of a reference, times, x and y, and to the left of it the times.

    Where a time is ``written`` already within ``apart`` [m], as where robots meet, there is no second one.
    """
    times, x, y = way
    last = min(float(times[-1]), end)
    for share in np.arange(1, MARKS + 1) / (MARKS + 1):
        k = int(np.searchsorted(times, share * last))
        j = max(k - max(len(times) // 200, 1), 0)
        if np.hypot(x[k] - x[j], y[k] - y[j]) > 0:
            arrow = {"arrowstyle": "-|>", "color": color, "lw": 0.0, "mutation_scale": 9}
            ax.annotate("", (x[k], y[k]), (x[j], y[j]), arrowprops=arrow, zorder=4)
            if all(np.hypot(x[k] - a, y[k] - b) > apart for a, b in written):
                written.append((float(x[k]), float(y[k])))
                left = np.array([y[j] - y[k], x[k] - x[j]]) / np.hypot(x[k] - x[j], y[k] - y[j])
                ax.annotate(f"{times[k]:.0f} s", (x[k], y[k]), (7 + 4 * abs(left[0])) * left, **_TIME)


def _draw_robots(ax: Axes, scenario: Scenario, sensors: bool) -> None:
    """Draw every robot in true size where it starts and where its reference ends, with its sensors."""
    goal = scenario.trajectory.at(float(scenario.trajectory.ends.max()))
    for i, member in enumerate(scenario.robots):
        robot, color = member.robot, COLORS[i % len(COLORS)]
        x, y, heading = (scenario.starts[i : i + 1, k] for k in range(3))
        body = rectangles(x, y, heading, robot.length, robot.width)
        ax.add_collection(PolyCollection(list(body), facecolors=color, edgecolors="black", linewidths=0.6, zorder=3))
        nose = (np.cos(heading[0]), np.sin(heading[0]))
        tip = (x[0] + nose[0] * robot.length / 2, y[0] + nose[1] * robot.length / 2)
        ax.plot([x[0], tip[0]], [y[0], tip[1]], color="white", linewidth=1.0, zorder=3.5)
        at = (goal.x[i : i + 1], goal.y[i : i + 1], goal.heading[i : i + 1])
        outline = rectangles(*at, robot.length, robot.width)
        ax.add_collection(PolyCollection(list(outline), facecolors="none", edgecolors=color, linewidths=1.0, zorder=3))
        carried = scenario.setting.sensors[i]
        if sensors and len(carried) <= _BEAMS:
            for sensor in carried.values():
                px = x[0] + nose[0] * sensor.x - nose[1] * sensor.y
                py = y[0] + nose[1] * sensor.x + nose[0] * sensor.y
                axis, half = np.degrees(heading[0] + sensor.axis), max(np.degrees(sensor.half_cone), 0.5)
                sides = (axis - half, axis + half)
                ax.add_patch(Wedge((px, py), sensor.range, *sides, color=color, alpha=0.07, lw=0, zorder=0.5))


def _draw_findings(ax: Axes, findings: Sequence[ScenarioFinding]) -> None:
    """Mark what was found, each with its number; at one place the gravest sign stands for all."""
    places: dict[tuple[float, float], list[int]] = {}
    for number, finding in enumerate(findings, start=1):
        if finding.x is not None and finding.y is not None:
            places.setdefault((round(finding.x, 2), round(finding.y, 2)), []).append(number)
    seen: set[str] = set()
    for at, numbers in places.items():
        severity = findings[numbers[0] - 1].severity
        marker, color = _SIGNS[severity]
        sign: dict[str, Any] = {"marker": marker, "color": color, "markersize": 6, "markeredgecolor": "white"}
        sign |= {"markeredgewidth": 0.6, "linestyle": "none", "zorder": 6}
        ax.plot(*([v] for v in at), **sign, label=None if severity in seen else severity)
        seen.add(severity)
        text = ", ".join(map(str, numbers))
        ax.annotate(text, at, (4, -8), textcoords="offset points", fontsize=7, weight="bold", zorder=6)
