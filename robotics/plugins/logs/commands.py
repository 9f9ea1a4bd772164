"""The command ``robotics dataset from-bag``: training data of drives that are logged, of any robot."""

import shlex
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

from fuzzy.files.atomic import check_target
from fuzzy.shell.options import FieldOptions, Json, Quiet, Shown, argument, option
from fuzzy.shell.progress import progress_bar
from fuzzy.shell.terminal import print_json
from robotics.plugins.logs.runfiles import Distribution

if TYPE_CHECKING:
    from robotics.plugins.logs.drivedata import DriveRecipe


def from_bag(
    *,
    logs: Annotated[list[Path], argument("Logs: rosbag2 folders, .mcap, .db3 or .bag files.", "LOG...")],
    out: Annotated[Path, option("File into which the table goes.", "--out", "-o", "FILE.csv")],
    robot: Annotated[
        list[str] | None, option("Whose drive: robot2; may be given again. Default: the one.", "NAMESPACE")
    ] = None,
    check: Annotated[Path | None, option("Keep every fourth stretch of 5 s for checking, here.", "FILE.csv")] = None,
    recipe: Annotated[
        "DriveRecipe",
        FieldOptions(
            "robotics.plugins.logs.drivedata:DriveRecipe",
            *("inputs", "driven", "look_ahead", "period", "gap", "delay", "whole"),
            inputs=Shown(metavar="A,B,..."),
        ),
    ],
    odom: Annotated[str, option("Odometry. Default: odom, or the only one.", "TOPIC")] = "",
    cmd_vel: Annotated[str, option("Commands. Default: cmd_vel, or the only one.", "TOPIC")] = "",
    reference: Annotated[
        str, option("The moving target, as odometry. Default: reference, if it is there.", "TOPIC")
    ] = "",
    path: Annotated[str, option("The path. Default: path, plan, or the only one, if there is one.", "TOPIC")] = "",
    ros: Distribution = "jazzy",
    json: Json = False,
    quiet: Quiet = False,
) -> None:
    """Make training data of logged drives: what a robot knew, and what it was commanded then.

    Odometry and commands of any robot on ROS 2 are enough. With a moving target or a path in the log the
    table says how it follows these, else how it drives from where it is to where it was a little later. `anfis train`
    learns from the table, and the law fuzzy drives by the result. FILE.card.md says what is in the table.

    \b
    Example:
      robotics run lyapunov-sine --controller lyapunov --rosbag drive
      robotics dataset from-bag drive -o drive.csv
      anfis train drive.csv --outputs v,w --rules 4 --epochs 5 -o driven.fis
    """
    import numpy as np

    from robotics.plugins.learning.datacard import write_set
    from robotics.plugins.logs.drive import read_drive
    from robotics.plugins.logs.drivedata import DRIVE_OUTPUTS, drive_data, drive_facts

    check_target(out, ".csv")
    check_target(check, ".csv")
    topics = {"odometry": odom, "commands": cmd_vel, "reference": reference, "path": path, "distribution": ros}
    with progress_bar(quiet) as begin:
        jobs = [(log, name) for log in logs for name in robot or [""]]
        advance = begin("reading", 2 * len(jobs))
        drives = []
        for log, name in jobs:
            drives.append(read_drive(log, name, **topics))
            advance()
        table = drive_data(drives, recipe, advance)
    everything = np.ones(len(table.values), dtype=bool)
    parts = {out: everything} if check is None else {out: ~table.for_checking, check: table.for_checking}
    facts = drive_facts(drives, recipe, table, _command(logs, robot or []))
    files: dict[str, Any] = {}
    for file, which in parts.items():
        card = write_set(file, facts, table.columns, table.values[which])
        files[str(file)] = {"rows": len(table.values[which]), "card": str(card)}
    if json:
        print_json({"files": files, "inputs": table.inputs, "outputs": DRIVE_OUTPUTS, "followed": table.followed})
        return
    for name, about in files.items():
        print(f"{name}: {about['rows']} rows, inputs {', '.join(table.inputs)}, outputs {', '.join(DRIVE_OUTPUTS)}")
    print(f"Followed: {table.followed}")


def _command(logs: list[Path], robots: list[str]) -> str:
    """What made the table, without folders and without what the card says anyway."""
    words = ["robotics", "dataset", "from-bag", *(log.name for log in logs)]
    return shlex.join([*words, *(word for name in robots for word in ("--robot", name))])
