"""The keys of files as data: what is listed is what the readers accept, schemas and commented files say the same."""

import copy
import re
import tomllib
from importlib import resources
from pathlib import Path
from typing import Any

import pytest

from fuzzy.errors import InputError
from robotics.commands.filekinds import FILE_KINDS
from robotics.simulation.scenario.keys import scenario_table
from robotics.simulation.scenario.reading import parse_scenario, scenario_file, scenario_from_table, scenario_names
from robotics.simulation.scenario.survey import survey_text
from robotics.tables.keys import KeyUnknownError, Placed, find, walk
from robotics.tables.schema import schema_of
from robotics.tables.template import commented_file

LINE = {"shape": "line", "start": [0.0, 0.0], "end": [5.0, 0.0]}
BASE: dict[str, Any] = {"robots": [{"start": [0.0, 0.0, 0.0], "path": LINE, "timing": {"speed": 0.1}}]}
ALL = list(walk(scenario_table()))


@pytest.fixture(autouse=True)
def files(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """The files that examples name."""
    (tmp_path / "lap.csv").write_text("x,y\n0,0\n1,0\n2,1\n", encoding="utf-8")
    monkeypatch.chdir(tmp_path)


def place(key: Placed) -> tuple[dict[str, Any], list[Any]]:
    """A scenario's table with all tables around ``key``, and the keys that lead to its table."""
    table, names = copy.deepcopy(BASE), key.path.split(".")[:-1]
    node: Any = table
    at: list[Any] = []
    if key.path.startswith("robots.goal"):
        table |= {"kind": "goal", "robots": [{"start": [0.0, 0.0, 0.0]}]}
        moves = names[2:3] in (["path"], ["timing"]) or key.key.name in ("path", "timing")
        table["robots"][0]["goal"] = {"path": dict(LINE), "timing": {"speed": 0.1}} if moves else {"at": [1.0, 0.0]}
    if names[:1] == ["virtual"]:
        table["robots"] = [{"offset": [0.0, 0.1]}]
        table["virtual"] = {"path": dict(LINE), "timing": {"speed": 0.1}}
    for depth, name in enumerate(names, start=1):
        inner = find(scenario_table(), ".".join(names[:depth]))[0].key
        assert inner.table is not None
        if name not in node:
            made: Any = {k.name: k.shown for k in inner.table.keys if k.required and k.table is None}
            if inner.table.name == "sensors":
                made = {"name": "rear"}
            if inner.table.name == "robot":
                made = {"model": "etsro"}
            if inner.table.name in ("path", "timing") and names[0] == "obstacles":
                node |= {"path": dict(LINE), "timing": {"speed": 0.1}}
            node.setdefault(name, [made] if inner.holds == "tables" else made)
        node, at = node[name], [*at, name]
        if inner.holds == "tables":
            node, at = node[0], [*at, 0]
        if depth == len(names) and key.shape:
            node.clear()
            node["shape"] = key.shape
            node |= {k.name: k.shown for k in inner.table.shapes[key.shape] if k.required}
    return table, at


def inside(table: Any, at: list[Any]) -> Any:
    for key in at:
        table = table[key]
    return table


def test_every_key_bears_a_sentence():
    lacking = [
        p.path for kind in FILE_KINDS.values() for p in walk(kind.table()) if not p.key.doc.endswith((".", "..."))
    ]
    own = [path for path in lacking if not re.match(r"(robots\.)?robot\.", path)]  # the robot's are its own business
    assert own == []


@pytest.mark.parametrize("key", [p for p in ALL if p.key.table is not None] + ALL[:1], ids=lambda p: p.path)
def test_the_reader_accepts_in_every_table_the_keys_that_are_listed_and_no_others(key: Any) -> None:
    """The reader lists what it accepts where it refuses a key that no table has."""
    shapes: Any
    if key is ALL[0]:
        table, names, shapes = copy.deepcopy(BASE), {k.name for k in scenario_table().keys}, {"": ()}
        at: list[Any] = []
    else:
        names, shapes = {k.name for k in key.key.table.keys}, key.key.table.shapes or {"": ()}
    for shape, own in shapes.items():
        if key is not ALL[0]:
            table, at = place(Placed(f"{key.path}.nonsense", "", shape, key.key))
        inside(table, at)["nonsense"] = 1
        with pytest.raises(InputError) as caught:
            scenario_from_table(table, "t")
        known = set(str(caught.value).partition("Known: ")[2].split(", "))
        listed = names | {k.name for k in own}
        if key.path == "robots":
            listed -= {"nonsense"}
        assert known == listed, (key.path, shape)
        assert caught.value.at == (*at, "nonsense")


def test_every_default_is_accepted_and_a_value_of_another_type_names_key_and_line():
    seen = set()
    for p in ALL:
        known = (p.key.name, p.shape, p.marked.rpartition(".")[2])
        if p.key.table is not None or known in seen:  # the same table in another place
            continue
        seen.add(known)
        table, at = place(p)
        here = inside(table, at)
        if p.key.default is not None and not p.key.words:
            here[p.key.name] = p.key.default
            scenario_from_table(table, "t")
        here[p.key.name] = {"a": "table"}
        with pytest.raises(InputError) as caught:
            scenario_from_table(table, "t")
        assert caught.value.at[: len(at) + 1] in ((*at, p.key.name), tuple(at)), p.path
        assert p.key.name in str(caught.value), p.path


def test_names_are_found_by_their_end_and_mistyped_ones_are_guessed():
    assert [p.path for p in find(scenario_table(), "timing.speed")] == ["robots.timing.speed"]
    assert [p.path for p in find(scenario_table(), "[radio] loss")] == ["radio.loss"]
    assert {p.path for p in find(scenario_table(), "radio")} >= {"radio", "radio.loss", "radio.graph"}
    with pytest.raises(KeyUnknownError, match=r"did you mean 'robots\.timing\.speed'"):
        find(scenario_table(), "robots.timing.sped")


# Schemas ---------------------------------------------------------------------------------------------------------

BROKEN = {
    "unknown key": ("duration = ", "lenght = 3\nduration = "),
    "text for a number": ("duration = 90.0", 'duration = "90"'),
    "below its range": ("position_noise = 0.003", "position_noise = -0.003"),
    "above its range": ("heading_noise = 0.003", "heading_noise = 4.0"),
    "unknown word": ('kind = "team"', 'kind = "teem"'),
    "unknown shape": ('shape = "line"', 'shape = "spline"'),
    "key of another shape": ("start = [-1.0, 0.0], ", "start = [-1.0, 0.0], amplitude = 1.0, "),
    "point of three": ("end = [7.46, 0.0]", "end = [7.46, 0.0, 0.0]"),
    "two timings": ("timing = { duration = 44.4 }", "timing = { duration = 44.4, speed = 0.2 }"),
    "no timing": ("timing = { duration = 44.4 }\n\n", "\n\n"),
    "unknown graph": ('graph = "complete"', 'graph = "star-like"'),
}


def packaged(name: str) -> str:
    return scenario_file(name).text


def test_packaged_files_are_valid_by_the_schema_and_broken_ones_are_not():
    jsonschema = pytest.importorskip("jsonschema")
    validator = jsonschema.Draft202012Validator
    for name, kind in FILE_KINDS.items():
        validator.check_schema(schema_of(kind.table(), name))
    scenario = validator(schema_of(scenario_table(), "scenario"))
    for name in scenario_names():
        scenario.validate(tomllib.loads(packaged(name)))
    for before, after in BROKEN.values():
        text = packaged("three-cross").replace(before, after, 1)
        assert text != packaged("three-cross")
        assert not scenario.is_valid(tomllib.loads(text)), after
    sweep = validator(schema_of(FILE_KINDS["sweep"].table(), "sweep"))
    text = (resources.files("robotics") / "data" / "sweeps" / "lyapunov-gains.toml").read_text(encoding="utf-8")
    sweep.validate(tomllib.loads(text))
    assert not sweep.is_valid(tomllib.loads(text.replace("seeds = 10", "seeds = 0")))


@pytest.mark.parametrize(("before", "after"), BROKEN.values(), ids=BROKEN)
def test_the_reader_refuses_what_the_schema_refuses(before, after):
    with pytest.raises(InputError):
        parse_scenario(packaged("three-cross").replace(before, after, 1), "t")


# Files to begin with ---------------------------------------------------------------------------------------------


@pytest.mark.parametrize("name", FILE_KINDS)
def test_a_commented_file_runs_and_all_its_optional_lines_at_once_do_too(name):
    kind = FILE_KINDS[name]
    for variant, values in kind.values.items():
        if variant == "formation":  # below: it takes seconds
            continue
        text = commented_file(kind.table(), values, kind.read, kind.title)
        assert tomllib.loads(text) == tomllib.loads(commented_file(kind.table(), values, kind.read, minimal=True))
        full = re.sub(r"^#(?!#|or |:)", "", text, flags=re.MULTILINE)  # every optional line set
        kind.read(full)
        assert len(full) < len(text)
        assert tomllib.loads(full) != tomllib.loads(text)
        assert max(map(len, text.splitlines())) <= 120


def test_a_minimal_file_of_a_formation_is_read():
    kind = FILE_KINDS["scenario"]
    text = commented_file(kind.table(), kind.values["formation"], kind.read, minimal=True)
    assert "#" not in text
    assert len(kind.read(text).robots) == 3


# All faults at once ----------------------------------------------------------------------------------------------


def test_all_faults_of_a_file_are_told_and_the_rest_is_read():
    text = packaged("three-cross").replace('kind = "team"', 'kind = "team"\nspeed = 3')
    text = text.replace("position_noise = 0.003", 'position_noise = "much"').replace('graph = "complete"', "los = 0.1")
    text = text.replace('shape = "line"', 'shape = "spline"')
    found = survey_text(text, "t")
    told = {(fault.at, found.line(fault.at)) for fault in found.faults}
    lines = text.splitlines()
    assert {at for at, _ in told} == {
        ("speed",),
        ("sensing", "position_noise"),
        ("radio", "los"),
        ("robots", 1, "path", "shape"),
    }
    for at, line in told:
        assert str(at[-1]) in lines[line - 1]
    assert found.scenario is not None
    assert found.robots == (0, 2)
    assert found.controller == "right-of-way"


def test_a_file_without_faults_has_none_and_an_infeasible_one_is_read():
    assert survey_text(packaged("trap-u"), "t").faults == ()
    fast = survey_text(packaged("lyapunov-sine").replace("x_rate = 0.3", "x_rate = 3.0"), "t")
    assert fast.faults == ()
    assert fast.scenario is not None
