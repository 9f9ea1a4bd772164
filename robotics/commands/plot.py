"""The command ``robotics plot``: one kind of picture of saved runs."""

from pathlib import Path
from typing import Annotated, Any, NamedTuple

import robotics
from fuzzy.errors import InputError
from fuzzy.naming import check_known
from fuzzy.shell.options import Json, argument, option
from robotics.commands.completion import one_of
from robotics.commands.shared import OneSeed, print_result


class Kind(NamedTuple):
    """A kind of picture."""

    function: str  # of the package robotics
    shows: str
    takes: tuple[str, ...] = ()  # of "robot", "time", "task"
    several: bool = False  # whether it shows several runs on one scenario beside each other


_KINDS = {
    "run": Kind("plot_run", "paths, errors, speeds and commands"),
    "paths": Kind("plot_paths", "paths from above, and errors across them with bands over the seeds", several=True),
    "errors": Kind("plot_errors", "errors of one robot in x, y and heading", ("robot",), several=True),
    "velocities": Kind(
        "plot_velocities", "speed, turn rate and demanded turn rate of one robot", ("robot",), several=True
    ),
    "team": Kind("plot_team", "a team: paths, errors, speeds, progress"),
    "formation": Kind("plot_formation", "a formation: paths, lead, speeds, wheels"),
    "progress": Kind("plot_progress", "progress of a team and its differences"),
    "distances": Kind("plot_distances", "distances d_ij between robots, and from obstacles"),
    "meetings": Kind("plot_meetings", "where robots came nearest to each other, magnified"),
    "avoidance": Kind("plot_avoidance", "a page about avoidance: paths, distances, errors, modes", several=True),
    "sonar": Kind("plot_sonar", "readings of the range sensors", ("robot",)),
    "modes": Kind("plot_modes", "what robots were about: tracking, avoiding, yielding"),
    "rules": Kind("plot_rules_at", "which rules fired for one robot at one time", ("robot", "time", "task")),
}
# Those of plug-ins are there where these are
PLOT_KINDS = {name: kind for name, kind in _KINDS.items() if kind.function in vars(robotics)["__all__"]}


def plot(
    runs: Annotated[
        list[Path],
        argument(
            "Files that `robotics run ... --save` wrote; several, of one scenario, for "
            f"{', '.join(name for name, kind in PLOT_KINDS.items() if kind.several)}.",
            "RUN.npz",
        ),
    ],
    out: Annotated[Path, option("The file to write: .png, .pdf or .svg.", "--out", "-o", "PICTURE")],
    kind: Annotated[
        str,
        option(
            "; ".join(f"{name}: {about.shows}" for name, about in PLOT_KINDS.items()) + ".",
            "--kind",
            "-k",
            autocompletion=one_of(PLOT_KINDS),
        ),
    ] = "run",
    seed: OneSeed = None,
    robot: Annotated[
        int | None, option("The robot, from 1; for errors, velocities, rules (default: 1) and sonar (all).")
    ] = None,
    time: Annotated[float | None, option("The time, s; for rules.", "S")] = None,
    task: Annotated[str | None, option("The rule base, by its task in the law; for rules. Default: the first.")] = None,
    json: Json = False,
) -> None:
    """Draw one kind of picture of a saved run, or of several on one scenario beside each other.

    \b
    Example:
      robotics run three-cross --save run.npz
      robotics plot run.npz --kind distances -o distances.png
    """
    check_known(kind, PLOT_KINDS, "kind of picture")
    about = PLOT_KINDS[kind]
    for name, value in (("robot", robot), ("time", time), ("task", task)):
        if value is not None and name not in about.takes:
            takers = " and ".join(other for other, each in PLOT_KINDS.items() if name in each.takes)
            raise InputError(f"--{name} belongs to the kind{'s' if ' and ' in takers else ''} {takers}, not to {kind}")
    if time is None and "time" in about.takes:
        raise InputError(f"the kind {kind} needs --time S")
    if len(runs) > 1 and not about.several:
        raise InputError(f"the kind {kind} shows one run, got {len(runs)}")

    from fuzzy.figures.drawing import check_picture, save_figure
    from robotics.simulation.run import load_run

    check_picture(out)
    loaded = [load_run(path) for path in runs]
    options: dict[str, Any] = {"seed": seed}
    if robot is not None:
        options["robot"] = robot - 1 if about.several else robot  # the pictures of several runs count from 0
    options |= {name: value for name, value in (("time", time), ("task", task)) if value is not None}
    save_figure(getattr(robotics, about.function)(loaded if about.several else loaded[0], **options), out)
    print_result(json, {"file": str(out), "kind": kind, "scenario": loaded[0].scenario}, str(out))
