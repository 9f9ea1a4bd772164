"""The command line ``anfis``: one module a command beside this one.

Data goes to stdout, progress and messages to stderr. What a command needs is imported when it runs, so that
``--help`` is quick.
"""

from collections.abc import Sequence
from functools import partial

from fuzzy.shell.terminal import application, run, versions_with

app = application(
    "Learn Sugeno fuzzy systems from data.",
    "fuzzy example samples check",
    "anfis train samples.csv --check check.csv --rules 8 --epochs 60 -o net.fis",
    program="anfis",
    commands="train predict evaluate",
    version=partial(versions_with, "torch"),
)


def main(arguments: Sequence[str] | None = None) -> int:
    """Run the command line and return the exit code: 0 fine, 2 an error, 130 Ctrl-C."""
    return run(app, "anfis", arguments)
