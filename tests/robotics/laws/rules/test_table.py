"""The page of what a robot can know is what the tables say, and its example drives."""

import os
import re
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
import shapely

import fuzzy
import robotics
from robotics.laws.law import ControllerError
from robotics.laws.rules import fuzzy_team, own_rules
from robotics.laws.rules.own_rules import OwnRules
from robotics.laws.rules.quantities import (
    PATTERNS,
    QUANTITIES_PAGE,
    QUANTITY_GROUPS,
    RULE_QUANTITIES,
    Quantity,
    quantity_of,
)
from tests.conftest import module_in

ROOT = Path(__file__).parents[4]
page = module_in(ROOT / "docs" / "reference" / "quantitiespage.py").page

PAIR = """
kind = "team"
duration = 2.0
[[robots]]
start = [0.0, 0.0, 0.0]
path = { shape = "line", start = [0.0, 0.0], end = [4.0, 0.0] }
timing = { duration = 20.0 }
[[robots]]
start = [0.0, 1.0, 0.0]
path = { shape = "line", start = [0.0, 1.0], end = [4.0, 1.0] }
timing = { duration = 20.0 }
"""


def system(inputs: dict[str, tuple[float, float]], outputs: dict[str, float], rules: list[str]) -> fuzzy.Sugeno:
    """Inputs with the terms low and high over their ranges, outputs with one constant, some."""
    terms = {name: {"low": fuzzy.LinearZ(*ends), "high": fuzzy.LinearS(*ends)} for name, ends in inputs.items()}
    return fuzzy.Sugeno(
        inputs=[fuzzy.Variable(name, ends, terms[name]) for name, ends in inputs.items()],
        outputs=[fuzzy.Variable(name, (-5, 5), {"some": value}) for name, value in outputs.items()],
        rules=rules,
    )


def test_the_page_is_what_the_tables_say() -> None:
    assert (ROOT / QUANTITIES_PAGE).read_text(encoding="utf-8") == page(), (
        "python docs/reference/quantitiespage.py > " + QUANTITIES_PAGE
    )


def test_every_name_and_output_has_its_row() -> None:
    rows = [[cell.strip() for cell in line.strip("|").split("|")] for line in page().splitlines() if line[:1] == "|"]
    firsts = [row[0].strip("`") for row in rows]
    for name in (*RULE_QUANTITIES, *PATTERNS, *own_rules.RULE_OUTPUTS):
        assert name in firsts, name
    tasks = {(row[0].strip("*"), row[1].strip("`")) for row in rows if len(row) == 4}
    assert {(task, name) for task, outs in fuzzy_team.TEAM_OUTPUTS.items() for name in outs} <= tasks
    assert max(len(line) for line in page().splitlines() if line[:1] != "|") <= 120


def test_an_unknown_name_points_to_the_page() -> None:
    with pytest.raises(
        ControllerError, match=r"mine: unknown quantity .* 'gapp'; did you mean 'gap'\?.*quantities\.md"
    ):
        quantity_of("gapp", "mine")


def test_what_needs_range_sensors_is_what_they_change() -> None:
    """A robot drives in a closed room, the same way whether its sensors reach the walls or not."""
    room = """
    duration = 3.0
    [[robots]]
    start = [0.0, 0.0, 0.0]
    path = { shape = "line", start = [0.0, 0.0], end = [2.0, 0.1] }
    timing = { speed = 0.3 }
    [[obstacles]]
    shape = "wall"
    points = [[-0.5, -0.4], [1.6, -0.4], [1.3, 0.5], [-0.5, 0.6], [-0.5, -0.4]]
    """
    names = [name for name, q in RULE_QUANTITIES.items() if not q.pair]
    fis = system(dict.fromkeys(names, (-9.0, 9.0)), {"keep": 1.0}, ["if time is low then keep is some"])
    runs = []
    for reach in (2.0, 0.01):
        axes = {"ahead-left": 0.5, "ahead-right": -0.5, "left": 1.5, "right": -1.5, "rear": 3.1}
        own = "".join(f'[[sensors]]\nname = "{name}"\naxis = {a}\nrange = {reach}\n' for name, a in axes.items())
        runs.append(robotics.simulate(robotics.parse_scenario(room + own, "room"), OwnRules(rule_base=fis)))
    seeing, blind = runs
    np.testing.assert_array_equal(seeing["x"], blind["x"])
    changed = {name for k, name in enumerate(names) if (seeing.inputs[:, k] != blind.inputs[:, k]).any()}
    assert changed == {name for name in names if RULE_QUANTITIES[name].ranges}


def test_the_example_of_the_page_keeps_its_formation(tmp_path, monkeypatch) -> None:
    ((text),) = re.findall(r"```python\n(.*?)```", page(), re.DOTALL)
    monkeypatch.chdir(tmp_path)
    made: dict = {}
    exec(text, made)
    run = made["run"]
    dx, dy = (run[axis][0, 0] - run[axis][0, 1] for axis in "xy")
    cos, sin = np.cos(run["heading"][0, 1]), np.sin(run["heading"][0, 1])
    later = run.time > 10
    ahead, left = (cos * dx + sin * dy)[later], (cos * dy - sin * dx)[later]
    assert np.abs(ahead - 0.65).max() < 0.03
    assert np.abs(left).max() < 0.1


def test_a_rule_base_of_pairs_tracks_until_somebody_is_heard() -> None:
    fis = system({"gap": (0.0, 2.0)}, {"v": 0.1}, ["if gap is low then v is some", "if gap is high then v is some"])
    run = robotics.simulate(robotics.parse_scenario(PAIR, "pair"), OwnRules(rule_base=fis))
    assert not run.diverged.any()
    np.testing.assert_allclose(run["v"][0, :, -1], 0.1, atol=0.005)


EAST = """
import sys
import numpy as np
import fuzzy
import robotics
from fuzzy.compiled.jit import compiled_only
from robotics.laws.rules.quantities import QUANTITY_GROUPS, RULE_QUANTITIES, Quantity

@compiled_only
def east(robot, memory, known, i, now):
    return robot.x

RULE_QUANTITIES["east"] = QUANTITY_GROUPS["Its own motion"]["east"] = Quantity("m", "how far east it is", of=east)

from robotics.laws.rules.own_rules import OwnRules

fis = fuzzy.Sugeno(
    inputs=[fuzzy.Variable("east", (0, 2), {"west": fuzzy.LinearZ(0, 2), "east": fuzzy.LinearS(0, 2)})],
    outputs=[fuzzy.Variable("v", (0, 1), {"stop": 0.0, "drive": 1.0})],
    rules=["if east is west then v is drive", "if east is east then v is stop"],
)
run = robotics.simulate(robotics.parse_scenario(sys.argv[1], "pair"), OwnRules(rule_base=fis))
np.testing.assert_allclose(run["x"][0, :, -1], 2 * (1 - np.exp(-4.0 / 2)), atol=0.1)  # x' = 1 - x/2
np.testing.assert_allclose(run.inputs[:, 0, 0, 0], run["x_measured"][0, 0], rtol=1e-6)
"""


@pytest.mark.parametrize("plain", ["1", pytest.param("0", marks=pytest.mark.long)])
def test_a_new_quantity_drives(plain: str) -> None:
    """A toy one: robots slow down towards x = 2 m, as a rule base says that names it; without the compiler, too."""
    scenario = PAIR.replace("duration = 2.0", "duration = 4.0")
    environment = os.environ | {"NUMBA_DISABLE_JIT": plain}
    done = subprocess.run([sys.executable, "-c", EAST, scenario], env=environment, capture_output=True, text=True)
    assert done.returncode == 0, done.stderr


def test_a_new_quantity_stands_on_the_page_and_must_come_before_laws(monkeypatch) -> None:
    made = Quantity("m", "how far east the robot is", of=lambda *_: 0.0)
    monkeypatch.setitem(QUANTITY_GROUPS["Its own motion"], "east", made)
    monkeypatch.setitem(RULE_QUANTITIES, "east", made)
    assert "| `east` | m | how far east the robot is |  |\n" in page()
    law = OwnRules(rule_base=system({"east": (0.0, 2.0)}, {"v": 0.1}, ["if east is low then v is some"]))
    with pytest.raises(ControllerError, match="east was added to RULE_QUANTITIES after a law was imported"):
        robotics.simulate(robotics.parse_scenario(PAIR, "pair"), law)


def test_the_corridor_keeper_of_the_readme_keeps_to_the_middle() -> None:
    fis = fuzzy.Sugeno(
        inputs=[
            fuzzy.Variable(name, (0, 2), {"near": fuzzy.LinearZ(0.1, 0.8), "far": fuzzy.LinearS(0.1, 0.8)})
            for name in ("front_left", "front_right")
        ],
        outputs=[
            fuzzy.Variable("v", (0, 0.5), {"slow": 0.15, "cruise": 0.3}),
            fuzzy.Variable("w", (-1, 1), {"left": 1, "straight": 0, "right": -1}),
        ],
        rules=[
            "if front_left is near and front_right is far then v is slow and w is right",
            "if front_left is far and front_right is near then v is slow and w is left",
            "if front_left is near and front_right is near then v is slow and w is straight",
            "if front_left is far and front_right is far then v is cruise and w is straight",
        ],
    )
    walls = [[-1.0, 0.6], [3.0, 0.6], [8.0, 5.6]], [[-1.0, -0.6], [3.5, -0.6], [8.5, 4.4]]  # with a bend of 45°
    corridor = """
    duration = 35.0
    [[robots]]
    start = [0.0, 0.25, 0.0]
    path = { shape = "line", start = [0.0, 0.25], end = [6.0, 0.25] }
    timing = { speed = 0.3 }
    """ + "".join(f'[[obstacles]]\nshape = "wall"\npoints = {points}\n' for points in walls)
    run = robotics.simulate(robotics.parse_scenario(corridor, "corridor"), OwnRules(rule_base=fis))
    places = shapely.points(run["x"][0, 0], run["y"][0, 0])
    left, right = (shapely.distance(places, shapely.LineString(points)) for points in walls)
    assert np.minimum(left, right).min() > 0.3
    bend = np.abs(run["x"][0, 0] - 3.25) < 0.75
    later = (run.time > 8.0) & ~bend
    assert np.abs(left - right)[later].max() < 0.05
    assert run["x"][0, 0, -1] > 6.0
