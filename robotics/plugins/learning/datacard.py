"""The data card of a set: what it is, how it was made, and what is in its columns; read by people and by programs.

The card of ``data.csv`` is ``data.card.md``, Markdown with two tables: one of facts, and one with a row a column. The
scatter of an output at equal inputs is √Γ of :mod:`robotics.plugins.learning.scatter`: about what a smooth function
of the inputs errs by on fresh samples.
"""

from collections.abc import Mapping, Sequence
from dataclasses import fields, is_dataclass
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from fuzzy.files.atomic import write_whole
from robotics.laws.catalogue import make_controller
from robotics.laws.formation.leader_follower import FormationTeacher
from robotics.laws.law import Law
from robotics.plugins.learning.datatable import DataColumn, write_data
from robotics.plugins.learning.formationdata import LEARNING_TEXTS, FormationRecipe
from robotics.plugins.learning.scatter import NEIGHBOURS, SHARE, scatter
from robotics.plugins.learning.scenariodata import ScenarioRecipe
from robotics.simulation.scenario.description import Scenario
from robotics.world.sensing.posture import Sensing

_COLUMNS = ("column", "unit", "role", "meaning", "min", "max", "mean", "scatter at equal inputs")


class Card(NamedTuple):
    """What a card says: its facts, and of each column the cells of COLUMNS after the first, as text."""

    facts: Mapping[str, str]
    columns: Mapping[str, Mapping[str, str]]


def card_path(data: str | Path) -> Path:
    """The file of the card that belongs to the file ``data``: data.card.md beside data.csv."""
    return Path(data).with_suffix(".card.md")


def write_set(data: str | Path, facts: Mapping[str, str], columns: Sequence[DataColumn], values: np.ndarray) -> Path:
    """Write a set as CSV, and its card beside it; return the card's file. Each appears whole or not at all.

    Args:
        data: The file of the set.
        facts: What is said of it, by a word each.
        columns: Its columns.
        values: Its numbers (rows, columns).
    """
    write_data(data, [column.name for column in columns], values)
    path = card_path(data)
    facts = {**facts, "rows": str(len(values))}
    lines = [f"# {Path(data).name}", "", *_table(("fact", "value"), facts.items()), "", "## Columns", ""]
    lines += _table(_COLUMNS, _column_rows(columns, values))
    said = "The scatter is √Γ of the Gamma test: about what a smooth function of the inputs errs by on fresh samples."
    write_whole(path, "\n".join([*lines, "", said]) + "\n")
    return path


def read_card(path: str | Path) -> Card:
    """Read a card that :func:`write_set` wrote."""
    lines = [line for line in Path(path).read_text(encoding="utf-8").splitlines() if line.startswith("|")]
    rows = [[cell.strip().replace("\\|", "|").strip("`") for cell in _cells(line)] for line in lines]
    split = next(k for k, row in enumerate(rows) if row[0] == _COLUMNS[0])
    columns = {row[0]: dict(zip(_COLUMNS[1:], row[1:], strict=True)) for row in rows[split + 2 :]}
    return Card({row[0]: row[1] for row in rows[2:split]}, columns)


def _cells(line: str) -> list[str]:
    return [part.replace("\0", "\\|") for part in line.replace("\\|", "\0").strip().strip("|").split("|")]


def _column_rows(columns: Sequence[DataColumn], values: np.ndarray) -> list[tuple[str, ...]]:
    scattered = _scattered(columns, values)
    rows = []
    for k, c in enumerate(columns):
        numbers = (f"{number:.6g}" for number in (values[:, k].min(), values[:, k].max(), values[:, k].mean()))
        found = scattered.get(c.name)
        shown = "" if found is None else f"{found:.2g} {c.unit}"
        rows.append((f"`{c.name}`", c.unit, "output" if c.output else "input", c.meaning, *numbers, shown))
    return rows


def _scattered(columns: Sequence[DataColumn], values: np.ndarray) -> dict[str, float]:
    """√Γ of each output by the inputs of its group; nothing of a set too small to tell."""
    if len(values) * SHARE <= NEIGHBOURS:
        return {}
    found: dict[str, float] = {}
    for group in dict.fromkeys(c.group for c in columns):
        inputs = [k for k, c in enumerate(columns) if c.group == group and not c.output]
        outputs = [k for k, c in enumerate(columns) if c.group == group and c.output]
        if inputs and outputs:
            rms = scatter(values[:, inputs], values[:, outputs]).rms
            found |= {columns[k].name: float(r) for k, r in zip(outputs, rms, strict=True)}
    return found


def _table(head: Sequence[str], rows: Any) -> list[str]:
    lines = [tuple(head), ("---",) * len(head), *rows]
    return ["| " + " | ".join(cell.replace("|", "\\|") for cell in cells) + " |" for cells in lines]


def thesis_facts(recipe: FormationRecipe, command: str) -> dict[str, str]:
    """What there is to say of a set of the thesis's kinds; ``command`` is what made it."""
    teacher = FormationTeacher(speed=recipe.speed, speeds="literal" if recipe.kind == "literal" else "lead")
    about = {"recipe": recipe, "command": command, "starts": ", ".join(f"{x:g}" for x in recipe.starts)}
    return LEARNING_TEXTS.filled(f"facts.{recipe.kind}", **about, gains=gains(teacher))


def robot_facts(scenario: Scenario, recipe: ScenarioRecipe, command: str) -> dict[str, str]:
    """What there is to say of a set that was made of ``scenario``; ``command`` is what made it."""
    return LEARNING_TEXTS.filled(
        "facts.scenario",
        scenario=scenario,
        recipe=recipe,
        command=command,
        robots=len(scenario.robots),
        title=f": {scenario.title}" if scenario.title else "",
        teacher=f"{recipe.teacher}: {gains(make_controller(recipe.teacher))}".removesuffix(": "),
        noise=noise(scenario.setting.sensing),
        runs=f"{recipe.seeds.start} to {recipe.seeds.stop - 1}" if recipe.runs else "none",
        last=recipe.seeds.stop + recipe.places * recipe.starts - 1,
    )


def gains(law: Law[Any]) -> str:
    """The numbers and words that a law is set to, and that have an effect."""
    if not is_dataclass(law):
        return ""
    known = {f.name: getattr(law, f.name) for f in fields(law) if f.init and f.name not in law.idle}
    shown = {name: value for name, value in known.items() if isinstance(value, (int, float, str)) and value != ""}
    return ", ".join(f"{n} = {v:g}" if isinstance(v, float) else f"{n} = {v}" for n, v in shown.items())


def noise(sensing: Sequence[Sensing]) -> str:
    """How each robot knows its posture: its noise and errors that are not 0."""
    said = []
    for one in sensing:
        units = {f.name: f.metadata["unit"] for f in fields(one) if "unit" in f.metadata}
        on = {n: getattr(one, n) for n in units if n.endswith(("noise", "error")) or n.startswith("start_")}
        parts = [f"{n} {v:g}{'' if units[n] == '1' else ' ' + units[n]}" for n, v in on.items() if v]
        said.append(", ".join([f"posture by {one.posture}", *parts]))
    if len(set(said)) == 1:
        return said[0]
    return "; ".join(f"robot {i}: {text}" for i, text in enumerate(said, start=1))
