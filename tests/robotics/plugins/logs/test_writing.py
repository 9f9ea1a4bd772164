"""Logs of runs, read back by other programs than those that wrote them, number for number."""

import json
import os
import re
import sys
from collections import defaultdict
from dataclasses import replace
from importlib.metadata import version
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from mcap.reader import make_reader
from mcap_ros2.decoder import DecoderFactory
from rosbags.highlevel import AnyReader

from fuzzy.errors import InputError
from fuzzy.files.atomic import TargetError
from fuzzy.inference import infer
from robotics.commands.application import main
from robotics.laws.catalogue import make_controller
from robotics.plugins.logs.layout import layout_of, write_layout
from robotics.plugins.logs.typestore import DISTRIBUTIONS, LogError
from robotics.plugins.logs.writing import write_mcap, write_rosbag
from robotics.simulation.loop import simulate
from robotics.simulation.run import load_run
from robotics.simulation.scenario.reading import load_scenario, parse_scenario
from robotics.world.environment.world import Disc
from robotics.world.paths.path import Line
from robotics.world.paths.trajectory import Timing

KEPT: dict[str, Any] = {"message_ages": True, "encoders": True, "messages": True}


@pytest.fixture(scope="module")
def tracking():
    """One robot under a rule base, for two seeds."""
    return simulate(short("lyapunov-sine", 3.0), make_controller("fuzzy"), (4, 5), name="fuzzy", **KEPT, torques=True)


@pytest.fixture(scope="module")
def team():
    """Three robots that talk, look and change their modes among obstacles."""
    return simulate(short("obstacles-on-two-paths", 5.5), make_controller("obstacles"), (7,), name="obstacles", **KEPT)


def short(name, duration):
    return replace(load_scenario(name), duration=duration)


def read(path):
    """The messages of an MCAP file by topic, as mcap-ros2-support decodes them, each with its time [s]."""
    found = defaultdict(list)
    with Path(path).open("rb") as file:
        reader = make_reader(file, decoder_factories=[DecoderFactory()])
        for _, channel, raw, message in reader.iter_decoded_messages():
            assert raw.log_time == raw.publish_time
            found[channel.topic].append((raw.log_time / 1e9, message))
    return found


def stamp(message):
    return message.header.stamp.sec + message.header.stamp.nanosec / 1e9


def yaw(turn):
    return 2 * np.arctan2(turn.z, turn.w)


@pytest.fixture(scope="module")
def logged(tracking, team, tmp_path_factory):
    folder = tmp_path_factory.mktemp("logs")
    write_mcap(tracking, folder / "one.mcap", seed=5)
    write_mcap(team, folder / "team.mcap")
    return {"one": read(folder / "one.mcap"), "team": read(folder / "team.mcap"), "folder": folder}


def test_every_number_of_a_run_comes_back_to_the_last_bit(tracking, team, logged):
    for name, run in (("one", tracking.only(5)), ("team", team)):
        frame = run.frame()
        for robot in range(1, len(run.about.robots) + 1):
            rows = frame[frame["robot"] == robot]
            topic = "/state" if name == "one" else f"/robot{robot}/state"
            states = logged[name][topic]
            assert [round(time, 9) for time, _ in states] == [round(t, 9) for t in run.time]
            numbers = [c for c in rows if c not in ("seed", "robot", "time", "mode", "guarded", "fault")]
            assert len(numbers) == 14 + 6 + (4 if name == "team" else 0)
            for column in numbers:
                said = np.array([getattr(message, column) for _, message in states])
                np.testing.assert_array_equal(said, rows[column].to_numpy(), err_msg=column)
    assert [m.mode for _, m in logged["team"]["/robot1/state"]] == [
        mode for mode, robot in zip(team.frame()["mode"], team.frame()["robot"], strict=True) if robot == 1
    ]


def test_postures_commands_and_targets_are_where_ros_looks_for_them(tracking, logged):
    one, log = tracking.only(5), logged["one"]
    for topic, suffix in (("/odom", "_measured"), ("/ground_truth", ""), ("/reference", "_reference")):
        for k, (time, message) in enumerate(log[topic]):
            x, y, heading = (
                one.target(n)[0, k] if suffix == "_reference" else one[n + suffix][0, 0, k]
                for n in ("x", "y", "heading")
            )
            at = message.pose.pose
            assert (at.position.x, at.position.y, message.header.frame_id) == (x, y, "odom")
            assert yaw(at.orientation) == pytest.approx(np.arctan2(np.sin(heading), np.cos(heading)), abs=1e-15)
            assert stamp(message) == pytest.approx(time, abs=1e-12)
    twists = [message.twist.twist for _, message in log["/odom"]]
    np.testing.assert_array_equal([t.linear.x for t in twists], one.encoders[:, 2, 0, 0])
    np.testing.assert_array_equal([t.angular.z for t in twists], one.encoders[:, 3, 0, 0])
    twists = [message.twist for _, message in log["/cmd_vel"]]
    np.testing.assert_array_equal([t.linear.x for t in twists], one["command_1"][0, 0])
    np.testing.assert_array_equal([t.angular.z for t in twists], one["command_2"][0, 0])


def test_joints_are_what_the_encoders_count_and_make_the_speeds_of_the_odometry(tracking, logged):
    robot, log = tracking.about.robots[0], logged["one"]
    joints = [message for _, message in log["/joint_states"]]
    assert {tuple(j.name) for j in joints} == {("wheel_left_joint", "wheel_right_joint")}
    counts = np.array([j.position for j in joints]) * robot.counts_per_turn / (2 * np.pi)
    np.testing.assert_allclose(counts, counts.round(), atol=1e-6)
    speeds = np.array([j.velocity for j in joints]) * robot.wheel_radius
    odometry = [message.twist.twist for _, message in log["/odom"]]
    np.testing.assert_allclose(speeds.mean(axis=1), [t.linear.x for t in odometry], atol=1e-12)
    turn = (speeds[:, 1] - speeds[:, 0]) / (2 * robot.half_axle)
    np.testing.assert_allclose(turn, [t.angular.z for t in odometry], atol=1e-12)
    torques = tracking.only(5).torques[:, ::-1, 0, 0].astype(float)
    np.testing.assert_array_equal([j.effort for j in joints], torques)


def test_rules_fire_in_the_log_as_the_inference_says(tracking, logged):
    log, system = logged["one"], tracking.about.rule_bases["tracking"]
    (_, base), *more = log["/rule_base/tracking"]
    assert not more
    assert base.rules == [str(rule) for rule in system.rules]
    assert base.inputs == [variable.name for variable in system.inputs]
    told = [message for _, message in log["/firing/tracking"]]
    asked = np.array([message.inputs for message in told])
    np.testing.assert_array_equal(asked, tracking.only(5).inputs[:, :, 0, 0].astype(float))
    firing = infer(system, asked).firing
    np.testing.assert_allclose([message.firing for message in told], firing, atol=1e-12)
    np.testing.assert_allclose(np.sum([message.shares for message in told], axis=1), 1.0, atol=1e-12)
    assert [message.strongest for message in told] == (np.argmax(firing, axis=1) + 1).tolist()
    assert all(message.strongest_rule == base.rules[message.strongest - 1] for message in told)


def test_the_radio_is_logged_as_it_was_sent_and_as_it_was_heard(team, logged):
    for i in range(3):
        sent = logged["team"][f"/robot{i + 1}/radio"]
        names = team.about.message
        assert len(sent) == len(team.time)
        for k, (_, message) in enumerate(sent):
            assert message.sender == i + 1
            assert [value.name for value in message.values] == list(names)
            np.testing.assert_array_equal([value.value for value in message.values], team.messages[k, :, 0, i])
        ages = np.array([message.age for _, message in logged["team"][f"/robot{i + 1}/radio_ages"]])
        np.testing.assert_array_equal(ages, team.message_ages[:, 0, i].astype(float))
    place = team.about.message.index("x")
    np.testing.assert_array_equal(team.messages[:, place, 0, 1], team["x_measured"][0, 1])  # it told where it was


def test_ranges_are_in_single_precision_as_the_run_keeps_them(team, logged):
    for n, name in enumerate(("front_left", "front_right", "left", "right")):
        told = [message for _, message in logged["team"][f"/robot1/range/{name}"]]
        np.testing.assert_array_equal(np.array([m.range for m in told], dtype=np.float32), team.ranges[:, 0, 0, n])
        sensor = team.about.sensors[0][name.replace("_", "-")]
        assert told[0].max_range == pytest.approx(sensor.range, rel=1e-6)
        assert told[0].header.frame_id == f"robot1/range_{name}"
    assert np.isfinite(team.ranges[:, 0, 0]).any()


def test_frames_make_one_tree_and_obstacles_stand_in_the_scene(team, logged):
    log = logged["team"]
    still = [one for _, message in log["/tf_static"] for one in message.transforms]
    moving = log["/tf"]
    assert len(moving) == len(team.time)
    parents = {one.child_frame_id: one.header.frame_id for one in still}
    parents |= {one.child_frame_id: one.header.frame_id for one in moving[0][1].transforms}
    for message in (message for topic, rows in log.items() for _, message in rows[:1] if hasattr(message, "header")):
        frame = message.header.frame_id
        while frame != "map":
            frame = parents[frame]
    true = next(one for one in moving[9][1].transforms if one.child_frame_id == "robot3/base_link_true")
    assert true.transform.translation.x == team["x"][0, 2, 9]
    (_, scene), *_ = log["/scene"]
    bodies = [marker for marker in scene.markers if marker.ns == "obstacles"]
    assert len(bodies) == int(team.obstacles.counts[0])
    discs = [m for m in bodies if m.type == 3]
    radii = {round(float(r), 9) for *_, r in team.obstacles.circles[0][team.obstacles.bodies[0, :, 1] == 0]}
    assert {round(m.scale.x / 2, 9) for m in discs} == radii
    assert {(m.scale.x, m.scale.y) for m in scene.markers if m.ns == "robots"} == {
        (r.length, r.width) for r in team.about.robots
    }


def test_a_log_says_what_ran_and_names_no_machine(logged, tracking, tmp_path):
    (_, info), *_ = logged["team"]["/run_info"]
    assert (info.scenario, info.controller, info.seed) == ("obstacles-on-two-paths", "obstacles", 7)
    assert info.robots == ["/robot1", "/robot2", "/robot3"]
    with (logged["folder"] / "team.mcap").open("rb") as file:
        summary = {m.name: m.metadata for m in make_reader(file).iter_metadata()}
    text = summary["rosbag2"]["serialized_metadata"]
    for fact in (
        "scenario: obstacles-on-two-paths",
        "controller: obstacles",
        "seed: '7'",
        f"fuzzyfleet: {version('fuzzyfleet')}",
    ):
        assert fact in text
    write_rosbag(tracking, tmp_path / "plain", seed=4, storage="sqlite3")
    content = b"".join(file.read_bytes() for file in (tmp_path / "plain").iterdir())
    for name in (str(tmp_path), os.uname().nodename, str(Path.home())):
        assert name.encode() not in content


@pytest.mark.parametrize(
    ("distribution", "storage"), [("humble", "sqlite3"), ("iron", "sqlite3"), ("jazzy", "mcap"), ("kilted", "mcap")]
)
def test_a_rosbag_holds_the_same_messages_in_every_storage_and_distribution(
    tracking, logged, tmp_path, storage, distribution
):
    write_rosbag(tracking, tmp_path / "bag", seed=5, storage=storage, distribution=distribution)
    files = {"mcap": "bag.mcap", "sqlite3": "bag.db3"}
    assert sorted(file.name for file in (tmp_path / "bag").iterdir()) == [files[storage], "metadata.yaml"]
    found: dict[str, list[Any]] = defaultdict(list)
    with AnyReader([tmp_path / "bag"]) as reader:
        for connection, time, data in reader.messages():
            found[connection.topic].append((time / 1e9, reader.deserialize(data, connection.msgtype)))
    assert {topic: len(rows) for topic, rows in found.items()} == {t: len(r) for t, r in logged["one"].items()}
    for (_, ours), (_, theirs) in zip(found["/state"], logged["one"]["/state"], strict=True):
        assert (ours.x, ours.heading, ours.command_2) == (theirs.x, theirs.heading, theirs.command_2)
    assert f"version: {DISTRIBUTIONS[distribution]}" in (tmp_path / "bag" / "metadata.yaml").read_text("utf-8")


def test_the_same_run_makes_the_same_bytes_and_replaces_a_file(tracking, tmp_path):
    write_mcap(tracking, tmp_path / "a.mcap", seed=5)
    first = (tmp_path / "a.mcap").read_bytes()
    (tmp_path / "a.mcap").write_bytes(b"something else")
    write_mcap(tracking, tmp_path / "a.mcap", seed=5)
    assert (tmp_path / "a.mcap").read_bytes() == first
    assert [file.name for file in tmp_path.iterdir()] == ["a.mcap"]


def test_a_saved_run_is_logged_as_it_would_have_been_at_once(team, logged, tmp_path):
    team.save(tmp_path / "run.npz")
    write_mcap(load_run(tmp_path / "run.npz"), tmp_path / "team.mcap")
    assert (tmp_path / "team.mcap").read_bytes() == (logged["folder"] / "team.mcap").read_bytes()


def test_a_law_of_torques_logs_the_velocities_that_it_demands(tmp_path):
    run = simulate(short("lyapunov-sine", 1.0), "esm", torques=True, encoders=True)
    assert run.level == "torque"
    write_mcap(run, tmp_path / "esm.mcap")
    found = read(tmp_path / "esm.mcap")
    np.testing.assert_array_equal([m.twist.linear.x for _, m in found["/cmd_vel"]], run["v_demand"][0, 0])
    np.testing.assert_array_equal([m.command_1 for _, m in found["/state"]], run["command_1"][0, 0])


def test_what_a_run_does_not_keep_is_not_logged(tmp_path):
    run = simulate(short("lyapunov-sine", 0.5), "lyapunov")
    write_mcap(run, tmp_path / "bare.mcap")
    found = read(tmp_path / "bare.mcap")
    assert {"/odom", "/cmd_vel", "/state", "/path"} <= set(found)
    assert not {t for t in found if t.startswith(("/joint", "/radio", "/range", "/firing", "/rule"))}
    assert np.isnan(found["/odom"][3][1].twist.twist.linear.x)  # it is not known, and so not 0


def test_a_stopped_robot_says_no_more_but_that(tmp_path):
    text = (
        "duration = 4.0\ndivergence = 0.25\n[[robots]]\nstart = [0.0, 0.0, 3.0]\n"
        'path = { shape = "line", start = [0.0, 0.0], end = [9.0, 0.0] }\ntiming = { speed = 0.6 }\n'
    )
    run = simulate(parse_scenario(text, "away"), "pid")
    assert run.diverged.all()
    write_mcap(run, tmp_path / "run.mcap")
    found = read(tmp_path / "run.mcap")
    last = run.stopped[0, 0]
    assert len(found["/state"]) == len(run.time)
    assert found["/state"][-1][1].mode == "stopped"
    assert len(found["/odom"]) == last + 1


def test_moving_obstacles_move(tmp_path):
    scenario = short("obstacles-on-two-paths", 1.0)
    scenario = replace(
        scenario, obstacles=(Disc(radius=0.2, path=Line(start=(2.0, 5.0), end=(4.0, 5.0)), timing=Timing(speed=0.1)),)
    )
    run = simulate(scenario, "obstacles")
    write_mcap(run, tmp_path / "run.mcap")
    scenes = read(tmp_path / "run.mcap")["/scene"]
    places = [[m.pose.position.x for m in scene.markers if m.ns == "obstacles"] for _, scene in scenes]
    np.testing.assert_allclose(np.ravel(places), 2.0 + 0.1 * run.time, atol=1e-9)


# Bad input, and files ---------------------------------------------------------------------------------------------


def test_several_seeds_need_a_seed_or_get_a_file_each(tracking, tmp_path, capsys, monkeypatch):
    with pytest.raises(LogError, match="a log holds the run of one seed, and this run has 2: name the seed"):
        write_mcap(tracking, tmp_path / "a.mcap")
    with pytest.raises(LogError, match="the run has no seed 9: it has 4, 5"):
        write_mcap(tracking, tmp_path / "a.mcap", seed=9)
    assert not list(tmp_path.iterdir())
    monkeypatch.chdir(tmp_path)
    (tmp_path / "short.toml").write_text(
        "duration = 1.0\n[[robots]]\nstart = [0.0, 0.0, 0.0]\n"
        'path = { shape = "line", start = [0.0, 0.0], end = [2.0, 0.0] }\ntiming = { speed = 0.3 }\n',
        encoding="utf-8",
    )
    command = ["run", "short.toml", "-c", "lyapunov", "-q", "--seeds", "2", "--seed", "3"]
    assert main([*command, "--mcap", "run.mcap", "--rosbag", "bag", "--layout", "panels.json"]) == 0
    assert sorted(p.name for p in tmp_path.iterdir()) == [
        "bag-seed-3", "bag-seed-4", "panels.json", "run-seed-3.mcap", "run-seed-4.mcap", "short.toml",
    ]  # fmt: skip
    assert read("run-seed-4.mcap")["/run_info"][0][1].seed == 4
    assert main([*command, "--rosbag", "bag"]) == 2
    assert "bag-seed-3: exists already, and a rosbag2 folder is never overwritten" in capsys.readouterr().err


@pytest.mark.parametrize(
    ("options", "said"),
    [
        (["--mcap", "run.bag"], "run.bag: the file's name must end in .mcap"),
        (["--mcap", "nowhere/run.mcap"], "there is no folder 'nowhere' to write into"),
        (["--layout", "run.txt"], "run.txt: the file's name must end in .json"),
        (["--mcap", "run.mcap", "--ros", "humbel"], "unknown ROS 2 distribution 'humbel'; did you mean 'humble'?"),
        (["--rosbag", "bag", "--storage", "sqlite"], "unknown storage of a rosbag2 folder 'sqlite'"),
    ],
)
def test_bad_options_are_refused_before_the_run(options, said, tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr("robotics.simulation.loop.simulate", lambda *_, **__: pytest.fail("it ran"))
    assert main(["run", "lyapunov-sine", "-q", *options]) == 2
    assert said in capsys.readouterr().err
    assert not list(tmp_path.iterdir())


def test_nothing_half_written_stays(tracking, tmp_path, monkeypatch):
    (tmp_path / "old.mcap").write_bytes(b"old")

    def fails(*_, **__):
        raise OSError(28, "No space left on device")

    monkeypatch.setattr("rosbags.rosbag2.Writer.write", fails)
    with pytest.raises(OSError, match="No space left"):
        write_mcap(tracking, tmp_path / "old.mcap", seed=4)
    with pytest.raises(OSError, match="No space left"):
        write_rosbag(tracking, tmp_path / "bag", seed=4)
    assert [(p.name, p.read_bytes()) for p in tmp_path.iterdir()] == [("old.mcap", b"old")]


def test_a_folder_that_is_there_is_kept(tracking, tmp_path):
    (tmp_path / "bag").mkdir()
    with pytest.raises(TargetError, match="exists already"):
        write_rosbag(tracking, tmp_path / "bag", seed=4)
    assert not list((tmp_path / "bag").iterdir())


def test_without_rosbags_the_command_says_how_to_get_it(tracking, tmp_path, monkeypatch):
    monkeypatch.setitem(sys.modules, "rosbags.typesys", None)
    with pytest.raises(InputError, match=r"logs need the package rosbags: pip install 'rosbags>="):
        write_mcap(tracking, tmp_path / "a.mcap", seed=4)


# The layout -------------------------------------------------------------------------------------------------------


def panels_in(tree):
    return [tree] if isinstance(tree, str) else [*panels_in(tree["first"]), *panels_in(tree["second"])]


def resolved(log, path):
    """What a message path of the layout finds in the log: /topic.field.field[3]."""
    topic = max((t for t in log if path == t or path.startswith(f"{t}.")), key=len)
    value = log[topic][0][1]
    for name, place in re.findall(r"\.(\w+)(?:\[(\d+)\])?", path[len(topic) :]):
        value = getattr(value, name)
        value = value[int(place)] if place else value
    return value


@pytest.mark.parametrize("name", ["one", "team"])
def test_every_path_of_the_layout_leads_to_something_in_the_log(name, tracking, team, logged, tmp_path):
    write_layout(tracking if name == "one" else team, tmp_path / "layout.json")
    layout = json.loads((tmp_path / "layout.json").read_text("utf-8"))
    assert layout == layout_of(tracking if name == "one" else team)
    assert set(layout) == {"configById", "globalVariables", "userNodes", "playbackConfig", "layout"}
    assert sorted(panels_in(layout["layout"])) == sorted(layout["configById"])
    kinds = {panel.partition("!")[0] for panel in layout["configById"]}
    assert kinds == {"3D", "Plot", "StateTransitions", "RawMessages"}
    for panel, config in layout["configById"].items():
        for path in config.get("paths", []):
            found = resolved(logged[name], path["value"])
            assert isinstance(found, str if panel.startswith("State") else float), path
        if "topicPath" in config:
            assert config["topicPath"] in logged[name]
        if "xAxisPath" in config:
            assert isinstance(resolved(logged[name], config["xAxisPath"]["value"]), float)
        assert set(config.get("topics", {})) <= set(logged[name])
