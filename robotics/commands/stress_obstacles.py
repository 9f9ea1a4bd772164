"""The command ``robotics stress obstacles``: thousands of random courses among unknown obstacles."""

from enum import StrEnum
from functools import partial
from typing import Annotated, Any

import typer

from fuzzy.shell.progress import progress_bar
from robotics.commands.completion import controllers
from robotics.commands.shared import Jobs, Json, Law, Quiet, chosen_controller, print_forewarnings, print_outcome


class Field(StrEnum):
    """The class of a course: what stands on it."""

    A = "A"
    B = "B"
    U = "U"


class Team(StrEnum):
    """The number of robots on a course."""

    one = "1"
    three = "3"


class Side(StrEnum):
    """How the lanes of several robots lie to each other."""

    beside = "beside"
    crossing = "crossing"


def obstacles(
    runs: Annotated[int, typer.Option(min=1, max=1_000_000, help="Number of random courses.")] = 1000,
    field: Annotated[
        Field, typer.Option("--class", help="A: gaps of 0.7 m; B: obstacles may overlap; U: a trap.")
    ] = Field.A,
    robots: Annotated[Team, typer.Option(help="Number of robots, each on a lane.")] = Team.one,
    lanes: Annotated[
        Side, typer.Option(help="beside: lanes side by side; crossing: robots on time would meet, for 3 robots.")
    ] = Side.beside,
    controller: Annotated[
        str | None,
        typer.Option(
            help="Controller: committed (default), literal, or one that `robotics list` names.",
            autocompletion=controllers,
        ),
    ] = None,
    law: Law = None,
    seed: Annotated[int, typer.Option(min=0, help="The first course's seed.")] = 0,
    loss: Annotated[float, typer.Option(min=0, max=0.95, help="Share of the messages that are lost.")] = 0.0,
    latency: Annotated[float, typer.Option(min=0, max=10, help="Latency of the messages, s.")] = 0.0,
    freeze: Annotated[float, typer.Option(min=0.0, max=600.0, help="Seconds for which one robot is held up.")] = 0.0,
    moving: Annotated[
        int, typer.Option(min=0, max=10, help="Number of discs that cross the lanes, at 0.2 m/s at most.")
    ] = 0,
    jobs: Jobs = None,
    json: Json = False,
    quiet: Quiet = False,
) -> None:
    """Simulate random courses among obstacles that the robots only sense: who arrives, and who touches what.

    The plant is the full one, sonars and postures are noisy. A course depends on its seed alone, so that `robotics
    repeat obstacles --seed N` with the same options repeats one. The number of processes changes no number.

    \b
    Example:
      robotics stress obstacles --runs 20 --class U --json
    """
    from robotics.experiments.forewarnings import blind
    from robotics.experiments.stress.crew import in_chunks
    from robotics.experiments.stress.disturbance import Disturbance
    from robotics.experiments.stress.obstaclecourse import obstacle_ensemble, stress_obstacles
    from robotics.experiments.stress.single import ALIASES
    from robotics.laws.catalogue import make_controller

    controller = chosen_controller(controller, law) or "committed"
    name = ALIASES["obstacles"].get(controller, controller)
    driver = make_controller(name)
    count = int(robots.value)
    print_forewarnings(blind(obstacle_ensemble([seed], field.value, count, lanes=lanes.value), driver, controller))
    wrong = Disturbance(loss=loss, latency=latency, freeze=freeze)
    with progress_bar(quiet) as begin:
        stress = partial(
            stress_obstacles, name, kind=field.value, robots=count, disturbance=wrong, moving=moving, lanes=lanes.value
        )
        outcome = in_chunks(stress, count, range(seed, seed + runs), jobs=jobs, begin=begin)
    about: dict[str, Any] = {"controller": controller, "class": field.value, "robots": count, "lanes": lanes.value}
    about |= {"first_seed": seed, "loss": loss, "latency_s": latency, "freeze_s": freeze, "moving": moving}
    print_outcome(about | outcome.summary(), json)
