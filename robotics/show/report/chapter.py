"""The parts of a report: pictures, tables, claims, chapters."""

from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any, NamedTuple

from matplotlib.figure import Figure

from robotics.measures.evidence import AT_BEST, FORMS, Estimate, Form, Part, Verdict, judge
from robotics.measures.leading import Lead
from robotics.show.report.wording import sentence


class Picture(NamedTuple):
    """A figure of the report, which ``draw`` makes when its turn comes."""

    name: str  # of its file, without the suffix
    caption: str
    alt: str
    draw: Callable[[], Figure]
    narrow: Callable[[], Figure] | None = None  # the same for a phone, where the width is not enough


class Plate(NamedTuple):
    """A figure that is already drawn."""

    name: str
    caption: str
    alt: str
    png: bytes
    webp: bytes  # the same picture, for the page
    width: int  # pixels
    height: int
    narrow: "Plate | None" = None  # the same for a phone


class Film(NamedTuple):
    """A run to play in the report, whose HTML ``make`` gives when its turn comes."""

    caption: str
    make: Callable[[], str]


class Front(NamedTuple):
    """What opens a report: one picture, and what it says in a few sentences."""

    title: str
    picture: Picture
    sentences: Sequence[str]
    note: str  # on what terms, and where there is more


class Grid(NamedTuple):
    """A table of a chapter, as text."""

    caption: str
    head: tuple[str, ...]
    rows: Sequence[tuple[str, ...]]

    @classmethod
    def of(cls, caption: str, about: Iterable[Any], columns: Mapping[str, Callable[[Any], str]]) -> "Grid":
        """A table with a row for each thing that it is ``about``; a column, by its title, says a cell of each."""
        rows = [tuple(cell(each) for cell in columns.values()) for each in about]
        return cls(caption, tuple(columns), rows)


@dataclass(frozen=True, kw_only=True)
class Claim:
    """One claim, and the parts that decide it."""

    name: str
    source: str  # where the claim is made
    says: str  # what is claimed, in a sentence
    untested: str  # what of it is not tested here, in a sentence
    parts: tuple[Part, ...]

    @property
    def verdict(self) -> Verdict:
        """The verdict on all forms but "tuned" together, by :func:`robotics.measures.evidence.judge`."""
        return judge([part for part in self.parts if part.form != AT_BEST])

    @property
    def forms(self) -> dict[Form, Verdict]:
        """The verdict on each form that is judged, by its name."""
        found = {form: self.of(form) for form in ("", *FORMS)}
        return {form: judge(parts) for form, parts in found.items() if parts}

    def of(self, form: Form) -> tuple[Part, ...]:
        """The parts of one form."""
        return tuple(part for part in self.parts if part.form == form)

    @property
    def measured(self) -> str:
        """What was measured of each part, and what follows: made of the numbers alone."""
        said = {form: f"{'; '.join(map(sentence, self.of(form)))}." for form in self.forms}
        return " ".join(f"{form.capitalize()}: {words}" if form else words for form, words in said.items())

    def row(self) -> dict[str, str]:
        """Its row of claims.csv; a column for each form, where the claim is judged by forms."""
        verdicts = {form.replace(" ", "_"): str(self.forms.get(form, "")) for form in FORMS if "" not in self.forms}
        about = {"name": self.name, "source": self.source, "says": self.says, "verdict": str(self.verdict)}
        return about | verdicts | {"measured": self.measured, "untested": self.untested}

    def evidence(self) -> list[dict[str, str | float | int]]:
        """Its rows of evidence.csv, one a part."""
        return [self._row(part) for part in self.parts]

    def _row(self, part: Part) -> dict[str, str | float | int]:
        row = {"claim": self.name} | _fields(part, "form", "says", "quantity", "on")
        row |= {"robot": part.robots, "of": part.of, "against": "; ".join(part.against)}
        row |= _fields(part.estimate, "kind", "value", "low", "high", "runs")
        row |= _fields(part, "unit", "sense", "bound", "outcome")
        if not part.form:
            row |= _fields(part, "scale", "fewest", "note")
        return row


def _fields(of: Part | Estimate, *names: str) -> dict[str, Any]:
    return {name: getattr(of, name) for name in names}


@dataclass(frozen=True, eq=False)
class Chapter:
    """A part of the report after the comparison: text, tables, pictures, and the claims that it judges."""

    name: str  # of its anchor
    title: str
    text: tuple[str, ...] = ()  # paragraphs
    tables: Sequence[Grid] = ()
    details: Sequence[Grid] = ()  # tables that are folded away
    pictures: Sequence[Picture | Plate] = ()
    claims: Sequence[Claim] = ()
    films: Sequence[Film] = ()
    leads: Sequence[Lead] = ()  # who leads where, for the picture at the head of the report
    folded: str = "More tables"  # what the folded-away tables are called
    closed: bool = False  # whether it is folded under its title, on a page that can
