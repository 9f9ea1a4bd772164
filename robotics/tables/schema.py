"""JSON schemas of TOML files, draft 2020-12: editors complete and check a file by them.

An editor that knows schemas of TOML (taplo, Even Better TOML) finds the schema by the file's first line, as
:func:`naming` writes it. A schema says of each key what :mod:`robotics.tables.keys` does; what depends on several keys
only the reader says.
"""

from math import inf
from typing import Any

from robotics.tables.keys import HELD, Key, KeyTable, distinct_tables

DRAFT = "https://json-schema.org/draft/2020-12/schema"


def schema_of(table: KeyTable, title: str) -> dict[str, Any]:
    """The schema of a file.

    Args:
        table: The description of the file's outermost table.
        title: What the file is, for the editor.
    """
    inner = {name: _object(each) for name, each in distinct_tables(table).items() if each is not table}
    return {"$schema": DRAFT, "title": title, **_object(table), "$defs": inner}


def naming(file: str) -> str:
    """The first line of a TOML file by which editors find the schema in ``file``, which lies beside it."""
    return f"#:schema ./{file}"


def _object(table: KeyTable) -> dict[str, Any]:
    made: dict[str, Any] = {"type": "object", "description": table.doc}
    common = {key.name: _value(key) for key in table.keys}
    needed = [key.name for key in table.keys if key.required]
    if table.any_key is not None:
        return made | {"additionalProperties": _value(table.any_key)}
    if table.shapes:
        made |= {"properties": {table.by: common[table.by]}, "required": [table.by]}
        shapes = [_shape(table, name, keys, common, needed) for name, keys in table.shapes.items()]
        return made | {"oneOf": shapes}
    made |= {"properties": common, "additionalProperties": False}
    if needed:
        made["required"] = needed
    groups = [{"oneOf": [{"required": [name]} for name in group]} for group in table.one_of]
    return made | (groups[0] if len(groups) == 1 else {"allOf": groups} if groups else {})


def _shape(
    table: KeyTable, name: str, keys: tuple[Key, ...], common: dict[str, Any], needed: list[str]
) -> dict[str, Any]:
    own = {key.name: _value(key) for key in keys}
    return {
        "title": name,
        "description": table.shape_docs.get(name, ""),
        "properties": common | own | {table.by: {"const": name}},
        "required": [*needed, *(key.name for key in keys if key.required)],
        "additionalProperties": False,
    }


def _value(key: Key) -> dict[str, Any]:
    """What stands under one key."""
    made: dict[str, Any] = {"description": _description(key)}
    if key.default is not None:
        made["default"] = key.default
    if key.example is not None:
        made["examples"] = [key.example]
    return made | _type(key)


def _description(key: Key) -> str:
    tail = f" Unit: {key.unit}." if key.unit else ""
    return key.doc + tail + (f" Left out: {key.rule}." if key.rule else "")


def _type(key: Key) -> dict[str, Any]:
    if key.table is not None:
        inner: dict[str, Any] = {"$ref": f"#/$defs/{key.table.name}"}
        made = {"type": "array", "items": inner} if key.holds == "tables" else inner
        others = [{"type": "array", "minItems": 1}] if key.or_list else [{"type": "string"}] if key.or_text else []
        return {"anyOf": [made, *others]} if others else made
    bounds: dict[str, Any] = {}
    for name, value in (("exclusiveMinimum", key.above), ("minimum", key.least), ("maximum", key.most)):
        if abs(value) < inf:
            bounds[name] = value
    made = {"enum": list(key.words)} if key.holds == "word" else {**HELD[key.holds].schema, **bounds}
    return {"anyOf": [made, {"const": key.word}]} if key.word else made
