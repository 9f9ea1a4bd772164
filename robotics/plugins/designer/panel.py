"""The designer's panel "Try it": the rule base that is edited drives a robot, anew after every edit.

:class:`robotics.plugins.designer.session.TryoutSession` does the work. The module also generates data for the panel
"Train".
"""

from collections.abc import Sequence
from functools import partial
from pathlib import Path
from typing import Any

from fuzzy.plugins.designer.panel import SessionPanel
from robotics.plugins.designer.driving import drives


def _begin(bench: Any) -> None:
    from robotics.plugins.designer.session import TryoutSession

    TryoutSession(bench)


panel = SessionPanel("Try it", 50, _begin, purpose="robot", suits=drives)


# Data for the panel "Train" -------------------------------------------------------------------------------------


def formation_data() -> Sequence[Any]:
    """Formation data, thesis 5.2.1's and a scenario's, each an anfis.plugins.designer.task.Generator for "Train"."""
    from anfis.plugins.designer.task import Generator

    return [
        Generator("formation-literal", "Formation data, as the thesis describes them", partial(_formation, "literal")),
        Generator("formation-well-posed", "Formation data, well-posed", partial(_formation, "well-posed")),
        Generator("formation-scenario", "Formation data of a scenario ...", _scenario_formation, _scenario_asks),
    ]


def _formation(kind: str) -> Any:
    from fuzzy.plugins.designer.columns import LoadedTable
    from robotics.plugins.learning.formationdata import FILES
    from robotics.plugins.learning.formationdata import formation_data as made

    table = made(FILES[f"formation-{kind}.csv"])
    units = tuple(column.unit for column in table.columns)
    return LoadedTable(f"formation data, {kind}", table.names, table.values, len(table.inputs), units)


def _scenario_asks(folder: Path) -> Any:
    """What is asked before data of a scenario are made: scenario, teacher, robot and output."""
    from anfis.plugins.designer.task import Ask
    from fuzzy.plugins.designer.folder import open_folder
    from robotics.laws.catalogue import presets
    from robotics.plugins.designer.folderfiles import scenario_files
    from robotics.simulation.scenario.reading import scenario_names

    names = [*scenario_files(open_folder(folder)), *scenario_names("formation")]
    taught = [n for n, p in presets().items() if p.kind == "formation" and n != "formation"]
    taught = ["leader-follower", *(n for n in taught if n != "leader-follower"), "lyapunov", "fuzzy"]
    return (
        Ask("scenario", "Scenario", tuple((n, n) for n in names), names[0]),
        Ask("teacher", "Teacher", tuple((n, n) for n in taught), taught[0]),
        Ask("robot", "Robot", (), "2"),
        Ask("output", "Output", (("v", "speed v"), ("w", "turn rate w")), "v"),
    )


def _scenario_formation(folder: Path, chosen: dict[str, str]) -> Any:
    """What one robot of a scenario knows, and what the teacher makes it do: few rows, for the page."""
    from fuzzy.plugins.designer.columns import LoadedTable
    from fuzzy.plugins.designer.folder import open_folder
    from robotics.plugins.designer.conditions import scenario_of
    from robotics.plugins.designer.folderfiles import read_text_file
    from robotics.plugins.designer.uses import TryoutError
    from robotics.plugins.learning.scenariodata import ScenarioRecipe, column, scenario_data

    name, robot = chosen["scenario"], int(chosen["robot"])
    text = read_text_file(open_folder(folder), name).text if name.endswith(".toml") else None
    scenario = scenario_of(name, text, str(folder))
    if robot > len(scenario.robots):
        raise TryoutError(f"{name} has {len(scenario.robots)} robots; got robot {robot}")
    # Robots that come back along the whole way, and no whole run: a page waits for it
    recipe = ScenarioRecipe(teacher=chosen["teacher"], samples=1000, runs=0, places=16, starts=8, displaced=1.0)
    table = scenario_data(scenario, recipe)
    output = column(chosen["output"], robot)
    columns = [*(column(n, robot) for n in table.quantities), output]
    places = [table.names.index(n) for n in columns]
    units = tuple(table.columns[place].unit for place in places)
    names = (*table.quantities, output)
    title = f"{name}, {chosen['teacher']}, robot {robot}"
    return LoadedTable(title, names, table.values[:, places], len(table.quantities), units)
