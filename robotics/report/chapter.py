"""What a report is made of: pictures, tables, chapters."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Literal, NamedTuple

from matplotlib.figure import Figure


class Picture(NamedTuple):
    """A figure of the report; ``draw`` makes it when its turn comes."""

    name: str  # of its file, without the suffix
    caption: str
    alt: str
    draw: Callable[[], Figure]


class Plate(NamedTuple):
    """A figure that is drawn."""

    name: str
    caption: str
    alt: str
    png: bytes


class Film(NamedTuple):
    """A run to play in the report; ``make`` gives its HTML when its turn comes."""

    caption: str
    make: Callable[[], str]


class Grid(NamedTuple):
    """A table of a chapter, as text."""

    caption: str
    head: tuple[str, ...]
    rows: Sequence[tuple[str, ...]]


Verdict = Literal["holds", "holds in part", "does not hold"]


@dataclass(frozen=True)
class Claim:
    """One claim, what was measured, and whether it holds here."""

    name: str
    source: str  # where it is made
    statement: str  # what it says, in a sentence
    measured: str  # what was run and what came out, with the numbers
    verdict: Verdict


@dataclass(frozen=True, eq=False)
class Chapter:
    """A part of the report beside the comparison: its text, tables and pictures, and the claims it judges."""

    name: str  # of its anchor
    title: str
    text: tuple[str, ...]  # paragraphs
    tables: Sequence[Grid]
    details: Sequence[Grid]  # tables that are folded away
    pictures: Sequence[Picture | Plate]
    claims: Sequence[Claim]
    films: Sequence[Film] = ()
    folded: str = "More tables"  # what the folded-away tables are called
