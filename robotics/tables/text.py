"""The text of a TOML file, and the line that a fault is on."""

import re
import tomllib
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

from fuzzy.errors import InputError
from robotics.tables.lines import line_of


def read_text(path: Path, fault: type[InputError]) -> str:
    """The text of a file in UTF-8. Raises ``fault``, which names the file, where it cannot be read."""
    try:
        return path.read_text(encoding="utf-8")
    except UnicodeDecodeError:
        raise fault(f"{path}: cannot be read: it is not UTF-8 text") from None
    except (OSError, ValueError) as error:
        raise fault(f"{path}: cannot be read: {getattr(error, 'strerror', None) or error}") from None


def parse_table(text: str, file: str, fault: type[InputError]) -> dict[str, Any]:
    """The table that a TOML text describes. Raises ``fault``, which names file and line, for other text."""
    try:
        return tomllib.loads(text)
    except (ValueError, RecursionError) as error:  # TOMLDecodeError, or a number or a nesting that does not end
        line = re.search(r"at line (\d+)", str(error))
        end = f":{text.count(chr(10)) + 1}" if isinstance(error, tomllib.TOMLDecodeError) else ""
        where = f":{line[1]}" if line else end
        raise fault(f"{file}{where}: this is not TOML: {error}") from None


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
