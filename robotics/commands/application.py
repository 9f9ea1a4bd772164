"""The command line ``robotics``; every command has a module of its own beside this one.

Data goes to stdout, progress and messages to stderr. What a command needs is imported when it runs, so that
``--help`` is quick.
"""

from collections.abc import Sequence

from fuzzy.shell.terminal import application, run
from robotics.studies.versions import versions

app = application(
    "Simulate robots and compare their controllers, fuzzy and nonlinear, on the same terms.",
    "robotics list scenarios",
    "robotics run lyapunov-sine --plot sine.png",
    program="robotics",
    commands={
        "look": "list scenario check plot explain",
        "run": "new run",
        "compare": "compare sweep study",
        "tune": "",
        "learn": "",
        "deploy": "",
        "more": "copy team",
    },
    version=lambda: " ".join(f"{name} {version}" for name, version in versions().items()),
)


def main(arguments: Sequence[str] | None = None) -> int:
    """Run the command line and return the exit code: 0 fine, 2 an error or a diverged controller, 130 Ctrl-C."""
    return run(app, "robotics", arguments)
