"""The command line ``robotics stress``: thousands of random scenarios, and what went wrong in which."""

from enum import StrEnum
from typing import Annotated

import typer

from fuzzy.progress import progress_bar
from fuzzy.terminal import print_json
from robotics.commands.obstacles import obstacles

stress = typer.Typer(help="Thousands of random scenarios.", rich_markup_mode=None, no_args_is_help=True)
stress.command("obstacles")(obstacles)


class Ends(StrEnum):
    """Where the paths of a crossing may end."""

    A = "A"
    B = "B"


@stress.command()
def crossing(
    runs: Annotated[int, typer.Option(min=1, max=1_000_000, help="How many random crossings.")] = 1000,
    robots: Annotated[int, typer.Option(min=2, max=200, help="How many robots each.")] = 3,
    ends: Annotated[
        Ends, typer.Option("--class", help="A: ends clear of the other paths; B: ends only apart from each other.")
    ] = Ends.A,
    controller: Annotated[
        str, typer.Option(help="right-of-way, literal, or a controller that `robotics list` names.")
    ] = "right-of-way",
    loss: Annotated[float, typer.Option(min=0.0, max=1.0, help="Share of the messages that are lost.")] = 0.0,
    latency: Annotated[float, typer.Option(min=0.0, max=10.0, help="Of the messages, s.")] = 0.0,
    freeze: Annotated[float, typer.Option(min=0.0, help="Seconds for which one robot is held up.")] = 0.0,
    seed: Annotated[int, typer.Option(min=0, help="The first crossing's seed.")] = 0,
    json: Annotated[bool, typer.Option("--json", help="Print one JSON object instead of text.")] = False,
    quiet: Annotated[bool, typer.Option("--quiet", "-q", help="No progress bar.")] = False,
) -> None:
    """Random crossings of paths: who arrives, who waits for ever, and who touches.

    The full plant and noise of the postures; a crossing depends on its seed alone, so that --seed N --runs 1 repeats
    one that failed. Example: robotics stress crossing --robots 3 --runs 2000 --json
    """
    from robotics.controllers import make_controller
    from robotics.stress.outcome import Disturbance, stress_crossing

    law = make_controller({"literal": "crash-literal"}.get(controller, controller))
    disturbance = Disturbance(loss=loss, latency=latency, freeze=freeze)
    with progress_bar(quiet) as begin:
        outcome = stress_crossing(law, robots, range(seed, seed + runs), ends.value, disturbance, begin)
    figures = {"controller": controller, "class": ends.value, "robots": robots, "first_seed": seed} | outcome.summary()
    if json:
        print_json(figures)
        return
    failed = figures.pop("failed_seeds")
    for name, value in figures.items():
        print(f"{name:22} {'-' if value is None else f'{value:.4g}' if isinstance(value, float) else value}")
    for name, seeds in failed.items():
        if seeds:
            print(f"seeds, {name + ':':14} {', '.join(map(str, seeds))}")
