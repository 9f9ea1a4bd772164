"""The command ``robotics learn formation``: formation networks from formation data."""

import os
import shlex
import sys
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

from fuzzy.commands.datafile import SkipBad
from fuzzy.files.atomic import check_folder, check_target
from fuzzy.shell.options import FieldOptions, Json, Quiet, Shown, argument, option, renamed_options
from fuzzy.shell.progress import progress_bar
from fuzzy.shell.terminal import print_json
from fuzzy.shown import shown
from robotics.commands.completion import scenarios
from robotics.commands.shared import Workers

if TYPE_CHECKING:
    from anfis import Options

PAYS = 4  # networks: more of them are learnt in several processes, which take seconds to start

DRIVES = ("formation-behind", "formation-ahead")  # of a leader and its followers, from datasets/README.md


@renamed_options(jobs="--workers")
def formation(
    *,
    data: Annotated[Path, argument('Formation data below a header of names, "v_l" or "v_l [m/s]".', "DATA.csv")],
    out: Annotated[Path, option("Folder into which v_l.fis ... or v_1.fis ... go.", "--out", "-o", "FOLDER")],
    check: Annotated[Path | None, option("Checking data with the same columns.", "CHECK.csv")] = None,
    rules: Annotated[int, option("Wanted number of rules; the nearest that a setting gives is taken.", min=1)] = 8,
    options: Annotated[
        "Options",
        FieldOptions("anfis.methods.options:Options", "method", "epochs", epochs=Shown(default=60)),
    ],
    report: Annotated[
        Path | None, option("Write a page about data, networks and how they drive: one file.", "PAGE.html")
    ] = None,
    title: Annotated[str | None, option("Title of the page.", show_default=False)] = None,
    drive: Annotated[
        list[str] | None,
        option(
            "Scenario, or .toml file, that the networks drive for the page; can be given several times. Default: "
            f"{', '.join(DRIVES)}.",
            "SCENARIO",
            autocompletion=scenarios,
            show_default=False,
        ),
    ] = None,
    seeds: Annotated[int, option("Number of seeds of each drive, from 0 on.", min=1)] = 1,
    workers: Workers = None,
    skip_bad: SkipBad = False,
    json: Json = False,
    quiet: Quiet = False,
) -> None:
    """Cluster and train the networks that drive a formation: the thesis's four, or two for each robot of a scenario.

    \b
    Example:
      robotics dataset formation --kind well-posed -o formation.csv
      robotics dataset formation --kind well-posed --check -o check.csv
      robotics learn formation formation.csv --check check.csv -o networks --report report.html
      robotics run formation-behind --controller formation:networks=networks
    """
    from threadpoolctl import threadpool_limits

    from fuzzy.files.table import BadRowsError
    from robotics.plugins.learning import formationlearning as learning
    from robotics.simulation.scenario.reading import load_scenario

    if report is None and (title is not None or drive):
        raise learning.FormationLearningError(f"--{'drive' if drive else 'title'} belongs to --report PAGE.html")
    check_folder(out)
    check_target(report, ".html", folder_is_made=True)
    scenarios = [load_scenario(name) for name in drive or []]
    try:
        reads = [learning.formation_table(data, skip_bad=skip_bad)]
        if check is not None:
            reads.append(learning.formation_table(check, reads[0].names, skip_bad=skip_bad))
    except BadRowsError as error:
        raise BadRowsError(f"{error}; --skip-bad leaves such rows out") from None
    names, values = reads[0].names, [read.values for read in reads]  # of the data, and of the checking data
    for read in reads:
        if read.skipped:
            print(read.omission, file=sys.stderr)
    with threadpool_limits(1, "blas"), progress_bar(quiet) as begin:  # the matrices are small
        outputs = learning.outputs_of(names)
        advance = begin("learning", learning.steps(options.epochs, len(outputs)))
        count = workers or (min(os.cpu_count() or 1, len(outputs)) if len(outputs) > PAYS else 1)
        networks = learning.learn_networks(names, *values, rules=rules, options=options, advance=advance, jobs=count)
        learning.write_networks(networks, out, data.name)
        if report is not None:
            from robotics.laws.formation.leader_follower import FORMATION_OUTPUTS
            from robotics.plugins.learning.datatable import Samples
            from robotics.plugins.learning.report import drive_networks, write_learning_report

            words = ["robotics", "learn", "formation", str(data), *([] if check is None else ["--check", str(check)])]
            words += ["-o", str(out), f"--rules={rules}", f"--method={options.method}", f"--epochs={options.epochs}"]
            words += [f"--report={report}", *([] if title is None else [f"--title={title}"])]
            words += [f"--drive={name}" for name in drive or []]
            if drive is None and {network.output for network in networks} == set(FORMATION_OUTPUTS):
                scenarios = [load_scenario(name) for name in DRIVES]
            write_learning_report(
                report,
                networks,
                *(Samples(read.file, names, read.values, len(read.skipped)) for read in reads),
                runs=drive_networks(out, scenarios, range(seeds), begin),
                title=title,
                folder=str(out),
                command=shlex.join([*words, *["--skip-bad"] * skip_bad, f"--seeds={seeds}"]),
                begin=begin,
            )
    rows = []
    for network in networks:
        training, trial = network.training, network.trial
        row: dict[str, Any] = {"output": network.output, "inputs": [variable.name for variable in network.after.inputs]}
        row |= {"rules": trial.rules, "radius": trial.radius}
        row |= {name: getattr(trial.options, name) for name in ("squash", "accept", "reject")}
        best = training.history[training.best]
        row |= {"clustering_rmse": training.history[0].train, "train_rmse": best.train, "check_rmse": best.check}
        row |= {"best_epoch": training.best, "stopped": training.stopped, "remarks": network.remarks}
        rows.append(row | {"file": str(out / f"{network.output}.fis")})
    if json:
        told = {"method": options.method, "skipped": sum(len(read.skipped) for read in reads), "networks": rows}
        print_json(told if report is None else told | {"report": str(report)})
        return
    for row in rows:
        errors = (row[f"{stage}_rmse"] for stage in ("clustering", "train", "check"))
        first, last, held_error = (shown(error, digits=3) for error in errors)
        checked = "" if check is None else f", {held_error} checking"
        print(
            f"{row['file']}: {row['rules']} rules; RMSE {first} by clustering, then {last} training{checked} "
            f"(epoch {row['best_epoch']})",
            *(f"  note: {remark}" for remark in row["remarks"]),
            sep="\n",
        )
    if report is not None:
        print(report)
