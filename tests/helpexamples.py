"""The examples at the end of every command's --help."""

import importlib
import re
from typing import Any, NamedTuple

import typer

from tests.snippets import PROGRAMS

_COMMAND = re.compile(rf"^\s+((?:{'|'.join(PROGRAMS)}) .*)$", re.MULTILINE)


class Help(NamedTuple):
    """A command line's help: its words, such as ``robotics stress crossing``, its command, and its examples."""

    words: tuple[str, ...]
    command: Any
    examples: tuple[str, ...]


def helps() -> list[Help]:
    """The help of the three programs, of their groups and of every command."""
    found: list[Help] = []
    for program in PROGRAMS:
        app = importlib.import_module(f"{program}.commands.application").app
        found += _below((program,), typer.main.get_command(app))
    return found


def _below(words: tuple[str, ...], command: Any) -> list[Help]:
    below = [_below((*words, name), one) for name, one in getattr(command, "commands", {}).items()]
    return [Help(words, command, tuple(_COMMAND.findall(command.help))), *(each for some in below for each in some)]
