"""The command ``robotics repeat``: one run of a stress test, made again."""

from enum import StrEnum
from typing import Annotated

from fuzzy.shell.options import Json, Quiet, argument, option
from fuzzy.shell.progress import progress_bar
from robotics.commands.shared import Files, Law, Metric, chosen_controller, controller_option, print_run
from robotics.plugins.stress.commands_stress_obstacles import Side
from robotics.plugins.stress.printing import Driven, Wrong


class Stress(StrEnum):
    """The stress tests."""

    crossing = "crossing"
    obstacles = "obstacles"


def repeat(
    *,
    stress: Annotated[Stress, argument("The stress test of which a run is repeated.")],
    seed: Annotated[int, option("The run's seed.", min=0)] = 0,
    robots: Annotated[
        int | None, option("Number of robots. Default: crossing: 3, obstacles: 1.", min=1, max=200)
    ] = None,
    kind: Annotated[
        str | None, option("Class of the run. crossing: A or B, obstacles: A, B or U. Default: A", "--class")
    ] = None,
    controller: Annotated[
        str | None, controller_option("Controller, as for the stress test. Default: right-of-way, or obstacles.")
    ] = None,
    law: Law = None,
    robot: Driven = None,
    metric: Metric = None,
    disturbance: Wrong,
    moving: Annotated[int, option("Number of discs that cross the lanes (obstacles only).", min=0, max=10)] = 0,
    lanes: Annotated[
        Side, option("Lanes side by side, or crossing each other (obstacles with 3 robots only).")
    ] = "beside",
    files: Files,
    json: Json = False,
    quiet: Quiet = False,
) -> None:
    """Repeat one run of a stress test by its seed, to look at it: the same to the last bit, with the same options.

    \b
    Example:
      robotics repeat crossing --seed 4 --animate
    """
    from robotics.laws.catalogue import make_controller
    from robotics.measures.registry import own_metrics
    from robotics.plugins.stress.single import ALIASES, STRESSES, single_run

    name = chosen_controller(controller, law) or STRESSES[stress]
    driver, own = make_controller(ALIASES[stress].get(name, name)), own_metrics(metric or (), "team")
    files.check_logs([seed])
    ages = files.save is not None or files.player or files.logged
    with progress_bar(quiet) as begin:
        run, outcome = single_run(
            stress.value,
            driver,
            seed,
            robots,
            kind,
            disturbance,
            name,
            ages,
            begin,
            moving=moving,
            lanes=lanes,
            robot=robot,
            logged=files.logged,
        )
        page = files.write(run, begin)
    print_run(run, page, json, outcome.summary(), own)
