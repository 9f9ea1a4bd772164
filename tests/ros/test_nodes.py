"""The nodes on a real ROS 2: messages go over DDS, within this machine and this process."""

import re
import sys
import time
from dataclasses import replace
from importlib.resources import files
from math import inf
from types import SimpleNamespace

import numpy as np
import pytest

from robotics import load_run, load_scenario, simulate
from tests.ros.together import controller, farthest, simulator, spun

pytestmark = pytest.mark.usefixtures("ros")


@pytest.fixture
def probe(ros):
    """A node of the test's own, for what a robot would send and receive."""
    from rclpy.node import Node

    return lambda: Node("probe")


def odometry(x=0.0, y=1.0, heading=0.0, off=0.0):
    """Odometry of the robot of the scenario reference, at its start, as of now or ``off`` [s] later."""
    from fuzzyfleet_ros.frames import Posture
    from fuzzyfleet_ros.messages import odometry as made

    return made(time.time_ns() + round(1e9 * off), "odom", "base_link", Posture(x, y, heading), 0.0, 0.0)


def drive_team(tmp_path, scenario, law, seconds, **more):
    """The run of a team in lockstep, over DDS."""
    robots = len(load_scenario(scenario).robots)
    both = {"scenario": scenario, "law": law, "lockstep": True}
    file = tmp_path / "run.npz"
    makers = [
        controller(f"/robot{i + 1}" if robots > 1 else "", **both, member=i + 1, odom_timeout=20.0, **more)
        for i in range(robots)
    ]
    # However busy the machine is, no period goes on without a robot.
    told = {"duration": float(seconds), "seed": 3, "save": str(file), "step_timeout": 60.0}
    with spun(simulator(**both, **told), *makers) as (nodes, until):
        assert until(lambda: nodes[0].done, 120)
        nodes[0].leave()
    return load_run(file)


def test_three_robots_in_lockstep_drive_as_without_ros(tmp_path):
    run = drive_team(tmp_path, "noisy-position", "cooperation", 3.0)
    assert len(run.time) == 61
    told = replace(load_scenario("noisy-position"), duration=3.0)
    assert farthest(run, simulate(told, "cooperation", [3])) < 1e-3  # m, as is asked for;
    assert farthest(run, simulate(told, "cooperation", [3])) < 1e-9  # and as it is


@pytest.mark.long
@pytest.mark.parametrize(
    ("scenario", "law", "seconds"),
    [
        ("outage-10s", "cooperation", 40),  # faults of a robot and of its radio
        ("formation-behind", "leader-follower", 20),  # followers read the leader's odometry
        ("turn-into-neighbour", "obstacles", 15),  # range sensors
        ("reference", "nmpc", 10),
        ("start-off-paths", "virtual-structure", 20),
    ],
)
def test_every_kind_of_law_in_lockstep_drives_as_without_ros(tmp_path, scenario, law, seconds):
    run = drive_team(tmp_path, scenario, law, seconds)
    told = replace(load_scenario(scenario), duration=float(seconds))
    assert farthest(run, simulate(told, law, [3])) < 1e-3


@pytest.mark.long
def test_passive_safety_in_lockstep_acts_as_without_ros(tmp_path, monkeypatch):
    """Three robots under a law that hears and sees nothing; their monitors do."""
    scenario = tmp_path / "odometry.toml"
    text = (files("robotics.data") / "scenarios" / "three-cross.toml").read_text(encoding="utf-8")
    scenario.write_text(re.sub(r"\[sensing\]\n(?:.+\n)*", "", text), encoding="utf-8")  # by odometry
    said: list[str] = []
    monkeypatch.setattr("fuzzyfleet_ros.controllernode.Controller.get_logger", lambda self: Said(said))
    run = drive_team(tmp_path, str(scenario), "fuzzy:safe=yes", 24)
    told = replace(load_scenario(scenario), duration=24.0)
    assert farthest(run, simulate(told, "fuzzy", [3])) > 0.1
    assert farthest(run, simulate(told, "fuzzy:safe=yes", [3])) < 1e-3
    assert sum("no sensor looks at" in line for line in said) == 3


class Said:
    """A logger that keeps what is said."""

    def __init__(self, lines):
        self.info = self.warning = self.error = lines.append


def test_faults_of_the_radio_reach_the_robots(tmp_path):
    """A good radio brings messages, one that loses all brings none, and a dead robot is silent."""
    team = (
        'kind = "team"\nduration = 2.0\n[radio]\nlatency = 0.1\n{radio}\n'
        '[[faults]]\nkind = "failure"\nrobot = 2\nstart = 0.5\nduration = 9.0\n'
        + "".join(
            f"[[robots]]\nstart = [0.0, {y}, 0.0]\n"
            f'[robots.path]\nshape = "line"\nstart = [0.0, {y}]\nend = [2.0, {y}]\n'
            "[robots.timing]\nduration = 20.0\n"
            for y in (0.0, 1.0)
        )
    )
    ages = {}
    for name, radio in (("good", ""), ("lossy", "loss = 1.0")):
        file = tmp_path / f"{name}.toml"
        file.write_text(team.format(radio=radio), encoding="utf-8")
        both = {"scenario": str(file), "law": "cooperation", "lockstep": True}
        makers = [controller(f"/robot{i}", **both, member=i, odom_timeout=20.0) for i in (1, 2)]
        with spun(simulator(**both), *makers) as (nodes, until):
            assert until(lambda: nodes[0].loop.k == 8 or nodes[0].done)
            early = nodes[1].received.ages(0.0)[1]  # those that came with the last period
            assert until(lambda: nodes[0].done)
            ages[name] = early, nodes[0].sensed.heard.age[0, 0, 1]
    assert ages["lossy"] == (inf, inf)
    assert np.isfinite(ages["good"][0])
    assert ages["good"][1] > 1.2  # s since robot 2 died


@pytest.mark.parametrize(("timeout", "stops"), [(0.3, True), (0.0, False)])
def test_a_robot_without_odometry_stops_and_goes_on_when_it_comes_back(probe, timeout, stops):
    from geometry_msgs.msg import TwistStamped
    from nav_msgs.msg import Odometry

    drives = controller(scenario="reference", odom_timeout=timeout)
    with spun(probe, drives) as ((own, node), until):
        told = []
        own.create_subscription(TwistStamped, "/cmd_vel", lambda m: told.append(m.twist.linear.x), 10)
        sends = own.create_publisher(Odometry, "/odom", 10)
        send = own.create_timer(0.02, lambda: sends.publish(odometry()))
        assert until(lambda: told and told[-1] > 0.05)
        send.cancel()
        lost = time.monotonic()
        until(lambda: told[-1] == 0.0 or time.monotonic() > lost + 1.0, 5)
        assert (told[-1] == 0.0) == stops
        if stops:
            assert node.standing.why == "its odometry is older than 0.3 s"
            assert until(lambda: time.monotonic() > lost + 0.7)
            send.reset()
            assert until(lambda: told[-1] > 0.05)
            assert node.waited > 0.2e9  # ns: the reference has waited


def test_a_robot_whose_driver_repeats_itself_stands_and_says_so_once(probe):
    from geometry_msgs.msg import TwistStamped
    from nav_msgs.msg import Odometry

    drives = controller(scenario="reference", odom_timeout=0.3)
    with spun(probe, drives) as ((own, node), until):
        told: list = []
        said = Warned(node)
        own.create_subscription(TwistStamped, "/cmd_vel", lambda m: told.append(m.twist.linear.x), 10)
        sends = own.create_publisher(Odometry, "/odom", 10)
        send = own.create_timer(0.02, lambda: sends.publish(odometry()))
        assert until(lambda: told and told[-1] > 0.05)
        send.cancel()
        last = odometry()
        again = own.create_timer(0.02, lambda: sends.publish(last))
        assert until(lambda: told[-1] == 0.0, 5)
        until(lambda: False, 0.3)
        assert [text for text in said if "does not move on" in text] == [
            f"odometry of robot1 is ignored: its stamp, {node.stamps['odometry 0'] / 1e9:.9g} s, does not move on"
        ]
        again.cancel()
        send.reset()
        assert until(lambda: told[-1] > 0.05)


@pytest.mark.parametrize(("off", "words"), [(-100.0, "100 s behind"), (100.0, "100 s ahead of")])
def test_odometry_of_another_time_moves_nobody(probe, off, words):
    from geometry_msgs.msg import TwistStamped
    from nav_msgs.msg import Odometry

    with spun(probe, controller(scenario="reference", odom_timeout=0.5)) as ((own, node), until):
        told: list = []
        said = Warned(node)
        own.create_subscription(TwistStamped, "/cmd_vel", told.append, 10)
        sends = own.create_publisher(Odometry, "/odom", 10)
        own.create_timer(0.02, lambda: sends.publish(odometry(off=off)))
        assert until(lambda: said)
        until(lambda: False, 0.3)
        assert (told, node.known) == ([], {})
        assert len(said) == 1
        assert words in said[0]


def test_a_robot_that_is_lost_and_hears_no_more_says_each_reason_once(probe):
    from nav_msgs.msg import Odometry

    with spun(probe, controller(scenario="reference", odom_timeout=0.3)) as ((own, node), until):
        said = Warned(node)
        sends = own.create_publisher(Odometry, "/odom", 10)
        send = own.create_timer(0.02, lambda: sends.publish(odometry()))
        assert until(lambda: node.begin is not None)
        send.cancel()
        sends.publish(odometry(x=1e300))
        assert until(lambda: said)
        until(lambda: False, 1.0)
        assert len(said) == len(set(said)) == 1, said
        assert said[0].startswith("the robot stands: it is stopped for good")


def test_a_follower_stands_while_the_leaders_odometry_stays_away(probe):
    from nav_msgs.msg import Odometry

    drives = controller("/robot2", scenario="formation-behind", law="leader-follower", member=2, odom_timeout=0.3)
    with spun(probe, drives) as ((own, node), until):
        topics = [own.create_publisher(Odometry, f"/robot{j}/odom", 10) for j in (1, 2, 3)]

        def send(*robots):
            for j in robots:
                topics[j].publish(odometry(*node.task.start_of(j)))

        every = own.create_timer(0.02, lambda: send(0, 1, 2))
        assert until(lambda: node.begin is not None)
        every.cancel()
        own.create_timer(0.02, lambda: send(1, 2))
        assert until(lambda: node.standing.why == "the odometry of robot1 is older than 0.3 s", 5)


class Warned(list):
    """What a node warns of."""

    def __init__(self, node):
        super().__init__()
        logger = node.get_logger()
        node.get_logger = lambda: SimpleNamespace(
            warning=lambda text, **how: self.append(text), info=logger.info, error=logger.error
        )


def test_a_twist_without_a_stamp_and_a_base_whose_driver_is_gone(probe):
    from geometry_msgs.msg import Twist

    with spun(probe, simulator(stamped=False, waits=False, cmd_vel_timeout=0.2)) as ((own, node), until):
        sends = own.create_publisher(Twist, "/cmd_vel", 10)
        message = Twist()
        message.linear.x = 0.2
        send = own.create_timer(0.02, lambda: sends.publish(message))
        assert until(lambda: node.sensed.speed[0, 0] > 0.15)
        send.cancel()
        assert until(lambda: abs(node.sensed.speed[0, 0]) < 0.01)


def test_what_the_simulator_says_is_what_it_senses(probe):
    from nav_msgs.msg import Odometry
    from rosgraph_msgs.msg import Clock
    from sensor_msgs.msg import JointState, Range

    heard: dict = {}
    given = {"scenario": "turn-into-neighbour", "law": "obstacles", "lockstep": True}
    with spun(probe, simulator(**given)) as ((own, node), until):
        for kind, topic in (
            (Odometry, "/robot2/odom"),
            (Odometry, "/robot2/ground_truth"),
            (JointState, "/robot2/joint_states"),
            (Range, "/robot2/range/front_left"),
            (JointState, "/robot2/heard"),
            (Clock, "/clock"),
        ):
            own.create_subscription(kind, topic, lambda message, topic=topic: heard.__setitem__(topic, message), 10)
        assert until(lambda: len(heard) == 6)
        seen = node.sensed
    odom = heard["/robot2/odom"]
    assert (odom.header.frame_id, odom.child_frame_id) == ("robot2/odom", "robot2/base_link")
    assert (odom.pose.pose.position.x, odom.pose.pose.position.y) == tuple(seen.posture[:2, 1])
    assert heard["/robot2/ground_truth"].header.frame_id == "map"
    assert list(heard["/robot2/joint_states"].name) == ["wheel_left_joint", "wheel_right_joint"]
    sonar = heard["/robot2/range/front_left"]
    assert (sonar.header.frame_id, sonar.radiation_type) == ("robot2/front_left", Range.ULTRASOUND)
    assert sonar.field_of_view == pytest.approx(2 * 37 * np.pi / 180)
    assert heard["/clock"].clock.sec == 1


def test_a_path_that_comes_is_driven_and_a_bad_one_is_refused(probe):
    from geometry_msgs.msg import TwistStamped
    from nav_msgs.msg import Odometry
    from nav_msgs.msg import Path as PathMessage

    from fuzzyfleet_ros import messages
    from fuzzyfleet_ros.frames import Posture

    def path(frame, *points):
        return messages.path(0, frame, [Posture(x, y, 0.0) for x, y in points])

    with spun(probe, controller(robot="turtlebot3-burger", path_speed=0.15, origin="start")) as ((own, node), until):
        told = []
        own.create_subscription(TwistStamped, "/cmd_vel", lambda m: told.append(m.twist.linear.x), 10)
        moves = own.create_publisher(Odometry, "/odom", 10)
        sends = own.create_publisher(PathMessage, "/path", 1)
        own.create_timer(0.02, lambda: moves.publish(odometry(x=5.0, y=5.0)))
        assert until(lambda: sends.get_subscription_count() == 1 and node.known)
        for bad in (path("map", (0, 0), (1, 0)), path("odom", (0, 0)), path("odom", (0, 0), (0, 0))):
            sends.publish(bad)
            until(lambda: False, 0.2)
        assert node.task is None
        assert told == []
        sends.publish(path("odom", (0, 0), (0.5, 0), (1, 0)))
        assert until(lambda: node.begin is not None and told and told[-1] > 0.01)
        assert node.known[0].posture == pytest.approx((0.0, 0.0, 0.0), abs=1e-9)  # where the path begins
        place = node._in_odometry(node.task.start)  # type: ignore[attr-defined]
        assert place == pytest.approx((5.0, 5.0, 0.0), abs=1e-9)


def test_radio_of_robots_that_hear_each_other_directly(probe):
    from nav_msgs.msg import Odometry
    from sensor_msgs.msg import JointState

    from fuzzyfleet_ros import messages

    drives = controller("/robot1", scenario="noisy-position", law="cooperation", radio="direct")
    with spun(probe, drives) as ((own, node), until):
        said: list = []
        own.create_subscription(JointState, "/robot1/radio", said.append, 10)
        other = own.create_publisher(JointState, "/robot2/radio", 10)
        moves = own.create_publisher(Odometry, "/robot1/odom", 10)
        x, y, heading = node.task.start
        words = list(node.law.message)

        def send():
            moves.publish(odometry(x=x, y=y, heading=heading))
            now = own.get_clock().now().nanoseconds
            other.publish(messages.words(now, "robot2", words, [0.5] * len(words)))

        own.create_timer(0.02, send)
        assert until(lambda: said and np.isfinite(node.received.age[1]))
        assert list(said[-1].name) == words
        assert node.received.values[:, 1].tolist() == [0.5] * len(words)
        assert np.isinf(node.received.age[2])


@pytest.mark.parametrize(
    ("parameters", "sentence"),
    [
        ({"law": "nonsense"}, "nonsense"),
        ({"scenario": "nowhere"}, "nowhere"),
        ({"scenario": "reference", "member": 4}, "robots are 1 to 1, got 4"),
        ({"scenario": "reference", "law": "csm"}, "torque_as_velocity"),
        ({"scenario": "reference", "odom_timeout": -1.0}, "odom_timeout must be >= 0 and <= 60, got -1.0"),
        ({"scenario": "reference", "rate": 30.0}, "rate must be 100 Hz divided by a whole number"),
        ({"scenario": "reference", "stamped": "yes"}, "stamped must be true or false, got 'yes'"),
        ({"scenario": "reference", "v_max": float("nan")}, "v_max must be"),
        ({"scenario": "reference", "odom_timout": 1.0}, "odom_timeout"),
        ({"scenario": "reference", "origin": "here"}, "origin must be odom or start, got 'here'"),
        ({"lockstep": True}, "lockstep needs a scenario"),
        ({"robot": "unknown"}, "unknown"),
    ],
)
def test_a_bad_parameter_is_a_sentence(parameters, sentence):
    from fuzzy.errors import InputError

    with pytest.raises(InputError) as caught:
        controller(**parameters)()
    assert sentence in str(caught.value)


def test_parameters_are_declared_with_their_bounds():
    with spun(controller(scenario="reference", odom_timeout=1)) as ((node,), _):
        assert node.get_parameter("odom_timeout").value == 1.0
        described = node.describe_parameter("odom_timeout")
        assert described.read_only
        assert described.description.startswith("The age of odometry")
        assert described.floating_point_range[0].to_value == 60.0


def test_a_controller_that_goes_by_the_simulators_clock_begins_and_drives():
    drives = controller(scenario="reference", use_sim_time=True)
    with spun(simulator(clock=True), drives) as ((node, other), until):
        assert until(lambda: node.sensed.speed[0, 0] > 0.1)
        assert other.begin < 60e9  # ns, by that clock


@pytest.mark.long
def test_a_path_that_is_driven_is_over_once_and_another_one_begins(probe):
    from nav_msgs.msg import Odometry, Path

    from fuzzyfleet_ros import messages
    from fuzzyfleet_ros.frames import Posture

    with spun(probe, controller(path_speed=0.5, path_ramp=0.0, rate=20.0, odom_timeout=0.0)) as ((own, node), until):
        told: list[str] = []
        node.get_logger = lambda: SimpleNamespace(warning=told.append, info=told.append, error=told.append)
        moves, paths = own.create_publisher(Odometry, "odom", 10), own.create_publisher(Path, "path", 1)
        own.create_timer(0.02, lambda: moves.publish(odometry(x=0.05, y=0.0)))
        assert until(lambda: paths.get_subscription_count() and node.known)
        for drives in (1, 2):
            paths.publish(messages.path(0, "odom", [Posture(x, 0.0, 0.0) for x in (0.0, 0.05, 0.1)]))
            assert until(lambda n=drives: sum("is over" in said for said in told) == n), told
            later = own.get_clock().now().nanoseconds + 500_000_000
            assert until(lambda at=later: own.get_clock().now().nanoseconds > at)
            assert node.waited == 0
            assert sum("is over" in said for said in told) == drives
            assert sum("drives on" in said for said in told) == drives - 1  # for another path alone


def test_frames_are_told_where_tf2_is_installed(probe, monkeypatch):
    """Its wheels are not on PyPI: a module of the test's own stands in for it."""
    from fuzzyfleet_ros.frames import Posture
    from fuzzyfleet_ros.simulatornode import Transforms

    sent: list = []

    class Broadcaster:
        def __init__(self, node):
            pass

        def sendTransform(self, made):  # the name that tf2_ros gives it
            sent.extend((m.header.frame_id, m.child_frame_id, m.transform.translation.x) for m in made)

    stand_in = SimpleNamespace(TransformBroadcaster=Broadcaster, StaticTransformBroadcaster=Broadcaster)
    mounts = [{"front-left": Posture(0.1, 0.0, 0.0)}, {}]
    monkeypatch.setitem(sys.modules, "tf2_ros", None)
    with spun(probe) as ((own,), _):
        Transforms(own, 2, mounts).tell(0, 1, Posture(3.0, 0.0, 0.0))
        assert sent == []
        monkeypatch.setitem(sys.modules, "tf2_ros", stand_in)
        Transforms(own, 2, mounts).tell(1, 1, Posture(3.0, 0.0, 0.0))
    assert sent == [
        ("map", "robot1/odom", 0.0),
        ("robot1/base_link", "robot1/front_left", 0.1),
        ("map", "robot2/odom", 0.0),
        ("robot2/odom", "robot2/base_link", 3.0),
    ]
