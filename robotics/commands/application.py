"""The command line ``robotics``; every command has a module of its own beside this one.

Data goes to stdout, progress and messages to stderr. What a command needs is imported when it runs, so that
``--help`` is quick.
"""

import sys
from collections.abc import Sequence
from typing import Annotated

import typer

from fuzzy.errors import InputError
from fuzzy.shell.terminal import application, run
from robotics.commands.animate import animate
from robotics.commands.arena import arena
from robotics.commands.certify import certify
from robotics.commands.check import check
from robotics.commands.compare import compare
from robotics.commands.copy import copy
from robotics.commands.dataset import dataset
from robotics.commands.explain import explain
from robotics.commands.export import export
from robotics.commands.learn import learn
from robotics.commands.list import list_
from robotics.commands.new import new
from robotics.commands.plot import plot
from robotics.commands.reinforce import reinforce
from robotics.commands.repeat import Stress, repeat
from robotics.commands.robot import robot
from robotics.commands.run import run_
from robotics.commands.scenario import scenario
from robotics.commands.stress import stress
from robotics.commands.study import study
from robotics.commands.sweep import sweep
from robotics.commands.team import team
from robotics.commands.tune import tune
from robotics.experiments.versions import versions

app = application(
    "Simulate robots and compare their controllers, fuzzy and nonlinear, on the same terms.",
    "robotics list scenarios",
    "robotics run lyapunov-sine --plot sine.png",
)

app.add_typer(dataset, name="dataset")
app.add_typer(stress, name="stress")
app.add_typer(learn, name="learn")
app.add_typer(export, name="export")
app.command("list")(list_)
app.command()(copy)
app.command()(scenario)
app.command()(new)
app.command()(check)
app.command("run")(run_)
app.command()(repeat)
app.command()(compare)
app.command()(plot)
app.command()(explain)
app.command()(animate)
app.command()(certify)
app.command()(robot)
app.command()(sweep)
app.command()(tune)
app.command()(reinforce)
app.command()(arena)
app.command()(study)
app.command()(team)


def main(arguments: Sequence[str] | None = None) -> int:
    """Run the command line and return the exit code: 0 fine, 2 an error or a diverged controller, 130 Ctrl-C."""
    return run(app, (InputError,), "robotics", _as_named_today(sys.argv[1:] if arguments is None else arguments))


def _as_named_today(arguments: Sequence[str]) -> list[str]:
    """The arguments by today's names: what version 0.1 called `run crossing|obstacles` and `learn DATA.csv`."""
    match list(arguments):
        case ["run", stress, *rest] if stress in list(Stress):
            return _renamed(f"run {stress}", ["repeat", stress], rest)
        case ["learn", data, *rest] if data.endswith(".csv"):
            return _renamed("learn DATA.csv", ["learn", "formation"], [data, *rest])
    return list(arguments)


def _renamed(before: str, now: list[str], rest: list[str]) -> list[str]:
    print(
        f"robotics: `{before}` is now called `{' '.join(now)}`; the old name goes in the next release", file=sys.stderr
    )
    return [*now, *rest]


def _version(wanted: bool) -> None:
    if wanted:
        print(" ".join(f"{name} {version}" for name, version in versions().items()))
        raise typer.Exit


@app.callback()
def _options(
    version: Annotated[
        bool, typer.Option("--version", callback=_version, is_eager=True, help="Print the versions and stop.")
    ] = False,
) -> None:
    pass
