"""The command line ``fuzzy``: one module a command beside this one.

Data goes to stdout, messages to stderr. What a command needs is imported when it runs, so that ``--help`` is quick.
"""

from collections.abc import Sequence
from functools import partial

from fuzzy.shell.terminal import application, run, versions_with

app = application(
    "Look at, check, draw, evaluate and identify Sugeno fuzzy systems in MATLAB's .fis files.",
    "fuzzy example tipper",
    "fuzzy show tipper.fis",
    program="fuzzy",
    commands={
        "look": "show rules plot surface explain check",
        "run": "evaluate",
        "make": "example",
        "learn": "identify search",
        "tune": "",
        "more": "doctor",
    },
    version=partial(versions_with, "numpy"),
)


def main(arguments: Sequence[str] | None = None) -> int:
    """Run the command line and return the exit code: 0 fine, 1 a check found something, 2 an error, 130 Ctrl-C."""
    return run(app, "fuzzy", arguments)
