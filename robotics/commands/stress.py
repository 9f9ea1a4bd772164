"""The command line ``robotics stress``: thousands of random scenarios, and what went wrong in which."""

import os
from enum import StrEnum
from typing import Annotated

import typer

from fuzzy.shell.progress import progress_bar
from fuzzy.shell.terminal import print_json
from robotics.commands.obstacles import obstacles

stress = typer.Typer(help="Thousands of random scenarios.", rich_markup_mode=None, no_args_is_help=True)
stress.command("obstacles")(obstacles)


CHUNK, MOST = 600, 20_000  # robots, and pairs of them, that are simulated in one pass


def cores() -> int:
    """How many cores this process may use."""
    return len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1


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
        str,
        typer.Option(help="right-of-way, literal, lag-clock, yielding, none, or one that `robotics list` names."),
    ] = "right-of-way",
    loss: Annotated[float, typer.Option(min=0.0, max=1.0, help="Share of the messages that are lost.")] = 0.0,
    latency: Annotated[float, typer.Option(min=0.0, max=10.0, help="Of the messages, s.")] = 0.0,
    freeze: Annotated[float, typer.Option(min=0.0, max=600.0, help="Seconds for which one robot is held up.")] = 0.0,
    seed: Annotated[int, typer.Option(min=0, help="The first crossing's seed.")] = 0,
    jobs: Annotated[
        int | None, typer.Option(min=1, max=1000, help="Processes. Default: as many as there are cores, if it pays.")
    ] = None,
    json: Annotated[bool, typer.Option("--json", help="Print one JSON object instead of text.")] = False,
    quiet: Annotated[bool, typer.Option("--quiet", "-q", help="No progress bar.")] = False,
) -> None:
    """Random crossings of paths: who arrives, who waits for ever, and who touches.

    The full plant and noise of the postures; a crossing depends on its seed alone, so that `robotics run crossing
    --seed N` with the same options repeats, draws and saves one that failed. The number of processes changes nothing.
    Example: robotics stress crossing --robots 3 --runs 2000 --json
    """
    from robotics.experiments.stress.crossing_runs import stress_crossing
    from robotics.experiments.stress.outcome import Disturbance, joined
    from robotics.experiments.stress.single import ALIASES
    from robotics.laws.catalogue import make_controller

    law = make_controller(ALIASES["crossing"].get(controller, controller))
    disturbance = Disturbance(loss=loss, latency=latency, freeze=freeze)
    seeds = range(seed, seed + runs)
    size = max(1, min(CHUNK // robots, MOST // robots**2))
    chunks = [seeds[k : k + size] for k in range(0, runs, size)]
    workers = min(len(chunks), jobs or cores())
    with progress_bar(quiet) as begin:
        if workers == 1:
            outcome = joined([stress_crossing(law, robots, chunk, ends.value, disturbance, begin) for chunk in chunks])
        else:
            from robotics.experiments import executors

            advance = begin("crossings", len(chunks))
            with executors.processes(
                workers, ["robotics.experiments.stress.outcome", "robotics.laws.catalogue"]
            ) as crew:
                work = [
                    crew.executor.submit(stress_crossing, law, robots, chunk, ends.value, disturbance)
                    for chunk in chunks
                ]
                parts = []
                for future in work:
                    parts.append(future.result())
                    advance()
            outcome = joined(parts)
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
