"""Drives read back: those of our own logs, and those of robots that write theirs otherwise."""

import shutil
from contextlib import suppress
from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from robotics.plugins.logs.bag import opened
from robotics.plugins.logs.drive import read_drive
from robotics.plugins.logs.typestore import LogError
from robotics.plugins.logs.writing import write_mcap, write_rosbag
from robotics.simulation.loop import simulate
from robotics.simulation.scenario.reading import load_scenario
from tests.robotics.plugins.logs import bags

KEPT: dict[str, Any] = {"message_ages": True, "encoders": True, "messages": True}


@pytest.fixture(scope="module")
def run():
    return simulate(replace(load_scenario("three-cross"), duration=1.5), "right-of-way", [2], **KEPT)


@pytest.fixture(scope="module")
def log(run, tmp_path_factory):
    path = tmp_path_factory.mktemp("drive") / "run.mcap"
    write_mcap(run, path)
    return path


def straight(count=40, rate=20.0, begin=bags.EPOCH, **topics):
    """Rows of a drive straight on at 0.2 m/s, its odometry and its commands on these topics."""
    odom, commands = topics.get("odom", "/odom"), topics.get("commands", "/cmd_vel")
    rows = []
    for k in range(count):
        time = begin + k / rate
        rows.append((time, odom, bags.odometry(time, (0.2 * k / rate, 0.0, 0.0), 0.2, 0.0)))
        rows.append((time, commands, bags.twist(0.2, 0.0)))
    return rows


def test_a_drive_of_our_own_log_is_that_of_the_run(run, log):
    drive = read_drive(log, "robot2")
    assert (drive.log, drive.robot) == ("run.mcap", "robot2")
    assert set(drive.clocks.values()) == {"headers"}
    np.testing.assert_allclose(drive.odometry.time, run.time, atol=1e-9)
    for name in ("x", "y"):
        np.testing.assert_array_equal(getattr(drive.odometry, name), run[f"{name}_measured"][0, 1])
        np.testing.assert_array_equal(getattr(drive.reference, name), run.target(name)[1])
    heading = run["heading_measured"][0, 1]
    np.testing.assert_allclose(np.exp(1j * drive.odometry.heading), np.exp(1j * heading), atol=1e-14)
    assert np.abs(np.diff(drive.odometry.heading)).max() < 1.0
    np.testing.assert_array_equal(drive.odometry.v, run.encoders[:, 2, 0, 1])
    np.testing.assert_array_equal(drive.commands.w, run["command_2"][0, 1])


@pytest.mark.parametrize("storage", ["mcap", "sqlite3"])
def test_both_storages_and_a_single_file_of_one_read_alike(run, log, tmp_path, storage):
    write_rosbag(run, tmp_path / "bag", storage=storage, distribution="humble")
    single = next(file for file in (tmp_path / "bag").iterdir() if file.suffix != ".yaml")
    for path in (tmp_path / "bag", single):
        drive = read_drive(path, "/robot3/")
        np.testing.assert_array_equal(drive.odometry.x, run["x_measured"][0, 2])


def test_a_bag_of_odometry_and_unstamped_commands_is_enough(tmp_path):
    drive = read_drive(bags.write(tmp_path / "bag", straight()))
    assert drive.topics == {"odometry": "/odom", "commands": "/cmd_vel"}
    assert drive.clocks == {"odometry": "headers", "commands": "arrival"}
    assert (drive.reference, drive.plans) == (None, ())
    assert len(drive.commands.time) == 40


def test_stamped_commands_count_by_their_headers_not_by_when_they_came(tmp_path):
    rows = [row for row in straight() if row[1] == "/odom"]
    late = [
        (bags.EPOCH + k / 20 + 0.2, "/cmd_vel", bags.twist_stamped(bags.EPOCH + k / 20, 0.1 * k, 0.0)) for k in range(9)
    ]
    drive = read_drive(bags.write(tmp_path / "bag", [*rows, *late], "mcap"))
    np.testing.assert_allclose(drive.commands.time - bags.EPOCH, np.arange(9) / 20, atol=1e-6)
    assert drive.clocks["commands"] == "headers"


def test_what_has_no_header_is_brought_to_the_clock_of_the_headers(tmp_path):
    """A simulator's odometry counts from 0; its unstamped commands were written by the computer's clock."""
    rows = [
        (
            time,
            topic,
            bags.odometry(time - bags.EPOCH + 5.0, (0.0, 0.0, 0.0), 0.2, 0.0) if topic == "/odom" else message,
        )
        for time, topic, message in straight()
    ]
    drive = read_drive(bags.write(tmp_path / "bag", rows))
    assert drive.odometry.time[0] == pytest.approx(5.0, abs=1e-6)
    np.testing.assert_allclose(drive.commands.time, drive.odometry.time, atol=1e-5)


def test_messages_out_of_order_are_put_in_order_and_twins_count_once(tmp_path):
    rows = straight(6)
    swapped = bags.odometry(bags.EPOCH + 2 / 20, (9.0, 0.0, 0.0), 0.2, 0.0)  # a twin that comes last
    drive = read_drive(bags.write(tmp_path / "bag", [*rows[::-1], (bags.EPOCH + 1.0, "/odom", swapped)]))
    assert (np.diff(drive.odometry.time) > 0).all()
    assert len(drive.odometry.time) == 6
    assert drive.odometry.x[2] == 9.0


def test_topics_have_other_names(tmp_path):
    folder = bags.write(tmp_path / "bag", straight(odom="/wheel/odometry", commands="/teleop/cmd"))
    drive = read_drive(folder, odometry="/wheel/odometry", commands="teleop/cmd")
    assert drive.topics["odometry"] == "/wheel/odometry"
    with pytest.raises(LogError, match="there is no topic /odom; it has /teleop/cmd "):
        read_drive(folder, odometry="/odom")


def test_two_of_a_kind_must_be_named(tmp_path):
    rows = straight(odom="/a") + [row for row in straight(odom="/b") if row[1] == "/b"]
    folder = bags.write(tmp_path / "bag", rows)
    with pytest.raises(LogError, match="which topic is the odometry: /a, /b"):
        read_drive(folder)
    assert read_drive(folder, odometry="/b").topics["odometry"] == "/b"


def test_a_robot_of_several_is_chosen_by_its_namespace(log):
    with pytest.raises(LogError, match="several robots drive there; choose one with --robot: robot1, robot2, robot3"):
        read_drive(log)
    with pytest.raises(LogError, match="unknown robot 'robot4'; did you mean"):
        read_drive(log, "robot4")


# Paths, references and frames -------------------------------------------------------------------------------------


def test_a_path_with_times_is_a_reference_and_one_without_is_a_plan(tmp_path):
    points = np.stack([np.linspace(0, 3, 31), np.zeros(31)], axis=-1)
    times = bags.EPOCH + np.linspace(0, 15, 31)
    timed = [(bags.EPOCH, "/plan", bags.path(bags.EPOCH, points, times=times))]
    drive = read_drive(bags.write(tmp_path / "timed", [*straight(), *timed]))
    np.testing.assert_allclose(drive.reference.v, 0.2, atol=1e-9)
    np.testing.assert_array_equal(drive.plans[0].points, points)
    twice = [
        (bags.EPOCH + t, "/plan", bags.path(bags.EPOCH + t, points * f)) for t, f in ((0.0, 1), (0.5, 1), (1.0, 2))
    ]
    drive = read_drive(bags.write(tmp_path / "plain", [*straight(), *twice]))
    assert drive.reference is None
    assert [round(plan.time - bags.EPOCH, 6) for plan in drive.plans] == [0.0, 1.0]  # the same again is no other
    np.testing.assert_array_equal(drive.plans[1].points, 2 * points)


@pytest.mark.parametrize("inverse", [False, True])
def test_a_path_in_another_frame_is_brought_into_that_of_the_odometry(tmp_path, inverse):
    """The frame odom stands in map at (1, 2), turned by 90° to the left."""
    points = np.array([[1.0, 2.0], [1.0, 3.0], [0.0, 3.0]])
    told = ("odom", "map", -2.0, 1.0, -np.pi / 2) if inverse else ("map", "odom", 1.0, 2.0, np.pi / 2)
    rows = [
        (bags.EPOCH, "/tf", bags.transform(bags.EPOCH, *told)),
        (bags.EPOCH, "/plan", bags.path(bags.EPOCH, points, "map")),
    ]
    drive = read_drive(bags.write(tmp_path / "bag", [*straight(), *rows]))
    np.testing.assert_allclose(drive.plans[0].points, [[0.0, 0.0], [1.0, 0.0], [1.0, 1.0]], atol=1e-12)
    with pytest.raises(LogError, match="/plan is in the frame 'map' and the odometry in 'odom', and neither"):
        read_drive(bags.write(tmp_path / "lost", [*straight(), rows[1]]))


# Bad input --------------------------------------------------------------------------------------------------------


def test_what_is_no_log_is_refused(tmp_path):
    (tmp_path / "notes.txt").write_text("no log", encoding="utf-8")
    (tmp_path / "folder").mkdir()
    (tmp_path / "empty.mcap").write_bytes(b"")
    (tmp_path / "text.mcap").write_text("hello", encoding="utf-8")
    (tmp_path / "text.db3").write_text("hello", encoding="utf-8")
    (tmp_path / "text.bag").write_text("hello", encoding="utf-8")
    (tmp_path / "broken").mkdir()
    (tmp_path / "broken" / "metadata.yaml").write_text("a: [", encoding="utf-8")
    for name, said in {
        "nothing.mcap": "there is no such file or folder",
        "notes.txt": "a log is a rosbag2 folder or a file that ends in .mcap, .db3, .bag",
        "folder": "this folder is no rosbag2: it has no metadata.yaml",
        "empty.mcap": "this log cannot be opened: ",
        "text.mcap": "this log cannot be opened: ",
        "text.db3": "this log cannot be opened: ",
        "text.bag": "this log cannot be opened: ",
        "broken": "this log cannot be opened: ",
    }.items():
        with pytest.raises(LogError, match=said) as found:
            read_drive(tmp_path / name)
        assert str(found.value).startswith(str(tmp_path / name))
        assert "\n" not in str(found.value)


def test_a_folder_with_a_log_but_without_metadata_says_which_file_to_name(run, tmp_path):
    write_rosbag(run, tmp_path / "bag")
    (tmp_path / "bag" / "metadata.yaml").unlink()
    with pytest.raises(LogError, match=r"it has no metadata.yaml; name the file .*bag/bag.mcap"):
        read_drive(tmp_path / "bag")


def test_a_truncated_or_damaged_file_is_refused_wherever_it_ends(log, tmp_path):
    content = log.read_bytes()
    for cut in (5, 100, len(content) // 3, len(content) // 2, len(content) - 30, len(content) - 1):
        (tmp_path / "cut.mcap").write_bytes(content[:cut])
        with pytest.raises(LogError, match=r"cut.mcap: "):
            read_drive(tmp_path / "cut.mcap", "robot1")
    rng = np.random.default_rng(0)
    for _ in range(8):  # a flipped byte is noticed, or it changes nothing that is read; but nothing else is raised
        broken = bytearray(content)
        broken[rng.integers(len(content))] ^= int(rng.integers(1, 256))
        (tmp_path / "flipped.mcap").write_bytes(bytes(broken))
        with suppress(LogError):
            read_drive(tmp_path / "flipped.mcap", "robot1")


def test_a_bag_without_odometry_says_what_it_has(tmp_path):
    rows = [row for row in straight() if row[1] == "/cmd_vel"]
    with pytest.raises(
        LogError, match=r"there is no odometry, a topic of nav_msgs/Odometry; it has /cmd_vel \(geometry"
    ):
        read_drive(bags.write(tmp_path / "bag", rows))
    with pytest.raises(LogError, match="there is no odometry, a topic of nav_msgs/Odometry; it has no topics"):
        read_drive(bags.write(tmp_path / "empty", []))
    rows = [row for row in straight() if row[1] == "/odom"]
    with pytest.raises(LogError, match="there is no commanded velocity, a topic of geometry_msgs/TwistStamped or "):
        read_drive(bags.write(tmp_path / "other", rows))


def test_a_wrong_type_and_no_messages(tmp_path):
    folder = bags.write(tmp_path / "bag", straight())
    with pytest.raises(LogError, match="/cmd_vel is of geometry_msgs/Twist, and odometry must be of nav_msgs/Odometry"):
        read_drive(folder, odometry="/cmd_vel")
    from rosbags.rosbag2 import Writer

    with Writer(tmp_path / "silent", version=8) as writer:
        writer.add_connection("/odom", "nav_msgs/msg/Odometry", typestore=bags.STORE)
        writer.add_connection("/cmd_vel", "geometry_msgs/msg/Twist", typestore=bags.STORE)
    with pytest.raises(LogError, match="/odom has no messages"):
        read_drive(tmp_path / "silent")


def test_a_type_that_nobody_knows_matters_only_where_it_is_read(tmp_path):
    from rosbags.rosbag2 import StoragePlugin, Writer

    with Writer(tmp_path / "bag", version=8, storage_plugin=StoragePlugin.SQLITE3) as writer:
        odd = writer.add_connection(
            "/odd", "their_msgs/msg/Odd", msgdef="float64 x\nunknown/Thing y", rihs01="RIHS01_0"
        )
        writer.write(odd, 1, b"\0" * 8)
        known: dict[str, Any] = {}
        for time, topic, message in straight():
            kind = message.__msgtype__
            known.setdefault(topic, None)
            if known[topic] is None:
                known[topic] = writer.add_connection(topic, kind, typestore=bags.STORE)
            writer.write(known[topic], round(time * 1e9), bags.STORE.serialize_cdr(message, kind))
    assert len(read_drive(tmp_path / "bag").odometry.time) == 40
    with opened(tmp_path / "bag") as bag:
        topic = next(topic for topic in bag.topics if topic.name == "/odd")
        with pytest.raises(LogError, match=r"/bag: the .* cannot be read: "):
            bag.read(topic, lambda message: message)


def test_a_bag_whose_types_are_not_defined_in_it_is_read_by_those_of_a_distribution(tmp_path):
    """As ROS 2 up to Humble writes sqlite3."""
    import sqlite3

    folder = bags.write(tmp_path / "bag", straight())
    file = next(folder.glob("*.db3"))
    with sqlite3.connect(file) as database:
        database.execute("DELETE FROM message_definitions")
    database.close()
    text = (folder / "metadata.yaml").read_text("utf-8")
    assert len(read_drive(folder).odometry.time) == 40
    (folder / "metadata.yaml").write_text(text.replace("nav_msgs/msg/Odometry", "nav_msgs/msg/Odometrie"), "utf-8")
    with pytest.raises(LogError, match="there is no odometry"):
        read_drive(folder)
    shutil.rmtree(folder)
