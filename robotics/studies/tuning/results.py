"""What tuning leaves in its folder: the tuned law's rule bases, its specification, and where they come from."""

from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd

import fuzzy
from fuzzy.figures.drawing import save_figure
from fuzzy.figures.tuning import plot_front, plot_search
from fuzzy.files.atomic import write_json
from fuzzy.files.fisfile import write_system
from fuzzy.files.table import write_frame
from robotics.laws.law import Law
from robotics.laws.specification import Specification
from robotics.studies.tuning.space import FORMATION, task_of
from robotics.studies.tuning.tune import Tuned

RESULT, _FRONT = "result.json", "front.csv"
_NETWORKS = "networks"  # the folder of systems that a law takes together
_PICTURE, FRONT_PICTURE = "evaluations.png", "front.png"


def write_tuned(tuned: Tuned, specification: str, folder: Path) -> str:
    """Write what was found into ``folder``; return the specification of the tuned law, as seen from the present folder.

    Writes result.json, a .fis file for each rule base that moved, evaluations.png, and of a front front.csv and
    front.png. What was tuned, on what and by what is in each of result.json and the .fis files.

    Args:
        tuned: What was found.
        specification: The specification of the law that was tuned.
        folder: The folder, which exists.
    """
    values = tuned.evaluated.values[tuned.evaluated.best]
    kept = ("law", "scenarios", "seeds", "cost", "evaluations", "seed", "engine", "versions")
    provenance = {key: tuned.about[key] for key in kept}  # the contents of the scenarios are in search.json
    for file, (name, fis) in _files(tuned, values).items():
        (folder / file).parent.mkdir(exist_ok=True)
        write_system(fis, folder / file, _comment(fis, name, tuned, provenance))
    inside = _specification(tuned, specification, values, Path())
    about = {
        "specification": inside,  # its files are those of this folder
        "before": tuned.before,
        "after": tuned.after,
        "evaluations": tuned.evaluations,
        "held": list(tuned.space.held),  # what the runs say nothing of
        "parameters": dict(zip([p.name for p in tuned.space.parameters], _shown(tuned, values), strict=True)),
        "provenance": provenance,
    }
    write_json(folder / RESULT, about)
    save_figure(plot_search(tuned.evaluated), folder / _PICTURE)
    if tuned.about["engine"] == "pareto":
        write_frame(front_table(tuned), folder / _FRONT)
        save_figure(plot_front(tuned.evaluated), folder / FRONT_PICTURE)
    return _specification(tuned, specification, values, folder)


def front_table(tuned: Tuned) -> pd.DataFrame:
    """The evaluations that no other one beats in all objectives, a row each, by the first objective."""
    return tuned.history.iloc[tuned.evaluated.front].drop(columns="best")


def _files(tuned: Tuned, values: np.ndarray) -> dict[str, tuple[str, Any]]:
    """The rule bases that moved, each with its name in the law, by file; of networks in one folder all of them.

    A tree is a folder.
    """
    space = tuned.space
    moved = space.systems_of(values)
    if any(task_of(space.law, name) == FORMATION for name in moved):
        return {f"{_NETWORKS}/{name}.fis": (name, fis) for name, fis in space.made(values).fuzzy_systems.items()}
    return {name if isinstance(fis, fuzzy.Tree) else f"{name}.fis": (name, fis) for name, fis in moved.items()}


def _specification(tuned: Tuned, specification: str, values: np.ndarray, folder: Path) -> str:
    """The specification of the law that ``values`` make, its rule bases being files in ``folder``."""
    about = Specification.of(specification)
    law: Law[Any] = tuned.space.law
    gains = dict(part.split("=", 1) for part in about.gains.split(",") if "=" in part)
    for file, (name, _) in _files(tuned, values).items():
        task = task_of(law, name)
        gain = law.rule_base_gain(task)
        path = str(folder / _NETWORKS) if task == FORMATION else str(folder / file)
        if about.file.endswith(".fis") and gain == "rule_base":
            about = about._replace(file=path)
        else:
            gains[gain] = path
    gains |= {name: repr(value) for name, value in tuned.space.gains_at(values).items()}
    return str(about._replace(gains="").with_gains(f"{name}={value}" for name, value in gains.items()))


def _shown(tuned: Tuned, values: np.ndarray) -> list[Any]:
    return [p.choices[int(v)] if p.choices else float(v) for p, v in zip(tuned.space.parameters, values, strict=True)]


def _comment(fis: Any, task: str, tuned: Tuned, about: Mapping[str, Any]) -> str:
    terms = " + ".join(f"{t.weight:g} * {t.metric} / {t.scale:g}" for t in tuned.cost.terms)
    first, last = about["seeds"]
    return "\n".join(
        [
            f"{fis.name}: the rule base {task} of {about['law']}, tuned through the closed loop.",
            f"Scenarios: {', '.join(about['scenarios'])}; seeds {first} to {last}",
            f"Cost: {terms}; failed runs {tuned.cost.failed:g}",
            f"Mean cost on these runs: {tuned.before:.6g} before, {tuned.after:.6g} after",
            f"Budget: {about['evaluations']} evaluations by {about['engine']}, seed {about['seed']}",
            "Versions: " + ", ".join(f"{name} {version}" for name, version in about["versions"].items()),
        ]
    )
