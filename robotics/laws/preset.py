"""A law with some of its gains set, under a title: what the catalogue, other packages and files of laws are made of."""

from dataclasses import dataclass
from typing import Any

from robotics.laws.law import Law
from robotics.laws.setting import Kind


@dataclass(frozen=True)
class Preset:
    """A law with some of its gains set."""

    law: type[Law[Any]]
    gains: dict[str, Any]
    title: str
    note: str  # where the gains come from
    kind: Kind = "tracking"  # the kind of scenario that it drives
