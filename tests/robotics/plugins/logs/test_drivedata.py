"""Tables of drives: the very numbers by which rule bases drive, and ANFIS that drives as a logged robot did."""

import json
from dataclasses import replace

import numpy as np
import pytest
from rosbags.rosbag2 import Reader

import anfis
import fuzzy
from anfis.commands.application import main as train
from fuzzy.files.fisfile import read_fis, write_fis
from fuzzy.files.table import read_table
from robotics.commands.application import main
from robotics.laws.law import ControllerError
from robotics.measures.tracking import cross_track_error, measure
from robotics.plugins.learning.datatable import TIMED_COLUMNS, write_data
from robotics.plugins.logs.drive import read_drive
from robotics.plugins.logs.drivedata import (
    DRIVEN,
    UNTIMED,
    DriveDataError,
    DriveRecipe,
    drive_data,
)
from robotics.plugins.logs.writing import write_mcap
from robotics.simulation.loop import simulate
from robotics.simulation.scenario.reading import load_scenario
from tests.robotics.plugins.logs import bags

KNOWN = (
    *TIMED_COLUMNS,
    "cross_track",
    "path_bearing",
    "curvature",
    "onward_bearing",
    "lag",
    "v",
    "w",
    "time",
    "distance",
)


@pytest.fixture(scope="module")
def rules():
    """A rule base that asks for much and turns to where its target is."""
    inputs = [fuzzy.Variable(name, (-9.0, 9.0), {"any": fuzzy.Gaussian(9.0, 0.0)}) for name in KNOWN]
    gain = np.zeros(len(KNOWN))
    gain[KNOWN.index("x_err")], turn = 2.0, np.zeros(len(KNOWN))
    turn[KNOWN.index("y_err")] = 12.0
    outputs = [
        fuzzy.Variable("v", (0.0, 1.0), {"go": fuzzy.Linear(tuple(gain), 0.0)}, unit="m/s"),
        fuzzy.Variable("w", (-3.0, 3.0), {"go": fuzzy.Linear(tuple(turn), 0.0)}, unit="rad/s"),
    ]
    all_of_it = " and ".join(f"{name} is any" for name in KNOWN)
    return fuzzy.Sugeno(inputs=inputs, outputs=outputs, rules=[f"if {all_of_it} then v is go and w is go"])


def test_the_table_of_a_log_holds_what_the_rule_base_was_asked_while_it_drove(rules, tmp_path):
    """The run keeps that in single precision; where the last target lies, the log does not know."""
    write_fis(rules, tmp_path / "mine.fis")
    run = simulate(
        replace(load_scenario("fuzzy-off-path"), duration=6.0), f"fuzzy:rule_base={tmp_path / 'mine.fis'}",
        [3], encoders=True,
    )  # fmt: skip
    write_mcap(run, tmp_path / "run.mcap")
    table = drive_data([read_drive(tmp_path / "run.mcap")], DriveRecipe(inputs=KNOWN, whole=True))
    asked = run.inputs[:, :, 0, 0]
    count = len(table.values)
    assert count == len(run.time) - 8  # 0.4 s of it
    for k, name in enumerate(KNOWN):
        # The log's path has points 2 cm apart, the run's is exact
        allowed = 2e-3 if name == "curvature" else 2e-5 if name in ("path_bearing", "onward_bearing", "lag") else 2e-6
        np.testing.assert_allclose(table.values[:, k], asked[:count, k], atol=allowed, rtol=2e-6, err_msg=name)
    np.testing.assert_allclose(table.values[:, -2], run["command_1"][0, 0, :count], atol=1e-9)
    np.testing.assert_allclose(table.values[:, -1], run["command_2"][0, 0, :count], atol=1e-9)


@pytest.fixture(scope="module")
def driven(tmp_path_factory):
    """Three drives by the Lyapunov law as a robot logs them: odometry with 3 mm and 3 mrad of noise, and commands."""
    folder = tmp_path_factory.mktemp("driven")
    drives = []
    for seed, name in enumerate(("lyapunov-sine", "lyapunov-circle", "fuzzy-off-path")):
        run = simulate(load_scenario(name), "lyapunov", [seed])
        drives.append(read_drive(bags.as_a_robot_writes_it(run, folder / name, seed, (0.003, 0.003))))
    return drives


def late_distance(fis, folder, name, seeds):
    """The RMS distance to the reference [mm] from 6 s on, of each seed; infinite where the robot was stopped."""
    write_fis(fis, folder / "driven.fis")
    run = simulate(load_scenario(name), f"fuzzy:rule_base={folder / 'driven.fis'}", seeds)
    found = 1000 * measure(run)["rms_distance_late_m"][:, 0]
    return np.where(run.diverged[:, 0], np.inf, found)


def learnt(table, commands=None, *, taught=True):
    """A system made of clusters, and trained unless it is not to be taught."""
    x, y = table.values[:, :-2], table.values[:, -2:] if commands is None else commands
    names = {"input_names": table.inputs, "output_names": ("v", "w")}
    fis = fuzzy.identify(x, y, "subtractive", radius=1.6, fit=taught, **names)
    if taught:
        fis = anfis.train(fis, x, y, anfis.Options(epochs=20)).system
    return replace(fis, out_of_range="clip")


@pytest.mark.long
def test_anfis_learns_from_odometry_and_commands_alone_to_drive_and_not_without_learning(driven, tmp_path):
    """No reference, no path: what was driven is the target. Untaught, or taught by others' commands, it does not."""
    table = drive_data(driven, DriveRecipe())
    assert table.inputs == DRIVEN
    assert table.followed == "the way driven"
    system = learnt(table)
    for name in ("lyapunov-sine", "fuzzy-off-path"):
        assert late_distance(system, tmp_path, name, range(50, 53)).max() < 20.0  # mm; it starts 1 m off
    assert late_distance(learnt(table, taught=False), tmp_path, "lyapunov-sine", [50]).min() > 1000.0
    shuffled = np.random.default_rng(0).permutation(table.values[:, -2:])
    assert late_distance(learnt(table, shuffled), tmp_path, "lyapunov-sine", [50]).min() > 200.0


def test_the_way_driven_tells_how_to_get_where_one_was_a_little_later(tmp_path):
    """On a circle of radius r at v the point T later lies at (r sin vT/r, r (1 - cos vT/r))."""
    r, v, look = 0.5, 0.3, 0.6
    rows = []
    for k in range(300):
        time = k / 30
        turned = v * time / r
        posture = (r * np.sin(turned), r * (1 - np.cos(turned)), turned)
        stamp = bags.EPOCH + time
        rows.append((stamp, "/odom", bags.odometry(stamp, posture, v, v / r)))
        rows.append((stamp, "/cmd_vel", bags.twist(v, v / r)))
    drive = read_drive(bags.write(tmp_path / "bag", rows))
    table = drive_data([drive], DriveRecipe(inputs=("x_err", "y_err", "target_v"), look_ahead=look))
    angle = v * look / r
    expected = [r * np.sin(angle), r * (1 - np.cos(angle)), v, v, v / r]
    np.testing.assert_allclose(table.values, np.tile(expected, (len(table.values), 1)), atol=1e-4)


def test_a_path_without_times_teaches_what_needs_no_timetable(tmp_path):
    run = simulate(replace(load_scenario("lyapunov-sine"), duration=8.0), "lyapunov", [1])
    folder = bags.as_a_robot_writes_it(run, tmp_path / "plain", 1)
    drive = read_drive(folder)
    plan = bags.path(bags.EPOCH, run.paths[0].T[::20])
    rows = []
    with Reader(folder) as reader:
        for one, time, data in reader.messages():
            rows.append((time / 1e9, one.topic, bags.STORE.deserialize_cdr(data, one.msgtype)))
    drive = read_drive(bags.write(tmp_path / "planned", [*rows, (bags.EPOCH, "/plan", plan)]))
    table = drive_data([drive], DriveRecipe())
    assert table.inputs == UNTIMED
    assert table.followed == "the path in the log"
    offs = table.values[:, 0]
    true = cross_track_error(run)[0, 0]
    np.testing.assert_allclose(offs[90:150], true[90:150], atol=1e-3)  # it began before the path's beginning
    assert np.ptp(offs[90:150]) > 2e-3
    with pytest.raises(DriveDataError, match=r"x_err needs to know when .* planned has a path without times \(/plan\)"):
        drive_data([drive], DriveRecipe(inputs=("x_err", "cross_track")))


@pytest.mark.parametrize(
    ("inputs", "said"),
    [
        (("x_err", "x_err"), "each quantity once"),
        (("gap",), "gap is of other robots, and the table of a drive is of one alone"),
        (("robot2_gap",), "robot2_gap is of other robots"),
        (("leader_ahead",), "leader_ahead is of other robots"),
        (("front",), "front needs range sensors, which are not read from logs"),
        (("x_error",), "unknown quantity that a robot knows 'x_error'; did you mean 'x_err'"),
    ],
)
def test_what_a_log_does_not_tell_is_refused(driven, inputs, said):
    with pytest.raises((DriveDataError, ControllerError), match=said):
        drive_data(driven[:1], DriveRecipe(inputs=inputs))


def test_a_log_shorter_than_the_look_ahead_leaves_nothing(driven):
    with pytest.raises(DriveDataError, match="no row is left: the drives are shorter than the look-ahead"):
        drive_data(driven[:1], DriveRecipe(look_ahead=9e3))
    with pytest.raises(DriveDataError, match=r"period must be a finite number in s, > 0; got 0\.0"):
        drive_data(driven[:1], DriveRecipe(period=0.0))
    with pytest.raises(DriveDataError, match="at least one drive"):
        drive_data([], DriveRecipe())


def test_the_command_makes_a_table_a_card_and_a_table_for_checking(tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    run = simulate(replace(load_scenario("three-cross"), duration=22.0), "right-of-way", [2])
    write_mcap(run, "team.mcap")
    command = ["dataset", "from-bag", "team.mcap", "-q", "--robot", "robot1", "--robot", "robot3", "-o", "data.csv"]
    assert main([*command, "--check", "check.csv", "--json"]) == 0
    said = json.loads(capsys.readouterr().out)
    data, check = (read_table(f"{name}.csv") for name in ("data", "check"))
    assert (said["files"]["data.csv"]["rows"], said["files"]["check.csv"]["rows"]) == (
        len(data.values),
        len(check.values),
    )
    assert 0.2 < len(check.values) / len(data.values) < 0.4
    assert tuple(data.names) == (*TIMED_COLUMNS, "v", "w")
    card = (tmp_path / "data.card.md").read_text("utf-8")
    assert "`robotics dataset from-bag team.mcap --robot robot1 --robot robot3`" in card
    assert str(tmp_path) not in card
    assert main([*command[:4], "-o", "data.csv"]) == 2
    assert "several robots drive there; choose one with --robot: robot1, robot2, robot3" in capsys.readouterr().err
    assert main([*command, "--check", "check.txt"]) == 2
    assert "check.txt: the file's name must end in .csv" in capsys.readouterr().err


@pytest.mark.long
def test_the_numbers_of_the_page(tmp_path, monkeypatch, capsys):
    """docs/howto/logs.md: nine logged drives, three rules by `anfis train`, twenty seeds not seen before."""
    monkeypatch.chdir(tmp_path)
    names = ("lyapunov-sine", "lyapunov-circle", "fuzzy-off-path")
    logs = []
    for name in names:
        for seed in range(3):
            run = simulate(load_scenario(name), "lyapunov", [seed])
            logs.append(str(bags.as_a_robot_writes_it(run, tmp_path / f"{name}-{seed}", seed, (0.003, 0.003))))
    assert main(["dataset", "from-bag", *logs, "-o", "real.csv", "-q"]) == 0
    table = read_table("real.csv")
    mixed = np.array(table.values)
    mixed[:, -2:] = np.random.default_rng(0).permutation(mixed[:, -2:])
    write_data("mixed.csv", table.names, mixed)
    reached = {}
    for data, rules in (("real", "3"), ("mixed", "2")):
        options = ["--outputs", "v,w", "--rules", rules, "--epochs", "20", "-q"]
        assert train(["train", f"{data}.csv", *options, "-o", f"{data}.fis"]) == 0
        system = read_fis(f"{data}.fis")
        reached[data] = [late_distance(system, tmp_path, name, range(100, 120)).mean() for name in names]
    capsys.readouterr()
    assert max(reached["real"]) < 8.0  # mm
    assert min(reached["mixed"]) > 1000.0
