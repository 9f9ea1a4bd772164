"""The command ``robotics scenario``: what the keys of one's own files mean, and the JSON schemas of these files."""

import sys
from typing import TYPE_CHECKING, Annotated, Any

from fuzzy.errors import InputError
from fuzzy.shell.options import Json, argument, option
from fuzzy.shell.terminal import print_json
from robotics.commands.completion import one_of
from robotics.commands.filekinds import FILE_KINDS, file_kind

if TYPE_CHECKING:
    from robotics.tables.keys import KeyTable, Placed


def scenario(
    key: Annotated[str | None, argument("A key or a table, such as robots.timing.speed or timing.", "KEY")] = None,
    explain: Annotated[bool, option("Say what the keys mean; this is the default.")] = False,
    schema: Annotated[bool, option("Print the JSON schema, for editors.")] = False,
    of: Annotated[
        str, option(f"Kind of file: {', '.join(FILE_KINDS)}.", "KIND", autocompletion=one_of(FILE_KINDS))
    ] = "scenario",
    json: Json = False,
) -> None:
    """Explain the keys of a scenario's file, or of another kind of file: unit, range, default and meaning.

    An editor checks a file whose first line names the schema:  #:schema ./scenario.schema.json

    \b
    Example:
      robotics scenario --explain
      robotics scenario --explain robots.timing.speed
      robotics scenario --schema > scenario.schema.json
      robotics scenario --schema --of sweep > sweep.schema.json
    """
    from robotics.tables.keys import find, walk
    from robotics.tables.schema import naming, schema_of

    if schema:
        if explain:
            raise InputError("give --explain or --schema, not both")
        name = key or of
        print_json(schema_of(file_kind(name).table(), f"Fuzzyfleet: {file_kind(name).title}"))
        print(f"robotics: editors find it by a file's first line: {naming(f'{name}.schema.json')}", file=sys.stderr)
        return
    table = file_kind(of).table()
    found = find(table, key) if key else list(walk(table))
    if json:
        print_json({"keys": [_row(p) for p in found]})
    elif key and len(found) == 1:
        _print_one(found[0])
    else:
        _print_tables(table, found, whole=key is None)


def _row(p: "Placed") -> dict[str, Any]:
    key = p.key
    row: dict[str, Any] = {"key": p.path, "shape": p.shape or None, "holds": key.holds, "unit": key.unit or None}
    bounds = {"above": key.above, "least": key.least, "most": key.most}
    row |= bounds | {"words": list(key.words) or None, "required": key.required, "default": key.default}
    return row | {"rule": key.rule or None, "example": key.shown, "accepted": key.accepted, "doc": key.doc}


def _default(p: "Placed") -> str:
    """What holds where a key is left out, in a word."""
    from robotics.tables.template import toml_value

    key = p.key
    if key.required:
        return "needed"
    return "by rule" if key.rule and key.default is None else "-" if key.default is None else toml_value(key.default)


def _print_one(p: "Placed") -> None:
    """Print all that is known of one key."""
    from robotics.tables.template import example_line

    key = p.key
    print(f"{p.marked}" + (f"  (of shape = {p.shape!r})" if p.shape else ""))
    print(f"  {key.doc}")
    print(f"  accepted  {key.accepted}")
    print(f"  default   {_default(p)}" + (f": {key.rule}" if key.rule else ""))
    if key.table is None:
        header = p.marked.removesuffix(key.name).strip()
        shape = f'shape = "{p.shape}"; ' if p.shape else ""
        print(f"  example   {header + ' ' if header else ''}{shape}{example_line(key)}")


def _print_tables(table: "KeyTable", found: list["Placed"], whole: bool) -> None:
    """Print keys in groups, one for each table; a table that stands in several places is printed in the first."""
    from rich.console import Console
    from rich.table import Table as Grid

    from robotics.tables.keys import walk

    width = None if sys.stdout.isatty() else 132
    console = Console(width=width, highlight=False, markup=False)
    printed: dict[str, str] = {}
    groups: dict[str, list[Placed]] = {}
    for p in found:
        groups.setdefault(p.marked.removesuffix(p.key.name).strip(), []).append(p)
    names = {"": table.name} | {p.header: p.key.table.name for p in walk(table) if p.key.table is not None}
    for header, rows in groups.items():
        name = names[header]
        if whole and name in printed:
            continue
        printed[name] = header
        others = [other for other, its in names.items() if its == name and other != header] if whole else []
        print(f"\n{header or 'the file itself'}" + (f", and alike {', '.join(others)}" if others else ""))
        grid = Grid(box=None, padding=(0, 2, 0, 2), show_header=True, header_style="dim")
        for column in ("key", "accepted", "default", "meaning"):
            grid.add_column(column, overflow="fold", no_wrap=column == "key")
        for p in rows:
            shown = f"{p.shape}: {p.key.name}" if p.shape else p.key.name
            grid.add_row(shown, p.key.accepted, _default(p), p.key.doc)
        with console.capture() as text:
            console.print(grid)
        print("\n".join(line.rstrip() for line in text.get().splitlines()))
