"""The command ``robotics robot``: what a robot is, drawn and in numbers, and gains tuned for its wheel loop."""

import textwrap
from dataclasses import fields, replace
from math import isfinite
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

from fuzzy.commands.shared import check_plot
from fuzzy.files.atomic import check_target
from fuzzy.shell.options import Json, argument, option
from fuzzy.shell.terminal import print_json
from fuzzy.shown import shown
from robotics.commands.completion import robots
from robotics.commands.shared import number_cell

if TYPE_CHECKING:
    from robotics.simulation.scenario.robots import RobotModel
    from robotics.world.vehicle.robot import Robot
    from robotics.world.vehicle.wheel_loop import Gains


def robot(
    name: Annotated[str, argument("A robot's name, or its file.", "NAME|FILE.toml", autocompletion=robots)],
    out: Annotated[Path | None, option("Draw it: .png, .pdf, .svg.", "--out", "-o", "PICTURE")] = None,
    tune: Annotated[bool, option("Find gains of the wheel loop: shortest settling, overshoot up to 5 %.")] = False,
    write: Annotated[Path | None, option("With --tune: write the robot's file with these gains.", "FILE.toml")] = None,
    force: Annotated[bool, option("With --write: overwrite a file that is there already.")] = False,
    json: Json = False,
) -> None:
    """Show a robot: size, mass, limits, every number (with its rule if it is derived), and its wheel loop.

    \b
    Example:
      robotics new robot -o mine.toml
      robotics robot mine.toml --tune -o mine.png
    """
    from robotics.simulation.scenario.robots import load_robot, write_tuned
    from robotics.world.vehicle.robot import RobotError
    from robotics.world.vehicle.wheel_loop import tuned

    check_plot(out)
    if write is not None and not tune:
        raise RobotError("--write writes what --tune finds: give both")
    check_target(write, ".toml")
    model = load_robot(name)
    gains = tuned(model.robot) if tune else None
    if write is not None and gains is not None:
        write_tuned(name, gains, write, force)
    if out is not None:
        from fuzzy.figures.drawing import save_figure
        from robotics.plugins.datasheets.figures import plot_robot

        save_figure(plot_robot(model), out)
    if json:
        print_json(_report(model, gains))
        return
    _print(model)
    if gains is not None:
        _print_tuned(model.robot, gains)


def _report(model: "RobotModel", gains: "Gains | None") -> dict[str, Any]:
    found = {
        "name": model.name,
        "title": model.title,
        "source": model.source,
        "numbers": _numbers(model.robot),
        "sensors": list(model.sensors),
        "mass_kg": model.robot.mass,
        "limits": _limits(model.robot),
        "wheel_loop": _loop(model.robot),
    }
    if gains is not None:
        found["tuned"] = {**gains._asdict(), "wheel_loop": _loop(replace(model.robot, **gains._asdict()))}
    return found


def _numbers(robot: "Robot") -> list[dict[str, Any]]:
    """Every number with its unit and what it is; its rule where it was derived, otherwise None."""
    return [
        {
            "name": f.name,
            "value": getattr(robot, f.name),
            "unit": f.metadata["unit"],
            "doc": f.metadata["doc"],
            "rule": robot.derived.get(f.name),
        }
        for f in fields(robot)
        if getattr(robot, f.name) is not None
    ]


def _limits(robot: "Robot") -> dict[str, float | None]:
    from robotics.world.vehicle.wheel_loop import top_speed

    return {
        "v_mps": robot.wheel_radius * top_speed(robot, "straight"),
        "w_radps": robot.wheel_radius * top_speed(robot, "spot") / robot.half_axle,
        "wheel_mps": robot.wheel_speed_limit,
        "v_rate_mps2": robot.v_rate_max,
        "w_rate_radps2": robot.w_rate_max,
    }


def _loop(robot: "Robot") -> dict[str, dict[str, float | None]]:
    """Overshoot and settling time of a step to half of the top speed; None: it does not settle."""
    from robotics.world.vehicle.wheel_loop import MOTIONS, step_response

    steps = {motion: step_response(robot, motion) for motion in MOTIONS}
    return {
        motion: {
            "overshoot": step.overshoot,
            "settling_time_s": step.settling_time if isfinite(step.settling_time) else None,
        }
        for motion, step in steps.items()
    }


def _print(model: "RobotModel") -> None:
    machine, limits = model.robot, _limits(model.robot)
    print(f"{model.name}: {model.title}" if model.title else model.name)
    if model.source:
        print(f"source: {model.source}")
    print(f"\nsize      {machine.length:g} x {machine.width:g} m, wheels of {machine.wheel_radius:g} m radius")
    print(
        f"mass      {shown(machine.mass)} kg; its wheels and rotors make it "
        f"{shown(machine.effective_mass)} kg to accelerate"
    )
    print(
        f"limits    v {number_cell(limits['v_mps'])} m/s, ω {number_cell(limits['w_radps'])} rad/s; "
        f"|v| + {machine.half_axle:g} m |ω| <= {number_cell(limits['wheel_mps'])} m/s"
    )
    units = {"v_rate_mps2": "m/s²", "w_rate_radps2": "rad/s²"}
    rates = [f"{number_cell(limits[key])} {unit}" for key, unit in units.items() if limits[key] is not None]
    print(f"          commands change by up to {', '.join(rates) if rates else 'any rate'}")
    print(f"sensors   {_listed(list(model.sensors))}")
    print(f"loop      {_said(_loop(machine))}")
    given = [row for row in _numbers(machine) if row["rule"] is None]
    derived = [row for row in _numbers(machine) if row["rule"] is not None]
    print("\nGiven")
    for row in given:
        print(f"  {row['name']:<19} {shown(row['value'], 0, 5):>10} {row['unit']}")
    if derived:
        print("\nDerived")
    for row in derived:
        start = f"  {row['name']:<19} {shown(row['value'], 0, 5):>10} {row['unit']:<8} = "
        print(textwrap.fill(row["rule"], 118, initial_indent=start, subsequent_indent=" " * len(start)))


def _listed(names: list[str]) -> str:
    if not names:
        return "none"
    few = names if len(names) <= 8 else [*names[:2], "...", names[-1]]
    return f"{len(names)}: {', '.join(few)}"


def _said(loop: dict[str, dict[str, float | None]]) -> str:
    said = []
    for motion, name in (("straight", "straight on"), ("spot", "on the spot")):
        overshoot, settling = loop[motion]["overshoot"], loop[motion]["settling_time_s"]
        settled = "does not settle" if settling is None else f"settles to 2 % in {settling:.2f} s"
        said.append(f"{name} it {settled}, overshoot {100 * (overshoot or 0.0):.1f} %")
    return "; ".join(said)


def _print_tuned(machine: "Robot", gains: "Gains") -> None:
    print("\nTuned: the shortest settling time of steps to 20-80 % of the top speed, overshoot up to 5 %")
    print(f"  before  {_said(_loop(machine))}")
    print(f"  after   {_said(_loop(replace(machine, **gains._asdict())))}")
    for name, value in gains._asdict().items():
        if value or getattr(machine, name):
            print(f"{name} = {value!r}")
