"""Frozen dataclasses made of TOML tables: every key known, every value of its field's type, nothing missing.

A field's type says what its value must be: a number, text, one of some words, points, a dataclass (a table) or several
of them (tables [[...]]). What a table cannot say by its types alone has a :data:`Special` reader. Where a field is
described by :mod:`fuzzy.quantity`, the same description stands in messages, in explanations and in schemas.
"""

import types
from collections.abc import Callable, Mapping
from dataclasses import MISSING, Field, dataclass, field, fields, is_dataclass
from typing import Any, Literal, Union, get_args, get_origin, get_type_hints

from fuzzy.errors import InputError, concerning
from fuzzy.naming import check_known, expected
from fuzzy.quantity import accepted, got, is_number
from robotics.tables.keys import HELD, HOLDS_OF, Holds

Keys = tuple[str | int, ...]  # the place of a value in a file: the keys from the outermost in
Special = Callable[[Any, Keys], Any]  # makes a field's value of what stands in the file, or raises an InputError


@dataclass(frozen=True)
class Builder:
    """Makes dataclasses of tables; its errors are ``fault``, and are ``about`` the keys of what is wrong."""

    fault: type[InputError]
    special: Mapping[Any, Special] = field(default_factory=dict)  # by the type of the field

    def build(self, kind: type, table: Mapping[str, Any], keys: Keys, also: tuple[str, ...] = (), **given: Any) -> Any:
        """Make a dataclass of a table.

        Args:
            kind: The dataclass. Its fields that are described are read.
            table: The table.
            keys: Its place in the file.
            also: Other keys that messages say are accepted there.
            given: Fields that are not read.
        """
        hints = get_type_hints(kind)
        known = {f.name: f for f in fields(kind) if "doc" in f.metadata and f.name not in given}
        values = dict(given)
        for key, value in table.items():
            if key not in known:
                raise self.fault(expected(key, dict.fromkeys([*known, *also]), "key")).about(*keys, key)
            values[key] = self.convert(value, hints[key], known[key], (*keys, key))
        needed = (f for f in known.values() if f.default is MISSING and f.default_factory is MISSING)
        missing = {f.name: f.metadata.get("missing") for f in needed if f.name not in values}
        if missing:
            usual = f"{kind.__name__.lower()} lacks {', '.join(missing)}"
            raise self.fault(next(filter(None, missing.values()), usual)).about(*keys)
        with concerning(*keys):
            return kind(**values)

    def convert(self, value: Any, hint: Any, field: Field[Any], keys: Keys) -> Any:
        """Make the value of a ``field`` of type ``hint`` of the ``value`` in the file at ``keys``."""

        def refuse(usual: str) -> InputError:
            what = field.metadata.get("accepts") or usual
            return self.fault(f"{field.name} must be {what}; {got(value)}").about(*keys)

        origin = get_origin(hint)
        if origin in (Union, types.UnionType) and hint not in self.special:
            hint = next(h for h in get_args(hint) if h is not type(None))
            origin = get_origin(hint)
        if hint in self.special:
            return self.special[hint](value, keys)
        if is_dataclass(hint):
            assert isinstance(hint, type)
            return self.build(hint, self.table(value, keys), keys)
        if origin is Mapping:
            rows = self.table(value, keys).items()
            inner = get_args(hint)[1]
            return {name: self.build(inner, self.table(row, (*keys, name)), (*keys, name)) for name, row in rows}
        if origin is tuple and is_dataclass(inner := get_args(hint)[0]):
            assert isinstance(inner, type)
            return tuple(self.build(inner, row, (*keys, i)) for i, row in enumerate(self.tables(value, keys)))
        if origin is Literal:
            if value not in get_args(hint):
                raise refuse("one of " + ", ".join(map(repr, get_args(hint))))
            return value
        if hint not in HOLDS_OF:
            raise TypeError(f"a field of type {hint!r} cannot be read from TOML")
        holds = HOLDS_OF[hint]
        if isinstance(value, str) and value == field.metadata.get("word"):
            return value
        made = plain_value(holds, value)
        if made is not None:
            return made
        if holds == "points" and isinstance(value, list):
            i, row = next((i, row) for i, row in enumerate(value, 1) if plain_value("point", row) is None)
            what = f"point {i} of {field.name} must be {HELD['point'].accepted}; {got(row)}"
            raise self.fault(what).about(*keys)
        bounded = "unit" in field.metadata or "whole" in field.metadata
        raise refuse(accepted(field.metadata) if bounded else HELD[holds].accepted)

    def table(self, value: Any, keys: Keys) -> dict[str, Any]:
        """``value`` itself, which must be a table."""
        if not isinstance(value, dict):
            name = f"{keys[-2]} {keys[-1] + 1}" if isinstance(keys[-1], int) else keys[-1]
            raise self.fault(f"{name} must be a table, {got(value)}").about(*keys)
        return value

    def shaped(self, value: Any, keys: Keys, kinds: Mapping[str, type], what: str) -> Any:
        """Make the one of several dataclasses that the key ``shape`` of a table names.

        Args:
            value: What stands in the file.
            keys: Its place in the file.
            kinds: The dataclasses by their names.
            what: What messages call such a table.
        """
        table = dict(self.table(value, keys))
        if "shape" not in table:
            raise self.fault(f"{what} lacks shape, one of {', '.join(kinds)}").about(*keys)
        shape = table.pop("shape")
        check_known(shape, kinds, f"{what.split()[-1]} shape", self.fault, *keys, "shape")
        return self.build(kinds[shape], table, keys, ("shape",))

    def tables(self, value: Any, keys: Keys) -> list[dict[str, Any]]:
        """``value`` itself, which must be a list of tables."""
        if not isinstance(value, list):
            raise self.fault(f"{keys[-1]} must be tables [[{keys[-1]}]]; {got(value)}").about(*keys)
        return [self.table(row, (*keys, i)) for i, row in enumerate(value)]


def plain_value(holds: Holds, value: Any) -> Any:
    """A value that is no table, as a dataclass has it; None where it is not what such a key ``holds``."""
    match holds:
        case "truth" if isinstance(value, bool):
            return value
        case "whole number" if type(value) is int:
            return value
        case "number" if is_number(value):
            return float(value)
        case "text" if isinstance(value, str):
            return value
        case "texts" if isinstance(value, list) and all(isinstance(v, str) for v in value):
            return tuple(value)
        case "point" | "pose" if isinstance(value, (list, tuple)) and len(value) == (2 if holds == "point" else 3):
            return tuple(map(float, value)) if all(map(is_number, value)) else None
        case "points" if isinstance(value, list):
            points = tuple(plain_value("point", row) for row in value)
            return None if None in points else points
        case "pairs" if isinstance(value, list) and all(isinstance(e, list) and len(e) == 2 for e in value):
            return tuple(map(tuple, value)) if all(type(i) is int for e in value for i in e) else None
    return None
