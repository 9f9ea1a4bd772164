"""The text of a TOML file, and the line that a fault is on."""

import re
import tomllib
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

from fuzzy.errors import InputError
from fuzzy.naming import file_beside
from fuzzy.quantity import UNPRINTABLE, unprintable


def read_text(path: Path, fault: type[InputError]) -> str:
    """The text of a file in UTF-8. Raises ``fault``, which names the file, where it cannot be read."""
    try:
        return path.read_text(encoding="utf-8")
    except UnicodeDecodeError:
        raise fault(f"{path}: cannot be read: it is not UTF-8 text") from None
    except (OSError, ValueError) as error:
        reason = f"{getattr(error, 'strerror', None) or error}{file_beside(path)}"
        raise fault(f"{path}: cannot be read: {reason}") from None


def parse_table(text: str, file: str, fault: type[InputError]) -> dict[str, Any]:
    """The table that a TOML text describes. Raises ``fault``, which names file and line, for other text."""
    try:
        table = tomllib.loads(text)
    except (ValueError, RecursionError) as error:  # TOMLDecodeError, or a number or a nesting that does not end
        line = re.search(r"at line (\d+)", str(error))
        end = f":{text.count(chr(10)) + 1}" if isinstance(error, tomllib.TOMLDecodeError) else ""
        where = f":{line[1]}" if line else end
        raise fault(f"{file}{where}: this is not TOML: {error}") from None
    for keys in unprintable(table):
        raise fault(f"{file}:{line_of(text, keys)}: {UNPRINTABLE}")
    return table


@contextmanager
def reading(text: str, file: str, fault: type[InputError]) -> Iterator[dict[str, Any]]:
    """Give the block the table of a TOML text; its InputErrors become ``fault``, with file and line.

    Args:
        text: The TOML text.
        file: The name of the file in messages.
        fault: The error to raise.
    """
    table = parse_table(text, file, fault)
    try:
        yield table
    except InputError as error:
        raise fault(f"{file}:{line_of(text, error.at)}: {error}") from None


# The line of a key -----------------------------------------------------------------------------------------------

_HEADER = re.compile(r"^\s*(\[\[?)\s*([^\]]+?)\s*\]\]?\s*(#.*)?$")
_KEY = re.compile(r"""^\s*((?:[\w\-.\s]|"[^"]*"|'[^']*')+?)\s*=""")


def line_of(text: str, keys: tuple[str | int, ...]) -> int:
    """The line (from 1) where ``keys`` stand in TOML ``text``: the deepest of them that has a line of its own."""
    wanted = _names(".".join(map(str, keys)))
    best, best_depth = 1, 0
    prefix: list[str] = []
    counts: dict[tuple[str, ...], int] = {}  # of tables [[...]], by their names
    for number, line in enumerate(text.splitlines(), start=1):
        header, key = _HEADER.match(line), _KEY.match(line)
        if header:
            names = _names(header[2])
            prefix = []
            for n, name in enumerate(names, start=1):
                prefix.append(name)
                if n == len(names) and header[1] == "[[":
                    counts[tuple(prefix)] = counts.get(tuple(prefix), -1) + 1
                if tuple(prefix) in counts:
                    prefix.append(str(counts[tuple(prefix)]))
            here = prefix
        elif key:
            here = prefix + _names(key[1])
        else:
            continue
        depth = 0
        while depth < min(len(here), len(wanted)) and here[depth] == wanted[depth]:
            depth += 1
        if depth in (len(here), len(wanted)) and depth > best_depth:
            best, best_depth = number, depth
    return best


def _names(dotted: str) -> list[str]:
    """The parts of a dotted key; one in quotes, which may have dots itself, is taken apart likewise."""
    return [name.strip().strip("\"'") for name in dotted.split(".")] if dotted else []
