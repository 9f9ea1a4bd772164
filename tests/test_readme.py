"""Every snippet of the README, and the examples in docstrings, run as written."""

import doctest
import importlib
import os
import re
import subprocess
import sys
import tomllib
from pathlib import Path

import numpy as np
import pytest
import shapely

ROOT = Path(__file__).parent.parent
README = (ROOT / "README.md").read_text(encoding="utf-8")
SNIPPETS = [(m[1], m[2]) for m in re.finditer(r"```(\w+)\n(.*?)```", README, re.DOTALL)]


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    return tmp_path_factory.mktemp("readme")


def _run(command, folder):
    # The console scripts of this very environment, whether it is activated or not
    path = os.pathsep.join([str(Path(sys.executable).parent), os.environ["PATH"]])
    done = subprocess.run(
        command, cwd=folder, env={**os.environ, "PATH": path}, capture_output=True, text=True, timeout=240, check=False
    )
    assert done.returncode == 0, done.stderr
    assert "Traceback" not in done.stderr
    return done.stdout


def test_the_readme_has_what_a_newcomer_needs():
    kinds = [kind for kind, _ in SNIPPETS]
    assert kinds.count("python") == 6
    assert kinds.count("sh") == 9
    assert kinds.count("toml") == 2


def test_snippets_run_in_order(folder):
    """One after the other in one folder: later ones use the files of earlier ones."""
    output = ""
    for kind, text in SNIPPETS:
        if kind == "python":
            output += _run([sys.executable, "-c", text], folder)
        elif kind == "sh" and "make " not in text:
            output += _run(["sh", "-e", "-c", text], folder)
        elif file := re.match(r"# ([\w-]+\.toml)", text):
            (folder / file[1]).write_text(text, encoding="utf-8")
    for name in (
        "surface.png",
        "go.fis",
        "memberships.png",
        "run.png",
        "wall-surface.png",
        "wall.png",
        "comparison/report.html",
        "formation.png",
        "sinc.fis",
        "team.png",
        "team.html",
        "crossing-3-A-seed-4.html",
    ):
        assert (folder / name).stat().st_size > 200, name
    _check_the_wall_is_followed(folder)
    assert "within 5 cm of the path after" in output
    assert "virtual-structure  from" in output
    import fuzzy

    with pytest.warns(fuzzy.FisFileWarning, match="hedge"):
        go = fuzzy.read_fis(folder / "go.fis")
    # near and far are 0 and 1 at 1 m; ahead is exp(-0.02); by hand
    ahead, left = 0.9801986733067553, (2 * (0.1 / 1.5) ** 2) ** 2
    expected = (ahead * 0.6 + (1 - ahead) * 0.1) / (ahead + 1 - ahead + 0.5 * left)
    assert float(go([1.0, 0.1])[0]) == pytest.approx(expected, rel=1e-12)


def _check_the_wall_is_followed(folder):
    """The saved run goes round the room, at a distance from its wall that changes little, corners included."""
    from robotics.simulation.run import load_run

    run = load_run(folder / "wall.npz")
    room = tomllib.loads((folder / "wall.toml").read_text(encoding="utf-8"))
    wall = shapely.LineString(room["obstacles"][0]["points"])
    later = run.time > 5.0  # it starts too far away
    places = shapely.points(run["x"][0, 0, later], run["y"][0, 0, later])
    distance = shapely.distance(places, wall)
    assert 0.25 < distance.min() < distance.max() < 0.65
    assert 0.36 < np.median(distance) < 0.46
    along = np.unwrap(shapely.line_locate_point(wall, places), period=wall.length)
    assert along[-1] - along[0] > wall.length


def test_the_sensors_of_the_readme_are_what_a_scenario_takes():
    from robotics.scenario.reading import parse_scenario

    (text,) = (text for kind, text in SNIPPETS if kind == "toml" and "[[sensors]]" in text)
    path = 'path = { shape = "line", start = [0.0, 0.0], end = [2.0, 0.0] }\ntiming = { speed = 0.2 }\n'
    robot = f"[[robots]]\nstart = [0.0, 0.0, 0.0]\n{path}"
    scenario = parse_scenario(text.replace("[[robots]]\n", f"{robot}{robot}"), "readme")
    all_robots, this_robot = scenario.setting.sensors
    assert [s.noise for s in all_robots.values()] == [0.03] * 4 + [0.0]
    assert all_robots["rear"].failure_start == 20.0
    assert {name: s.range for name, s in this_robot.items()} == {"nose": 3.0}


def test_make_targets_named_in_the_readme_exist():
    makefile = (ROOT / "Makefile").read_text(encoding="utf-8")
    for target in re.findall(r"make (\w+)", README):
        assert re.search(rf"^{target}:", makefile, re.MULTILINE), target


@pytest.mark.parametrize("link", re.findall(r"\]\(([\w./]+)\)", README))
def test_links_lead_somewhere(link):
    assert (ROOT / link).exists()


@pytest.mark.parametrize("module", ["fuzzy", "fuzzy.naming", "fuzzy.rule", "robotics", "robotics.commands.compare"])
def test_docstring_examples(module):
    result = doctest.testmod(importlib.import_module(module))
    assert result.attempted > 0
    assert result.failed == 0
