"""The parts of a report: pictures, tables, claims, chapters."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Literal, NamedTuple

from matplotlib.figure import Figure


class Picture(NamedTuple):
    """A figure of the report, which ``draw`` makes when its turn comes."""

    name: str  # of its file, without the suffix
    caption: str
    alt: str
    draw: Callable[[], Figure]


class Plate(NamedTuple):
    """A figure that is already drawn."""

    name: str
    caption: str
    alt: str
    png: bytes


class Film(NamedTuple):
    """A run to play in the report, whose HTML ``make`` gives when its turn comes."""

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
    """One claim, what was measured, and whether the claim holds here."""

    name: str
    source: str  # where the claim is made
    statement: str  # what the claim says, in a sentence
    measured: str  # what was run and what came out, with the numbers
    verdict: Verdict


@dataclass(frozen=True, eq=False)
class Chapter:
    """A part of the report after the comparison: text, tables, pictures, and the claims that it judges."""

    name: str  # of its anchor
    title: str
    text: tuple[str, ...]  # paragraphs
    tables: Sequence[Grid]
    details: Sequence[Grid]  # tables that are folded away
    pictures: Sequence[Picture | Plate]
    claims: Sequence[Claim]
    films: Sequence[Film] = ()
    folded: str = "More tables"  # what the folded-away tables are called
