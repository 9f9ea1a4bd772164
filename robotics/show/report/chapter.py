"""The parts of a report: pictures, tables, claims, chapters."""

from collections import Counter
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from itertools import chain
from typing import Any, NamedTuple

from matplotlib.figure import Figure

from fuzzy.words import counted
from robotics.measures.evidence import FORMS, Estimate, Form, Part, Verdict, adjusted, judge
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
    width: int  # pixels of the page
    height: int
    narrow: "Plate | None" = None  # the same for a phone


class Film(NamedTuple):
    """A run to play in the report, whose HTML ``make`` gives when its turn comes."""

    caption: str
    make: Callable[[], str]
    beside: str = ""  # the picture under which it stands; "": at the end of its chapter


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
        """The verdict on the first of FORMS that is judged, as printed if it is; each form has one of its own."""
        return next(iter(self.forms.values()))

    @property
    def forms(self) -> dict[Form, Verdict]:
        """The verdict on each form that is judged, by its name."""
        found = {form: self.of(form) for form in ("", *FORMS)}
        return {form: judge(parts) for form, parts in found.items() if parts}

    def of(self, form: Form) -> tuple[Part, ...]:
        """The parts of one form."""
        return tuple(part for part in self.parts if part.form == form)

    def counts(self, form: Form) -> str:
        """What became of the parts of a form, and in how many runs what was asked was so: of its parts the fewest."""
        parts = self.of(form)
        found = Counter(part.outcome for part in parts)
        told = f"{found['holds']} of {counted(len(parts), 'part')}" if len(found) > 1 else ""
        open_ = f"{found['open']} open" if len(found) > 1 and found["open"] else ""
        least = min(parts, key=lambda part: part.kept / part.estimate.runs)
        runs = f"{least.kept} of {least.estimate.runs} runs" if least.estimate.runs > 1 else ""
        return ", ".join(filter(None, (told, open_, runs)))

    @property
    def measured(self) -> str:
        """What was measured of each part, and what follows: made of the numbers alone."""
        said = {form: f"{'; '.join(map(sentence, self.of(form)))}." for form in self.forms}
        return " ".join(f"{form.capitalize()}: {words}" if form else words for form, words in said.items())

    def row(self) -> dict[str, str]:
        """Its row of claims.csv; a column for each form, where the claim is judged by forms."""
        columns = [form for form in FORMS if "" not in self.forms]
        verdicts: dict[str, str] = {form.replace(" ", "_"): str(self.forms.get(form, "")) for form in columns}
        verdicts |= {f"{form} runs".replace(" ", "_"): self.counts(form) if self.of(form) else "" for form in columns}
        about = {"name": self.name, "source": self.source, "says": self.says}
        verdicts |= {} if columns else {"verdict": str(self.verdict), "verdict_runs": self.counts("")}
        return about | verdicts | {"measured": self.measured, "untested": self.untested}

    def evidence(self) -> list[dict[str, str | float | int]]:
        """Its rows of evidence.csv, one a part."""
        return [self._row(part) for part in self.parts]

    def _row(self, part: Part) -> dict[str, str | float | int]:
        row = {"claim": self.name} | _fields(part, "form", "says", "quantity", "on")
        row |= {"robot": part.robots, "of": part.of, "against": "; ".join(part.against)}
        row |= _fields(part.estimate, "kind", "value", "low", "high", "runs", "lost")
        row |= _fields(part, "unit", "sense", "bound", "kept", "origin", "outcome")
        row["adjusted"] = "" if part.adjusted is None else part.adjusted
        sense, limit = part.limit or ("", "")
        number = part.sides[0] if part.limit else None
        row |= {"limit": limit, "limit_sense": sense, "number": number.value if number else ""}
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


def judged_together(claims: Sequence[Claim], chapters: Sequence[Chapter]) -> tuple[list[Claim], list[Chapter]]:
    """The same claims, and chapters with theirs, as one family: see :func:`robotics.measures.evidence.adjusted`."""
    family = chain(claims, *(chapter.claims for chapter in chapters))
    parts = iter(adjusted([part for claim in family for part in claim.parts]))

    def again(several: Sequence[Claim]) -> list[Claim]:
        return [replace(claim, parts=tuple(next(parts) for _ in claim.parts)) for claim in several]

    return again(claims), [replace(chapter, claims=again(chapter.claims)) for chapter in chapters]
