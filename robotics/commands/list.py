"""The command ``robotics list``."""

import sys
import textwrap
from collections.abc import Callable, Iterable, Iterator
from contextlib import redirect_stderr, redirect_stdout
from functools import partial
from io import StringIO
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, Literal, NamedTuple

from fuzzy.errors import InputError
from fuzzy.shell.options import Json, argument
from fuzzy.shell.terminal import print_json
from robotics.commands.keptlist import kept_or_made

if TYPE_CHECKING:
    from robotics.tables.files import TomlFile

_WIDTH = 100  # characters in a line
# Of our own teams without obstacles those that would touch, were all on time: to find that out takes a second or two
_MEET = ("three-cross", "two-meetings")
_OURS = Path(__file__).parents[1]

Section = Literal["scenarios", "robots", "controllers", "rule-bases", "studies", "metrics"]


def list_(
    section: Annotated[
        Section | None,
        argument("What to list: scenarios, robots, controllers, rule-bases, studies or metrics.", "SECTION"),
    ] = None,
    json: Json = False,
) -> None:
    """List scenarios, robots, controllers, rule bases, studies and metrics, those of other packages too.

    \b
    Example:
      robotics list
      robotics list rule-bases
    """
    if section is None:
        print(kept_or_made("list.json" if json else "list.txt", lambda: _everything(json)), end="")
    else:
        _print_sections([section], json)


def _everything(json: bool) -> tuple[str, bool]:
    """All sections as they are printed, and whether nothing was said of plug-ins that cannot be used."""
    with redirect_stdout(StringIO()) as printed, redirect_stderr(StringIO()) as said:
        _print_sections([*_LISTINGS], json)
    print(said.getvalue(), end="", file=sys.stderr)
    return printed.getvalue(), not said.getvalue()


def _print_sections(wanted: list[Section], json: bool) -> None:
    rows = {each: _LISTINGS[each].rows() for each in wanted}
    if json:
        print_json({each.replace("-", "_"): found for each, found in rows.items()})
        return
    for place, (each, found) in enumerate(rows.items()):
        print("\n" * (place > 0) + _LISTINGS[each].heading)
        _print_section(found, _LISTINGS[each].lines)


def _print_section(rows: list[dict[str, Any]], lines: Callable[[dict[str, Any]], list[str]]) -> None:
    """Print the entries of a section, in their groups if they have any; the names' column is as wide as the longest."""
    from robotics.simulation.scenario.conditions import CONDITION_GROUPS

    groups = [group for group in CONDITION_GROUPS if any(row.get("group") == group for row in rows)]
    indent = "    " if groups else "  "
    column = len(indent) + max((len(row["name"]) for row in rows), default=0) + 2
    for group in groups or [""]:
        if group:
            print(f"  {group}")
        for row in rows:
            if row.get("group", "") == group:
                _print_entry(indent + row["name"], lines(row), column)


def _print_entry(start: str, lines: list[str], column: int) -> None:
    """Print a name, and from ``column`` on what is said of it."""
    rest = " " * column
    for k, line in enumerate(lines):
        first = start.ljust(column) if k == 0 else rest
        print(textwrap.fill(line, _WIDTH, initial_indent=first, subsequent_indent=rest, break_on_hyphens=False))


def _fields(things: Iterable[Any], *names: str) -> list[dict[str, Any]]:
    return [{name: getattr(thing, name) for name in names} for thing in things]


def _tables(folder: str) -> Iterator[tuple["TomlFile", dict[str, Any]]]:
    """The packaged files of a kind, as they are written: to make what they describe takes seconds."""
    from robotics.tables.files import TomlFiles
    from robotics.tables.text import parse_table

    files = TomlFiles(folder, folder, InputError)
    for name in files.names():
        found = files.find(name)
        yield found, parse_table(found.text, found.file, InputError)


def _said(table: dict[str, Any], *keys: str) -> dict[str, str]:
    return {key: table.get(key, "") for key in keys}


def _scenarios() -> list[dict[str, Any]]:
    from robotics.simulation.scenario.conditions import group

    rows = []
    for file, table in _tables("scenarios"):
        kind, robots, obstacles = table.get("kind", "tracking"), len(table["robots"]), bool(table.get("obstacles"))
        of = group(kind, robots, obstacles, partial(_meet, file))
        rows.append({"name": file.name, "kind": kind, "group": of, **_said(table, "title", "source")})
    return rows


def _meet(file: "TomlFile") -> bool:
    if file.path.is_relative_to(_OURS):
        return file.name in _MEET
    from robotics.simulation.scenario.conditions import touch_on_time
    from robotics.simulation.scenario.reading import load_scenario

    return touch_on_time(load_scenario(file.name))


def _robots() -> list[dict[str, Any]]:
    from robotics.simulation.scenario.robots import load_robot, robot_names

    return _fields([load_robot(name) for name in robot_names()], "name", "title", "source")


def _controllers() -> list[dict[str, Any]]:
    from robotics.laws.catalogue import gains_of, make_controller, presets, unusable_laws

    for reason in unusable_laws().values():
        print(f"robotics: {reason}", file=sys.stderr)
    return [
        {"name": name, "title": preset.title, "note": preset.note, "gains": gains_of(make_controller(name))}
        for name, preset in presets().items()
    ]


def _controller_lines(row: dict[str, Any]) -> list[str]:
    from robotics.laws.catalogue import shown_gain

    gains = ", ".join(f"{name}={shown_gain(value)}" for name, value in row["gains"].items())
    return [f"{row['title']}: {row['note']}", gains]


def _rule_bases() -> list[dict[str, Any]]:
    from fuzzy.files.fisfile import read_fis
    from fuzzy.files.packaged import fis_title, unusable_rule_bases
    from robotics.laws.tracking.fuzzy_tracking import rule_base_files

    for reason in unusable_rule_bases():
        print(f"robotics: {reason}", file=sys.stderr)
    return [
        {
            "name": name,
            "title": fis_title(file),
            "inputs": _fields(fis.inputs, "name", "unit", "universe"),
            "outputs": _fields(fis.outputs, "name", "unit", "universe"),
            "rules": len(fis.rules),
        }
        for name, file in rule_base_files().items()
        for fis in [read_fis(file)]
    ]


def _studies() -> list[dict[str, Any]]:
    return [
        {"name": file.name, **_said(table, "title")} | {key: table[key] for key in ("scenarios", "controllers")}
        for file, table in _tables("studies")
    ]


def _metrics() -> list[dict[str, Any]]:
    from robotics.measures.own import installed_metrics
    from robotics.measures.registry import ALL_METRICS

    own, unusable = installed_metrics()
    for reason in unusable.values():
        print(f"robotics: {reason}", file=sys.stderr)
    return [
        {"name": name, "title": metric.title, "unit": metric.unit, "kinds": list(metric.kinds), "own": name in own}
        for name, metric in {**ALL_METRICS, **own}.items()
    ]


def _metric_line(row: dict[str, Any]) -> list[str]:
    asked = f"; measured if asked for: --metric {row['name']}" if row["own"] else ""
    return [f"{row['title']} [{row['unit']}]; {', '.join(row['kinds'])}{asked}"]


def _rule_base_lines(row: dict[str, Any]) -> list[str]:
    inputs, outputs = (
        ", ".join(f"{v['name']} [{v['unit']}]" if v["unit"] else v["name"] for v in row[side])
        for side in ("inputs", "outputs")
    )
    return [row["title"] or "(no comment)", f"{inputs} → {outputs}; {row['rules']} rules"]


class ListedKind(NamedTuple):
    """What can be listed."""

    heading: str
    rows: Callable[[], list[dict[str, Any]]]
    lines: Callable[[dict[str, Any]], list[str]] = lambda row: [row["title"]]  # what is said of an entry


_LISTINGS: dict[Section, ListedKind] = {
    "scenarios": ListedKind("Scenarios (a name, or the path of a .toml file)", _scenarios),
    "robots": ListedKind(
        "Robots (a name, or the path of a .toml file; try `robotics robot NAME`, `robotics copy NAME`)", _robots
    ),
    "controllers": ListedKind(
        "Controllers (a name, or name:gain=value,gain=value; your own: mylaw.py:MyLaw, mine.fis)",
        _controllers,
        _controller_lines,
    ),
    "rule-bases": ListedKind(
        "Rule bases (a name, or the path of a .fis file; try `fuzzy show NAME`, `robotics copy NAME`)",
        _rule_bases,
        _rule_base_lines,
    ),
    "studies": ListedKind(
        "Studies (a name, or the path of a .toml file, for `robotics study`)",
        _studies,
        lambda row: [row["title"], f"{len(row['scenarios'])} scenarios × {', '.join(row['controllers'])}"],
    ),
    "metrics": ListedKind(
        "Metrics (measured in scenarios of these kinds; your own: --metric mymetric.py:NAME)", _metrics, _metric_line
    ),
}
