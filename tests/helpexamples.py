"""The examples at the end of every command's --help, and command lines parsed without running them."""

import importlib
import re
import shlex
from functools import cache
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
        found += _below((program,), _program(program))
    return found


def parse(line: str) -> None:
    """Parse a command line; unknown commands raise KeyError, unknown options and values of a wrong kind UsageError."""
    program, *words = shlex.split(line)
    command = _program(program)
    while hasattr(command, "commands"):
        command = command.commands[words.pop(0)]
    command.make_context(line, words)


@cache
def _program(name: str) -> Any:
    return typer.main.get_command(importlib.import_module(f"{name}.commands.application").app)


def _below(words: tuple[str, ...], command: Any) -> list[Help]:
    below = [_below((*words, name), one) for name, one in getattr(command, "commands", {}).items()]
    return [Help(words, command, tuple(_COMMAND.findall(command.help))), *(each for some in below for each in some)]
