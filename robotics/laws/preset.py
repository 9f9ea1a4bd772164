"""A law with some of its gains set, under a title: what the catalogue, other packages and files of laws are made of."""

from dataclasses import dataclass
from typing import Any

from robotics.laws.law import Law
from robotics.laws.setting import Kind


@dataclass(frozen=True)
class Preset:
    """A law with some of its gains set.

    Attributes:
        law: The class.
        gains: Those that differ from its defaults, by name.
        title: What tables and pictures call it.
        note: Where the gains come from.
        kind: The kind of scenario that it drives.
    """

    law: type[Law[Any]]
    gains: dict[str, Any]
    title: str
    note: str
    kind: Kind = "tracking"
