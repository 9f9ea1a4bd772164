"""A robot identified from a drive: the model against the simulator, the command from end to end, what is not told."""

import json
import re
from pathlib import Path

import numpy as np
import pytest

from robotics.commands.application import main
from robotics.plugins.identify.calibration import track
from robotics.plugins.identify.excitation import excite
from robotics.plugins.identify.model import COORDINATE_NAMES, Stimulus, drive, fields_of, sampled, values_of
from robotics.plugins.identify.replay import COMMAND_PERIOD, Program, replayed, write_drive
from robotics.simulation.scenario.robots import load_robot
from robotics.world.vehicle.robot import Robot

SHEET = load_robot("etsro").robot
HIDDEN = SHEET.changed(kp=0.65, ki=7.0, friction_torque=0.028, v_max=0.35, v_rate_max=1.6, torque_constant=0.11)
LATENCY = 0.13


@pytest.fixture(scope="module")
def program() -> Program:
    return excite(SHEET, 3.0, 24.0).program


@pytest.fixture(scope="module")
def log(program: Program, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The log of a robot that is not its data sheet's, by the simulator's loop with its encoders."""
    file = tmp_path_factory.mktemp("drive") / "drive.csv"
    write_drive(replayed(HIDDEN, program, latency=LATENCY), file)
    return file


@pytest.mark.parametrize("name", ["etsro", "turtlebot3-burger", "pioneer-3dx", "mir100"])
def test_coordinates_and_fields_of_a_robot_are_inverse(name: str) -> None:
    robot = load_robot(name).robot
    own = values_of(robot, 0.1)
    again = robot.changed(**fields_of(robot, own))
    assert values_of(again, 0.1) == pytest.approx(own, rel=1e-6)


def test_a_robot_of_another_mass_that_answers_alike_has_the_same_coordinates() -> None:
    """Twice of every mass, inertia and torque is the same motion."""
    names = ["body_mass", "body_inertia", "wheel_mass", "wheel_inertia", "wheel_spin_inertia"]
    names += ["friction_torque", "torque_limit", "torque_constant"]
    twice = SHEET.changed(**{name: 2 * getattr(SHEET, name) for name in names})
    assert values_of(twice) == pytest.approx(values_of(SHEET))


def test_the_model_is_the_simulators_plant(program: Program) -> None:
    run = replayed(HIDDEN, program, latency=LATENCY)
    assert run.encoders is not None
    given = Stimulus.of(run.time, run["command_1"][0, 0], run["command_2"][0, 0], 0.0, float(run.time[-1]))
    window = np.full(len(run.time), COMMAND_PERIOD)
    own = sampled(drive(SHEET, values_of(HIDDEN, LATENCY)[:, None], given), run.time, window)[:, :, 0]
    count = 2 * np.pi * SHEET.wheel_radius / SHEET.counts_per_turn / COMMAND_PERIOD  # m/s: of one wheel
    wrong = np.abs(own - run.encoders[:, 2:, 0, 0].T)[:, 1:]
    assert wrong[0].max() < 2.5 * count
    assert wrong[1].max() < 2.5 * count / SHEET.half_axle


def test_wheels_that_turn_evenly_lead_along_a_circle() -> None:
    """Of radius b (r + l) / (r - l) around a middle to the left, however far a sample is from the next."""
    half, ways = 0.1, np.array([[0.09], [0.05]]) * np.ones(40)
    radius = half * (0.09 + 0.05) / (0.09 - 0.05)
    x, y, heading = track(np.zeros(3), ways, half)
    assert np.hypot(x, y - radius) == pytest.approx(radius, rel=1e-12)
    assert x == pytest.approx(radius * np.sin(heading))
    assert heading[-1] == pytest.approx(40 * (0.09 - 0.05) / (2 * half))


def test_the_command_finds_the_robot_and_others_take_its_file(
    log: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    file, page = tmp_path / "mine.toml", tmp_path / "fits.html"
    assert main(["identify", str(log), "--robot", "etsro", "-o", str(file), "--page", str(page), "--json"]) == 0
    told = json.loads(capsys.readouterr().out)
    rows = {row["name"]: row for row in told["numbers"]}
    true = dict(zip(COORDINATE_NAMES, values_of(HIDDEN, LATENCY).tolist(), strict=True))
    assert rows["latency"]["value"] == pytest.approx(LATENCY, abs=0.01)
    for name, share in {"lag": 0.1, "friction": 0.15, "v_max": 0.02, "v_rate_max": 0.03, "right_gain": 0.01}.items():
        assert rows[name]["value"] == pytest.approx(true[name], rel=share), name
        assert rows[name]["low"] <= rows[name]["value"] <= rows[name]["high"]
    assert rows["w_rate_max"]["known"] == "above"
    assert rows["w_rate_max"]["high"] is None
    assert rows["counts_per_turn"]["value"] == pytest.approx(SHEET.counts_per_turn, rel=1e-3)
    assert "scale" not in rows, "odometry's own poses tell nothing of its wheels"
    assert any("--pose" in sentence for sentence in told["sentences"])
    found: Robot = load_robot(file).robot
    assert found.v_max == pytest.approx(HIDDEN.v_max, rel=0.02)
    assert found.v_rate_max == pytest.approx(HIDDEN.v_rate_max, rel=0.03)
    assert found.w_rate_max is None
    text = file.read_text(encoding="utf-8")
    assert re.search(r"^v_max = 0\.\d+    # identified: highest speed .* m/s \(.* to .*\)$", text, re.MULTILINE)
    assert re.search(r"^body_mass = 2\.3    # etsro, not identified$", text, re.MULTILINE)
    assert "latency = 0.13" in text
    shown = page.read_text(encoding="utf-8")
    assert "<svg" in shown
    assert "What to drive next" in shown
    assert main(["run", "fuzzy-off-path", "--robot", str(file), "--json", "--quiet"]) == 0
    assert json.loads(capsys.readouterr().out)["diverged"] == [[False]]


def test_another_robot_than_the_scenarios_drives(capsys: pytest.CaptureFixture[str]) -> None:
    found = []
    for words in ([], ["--robot", "pioneer-3dx"]):
        assert main(["run", "fuzzy-off-path", *words, "--json", "--quiet"]) == 0
        found.append(json.loads(capsys.readouterr().out)["metrics"]["rms_cross_track_m"])
    assert found[0] != found[1]
    assert main(["run", "fuzzy-off-path", "--robot", "pioneer"]) == 2
    assert "pioneer-3dx" in capsys.readouterr().err
