"""The pages of the reference that are made of the program itself, before Sphinx reads the sources.

``write(folder)`` writes them into the folder ``made`` there, which no version control keeps: a page for every public
name, one for each command, one for each kind of file, the tables of metrics, controllers, scenarios and rule bases, and
what the benchmarks measure, with the figures of ``benchmarks.json`` there.
"""

import ast
import dataclasses
import importlib
import inspect
import json
import re
import shutil
import textwrap
import tomllib
from collections.abc import Iterator
from functools import cache
from pathlib import Path
from typing import Any

import typer
from keypage import key_reference
from metricformulas import FORMULAS

PACKAGES = {
    "fuzzy": "Sugeno systems: membership functions, rules, inference, files, pictures",
    "anfis": "Learning a Sugeno system from data",
    "robotics": "Robots, laws, scenarios, runs and their comparison",
}
PROGRAMS = ("fuzzy", "anfis", "robotics")
_GROUP = re.compile(r"^(\S.*):$")


def write(folder: Path) -> None:
    """Write all pages anew below ``folder``."""
    made = folder / "made"
    shutil.rmtree(made, ignore_errors=True)
    measured = folder / "benchmarks.json"
    pages = {**_api(), **_commands(), **_files(), **_tables(), "benchmarks.md": benchmarks(measured)}
    pages["thesis-figures.md"] = thesis_figures(folder / "thesisfigures.toml")
    for name, text in pages.items():
        page = made / name
        page.parent.mkdir(parents=True, exist_ok=True)
        page.write_text(text, encoding="utf-8")


# Names ------------------------------------------------------------------------------------------------------


def _api() -> dict[str, str]:
    """A page for each package, in the groups of its docstring, and one for each of its names."""
    pages = {}
    for package, purpose in PACKAGES.items():
        module = importlib.import_module(package)
        rows = [_titled(f"``{package}``", "="), purpose + ".", ""]
        for title, names in groups(module):
            rows += [_titled(title, "-"), ".. list-table::", "   :widths: 30 70", ""]
            for name in names:
                rows += [f"   * - :doc:`{package}.{name} <{package}/{name}>`", f"     - {_sentence(module, name)}"]
            rows += ["", ".. toctree::", "   :hidden:", ""] + [f"   {package}/{name}" for name in names] + [""]
        pages[f"{package}.rst"] = "\n".join(rows)
        pages |= {f"{package}/{name}.rst": _page_of(package, module, name) for name in module.__all__}
    return pages


@cache
def stable_names() -> frozenset[str]:
    """The names that ``stable.md`` lists, with their packages."""
    text = (Path(__file__).parent / "stable.md").read_text(encoding="utf-8")
    return frozenset(f"{package}.{name}" for package, name in re.findall(r"\]\(made/(\w+)/(\w+)\)", text))


def groups(module: Any) -> list[tuple[str, list[str]]]:
    """The public names of a package, by the headings of its overview; those that it does not name come last."""
    left, found, title = set(module.__all__), [], ""
    for line in (inspect.getdoc(module) or "").splitlines():
        if heading := _GROUP.match(line):
            title = heading[1]
            found.append((title, []))
        elif title and line.startswith("    "):
            names = [name for name in re.findall(r"\w+", line) if name in left]
            found[-1][1].extend(dict.fromkeys(names))
            left -= set(names)
        else:
            title = ""
    rest = {
        "Errors and warnings": [n for n in left if n.endswith(("Error", "Warning"))],
        "Membership functions": [n for n in left if _is_membership(getattr(module, n))],
    }
    rest["Further names"] = [n for n in left if not any(n in names for names in rest.values())]
    found += [(title, sorted(names, key=str.lower)) for title, names in rest.items()]
    return [(title, names) for title, names in found if names]


def _is_membership(thing: Any) -> bool:
    function = importlib.import_module("fuzzy").MembershipFunction
    if inspect.isclass(thing):
        return issubclass(thing, function)
    return getattr(thing, "__module__", "") == "fuzzy.membership"


def _page_of(package: str, module: Any, name: str) -> str:
    thing, whole = getattr(module, name), f"{package}.{name}"
    rows = [_titled(whole, "="), f".. currentmodule:: {package}", ""]
    if whole not in stable_names():
        rows += [":doc:`Provisional <../../stable>`: it may change with any version.", ""]
    home = getattr(thing, "__module__", package).partition(".")[0]
    if home != package and home in PACKAGES:
        return "\n".join([*rows, f"The same as :doc:`{home}.{name} <../{home}/{name}>`.", ""])
    if inspect.isclass(thing) and thing.__name__ != name and thing.__name__ in module.__all__:
        call = f"``{name}{tuple(inspect.signature(thing).parameters)}``".replace("'", "")
        rows += [f"MATLAB's name of :doc:`{package}.{thing.__name__} <{thing.__name__}>`: {call}.", ""]
    elif inspect.isclass(thing):
        rows += [f".. autoclass:: {whole}", *_members(thing), "   :show-inheritance:", "", *_fields(thing)]
    elif inspect.isroutine(thing):
        rows += [f".. autofunction:: {whole}", ""]
    elif callable(thing):
        text = textwrap.indent(escaped(inspect.getdoc(thing) or ""), "   ")
        rows += [f".. py:function:: {whole}{inspect.signature(thing)}", "", text, ""]
    else:
        rows += [f".. py:data:: {whole}", "", f"   {_of_a_table(thing)}", ""]
    return "\n".join([*rows, f".. minigallery:: {whole}", "   :add-heading: Examples", ""])


def _members(kind: type) -> list[str]:
    """What is shown of a class beside its docstring: what it and our classes above it define."""
    ours = [c for c in kind.__mro__ if c.__module__.partition(".")[0] in PACKAGES]
    names = dict.fromkeys(
        name
        for one in ours
        for name, thing in vars(one).items()
        if not name.startswith("_")
        and not name.endswith("_request")  # scikit-learn makes them of every estimator
        and inspect.getdoc(thing)
        and (inspect.isroutine(thing) or isinstance(thing, property))
    )
    return [f"   :members: {', '.join(names)}"] if names else []


def _fields(kind: type) -> list[str]:
    """The fields of a class that are described by their metadata, as a table below its docstring."""
    told = [f for f in (dataclasses.fields(kind) if dataclasses.is_dataclass(kind) else ()) if f.metadata.get("doc")]
    words = [f for f in (dataclasses.fields(kind) if dataclasses.is_dataclass(kind) else ()) if "words" in f.metadata]
    rows = [(f.name, f.metadata["words"], ROLES[f.metadata["role"]]) for f in words]
    rows += [(f.name, f.metadata["doc"], _accepted(f)) for f in told]
    if not rows:
        return []
    head = ["   .. list-table::", "      :header-rows: 1", "      :widths: 20 50 30", ""]
    head += ["      * - field", "        - meaning", "        - accepted"]
    lines = [[f"      * - ``{n}``", f"        - {escaped(what)}", f"        - {escaped(yes)}"] for n, what, yes in rows]
    return [*head, *(line for row in lines for line in row), ""]


ROLES = {
    "location": "a place, in the unit of x",
    "width": "a length ≠ 0, in the unit of x",
    "slope": "in 1 / the unit of x",
    "shape": "without a unit",
}


def _accepted(field: Any) -> str:
    """What a field takes, with its default."""
    from fuzzy.quantity import accepted

    number = "least" in field.metadata
    said = accepted(field.metadata) if number else ""
    plain = isinstance(field.default, (int, float, str)) and field.default != ""
    return "; ".join(part for part in (said, f"default ``{field.default!r}``" if plain else "") if part)


def _of_a_table(thing: Any) -> str:
    keys = ", ".join(f"``{key}``" for key in thing)
    return f"A {type(thing).__name__} with the entries {keys}."


def _sentence(module: Any, name: str) -> str:
    thing = getattr(module, name)
    documented = inspect.isclass(thing) or callable(thing)
    if not documented:
        return "A table by name."
    return escaped((inspect.getdoc(thing) or "").partition("\n\n")[0].replace("\n", " "))


def escaped(text: str) -> str:
    """A text of ours as reStructuredText: a bar or a star that is no markup stands for itself; literals stay."""
    parts = re.split(r"(``.*?``|`[^`]*`)", text)
    return "".join(part if k % 2 else re.sub(r"(?<!\\)([|*])(?![*])", r"\\\1", part) for k, part in enumerate(parts))


def _titled(title: str, line: str) -> str:
    return f"{title}\n{line * len(title)}\n"


# Commands ---------------------------------------------------------------------------------------------------


def _commands() -> dict[str, str]:
    pages = {}
    for program in PROGRAMS:
        app = importlib.import_module(f"{program}.commands.application").app
        command = typer.main.get_command(app)
        sections = [f"# The command `{program}`\n", *_help(command), f"{_SHARED}\n"]
        for words, one in _below((program,), command):
            sections += [f"## `{' '.join(words)}`\n", *_help(one), *_parameters(one)]
        pages[f"command-{program}.md"] = "\n".join(sections)
    return pages


_SHARED = (
    "Data goes to stdout, messages to stderr. The exit code is 0 when all is well, 1 when a check found something, 2 "
    "for an error, which is one sentence, 130 after Ctrl-C."
)


def _below(words: tuple[str, ...], command: Any) -> Iterator[tuple[tuple[str, ...], Any]]:
    for name, one in getattr(command, "commands", {}).items():
        yield (*words, name), one
        yield from _below((*words, name), one)


def _help(command: Any) -> list[str]:
    text, _, example = inspect.cleandoc(command.help or "").partition("\b\nExample:\n")
    example, *more = example.split("\b\n")
    rows = [text.replace("\b", "").strip(), ""]
    if example.strip():
        rows += ["```sh", textwrap.dedent(example.strip("\n")).strip(), "```", ""]
    for block in more:
        rows += ["```text", block.strip(), "```", ""]
    return rows


def _parameters(command: Any) -> list[str]:
    rows = []
    for one in command.params:
        if one.name == "help" or getattr(one, "hidden", False):
            continue
        argument = one.param_type_name == "argument"
        names = one.metavar or (one.name or "").upper() if argument else ", ".join([*one.opts, *one.secondary_opts])
        default = "needed" if one.required else _default(one.default)
        meaning = " ".join((getattr(one, "help", "") or "").split())
        rows.append(f"| `{names.replace('|', chr(92) + '|')}` | {default} | {_cell(meaning)} |")
    return ["| | default | meaning |", "| --- | --- | --- |", *rows, ""] if rows else []


def _default(value: Any) -> str:
    return "" if value is None or value is False or value == () or callable(value) else f"`{value}`"


def _cell(text: str) -> str:
    return text.replace("|", r"\|").replace("<", r"\<").replace("*", r"\*")


# Files and tables ---------------------------------------------------------------------------------------------


def _files() -> dict[str, str]:
    """A page for each kind of file but scenarios and sweeps, which have one that is kept."""
    from robotics.commands.filekinds import FILE_KINDS

    pages = {}
    for name, kind in FILE_KINDS.items():
        if name in ("scenario", "sweep"):
            continue
        head = (
            f"# The file of {kind.title}\n\n`robotics new {name} -o mine.toml` writes one; {_cell(kind.use)} uses it.\n"
        )
        pages[f"file-{name}.md"] = f"{head}\n{key_reference(kind.table())}"
    return pages


def _tables() -> dict[str, str]:
    from fuzzy.files.packaged import fis_title, packaged_fis_files
    from robotics.laws.catalogue import CATALOGUE
    from robotics.measures.registry import ALL_METRICS
    from robotics.simulation.scenario.reading import load_scenario, scenario_names

    metrics = [
        f"| `{name}` | {_cell(m.title)} | {_cell(FORMULAS[name])} | {m.unit} | {', '.join(m.kinds)} | {m.of_run} |"
        for name, m in ALL_METRICS.items()
    ]
    laws = [f"| `{name}` | {_cell(p.title)} | {_cell(p.note)} |" for name, p in CATALOGUE.items()]
    scenarios = [(name, load_scenario(name)) for name in scenario_names()]
    drives = [
        f"| `{name}` | {_cell(s.title)} | {s.kind} | {len(s.robots)} | {_cell(s.source)} |" for name, s in scenarios
    ]
    bases = [f"| `{name}` | {_cell(fis_title(file))} |" for name, file in packaged_fis_files().items()]
    return {
        "metrics.md": "\n".join(
            [
                "# Metrics\n",
                _METRICS,
                *_head("name", "meaning", "definition", "unit", "kinds", "of robots"),
                *metrics,
                "",
            ]
        ),
        "controllers.md": "\n".join(["# Controllers\n", *_head("name", "law", "where it comes from"), *laws, ""]),
        "scenarios.md": "\n".join(
            ["# Scenarios that come with it\n", *_head("name", "what happens", "kind", "robots", "source"), *drives, ""]
        ),
        "rulebases.md": "\n".join(["# Rule bases that come with it\n", *_head("name", "what it does"), *bases, ""]),
    }


_METRICS = (
    "One number for each seed and robot; `robotics.measure_all(run)` gives them all. Errors are those of the true "
    "posture, not of the measured one: x_err along and y_err across the robot's heading, ψ_err of the heading (5.9), c "
    "the signed distance to the nearest point of the path. Sums and means are over the samples of a robot while it is "
    "in play, T is that time, Δ the change from sample to sample (50 ms). In `compare` what comes after a run's first "
    "contact does not count. The last column says how the robots' numbers make one of a run.\n"
)


def _head(*names: str) -> list[str]:
    return [f"| {' | '.join(names)} |", f"|{' --- |' * len(names)}"]


# The thesis's figures -----------------------------------------------------------------------------------------


def thesis_figures(told: Path) -> str:
    """A row for each figure and table of the thesis: our pictures of it, how to draw one anew, and what differs."""
    rows = []
    for row in tomllib.loads(told.read_text(encoding="utf-8"))["rows"]:
        pictures = ", ".join(f"`{name}`" for name in row.get("pictures", []))
        again = f"`{row['redraw']}`" if "redraw" in row else ""
        rows.append(f"| {row['thesis']}: {row['what']} | {pictures} | {again} | {row['differs']} |")
    return "\n".join(
        [_FIGURES, *_head("thesis", "in `figures/` of `robotics compare`", "one anew", "what differs"), *rows, ""]
    )


_FIGURES = (
    "# The thesis's figures and tables, and ours\n\n"
    "`robotics compare` without names, or `make demo`, draws all of them. Pictures of one robot have bands over the "
    "seeds; those of a team are of seed 0, and the tables beside them have the intervals. Another robot or law is "
    "a word of the command.\n"
)


# Benchmarks -------------------------------------------------------------------------------------------------


def benchmarks(measured: Path) -> str:
    """What each benchmark measures, by its docstring, and its last figures where the file has some."""
    source = Path(__file__).parents[2] / "benchmarks"
    found = json.loads(measured.read_text(encoding="utf-8")) if measured.exists() else {}
    rows = [_BENCHMARKS]
    for name in benchmark_names(source):
        doc = ast.get_docstring(ast.parse((source / f"{name}.py").read_text(encoding="utf-8"))) or ""
        title, _, text = doc.partition("\n\n")
        rows += [f"## `python -m benchmarks.{name}`\n", _prose(title.replace("\n", " ")), "", _prose(text), ""]
        if name in found:
            rows += ["### Measured\n", _machine(found[name]), "", "```text", *found[name]["report"], "```", ""]
    return "\n".join(rows)


def benchmark_names(source: Path) -> list[str]:
    """The benchmarks that ``python -m benchmarks`` runs, in its order."""
    tree = ast.parse((source / "__main__.py").read_text(encoding="utf-8"))
    table = next(n.value for n in tree.body if isinstance(n, ast.Assign) and ast.unparse(n.targets[0]) == "BENCHMARKS")
    return list(ast.literal_eval(table))


def _machine(entry: dict[str, Any]) -> str:
    quick = " Short form (`--quick`)." if entry["quick"] else ""
    busy = "; other work ran beside it" if max(entry["load"]) > 1 else ""
    return (
        f"{entry['date']}, {entry['processor']}, {entry['processors']} processors, Python {entry['python']}, load "
        f"{entry['load'][0]:.1f} before and {entry['load'][1]:.1f} after{busy}; {entry['seconds']:.0f} s.{quick}"
    )


def _prose(text: str) -> str:
    """A docstring's paragraphs as Markdown."""
    return re.sub(r":\w+:`~?([^`]*)`", r"`\1`", text.replace("``", "`")).replace("<", r"\<")


_BENCHMARKS = """# Benchmarks

`make bench` installs the peers that can be had, and runs them all; `python -m benchmarks` runs them without installing
anything, `python -m benchmarks inference learning` those two. Every module also runs by itself, and prints its
numbers as one JSON object with `--json`. They lie in the repository, not in the wheel. Engines take turns within
one run, so that a ratio says more than a time.

`python -m benchmarks --write docs/reference/benchmarks.json` writes the figures on this page, with machine, load and
date. A module without figures below has not been written there.
"""
