"""The command ``robotics repeat``: one run of a stress test, made again."""

from enum import StrEnum
from typing import Annotated, Any

import typer

from fuzzy.shell.progress import progress_bar
from robotics.commands.completion import controllers
from robotics.commands.shared import (
    Distribution,
    Events,
    Json,
    Law,
    Layout,
    Mcap,
    Metric,
    Player,
    Plot,
    Quiet,
    Rosbag,
    Save,
    Storage,
    Table,
    chosen_controller,
    print_run,
)
from robotics.commands.stress_obstacles import Side


class Stress(StrEnum):
    """The stress tests."""

    crossing = "crossing"
    obstacles = "obstacles"


def repeat(
    stress: Annotated[Stress, typer.Argument(help="The stress test of which a run is repeated.", show_default=False)],
    seed: Annotated[int, typer.Option(min=0, help="The run's seed.")] = 0,
    robots: Annotated[
        int | None, typer.Option(min=1, max=200, help="Number of robots. Default: crossing: 3, obstacles: 1.")
    ] = None,
    kind: Annotated[
        str | None,
        typer.Option("--class", help="Class of the run. crossing: A or B, obstacles: A, B or U. Default: A"),
    ] = None,
    controller: Annotated[
        str | None,
        typer.Option(
            "--controller",
            "-c",
            help="Controller, as for the stress test. Default: right-of-way, or obstacles.",
            autocompletion=controllers,
        ),
    ] = None,
    law: Law = None,
    metric: Metric = None,
    loss: Annotated[float, typer.Option(min=0.0, max=1.0, help="Share of the messages that are lost.")] = 0.0,
    latency: Annotated[float, typer.Option(min=0.0, max=10.0, help="Latency of the messages, s.")] = 0.0,
    freeze: Annotated[float, typer.Option(min=0.0, max=600.0, help="Seconds for which one robot is held up.")] = 0.0,
    moving: Annotated[
        int, typer.Option(min=0, max=10, help="Number of discs that cross the lanes (obstacles only).")
    ] = 0,
    lanes: Annotated[
        Side, typer.Option(help="Lanes side by side, or crossing each other (obstacles with 3 robots only).")
    ] = Side.beside,
    plot: Plot = None,
    save: Save = None,
    table: Table = None,
    events: Events = None,
    player: Player = False,
    mcap: Mcap = None,
    rosbag: Rosbag = None,
    layout: Layout = None,
    storage: Storage = "mcap",
    ros: Distribution = "jazzy",
    json: Json = False,
    quiet: Quiet = False,
) -> None:
    """Repeat one run of a stress test by its seed, to look at it: the same to the last bit, with the same options.

    \b
    Example:
      robotics repeat crossing --seed 4 --animate
    """
    from robotics.commands.run_files import RunFiles
    from robotics.experiments.stress.single import ALIASES, STRESSES, single_run
    from robotics.laws.catalogue import make_controller
    from robotics.measures.registry import own_metrics

    name = chosen_controller(controller, law) or STRESSES[stress]
    driver, own = make_controller(ALIASES[stress].get(name, name)), own_metrics(metric or (), "team")
    logs: dict[str, Any] = {"mcap": mcap, "rosbag": rosbag, "layout": layout, "storage": storage, "distribution": ros}
    files = RunFiles(save=save, table=table, events=events, plot=plot, player=player, **logs)
    files.check_logs([seed])
    disturbance = {"loss": loss, "latency": latency, "freeze": freeze}
    ages = save is not None or player or files.logged
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
            lanes=lanes.value,
            logged=files.logged,
        )
        page = files.write(run, begin)
    print_run(run, page, json, outcome.summary(), own)
