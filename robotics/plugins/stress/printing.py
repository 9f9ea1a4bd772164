"""Shared parts of the commands about stress tests: options, how they are run, and how outcomes are printed."""

import sys
from collections.abc import Mapping, Sequence
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from fuzzy.shell.interrupts import interrupted
from fuzzy.shell.options import FieldOptions, Shown, option
from fuzzy.shell.progress import progress_bar
from fuzzy.shell.terminal import USAGE, print_json
from robotics.commands.completion import robots
from robotics.commands.shared import number_cell
from robotics.commands.study_printing import already_there

if TYPE_CHECKING:
    from robotics.plugins.stress.crew import Crew
    from robotics.plugins.stress.disturbance import Disturbance
    from robotics.plugins.stress.outcome import StressOutcome

Wrong = Annotated[
    "Disturbance",
    FieldOptions(
        "robotics.plugins.stress.disturbance:Disturbance",
        freeze=Shown(doc="Stop one robot for this many seconds."),
    ),
]
Runners = Annotated["Crew", FieldOptions("robotics.plugins.stress.crew:Crew")]
Driven = Annotated[
    str | None,
    option(
        "What the robots are: a name of `robotics list robots`, or a .toml file. All lengths grow with its turning "
        "circle. Default: etsro",
        "--robot",
        "NAME|FILE",
        autocompletion=robots,
    ),
]


def run_stress(
    about: Mapping[str, Any],
    stress: "partial[Any]",
    kind: "type[StressOutcome]",
    robots: int,
    seeds: Sequence[int],
    crew: "Crew",
    *,
    json: bool,
    quiet: bool,
    threads: bool = False,
) -> None:
    """Do a stress test and print its outcome, also of one that was stopped: then say which seeds are missing, and exit.

    Args:
        about: What is printed before the outcome.
        stress: As :func:`robotics.plugins.stress.running.in_pieces` takes it, as the next four and ``threads``.
        kind: The class of the outcome.
        robots: Number of robots of each run.
        seeds: One run for each.
        crew: Who does it.
        json: Whether one JSON object is printed.
        quiet: Whether no progress is shown.
        threads: Whether processes are threads.
    """
    from robotics.laws.catalogue import files_of
    from robotics.plugins.stress.running import in_pieces
    from robotics.simulation.scenario.robots import robot_file
    from robotics.studies.versions import digest_of

    files = {name: digest_of(path) for name, path in sorted(files_of(stress.args[0]).items())}
    if robot := stress.keywords.get("robot"):
        files[robot] = digest_of(robot_file(robot).path)
    whole = {"test": stress.func.__name__, **about, **stress.keywords, "runs": len(seeds), "files_sha256": files}
    told = already_there(crew.out or Path(), quiet)
    with progress_bar(quiet) as begin:
        done = in_pieces(stress, robots, seeds, crew, begin=begin, threads=threads, about=whole, resumed=told)
    missing = _stretches(done.missing)
    if done.table is not None:
        print_outcome({**about, **kind(done.table).summary()} | ({"missing_seeds": missing} if missing else {}), json)
    if not missing:
        return
    left = ", ".join(f"{first} to {last}" if last > first else str(first) for first, last in missing)
    said = f"{len(seeds) - sum(map(len, done.missing))} of {len(seeds)} runs are done; the seeds {left} are missing"
    said += "" if crew.out is None else "; the same command goes on from there"
    if done.interrupted:
        interrupted(said)
    print(f"robotics: {done.reason}; {said}", file=sys.stderr)
    raise typer.Exit(USAGE)


def _stretches(parts: Sequence[Sequence[int]]) -> list[list[int]]:
    """The first and the last seed of every stretch of parts that follow each other."""
    found: list[list[int]] = []
    for part in parts:
        first = found.pop()[0] if found and found[-1][1] + 1 == part[0] else part[0]
        found.append([first, part[-1]])
    return found


def print_outcome(figures: Mapping[str, Any], json: bool) -> None:
    """Print the outcome of a stress test: a line for each number, and the seeds of the runs that failed."""
    if json:
        print_json(figures)
        return
    for name, value in figures.items():
        if name not in ("failed_seeds", "missing_seeds"):
            print(f"{name:22} {number_cell(value) if value is None or isinstance(value, float) else value}")
    for name, seeds in figures["failed_seeds"].items():
        if seeds:
            print(f"seeds, {name + ':':14} {', '.join(map(str, seeds))}")
