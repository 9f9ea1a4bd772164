"""The command ``robotics run``: one scenario under one controller."""

from functools import partial
from pathlib import Path
from typing import Annotated, Any

from fuzzy.commands.shared import parsed, usage
from fuzzy.errors import InputError
from fuzzy.shell.options import Json, Quiet, option
from fuzzy.shell.progress import progress_bar
from robotics.commands.completion import robots
from robotics.commands.shared import (
    Files,
    Law,
    Metric,
    ScenarioName,
    chosen_controller,
    controller_option,
    print_forewarnings,
    print_run,
)


def _spread(text: str) -> tuple[float, float, float]:
    wanted = "--starts takes three numbers >= 0, in m, m and rad, such as 0.5,0.5,3.14"
    parts = [parsed(float, part, wanted) for part in text.split(",")]
    if len(parts) != 3:
        usage(f"{wanted}, got {text!r}")
    return parts[0], parts[1], parts[2]


def run_(
    *,
    scenario: ScenarioName,
    controller: Annotated[
        str | None, controller_option("Controller: name or name:gain=value,... Default: the scenario's own, or fuzzy.")
    ] = None,
    law: Law = None,
    robot: Annotated[
        str | None,
        option("Another robot than the scenario's, with its own sensors.", "NAME|FILE.toml", autocompletion=robots),
    ] = None,
    plant: Annotated[str, option("Other physics: mujoco, or mujoco:friction=0.3,...", "--plant", "NAME")] = "",
    film: Annotated[
        Path | None, option("A film of the first seed by MuJoCo's renderer: .mp4, .gif.", "--film", "FILE")
    ] = None,
    metric: Metric = None,
    starts: Annotated[
        str | None,
        option("Draw each seed's start within so much of it: m, m, rad.", "--starts", "DX,DY,DHEADING"),
    ] = None,
    seed: Annotated[int, option("The first seed.", min=0)] = 0,
    seeds: Annotated[int, option("Number of seeds, from --seed on.", min=1)] = 1,
    files: Files,
    json: Json = False,
    quiet: Quiet = False,
) -> None:
    """Simulate one scenario under one controller, print its metrics, and draw or save it if asked.

    \b
    Example:
      robotics run lyapunov-sine --controller lyapunov:ky=10,kpsi=5 --seed 3 --plot out.png
      robotics run lyapunov-sine --mcap run.mcap --layout panels.json
      robotics run lyapunov-sine --starts 0.5,0.5,3.14 --seeds 200
      robotics run fuzzy-off-path --robot pioneer-3dx
    """
    from robotics.laws.catalogue import make_controller
    from robotics.measures.registry import chosen_metrics, own_metrics, with_named
    from robotics.simulation.loop import simulate
    from robotics.simulation.physics import as_physics
    from robotics.simulation.scenario.conditions import noises
    from robotics.simulation.scenario.reading import load_scenario
    from robotics.simulation.scenario.robots import load_robot
    from robotics.studies.forewarnings import forewarnings

    if scenario in ("crossing", "obstacles"):
        raise InputError(f"{scenario} is no scenario but a stress test: `robotics repeat {scenario}` repeats one run")
    setting = load_scenario(scenario)
    if robot is not None:
        setting = setting.with_robot(load_robot(robot))
    if starts is not None:
        setting = setting.spread(_spread(starts))
    controller = chosen_controller(controller, law) or setting.controller or "fuzzy"
    driver, own = make_controller(controller), own_metrics(with_named([setting], metric or ()), setting.kind)
    physics: Any = plant
    if film is not None:
        other = as_physics(plant)
        if not hasattr(other, "filmed"):
            raise InputError("--film needs --plant mujoco; robotics animate draws any saved run from above")
        physics = other.filmed(plant, film)
    files.check_logs(range(seed, seed + seeds))
    ages = setting.kind == "team" and files.need_ages(seeds, len(setting.robots), setting.ticks)
    print_forewarnings(forewarnings(setting.setting, driver, controller))
    with progress_bar(quiet) as begin:
        advance = begin(f"{setting.name}: {controller}", setting.ticks + 1)
        kept: dict[str, Any] = {"message_ages": ages} | dict.fromkeys(("torques", "encoders", "messages"), files.logged)
        run = simulate(
            setting, driver, range(seed, seed + seeds), name=controller, **kept, progress=advance, plant=physics
        )
        page = files.write(run, begin)
        if film is not None:
            physics.write(run, partial(begin, f"drawing {film.name}"))
    print_run(run, page, json, metrics=own, first=chosen_metrics(setting.metrics, setting.kind), noise=noises(setting))
