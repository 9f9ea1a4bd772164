"""MuJoCo as the plant: against our own where both must agree, and against closed forms where ours says nothing."""

import json
import sys
from dataclasses import dataclass, replace
from math import sin
from typing import Any, cast
from xml.etree import ElementTree

import numpy as np
import pytest

from robotics import load_robot, load_run, load_scenario, simulate
from robotics.commands.application import main
from robotics.laws.law import Command, Law
from robotics.plugins.films.animation import AnimationError
from robotics.plugins.identify.replay import COMMAND_PERIOD, Program, replayed
from robotics.plugins.mujoco.mjcf import Ground, scene
from robotics.simulation.physics import PhysicsError, physics_of
from robotics.simulation.scenario.reading import parse_scenario
from robotics.world.vehicle.robot import GRAVITY

ETSRO = load_robot("etsro").robot
LINE = """
duration = 4.0
divergence = 100
[[robots]]
start = [0.0, 0.0, 0.0]
path = { shape = "line", start = [0.0, 0.0], end = [20.0, 0.0] }
timing = { speed = 0.3 }
"""
BOX = '\n[[obstacles]]\nshape = "box"\nlength = 0.2\nwidth = 0.3\nposition = [0.6, 0.0]\n'


@dataclass(frozen=True)
class Coast(Law[None]):
    """Motors without torque."""

    level = "torque"

    def control(self, seen, memory, dt):
        nothing = np.zeros_like(seen.x)
        return Command(nothing, nothing, nothing, nothing), None


def held(v, w, seconds):
    time = np.arange(0.0, seconds, COMMAND_PERIOD)
    return Program(time, np.full(len(time), v), np.full(len(time), w))


def test_the_scene_has_the_robots_masses():
    for name in ("etsro", "turtlebot3-burger", "pioneer-3dx"):
        robot = load_robot(name).robot
        tree = ElementTree.fromstring(scene((robot, robot), None, Ground()))
        assert sum(float(each.get("mass")) for each in tree.iter("inertial")) == pytest.approx(2 * robot.mass)
        assert len(tree.findall("actuator/general")) == 4


@pytest.mark.parametrize(
    ("plant", "message"),
    [
        ("bullet", "unknown plant 'bullet'.*mujoco"),
        ("mujoco:grip=1", "plant mujoco: unknown option 'grip'"),
        ("mujoco:friction=wet", "friction must be a finite number, > 0 and <= 5; got 'wet'"),
        ("mujoco:friction=-1", "friction must be a finite number, > 0 and <= 5"),
        ("mujoco:step=0.0019", "step must be a part of 10 ms"),
    ],
)
def test_what_is_no_plant_is_said(plant, message):
    with pytest.raises(PhysicsError, match=message):
        physics_of(plant)


def test_what_it_cannot_move_and_what_is_not_installed_is_said(monkeypatch):
    with pytest.raises(PhysicsError, match='plant = "dynamic"'):
        simulate(replace(load_scenario("lyapunov-sine"), plant="kinematic"), "lyapunov", plant="mujoco")
    moving = LINE + '[[obstacles]]\nshape = "disc"\npath = { shape = "line", start = [1, 1], end = [2, 1] }\n'
    with pytest.raises(PhysicsError, match="an obstacle moves by itself"):
        simulate(parse_scenario(moving + "timing = { speed = 0.1 }\n", "one"), "lyapunov", plant="mujoco")
    monkeypatch.setitem(sys.modules, "mujoco", None)
    with pytest.raises(PhysicsError, match="needs MuJoCo: pip install"):
        simulate(load_scenario("lyapunov-sine"), "lyapunov", plant="mujoco")


def test_a_film_needs_the_plant(tmp_path, capsys):
    assert main(["run", "lyapunov-sine", "--film", str(tmp_path / "film.gif")]) == 2
    assert "--film needs --plant mujoco" in capsys.readouterr().err


class TestDriven:
    """With the package."""

    @pytest.fixture(autouse=True)
    def package(self):
        self.mujoco = pytest.importorskip("mujoco")

    @pytest.mark.parametrize("name", ["etsro", "pioneer-3dx"])
    def test_a_robot_has_the_inertia_of_its_file(self, name):
        """About the vertical through the middle of the axle: of all bodies, by MuJoCo's own mass matrix."""
        robot = load_robot(name).robot
        model = self.mujoco.MjModel.from_xml_string(scene((robot,), None, Ground()))
        data = self.mujoco.MjData(model)
        self.mujoco.mj_forward(model, data)
        whole = np.zeros((model.nv, model.nv))
        self.mujoco.mj_fullM(model, data, whole)
        assert whole[0, 0] == pytest.approx(robot.mass)
        assert whole[5, 5] == pytest.approx(robot.yaw_inertia, rel=0.01)

    def test_a_law_drives_it_as_our_own_plant(self):
        """On the sine of 25 s, within 30 mm always and 5 mm rms; a robot is 230 mm long."""
        scenario = load_scenario("lyapunov-sine")
        own, other = (simulate(scenario, "lyapunov", plant=plant) for plant in ("", "mujoco"))
        apart = np.hypot(own["x"] - other["x"], own["y"] - other["y"])
        assert 0 < apart.max() < 0.03
        assert np.sqrt((apart**2).mean()) < 0.005
        assert other.scenario == "lyapunov-sine in mujoco"
        again = simulate(scenario, "lyapunov", [0, 1], plant="mujoco")
        assert np.array_equal(again["x"][0], other["x"][0]), "a run is the same beside others"

    @pytest.mark.parametrize(("v", "w"), [(0.3, 0.0), (0.0, 1.5), (0.3, 1.0)])
    def test_commands_lead_where_they_lead_in_our_own_plant(self, v, w):
        """Open loop over 4 s: the way and the turn within 2 %, where wheels grip."""
        ends = []
        for plant in ("", "mujoco:friction=3"):
            run = replayed(ETSRO, held(v, w, 4.0), latency=0.1, plant=plant)
            ends.append([run[name][0, 0, -1] for name in ("x", "y", "heading")])
            assert np.abs(run["v"][0, 0, :2]).max() < 5e-3  # of latency, in which it sits down on its castor
        assert ends[1] == pytest.approx(ends[0], rel=0.02, abs=0.004)

    def test_it_rolls_down_a_slope_as_a_body_on_wheels(self):
        """a = (m g sin α - 2 τ/r) / (m + 2 J/r²), with motors that give no torque."""
        slope, robot = 0.1, ETSRO.changed(mass_offset=0.0)
        scenario = parse_scenario(LINE.replace("duration = 4.0", "duration = 1.0"), "one")
        scenario = replace(scenario, robots=(replace(scenario.robots[0], robot=robot),))
        run = simulate(scenario, Coast(), plant=f"mujoco:slope={slope},castor_friction=0")
        force = robot.mass * GRAVITY * sin(slope) - 2 * robot.friction_torque / robot.wheel_radius
        assert run["v"][0, 0, -1] / 1.0 == pytest.approx(-force / robot.effective_mass, rel=0.02)

    def test_a_castor_that_drags_stays_on_the_floor(self):
        """A steady drive is steady: as stiff as a wheel, the castor bounced, and the speed went by 5 % up and down."""
        robot = ETSRO.changed(mass_offset=-0.034)
        run = replayed(robot, held(0.3, 0.0, 3.0), plant="mujoco:castor_friction=0.2")
        assert np.ptp(run["v"][0, 0, -20:]) < 1e-3
        assert run["v"][0, 0, -1] == pytest.approx(0.3, rel=5e-3)

    def test_on_ice_it_speeds_up_no_faster_than_friction_allows(self):
        """a <= μ g; the wheels turn ahead of the floor, and what odometry tells is wrong by it."""
        run = replayed(ETSRO, held(0.5, 0.0, 2.0), plant="mujoco:friction=0.02,castor_friction=0")
        steady = run["v"][0, 0]
        assert 0.5 * 0.02 * GRAVITY < steady[20] / 1.0 < 0.02 * GRAVITY * 1.02
        assert run.encoders[20, 2, 0, 0] > 2 * steady[20]

    def test_it_pushes_what_is_light_and_stands_before_what_is_fixed(self):
        scenario = parse_scenario(LINE + BOX, "one")
        edge = 0.6 - 0.1 - ETSRO.length / 2
        ends = [
            float(simulate(scenario, "lyapunov", plant=plant)["x"][0, 0, -1])
            for plant in ("mujoco", "mujoco:obstacle_mass=0.3")
        ]
        assert ends[0] == pytest.approx(edge, abs=0.02)
        assert ends[1] > edge + 0.2

    def test_torques_are_held_by_a_drive(self):
        scenario = replace(load_scenario("lyapunov-sine"), duration=5.0)
        own, other = (simulate(scenario, "csm", plant=plant) for plant in ("", "mujoco"))
        assert own.level == "torque"
        assert np.hypot(own["x"] - other["x"], own["y"] - other["y"]).max() < 0.02

    def test_a_team_drives_in_one_world(self):
        """Robots that hear each other, and would push each other if they touched."""
        scenario = replace(load_scenario("formation-triangle"), duration=5.0)
        own, other = (simulate(scenario, "formation", plant=plant) for plant in ("", "mujoco"))
        assert np.hypot(own["x"] - other["x"], own["y"] - other["y"]).max() < 0.03

    def test_the_command(self, capsys):
        assert main(["run", "lyapunov-sine", "--controller", "lyapunov", "--plant", "mujoco", "--json", "-q"]) == 0
        told = json.loads(capsys.readouterr().out)
        assert told["scenario"] == "lyapunov-sine in mujoco"
        assert told["metrics"]["rms_cross_track_under_way_m"][0] < 0.003

    @pytest.mark.long
    def test_a_film_shows_the_robot_on_its_way(self, tmp_path):
        """By MuJoCo's renderer: what is blue moves to the right by what the robot drives."""
        pytest.importorskip("OpenGL")
        from PIL import Image

        file, scenario = tmp_path / "film.gif", tmp_path / "line.toml"
        scenario.write_text(LINE.replace("4.0", "1.0").replace("20.0", "1.0"), encoding="utf-8")
        try:
            cast(Any, physics_of("mujoco")).filmed("mujoco", file)
        except PhysicsError as error:
            pytest.skip(str(error))
        words = ["run", str(scenario), "--controller", "lyapunov", "--plant", "mujoco", "--film", str(file)]
        assert main([*words, "--save", str(tmp_path / "run.npz"), "--quiet"]) == 0
        places = []
        with Image.open(file) as film:
            frames = cast(Any, film).n_frames
            for k in (0, frames - 1):
                film.seek(k)
                red, _, blue = np.moveaxis(np.asarray(film.convert("RGB")).astype(int), -1, 0)
                places.append(np.nonzero(blue - red > 60)[1].mean())
        driven = np.ptp(load_run(tmp_path / "run.npz")["x"])
        assert frames == 11
        # The camera sees 1.25 m times the proportions of the picture, or more where things are near
        assert (places[1] - places[0]) / 960 * 1.25 == pytest.approx(driven, rel=0.25)

    def test_without_opengl_a_film_says_what_to_install(self, monkeypatch, tmp_path):
        monkeypatch.delenv("MUJOCO_GL", raising=False)
        monkeypatch.setattr("robotics.plugins.mujoco.film.find_library", lambda name: None)
        with pytest.raises(PhysicsError, match="apt install libosmesa6"):
            cast(Any, physics_of("mujoco")).filmed("mujoco", tmp_path / "film.gif")
        with pytest.raises(AnimationError, match=r"robotics animate makes \.html"):
            cast(Any, physics_of("mujoco")).filmed("mujoco", tmp_path / "film.html")
