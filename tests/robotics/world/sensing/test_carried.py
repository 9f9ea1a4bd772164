"""What each robot carries: in a scenario's file, in the readings, and what a law that needs it is told."""

from dataclasses import replace

import numpy as np
import pytest

from robotics.laws.catalogue import make_controller
from robotics.laws.law import ControllerError
from robotics.simulation.loop import simulate
from robotics.simulation.scenario.description import ScenarioError
from robotics.simulation.scenario.reading import load_scenario, parse_scenario
from robotics.world.environment.collision import footprints
from robotics.world.environment.world import Wall, World, compile_world
from robotics.world.sensing.carried import CarriedSensors, sensor_names
from robotics.world.sensing.sonar import SONAR, Ranges, RangeSensor, SonarError
from tests.robotics.world.sensing.readings import TICK, Readings
from tests.robotics.world.vehicle.etsro import ETSRO

ROOM = compile_world(
    World(obstacles=(Wall(points=((-2.0, -2.0), (3.0, -2.0), (3.0, 2.0), (-2.0, 2.0), (-2.0, -2.0))),))
)
EMPTY = compile_world(World()).at(0.0)
FILE = """duration = 2.0
{sensors}
[[robots]]
start = [0.0, 0.0, 0.0]
path = {{ shape = "line", start = [0.0, 0.0], end = [2.0, 0.0] }}
timing = {{ speed = 0.2 }}
{own}
[[obstacles]]
shape = "disc"
position = [1.5, 0.0]
radius = 0.2
"""


def parsed(sensors="", own=""):
    return parse_scenario(FILE.format(sensors=sensors, own=own), "one", "one.toml")


def carried(scenario):
    return scenario.setting.sensors[0]


def test_without_a_word_a_robot_carries_its_four_sonars():
    assert carried(parsed()) == SONAR


def test_a_file_says_what_all_robots_carry():
    text = """
[[sensors]]
preset = "sonar"
noise = 0.03

[[sensors]]
name = "rear"
x = -0.115
axis = 3.14159
half_cone = 0.2
rays = 5
failure_start = 3.0
"""
    found = carried(parsed(text))
    assert list(found) == [*SONAR, "rear"]
    assert all(found[name] == replace(SONAR[name], noise=0.03) for name in SONAR)
    assert found["rear"] == RangeSensor(x=-0.115, axis=3.14159, half_cone=0.2, rays=5, failure_start=3.0)
    assert carried(parsed("sensors = []")) == {}


def test_a_robot_may_carry_its_own():
    own = '\n[[robots.sensors]]\nname = "nose"\nrange = 1.0\n'
    assert carried(parsed("", own)) == {"nose": RangeSensor(range=1.0)}


@pytest.mark.parametrize(
    ("sensors", "own", "line", "message"),
    [
        ('[[sensors]]\nname = "a"\nnoize = 1.0', "", 4, "unknown key 'noize'; did you mean 'noise'?"),
        ('[[sensors]]\nname = "a"\n[[sensors]]\nname = "a"', "", 4, "there are two sensors called 'a'"),
        ("[[sensors]]\nrange = 1.0", "", 2, "a sensor needs a name"),
        ('[[sensors]]\npreset = "radar"', "", 3, "unknown sensor preset 'radar'"),
        ('[[sensors]]\nname = "a"\npreset = "sonar"', "", 4, "give name or preset, not both"),
        ('[[sensors]]\nname = "a"\nrange = -1.0', "", 4, "range must be a finite number in m, > 0"),
        ("sensors = 3", "", 2, "sensors must be tables [[sensors]]"),
        ("", '[[robots.sensors]]\nname = "a"\n[[robots.sensors]]\nname = "b"\nrays = 0', 11, "rays must be a whole"),
        ('[[sensors]]\nname = "a"\nfailure_end = 1.0', "", 4, "failure_end must be > failure_start"),
    ],
)
def test_what_is_wrong_with_a_sensor_is_named_with_its_line(sensors, own, line, message):
    with pytest.raises(ScenarioError) as caught:
        parsed(sensors, own)
    assert str(caught.value).startswith(f"one.toml:{line}: ")
    assert message in str(caught.value)


def test_robots_that_carry_different_sensors_read_what_each_would_alone():
    beam, rear = RangeSensor(range=5.0, noise=0.01), RangeSensor(range=5.0, axis=np.pi, noise=0.01)
    sensors: tuple[dict[str, RangeSensor], ...] = (
        {"nose": beam},
        {"rear": rear, "nose": replace(beam, range=1.0)},
        {"nose": beam},
        {},
    )
    assert sensor_names(sensors) == ("nose", "rear")
    x, y, heading = np.array([[[0.0, 1.0, -1.0, 0.0]], [[0.0, 1.0, -1.0, 1.5]], [[0.0, 0.3, 2.0, 0.0]]])
    sizes = footprints([ETSRO] * 4)
    all_of_them = Readings((), (3,), sizes, ROOM.at(0.0), carried=sensors)
    found = Ranges(all_of_them.carried.names, all_of_them.at(0, x, y, heading))
    expected = Readings([beam], (3,), sizes, ROOM.at(0.0)).at(0, x, y, heading)
    assert found["nose"][0, [0, 2]].tolist() == expected[0, [0, 2], 0].tolist()
    expected = Readings([*sensors[1].values()], (3,), sizes, ROOM.at(0.0)).at(0, x, y, heading)
    assert found.of(("rear", "nose"))[0, 1].tolist() == expected[0, 1].tolist()
    assert np.isinf(found["rear"][0, [0, 2, 3]]).all()
    assert np.isinf(found["nose"][0, 3])


def test_pings_are_heard_of_robots_that_carry_the_same_sensors_only():
    beam = RangeSensor(x=0.115, half_cone=0.5, rays=5, range=2.0, crosstalk=1.0)
    sizes, poses = footprints([ETSRO] * 2), (np.array([[0.0, 1.6]]), np.zeros((1, 2)), np.array([[0.0, np.pi]]))
    alike = Readings([beam], (0,), sizes, EMPTY).at(0, *poses)
    np.testing.assert_allclose(alike[..., 0], 1.37 / 2)
    unlike = ({"nose": beam}, {"nose": replace(beam, range=1.9)})
    np.testing.assert_allclose(Readings((), (0,), sizes, EMPTY, carried=unlike).at(0, *poses)[..., 0], 1.37)


def test_a_sensor_sees_nothing_while_it_fails():
    beam = RangeSensor(range=5.0, failure_start=0.1, failure_end=0.2)
    pair = [beam, replace(beam, failure_start=None, failure_end=None)]
    readings, zero = Readings(pair, (0,), footprints([ETSRO]), ROOM.at(0.0)), np.zeros((1, 1))
    read = [readings.at(k, zero, zero, zero)[0, 0].tolist() for k in range(6)]
    assert read == [[3.0, 3.0]] * 2 + [[np.inf, 3.0]] * 2 + [[3.0, 3.0]] * 2


def test_ranges_are_found_by_name_in_any_order():
    ranges = Ranges(("a", "b"), np.array([[[1.0, 2.0]]]))
    assert ranges["b"].tolist() == [[2.0]]
    assert ranges.of(("b", "a")).tolist() == [[[2.0, 1.0]]]
    with pytest.raises(ValueError, match="not in tuple"):
        ranges["c"]


def test_a_law_is_refused_where_a_robot_lacks_what_it_needs():
    scenario = parsed('[[sensors]]\nname = "left"')
    with pytest.raises(ControllerError, match="robot 1 lacks the range sensors front-left, front-right, right that"):
        simulate(scenario, make_controller("obstacles"))
    with pytest.raises(ScenarioError, match=r"^one\.toml:2: one: robot 1 lacks .* it carries none; add a table"):
        parsed('controller = "obstacles"\nsensors = []')


def test_the_same_law_meets_other_sensors_than_before():
    """Blind for the first seconds, the robot drives up to the disc; its own noise is what the file says."""
    course = load_scenario("obstacles-on-two-paths")
    blind = {name: replace(sensor, failure_start=0.0) for name, sensor in SONAR.items()}
    law = make_controller("obstacles")
    seeing = simulate(replace(course, duration=20.0), law)
    without = simulate(replace(course, duration=20.0, sensors=blind), law)
    assert (seeing.modes > 0).any()
    assert not (without.modes > 0).any()
    assert np.isinf(without.ranges).all()


def test_a_period_that_does_not_fit_is_refused():
    with pytest.raises(SonarError, match="period must be a multiple"):
        CarriedSensors.opened([{"a": RangeSensor(period=0.07)}], 1, (0,), TICK)
