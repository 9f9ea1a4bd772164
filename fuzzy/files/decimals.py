"""Columns of texts as numbers, with a decimal point or a decimal comma.

A column has one decimal mark. A comma is one where the column's texts leave no doubt ("0,5", "1,25"), or where
semicolons separate the columns, as programs write tables where the comma is the decimal mark. What could as well be
thousands ("1,234", or "1.234" beside decimal commas) is refused, and so are marks of thousands ("1.234,5"): what they
mean depends on the country.
"""

import math
import re
from collections.abc import Callable, Sequence
from typing import TYPE_CHECKING, NamedTuple

from fuzzy.errors import quoted

if TYPE_CHECKING:
    import numpy as np

_EXPONENT = r"(?:[eE][+-]?\d+)?"
_COMMA = re.compile(rf"[+-]?(?:\d+,\d*|,\d+){_EXPONENT}", re.ASCII)
_POINT = re.compile(rf"[+-]?(?:\d+\.\d*|\.\d+){_EXPONENT}", re.ASCII)
_THOUSANDS = re.compile(r"[+-]?[1-9]\d{0,2}(?:[.,]\d{3})+")
_GROUPED = re.compile(r"[+-]?\d{1,3}(?:(?:\.\d{3})+,\d*|(?:,\d{3})+\.\d*|(?:\.\d{3}){2,}|(?:,\d{3}){2,})", re.ASCII)


class Marks(NamedTuple):
    """The decimal marks that stand in a table beyond doubt."""

    comma: bool
    point: bool


class Numbers(NamedTuple):
    """A column's numbers."""

    values: "np.ndarray"  # (rows,) not-a-number where there is none
    doubt: str = ""  # why its texts cannot be told, as the end of a sentence; then every value is not-a-number


def numbers_of(texts: Sequence[str], marks: Callable[[], Marks], semicolons: bool) -> Numbers:
    """The numbers in a column's ``texts``; ``marks`` tells those of the whole table, if that matters.

    ``semicolons`` says that these separate the table's columns. Text that is no finite number is not-a-number.
    """
    import numpy as np  # for which nobody waits who reads no table

    try:
        values = np.array(list(map(float, texts)), dtype=float)
        plain = "_" not in "".join(texts)  # float reads 1_000, by which a table means something else
    except ValueError:
        plain = False
    commas: list[str] = []
    points: Sequence[str] = texts if plain and any(map(_THOUSANDS.fullmatch, texts)) else ()
    if not plain:
        texts = [text.strip() for text in texts]
        commas = [text for text in texts if "," in text and _COMMA.fullmatch(text)]
        points = [text for text in texts if "." in text and _POINT.fullmatch(text)]
    doubt = _doubt(commas, points, marks, semicolons)
    if doubt:
        return Numbers(np.full(len(texts), np.nan), doubt)
    if not plain:
        values = np.array([_number(text, bool(commas)) for text in texts], dtype=float)
    return Numbers(np.where(np.isfinite(values), values, np.nan))


def sure_marks(text: str) -> Marks:
    """The decimal marks in one field: none where it is no number, or may hold a mark of thousands."""
    text = text.strip()
    if _THOUSANDS.fullmatch(text):
        return Marks(False, False)
    return Marks("," in text and bool(_COMMA.fullmatch(text)), "." in text and bool(_POINT.fullmatch(text)))


def why_no_number(text: str) -> str:
    """Say what a field holds in a number's place."""
    text = text.strip()
    if not text:
        return "the field is empty"
    if _GROUPED.fullmatch(text):
        return f"{quoted(text)} has marks of thousands; write it without them"
    try:
        float(text)
    except ValueError:
        parts = text[:1000].split()
        if len(parts) > 1 and all(map(is_number, parts)):
            return f"{quoted(text)} holds several numbers; separate the columns with commas, semicolons or tabs"
        return quoted(text)
    return quoted(text) if "_" in text else f"{quoted(text)} is not finite"


def _doubt(commas: Sequence[str], points: Sequence[str], marks: Callable[[], Marks], semicolons: bool) -> str:
    if commas and points:
        return (
            f"holds {quoted(commas[0])} and {quoted(points[0])}; write all its numbers with a decimal point, or "
            "all with a decimal comma"
        )
    if commas and not _settled(commas):
        known = marks()
        if known.point or not (known.comma or semicolons):
            return f"holds {quoted(commas[0])}, of which the comma may mark thousands or decimals; write it without one"
    if points and not _settled(points) and marks().comma:
        doubtful = next(text for text in points if _THOUSANDS.fullmatch(text.strip()))
        return (
            f"holds {quoted(doubtful)}, of which the point may mark thousands, as another column has decimal commas; "
            "write it without the point"
        )
    return ""


def _settled(texts: Sequence[str]) -> bool:
    """Whether one of the texts has a mark that can only be the decimal one."""
    return any(any(sure_marks(text)) for text in texts)


def _number(text: str, comma: bool) -> float:
    if comma:
        text = text.replace(",", ".", 1)
    try:
        return float(text) if "_" not in text else math.nan
    except ValueError:
        return math.nan


def is_number(text: str) -> bool:
    """Whether ``text`` is a number as tables hold them, also one that is not finite."""
    try:
        float(text)
    except ValueError:
        return False
    return "_" not in text  # float reads 1_000, by which a table means something else
