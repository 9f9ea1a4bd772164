"""The snippets of a page, run as a reader would run them, but in this process where that is the same and quicker."""

import importlib
import re
import shlex
import subprocess
from pathlib import Path

PROGRAMS = ("fuzzy", "anfis", "robotics")
_SHELL = re.compile(r"\|\||&&|[|<>;$*]")  # what only a shell understands


def snippets(page: Path) -> list[tuple[str, str]]:
    """The kind and the text of each fenced block of a Markdown page, in its order."""
    return [(m[1], m[2]) for m in re.finditer(r"```(\w+)\n(.*?)```", page.read_text(encoding="utf-8"), re.DOTALL)]


def run_commands(text: str) -> None:
    """Run the lines of a block of shell commands in the current folder; each must succeed."""
    for line in text.replace("\\\n", " ").splitlines():
        words = shlex.split(line, comments=True)
        if not words:
            continue
        if words[0] in PROGRAMS and not _SHELL.search(line.partition("#")[0]):
            main = importlib.import_module(f"{words[0]}.commands.application").main
            assert main(words[1:]) == 0, line
        else:
            assert subprocess.run(["sh", "-e", "-c", line], check=False, timeout=240).returncode == 0, line


def run_python(text: str, name: str) -> None:
    """Run a block of Python as a program of its own."""
    exec(compile(text, name, "exec"), {"__name__": "__main__"})
