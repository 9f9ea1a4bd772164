"""The thesis's claims, which stand in ``claims.toml``: the runs that they need, and the claims judged by them.

The file's tables are those of :mod:`robotics.show.report.claims`, with a chapter for each claim, and in each part the
laws in the forms ``printed``, ``corrected``, ``ideal`` and ``tuned`` in place of ``of`` and ``against``.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import cache
from importlib import resources
from typing import NamedTuple

import numpy as np

from fuzzy.quantity import described
from robotics.measures.evidence import Form, Part
from robotics.measures.quantities import MEASURED_QUANTITIES
from robotics.show.report.chapter import Claim
from robotics.show.report.claims import ClaimError, Condition, Measure, Statement, decided, run_name, statements
from robotics.tables.text import reading

# Their keys in the file
_FORMS: dict[str, Form] = {"printed": "as printed", "corrected": "corrected", "ideal": "ideal", "tuned": "tuned"}


class Needed(NamedTuple):
    """A law on a scenario or an experiment, with or without noise."""

    on: str
    of: str
    ideal: bool


@dataclass(frozen=True, kw_only=True)
class _Condition(Condition):
    """A part of a claim: the laws that it compares stand in it by their form, the one that is judged first."""

    printed: tuple[str, ...] = described("The law as the thesis prints it, and those to which it is compared.", ())
    corrected: tuple[str, ...] = described("Likewise without what is wrong in its text, both sides alike.", ())
    ideal: tuple[str, ...] = described("Likewise without noise, in one run: where the claim is about an ideal.", ())
    tuned: tuple[str, ...] = described("Likewise at their best: as equal tuning of all laws found them.", ())
    unit: str = described("The unit of what a chapter measures itself.", "1")

    @property
    def laws(self) -> dict[Form, tuple[str, ...]]:
        """The laws of each form that is judged."""
        found = {form: getattr(self, key) for key, form in _FORMS.items()}
        return {form: laws for form, laws in found.items() if laws}


@dataclass(frozen=True, kw_only=True)
class _Statement(Statement):
    """A claim of the thesis before anything is measured."""

    chapter: str = described("The chapter of the report that judges it.")
    parts: tuple[_Condition, ...] = described("Its parts.", ())


# Gives the numbers of a law's seeds (runs,) by quantity and whose number counts; bool where something happens or not
Measured = Callable[[Needed, str, str], np.ndarray]


def needed(chapter: str) -> list[Needed]:
    """What the claims of a chapter are judged by, each once, in the order of the file."""
    asked = [c for statement in _statements() if statement.chapter == chapter for c in statement.parts]
    laws = [(c.on, law, form == "ideal") for c in asked for form in c.laws for law in c.laws[form]]
    return list(dict.fromkeys(Needed(on, law, ideal) for several, law, ideal in laws for on in several))


def run_file(need: Needed) -> str:
    """The name of the file of a law's runs on a scenario."""
    return f"{run_name(need.on, need.of)}{'--ideal' if need.ideal else ''}.npz"


def judged(chapter: str, values: Measured, notes: Callable[[Needed], str] = lambda _: "") -> list[Claim]:
    """The claims of a chapter, judged by the ``values`` that were measured; ``notes`` say what to know of them."""
    return [
        Claim(**statement.texts, parts=tuple(p for c in statement.parts for p in _parts(c, values, notes)))
        for statement in _statements()
        if statement.chapter == chapter
    ]


def _parts(condition: _Condition, values: Measured, notes: Callable[[Needed], str]) -> list[Part]:
    known = MEASURED_QUANTITIES.get(condition.metric)
    measure = Measure(condition.says, known.unit if known is not None else condition.unit)

    def part(on: str, form: Form, of: str, against: Sequence[str]) -> Part:
        def seeds(law: str) -> np.ndarray:
            return values(Needed(on, law, form == "ideal"), condition.metric, condition.robots)

        note = notes(Needed(on, of, form == "ideal"))
        return decided(condition, measure, seeds, on=on, of=of, against=against, form=form, note=note)

    return [part(on, form, of, against) for on in condition.on for form, (of, *against) in condition.laws.items()]


@cache
def _statements() -> tuple[_Statement, ...]:
    file = resources.files("robotics") / "plugins" / "thesis" / "claims.toml"
    with reading(file.read_text(encoding="utf-8"), "claims.toml", ClaimError) as table:
        return statements(table["claims"], ("claims",), kind=_Statement)
