"""Logs that tell nothing, each refused by the command with a sentence that says what to do; and odd ones that do."""

from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

from robotics.commands.application import main
from robotics.plugins.identify.signals import read_signals
from robotics.plugins.identify.soundness import sound
from robotics.simulation.scenario.robots import load_robot

Columns = dict[str, np.ndarray]
SHEET = load_robot("etsro").robot


def drive() -> Columns:
    """Thirty seconds of steps at 20 Hz, answered 0.2 s late by a lag of 0.1 s: by a formula, not by the simulator."""
    generator = np.random.default_rng(3)
    time = 0.05 * np.arange(600)
    v, w = (np.repeat(generator.uniform(-size, size, 40), 15) for size in (0.5, 2.0))
    v[:20] = w[:20] = 0.0
    rows = []
    for each in (v, w):
        late = np.concatenate([np.zeros(4), each[:-4]])
        answer = np.zeros_like(late)
        for k in range(1, len(late)):
            answer[k] = answer[k - 1] + 0.4 * (late[k] - answer[k - 1])
        rows.append(answer + 0.005 * generator.standard_normal(len(late)))
    heading = np.cumsum(rows[1]) * 0.05
    x, y = (np.cumsum(rows[0] * along(heading)) * 0.05 for along in (np.cos, np.sin))
    return {
        "time": time,
        "v_command": v,
        "w_command": w,
        "v": rows[0],
        "w": rows[1],
        "x": x,
        "y": y,
        "heading": heading,
    }


def write(columns: Columns, file: Path) -> Path:
    lines = [",".join(columns)]
    lines += [
        ",".join("" if np.isnan(each) else f"{each:.9g}" for each in row) for row in zip(*columns.values(), strict=True)
    ]
    file.write_text("\n".join(lines) + "\n", encoding="utf-8")
    return file


def changed(**changes: Callable[[Columns], np.ndarray]) -> Columns:
    columns = drive()
    return columns | {name: change(columns) for name, change in changes.items()}


def back(columns: Columns) -> np.ndarray:
    time = columns["time"].copy()
    time[300:] -= 12.0
    return time


BAD = {
    "no motion": (changed(v=lambda c: 0 * c["v"], w=lambda c: 0 * c["w"]), "never moved"),
    "straight on alone": (
        changed(w_command=lambda c: 0 * c["w"], w=lambda c: 0 * c["w"], heading=lambda c: 0 * c["w"]),
        "the measured turn rate is the same all the time: a drive must go straight on and turn",
    ),
    "no commands": (changed(v_command=lambda c: 0 * c["v"], w_command=lambda c: 0 * c["w"]), "nothing but to stand"),
    "swapped commands": (
        changed(v_command=lambda c: c["w_command"], w_command=lambda c: c["v_command"]),
        "are swapped",
    ),
    "swapped measurements": (changed(v=lambda c: c["w"], w=lambda c: c["v"]), "are swapped"),
    "swapped both": (
        changed(
            v=lambda c: c["w"],
            w=lambda c: c["v"],
            v_command=lambda c: c["w_command"],
            w_command=lambda c: c["v_command"],
        ),
        "v and w are swapped",
    ),
    "mm/s": (changed(v=lambda c: 1000 * c["v"], v_command=lambda c: 1000 * c["v_command"]), "mm/s"),
    "one in mm/s": (changed(v_command=lambda c: c["v_command"] * 1000), "mm/s"),
    "one in cm/s": (changed(v=lambda c: c["v"] * 10), "different units"),
    "degrees per second": (changed(w=lambda c: np.degrees(c["w"])), "degrees per second"),
    "heading in degrees": (changed(heading=lambda c: np.degrees(c["heading"])), "degrees"),
    "time in ms": (changed(time=lambda c: 1000 * c["time"]), r"time [ms]"),
    "time in ns": (changed(time=lambda c: 1e9 * c["time"]), r"time [ns]"),
    "clock jumps back": (changed(time=back), "jumps back from 14.95 s to 3.00 s"),
    "other sign": (changed(w=lambda c: -c["w"]), "opposite sign"),
    "other robot": (changed(v=lambda c: c["v"][::-1], w=lambda c: c["w"][::-1]), "does not follow"),
    "all NaN": (changed(v=lambda c: np.full(600, np.nan)), "no row has numbers in v and w"),
    "heading clockwise": (
        changed(heading=lambda c: -c["heading"], y=lambda c: -c["y"]),
        "the heading falls where",
    ),
    "x and y swapped": (changed(x=lambda c: c["y"], y=lambda c: c["x"]), "a mirror image of where v and the heading"),
    "positions in mm": (changed(x=lambda c: 1000 * c["x"], y=lambda c: 1000 * c["y"]), "x [mm]"),
    "heading along y": (changed(heading=lambda c: c["heading"] - np.pi / 2), "90 degrees to the left of where its"),
    "whole seconds": (changed(time=lambda c: np.floor(c["time"])), "only 30 different times"),
    "too short": ({name: each[:60] for name, each in drive().items()}, "can be used"),
}


@pytest.mark.parametrize("what", BAD)
def test_it_is_refused_in_a_sentence(what: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    columns, sentence = BAD[what]
    assert main(["identify", str(write(columns, tmp_path / "drive.csv"))]) == 2
    said = capsys.readouterr().err
    assert sentence in said
    assert "drive.csv" in said
    assert "Traceback" not in said
    assert said.count("\n") == 1


@pytest.mark.parametrize(
    ("header", "said"),
    [
        ("t,x,y", "need the columns v_command and w_command"),
        ("time,v_command,w_command,x,y,heading", "velocities need the columns v and w or right and left"),
        ("time [fortnight],v_command,w_command,v,w", "unknown unit 'fortnight'"),
        ("v_command,w_command,v,w", "there is no column time, t, .* it has v_command, w_command, v and w: rename them"),
        ("time,v_command,w_command,v,w,v_measured", "two columns are v, the second is v_measured"),
    ],
)
def test_columns_that_are_missing_are_named(header: str, said: str, tmp_path: Path) -> None:
    file = tmp_path / "drive.csv"
    file.write_text(
        f"{header}\n" + "\n".join(",".join(["1"] * len(header.split(","))) for _ in range(3)), encoding="utf-8"
    )
    with pytest.raises(ValueError, match=said):
        read_signals(file, SHEET)


def test_units_in_the_header_are_heeded(tmp_path: Path) -> None:
    plain = read_signals(write(drive(), tmp_path / "si.csv"), SHEET)
    one = drive()
    other = {
        "time [ms]": 1000 * one["time"],
        "v_command [mm/s]": 1000 * one["v_command"],
        "w_command [deg/s]": np.degrees(one["w_command"]),
        "v [cm/s]": 100 * one["v"],
        "w [rpm]": one["w"] * 30 / np.pi,
    }
    read = read_signals(write(other, tmp_path / "other.csv"), SHEET)
    for a, b in zip((*plain.commands, *plain.velocities), (*read.commands, *read.velocities), strict=True):
        assert b == pytest.approx(a, abs=1e-6)


def test_wheel_speeds_become_velocities_by_the_data_sheet(tmp_path: Path) -> None:
    one = drive()
    radius, half = SHEET.wheel_radius, SHEET.half_axle
    wheels = {"right": (one["v"] + half * one["w"]) / radius, "left": (one["v"] - half * one["w"]) / radius}
    columns = {name: one[name] for name in ("time", "v_command", "w_command")} | wheels
    read = read_signals(write(columns, tmp_path / "wheels.csv"), SHEET)
    assert read.velocities.v == pytest.approx(one["v"], abs=1e-6)
    assert read.velocities.w == pytest.approx(one["w"], abs=1e-6)


def test_gaps_and_missing_numbers_are_left_out_and_told(tmp_path: Path) -> None:
    columns = drive()
    columns["v"][100:112] = np.nan
    columns = {name: np.delete(each, slice(200, 230)) for name, each in columns.items()}
    found = sound(read_signals(write(columns, tmp_path / "gaps.csv"), SHEET))
    said = " ".join(found.remarks)
    assert "12 of 570 rows have no number in v and w: left out." in said
    assert "There is no velocity from 4.95 s to 5.60 s" in said
    assert "There is no command from 9.95 s to 11.50 s" in said
    time = found.signals.velocities.time
    assert not found.usable[(time > 11.0) & (time < 12.4)].any()
    assert found.usable[time > 13.0].all()


def oddly(what: str, columns: Columns) -> Columns:
    """A drive with a fault in some of its samples."""
    lost = {name: each.copy() for name, each in columns.items()}
    if what == "spikes":
        lost["v"][[50, 300, 444]] = 327.67
    elif what == "stuck":
        lost["v"][200:300] = lost["v"][200]
    elif what == "poses jump":
        lost["x"][100:120] = 99.0
    elif what == "poses stay":
        for name in ("x", "y", "heading"):
            lost[name][400:500] = lost[name][400]
    elif what == "steps back":
        lost["time"][300:] -= 0.3
    elif what == "late":
        for name in ("v_command", "w_command"):
            lost[name] = np.roll(lost[name], -19)
    return lost


@pytest.mark.parametrize(
    ("what", "said"),
    [
        ("none", ""),
        ("spikes", "3 of 600 measured speeds are beyond 1.496 m/s, three times what was commanded: left out."),
        ("stuck", "stays at 0.0401 m/s from 10.00 s to 14.95 s, whatever was commanded: left out."),
        ("poses jump", "20 of 600 poses are farther away than the robot comes in that time: left out."),
        ("poses stay", "The pose stays the same from 20.00 s to 24.95 s while the wheels turn: left out."),
        ("steps back", "The clock steps back, by up to 0.25 s"),
        ("late", "What was measured comes 1 s after its command, or later"),
    ],
)
def test_what_no_robot_does_is_left_out_and_told(what: str, said: str, tmp_path: Path) -> None:
    found = sound(read_signals(write(oddly(what, drive()), tmp_path / "odd.csv"), SHEET))
    assert " ".join(found.remarks) == "" if not said else said in " ".join(found.remarks)
    assert np.abs(found.signals.velocities.v).max() < 0.6
    poses = found.signals.poses
    assert poses is not None
    assert np.abs(poses.x).max() < 10
    assert len(poses.time) == {"poses jump": 580, "poses stay": 501, "steps back": 594}.get(what, 600)


def test_columns_as_plotjuggler_names_topics(tmp_path: Path) -> None:
    plain = drive()
    named = [
        f"/{topic}/{part}" for topic in ("cmd_vel/twist", "odom/twist/twist") for part in ("linear/x", "angular/z")
    ]
    posed = [f"/odom/pose/pose/{part}" for part in ("position/x", "position/y", "orientation/yaw")]
    columns = dict(zip(("__time", *named, *posed), plain.values(), strict=True))
    read = read_signals(write(columns, tmp_path / "plotjuggler.csv"), SHEET)
    assert read.commands.w == pytest.approx(plain["w_command"])
    assert read.velocities.v == pytest.approx(plain["v"])
    assert read.poses is not None
    assert read.poses.y == pytest.approx(plain["y"])


def test_a_pause_of_an_hour_makes_two_drives(tmp_path: Path) -> None:
    columns = drive()
    columns["time"] = columns["time"] + np.where(np.arange(600) < 300, 0.0, 3600.0)
    found = sound(read_signals(write(columns, tmp_path / "pause.csv"), SHEET))
    assert "it is used as two drives" in " ".join(found.remarks)
    assert found.signals.velocities.time[-1] < 40.0


def test_the_delay_is_latency_and_lag() -> None:
    from robotics.plugins.identify.signals import MeasuredVelocities, Signals
    from robotics.plugins.logs.drive import Commands

    one = drive()
    signals = Signals(
        "x",
        Commands(one["time"], one["v_command"], one["w_command"]),
        MeasuredVelocities(one["time"], one["v"], one["w"]),
    )
    assert sound(signals).delay == pytest.approx(0.2 + 0.05, abs=0.06)
