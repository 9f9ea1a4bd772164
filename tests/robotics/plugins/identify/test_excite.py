"""Commands that tell most: they stay inside, they tell more than chance, and the command writes what identify reads."""

import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from fuzzy.files.table import read_table
from robotics.commands.application import main
from robotics.plugins.identify.calibration import steady_stretches
from robotics.plugins.identify.excitation import SQUARE_MARGIN, excite
from robotics.plugins.identify.replay import (
    COMMAND_PERIOD,
    COMMANDS,
    ODOMETRY_POSES,
    POSES,
    VELOCITIES,
    WHEEL_SPEEDS,
    YAW,
    replayed,
    write_log,
)
from robotics.plugins.identify.signals import IdentifyError, MeasuredVelocities, read_signals
from robotics.simulation.scenario.robots import load_robot

SHEET = load_robot("etsro").robot
GENTLE = ("gently straight", "gently on the spot", "gently around a wheel")


def test_simulated_robots_of_the_range_stay_in_the_square_and_it_tells_more_than_chance() -> None:
    """By the simulator's own loop, with robots that the design has not drawn."""
    found, square = excite(SHEET, 2.5, 24.0), 2.5
    assert found.efficiency > 1.0
    assert found.room >= SQUARE_MARGIN * square
    assert len(found.program.time) == 480
    generator = np.random.default_rng(8)
    for _ in range(5):
        factors = {"kp": 0.8, "ki": 0.7, "friction_torque": 1.6, "torque_limit": 0.8}
        robot = SHEET.changed(
            **{name: getattr(SHEET, name) * generator.uniform(min(f, 1), max(f, 1)) for name, f in factors.items()},
            v_rate_max=float(generator.uniform(1.2, 5.0)),
            w_rate_max=float(generator.uniform(9.0, 30.0)),
        )
        run = replayed(robot, found.program, latency=0.01 * int(generator.integers(0, 31)))
        far = max(np.abs(run["x"]).max(), np.abs(run["y"]).max())
        assert far + robot.turning_circle < square / 2
    assert np.ptp(run["x"]) + np.ptp(run["y"]) > 0.3, "it drives"


def test_slow_ramps_turning_and_commands_beyond_the_limits_are_in_it() -> None:
    found = excite(SHEET, 3.0, 24.0)
    assert not set(GENTLE) & set(found.names), "a short one has no time for them"
    program = found.program
    assert np.abs(program.w).max() > SHEET.w_max
    assert np.count_nonzero((np.abs(program.v) > 0) & (np.abs(program.v) < 0.1)) > 20


def test_a_third_of_a_minute_is_steady_and_the_robot_comes_back() -> None:
    """Steady as the calibration of wheels counts it: by its own odometry, of a robot that does what it is told."""
    found = excite(SHEET, 3.0, 60.0)
    assert [name for name in found.names if name.startswith("gently")] == list(GENTLE)
    program = found.program
    seen = MeasuredVelocities(program.time, program.v, program.w)
    stretches = steady_stretches(seen, SHEET.half_axle)
    driven = [np.abs(program.v[a:b]).sum() + SHEET.half_axle * np.abs(program.w[a:b]).sum() for a, b in stretches]
    assert COMMAND_PERIOD * sum(driven) > 3.0, "m, of rims on average, straight on and around"
    assert sum(program.time[b - 1] - program.time[a] for a, b in stretches) > 20.0
    assert abs(program.v.sum()) + abs(program.w.sum()) < 1e-9


def test_a_square_without_room_is_refused() -> None:
    with pytest.raises(IdentifyError, match="leaves the robot no room"):
        excite(SHEET, 0.4, 30.0)
    with pytest.raises(IdentifyError, match="from 20 to 600 s"):
        excite(SHEET, 3.0, 5.0)


@pytest.mark.parametrize("ending", ["csv", "mcap"])
def test_the_command_writes_commands_and_a_drive(
    ending: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    if ending == "mcap":
        pytest.importorskip("rosbags")
    file, log = tmp_path / f"excite.{ending}", tmp_path / f"drive.{ending}"
    words = ["--seconds", "20", "-o", str(file), "--drive", str(log), "--latency", "0.05", "--json"]
    assert main(["excite", "--robot", "etsro", *words]) == 0
    told = json.loads(capsys.readouterr().out)
    assert told["topic"] == "cmd_vel"
    time, v, w = commands_of(file)
    assert np.diff(time) == pytest.approx(0.05)
    read = read_signals(log, SHEET)
    assert read.commands.v[: len(time)] == pytest.approx(v, abs=1e-6)
    assert read.commands.w[: len(time)] == pytest.approx(w, abs=1e-6)
    assert read.poses is not None


def commands_of(file: Path) -> np.ndarray:
    """Times, v and w (3, n) of a file: of MCAP as the package rosbags reads what ros2 bag would play."""
    if file.suffix == ".csv":
        table = read_table(file)
        assert (table.names, table.units) == (("time", "v_command", "w_command"), ("s", "m/s", "rad/s"))
        return table.values.T
    from rosbags.highlevel import AnyReader

    with AnyReader([file]) as reader:
        rows = [(time / 1e9, *_twist(reader.deserialize(raw, c.msgtype))) for c, time, raw in reader.messages()]
        assert [(c.topic, c.msgtype) for c in reader.connections] == [("/cmd_vel", "geometry_msgs/msg/TwistStamped")]
    return np.array(rows).T


def _twist(message: Any) -> tuple[float, float]:
    return message.twist.linear.x, message.twist.angular.z


def test_a_log_of_several_rates_is_the_same_as_csv_and_as_mcap(tmp_path: Path) -> None:
    """Poses of another source than odometry's, a gyroscope and wheels, each at times of its own."""
    pytest.importorskip("rosbags")
    units = COMMANDS | VELOCITIES | ODOMETRY_POSES | POSES | WHEEL_SPEEDS | YAW
    generator, names = np.random.default_rng(0), [*units]
    rows = np.full((60, 1 + len(names)), np.nan)
    rows[:, 0] = 0.01 * np.arange(60)
    groups = ((COMMANDS,), (VELOCITIES, ODOMETRY_POSES), (POSES,), (YAW, WHEEL_SPEEDS))
    for first, parts in enumerate(groups):  # small angles: faster ones would be taken for degrees
        for name in (name for part in parts for name in part):
            rows[first::4, 1 + names.index(name)] = generator.uniform(-0.1, 0.1, 15)
    for ending in ("csv", "mcap"):
        write_log(tmp_path / f"log.{ending}", units, rows)
    table = read_signals(tmp_path / "log.csv", SHEET)
    bag = read_signals(tmp_path / "log.mcap", SHEET, pose="pose", imu="imu")
    for part in ("commands", "velocities", "poses", "yaw"):
        told = getattr(bag, part)
        assert len(told.time) == 15
        for one, other in zip(getattr(table, part), told, strict=True):
            assert other == pytest.approx(one, abs=1e-9)
    own = read_signals(tmp_path / "log.mcap", SHEET).poses
    assert own is not None
    assert own.x == pytest.approx(rows[1::4, 1 + names.index("odometry_x")])
