"""The command ``robotics dataset formation``: data of formations, the thesis's and one's own."""

import shlex
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from fuzzy.errors import InputError
from fuzzy.files.atomic import check_target, replacing
from fuzzy.shell.progress import progress_bar
from fuzzy.shell.terminal import print_json
from robotics.commands.completion import controllers, scenarios
from robotics.commands.shared import Json, Quiet

if TYPE_CHECKING:
    from robotics.scenario.description import Scenario

_OF_SCENARIO = ("teacher", "inputs", "runs", "displaced")
_OF_PLAN = ("amplitude", "wavelength", "path", "spacing", "followers", "arrangement")
_OF_THESIS = ("kind", "formations", "coverage", "jitter")


def formation(
    out: Annotated[Path, typer.Option("--out", "-o", metavar="FILE.csv", help="File into which the table goes.")],
    scenario: Annotated[
        str | None,
        typer.Option(
            metavar="SCENARIO", help="Scenario to make data of: a name, or a .toml file.", autocompletion=scenarios
        ),
    ] = None,
    teacher: Annotated[
        str | None,
        typer.Option(
            help="scenario: the law that drives, name or name:gain=value,... Default: leader-follower",
            autocompletion=controllers,
        ),
    ] = None,
    inputs: Annotated[
        str | None,
        typer.Option(
            metavar="A,B,...",
            help="scenario: quantities that each robot's networks know (docs/quantities.md). Default: "
            "leader_ahead,stretch,onward_bearing for leader-follower (with curvature for other formation laws), "
            "x_err,y_err,heading_err,target_v,target_w for laws that follow a timing.",
        ),
    ] = None,
    runs: Annotated[
        int | None, typer.Option("--seeds", help="scenario: runs from its own starts, one a seed. Default: 2")
    ] = None,
    displaced: Annotated[
        float | None, typer.Option(help="scenario: share of rows in which robots come back. Default: 0.5")
    ] = None,
    amplitude: Annotated[float | None, typer.Option(help="Amplitude of the leader's sine, m. Default: 0.5")] = None,
    wavelength: Annotated[float | None, typer.Option(help="Wavelength of it, m; two of it. Default: 6")] = None,
    path: Annotated[
        str | None,
        typer.Option(
            metavar="SHAPE:NAME=VALUE,...", help="Path in its place: circle:radius=2, eight:width=8, or a .toml file's."
        ),
    ] = None,
    spacing: Annotated[float | None, typer.Option(help="Spacing of rows and of robots, m. Default: 0.6")] = None,
    followers: Annotated[int | None, typer.Option(help="Number of followers. Default: 2")] = None,
    arrangement: Annotated[str | None, typer.Option(help="wedge or abreast. Default: wedge")] = None,
    save_scenario: Annotated[
        Path | None, typer.Option(metavar="FILE.toml", help="Write the scenario of these options, to be run.")
    ] = None,
    kind: Annotated[
        str | None, typer.Option(help="The thesis's formations: literal, or well-posed (with the lead dx).")
    ] = None,
    check: Annotated[
        bool, typer.Option("--check", help="Make the checking set: other seeds; thesis: the leader starts at -1.")
    ] = False,
    seed: Annotated[int, typer.Option(help="Seed of the displacements and of the cover.")] = 0,
    samples: Annotated[
        int | None, typer.Option(help="Number of rows, 2000 of a scenario; 400 of each formation of the thesis.")
    ] = None,
    formations: Annotated[
        str | None, typer.Option(metavar="X,X,...", help="thesis: the leader's x at the start, m. Default: -4,-2,0,2,4")
    ] = None,
    speed: Annotated[
        float | None, typer.Option(help="Desired speed v_d, m/s. Default: 0.1; with --path and so on 0.2")
    ] = None,
    coverage: Annotated[
        float | None, typer.Option(help="well-posed: share spread over (x_l, dx), the rest along runs. Default: 1")
    ] = None,
    jitter: Annotated[float | None, typer.Option(help="well-posed: share displaced. Default: 0.6")] = None,
    lateral: Annotated[
        float | None, typer.Option(help="Largest displacement aside, m. Default: 0.1; of a scenario 0.15")
    ] = None,
    heading: Annotated[
        float | None, typer.Option(help="Largest rotation, rad. Default: 0.15; of a scenario 0.3")
    ] = None,
    lead: Annotated[
        float | None, typer.Option(help="Largest displacement along the path, m. Default: 0.5; of a scenario 0.4")
    ] = None,
    json: Json = False,
    quiet: Quiet = False,
) -> None:
    """Make data of leader-follower formations: what robots know, and what a law makes them do then.

    Of a --scenario, or of a formation given by --path, --followers and so on, the columns are named by robot, as v_2.
    Without either they are those of the thesis: what all robots do, by the leader's posture. FILE.card.md says what is
    in the file, and how it was made. The same options give the same file.

    \b
    Example:
      robotics dataset formation --path eight:width=10 --followers 4 --save-scenario mine.toml -o mine.csv
    """
    given = {name: value for name, value in locals().items() if value is not None}
    check_target(out, ".csv")
    own = [n for n in (*_OF_SCENARIO, *_OF_PLAN, "scenario", "save_scenario") if n in given]
    thesis = [n for n in _OF_THESIS if n in given]
    if own and thesis:
        raise InputError(f"--{_option(own[0])} is of a formation of one's own, --{thesis[0]} of the thesis's: give one")
    if not own:
        _thesis_set(given)
        return
    planned = [n for n in (*_OF_PLAN, "speed", "save_scenario") if n in given]
    if scenario is not None and planned:
        raise InputError(f"give --scenario or --{_option(planned[0])}, not both: the scenario says it")
    _scenario_set(given)


def _thesis_set(given: dict[str, Any]) -> None:
    """Make, write and tell of a set of the thesis's kinds."""
    from robotics.experiments.learning.datacard import thesis_columns, thesis_facts, write_card
    from robotics.experiments.learning.formationdata import FormationRecipe, checking_recipe, formation_data, write_data
    from robotics.experiments.learning.scatter import DRAWS, NEIGHBOURS, SHARE, scatter

    out, kind, check, seed = given["out"], given.get("kind", "literal"), given["check"], given["seed"]
    own: dict[str, Any] = {n: given[n] for n in ("coverage", "jitter", "lateral", "heading", "lead") if n in given}
    if kind == "literal" and own:
        raise InputError(f"--{next(iter(own))} belongs to --kind well-posed; literal data have nothing random")
    if check and "formations" in given:
        raise InputError("--check is the formation with the leader at -1: give it or --formations, not both")
    if kind == "well-posed" and "formations" in given and "coverage" not in given:
        raise InputError("--formations needs --coverage below 1: without it no sample lies along a formation's run")
    own |= {n: given[n] for n in ("speed", "samples") if n in given}
    if "formations" in given:
        own["starts"] = _numbers(given["formations"])
    recipe = FormationRecipe(kind=kind, seed=seed, **own)
    recipe = checking_recipe(recipe) if check else recipe
    table = formation_data(recipe)
    write_data(out, table.names, table.values)
    card = write_card(out, thesis_facts(recipe, _command(given)), thesis_columns(table), table.values)
    inputs, outputs = table.names[: table.inputs], table.names[table.inputs :]
    found = None
    plenty = len(table.values) * SHARE > NEIGHBOURS
    if (
        kind == "literal" and not check and plenty
    ):  # one formation alone never contradicts itself, nor does the well-posed law
        found = scatter(table.values[:, : table.inputs], table.values[:, table.inputs :])
    if given["json"]:
        about = {"file": str(out), "kind": kind, "check": check, "seed": seed, "rows": len(table.values)}
        said = None
        if found is not None:
            rows = zip(outputs, *found, strict=True)
            said = {name: dict(zip(found._fields, map(float, row), strict=True)) for name, *row in rows}
        print_json(about | {"inputs": inputs, "outputs": outputs, "scatter": said, "card": str(card)})
        return
    print(f"{out}: {len(table.values)} rows, inputs {', '.join(inputs)}, outputs {', '.join(outputs)}")
    if found is not None:
        shown = ", ".join(f"{n} {r:.4f} ({a:.4f} to {b:.4f})" for n, r, a, b in zip(outputs, *found, strict=True))
        print(
            f"At equal inputs outputs scatter by about (RMS; Gamma test, mean and range of {DRAWS} draws): {shown}\n"
            "A smooth function errs by about that on fresh samples. A training error below it tells rows apart whose "
            "inputs are all but equal."
        )


def _scenario_set(given: dict[str, Any]) -> None:
    """Make, write and tell of a set of a scenario."""
    from robotics.experiments.learning.datacard import robot_columns, robot_facts, write_card
    from robotics.experiments.learning.formationdata import write_data
    from robotics.experiments.learning.scenariodata import (
        ScenarioRecipe,
        checking_set,
        passes,
        scenario_data,
    )
    from robotics.experiments.versions import versions

    names = ("teacher", "runs", "displaced", "seed", "samples", "lateral", "heading", "lead")
    own = {n: given[n] for n in names if n in given}
    if "inputs" in given:
        own["inputs"] = tuple(part.strip() for part in given["inputs"].split(",") if part.strip())
    recipe = ScenarioRecipe(**own)
    recipe = checking_set(recipe) if given["check"] else recipe
    scenario = _scenario(given)
    with progress_bar(given["quiet"]) as begin:
        table = scenario_data(scenario, recipe, begin(f"{scenario.name}: {recipe.teacher}", passes(recipe)))
    out = given["out"]
    write_data(out, table.names, table.values)
    facts = robot_facts(scenario, recipe, _command(given))
    facts |= {"versions": ", ".join(f"{name} {number}" for name, number in versions().items())}
    card = write_card(out, facts, robot_columns(table), table.values)
    if given["json"]:
        print_json(
            {"file": str(out), "card": str(card), "scenario": scenario.name, "teacher": recipe.teacher}
            | {"check": given["check"], "seed": recipe.seed, "rows": len(table.values), "robots": table.robots}
            | {"inputs": table.inputs, "columns": table.names}
        )
        return
    print(
        f"{out}: {len(table.values)} rows of {table.robots} robots, each with the inputs {', '.join(table.inputs)} and "
        f"the outputs v, w; {card} says more"
    )


def _scenario(given: dict[str, Any]) -> "Scenario":
    """The scenario that is named, or made of the other options and saved if wished."""
    from robotics.scenario.formationtext import FormationPlan, formation_text
    from robotics.scenario.reading import load_scenario, parse_scenario

    if "scenario" in given:
        return load_scenario(given["scenario"])
    plan = FormationPlan(**{n: given[n] for n in (*_OF_PLAN, "speed") if n in given})
    text, file = formation_text(plan), given.get("save_scenario")
    if file is not None:
        check_target(file, ".toml")
        with replacing(file) as temporary:
            temporary.write_text(text, encoding="utf-8", newline="\n")
    return parse_scenario(text, file.stem if file is not None else "formation")


def _command(given: dict[str, Any]) -> str:
    """The command line that makes the same file, whose own folder is left out."""
    words = ["robotics", "dataset", "formation"]
    for name, value in given.items():
        if value is True and name == "check":
            words.append("--check")
        elif name not in ("out", "check", "json", "quiet", "seed") or (name == "seed" and value):
            words += [f"--{_option(name)}", str(value)]
    return shlex.join([*words, "-o", given["out"].name])


def _option(name: str) -> str:
    return "seeds" if name == "runs" else name.replace("_", "-")


def _numbers(text: str) -> tuple[float, ...]:
    try:
        return tuple(float(part) for part in text.split(","))
    except ValueError:
        raise InputError(f"--formations must be numbers in m with commas between them, got {text!r}") from None
