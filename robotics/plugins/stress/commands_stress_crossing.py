"""The command ``robotics stress crossing``: thousands of random crossings, and what went wrong in which."""

from functools import partial
from typing import Annotated, Literal

from fuzzy.shell.options import Json, Quiet, option, renamed_options
from robotics.commands.shared import Law, chosen_controller, controller_option, print_forewarnings
from robotics.plugins.stress.printing import Driven, Runners, Wrong, run_stress

Ends = Literal["A", "B"]  # the class of a crossing: where its paths may end


@renamed_options(jobs="--workers")
def crossing(
    *,
    runs: Annotated[int, option("Number of random crossings.", min=1, max=1_000_000)] = 1000,
    robots: Annotated[int, option("Number of robots in each.", min=2, max=200)] = 3,
    ends: Annotated[
        Ends, option("A: ends clear of the other paths; B: ends only apart from each other.", "--class")
    ] = "A",
    controller: Annotated[
        str | None,
        controller_option(
            "Controller: right-of-way (default), literal, lag-clock, yielding, none, or one of `robotics list`."
        ),
    ] = None,
    law: Law = None,
    robot: Driven = None,
    disturbance: Wrong,
    seed: Annotated[int, option("The first crossing's seed.", min=0)] = 0,
    crew: Runners,
    json: Json = False,
    quiet: Quiet = False,
) -> None:
    """Simulate random crossings of paths, and count who arrives, who never does, and who touches.

    The plant is the full one and postures are noisy. A crossing depends on its seed alone, so that `robotics repeat
    crossing --seed N` with the same options repeats, draws and saves one that failed. The number of workers changes no
    number. With --out the same command goes on after a stop.

    \b
    Example:
      robotics stress crossing --robots 3 --runs 20 --json
    """
    from robotics.laws.catalogue import make_controller
    from robotics.plugins.stress.crossings import crossing_forewarnings, stress_crossing
    from robotics.plugins.stress.outcome import StressOutcome
    from robotics.plugins.stress.single import ALIASES
    from robotics.simulation.opening import has_equation
    from robotics.simulation.scenario.robots import STANDARD

    controller = chosen_controller(controller, law) or "right-of-way"
    name = ALIASES["crossing"].get(controller, controller)
    driver = make_controller(name)
    print_forewarnings(crossing_forewarnings(driver, controller, ends))
    stress = partial(stress_crossing, name, robots, kind=ends, disturbance=disturbance, robot=robot)
    run_stress(
        {"controller": controller, "class": ends, "robots": robots, "robot": robot or STANDARD, "first_seed": seed},
        stress,
        StressOutcome,
        robots,
        range(seed, seed + runs),
        crew,
        json=json,
        quiet=quiet,
        threads=has_equation(driver),
    )
