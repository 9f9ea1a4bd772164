"""The command ``robotics stress crossing``: thousands of random crossings, and what went wrong in which."""

from enum import StrEnum
from functools import partial
from typing import Annotated

import typer

from fuzzy.shell.progress import progress_bar
from robotics.commands.completion import controllers
from robotics.commands.shared import Jobs, Json, Law, Quiet, chosen_controller, print_forewarnings, print_stressed


class Ends(StrEnum):
    """The class of a crossing: where its paths may end."""

    A = "A"
    B = "B"


def crossing(
    runs: Annotated[int, typer.Option(min=1, max=1_000_000, help="Number of random crossings.")] = 1000,
    robots: Annotated[int, typer.Option(min=2, max=200, help="Number of robots in each.")] = 3,
    ends: Annotated[
        Ends, typer.Option("--class", help="A: ends clear of the other paths; B: ends only apart from each other.")
    ] = Ends.A,
    controller: Annotated[
        str | None,
        typer.Option(
            help="Controller: right-of-way (default), literal, lag-clock, yielding, none, or one of `robotics list`.",
            autocompletion=controllers,
        ),
    ] = None,
    law: Law = None,
    loss: Annotated[float, typer.Option(min=0.0, max=1.0, help="Share of the messages that are lost.")] = 0.0,
    latency: Annotated[float, typer.Option(min=0.0, max=10.0, help="Latency of the messages, s.")] = 0.0,
    freeze: Annotated[float, typer.Option(min=0.0, max=600.0, help="Seconds for which one robot is held up.")] = 0.0,
    seed: Annotated[int, typer.Option(min=0, help="The first crossing's seed.")] = 0,
    jobs: Jobs = None,
    json: Json = False,
    quiet: Quiet = False,
) -> None:
    """Simulate random crossings of paths, and count who arrives, who never does, and who touches.

    The plant is the full one and postures are noisy. A crossing depends on its seed alone, so that `robotics repeat
    crossing --seed N` with the same options repeats, draws and saves one that failed. The number of jobs changes no
    number.

    \b
    Example:
      robotics stress crossing --robots 3 --runs 20 --json
    """
    from robotics.experiments.forewarnings import crossing_forewarnings
    from robotics.experiments.stress.crew import in_chunks
    from robotics.experiments.stress.crossing_runs import stress_crossing
    from robotics.experiments.stress.disturbance import Disturbance
    from robotics.experiments.stress.single import ALIASES
    from robotics.laws.catalogue import make_controller
    from robotics.simulation.opening import has_equation

    controller = chosen_controller(controller, law) or "right-of-way"
    name = ALIASES["crossing"].get(controller, controller)
    driver = make_controller(name)
    print_forewarnings(crossing_forewarnings(driver, controller, ends.value))
    wrong = Disturbance(loss=loss, latency=latency, freeze=freeze)
    with progress_bar(quiet) as begin:
        stress = partial(stress_crossing, name, robots, kind=ends.value, disturbance=wrong)
        seeds, threads = range(seed, seed + runs), has_equation(driver)
        stressed = in_chunks(stress, robots, seeds, jobs=jobs, begin=begin, threads=threads)
    about = {"controller": controller, "class": ends.value, "robots": robots, "first_seed": seed}
    print_stressed(about, stressed, json)
