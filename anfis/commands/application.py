"""The command line ``anfis``: one module a command beside this one.

Data goes to stdout, progress and messages to stderr. What a command needs is imported when it runs, so that
``--help`` is quick.
"""

import sys
from collections.abc import Sequence
from typing import Annotated

import typer

from anfis.commands.evaluate import evaluate
from anfis.commands.predict import predict
from anfis.commands.train import train
from fuzzy.errors import InputError
from fuzzy.shell.terminal import application, run

app = application(
    "Learn Sugeno fuzzy systems from data.",
    "fuzzy example samples check",
    "anfis train samples.csv --check check.csv --rules 8 --epochs 60 -o net.fis",
)

app.command()(train)
app.command()(predict)
app.command()(evaluate)


def main(arguments: Sequence[str] | None = None) -> int:
    """Run the command line and return the exit code: 0 fine, 2 an error, 130 Ctrl-C."""
    return run(app, (InputError,), "anfis", arguments)


def _version(wanted: bool) -> None:
    if wanted:
        from importlib.metadata import version

        python = ".".join(map(str, sys.version_info[:3]))
        print(f"fuzzyfleet {version('fuzzyfleet')} (torch {version('torch')}, Python {python})")
        raise typer.Exit


@app.callback()
def _options(
    version: Annotated[
        bool, typer.Option("--version", callback=_version, is_eager=True, help="Print the versions and stop.")
    ] = False,
) -> None:
    pass
