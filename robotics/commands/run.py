"""The command ``robotics run``."""

import sys
from pathlib import Path
from typing import Annotated, Any

import typer

from fuzzy.errors import InputError
from fuzzy.shell.progress import progress_bar
from fuzzy.shell.terminal import print_json
from robotics.commands.shared import Json, Quiet, report_divergences, versions

_COLUMNS = 6  # robots that get a column each
_MOST_AGES = 100_000_000  # of messages that a saved run holds: 400 MB


def run_(
    scenario: Annotated[
        str,
        typer.Argument(
            help="A scenario's name, or a .toml file; crossing or obstacles: the random one of --seed.",
            show_default=False,
        ),
    ],
    controller: Annotated[
        str | None,
        typer.Option("--controller", "-c", help="name or name:gain=value,... Default: the scenario's own, or fuzzy."),
    ] = None,
    seed: Annotated[int, typer.Option(min=0, help="The first seed.")] = 0,
    seeds: Annotated[int, typer.Option(min=1, help="How many seeds, from --seed on.")] = 1,
    plot: Annotated[Path | None, typer.Option(metavar="PICTURE", help="Draw the first seed: .png, .pdf, .svg.")] = None,
    save: Annotated[Path | None, typer.Option(metavar="FILE.npz", help="Save the run without loss.")] = None,
    table: Annotated[Path | None, typer.Option(metavar="FILE.csv", help="Save every sample as CSV.")] = None,
    events: Annotated[
        Path | None, typer.Option(metavar="FILE.csv", help="Save who avoided, yielded or timed out, and when.")
    ] = None,
    player: Annotated[
        bool, typer.Option("--animate", help="Write a page that plays the first seed: SCENARIO-seed-N.html.")
    ] = False,
    robots: Annotated[int | None, typer.Option(min=1, max=200, help="Of a crossing (3) or obstacles (1).")] = None,
    kind: Annotated[str | None, typer.Option("--class", help="Of a crossing: A or B; of obstacles: A, B or U.")] = None,
    loss: Annotated[float, typer.Option(min=0.0, max=1.0, help="Of these: share of messages lost.")] = 0.0,
    latency: Annotated[float, typer.Option(min=0.0, max=10.0, help="Of these: of the messages, s.")] = 0.0,
    freeze: Annotated[float, typer.Option(min=0.0, max=600.0, help="In a crossing: s one robot is held up.")] = 0.0,
    moving: Annotated[int, typer.Option(min=0, max=10, help="Of obstacles: discs that cross the lanes.")] = 0,
    json: Json = False,
    quiet: Quiet = False,
) -> None:
    """One scenario under one controller: its figures of merit, and a picture if asked.

    "crossing" and "obstacles" repeat exactly what `robotics stress` made of a seed, with the options it had.
    Example: robotics run lyapunov-sine --controller lyapunov:ky=10,kpsi=5 --seed 3 --plot out.png
    """
    import numpy as np

    from fuzzy.files.table import write_frame
    from robotics.laws.catalogue import make_controller
    from robotics.measures.registry import measure_all, metrics_of
    from robotics.scenario.reading import load_scenario
    from robotics.simulation.loop import simulate

    random = scenario if scenario in ("crossing", "obstacles") else None
    if random is not None:
        from robotics.experiments.stress.single import ALIASES, STRESSES

        if seeds > 1:
            raise InputError(f"{random}: one seed at a time; `robotics stress {random}` runs many")
        controller = controller or STRESSES[random]
        law = make_controller(ALIASES[random].get(controller, controller))
    else:
        if robots is not None or kind is not None or loss or latency or freeze or moving:
            raise InputError(
                "--robots, --class, --loss and --latency belong to `robotics run crossing` and `obstacles`, --freeze "
                f"to the first, --moving to the second; {scenario} says in its file what it has"
            )
        setting = load_scenario(scenario)
        controller = controller or setting.controller or "fuzzy"
        law = make_controller(controller)
    if plot is not None:
        from fuzzy.figures.drawing import check_picture

        check_picture(plot)
    for path, suffix in ((save, ".npz"), (table, ".csv"), (events, ".csv")):
        if path is not None and path.suffix != suffix:
            raise InputError(f"{path}: the file's name must end in {suffix}")
    outcome: dict[str, Any] | None = None
    with progress_bar(quiet) as begin:
        if random is not None:
            from robotics.experiments.stress.single import single_run

            links = save is not None or player
            disturbed = {"loss": loss, "latency": latency, "freeze": freeze}
            result, about = single_run(
                random, law, seed, robots, kind, disturbed, controller, links, begin, moving=moving
            )
            outcome = about.summary()
            name, count, team_kind = result.scenario, result.samples.shape[3], result.about.kind
        else:
            advance = begin(f"{setting.name}: {controller}", setting.ticks + 1)
            # How old each message is, for moving pictures: as many numbers as robots squared.
            links = (save is not None or player) and setting.kind == "team"
            if links and seeds * len(setting.robots) ** 2 * setting.ticks > _MOST_AGES:
                links = False
                print(
                    "robotics: too many robots and seeds to save the age of every message; the rest is", file=sys.stderr
                )
            result = simulate(setting, law, range(seed, seed + seeds), name=controller, links=links, progress=advance)
            name, count, team_kind = setting.name, len(setting.robots), setting.kind
    if save is not None:
        result.save(save)
    if table is not None:
        write_frame(result.frame(), table)
    if events is not None:
        from robotics.simulation.mode_changes import events_of

        write_frame(events_of(result), events)
    if plot is not None:
        from fuzzy.figures.drawing import save_figure
        from robotics.figures.controllers import plot_run

        save_figure(plot_run(result), plot)
    page = Path(f"{name}-seed-{seed}.html")
    if player:
        from robotics.playback.player import write_player

        write_player(result, page)
    values, meanings = measure_all(result, team_kind), metrics_of(team_kind)
    if json:
        print_json(
            {
                "scenario": name,
                "controller": controller,
                "level": law.level,
                "seeds": list(result.seeds),
                "metrics": {name: v[:, 0] if v.shape[1] == 1 else v for name, v in values.items()},
                "diverged": result.diverged,
                "versions": versions(),
            }
            | ({"outcome": outcome} if outcome is not None else {})
            | ({"player": str(page)} if player else {})
        )
    else:
        for name, metric in meanings.items():
            shown = values[name].mean(axis=0)
            if count > _COLUMNS:
                shown = np.array([shown.min(), np.median(shown), shown.max()])
            print(f"{name:28} {'  '.join(f'{v:10.4g}' for v in shown)}  {metric.unit:8} {metric.title}")
        if seeds > 1 or count > 1:
            columns = "; one column a robot" if count <= _COLUMNS else f"; least, median and largest of {count} robots"
            print(f"(mean over {seeds} seeds{columns if count > 1 else ''})")
        if outcome is not None:
            print(", ".join(f"{name} {outcome[name]}" for name in ("collisions", "deadlocks", "contacts", "arrived")))
        if player:
            print(page)
    report_divergences(result.divergences())
