"""The commands, each in a process of its own: signals, exit statuses, and a fleet from one line."""

import os
import signal
import subprocess
import sys
from dataclasses import replace

import numpy as np
import pytest

from fuzzyfleet_ros.fleet import commands, node_command
from robotics import load_run, load_scenario, simulate
from tests.ros.together import farthest, simulator, spun


def called(*words, **more):
    return subprocess.run([sys.executable, "-m", *words], capture_output=True, text=True, timeout=120, **more)


@pytest.mark.parametrize(
    ("module", "command", "sentence"),
    [
        (
            "rclpy",
            "controller",
            "rclpy cannot be imported (not here); source the setup file of a ROS 2 installation",
        ),
        ("robotics", "simulator", "robotics cannot be imported (not here); install fuzzyfleet for this Python"),
        ("robotics", "fleet", "robotics cannot be imported (not here); install fuzzyfleet for this Python"),
    ],
)
def test_what_is_missing_is_said(tmp_path, module, command, sentence):
    (tmp_path / f"{module}.py").write_text("raise ImportError('not here')\n", encoding="utf-8")
    path = os.pathsep.join([str(tmp_path), os.environ["PYTHONPATH"]])
    words = ["nowhere"] if command == "fleet" else []
    done = called(f"fuzzyfleet_ros.{command}", *words, env={**os.environ, "PYTHONPATH": path}, cwd=tmp_path)
    assert done.returncode == 2
    said = done.stderr.splitlines()
    assert any(line.startswith(f"{command}: {sentence}") for line in said)
    if module == "robotics":  # which file stands in the way
        assert str(tmp_path / "robotics.py") in done.stderr
    else:
        assert len(said) == 1
    assert "Traceback" not in done.stderr


def test_a_fleet_has_a_simulator_and_a_controller_for_each_robot():
    lines = commands("three-cross", "fuzzy", 3, {"seed": 1}, {"lockstep": True})
    assert [line[2] for line in lines] == ["fuzzyfleet_ros.simulator"] + 3 * ["fuzzyfleet_ros.controller"]
    assert "__ns:=/robot2" in lines[2]
    assert lines[2][-4:] == ["-p", "member:=2", "-p", "lockstep:=true"]
    assert "robot:=" not in " ".join(node_command("simulator", {"robot": ""}))


@pytest.mark.long
def test_a_fleet_of_no_scenario_is_a_sentence():
    done = called("fuzzyfleet_ros.fleet", "nowhere")
    assert done.returncode == 2
    assert done.stderr.startswith("fleet: ")
    assert len(done.stderr.splitlines()) == 1


@pytest.mark.long
@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM])
def test_a_controller_that_is_told_to_end_lets_the_robot_stand(ros, number):
    """The base's own watchdog is off, so that only the controller's last word stops the robot."""
    process = subprocess.Popen(node_command("controller", {"scenario": "reference", "law": "fuzzy"}))
    try:
        with spun(simulator(cmd_vel_timeout=0.0)) as ((node,), until):
            assert until(lambda: node.sensed.speed[0, 0] > 0.1, 60)
            process.send_signal(number)
            assert until(lambda: process.poll() is not None, 20)
            assert process.returncode == 0
            assert until(lambda: abs(node.sensed.speed[0, 0]) < 0.01, 5)
            assert node.loop.outside.order.tolist() == [[0.0], [0.0]]
    finally:
        process.kill()
        process.wait()


@pytest.mark.long
def test_a_controller_that_is_killed_leaves_it_to_the_base(ros):
    for timeout, stops in ((0.5, True), (0.0, False)):
        process = subprocess.Popen(node_command("controller", {"scenario": "reference", "law": "fuzzy"}))
        with spun(simulator(cmd_vel_timeout=timeout)) as ((node,), until):
            assert until(lambda: node.sensed.speed[0, 0] > 0.1, 60)
            process.kill()
            process.wait()
            assert until(lambda: abs(node.sensed.speed[0, 0]) < 0.01, 10.0 if stops else 2.0) == stops


@pytest.mark.long
@pytest.mark.parametrize(
    ("parameters", "sentence"),
    [
        ({"law": "nonsense"}, "nonsense"),
        ({"scenario": "reference", "law": "csm"}, "torque_as_velocity"),
        ({"odom_timeout": -1}, "odom_timeout must be >= 0"),
        ({"law": "[1, 2"}, "Couldn't parse"),
    ],
)
def test_bad_parameters_are_one_sentence_and_no_traceback(ros, parameters, sentence):
    done = subprocess.run(node_command("controller", parameters), capture_output=True, text=True, timeout=60)
    assert done.returncode == 2
    *before, last = done.stderr.strip().splitlines()
    assert last.startswith("controller: ")
    assert sentence in last
    assert before == [] or "[rcl]" in before[0]  # ROS itself speaks of what it cannot parse


@pytest.mark.long
def test_a_fleet_of_processes_drives_as_without_ros(ros, tmp_path):
    file = tmp_path / "run.npz"
    line = ("fuzzyfleet_ros.fleet", "noisy-position", "cooperation", "--lockstep", "--seed", "3", "--duration", "20")
    done = called(*line, "--save", str(file))
    assert done.returncode == 0, done.stderr
    told = replace(load_scenario("noisy-position"), duration=20.0)
    assert farthest(load_run(file), simulate(told, "cooperation", [3])) < 1e-3


@pytest.mark.long
def test_a_fleet_in_real_time_comes_to_its_end(ros, tmp_path):
    file = tmp_path / "run.npz"
    done = called("fuzzyfleet_ros.fleet", "three-cross", "right-of-way", "--duration", "15", "--save", str(file))
    assert done.returncode == 0, done.stderr
    run = load_run(file)
    told = simulate(replace(load_scenario("three-cross"), duration=15.0), "right-of-way", [0])
    assert np.isfinite(run["x"]).all()
    # Commands come a period late, on a busy machine several (0.23 m were seen); lockstep tells it to the millimetre.
    driven = np.hypot(run["x"][..., -1] - run["x"][..., 0], run["y"][..., -1] - run["y"][..., 0])
    assert farthest(run, told) < 0.5 < driven.min()
