"""Commented TOML files to begin with: what is needed is set, and all that is optional stands there as a comment.

A line ``#key = value`` is made to hold by removing its ``#``; all such lines at once make a file that loads, too. A
line ``#or key = value`` stands instead of another. Lines that begin with ``##`` are remarks. Which lines go together
is not told but tried: the file's own reader says whether it loads.
"""

import json
import re
import textwrap
from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from typing import Any

from fuzzy.errors import InputError
from robotics.tables.keys import Key, KeyTable

_WIDTH = 120  # characters in a line
HEAD = """\
## Lines with ## are remarks. Remove the # of a line #key = value to set it; the value is the default, or an example.
## A line with #or stands instead of another. Units are SI, angles in radians.
"""


@dataclass(frozen=True)
class _Line:
    text: str  # without a mark
    mark: str  # "": it holds, "#": it may be uncommented, "#or ": instead of others, "## ": a remark
    block: int  # lines of one table have one number
    needed: bool = False  # whether its table cannot do without it


def commented_file(
    table: KeyTable, values: Mapping[str, Any], reads: Callable[[str], Any], head: str = "", minimal: bool = False
) -> str:
    """Write a file.

    Args:
        table: The description of the file's outermost table.
        values: What is set, as the file has it.
        reads: Reads the text of a file; an InputError says that it cannot be read.
        head: Remarks at its beginning.
        minimal: Whether only what is set is written, without comments.
    """
    writer = _Writer(remarks=not minimal)
    writer.table(table, values, "")
    lines = [line for line in writer.lines if not (minimal and line.mark)]
    if not minimal:
        lines = _tried(lines, reads)
        head = "".join(f"## {row}\n" for row in head.splitlines()) + HEAD
    body = "\n".join(line.mark + line.text for line in lines)
    text = re.sub(r"\n{3,}", "\n\n", f"{head if not minimal else ''}{body}\n").lstrip("\n")
    reads(text)
    return text


def toml_value(value: Any) -> str:
    """A value as TOML writes it."""
    if isinstance(value, bool):
        return "true" if value else "false"
    if isinstance(value, str):
        return json.dumps(value, ensure_ascii=False)
    if isinstance(value, Mapping):
        return "{ " + ", ".join(f"{name} = {toml_value(v)}" for name, v in value.items()) + " }"
    if isinstance(value, (list, tuple)):
        return "[" + ", ".join(map(toml_value, value)) + "]"
    return repr(value)


def example_line(key: Key) -> str:
    """A line of a file that sets ``key``, which is no table."""
    return f"{key.name} = {toml_value(key.shown)}"


class _Writer:
    """Collects the lines of a file, table by table."""

    def __init__(self, remarks: bool) -> None:
        self.remarks = remarks
        self.lines: list[_Line] = []
        self.block = 0
        self.set: set[str] = set()  # the names of tables that stand there in full, set
        self.optional: set[str] = set()  # and as comments

    def add(self, text: str, mark: str = "", needed: bool = False) -> None:
        self.lines.append(_Line(text, mark, self.block, needed))

    def remark(self, text: str) -> None:
        for line in textwrap.wrap(text, _WIDTH - 4, break_on_hyphens=False, break_long_words=False):
            self.add(line, "## ")

    def table(self, table: KeyTable, values: Mapping[str, Any] | None, path: str) -> None:
        """Write the keys of a table, and the tables in it; without ``values`` all as comments."""
        given = values or {}
        full = table.name not in (self.set if values is not None else self.set | self.optional)
        (self.set if values is not None else self.optional).add(table.name)
        shape = str(given.get(table.by, next(iter(table.shapes), ""))) if table.shapes else ""
        keys = [*table.keys, *table.shapes.get(shape, ())]
        instead = _alternatives(table, given)
        for key in keys:
            if key.inline and (key.name in given or full):
                value = shape if key.name == table.by else given.get(key.name)
                mark = "#or " if key.name in instead else "" if key.name in given else "#"
                self.key(key, value, mark, remark=full)
        if full:
            self.other_shapes(table, shape)
        for key in keys:
            if not key.inline and (key.name in given or full) and key.name not in instead:
                self.inner(key, given.get(key.name), f"{path}{key.name}")
        for name, value in given.items() if table.any_key is not None else ():
            self.add(f"{json.dumps(name) if '.' in name else name} = {toml_value(value)}")
        if table.any_key is not None and table.any_key.example is not None and full and not given:
            self.add(f"other = {toml_value(table.any_key.example)}  # {table.any_key.doc}", "#")
        elif table.any_key is not None and full and not given:
            self.add(f"latency = [0.0, 0.1]  # {table.any_key.doc}" if "field" in path else "ky = [5.0, 10.0]", "#")

    def key(self, key: Key, value: Any, mark: str, remark: bool) -> None:
        """Write one key, with its unit, range and sentence where that is asked for."""
        text = f"{key.name} = {toml_value(key.shown if value is None else value)}"
        words = _remark(key) if remark and self.remarks else ""
        room = max(len(mark + text), 32)
        if room + len(words) + 4 + 3 * (mark == "#") > _WIDTH:
            self.remark(words)
            words = ""
        filled = text.ljust(room - len(mark)) + f"  # {words}" if words else text
        self.add(filled, mark, key.required)

    def other_shapes(self, table: KeyTable, shape: str) -> None:
        """Write in a remark for each other shape what it is and an example of its keys."""
        for name, keys in table.shapes.items():
            if name != shape:
                needed = [k for k in keys if k.required] or list(keys[:2])
                rest = ", ".join(k.name for k in keys if k not in needed)
                pairs = ", ".join([f'{table.by} = "{name}"', *(example_line(k) for k in needed if k.table is None)])
                self.remark(f"or {pairs}" + (f"; also {rest}" if rest else ""))

    def inner(self, key: Key, value: Any, path: str) -> None:
        """Write the table, or the tables, under one key."""
        assert key.table is not None
        left, right = ("[[", "]]") if key.holds == "tables" else ("[", "]")
        rows = [None] if value is None else list(value) if key.holds == "tables" else [value]
        for row in rows:
            self.block += 1
            self.add("", "")
            if row is None and key.table.name in self.set | self.optional:
                self.add(f"{left}{path}{right} takes the same keys as above. {key.doc}", "## ")
                continue
            if row is None or key.table.name not in self.set:
                self.remark(key.doc)
            self.add(f"{left}{path}{right}", "#" if row is None else "")
            self.table(key.table, row, f"{path}.")


def _remark(key: Key) -> str:
    """The unit, the range and the sentence of a key."""
    words = key.accepted.removeprefix("a finite number").removeprefix(" in ").lstrip(", ")
    words = "" if key.holds == "text" else words
    return (f"[{words}] " if words else "") + key.doc + (f" Left out: {key.rule}." if key.rule else "")


def _alternatives(table: KeyTable, given: Mapping[str, Any]) -> set[str]:
    """The keys of a table that stand instead of those that are given, or else instead of the first of their group."""
    found: set[str] = set()
    for group in table.one_of:
        taken = [name for name in group if name in given] or group[:1]
        found |= set(group) - set(taken)
    return found


def _tried(lines: list[_Line], reads: Callable[[str], Any]) -> list[_Line]:
    """``lines`` with those marked as alternatives that do not go together with the others."""

    def loads(chosen: set[int]) -> bool:
        text = "\n".join(line.text for k, line in enumerate(lines) if line.mark == "" or k in chosen)
        try:
            reads(text)
        except InputError:
            return False
        return True

    optional = [k for k, line in enumerate(lines) if line.mark == "#"]
    chosen: set[int] = set()
    for block in dict.fromkeys(lines[k].block for k in optional):
        here = [k for k in optional if lines[k].block == block]
        if loads(chosen | set(here)):
            chosen |= set(here)
            continue
        kept = {k for k in here if lines[k].needed or lines[k].text.startswith("[")}
        if not loads(chosen | kept):
            continue
        for k in here:
            if loads(chosen | kept | {k}):
                kept.add(k)
        chosen |= kept
    alternatives = set(optional) - chosen
    return [replace(line, mark="#or ") if k in alternatives else line for k, line in enumerate(lines)]
