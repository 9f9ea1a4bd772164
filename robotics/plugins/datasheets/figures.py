"""The picture of a robot: to scale with its wheels and sensors, the response of its wheel loop, and its limits."""

from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.collections import LineCollection
from matplotlib.figure import Figure
from matplotlib.patches import Polygon, Rectangle, Wedge

from fuzzy.figures.drawing import COLORS, DOUBLE, number, styled_figure
from robotics.simulation.scenario.robots import RobotModel
from robotics.world.sensing.sonar import RangeSensor
from robotics.world.vehicle.robot import Robot
from robotics.world.vehicle.wheel_loop import MOTIONS, Motion, step_response

_BODY: dict[str, Any] = {"facecolor": "0.93", "edgecolor": "black", "linewidth": 1.0}
_SENSOR, _WHEEL, _FRONT = COLORS[0], "0.35", COLORS[1]
_NAMES: dict[Motion, str] = {"straight": "straight on", "spot": "on the spot"}
_SIGHT = 1.6  # as many lengths around the robot are shown


def plot_robot(model: RobotModel) -> Figure:
    """Draw a robot from above to scale, the step response of its wheel loop, and the velocities that it can drive."""
    with styled_figure(DOUBLE, 3.1) as figure:
        grid = figure.add_gridspec(2, 3, width_ratios=(1.25, 1.0, 1.0))
        _draw_above(figure.add_subplot(grid[:, 0]), model)
        speed = figure.add_subplot(grid[0, 1])
        _draw_steps(speed, figure.add_subplot(grid[1, 1], sharex=speed), model.robot)
        _draw_limits(figure.add_subplot(grid[:, 2]), model.robot)
        figure.suptitle(model.title or model.name, parse_math=False)
        return figure


def _draw_above(ax: Axes, model: RobotModel) -> None:
    """The outline, the wheels, the center of mass and what the sensors see, near the robot."""
    robot = model.robot
    reach = _SIGHT * max(robot.length, robot.width)
    _draw_sensors(ax, list(model.sensors.values()), reach)
    ax.add_patch(Rectangle((-robot.length / 2, -robot.width / 2), robot.length, robot.width, **_BODY, zorder=2))
    thick = min(0.4 * robot.wheel_radius, robot.width / 6)
    for side in (-1, 1):
        place = (-robot.wheel_radius, side * robot.half_axle - thick / 2)
        ax.add_patch(Rectangle(place, 2 * robot.wheel_radius, thick, color=_WHEEL, zorder=3))
    nose = np.array([[0.5, 0.0], [0.38, 0.12], [0.38, -0.12]]) * [robot.length, robot.width]
    ax.add_patch(Polygon(nose, color=_FRONT, zorder=3))
    ax.plot([0, 0], [-robot.half_axle, robot.half_axle], color=_WHEEL, linewidth=0.8, linestyle="-", zorder=3)
    ax.plot([robot.mass_offset], [0], "o", color="black", markersize=4, zorder=4, label="center of mass")
    for sensor in model.sensors.values():
        ax.plot([sensor.x], [sensor.y], "s", color=_SENSOR, markersize=2.5, zorder=4)
    ends = (-reach, reach)
    ax.set(aspect="equal", xlim=ends, ylim=ends, xlabel="x, ahead [m]", ylabel="y, to the left [m]")
    seen = sorted({sensor.range for sensor in model.sensors.values()})
    sight = f"; sensors reach {' and '.join(map(number, seen))} m" if seen else "; no range sensors"
    ax.set_title(f"● center of mass{sight}", fontsize=7)


def _draw_sensors(ax: Axes, sensors: list[RangeSensor], reach: float) -> None:
    """The cones of sonars and the beams of lidars, from where they are mounted to the edge of the picture."""
    beams = []
    for sensor in sensors:
        far = min(sensor.range, 4 * reach)
        if sensor.half_cone > 0:
            angles = np.degrees([sensor.axis - sensor.half_cone, sensor.axis + sensor.half_cone])
            ax.add_patch(Wedge((sensor.x, sensor.y), far, *angles, color=_SENSOR, alpha=0.13, linewidth=0, zorder=1))
        else:
            way = np.array([np.cos(sensor.axis), np.sin(sensor.axis)])
            start = np.array([sensor.x, sensor.y])
            beams.append([start + sensor.minimum * way, start + far * way])
    ax.add_collection(LineCollection(beams, colors=_SENSOR, alpha=0.35, linewidths=0.4, zorder=1))


def _draw_steps(speed: Axes, voltage: Axes, robot: Robot) -> None:
    for n, motion in enumerate(MOTIONS):
        step = step_response(robot, motion)
        look: dict[str, Any] = {"color": COLORS[n], "linestyle": ("-", "--")[n], "linewidth": 1.1}
        settled = f"{step.settling_time:.2f} s" if np.isfinite(step.settling_time) else "not yet"
        name = f"{_NAMES[motion]}: {100 * step.overshoot:.1f} %, {settled}"
        speed.plot(step.time, step.speed / step.command, **look, label=name)
        voltage.step(step.time, step.voltage, where="post", **look)
    for bound in (0.98, 1.02):
        speed.axhline(bound, color="0.6", linewidth=0.5, linestyle=":")
    voltage.axhline(robot.supply_voltage, color="0.2", linewidth=0.7, linestyle=(0, (1, 1.5)))
    legend = speed.legend(fontsize=6, loc="lower right", handlelength=1.6, title="overshoot, settled to 2 %")
    legend.get_title().set_fontsize(6)
    speed.set_title("Wheel loop: step to half of the top speed", fontsize=7)
    speed.set_ylabel("wheel speed / step")
    voltage.set(ylim=(0.0, 1.08 * robot.supply_voltage), ylabel="voltage [V]", xlabel="time [s]")
    speed.tick_params(labelbottom=False)
    speed.margins(x=0)


def _draw_limits(ax: Axes, robot: Robot) -> None:
    """What the wheels can turn, |v| + L |ω| <= r ω_wheel, and what of it may be commanded."""
    v, w = robot.wheel_speed_limit, robot.wheel_speed_limit / robot.half_axle
    ax.add_patch(Polygon([(v, 0), (0, w), (-v, 0), (0, -w)], facecolor="none", edgecolor="black", linewidth=1.0))
    ax.add_patch(Polygon(drivable(robot), facecolor=COLORS[0], alpha=0.25, edgecolor="none"))
    for side in (-1, 1):
        ax.axvline(side * robot.v_max, color=COLORS[1], linewidth=0.9, linestyle="--")
        ax.axhline(side * robot.w_max, color=COLORS[1], linewidth=0.9, linestyle="--")
    across, up = 1.15 * max(v, robot.v_max), 1.15 * max(w, robot.w_max)
    ax.set(xlim=(-across, across), ylim=(-up, up), xlabel="v [m/s]", ylabel="ω [rad/s]")
    ax.set_title("— wheels, - - v_max and w_max", fontsize=7)


def drivable(robot: Robot) -> np.ndarray:
    """The corners (n, 2) of the velocities v [m/s], ω [rad/s] within all limits, counter-clockwise."""
    limit, half = robot.wheel_speed_limit, robot.half_axle
    v, w = min(robot.v_max, limit), min(robot.w_max, limit / half)
    quarter = [(v, min(w, (limit - v) / half)), (min(v, limit - half * w), w)]
    corners = quarter + [(-x, y) for x, y in quarter[::-1]]
    return np.array([(v, -quarter[0][1]), *corners, *((-x, -y) for x, y in corners)][1:])
