"""Pages in Markdown about files: every key with its unit, range, default and meaning."""

from robotics.tables.keys import Key, KeyTable, distinct_tables, walk
from robotics.tables.template import toml_value


def key_reference(table: KeyTable) -> str:
    """A section for each table of a file, with all its keys; a table that stands in several places has one section."""
    return "\n".join(_section(each, table) for each in distinct_tables(table).values())


def _section(table: KeyTable, file: KeyTable) -> str:
    places = dict.fromkeys(p.header for p in walk(file) if p.key.table is not None and p.key.table.name == table.name)
    title = ", ".join(f"`{place}`" for place in places) or f"The file of a {table.name}"
    lines = [f"## {title}\n", f"{table.doc}\n"]
    for group in table.one_of:
        lines.append(f"Exactly one of {', '.join(f'`{name}`' for name in group)} is given.\n")
    if table.keys:
        lines += [*_rows(table.keys), ""]
    for shape, keys in table.shapes.items():
        lines.append(f'`{table.by} = "{shape}"`: {table.shape_docs.get(shape, "")}\n')
        lines += [*_rows(keys), ""]
    if table.any_key is not None:
        lines.append(f"Under each name stands {table.any_key.accepted}. {table.any_key.doc}\n")
    return "\n".join(lines)


def _rows(keys: tuple[Key, ...]) -> list[str]:
    rows = ["| key | accepted | default | meaning |", "| --- | --- | --- | --- |"]
    return rows + [f"| `{k.name}` | {k.accepted} | {_default(k)} | {k.doc} |" for k in keys]


def _default(key: Key) -> str:
    if key.required:
        return "needed"
    if key.default is not None:
        return f"`{toml_value(key.default)}`"
    return f"by rule: {key.rule}" if key.rule else ""
