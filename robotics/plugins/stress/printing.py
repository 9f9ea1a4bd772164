"""Shared parts of the commands about stress tests: the options of disturbances, and how outcomes are printed."""

import sys
from collections.abc import Mapping
from typing import TYPE_CHECKING, Annotated, Any

import typer

from fuzzy.shell.interrupts import interrupted
from fuzzy.shell.options import FieldOptions, Shown
from fuzzy.shell.terminal import USAGE, print_json
from robotics.commands.shared import number_cell

if TYPE_CHECKING:
    from robotics.plugins.stress.crew import Stressed
    from robotics.plugins.stress.disturbance import Disturbance

Wrong = Annotated[
    "Disturbance",
    FieldOptions(
        "robotics.plugins.stress.disturbance:Disturbance",
        freeze=Shown(doc="Stop one robot for this many seconds."),
    ),
]


def print_stressed(about: Mapping[str, Any], stressed: "Stressed[Any]", json: bool) -> None:
    """Print the outcome of a stress test, also of one that was stopped: then say which seeds are missing, and exit."""
    if stressed.outcome is not None:
        missing = [list(seeds) for seeds in stressed.missing]
        print_outcome({**about, **stressed.outcome.summary()} | ({"missing_seeds": missing} if missing else {}), json)
    if not stressed.missing:
        return
    done = 0 if stressed.outcome is None else len(stressed.outcome.seeds)
    total = done + sum(last - first + 1 for first, last in stressed.missing)
    seeds = ", ".join(f"{first} to {last}" if last > first else str(first) for first, last in stressed.missing)
    left = f"{done} of {total} runs are done; the seeds {seeds} are missing"
    if stressed.interrupted:
        interrupted(left)
    print(f"robotics: {stressed.reason}; {left}", file=sys.stderr)
    raise typer.Exit(USAGE)


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
