"""The keys of TOML files as data: what each holds, its unit, range and default, and what it means.

:func:`table_of` makes the description of a table from the dataclass that the table is read into, so that a field with
its unit, range and sentence is told once. What a dataclass cannot tell (tables that come in shapes, keys that are no
fields) is handed in as data. Explanations, schemas, commented files and pages are made of the descriptions.
"""

import re
import types
from collections.abc import Callable, Iterator, Mapping
from dataclasses import KW_ONLY, MISSING, Field, dataclass, field, fields, is_dataclass
from math import inf
from typing import Any, Literal, NamedTuple, Union, get_args, get_origin, get_type_hints

from fuzzy.errors import InputError
from fuzzy.naming import expected
from fuzzy.quantity import accepted

Holds = Literal[
    "number",
    "whole number",
    "text",
    "word",
    "truth",
    "point",
    "pose",
    "points",
    "pairs",
    "texts",
    "table",
    "tables",
    "any",
]


def _array(items: dict[str, Any], count: int) -> dict[str, Any]:
    return {"type": "array", "items": items, "minItems": count, "maxItems": count}


class Held(NamedTuple):
    """What stands under keys that hold one sort of value."""

    accepted: str  # in words
    schema: Mapping[str, Any] = {}  # JSON's
    kind: Any = None  # the type of a dataclass's field; None: no field is of one alone


_NUMBER = {"type": "number"}
_PAIR = _array({"type": "integer", "minimum": 1}, 2)
HELD: dict[Holds, Held] = {
    "number": Held("a finite number", _NUMBER, float),
    "whole number": Held("a whole number", {"type": "integer"}, int),
    "text": Held("text in quotes", {"type": "string"}, str),
    "truth": Held("true or false", {"type": "boolean"}, bool),
    "point": Held("2 finite numbers [x, y] in m", _array(_NUMBER, 2), tuple[float, float]),
    "pose": Held("3 finite numbers [x, y, heading] in m, m, rad", _array(_NUMBER, 3), tuple[float, float, float]),
    "points": Held(
        "a list of points [x, y] in m", {"type": "array", "items": _array(_NUMBER, 2)}, tuple[tuple[float, float], ...]
    ),
    "pairs": Held(
        "a list of pairs [sender, receiver], robots counted from 1",
        {"type": "array", "items": _PAIR},
        tuple[tuple[int, int], ...],
    ),
    "texts": Held("a list of texts in quotes", {"type": "array", "items": {"type": "string"}}, tuple[str, ...]),
    "table": Held("a table"),
    "tables": Held("tables, one for each"),
    "any": Held("a value"),
}
HOLDS_OF = {held.kind: holds for holds, held in HELD.items() if held.kind is not None}


class KeyUnknownError(InputError):
    """A name that no key and no table of a file has. The message says which one was probably meant."""


@dataclass(frozen=True)
class Key:
    """One key of a table."""

    name: str
    doc: str  # a sentence
    holds: Holds
    _: KW_ONLY
    unit: str = ""
    above: float = -inf
    least: float = -inf
    most: float = inf
    words: tuple[str, ...] = ()  # those that a "word" may be
    required: bool = False
    default: Any = None  # as a file has it; None: the key has no value of its own where it is left out
    rule: str = ""  # how its value follows from others where it is left out
    example: Any = None  # as a file has it
    table: "KeyTable | None" = None  # of a "table", and of each of "tables"
    or_list: bool = False  # whether a list of values may stand there instead
    or_text: str = ""  # what a text that may stand there instead is, in words
    word: str = ""  # one that may stand there instead of a number

    @property
    def inline(self) -> bool:
        """Whether a line of a file sets it."""
        return self.table is None or (self.or_list and self.example is not None)

    @property
    def accepted(self) -> str:
        """What it accepts, in words."""
        if self.holds in ("number", "whole number"):
            metadata = {name: getattr(self, name) for name in ("above", "least", "most", "word")} | {
                "unit": self.unit or "1"
            }
            return accepted(metadata | ({"whole": True} if self.holds == "whole number" else {}))
        words = "one of " + ", ".join(f'"{word}"' for word in self.words) if self.words else HELD[self.holds].accepted
        return words + (", or a list of values" if self.or_list else "") + (f", or {self.or_text}" * bool(self.or_text))

    @property
    def shown(self) -> Any:
        """A value that it can have, as a file has it: an example, or its default; None for a table."""
        if self.example is not None:
            return self.example
        if self.default is not None:
            return self.default
        if self.words:
            return self.words[0]
        return {"number": max(self.least, 1.0) if self.above < 1 else 2 * self.above, "whole number": 1}.get(self.holds)


@dataclass(frozen=True)
class KeyTable:
    """The keys of a table; one that comes in several shapes has further keys for each."""

    name: str  # such as "timing": what stands in two places alike has one name
    doc: str
    keys: tuple[Key, ...] = ()
    _: KW_ONLY
    by: str = ""  # the key that says which shape it has; it is among the keys
    shapes: Mapping[str, tuple[Key, ...]] = field(default_factory=dict)  # by the value of that key
    shape_docs: Mapping[str, str] = field(default_factory=dict)
    one_of: tuple[tuple[str, ...], ...] = ()  # groups of keys of which exactly one is given
    any_key: Key | None = None  # of a table whose keys are free: what stands under each

    def all_keys(self) -> Iterator[tuple[str, Key]]:
        """Every key with the shape that it belongs to; "" where it belongs to all."""
        yield from (("", key) for key in self.keys)
        for shape, keys in self.shapes.items():
            yield from ((shape, key) for key in keys)


@dataclass(frozen=True)
class Placed:
    """A key in its file."""

    path: str  # dotted, such as "robots.timing.speed"
    marked: str  # with its table as a header writes it, such as "[[robots]] timing.speed"
    shape: str  # of its table: "" where the key belongs to all shapes
    key: Key

    @property
    def header(self) -> str:
        """The header of the table under the key, such as "[[robots]]"."""
        return f"[[{self.path}]]" if self.key.holds == "tables" else f"[{self.path}]"


Special = Callable[[str], Key]  # the key of a given name that a field of a certain type is
Specials = Mapping[Any, Special]  # by the type of the field


def key_of(f: Field[Any], hint: Any, specials: Specials) -> Key:
    """The description of the key that the dataclass field ``f`` of type ``hint`` is read from.

    Raises TypeError for a type that no table can hold.
    """
    m = f.metadata
    optional = get_origin(hint) in (Union, types.UnionType)
    if optional and hint not in specials:
        hint = next(h for h in get_args(hint) if h is not types.NoneType)
    made = _held(f.name, hint, specials) | {
        name: m[name] for name in ("above", "least", "most", "example", "word") if name in m
    }
    made["required"] = f.default is MISSING and f.default_factory is MISSING
    made["default"] = None if f.default is MISSING else _as_written(f.default)
    made["unit"] = m.get("unit", "") if m.get("unit") != "1" else ""
    return Key(f.name, m.get("doc", ""), **made, rule=getattr(m.get("rule"), "says", ""))


def _held(name: str, hint: Any, specials: Specials) -> dict[str, Any]:
    if hint in specials:
        special = specials[hint](name)
        return {"holds": special.holds, "table": special.table, "or_list": special.or_list}
    if is_dataclass(hint):
        assert isinstance(hint, type)
        return {"holds": "table", "table": table_of(hint, name, specials)}
    if get_origin(hint) is Literal:
        return {"holds": "word", "words": get_args(hint)}
    if get_origin(hint) is tuple and is_dataclass(get_args(hint)[0]):
        return {"holds": "tables", "table": table_of(get_args(hint)[0], name, specials)}
    if hint not in HOLDS_OF:
        raise TypeError(f"{name}: a field of type {hint!r} cannot stand in a table")
    return {"holds": HOLDS_OF[hint]}


def _as_written(value: Any) -> Any:
    """A default as a file has it; None for one that a file cannot write, such as an empty list of tables."""
    if isinstance(value, tuple):
        return [_as_written(v) for v in value] or None
    return None if value == "" else value


def keys_of(
    kind: type, specials: Specials | None = None, *, without: tuple[str, ...] = (), also: tuple[Key, ...] = ()
) -> tuple[Key, ...]:
    """The keys that the dataclass ``kind`` is read from.

    Args:
        kind: The dataclass. Its fields that are described are keys.
        specials: What stands under a field whose type alone does not tell, by the type.
        without: Fields that are read otherwise.
        also: Further keys; those that have the name of a field take its place.
    """
    hints = get_type_hints(kind)
    others = {key.name: key for key in also}
    own = [f for f in fields(kind) if "doc" in f.metadata and f.name not in (*without, *others)]
    return (*also, *(key_of(f, hints[f.name], specials or {}) for f in own))


def table_of(kind: type, name: str, specials: Specials | None = None, **more: Any) -> KeyTable:
    """The description of the table that the dataclass ``kind`` is read from; ``more`` is as of :func:`keys_of`."""
    return KeyTable(name, first_line(kind), keys_of(kind, specials, **more))


def shapes_table(
    name: str, doc: str, shape_doc: str, kinds: Mapping[str, type], common: tuple[Key, ...] = ()
) -> KeyTable:
    """The description of a table that is read into the one of several dataclasses that its key ``shape`` names.

    Args:
        name: Of the table.
        doc: What the table is.
        shape_doc: What its key ``shape`` says.
        kinds: The dataclasses by their names.
        common: The keys that all of them have.
    """
    shape = Key("shape", shape_doc, "word", words=tuple(kinds), required=True)
    names = tuple(key.name for key in common)
    return KeyTable(
        name,
        doc,
        (shape, *common),
        by="shape",
        shapes={shape: keys_of(kind, without=names) for shape, kind in kinds.items()},
        shape_docs={shape: first_line(kind) for shape, kind in kinds.items()},
    )


def first_line(kind: Any) -> str:
    """The first sentence of the docstring of ``kind``."""
    return str(kind.__doc__ or "").strip().partition("\n")[0].split(" Raises ")[0]


# Finding keys ----------------------------------------------------------------------------------------------------


def walk(table: KeyTable, path: str = "", header: str = "") -> Iterator[Placed]:
    """Every key of a file in its order, each before those of the table under it.

    Args:
        table: The file's outermost table, or one in it.
        path: Its place, dotted, with a dot at its end.
        header: Its place as a file's header writes it.
    """
    for shape, key in table.all_keys():
        yield from _placed(key, path, header, shape)
    if table.any_key is not None:
        yield from _placed(table.any_key, path, header, "")


def _placed(key: Key, path: str, header: str, shape: str) -> Iterator[Placed]:
    placed = Placed(f"{path}{key.name}", f"{header} {key.name}".strip(), shape, key)
    yield placed
    if key.table is not None:
        yield from walk(key.table, f"{placed.path}.", placed.header)


def find(table: KeyTable, name: str) -> list[Placed]:
    """The keys that ``name`` means in a file, and all below those of them that are tables.

    Args:
        table: The file's outermost table.
        name: A key's whole dotted name, or its end, such as "timing.speed".

    Raises KeyUnknownError for a name that no key has.
    """
    wanted = re.sub(r"[\[\]\s.]+", ".", name).strip(".")
    every = list(walk(table))
    found = [p for p in every if p.path == wanted]
    if not found:
        ends = [p for p in every if p.path.endswith(f".{wanted}")]
        places: dict[int, str] = {}  # the same table in several places is shown in the first
        for p in ends:
            places.setdefault(id(p.key.table) if p.key.table is not None else id(p.key), p.path)
        found = [p for p in ends if p.path in places.values()]
    if not found:
        shorter = dict.fromkeys([p.path for p in every] + [p.key.name for p in every])
        raise KeyUnknownError(expected(wanted, shorter, "key").partition(" Known: ")[0].rstrip(".") + _hint(wanted))
    inside = [f"{p.path}." for p in found if p.key.table is not None]
    return [p for p in every if p in found or any(p.path.startswith(start) for start in inside)]


def _hint(wanted: str) -> str:
    return "" if "did you mean" in wanted else " (--explain without a key lists all)"


def distinct_tables(table: KeyTable) -> dict[str, KeyTable]:
    """The tables of a file by name, each once, the outermost first."""
    found = {table.name: table}
    for p in walk(table):
        if p.key.table is not None:
            found.setdefault(p.key.table.name, p.key.table)
    return found
