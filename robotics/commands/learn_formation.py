"""The command ``robotics learn formation``: formation networks from formation data."""

import os
import shlex
from collections.abc import Sequence
from pathlib import Path
from typing import Annotated

import typer

from anfis.methods.catalogue import METHODS
from fuzzy.shell.progress import progress_bar
from fuzzy.shell.terminal import print_json
from robotics.commands.completion import scenarios
from robotics.commands.shared import Jobs, Json, Quiet

PAYS = 4  # networks: more of them are learnt in several processes, which take seconds to start

DRIVES = ("formation-behind", "formation-ahead")  # of a leader and its followers, from datasets/README.md


def formation(
    data: Annotated[Path, typer.Argument(metavar="DATA.csv", help="Formation data with a header line.")],
    out: Annotated[
        Path, typer.Option("--out", "-o", metavar="FOLDER", help="Folder into which v_l.fis ... or v_1.fis ... go.")
    ],
    check: Annotated[
        Path | None, typer.Option(metavar="CHECK.csv", help="Checking data with the same columns.")
    ] = None,
    rules: Annotated[
        int, typer.Option(min=1, help="Wanted number of rules; the nearest that a setting gives is taken.")
    ] = 8,
    method: Annotated[str, typer.Option(help=f"Method of learning: {', '.join(METHODS)}.")] = "hybrid",
    epochs: Annotated[int, typer.Option(min=0, help="Number of epochs of learning.")] = 60,
    report: Annotated[
        Path | None,
        typer.Option(metavar="PAGE.html", help="Write a page about data, networks and how they drive: one file."),
    ] = None,
    title: Annotated[str | None, typer.Option(help="Title of the page.", show_default=False)] = None,
    drive: Annotated[
        list[str] | None,
        typer.Option(
            metavar="SCENARIO",
            help="Scenario, or .toml file, that the networks drive for the page; can be given several times. Default: "
            f"{', '.join(DRIVES)}.",
            autocompletion=scenarios,
            show_default=False,
        ),
    ] = None,
    seeds: Annotated[int, typer.Option(min=1, help="Number of seeds of each drive, from 0 on.")] = 1,
    jobs: Jobs = None,
    json: Json = False,
    quiet: Quiet = False,
) -> None:
    """Cluster and train the networks that drive a formation: the thesis's four, or two for each robot of a scenario.

    \b
    Example:
      robotics dataset formation -o formation.csv
      robotics dataset formation --check -o check.csv
      robotics learn formation formation.csv --check check.csv -o networks --report report.html
      robotics run formation-behind --controller formation:networks=networks
    """
    from threadpoolctl import threadpool_limits

    from anfis import Options
    from fuzzy.files.table import read_table
    from robotics.experiments.learning.formationlearning import (
        FormationLearningError,
        learn_networks,
        outputs_of,
        steps,
        write_networks,
    )
    from robotics.scenario.reading import load_scenario

    options = Options(method=method, epochs=epochs)
    if report is None and (title is not None or drive):
        raise FormationLearningError(f"--{'drive' if drive else 'title'} belongs to --report PAGE.html")
    if report is not None and report.suffix != ".html":
        raise FormationLearningError(f"{report}: the page's name must end in .html")
    scenarios = [load_scenario(name) for name in drive or []]
    names, values = read_table(data)
    if names is None:
        raise FormationLearningError(f"{data}: a header line with the columns' names is needed")
    held = None
    if check is not None:
        others, held = read_table(check)
        if others != names:
            raise FormationLearningError(f"{check}: its columns must be those of {data}: {', '.join(names)}")
    with threadpool_limits(1, "blas"), progress_bar(quiet) as begin:  # the matrices are small
        outputs = outputs_of(names)
        advance = begin("learning", steps(epochs, len(outputs)))
        count = jobs or (min(os.cpu_count() or 1, len(outputs)) if len(outputs) > PAYS else 1)
        networks = learn_networks(names, values, held, rules=rules, options=options, advance=advance, jobs=count)
        write_networks(networks, out, data.name)
        if report is not None:
            from robotics.laws.formation.leader_follower import OUTPUTS
            from robotics.report.learning import Samples, drive_networks, write_learning_report

            if drive is None and {network.output for network in networks} == set(OUTPUTS):
                scenarios = [load_scenario(name) for name in DRIVES]
            write_learning_report(
                report,
                networks,
                Samples(str(data), names, values),
                None if held is None else Samples(str(check), names, held),
                runs=drive_networks(out, scenarios, range(seeds), begin),
                title=title,
                folder=str(out),
                command=_command(data, check, out, rules, method, epochs, report, title, drive, seeds),
                begin=begin,
            )
    rows = []
    for network in networks:
        training, trial = network.training, network.trial
        best = training.history[training.best]
        rows.append(
            {
                "output": network.output,
                "inputs": [variable.name for variable in network.after.inputs],
                "rules": trial.rules,
                "radius": trial.radius,
                "squash": trial.options.squash,
                "accept": trial.options.accept,
                "reject": trial.options.reject,
                "clustering_rmse": training.history[0].train,
                "train_rmse": best.train,
                "check_rmse": best.check,
                "best_epoch": training.best,
                "stopped": training.stopped,
                "file": str(out / f"{network.output}.fis"),
            }
        )
    if json:
        print_json({"method": method, "networks": rows} | ({} if report is None else {"report": str(report)}))
        return
    for row in rows:
        checked = "" if check is None else f", {row['check_rmse']:.2e} checking"
        print(
            f"{row['file']}: {row['rules']} rules; RMSE {row['clustering_rmse']:.2e} by clustering, then "
            f"{row['train_rmse']:.2e} training{checked} (epoch {row['best_epoch']})"
        )
    if report is not None:
        print(report)


def _command(
    data: Path,
    check: Path | None,
    out: Path,
    rules: int,
    method: str,
    epochs: int,
    report: Path,
    title: str | None,
    drive: Sequence[str] | None,
    seeds: int,
) -> str:
    """The command line that makes the same page."""
    words = ["robotics", "learn", "formation", str(data), *(["--check", str(check)] if check else []), "-o", str(out)]
    words += [f"--rules={rules}", f"--method={method}", f"--epochs={epochs}", f"--report={report}"]
    words += [*([f"--title={title}"] if title is not None else []), *(f"--drive={name}" for name in drive or [])]
    return shlex.join([*words, f"--seeds={seeds}"])
