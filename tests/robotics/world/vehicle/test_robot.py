"""What a robot must say, what follows from it by which rule, and the packaged robots."""

from dataclasses import fields, replace
from math import pi

import numpy as np
import pytest

from robotics.simulation.scenario.robots import RobotModel, load_robot, robot_names
from robotics.world.vehicle.robot import ALTERNATIVES, IMPERFECTIONS, NEEDED, RULES, Robot, RobotError
from robotics.world.vehicle.wheel_loop import MOTIONS, step_response
from tests.robotics.world.vehicle.etsro import ETSRO

# A cart of a data sheet: 6 kg, 0.4 m x 0.3 m, 12 V motors with 2 N m at standstill and 20 rad/s without load
CART = {
    "body_mass": 6.0,
    "length": 0.4,
    "width": 0.3,
    "half_axle": 0.14,
    "wheel_radius": 0.05,
    "supply_voltage": 12.0,
    "stall_torque": 2.0,
    "no_load_speed": 20.0,
    "counts_per_turn": 2000.0,
}


def test_what_is_left_out_follows_by_the_stated_rules():
    cart = Robot(**CART)
    kt, ke = 2.0 / 12.0, 12.0 / 20.0
    assert (cart.torque_constant, cart.back_emf) == pytest.approx((kt, ke))
    assert (cart.mass_offset, cart.wheel_mass, cart.wheel_inertia, cart.kd, cart.filter_frequency) == (0, 0, 0, 0, 0)
    assert cart.mass == 6.0  # the data sheet's, whatever its wheels
    assert cart.body_inertia == pytest.approx(6.0 * (0.16 + 0.09) / 12)
    rotor = 0.01 * kt * ke
    assert cart.wheel_spin_inertia == pytest.approx(rotor)
    load = 0.05**2 * 6.0 / 2 + rotor  # half the robot at the rim, and the rotor
    assert cart.wheel_load == pytest.approx(load)
    slips = 0.55 * 9.81 * load / 0.05
    assert cart.torque_limit == pytest.approx(min(2.0, slips)) == slips
    assert cart.friction_torque == pytest.approx(0.02 * 6.0 * 9.81 * 0.05 / 2)
    assert cart.friction_speed == pytest.approx(0.2)
    assert (cart.wheel_speed_max, cart.v_max, cart.w_max) == pytest.approx((20.0, 1.0, 1.0 / 0.14))
    motor = load / (kt * ke)
    pole = max(0.04, motor / 2, load * 20.0 / (4 * slips))
    assert cart.kp == pytest.approx(load / (kt * pole))
    assert cart.ki == pytest.approx(cart.kp / motor)
    assert (cart.v_rate_max, cart.w_rate_max) == (None, None)
    assert set(cart.derived) == set(RULES)
    assert all(cart.derived.values())


def test_the_rotor_alone_reaches_its_speed_with_the_motors_own_time_constant():
    """A wheel in the air: J_w ω' = k_t (U − k_e ω), whose time constant the rule of the rotor sets to 10 ms."""
    cart = Robot(**CART)
    assert cart.wheel_spin_inertia / (cart.torque_constant * cart.back_emf) == pytest.approx(0.01)


def test_the_etsros_gains_follow_from_its_other_numbers():
    """They were tuned to 0.8 and 9 by hand, long before there was a rule."""
    numbers = {name: value for name, value in ETSRO.given.items() if name not in ("kp", "ki")}
    found = Robot(**numbers)
    assert (found.kp, found.ki) == pytest.approx((0.8, 9.0), rel=0.1)
    assert {*found.derived} - {*IMPERFECTIONS, "castor_offset"} == {"kp", "ki", "kd", "filter_frequency"}


def test_a_loop_with_derived_gains_settles_with_the_time_constant_of_the_rule():
    """Pole and zero cancel: with no friction, no torque limit and fine encoders the wheel follows 1 − exp(−t/λ)."""
    free = replace(Robot(**CART), friction_torque=0.0, torque_limit=1e3, counts_per_turn=1e9)
    step = step_response(free, "straight", 0.2)
    ideal = 1 - np.exp(-step.time / free.loop_time)
    # the loop's own delay of a period and a half moves it by about that share of the time constant
    assert np.abs(step.speed / step.command - ideal).max() < 0.75 * 0.015 / free.loop_time
    assert step.settling_time < 6 * free.loop_time


def test_the_time_of_a_sheets_motor_is_that_of_the_simulated_wheel():
    """At a held voltage the wheel reaches 63 % of its speed after T = J / (k_t k_e)."""
    open_loop = replace(Robot(**CART), friction_torque=0.0, torque_limit=1e3, counts_per_turn=1e9, ki=0.0)
    weak = replace(open_loop, kp=1e-3)  # so weak that the voltage hardly changes
    share = step_response(weak, "straight", 0.5)
    reached = share.speed / share.speed[-1]
    time = np.interp(0.632, reached[:150], share.time[:150])
    assert time == pytest.approx(weak.motor_time, abs=0.012)


@pytest.mark.parametrize("missing", [*NEEDED, "stall_torque", "no_load_speed"])
def test_what_nothing_implies_must_be_given(missing):
    with pytest.raises(RobotError, match=f"a robot lacks {missing} "):
        Robot(**{name: value for name, value in CART.items() if name != missing})


def test_a_robot_of_no_numbers_says_what_it_lacks():
    with pytest.raises(RobotError) as caught:
        Robot()
    assert all(f"{name} [" in str(caught.value) for name in (*NEEDED, *ALTERNATIVES, *ALTERNATIVES.values()))


@pytest.mark.parametrize(("name", "other"), [("torque_constant", "stall_torque"), ("back_emf", "no_load_speed")])
def test_one_of_two_ways_to_say_a_motor(name, other):
    usual = Robot(**CART)
    with pytest.raises(RobotError, match=f"give {other} or {name}, not both"):
        Robot(**CART, **{name: 0.1})
    same = Robot(**{k: v for k, v in CART.items() if k != other}, **{name: getattr(usual, name)})
    assert same == usual
    assert name not in same.derived
    assert name in usual.derived


def test_a_motor_that_the_simulation_cannot_resolve_is_refused():
    with pytest.raises(RobotError, match=r"would answer within 0\.\d+ ms, .* no less than 1 ms: check the motor's"):
        Robot(**CART | {"stall_torque": 2000.0, "wheel_spin_inertia": 0.0})


def test_changed_derives_anew_and_replace_does_not():
    cart = Robot(**CART)
    heavy = cart.changed(body_mass=12.0)
    assert heavy == Robot(**CART | {"body_mass": 12.0})
    assert heavy.body_inertia == pytest.approx(2 * cart.body_inertia)
    assert replace(cart, body_mass=12.0).body_inertia == cart.body_inertia
    assert cart.changed(stall_torque=4.0).torque_constant == pytest.approx(2 * cart.torque_constant)
    assert cart.changed(body_inertia=0.3).given["body_inertia"] == 0.3
    assert cart.changed() == cart


def test_every_number_says_what_it_is():
    docs = [f.metadata["doc"] for f in fields(Robot)]
    assert all(doc.endswith(".") and len(doc) > 20 for doc in docs)
    assert len(set(docs)) == len(docs)
    assert all(rule.says for rule in RULES.values())


# The packaged robots --------------------------------------------------------------------------------------------


@pytest.fixture(scope="module", params=robot_names())
def model(request: pytest.FixtureRequest) -> RobotModel:
    return load_robot(request.param)


def test_packaged_robots_say_what_they_are_and_where_their_numbers_come_from(model):
    assert model.title
    assert "estimated: " in model.source or "assumed: " in model.source
    assert model.sensors
    robot = model.robot
    outline = np.array([robot.length, robot.width]) / 2 + 1e-9
    assert all((np.abs([s.x, s.y]) <= outline).all() for s in model.sensors.values()), "sensors on the robot"
    assert robot.half_axle <= robot.width / 2


def test_the_wheel_loop_of_a_packaged_robot_settles(model):
    for motion in MOTIONS:
        step = step_response(model.robot, motion)
        assert step.settling_time < 1.0
        assert step.overshoot < 0.1
        assert np.abs(step.voltage).max() <= model.robot.supply_voltage


def test_the_presets_keep_what_their_data_sheets_say():
    """Speeds that the makers state, from wheels and motors; masses, sizes."""
    burger, pioneer, mir = (load_robot(name).robot for name in ("turtlebot3-burger", "pioneer-3dx", "mir100"))
    assert burger.mass == pytest.approx(1.0)
    assert burger.wheel_speed_limit == pytest.approx(2 * pi * 61 / 60 * 0.033, rel=1e-3)  # XL430 at 12 V: 61 rpm
    assert pioneer.mass == 9.0
    assert pioneer.wheel_speed_limit > 1.2
    assert pioneer.counts_per_turn == pytest.approx(500 * 4 * 38.3)
    assert mir.mass == 70.0
    assert mir.wheel_speed_limit > 1.5
    scan = load_robot("turtlebot3-burger").sensors
    angles = np.diff([sensor.axis for sensor in scan.values()])
    assert len(scan) == 120
    np.testing.assert_allclose(angles, np.radians(3), atol=1e-4)
    assert {(s.x, s.range, s.minimum, s.period) for s in scan.values()} == {(-0.032, 3.5, 0.12, 0.2)}
    ring = [round(np.degrees(s.axis)) for s in load_robot("pioneer-3dx").sensors.values()]
    assert ring == [90, 50, 30, 10, -10, -30, -50, -90]


@pytest.mark.parametrize("name", ["wheel_radius", "supply_voltage", "body_mass"])
def test_numbers_that_nothing_can_be_divided_by_are_refused(name):
    with pytest.raises(RobotError, match=f"{name} must be a finite number in .*> 0.* and 1e-15 at least; got 1e-320"):
        Robot(**{**CART, name: 1e-320})


def test_the_examples_of_its_numbers_are_those_of_one_small_robot():
    """Uncommented in a new file each is a number that such a robot may have, and all together are one."""
    shown = {f.name: f.metadata["example"] for f in fields(Robot) if f.init}
    assert None not in shown.values()
    small = Robot(**{name: shown[name] for name in (*NEEDED, *ALTERNATIVES)})
    for name in small.derived:
        if getattr(small, name):
            assert shown[name] == pytest.approx(getattr(small, name), rel=0.06), name
    both = {name: value for name, value in shown.items() if name not in ALTERNATIVES}
    whole = Robot(**both)
    assert whole.motor_time == pytest.approx(small.motor_time, rel=0.1)
