"""What is so, where laws and wheel loops are told otherwise."""

from dataclasses import replace

import numpy as np
import pytest

import robotics
from robotics.laws.setting import TrueParameters
from robotics.plugins.arena.changes import CHANGES, changed
from robotics.plugins.arena.computing import NullLaw
from robotics.simulation.scenario.description import Member, Scenario
from robotics.world.paths.path import Line
from robotics.world.paths.trajectory import Timing


def straight(**changes):
    member = Member(start=(0.0, 0.0, 0.0), path=Line(start=(0.0, 0.0), end=(9.0, 0.0)), timing=Timing(speed=0.3))
    return Scenario(name="straight", robots=(member,), duration=10.0, **changes)


def driven(scenario, truth=None):
    return robotics.simulate_many(scenario, [NullLaw()], [0], truth=truth)[0]


@pytest.mark.parametrize("factor", [0.8, 1.2])
def test_larger_wheels_go_farther_than_their_loops_believe(factor):
    scenario = straight()
    robot = scenario.robots[0].robot
    truth = TrueParameters(robots=(replace(robot, wheel_radius=factor * robot.wheel_radius),), latency=0.0)
    speed = driven(scenario, truth)["v"][0, 0, -1]
    assert speed == pytest.approx(factor * 0.3, rel=2e-3)  # the loop holds the wheel's speed, not the robot's
    assert driven(scenario)["v"][0, 0, -1] == pytest.approx(0.3, rel=2e-3)


def test_a_longer_latency_delays_the_first_motion_by_what_it_is_longer():
    def begins(run):
        return int(np.argmax(run["v"][0, 0] > 1e-6))

    scenario = straight(latency=0.05)
    late, told = changed(scenario, "latency ×2")[1], driven(scenario)
    assert begins(driven(scenario, late)) == begins(told) + 1  # one period of 50 ms


def test_a_heavier_robot_takes_up_speed_more_slowly():
    scenario = straight()
    early = [driven(scenario, changed(scenario, c)[1])["v"][0, 0, 1] for c in ("mass -20 %", "", "mass +20 %")]
    assert early[0] > early[1] > early[2]


def test_what_is_as_told_changes_no_bit():
    scenario = straight()
    same = TrueParameters(robots=tuple(m.robot for m in scenario.robots), latency=scenario.latency)
    assert np.array_equal(driven(scenario, same)["x"], driven(scenario)["x"])


def test_every_change_changes_something_and_laws_are_not_told():
    scenario = robotics.load_arena("demo").scenarios("test")[0]
    told = robotics.simulate_many(scenario, ["nmpc"], [0])[0]["x"]
    for change in CHANGES:
        other, truth = changed(scenario, change)
        assert [m.robot for m in other.robots] == [m.robot for m in scenario.robots]
        assert other.latency == scenario.latency
        assert not np.array_equal(robotics.simulate_many(other, ["nmpc"], [0], truth=truth)[0]["x"], told), change
