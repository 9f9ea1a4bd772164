"""CONTRIBUTING's table is true: what it names exists, and a toy one of each row is registered as it says, and used."""

import json
import os
import re
import signal
import subprocess
import sys
import urllib.request
from contextlib import contextmanager
from dataclasses import dataclass, fields
from importlib import metadata
from math import asinh, sqrt
from pathlib import Path
from typing import ClassVar

import numpy as np
import pandas as pd
import pytest

from fuzzy.quantity import check_quantities, quantity
from robotics.commands.application import main
from robotics.laws.catalogue import CATALOGUE, Preset, make_controller
from robotics.laws.law import Command, Law
from robotics.measures.clearance import clearances
from robotics.measures.evidence import Part, exact
from robotics.measures.registry import measure_all
from robotics.measures.tracking import METRICS, Metric
from robotics.plugins.designer.tryout import TryoutTrial, rival_data
from robotics.show.playback.player import player_data
from robotics.show.report.chapter import Chapter, Claim, Grid, Picture
from robotics.show.report.study import write_study
from robotics.simulation.loop import simulate
from robotics.simulation.run import load_run
from robotics.simulation.scenario.description import ScenarioError
from robotics.simulation.scenario.reading import parse_scenario
from robotics.world.environment.collision import footprints, obstacle_clearance, obstacle_contacts
from robotics.world.environment.world import OBSTACLES, Obstacle, Piece, outlines
from robotics.world.paths.path import SHAPES, PathError
from robotics.world.sensing.sonar import SENSOR_PRESETS, RangeSensor
from robotics.world.vehicle import plant
from robotics.world.vehicle.plant import ParameterColumns as Parameters
from robotics.world.vehicle.robot import ALTERNATIVES, Robot
from tests.robotics.world.sensing.echoes import exact_echoes
from tests.robotics.world.vehicle.etsro import ETSRO

ROOT = Path(__file__).parent.parent
PAGE = (ROOT / "CONTRIBUTING.md").read_text(encoding="utf-8")
ROWS = {  # by what is added: what is touched, and what proves it
    cells[0]: cells[1:]
    for line in PAGE.splitlines()
    if line.startswith("| ") and "---" not in line and (cells := [cell.strip() for cell in line.strip("|").split("|")])
}
PROVEN = (
    "a membership function",
    "a law",
    "a team law",
    "a sensor",
    "a recorded channel",
    "a metric",
    "an obstacle",
    "a path shape",
    "a robot parameter",
    "a quantity that a robot can know",
    "a report chapter",
    "a designer panel",
    "a learning method",
)

HEAD = "duration = 4.0\n"
ROBOT = """
[[robots]]
start = [0.0, 0.0, 0.0]
path = { shape = "line", start = [0.0, 0.0], end = [2.0, 0.0] }
timing = { speed = 0.3 }
"""
DISC = '\n[[obstacles]]\nshape = "disc"\nposition = [1.5, 0.0]\nradius = 0.2\n'
PLACE = (np.array([[0.0]]), np.array([[0.0]]), np.array([[0.0]]))  # x, y, heading of one robot at the origin


# The table -------------------------------------------------------------------------------------------------------


def named(cell):
    """The code spans of a cell."""
    return re.findall(r"`([^`]+)`", cell)


def test_every_kind_of_contribution_has_its_row_and_its_proof():
    assert set(PROVEN) <= set(ROWS)
    for name in PROVEN:
        touched, proof = ROWS[name]
        assert any("::" in span for span in named(proof)), name
        assert any((ROOT / span).exists() for span in named(touched)), name


@pytest.mark.parametrize("name", ROWS)
def test_files_tables_and_tests_of_a_row_exist(name):
    touched, proof = ROWS[name]
    spans = named(touched)
    files = [ROOT / span for span in spans if "/" in span or span.endswith(".toml")]
    words = [span.removeprefix("@") for span in spans if ROOT / span not in files]
    for file in files:
        assert file.exists(), file
    text = "".join(file.read_text(encoding="utf-8") for file in files if file.is_file())
    for word in words:
        assert re.search(rf"(?<!\w){re.escape(word)}(?!\w)", text), f"{name}: {word} is in none of the files named"
    for test in named(proof):
        path, _, function = test.partition("::")
        assert (ROOT / path).is_file(), test
        assert not function or f"def {function}(" in (ROOT / path).read_text(encoding="utf-8"), test


# A sensor --------------------------------------------------------------------------------------------------------


@dataclass(frozen=True)
class Shy(Law[None]):
    """Drive straight on until something is near."""

    needs: ClassVar[tuple[str, ...]] = ("nose",)

    def init(self, setting, runs):
        return None

    def control(self, seen, memory, dt):
        near = seen.x < 0 if seen.ranges is None else seen.ranges["nose"] < 0.4
        v, w = np.where(near, 0.0, 0.3), np.zeros_like(seen.x)
        return Command(v, w, v, w), None


def test_a_sensor(monkeypatch, tmp_path):
    """In a scenario's file, read, recorded, heeded by a law, saved, and shown."""
    nose = RangeSensor(x=0.115, range=0.8)
    monkeypatch.setitem(SENSOR_PRESETS, "bumper", {"nose": nose})
    monkeypatch.setitem(CATALOGUE, "shy", Preset(Shy, {}, "Shy", "made up"))
    first, rest = 'controller = "shy"\nduration = 6.0\n', ROBOT + DISC
    with pytest.raises(ScenarioError, match="robot 1 lacks the range sensor nose that Shy needs"):
        parse_scenario(first + rest, "one")
    scenario = parse_scenario(first + '[[sensors]]\npreset = "bumper"\n' + rest, "one")
    run = simulate(scenario, make_controller(scenario.controller), name="shy")
    gap = 1.5 - 0.2 - 0.115 - run["x"][0, 0]
    np.testing.assert_allclose(run.ranges[:, 0, 0, 0], np.where(gap <= 0.8, gap, np.inf), atol=1e-6)
    assert 0.3 < gap[-1] < 0.4  # it stopped, a little after it saw that it had to
    run.save(tmp_path / "run.npz")
    again = load_run(tmp_path / "run.npz")
    assert again.about.sensors == ({"nose": nose},)
    assert (again.ranges == run.ranges).all()
    assert player_data(again)["sonar"]["sensors"] == [[[0.115, 0.0, 0.0, 0.0, 0.8]]]


# A team law ------------------------------------------------------------------------------------------------------


@dataclass(frozen=True)
class Abreast(Law[None]):
    """Drive straight on, each as fast as makes up for what the others are ahead, by what they say."""

    message: ClassVar[tuple[str, ...]] = ("x",)

    def init(self, setting, runs):
        return None

    def control(self, seen, memory, dt):
        ahead = np.where(np.isfinite(seen.heard.age), seen.heard["x"] - seen.x[:, :, None], 0.0).sum(axis=2)
        v, w = np.clip(0.2 + ahead, 0.0, 0.5), np.zeros_like(seen.x)
        return Command(v, w, v, w, {"x": seen.x}), None


def test_a_team_law(monkeypatch, tmp_path, capsys):
    """Named in a scenario's file, run by a command, and the robots hear each other."""
    monkeypatch.setitem(CATALOGUE, "abreast", Preset(Abreast, {}, "Abreast", "made up", "team"))
    robot = ROBOT.replace("speed = 0.3", "duration = 8.0")
    behind = robot.replace("[0.0, 0.0, 0.0]", "[-0.5, 1.0, 0.0]").replace(
        "0.0], end = [2.0, 0.0]", "1.0], end = [2, 1]"
    )
    (tmp_path / "two.toml").write_text('kind = "team"\ncontroller = "abreast"\n' + HEAD + robot + behind)
    assert main(["run", str(tmp_path / "two.toml"), "--save", str(tmp_path / "run.npz"), "--json", "-q"]) == 0
    assert json.loads(capsys.readouterr().out)["controller"] == "abreast"
    x = load_run(tmp_path / "run.npz")["x"][0]
    gap = x[0] - x[1]
    assert gap[0] == 0.5
    assert abs(gap[-1]) < 0.02
    with pytest.raises(ScenarioError, match="a team needs at least two robots"):
        parse_scenario('kind = "team"\ncontroller = "abreast"\n' + HEAD + robot, "one")


# A metric --------------------------------------------------------------------------------------------------------


def test_a_metric(monkeypatch, tmp_path, capsys):
    """Measured, printed, in the tables of a comparison, in its report, and in the designer's "Try it"."""
    entry = Metric(
        lambda run: np.nanmax(run["v"], axis=-1),
        "m/s",
        "highest speed",
        headline=("tracking",),
        short="top speed",
        tried=("tracking",),
    )
    monkeypatch.setitem(METRICS, "top_speed_mps", entry)
    monkeypatch.setattr("robotics.show.report.plates.DPI", 30)
    file = tmp_path / "one.toml"
    file.write_text(HEAD + ROBOT)
    run = simulate(parse_scenario(HEAD + ROBOT, "one"), make_controller("lyapunov"))
    (top,) = measure_all(run)["top_speed_mps"][0]
    assert top == run["v"].max()
    assert main(["run", str(file), "-c", "lyapunov", "--json", "-q"]) == 0
    assert json.loads(capsys.readouterr().out)["metrics"]["top_speed_mps"] == [top]
    assert main(["run", str(file), "-c", "lyapunov", "-q"]) == 0
    assert re.search(r"^top_speed_mps .* m/s +highest speed$", capsys.readouterr().out, re.MULTILINE)
    out = tmp_path / "out"
    assert main(["compare", str(file), "--controllers", "lyapunov", "--seeds", "1", "--out", str(out), "-q"]) == 0
    assert "top speed" in capsys.readouterr().out
    assert pd.read_csv(out / "results.csv")["top_speed_mps"].tolist() == [top]
    assert "top_speed_mps" in set(pd.read_csv(out / "summary.csv")["metric"])
    assert "highest speed" in (out / "report.html").read_text(encoding="utf-8")
    assert rival_data("lyapunov", TryoutTrial(scenario="fuzzy-on-path"))["metrics"]["top_speed_mps"] > 0


# An obstacle -----------------------------------------------------------------------------------------------------


@dataclass(frozen=True, kw_only=True)
class Dumbbell(Obstacle):
    """Two discs, ``span`` between their centers across the heading."""

    span: float = quantity(1.0, "m", above=0, most=100)
    radius: float = quantity(0.2, "m", above=0, most=100)

    def pieces(self):
        return [Piece([(0.0, side * self.span / 2)], radius=self.radius) for side in (-1, 1)]


def test_an_obstacle(monkeypatch):
    """Read from a file, touched, seen by a sensor, measured, moved, and shown."""
    monkeypatch.setitem(OBSTACLES, "dumbbell", Dumbbell)
    table = '\n[[obstacles]]\nshape = "dumbbell"\nposition = [1.0, 0.0]\nradius = 0.3\n'
    scenario = parse_scenario(HEAD + ROBOT + table, "one")
    assert scenario.obstacles == (Dumbbell(position=(1.0, 0.0), radius=0.3),)
    with pytest.raises(ScenarioError, match=r"one\.toml:11: radius must be a finite number in m, > 0"):
        parse_scenario(HEAD + ROBOT + table.replace("0.3", "-0.3"), "one", "one.toml")
    here, sizes = scenario.setting.world.at(0.0), footprints([ETSRO])
    x, y, heading = PLACE
    assert obstacle_contacts(x + 1.0, y, heading, sizes, here) == [[-1]]  # between the discs
    assert obstacle_contacts(x + 1.0, y + 0.2, heading, sizes, here) == [[0]]
    assert obstacle_clearance(x + 1.0, y, heading, sizes, here)[0, 0] == pytest.approx(
        np.hypot(0.0, 0.5 - ETSRO.width / 2) - 0.3
    )
    eyes = [RangeSensor(range=5.0), RangeSensor(range=5.0, axis=np.arctan2(0.5, 1.0))]
    assert exact_echoes(eyes, *PLACE, sizes, here)[0, 0].tolist() == [np.inf, pytest.approx(np.hypot(0.5, 1.0) - 0.3)]
    run = simulate(scenario, make_controller("lyapunov"))
    assert 0.09 < clearances(run, 0).min() < 0.11  # it drove through the gap of 0.4 m
    assert len(outlines(run.obstacles)) == len(player_data(run)["obstacles"]["bodies"]) == 2
    moving = 'path = { shape = "line", start = [0.0, 0.0], end = [0.0, 5.0] }\ntiming = { speed = 0.5 }\n'
    moved = parse_scenario(HEAD + ROBOT + table + moving + 'orientation = "fixed"\n', "one").setting.world.at(2.0)
    assert sorted(moved.circles[0, :, 1]) == pytest.approx([0.5, 1.5], abs=0.2)  # 1 m on, less its start from rest


# A path shape ----------------------------------------------------------------------------------------------------


@dataclass(frozen=True, kw_only=True)
class Parabola:
    """y = bend · x², from x = 0 to ``extent``."""

    extent: float = quantity(2.0, "m", above=0)
    bend: float = quantity(0.1, "1/m")

    def __post_init__(self):
        check_quantities(self, PathError)

    def curve(self, u):
        x, one = self.extent * u, np.ones_like(u)
        k = 2 * self.bend * self.extent
        return (
            np.stack([x, self.bend * x**2]),
            np.stack([self.extent * one, k * x]),
            k * self.extent * np.stack([0 * u, one]),
        )


def test_a_path_shape(monkeypatch):
    """Read from a file, measured, and driven; an obstacle may move on it too."""
    monkeypatch.setitem(SHAPES, "parabola", Parabola)
    line = 'shape = "line", start = [0.0, 0.0], end = [2.0, 0.0]'
    text = "duration = 8.0\n" + ROBOT.replace(line, 'shape = "parabola", bend = 0.3')
    scenario = parse_scenario(text, "one")
    (path,) = scenario.trajectory.paths
    assert path.length == pytest.approx(sqrt(1 + 1.2**2) + asinh(1.2) / 1.2, abs=1e-9)
    found = path.at(np.linspace(0, path.length, 7))
    np.testing.assert_allclose(found.y, 0.3 * found.x**2, atol=1e-9)
    run = simulate(scenario, make_controller("lyapunov"))
    x, y = run["x"][0, 0], run["y"][0, 0]
    assert x[-1] > 1.9
    assert np.abs(y - 0.3 * x**2).max() < 0.05
    with pytest.raises(ScenarioError, match=r"one\.toml:5: extent must be a finite number in m, > 0"):
        parse_scenario(text.replace("bend = 0.3", "extent = 0.0"), "one", "one.toml")
    disc = DISC + 'path = { shape = "parabola" }\ntiming = { speed = 0.1 }\n'
    assert parse_scenario(text + disc, "one").obstacles[0].path == Parabola()


# A robot parameter -----------------------------------------------------------------------------------------------


@dataclass(frozen=True, kw_only=True)
class Loaded(Robot):
    """A robot with one parameter more, which the plant uses through ``mass``."""

    payload: float = quantity(0.0, "kg", least=0, most=50)

    @property
    def mass(self):
        return super().mass + self.payload


def test_a_robot_parameter(monkeypatch, tmp_path):
    """Read from a file, moved by, saved with a run, loaded, and told in a report."""
    from robotics.show.report.page import _facts

    for place in ("robotics.simulation.scenario.robots", "robotics.simulation.run"):
        monkeypatch.setattr(f"{place}.Robot", Loaded)  # where one that adds it edits the class
    text = HEAD + '[robot]\nmodel = "etsro"\npayload = 5.0\n' + ROBOT
    scenario = parse_scenario(text, "one")
    (robot,) = scenario.setting.robots
    heavier = plant.parameters(robot) - plant.parameters(ETSRO)
    assert np.flatnonzero(heavier).tolist() == [Parameters.mass.row]
    assert heavier[Parameters.mass.row] == pytest.approx(5.0)
    run = simulate(scenario, make_controller("lyapunov"))
    light = simulate(parse_scenario(HEAD + ROBOT, "one"), make_controller("lyapunov"))
    assert 0 < run["v"][0, 0, 1] < 0.8 * light["v"][0, 0, 1]  # it sets off more slowly
    run.save(tmp_path / "run.npz")
    assert load_run(tmp_path / "run.npz").about.robots == (Loaded(**ETSRO.given, payload=5.0),)
    assert "payload 5 kg" in dict(_facts(scenario))["robot"]
    with pytest.raises(ScenarioError, match=r"one\.toml:4: payload must be a finite number in kg, >= 0 and <= 50"):
        parse_scenario(text.replace("5.0", "-5.0"), "one", "one.toml")


@pytest.mark.parametrize("name", [f.name for f in fields(Robot) if f.name not in ALTERNATIVES])
def test_every_robot_parameter_is_read_and_changes_the_plant_or_the_footprint(name):
    usual = getattr(ETSRO, name) or 0.0  # None: a bound that the robot does not have
    value = round(usual * 1.01 + 0.01 * (usual == 0), 9)
    (robot,) = parse_scenario(HEAD + f'[robot]\nmodel = "etsro"\n{name} = {value!r}\n' + ROBOT, "one").setting.robots
    assert robot == ETSRO.changed(**{name: value}) != ETSRO
    same = [np.array_equal(of(robot), of(ETSRO)) for of in (plant.parameters, lambda r: footprints([r]))]
    assert not all(same)


# A report chapter ------------------------------------------------------------------------------------------------


def test_a_report_chapter(monkeypatch, tmp_path):
    """In a study's report: its words, table, picture and claim; the claim in claims.csv too."""
    from fuzzy.figures.drawing import new_figure

    def draw():
        figure = new_figure(2, 1)
        figure.add_subplot().plot([0, 1])
        return figure

    part = Part(
        says="it rises by more than 1 m",
        form="corrected",
        estimate=exact(2.0),
        bound=1.0,
        sense="above",
        unit="m",
        quantity="rise",
        on="the sea",
        of="lyapunov",
    )
    claim = Claim(name="Tides", source="made up", says="The sea rises.", untested="Storms.", parts=(part,))
    grid = Grid("High water", ("hour", "level"), [("6", "2 m")])
    picture = Picture("tides", "The tide", "A line that rises", draw)
    chapter = Chapter("tides", "Of the tides", ("Twice a day.",), [grid], [], [picture], [claim])

    @contextmanager
    def chapters(begin, folder, seed, drawn):
        begin("watching the sea", 1)()
        yield lambda: [chapter]

    monkeypatch.setattr("robotics.show.report.plates.DPI", 30)
    begun = []

    def begin(description, total):
        begun.append(description)
        return lambda: None

    study = write_study(
        tmp_path,
        [parse_scenario(HEAD + ROBOT, "one")],
        ["lyapunov"],
        [0],
        begin=begin,
        chapters=chapters,
    )
    assert begun[0] == "watching the sea"
    assert study.claims == [claim]
    assert pd.read_csv(tmp_path / "claims.csv", keep_default_na=False).to_dict("records") == [claim.row()]
    (row,) = pd.read_csv(tmp_path / "evidence.csv", keep_default_na=False).to_dict("records")
    assert row == claim.evidence()[0]
    assert (tmp_path / "figures" / "tides.png").read_bytes().startswith(b"\x89PNG")
    page = (tmp_path / "report.html").read_text(encoding="utf-8")
    for words in (
        "Of the tides",
        "Twice a day.",
        "High water",
        "The tide",
        "A line that rises",
        "it rises by more than 1 m",
        "2.00 m, asked for &gt; 1 m",
    ):
        assert words in page
    assert "thesis" not in page.lower()


# A designer panel ------------------------------------------------------------------------------------------------

PANEL = '''
class Count:
    """How many rules there are."""

    title, order = "Count the rules", 50

    def build(self, bench):
        def say():
            bench.notify(f"{len(bench.document.design.system.rules)} rules")

        bench.on_change(say)
        say()
'''


@pytest.fixture
def site(tmp_path):
    """A folder of installed packages with one that has a panel."""
    about = tmp_path / "site" / "rule_counter-1.0.dist-info"
    about.mkdir(parents=True)
    (about / "METADATA").write_text("Metadata-Version: 2.1\nName: rule-counter\nVersion: 1.0\n")
    (about / "entry_points.txt").write_text("[fuzzyfleet.designer]\ncount = rule_counter:Count\n")
    (about.parent / "rule_counter.py").write_text(PANEL)
    return about.parent


def test_a_designer_panel_hears_of_edits(site, monkeypatch, tmp_path):
    from robotics.laws.tracking.fuzzy_tracking import load_rule_base
    from tests.test_plugins import said_by_the_panel

    monkeypatch.syspath_prepend(site)
    assert "count" in {point.name for point in metadata.entry_points(group="fuzzyfleet.designer")}
    count = len(load_rule_base("tracking").rules)
    assert said_by_the_panel(tmp_path, "Count the rules") == [f"{count} rules", f"{count - 1} rules"]


@pytest.mark.long
def test_a_designer_panel_is_a_tab(site, tmp_path):
    pytest.importorskip("nicegui", reason="the designer needs the extra design")
    paths = os.pathsep.join([str(site), str(ROOT)])
    start = "import sys; from fuzzy.commands.application import main; sys.exit(main(sys.argv[1:]))"
    clean = {name: value for name, value in os.environ.items() if not name.startswith(("PYTEST", "NICEGUI"))}
    server = subprocess.Popen(
        [sys.executable, "-c", start, "design", "new.fis", "--no-browser"],
        cwd=tmp_path,
        env=clean | {"PYTHONPATH": paths},
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
    )
    try:
        url = re.search(r"http://127\.0\.0\.1:\d+/\S*", server.stdout.readline())
        with urllib.request.urlopen(url[0], timeout=60) as answer:
            page = answer.read().decode()
    finally:
        server.send_signal(signal.SIGINT)
        server.communicate(timeout=60)
    assert "Count the rules" in page
    assert "Surface" in page
