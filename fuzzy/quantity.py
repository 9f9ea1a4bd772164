"""Quantities: numbers with a unit and a range of plausible values, declared beside the field that holds them.

A plausible range catches the commonest mistake in a file of numbers: the right figure in the wrong unit
(degrees for radians, millimetres for metres). The message names the field, its unit and what is accepted.
"""

from collections.abc import Iterator
from dataclasses import MISSING, field, fields
from functools import partial
from math import inf, pi
from numbers import Integral, Real
from typing import Any

from fuzzy.errors import InputError, quoted, shortened

LARGEST_NUMBER = 1e15  # numbers of a robot's world are smaller by far; squares and cubes of these are numbers as well
SMALLEST = 1 / LARGEST_NUMBER  # and what must be greater than 0 can be divided by


def quantity(
    default: Any,
    unit: str,
    *,
    above: float = -inf,
    least: float = -inf,
    most: float = inf,
    doc: str = "",
    example: float | None = None,
    word: Any = "",
) -> Any:
    """Declare a dataclass field that is a number with a unit; :func:`check_quantities` holds it to its range.

    Args:
        default: The default value, or None for a number that may be left out.
        unit: The unit, such as "m/s"; "1" for none.
        above: The number must be greater.
        least: The number must be this or greater.
        most: The number must be this or smaller.
        doc: A sentence for programs and files that show the field.
        example: A value to show where the default is None.
        word: A word that may stand there instead of a number.
    """
    metadata = {"unit": unit, "above": above, "least": least, "most": most, "doc": doc, "example": example}
    return field(default=default, metadata=metadata | ({"word": word} if word else {}))


part = partial(quantity, unit="1", least=0, most=1)  # a part of a whole, or a probability
turn = partial(quantity, unit="rad", least=-2 * pi, most=2 * pi)  # within a turn either way


def whole(default: Any, *, least: int, most: float = inf, doc: str, example: int | None = None) -> Any:
    """Declare a dataclass field that is a whole number from ``least`` to ``most``, such as a count.

    :func:`check_quantities` holds it to its range. The other arguments are as of :func:`quantity`; the default may be
    dataclasses.MISSING for a field that must be given.
    """
    metadata = {"whole": True, "above": -inf, "least": least, "most": most, "doc": doc, "example": example}
    return field(default=default, metadata=metadata)


def described(
    doc: str,
    default: Any = MISSING,
    *,
    default_factory: Any = MISSING,
    example: Any = None,
    accepts: str = "",
    missing: str = "",
) -> Any:
    """Declare a dataclass field that is no quantity, with a sentence for programs and files that show it.

    Args:
        doc: The sentence.
        default: The default value; without one the field must be given.
        default_factory: Makes the default value, where each instance needs its own.
        example: A value to show where there is no default, as a file has it.
        accepts: What a message says that it must be; by default what its type says.
        missing: What a message says where a file lacks it.
    """
    metadata = {"doc": doc, "example": example, "accepts": accepts, "missing": missing}
    return field(default=default, default_factory=default_factory, metadata=metadata)


def accepted(metadata: Any) -> str:
    """The unit and the range of a quantity's ``metadata``, in words: "a finite number in m, > 0 and <= 1".

    Those of a whole number likewise: "a whole number >= 1".
    """
    bounds = []
    if metadata["above"] > -inf:
        bounds.append(f"> {metadata['above']:g}")
    if metadata["least"] > -inf:
        bounds.append(f">= {metadata['least']:.6g}")
    if metadata["most"] < inf:
        bounds.append(f"<= {metadata['most']:{'.0f' if metadata.get('whole') else '.6g'}}")
    if metadata.get("whole"):
        return "a whole number" + (" " + " and ".join(bounds) if bounds else "")
    unit = f" in {metadata['unit']}" if metadata["unit"] != "1" else ""
    word = f', or "{metadata["word"]}"' if metadata.get("word") else ""
    return f"a finite number{unit}" + (", " + " and ".join(bounds) if bounds else "") + word


def is_number(value: Any) -> bool:
    """Whether ``value`` is a finite real number, of :data:`LARGEST_NUMBER` in size at most."""
    real = isinstance(value, Real) and not isinstance(value, bool)
    return real and abs(value) <= LARGEST_NUMBER


UNPRINTABLE = "a whole number of more than 3,000 digits"


def unprintable(value: Any, keys: tuple[str | int, ...] = ()) -> Iterator[tuple[str | int, ...]]:
    """The keys of whole numbers of more than 3,000 digits: Python reads them from TOML and may not print them."""
    if isinstance(value, int) and value.bit_length() > 10_000:
        yield keys
    elif isinstance(value, dict | list):
        for key, part in value.items() if isinstance(value, dict) else enumerate(value):
            yield from unprintable(part, (*keys, key))


def got(value: Any) -> str:
    """What a message says of a ``value`` that is refused: "got 'fast'"; of a number that is too large, why.

    >>> got(1e200)
    'got 1e+200 (numbers may be 1e+15 in size at most)'
    """
    numbers = value if isinstance(value, (list, tuple)) else (value,)
    large = any(isinstance(v, (int, float)) and LARGEST_NUMBER < abs(v) < inf for v in numbers)
    text = quoted(value) if isinstance(value, str) else shortened(repr(value))
    return f"got {text}" + (f" (numbers may be {LARGEST_NUMBER:g} in size at most)" if large else "")


def check_quantities(instance: Any, error: type[InputError]) -> None:
    """Make every quantity of a frozen dataclass ``instance`` a float and every whole number an int, in their ranges.

    Raises ``error``, which is ``about`` the field, for a value that is no number or is out of range.
    """
    for f in fields(instance):
        if "unit" not in f.metadata and "whole" not in f.metadata:
            continue
        value = getattr(instance, f.name)
        m = f.metadata
        if (value is None and f.default is None) or (isinstance(value, str) and value == m.get("word")):
            continue
        if "whole" in m:
            if isinstance(value, bool) or not isinstance(value, Integral) or not m["least"] <= value <= m["most"]:
                raise error(f"{f.name} must be {accepted(m)}; {got(value)}").about(f.name)
            object.__setattr__(instance, f.name, int(value))
            continue
        if not (is_number(value) and value > m["above"] and value >= m["least"] and value <= m["most"]):
            raise error(f"{f.name} must be {accepted(m)}; {got(value)}").about(f.name)
        if m["above"] == 0 and value < SMALLEST:
            raise error(f"{f.name} must be {accepted(m)}, and {SMALLEST:g} at least; {got(value)}").about(f.name)
        object.__setattr__(instance, f.name, float(value))
