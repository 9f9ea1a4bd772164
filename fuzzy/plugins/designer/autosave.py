"""Unsaved work beside its file, FOLDER/.fuzzy-design/NAME.json, written whole or not at all: a crash loses nothing."""

import json
import math
import os
import re
import secrets
from dataclasses import dataclass, replace
from datetime import UTC, datetime
from pathlib import Path
from typing import Any

from fuzzy.errors import InputError
from fuzzy.files.atomic import write_whole
from fuzzy.files.fisfile import parse_bytes
from fuzzy.plugins.designer.design import Design, RuleLine, design_of, read, sentence, text_of, with_lines
from fuzzy.plugins.type2.files import system_of

FOLDER = ".fuzzy-design"
PROCESS = secrets.token_hex(8)  # tells this process from one before it that had the same number
_FORMAT = 1
MOST_UNSAVED = 20_000_000  # bytes of unsaved work: what a page shows takes less


@dataclass(frozen=True)
class Unsaved:
    """Work that was found unsaved."""

    path: Path  # the .json file
    design: Design
    when: datetime
    base: str | None  # the digest of the file that it goes on from; None for a file that was not there
    elsewhere: bool  # has a designer in another process, which is still running, this in hand?


def place_for(file: Path) -> Path:
    """The path of the unsaved work of ``file``."""
    return file.parent / FOLDER / f"{file.name}.json"


def write(file: Path, design: Design, base: str | None) -> Path:
    """Write a design as the unsaved work of a file, and return the path that was written. Raises OSError.

    Where a designer in another process has its own unsaved work, this one's stands beside it under another name.

    Args:
        file: The .fis file.
        design: The design.
        base: The digest of the file from which the design goes on; None where there was no file.
    """
    target = place_for(file)
    if _in_other_hands(target):
        target = target.with_name(f"{file.name}.{PROCESS}.json")
    target.parent.mkdir(exist_ok=True)
    if target.is_symlink():
        target.unlink()  # it would be followed, and might lead anywhere
    content = {
        "format": _FORMAT,
        "file": file.name,
        "when": datetime.now(UTC).isoformat(),
        "pid": os.getpid(),
        "process": PROCESS,
        "base": base,
        **design_content(design),
    }
    text = json.dumps(content, indent=1)
    write_whole(target, text)
    return target


def put_aside(work: Unsaved, file: Path) -> Unsaved:
    """Give ``work`` a name that no later unsaved work of ``file`` takes. Raises OSError."""
    if work.path != place_for(file):
        return work
    target = work.path.with_name(f"{file.name}.{secrets.token_hex(8)}.json")
    work.path.replace(target)
    return replace(work, path=target)


def design_content(design: Design) -> dict[str, Any]:
    """A design in JSON's types, rules that are switched off or misspelt included."""
    return {
        "system": text_of(design, replace(design.system, rules=())),
        "rules": [
            {
                "key": line.key,
                "rule": str(line.rule),
                "enabled": line.enabled,
                "text": line.text if line.problem else None,
                "source": line.source,
            }
            for line in design.lines
        ],
        "next_key": design.next_key,
        "point": list(design.point),
    }


def find(file: Path) -> list[Unsaved]:
    """The unsaved work of ``file`` that can be read, the newest first."""
    folder = place_for(file).parent
    names = re.compile(re.escape(file.name) + r"(\.[0-9a-f]{16})?\.json")
    try:
        paths = [path for path in folder.iterdir() if names.fullmatch(path.name) and not path.is_symlink()]
    except OSError:
        return []
    works = [work for path in paths if (work := _read(path, file)) is not None]
    return sorted(works, key=lambda work: work.when, reverse=True)


# What reading a damaged file may raise
DAMAGED = (OSError, InputError, ValueError, KeyError, TypeError, AttributeError, ArithmeticError, RecursionError)


def _read(path: Path, file: Path) -> Unsaved | None:
    """The unsaved work in ``path``, or None where it is none of ``file``'s."""
    try:
        if path.stat().st_size > MOST_UNSAVED:
            return None
        content = json.loads(path.read_text(encoding="utf-8"))
        if content["format"] != _FORMAT or content["file"] != file.name:
            return None
        when = datetime.fromisoformat(content["when"]).astimezone()
        base = None if content["base"] is None else str(content["base"])
        return Unsaved(path, design_from(content), when, base, _elsewhere(content))
    except DAMAGED:
        return None  # of another version, or damaged: the file itself is still there


def _in_other_hands(path: Path) -> bool:
    """Does ``path`` hold the unsaved work of a designer in another process?"""
    try:
        return not path.is_symlink() and _elsewhere(json.loads(path.read_text(encoding="utf-8")))
    except DAMAGED:
        return False


def _elsewhere(content: dict[str, Any]) -> bool:
    return content["process"] != PROCESS and _runs(int(content["pid"]))


def design_from(content: dict[str, Any]) -> Design:
    """The design that :func:`design_content` gave. Raises one of :data:`DAMAGED` where it is damaged."""
    empty = design_of(system_of(parse_bytes(content["system"].encode(), "<text>", type2=True), "<text>"))
    system = empty.system
    lines = []
    for entry in content["rules"]:
        rule = sentence(system, entry["rule"])
        line = RuleLine(int(entry["key"]), rule, str(rule), bool(entry["enabled"]), None, entry.get("source"))
        lines.append(read(system, line, entry["text"]) if entry["text"] is not None else line)
    point = tuple(float(value) for value in content["point"])
    whole = len({line.key for line in lines}) == len(lines) and all(map(math.isfinite, point))
    if not whole or len(point) != len(system.inputs):
        raise ValueError("the point or the keys do not fit")
    return with_lines(replace(empty, point=point, next_key=int(content["next_key"])), lines)


def _runs(pid: int) -> bool:
    """Is another process of this number running?"""
    if os.name != "posix" or pid <= 0 or pid == os.getpid():  # elsewhere than on POSIX, asking would end it
        return False
    try:
        os.kill(pid, 0)
    except (ProcessLookupError, OverflowError):
        return False
    except PermissionError:  # it is another user's
        return True
    return True
