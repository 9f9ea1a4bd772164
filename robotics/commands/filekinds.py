"""The kinds of files that one writes oneself: of TOML files the keys, the reader, and values to begin with.

A kind of TOML file that is registered here has its explanation, its JSON schema and its commented file. A law, a metric
and a rule base are no TOML: each has a template to begin with and to be changed.
"""

import json
import tomllib
from collections.abc import Mapping
from dataclasses import dataclass
from importlib import resources
from pathlib import Path
from pkgutil import resolve_name
from typing import Any

from fuzzy.errors import InputError
from fuzzy.files.atomic import write_whole
from fuzzy.naming import check_known
from robotics.tables.keys import KeyTable


@dataclass(frozen=True)
class FileKind:
    """One kind of file. Its keys and its reader are functions, "module:function", imported when they are called."""

    title: str
    keys: str  # describes the file's outermost table
    reader: str  # of a file's text, and of what messages call it
    use: str  # the command that uses a file, with FILE for its name
    templates: Mapping[str, str]  # in robotics/data/templates/, without .toml, by --kind; the first is the default

    def table(self) -> KeyTable:
        """The description of the file's outermost table."""
        found: KeyTable = resolve_name(self.keys)()
        return found

    def read(self, text: str) -> Any:
        """What a file's text describes. Raises an InputError for one that cannot be read."""
        return resolve_name(self.reader)(text, "new")

    @property
    def values(self) -> dict[str, dict[str, Any]]:
        """What files begin with, as they have it, by --kind."""
        return {kind: tomllib.loads(_packaged(f"{file}.toml")) for kind, file in self.templates.items()}


_ABOUT = json.loads(Path(__file__).with_suffix(".json").read_text(encoding="utf-8"))
FILE_KINDS = {name: FileKind(**about) for name, about in _ABOUT.items()}


def file_kind(name: str) -> FileKind:
    """The kind of file of that name. Raises InputError for another."""
    check_known(name, FILE_KINDS, "kind of file")
    return FILE_KINDS[name]


# By kind: the packaged file, the name by which its own comments call it, and the command that uses it
TEMPLATES: dict[str, tuple[str, str, str]] = {
    "law": ("law.py", "mylaw.py", "robotics run lyapunov-sine --law FILE:MyLaw"),
    "metric": ("metric.py", "mymetric.py", "robotics run lyapunov-sine --metric FILE:comfort"),
    "rule-base": ("rule-base.fis", "mine.fis", "robotics run lyapunov-sine -c FILE"),
}


def template_text(kind: str, file: str = "") -> str:
    """The commented template of a kind, whose comments call it ``file``. Raises InputError for an unknown kind."""
    check_known(kind, TEMPLATES, "kind of file")
    packaged, name, _ = TEMPLATES[kind]
    return _packaged(packaged).replace(name, file or name)


def write_template(kind: str, path: Path) -> str:
    """Write the template of a kind to a file, whole or not at all; return the command that uses it.

    Raises InputError for an unknown kind or a wrong ending, and OSError.
    """
    text, suffix = template_text(kind, str(path)), Path(TEMPLATES[kind][0]).suffix
    if path.suffix != suffix:
        raise InputError(f"{path}: the name of a {kind} file must end in {suffix}")
    write_whole(path, text)
    return TEMPLATES[kind][2].replace("FILE", str(path))


def _packaged(name: str) -> str:
    return (resources.files("robotics") / "data" / "templates" / name).read_text(encoding="utf-8")
