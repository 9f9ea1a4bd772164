"""The command ``robotics dataset formation``: data of formations, the thesis's and one's own, and scenarios of those.

One's own is a leader on any path and followers in a wedge or abreast, written as the text of a scenario's file.
"""

import json
import re
import shlex
from collections.abc import Mapping
from dataclasses import dataclass
from functools import partial
from math import ceil, pi
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, Literal

from fuzzy.errors import InputError
from fuzzy.files.atomic import check_target, write_whole
from fuzzy.naming import check_known, expected
from fuzzy.quantity import check_quantities, described, quantity, whole
from fuzzy.shell.options import FieldOptions, Json, Quiet, Shown, option
from fuzzy.shell.progress import progress_bar
from fuzzy.shell.terminal import print_json
from robotics.commands.completion import controllers, scenarios
from robotics.simulation.scenario.description import ScenarioError
from robotics.simulation.scenario.reading import load_scenario, parse_scenario, scenario_from_table
from robotics.tables.template import toml_value
from robotics.tables.text import parse_table, read_text
from robotics.world.paths.path import shapes

if TYPE_CHECKING:
    from robotics.plugins.learning.formationdata import FormationRecipe
    from robotics.plugins.learning.scenariodata import ScenarioRecipe
    from robotics.simulation.scenario.description import Scenario

_OF_SCENARIO = ("teacher", "inputs", "runs", "displaced")
_OF_PLAN = ("amplitude", "wavelength", "path", "spacing", "followers", "arrangement")
_OF_THESIS = ("kind", "formations", "coverage", "jitter")
_OF_BOTH = ("seed", "samples", "lateral", "heading", "lead")  # recipes, the thesis's and a scenario's
# The order in which a card's command has them
_ORDER = (
    *("scenario", *_OF_SCENARIO, *_OF_PLAN, "save_scenario", "kind", "check", "seed", "samples", "formations", "speed"),
    *("coverage", "jitter", "lateral", "heading", "lead"),
)


def formation(
    *,
    out: Annotated[Path, option("File into which the table goes.", "--out", "-o", "FILE.csv")],
    scenario: Annotated[
        str | None, option("Scenario to make data of: a name, or a .toml file.", "SCENARIO", autocompletion=scenarios)
    ] = None,
    recipe: Annotated[
        "partial[ScenarioRecipe]",
        FieldOptions(
            "robotics.plugins.learning.scenariodata:ScenarioRecipe",
            *(*_OF_SCENARIO, *_OF_BOTH),
            given=True,
            of="scenario",
            teacher=Shown(complete=controllers),
            inputs=Shown(metavar="A,B,..."),
            runs=Shown("--seeds"),
            seed=Shown(doc="Seed of the displacements and of the cover. Default: 0"),
            samples=Shown(doc="Number of rows, 2000 of a scenario; 400 of each formation of the thesis."),
            lateral=Shown(doc="Largest displacement aside, m. Default: 0.1; of a scenario 0.15"),
            heading=Shown(doc="Largest rotation, rad. Default: 0.15; of a scenario 0.3"),
            lead=Shown(doc="Largest displacement along the path, m. Default: 0.5; of a scenario 0.4"),
        ),
    ],
    plan: Annotated[
        "partial[FormationPlan]",
        FieldOptions(
            "robotics.plugins.learning.commands_dataset_formation:FormationPlan",
            *(*_OF_PLAN, "speed"),
            given=True,
            path=Shown(metavar="SHAPE:NAME=VALUE,..."),
            speed=Shown(doc="Desired speed v_d, m/s. Default: 0.1; with --path and so on 0.2"),
        ),
    ],
    save_scenario: Annotated[
        Path | None, option("Write the scenario of these options, to be run.", "FILE.toml")
    ] = None,
    thesis: Annotated[
        "partial[FormationRecipe]",
        FieldOptions(
            "robotics.plugins.learning.formationdata:FormationRecipe",
            *("kind", "coverage", "jitter", "speed", *_OF_BOTH),
            given=True,
            of="thesis",
        ),
    ],
    formations: Annotated[
        str | None, option("thesis: the leader's x at the start, m. Default: -4,-2,0,2,4", "X,X,...")
    ] = None,
    check: Annotated[bool, option("Make the checking set: other seeds; thesis: the leader starts at -1.")] = False,
    json: Json = False,
    quiet: Quiet = False,
) -> None:
    """Make data of leader-follower formations: what robots know, and what a law makes them do then.

    With --scenario, or a formation given by --path, --followers and so on, the columns are named by robot, as v_2.
    Without either they are those of the thesis: what all robots do, by the leader's posture. FILE.card.md says what is
    in the file, and how it was made. The same options give the same file.

    \b
    Example:
      robotics dataset formation --path eight:width=10 --followers 4 --save-scenario mine.toml -o mine.csv
    """
    given = {**recipe.keywords, **plan.keywords, **thesis.keywords}
    for name, value in {"scenario": scenario, "save_scenario": save_scenario, "formations": formations}.items():
        given |= {} if value is None else {name: value}
    check_target(out, ".csv")
    own = [n for n in (*_OF_SCENARIO, *_OF_PLAN, "scenario", "save_scenario") if n in given]
    of_thesis = [n for n in _OF_THESIS if n in given]
    if own and of_thesis:
        first, second = _option(own[0]), of_thesis[0]
        raise InputError(f"--{first} is of a formation of one's own, --{second} of the thesis's: give one")
    command = _command(given, check, out)
    if not own:
        _thesis_set(thesis, given, check, out, command, json)
        return
    planned = [n for n in (*_OF_PLAN, "speed", "save_scenario") if n in given]
    if scenario is not None and planned:
        raise InputError(f"give --scenario or --{_option(planned[0])}, not both: the scenario says it")
    made = recipe()
    setting = load_scenario(scenario) if scenario is not None else _planned_scenario(plan(), save_scenario)
    _scenario_set(setting, made, check, out, command, json, quiet)


def _thesis_set(
    thesis: "partial[FormationRecipe]", given: Mapping[str, Any], check: bool, out: Path, command: str, json: bool
) -> None:
    """Make, write and tell of a set of the thesis's kinds."""
    from robotics.plugins.learning.datacard import thesis_facts, write_set
    from robotics.plugins.learning.formationdata import checking_recipe, formation_data
    from robotics.plugins.learning.scatter import DRAWS, NEIGHBOURS, SHARE, scatter

    kind = given.get("kind", "literal")
    own = [n for n in ("coverage", "jitter", "lateral", "heading", "lead") if n in given]
    if kind == "literal" and own:
        raise InputError(f"--{own[0]} belongs to --kind well-posed; literal data have nothing random")
    if check and "formations" in given:
        raise InputError("--check is the formation with the leader at -1: give it or --formations, not both")
    if kind == "well-posed" and "formations" in given and "coverage" not in given:
        raise InputError("--formations needs --coverage below 1: without it no sample lies along a formation's run")
    recipe = thesis(starts=_numbers(given["formations"])) if "formations" in given else thesis()
    seed, recipe = recipe.seed, checking_recipe(recipe) if check else recipe
    table = formation_data(recipe)
    card = write_set(out, thesis_facts(recipe, command), table.columns, table.values)
    inputs, outputs = table.inputs, table.names[len(table.inputs) :]
    found = None
    plenty = len(table.values) * SHARE > NEIGHBOURS
    # One formation alone never contradicts itself, nor does the well-posed law
    if kind == "literal" and not check and plenty:
        found = scatter(table.values[:, : len(inputs)], table.values[:, len(inputs) :])
    if json:
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


def _scenario_set(
    scenario: "Scenario", recipe: "ScenarioRecipe", check: bool, out: Path, command: str, json: bool, quiet: bool
) -> None:
    """Make, write and tell of a set of a scenario."""
    from robotics.plugins.learning.datacard import robot_facts, write_set
    from robotics.plugins.learning.scenariodata import checking_set, passes, scenario_data
    from robotics.studies.versions import versions

    recipe = checking_set(recipe) if check else recipe
    with progress_bar(quiet) as begin:
        table = scenario_data(scenario, recipe, begin(f"{scenario.name}: {recipe.teacher}", passes(recipe)))
    facts = robot_facts(scenario, recipe, command)
    facts |= {"versions": ", ".join(f"{name} {number}" for name, number in versions().items())}
    card = write_set(out, facts, table.columns, table.values)
    if json:
        print_json(
            {"file": str(out), "card": str(card), "scenario": scenario.name, "teacher": recipe.teacher}
            | {"check": check, "seed": recipe.seed, "rows": len(table.values), "robots": table.robots}
            | {"inputs": table.quantities, "columns": table.names}
        )
        return
    print(
        f"{out}: {len(table.values)} rows of {table.robots} robots, each with the inputs {', '.join(table.quantities)} "
        f"and the outputs v, w; {card} says more"
    )


def _planned_scenario(plan: "FormationPlan", file: Path | None) -> "Scenario":
    """The scenario of a formation, saved if wished."""
    text = formation_text(plan)
    if file is not None:
        check_target(file, ".toml")
        write_whole(file, text)
    return parse_scenario(text, file.stem if file is not None else "formation")


def _command(given: Mapping[str, Any], check: bool, out: Path) -> str:
    """The command line that makes the same file, whose own folder is left out."""
    words = ["robotics", "dataset", "formation"]
    for name in _ORDER:
        if name == "check":
            words += ["--check"] if check else []
        elif name in given and (name != "seed" or given[name]):
            value = given[name]
            words += [f"--{_option(name)}", ",".join(value) if isinstance(value, tuple) else str(value)]
    return shlex.join([*words, "-o", out.name])


def _option(name: str) -> str:
    return "seeds" if name == "runs" else name.replace("_", "-")


def _numbers(text: str) -> tuple[float, ...]:
    try:
        return tuple(float(part) for part in text.split(","))
    except ValueError:
        raise InputError(f"--formations must be numbers in m with commas between them, got {text!r}") from None


_SPARE = 1.25  # the scenario's duration over that of its timing: the leader waits for followers at times
_PART = re.compile(r"\s*(\w+)\s*=\s*([^,]+?)\s*")


@dataclass(frozen=True, kw_only=True)
class FormationPlan:
    """What a formation is made of. Raises ScenarioError for numbers out of their ranges."""

    amplitude: float = quantity(0.5, "m", least=0, doc="Amplitude of the leader's sine.")
    wavelength: float = quantity(6.0, "m", above=0, doc="Wavelength of the leader's sine, of which it drives two.")
    path: str = described("Path in its place: circle:radius=2, eight:width=8, or a .toml file's.", "")
    followers: int = whole(2, least=1, most=30, doc="Number of followers.")
    spacing: float = quantity(0.6, "m", above=0, doc="Spacing of the rows, and of the robots in a row.")
    speed: float = quantity(0.2, "m/s", above=0, doc="Speed of the leader.")
    arrangement: Literal["wedge", "abreast"] = described("The shape of the formation.", "wedge")

    def __post_init__(self) -> None:
        check_quantities(self, ScenarioError)
        check_known(self.arrangement, ("wedge", "abreast"), "arrangement", ScenarioError)

    @property
    def offsets(self) -> list[tuple[float, float]]:
        """The places of all robots, the leader first: m ahead of it, and to its left."""
        rows = [(k // 2 + 1, 1 if k % 2 == 0 else -1) for k in range(self.followers)]
        back = self.spacing if self.arrangement == "wedge" else 0.0
        return [(0.0, 0.0), *((-row * back, side * row * self.spacing) for row, side in rows)]


def path_table(specification: str) -> dict[str, Any]:
    """The table of a path "SHAPE:name=number,...", such as "circle:radius=2", or that of the leader of a .toml file.

    Raises ScenarioError.
    """
    if specification.endswith(".toml"):
        table = parse_table(read_text(Path(specification), ScenarioError), specification, ScenarioError)
        members = table.get("robots")
        owner = table.get("virtual", members[0] if isinstance(members, list) and members else {})
        if not isinstance(owner, dict) or not isinstance(owner.get("path"), dict):
            raise ScenarioError(f"{specification}: it has no [virtual] and no [[robots]] with a path")
        return dict(owner["path"])
    shape, _, rest = specification.partition(":")
    if shape.strip() not in shapes():
        raise ScenarioError(expected(shape.strip(), shapes(), "path shape") + "; or the path of a .toml file")
    table = {"shape": shape.strip()}
    for part in filter(None, (p.strip() for p in rest.split(","))):
        found = _PART.fullmatch(part)
        if not found:
            raise ScenarioError(f"a path is SHAPE:name=value,name=value, such as circle:radius=2; got {part!r}")
        try:
            table[found[1]] = float(found[2])
        except ValueError:
            table[found[1]] = found[2]
    return table


def formation_text(plan: FormationPlan) -> str:
    """The text of the scenario's file. Raises ScenarioError where it cannot be driven, which names what is wrong."""
    if plan.path:
        path, what = path_table(plan.path), f"on {plan.path}"
    else:
        sine = {"amplitude": plan.amplitude, "wavenumber": 2 * pi / plan.wavelength, "x_end": 2 * plan.wavelength}
        path, what = {"shape": "sine", **sine}, f"on a sine of {plan.amplitude:g} m, {plan.wavelength:g} m long"
    followers = f"{plan.followers} follower{'s' * (plan.followers > 1)}"
    arranged = "in a wedge" if plan.arrangement == "wedge" else "abreast"
    lines = [
        'kind = "formation"',
        f"title = {json.dumps(f'A leader {what}, {followers} {arranged}')}",
        f'source = "robotics dataset formation; {plan.spacing:g} m apart, {plan.speed:g} m/s; noise: 3 mm, 3 mrad"',
        "duration = DURATION",
        'controller = "leader-follower"',
        "",
        "[sensing]",
        'posture = "pose"',
        "position_noise = 0.003",
        "heading_noise = 0.003",
        "",
        "[virtual] # offsets are measured from where this one is: m ahead, m to the left",
        f"path = {toml_value(path)}",
        f"timing = {{ speed = {plan.speed!r} }}",
    ]
    for i, (ahead, left) in enumerate(plan.offsets):
        lines += ["", "[[robots]]" + (" # the leader" if i == 0 else ""), f"offset = [{ahead!r}, {left!r}]"]
    text = "\n".join(lines) + "\n"
    try:
        short = parse_table(text.replace("DURATION", "1.0"), "formation", ScenarioError)
        needed = scenario_from_table(short, "formation").setting.references.ends.max()
    except InputError as error:
        places = ", ".join(f"[{ahead:g}, {left:g}]" for ahead, left in plan.offsets)
        raise ScenarioError(
            f"this formation, with robots at {places} m, cannot be driven: {error}; a smaller spacing, fewer "
            "followers, a wider path or a lower speed may do"
        ) from None
    return text.replace("DURATION", f"{ceil(_SPARE * float(needed) + 5.0):.1f}")
