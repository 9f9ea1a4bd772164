"""The thesis's claims, which stand in ``claims.toml``: the runs that they need, and the claims judged by them."""

import re
import tomllib
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from functools import cache
from importlib import resources
from typing import Any, NamedTuple

import numpy as np

from robotics.measures.evidence import Estimate, Form, Part, compared, exact, mean_of, rate_of
from robotics.report.chapter import Claim
from robotics.thesis.quantities import QUANTITIES

_FORMS: dict[str, Form] = {
    "printed": "as printed",
    "corrected": "corrected",
    "ideal": "ideal",
}  # their keys in the file


class Needed(NamedTuple):
    """A law on a scenario or an experiment, with or without noise."""

    on: str
    of: str
    ideal: bool


@dataclass(frozen=True)
class _Question:
    """A part of a claim before anything is measured."""

    says: str
    quantity: str
    on: str
    robots: str
    sense: str  # "below", "above", "less" or "more"
    bound: float
    unit: str
    laws: Mapping[Form, tuple[str, ...]]


@dataclass(frozen=True)
class _Statement:
    """A claim before anything is measured."""

    chapter: str
    about: Mapping[str, str]  # the texts of a Claim, by its fields
    questions: tuple[_Question, ...]


# Gives the numbers of a law's seeds (runs,) by quantity and whose number counts; bool where something happens or not
Measured = Callable[[Needed, str, str], np.ndarray]


def needed(chapter: str) -> list[Needed]:
    """What the claims of a chapter are judged by, each once, in the order of the file."""
    asked = [q for statement in _statements() if statement.chapter == chapter for q in statement.questions]
    return list(
        dict.fromkeys(Needed(q.on, law, form == "ideal") for q in asked for form in q.laws for law in q.laws[form])
    )


def run_file(need: Needed) -> str:
    """The name of the file of a law's runs on a scenario."""
    plain = re.sub(r"[^A-Za-z0-9.=-]+", "_", f"{need.on}--{need.of}")
    return f"{plain}{'--ideal' if need.ideal else ''}.npz"


def judged(chapter: str, values: Measured) -> list[Claim]:
    """The claims of a chapter, judged by the ``values`` that were measured."""
    return [
        Claim(**statement.about, parts=tuple(p for q in statement.questions for p in _parts(q, values)))
        for statement in _statements()
        if statement.chapter == chapter
    ]


def _parts(question: _Question, values: Measured) -> list[Part]:
    parts = []
    for form, (of, *against) in question.laws.items():
        ours, *others = (
            values(Needed(question.on, law, form == "ideal"), question.quantity, question.robots)
            for law in (of, *against)
        )
        if against:
            estimate, bound, sense = compared(ours, others, question.sense == "more")
            sides = tuple(map(_estimate, (ours, *others)))
        else:
            estimate, bound, sides = _estimate(ours), question.bound, ()
            sense = "above" if question.sense == "above" else "below"
        parts.append(
            Part(
                says=question.says,
                form=form,
                estimate=estimate,
                bound=bound,
                sense=sense,
                unit=question.unit,
                quantity=question.quantity,
                on=question.on,
                robots=question.robots,
                of=of,
                against=tuple(against),
                sides=sides,
            )
        )
    return parts


def _estimate(values: np.ndarray) -> Estimate:
    if len(values) == 1:
        return exact(values[0])
    return rate_of(values) if values.dtype == bool else mean_of(values)


@cache
def _statements() -> tuple[_Statement, ...]:
    text = (resources.files("robotics") / "thesis" / "claims.toml").read_text(encoding="utf-8")
    return tuple(_statement(row) for row in tomllib.loads(text)["claims"])


def _statement(row: dict[str, Any]) -> _Statement:
    about = {name: row[name] for name in ("name", "source", "says", "untested")}
    return _Statement(row["chapter"], about, tuple(map(_question, row["parts"])))


def _question(row: dict[str, Any]) -> _Question:
    (sense,) = {"below", "above", "less", "more"} & set(row)
    laws = {form: row[key] for key, form in _FORMS.items() if key in row}
    quantity = row["quantity"]
    return _Question(
        row["says"],
        quantity,
        row["on"],
        "mean" if row.get("mean") else str(row.get("robot", "worst")),
        sense,
        float(row[sense]) if sense in ("below", "above") else 0.0,
        QUANTITIES[quantity].unit if quantity in QUANTITIES else row.get("unit", "1"),
        {form: (law,) if isinstance(law, str) else tuple(law) for form, law in laws.items()},
    )
