"""A floor whose friction differs by place: where patches lie, what they do, and that without them nothing changes."""

from dataclasses import replace
from typing import Any, cast

import matplotlib.path
import numpy as np
import pytest

import robotics
from fuzzy.compiled.jit import kernel
from fuzzy.figures.drawing import style
from robotics.commands.application import main
from robotics.laws.catalogue import make_controller
from robotics.plugins.films.scene import set_scene
from robotics.plugins.identify.replay import Program, ProgramReplay
from robotics.show.playback.replay import replay
from robotics.simulation.physics import PhysicsError
from robotics.simulation.safety.coverage import blind_spots
from robotics.simulation.scenario.robots import load_robot
from robotics.world.vehicle import plant
from robotics.world.vehicle.floor import FloorError, Patch, compiled_floor, friction_at

STAR = ((0.0, 0.0), (2.0, 0.3), (1.0, 0.8), (1.8, 2.0), (0.4, 1.1))
ROBOT = load_robot("etsro").robot
EVERYWHERE = ((-50.0, -50.0), (50.0, -50.0), (50.0, 50.0), (-50.0, 50.0))


@kernel
def _at(floor, x, y, found):
    for i in range(len(x)):
        found[i] = friction_at(floor, x[i], y[i])


def _floor(*patches):
    return compiled_floor(patches, plant.parameters(ROBOT)[:, None])


def test_a_place_is_in_a_polygon_as_matplotlib_says_and_in_a_disc_by_its_distance_and_the_last_patch_counts():
    x, y = np.random.default_rng(1).uniform(-0.5, 2.5, (2, 2000))
    found = np.empty(2000)
    _at(_floor(Patch(friction=0.2, corners=STAR), Patch(friction=3.0, center=(1.0, 1.0), radius=0.5)), x, y, found)
    inside = matplotlib.path.Path(STAR).contains_points(np.stack([x, y], axis=1))
    disc = np.hypot(x - 1, y - 1) <= 0.5
    assert (found == np.where(disc, 3.0, np.where(inside, 0.2, 1.0))).all()
    assert 0 < inside.sum() < 2000


def _driven(scenario, robot=ROBOT, law="fuzzy", **changes):
    told = robotics.load_scenario(scenario)
    told = replace(told, robots=tuple(replace(member, robot=robot) for member in told.robots), duration=4.0, **changes)
    return robotics.simulate(told, law, [0])


@pytest.mark.parametrize("law", ["fuzzy", ProgramReplay(program=Program(*np.array([[0.0], [0.4], [1.5]])))])
def test_a_patch_everywhere_is_another_robot_and_one_of_friction_1_is_none(law):
    """Both in the compiled loop and in that of laws in Python, to the last bit."""
    slips = ROBOT.changed(longitudinal_slip=0.02, lateral_slip=0.01, castor_drag=0.5, kp=ROBOT.kp, ki=ROBOT.ki)
    halved = {"longitudinal_slip": 0.04, "lateral_slip": 0.02, "castor_drag": 0.25}
    other = slips.changed(torque_limit=slips.torque_limit / 2, **halved)
    assert (other.kp, other.ki, other.kd) == (slips.kp, slips.ki, slips.kd)
    plain = _driven("fuzzy-off-path", slips, law)
    same = _driven("fuzzy-off-path", slips, law, patches=(Patch(friction=1.0, corners=EVERYWHERE),))
    slippery = _driven("fuzzy-off-path", slips, law, patches=(Patch(friction=0.5, corners=EVERYWHERE),))
    assert (same["x"] == plain["x"]).all()
    assert np.abs(slippery["x"] - plain["x"]).max() > 1e-3
    assert (slippery["x"] == _driven("fuzzy-off-path", other, law)["x"]).all()


def test_on_ice_it_speeds_up_by_what_the_tyres_hold():
    """2 f τ / r − 2 τ_f / r over the moved mass, in a patch; out of it as before."""
    program = Program(np.array([0.0]), np.array([0.6]), np.array([0.0]))
    patch = Patch(friction=0.1, center=(0.0, 0.0), radius=0.1)
    told = replace(
        robotics.load_scenario("fuzzy-off-path"), patches=(patch,), duration=4.0, latency=0.0, divergence=1e3
    )
    start = replace(told.robots[0], start=(0.0, 0.0, 0.0), robot=ROBOT)
    run = robotics.simulate(replace(told, robots=(start,)), ProgramReplay(program=program), [0])
    x, v = run["x"][0, 0], run["v"][0, 0]
    inside = np.flatnonzero((x > 0.03) & (x < 0.09))
    gained = np.diff(v[inside]) / 0.05
    expected = 2 * (0.1 * ROBOT.torque_limit - ROBOT.friction_torque) / ROBOT.wheel_radius / ROBOT.effective_mass
    assert len(inside) > 4
    assert gained == pytest.approx(expected, rel=0.01)
    after = np.flatnonzero(x > 0.1)[0]
    assert (v[after + 2] - v[after + 1]) / 0.05 > 2 * expected


@pytest.mark.parametrize(
    ("given", "sentence"),
    [
        ({}, "a patch is a disc, which needs center and radius, or a polygon"),
        ({"center": (0.0, 0.0)}, "a patch is a disc"),
        ({"center": (0.0, 0.0), "radius": 1.0, "corners": STAR}, "a patch is a disc"),
        ({"corners": STAR[:2]}, r"corners must be at least 3 points \[x, y\] in m, got 2"),
        ({"corners": ((0.0, 0.0), (1.0, float("nan")), (0.0, 1.0))}, r"corners must be \[x, y\], finite numbers in m"),
        ({"center": (0.0, 0.0), "radius": -1.0}, "radius must be .*> 0"),
        ({"corners": STAR, "friction": 0.0}, "friction must be .*>= 0.01 and <= 10"),
    ],
)
def test_a_patch_that_cannot_be_is_refused(given, sentence):
    with pytest.raises(FloorError, match=sentence):
        Patch(**{"friction": 0.5, **given})


ICE = """title = "Over ice"
duration = 3.0
sensors = [{ preset = "lidar" }]
[[patches]]
friction = 0.2
center = [1.0, 0.0]
radius = 0.5
[[obstacles]]
shape = "disc"
position = [5.0, 3.0]
[[robots]]
start = [0.0, 0.0, 0.0]
path = { shape = "line", start = [0.0, 0.0], end = [2.0, 0.0] }
timing = { speed = 0.3 }
"""


@pytest.mark.long
def test_pictures_show_patches(tmp_path):
    file = tmp_path / "ice.toml"
    file.write_text(ICE, encoding="utf-8")
    assert main(["run", str(file), "--plot", str(tmp_path / "run.svg"), "--quiet", "--json"]) == 0
    assert main(["check", str(file), "-o", str(tmp_path / "check.svg")]) == 1  # fuzzy drives blind
    for picture in ("run.svg", "check.svg"):
        assert "friction × 0.2" in (tmp_path / picture).read_text(encoding="utf-8")


def test_films_show_patches_hatched_with_their_friction_where_it_is_seen():
    told = robotics.parse_scenario(ICE.replace("center = [1.0, 0.0]", "center = [1.0, 0.4]"), "ice")
    run = robotics.simulate(replace(told, duration=1.0), "fuzzy", [0])
    with style():
        figure = set_scene(replay(run, run.time), 1.0, 80).figure
    view = figure.axes[0]
    (patch,) = [part for part in view.patches if part.get_hatch()]
    assert np.hypot(*(cast(Any, patch).get_xy() - [1.0, 0.4]).T) == pytest.approx(0.5)
    (words,) = [text for text in view.texts if "friction" in text.get_text()]
    assert words.get_text() == "friction × 0.2"
    assert view.get_xlim()[0] < words.get_position()[0] < view.get_xlim()[1]
    assert view.get_ylim()[0] <= words.get_position()[1] < view.get_ylim()[1]
    assert "hatched floor: other friction" in " ".join(text.get_text() for text in figure.texts)


def test_a_file_has_patches_and_sentences_of_them(tmp_path, capsys):
    file, run = tmp_path / "ice.toml", tmp_path / "run.npz"
    file.write_text(ICE, encoding="utf-8")
    told = robotics.load_scenario(file)
    (said,) = blind_spots(told.setting, make_controller("fuzzy:safe=yes"))
    assert "it is proven of one floor, and this one has patches, the most slippery of friction 0.2" in said
    robotics.simulate(told, "fuzzy", [0]).save(run)
    assert robotics.load_run(run).about.patches == told.patches
    with pytest.raises(PhysicsError, match="has patches of another friction, and mujoco knows none"):
        robotics.simulate(told, "fuzzy", [0], plant="mujoco")
    file.write_text('plant = "kinematic"\n' + ICE, encoding="utf-8")
    assert main(["run", str(file)]) == 2
    assert 'patches of the floor are for plant = "dynamic"' in capsys.readouterr().err
    file.write_text(ICE.replace("radius = 0.5\n", ""), encoding="utf-8")
    assert main(["run", str(file)]) == 2
    assert "ice.toml:" in (said := capsys.readouterr().err)
    assert "which needs center and radius" in said
