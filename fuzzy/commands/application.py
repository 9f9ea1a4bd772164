"""The command line ``fuzzy``: one module a command beside this one.

Data goes to stdout, messages to stderr. What a command needs is imported when it runs, so that ``--help`` is quick.
"""

import sys
from collections.abc import Sequence
from typing import Annotated

import typer

from fuzzy.commands.check import check
from fuzzy.commands.convert import convert
from fuzzy.commands.design import design
from fuzzy.commands.evaluate import evaluate
from fuzzy.commands.example import example
from fuzzy.commands.explain import explain
from fuzzy.commands.export import export
from fuzzy.commands.identify import identify
from fuzzy.commands.new import new
from fuzzy.commands.plot import plot
from fuzzy.commands.rules import rules
from fuzzy.commands.search import search
from fuzzy.commands.show import show
from fuzzy.commands.step import step
from fuzzy.commands.surface import surface
from fuzzy.commands.tune import tune
from fuzzy.errors import InputError
from fuzzy.shell.terminal import application, run

app = application(
    "Look at, check, draw, evaluate and identify Sugeno fuzzy systems in MATLAB's .fis files.",
    "fuzzy example tipper",
    "fuzzy show tipper.fis",
)

for command in (
    show,
    rules,
    plot,
    surface,
    explain,
    check,
    evaluate,
    convert,
    identify,
    search,
    tune,
    step,
    design,
    new,
    example,
):
    app.command()(command)
app.add_typer(export, name="export")


def main(arguments: Sequence[str] | None = None) -> int:
    """Run the command line and return the exit code: 0 fine, 1 a check found something, 2 an error, 130 Ctrl-C."""
    return run(app, (InputError,), "fuzzy", arguments)


def _version(wanted: bool) -> None:
    if wanted:
        from importlib.metadata import version

        import numpy

        python = ".".join(map(str, sys.version_info[:3]))
        print(f"fuzzyfleet {version('fuzzyfleet')} (numpy {numpy.__version__}, Python {python})")
        raise typer.Exit


@app.callback()
def _options(
    version: Annotated[
        bool, typer.Option("--version", callback=_version, is_eager=True, help="Print the versions and stop.")
    ] = False,
) -> None:
    pass
