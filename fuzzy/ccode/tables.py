"""Constant tables in C."""

from collections.abc import Sequence
from textwrap import fill


def whole(count: int) -> str:
    """The smallest type that numbers the things of which there are ``count``."""
    return "unsigned char" if count < 256 else "unsigned short" if count < 65536 else "int"


def table(kind: str, name: str, values: Sequence[object]) -> str:
    """A constant table of the type ``kind``."""
    rows = fill(
        ", ".join(map(str, values)), 116, initial_indent="    ", subsequent_indent="    ", break_on_hyphens=False
    )
    return f"static const {kind} {name}[{len(values)}] = {{\n{rows}\n}};"
