"""Identification over topics: what is logged is what was driven, and when the robot is stopped."""

import time

import numpy as np
import pytest

from fuzzy.files.table import open_table
from robotics.plugins.identify.replay import (
    COMMANDS,
    ODOMETRY_POSES,
    POSES,
    VELOCITIES,
    YAW,
    Program,
    replayed,
    write_program,
)
from robotics.plugins.identify.signals import IdentifyError, read_signals
from robotics.simulation.scenario.robots import load_robot
from tests.ros.together import given, simulator, spun

pytestmark = pytest.mark.usefixtures("ros")
SHEET = load_robot("etsro").robot
FLOOR = """title = "An empty floor"
kind = "tracking"
duration = 60.0
latency = 0.1
[[robots]]
start = [1.0, 2.0, 0.5]
path = { shape = "line", start = [0.0, 0.0], end = [2.0, 0.0] }
timing = { speed = 0.05 }
"""


def exciter(**parameters):
    from fuzzyfleet_ros.excitenode import Exciter

    return lambda: Exciter(**given(out="", **parameters))


def identifier(**parameters):
    from fuzzyfleet_ros.identifynode import Identifier

    return lambda: Identifier(**given(out="", **parameters))


def odometry(x=0.0):
    from fuzzyfleet_ros.frames import Posture
    from fuzzyfleet_ros.messages import odometry as made

    return made(time.time_ns(), "odom", "base_link", Posture(x, 1.0, 0.3), 0.1, 0.2)


@pytest.fixture
def program(tmp_path):
    """A second and a half forward and round, in a file."""
    steps = 0.05 * np.arange(31)
    told = Program(steps, np.where(steps < 1, 0.3, -0.2), np.where(steps < 0.5, 0.0, 1.0))
    write_program(told, tmp_path / "excite.csv")
    return told


@pytest.fixture
def probe():
    """A node of the test's own, in the robot's place."""
    from rclpy.node import Node

    return lambda: Node("probe")


def test_in_lockstep_the_log_is_that_of_the_simulator_alone(tmp_path, program):
    """Commands, odometry and wheels, with the robot's latency, from wherever the robot begins."""
    floor, log = tmp_path / "floor.toml", tmp_path / "drive.csv"
    floor.write_text(FLOOR, encoding="utf-8")
    drives = exciter(commands=str(tmp_path / "excite.csv"), log=str(log), lockstep=True)
    with spun(simulator(scenario=str(floor), lockstep=True, step_timeout=60.0), drives) as ((_, node), until):
        assert until(lambda: node.done)
        node.leave()
    read, alone = read_signals(log, SHEET), replayed(SHEET, program, latency=0.1)
    count = len(program.time)
    assert read.commands.time == pytest.approx(0.05 * np.arange(count + 1))
    assert read.commands.v[:count] == pytest.approx(program.v)
    assert (read.commands.v[count], read.commands.w[count]) == (0.0, 0.0)
    assert alone.encoders is not None
    velocities = alone.encoders[:count, 2:, 0, 0].T
    assert np.stack([read.velocities.v[:count], read.velocities.w[:count]]) == pytest.approx(velocities, abs=1e-9)
    table = open_table(log)
    places = [[column.name for column in table.columns].index(name) for name in ("left", "right")]
    told = table.all_columns().values[:count, places].T
    wheels = np.array(
        [velocities[0] - SHEET.half_axle * velocities[1], velocities[0] + SHEET.half_axle * velocities[1]]
    )
    assert np.abs(told - wheels / SHEET.wheel_radius).max() < 1e-9
    assert read.poses is not None
    far = np.hypot(read.poses.x - 1.0, read.poses.y - 2.0)[:count]
    assert far == pytest.approx(np.hypot(alone["x_measured"][0, 0], alone["y_measured"][0, 0])[:count], abs=1e-6)


@pytest.mark.parametrize(
    ("what", "sentence"),
    [
        ("silence", "its odometry is older than 0.3 s"),
        ("far", r"it is 1\.4 m from the middle of its square, of 1\.3\d+ m that its outline leaves"),
        ("another", "another node commands on /cmd_vel, too"),
        ("end", "it was told to end"),
    ],
)
def test_it_stops_for_good_and_keeps_the_log(what, sentence, tmp_path, program, probe):
    from geometry_msgs.msg import TwistStamped
    from nav_msgs.msg import Odometry

    log = tmp_path / "drive.csv"
    drives = exciter(commands=str(tmp_path / "excite.csv"), log=str(log), odom_timeout=0.3)
    with spun(probe, drives) as ((own, node), until):
        told: list = []
        where = [0.5]
        sends = own.create_publisher(Odometry, "/odom", 10)
        send = own.create_timer(0.02, lambda: sends.publish(odometry(where[0])))
        assert until(lambda: node.standing.why.startswith("nobody takes the commands on /cmd_vel"))
        own.create_subscription(TwistStamped, "/cmd_vel", lambda m: told.append(m.twist.linear.x), 10)
        assert until(lambda: told and told[-1] == 0.3)
        if what == "silence":
            send.cancel()
        elif what == "far":  # the robot looks 0.3 rad to the left
            where[0] += 1.4 / np.cos(0.3)
        elif what == "another":
            own.create_publisher(TwistStamped, "/cmd_vel", 10)
        assert what == "end" or until(lambda: node.done)
        with pytest.raises(IdentifyError, match=f"stopped: {sentence}; .*drive.csv holds what it drove"):
            node.leave()
        assert until(lambda: told[-1] == 0.0)
        assert not until(lambda: told[-1] != 0.0, 0.2)
    assert len(read_signals(log, SHEET).commands.time) > 1


@pytest.mark.parametrize("ending", ["csv", "mcap"])
def test_a_drive_by_others_is_recorded_with_gyroscope_and_poses(ending, tmp_path, probe):
    from geometry_msgs.msg import PoseStamped, Twist
    from nav_msgs.msg import Odometry
    from sensor_msgs.msg import Imu, JointState

    from fuzzyfleet_ros import messages
    from fuzzyfleet_ros.frames import Posture

    log = tmp_path / f"drive.{ending}"
    listens = identifier(log=str(log), stamped=False, seconds=0.4, pose_topic="mocap")
    with spun(probe, listens) as ((own, node), until):
        kinds = {"/odom": Odometry, "/cmd_vel": Twist, "/imu": Imu, "/joint_states": JointState, "/mocap": PoseStamped}
        topics = {name: own.create_publisher(kind, name, 10) for name, kind in kinds.items()}

        def send():
            topics["/odom"].publish(odometry())
            topics["/cmd_vel"].publish(messages.twist(0.1, 0.25))
            now = time.time_ns()
            turning = Imu(header=messages.header(now, ""))
            turning.angular_velocity.z = 0.21
            topics["/imu"].publish(turning)
            topics["/joint_states"].publish(JointState(header=messages.header(now, ""), name=["arm"], velocity=[1.0]))
            topics["/mocap"].publish(messages.posed(now, "map", Posture(4.0, 5.0, 0.6)))

        own.create_timer(0.02, send)
        assert until(lambda: node.done)
        node.leave()
    named = {"pose": "pose", "imu": "imu"} if ending == "mcap" else {}
    if not named:
        columns = COMMANDS | VELOCITIES | ODOMETRY_POSES | POSES | YAW
        assert {column.name for column in open_table(log).columns} == {"time", *columns}
    read = read_signals(log, SHEET, **named)
    assert set(read.velocities.v.tolist()) == {0.1}
    assert set(read.commands.w.tolist()) == {0.25}
    assert read.yaw is not None
    assert set(read.yaw.w.tolist()) == {0.21}
    assert read.poses is not None
    assert read.poses.heading == pytest.approx(0.6)
    assert read.poses.x[0] == 4.0


def test_what_cannot_be_is_said(tmp_path, probe):
    from fuzzy.errors import InputError

    (tmp_path / "back.csv").write_text("time,v_command,w_command\n1,0,0\n0.5,0,0\n", encoding="utf-8")
    for make, sentence in (
        (exciter(log="drive.bag"), "must end in .csv, .mcap"),
        (exciter(robot="nobody"), "nobody"),
        (exciter(commands=str(tmp_path / "back.csv")), "back.csv: its times do not grow"),
        (exciter(square=0.2), "leaves the robot no room"),
        (exciter(lockstep=True, stamped=False), "lockstep needs stamped"),
        (identifier(lockstep=True), "lockstep"),
    ):
        with pytest.raises(InputError, match=sentence):
            make()
    silent = identifier(log=str(tmp_path / "drive.csv"))
    with spun(silent) as ((node,), _), pytest.raises(IdentifyError, match="nothing came on /cmd_vel"):
        node.leave()
