"""The snippets of a page, run as a reader would run them, but in this process where that is the same and quicker."""

import importlib
import os
import re
import shlex
import subprocess
import sys
import warnings
from pathlib import Path

PROGRAMS = ("fuzzy", "anfis", "robotics")
_CELL = re.compile(r"^```\{code-cell\} python\n(?:---\n.*?\n---\n|(?:^:[^\n]*\n)*)(.*?)^```$", re.MULTILINE | re.DOTALL)
_SHELL = re.compile(r"[|&<>;()]+|.*[$*].*")  # words that only a shell understands


def snippets(page: Path, *, changed: bool | None = None) -> list[tuple[str, str]]:
    """The kind and the text of each fenced block of a Markdown page, in its order.

    Args:
        page: The page.
        changed: True for those below its heading "Now change it" alone, False for all but them, None for all.
    """
    text = page.read_text(encoding="utf-8")
    if changed is not None:
        section = re.search(r"^## Now change it\n.*?(?=^## |\Z)", text, re.MULTILINE | re.DOTALL)
        found = section[0] if section else ""
        text = found if changed else text.replace(found, "")
    return [(m[1], m[2]) for m in re.finditer(r"```(\w+)\n(.*?)```", text, re.DOTALL)]


def cells(page: Path) -> list[str]:
    """The Python cells of a page that is a notebook, in its order."""
    return [match[1] for match in _CELL.finditer(page.read_text(encoding="utf-8"))]


def run_commands(text: str) -> None:
    """Run the lines of a block of shell commands in the current folder; each must succeed, and may warn."""
    # The console scripts of this very environment, whether it is activated or not
    path = os.pathsep.join([str(Path(sys.executable).parent), os.environ["PATH"]])
    for line in text.replace("\\\n", " ").splitlines():
        words = shlex.split(line, comments=True)
        if not words:
            continue
        parts = shlex.shlex(line, punctuation_chars=True)  # which leaves quotes about what is quoted
        if words[0] in PROGRAMS and not any(_SHELL.fullmatch(part) for part in parts):
            main = importlib.import_module(f"{words[0]}.commands.application").main
            with warnings.catch_warnings():
                warnings.simplefilter("default")
                assert main(words[1:]) == 0, line
        else:
            shell = ["sh", "-e", "-c", line]
            done = subprocess.run(shell, env={**os.environ, "PATH": path}, check=False, timeout=240)
            assert done.returncode == 0, line


def run_python(text: str, name: str) -> None:
    """Run a block of Python as a program of its own."""
    with warnings.catch_warnings():
        warnings.simplefilter("default")
        exec(compile(text, name, "exec"), {"__name__": "__main__"})
