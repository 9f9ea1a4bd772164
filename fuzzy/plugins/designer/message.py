"""Messages from a page: mappings that may hold anything, read field by field."""

import unicodedata
from collections.abc import Collection, Mapping
from typing import Any

from fuzzy.errors import InputError, quoted
from fuzzy.naming import check_known

_LARGEST = 1e100  # the largest number in an edit: squares of differences stay finite
# What people type, by the name that the page gives it; all else is written by the page itself.
TYPED = {
    "name": "the name",
    "unit": "the unit",
    "low": "the lowest value",
    "high": "the highest value",
    "parameters": "a parameter",
    "weight": "the weight",
    "text": "the sentence",
}


class EditError(InputError):
    """A message that is no edit of this design. The message says what is wrong and what is accepted."""


class Message:
    """The fields of one message; each reader raises EditError with a sentence that names the field."""

    def __init__(self, content: Mapping[str, Any], name: str) -> None:
        self.content, self.name = content, name

    def _get(self, field: str, what: str) -> Any:
        if field not in self.content:
            raise EditError(f"the edit {self.name!r} needs {field!r}, {what}")
        return self.content[field]

    def _wrong(self, field: str, what: str, value: Any) -> EditError:
        named = TYPED.get(field) or f"{field!r} of the edit {self.name!r}"
        shown = quoted(value, 60) if isinstance(value, str) else repr(value)[:60]
        return EditError(f"{named} must be {what}, got {shown}")

    def has(self, field: str) -> bool:
        """Whether the field is there and not null."""
        return self.content.get(field) is not None

    def text(self, field: str, longest: int = 5000) -> str:
        """A text that UTF-8 can hold."""
        value = self._get(field, "a text")
        if not isinstance(value, str) or len(value) > longest:
            raise self._wrong(field, f"a text of at most {longest} characters", value)
        if any("\ud800" <= c <= "\udfff" for c in value):
            raise self._wrong(field, "valid Unicode", value)
        return value

    def label(self, field: str, empty: bool = False) -> str:
        """A new name or unit: one line, without blanks at its ends."""
        value = self.text(field, 100).strip()
        if any(unicodedata.category(c) in ("Cc", "Zl", "Zp") for c in value):
            raise self._wrong(field, "one line without control characters", value)
        if not value and not empty:
            raise EditError(f"{TYPED.get(field, repr(field))} must not be empty")
        return value

    def one_of(self, field: str, accepted: Collection[str], what: str) -> str:
        """One of some words."""
        value = self.text(field)
        check_known(value, accepted, what, EditError)
        return value

    def number(self, field: str) -> float:
        """A finite number."""
        return self._number(field, self._get(field, "a number"))

    def numbers(self, field: str) -> tuple[float, ...]:
        """A list of finite numbers."""
        values = self._get(field, "a list of numbers")
        if not isinstance(values, (list, tuple)) or len(values) > 1000:
            raise self._wrong(field, "a list of numbers", values)
        return tuple(self._number(field, value) for value in values)

    def _number(self, field: str, value: Any) -> float:
        # Compared before it is converted: a large integer fits in no float.
        if isinstance(value, bool) or not isinstance(value, (int, float)) or not abs(value) <= _LARGEST:
            raise self._wrong(field, "a finite number", value)
        return float(value)

    def whole(self, field: str) -> int:
        """A whole number."""
        return self._whole(field, self._get(field, "a whole number"))

    def wholes(self, field: str) -> tuple[int, ...]:
        """A list of whole numbers."""
        return tuple(self._whole(field, value) for value in self.items(field, "a list of whole numbers"))

    def items(self, field: str, what: str, most: int = 10_000) -> list[Any]:
        """A list of anything, at most ``most`` long; ``what`` it holds, for the message."""
        values = self._get(field, what)
        if not isinstance(values, (list, tuple)) or len(values) > most:
            raise self._wrong(field, f"{what}, at most {most}", values)
        return list(values)

    def _whole(self, field: str, value: Any) -> int:
        number = isinstance(value, (int, float)) and not isinstance(value, bool)
        if not number or not abs(value) <= 1e9 or value != int(value):
            raise self._wrong(field, "a whole number", value)
        return int(value)

    def flag(self, field: str, default: bool | None = None) -> bool:
        """True or false."""
        if default is not None and not self.has(field):
            return default
        value = self._get(field, "true or false")
        if not isinstance(value, bool):
            raise self._wrong(field, "true or false", value)
        return value
