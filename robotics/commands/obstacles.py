"""``robotics stress obstacles``: thousands of random courses among unknown obstacles."""

from enum import StrEnum
from typing import Annotated, Any

import typer

from fuzzy.shell.progress import progress_bar
from fuzzy.shell.terminal import print_json


class Field(StrEnum):
    """What stands on the course."""

    A = "A"
    B = "B"
    U = "U"


class Team(StrEnum):
    """How many robots are on it."""

    one = "1"
    three = "3"


def obstacles(
    runs: Annotated[int, typer.Option(min=1, max=1_000_000, help="How many random courses.")] = 1000,
    field: Annotated[
        Field, typer.Option("--class", help="A: gaps of 0.7 m; B: obstacles may overlap; U: a trap.")
    ] = Field.A,
    robots: Annotated[Team, typer.Option(help="Robots on lanes side by side.")] = Team.one,
    controller: Annotated[
        str, typer.Option(help="committed, literal, or a controller that `robotics list` names.")
    ] = "committed",
    seed: Annotated[int, typer.Option(min=0, help="The first course's seed.")] = 0,
    loss: Annotated[float, typer.Option(min=0, max=0.95, help="Share of messages lost.")] = 0.0,
    latency: Annotated[float, typer.Option(min=0, max=10, help="Of messages, s.")] = 0.0,
    moving: Annotated[int, typer.Option(min=0, max=10, help="Discs that cross the lanes, 0.2 m/s at most.")] = 0,
    json: Annotated[bool, typer.Option("--json", help="Print one JSON object instead of text.")] = False,
    quiet: Annotated[bool, typer.Option("--quiet", "-q", help="No progress bar.")] = False,
) -> None:
    """Random courses among obstacles that the robots only sense: who arrives, and what touches.

    The full plant, noise of sonars and postures; a course depends on its seed alone.
    Example: robotics stress obstacles --runs 200 --class U --json
    """
    from robotics.experiments.stress.obstaclecourse import stress_obstacles
    from robotics.experiments.stress.outcome import Disturbance
    from robotics.laws.catalogue import make_controller

    law = make_controller({"committed": "obstacles", "literal": "obstacles-literal"}.get(controller, controller))
    with progress_bar(quiet) as begin:
        outcome = stress_obstacles(
            law,
            range(seed, seed + runs),
            field.value,
            int(robots.value),
            begin,
            disturbance=Disturbance(loss=loss, latency=latency),
            moving=moving,
        )
    about: dict[str, Any] = {
        "controller": controller,
        "class": field.value,
        "robots": int(robots.value),
        "first_seed": seed,
    }
    about |= {"loss": loss, "latency_s": latency, "moving": moving}
    figures = outcome.summary()
    if json:
        print_json(about | figures)
        return
    failed = {name: seeds for name, seeds in figures.pop("failed_seeds").items() if seeds}
    for name, value in (about | figures).items():
        print(f"{name:22} {'-' if value is None else f'{value:.4g}' if isinstance(value, float) else value}")
    for name, seeds in failed.items():
        print(f"seeds, {name + ':':14} {', '.join(map(str, seeds))}")
