"""Each step of a period alone: from a state to a state, against what it must do by hand."""

from dataclasses import dataclass
from typing import Any

import numpy as np
import pytest

from robotics.environment.world import Disc
from robotics.laws.law import Command, Law
from robotics.paths.path import Line
from robotics.paths.trajectory import Timing
from robotics.radio.description import Radio
from robotics.radio.faults import Fault
from robotics.scenario.description import Member, Scenario
from robotics.sensing.posture import Sensing
from robotics.simulation.loop import Simulation, drive
from robotics.vehicle import plant as p


@dataclass(frozen=True)
class Told(Law[int]):
    """Commands (0.2 m/s, 0.5 rad/s), says its x, and counts the periods."""

    message = ("x",)
    needs = ("left",)

    @property
    def watchdog(self):
        return 0.1

    def init(self, setting, runs):
        return 0

    def control(self, seen, memory, dt):
        v, w = np.full_like(seen.x, 0.2), np.full_like(seen.x, 0.5)
        return Command(v, w, v, w, {"x": seen.x}), memory + 1


def members(robots):
    return tuple(
        Member(
            start=(0.0, float(i), 0.0),
            path=Line(start=(0.0, float(i)), end=(5.0, float(i))),
            timing=Timing(duration=25.0),
        )
        for i in range(robots)
    )


def simulation(**settings):
    given: dict[str, Any] = {
        "kind": "team",
        "plant": "kinematic",
        "duration": 1.0,
        "sensing": Sensing(posture="pose"),
    } | settings
    scenario = Scenario(name="steps", robots=members(2), **given)
    return Simulation.opened(scenario.setting, Told(), (4,))


def ready(simulated, *steps):
    state = simulated.start()
    for step in steps:
        state = getattr(simulated, step)(state)
    return state


def test_sense_measures_and_looks_up_the_reference_and_moves_nothing():
    simulated = simulation(obstacles=(Disc(position=(0.0, 1.5), radius=0.2),))
    before = simulated.start()
    before = before.then(k=10, time=0.5, truth=before.truth + 0.0)
    before.truth[p.X] = 0.3
    after = simulated.sense(before)
    np.testing.assert_array_equal(after.posture, [[[0.3, 0.3]], [[0.0, 1.0]], [[0.0, 0.0]]])
    np.testing.assert_allclose(after.reference.x, [0.1, 0.1])  # 5 m in 25 s, after 0.5 s
    assert after.truth is before.truth
    assert np.isinf(after.ranges["right"][0, 0])
    assert abs(after.ranges["right"][0, 1] - 0.8) < 0.05  # the first robot: 1 m less half a width and the mounting
    alone = simulated.sense(simulated.start())
    assert abs(alone.ranges["left"][0, 1] - 0.2) < 0.05  # 0.5 m less the radius and the mounting
    assert abs(alone.ranges["left"][0, 0] - 0.8) < 0.05  # the second robot


def test_hear_brings_what_was_said_a_period_ago_and_who_is_at_fault():
    simulated = simulation(faults=(Fault(robot=2, kind="failure", start=0.05, duration=0.5),))
    state = ready(simulated, "sense", "hear")
    assert state.condition is None
    assert np.isnan(state.heard["x"]).all()
    state = simulated.say(simulated.decide(state))
    heard = simulated.hear(state.then(k=1, time=0.05, condition=None))
    assert heard.condition.failed.tolist() == [[False, True]]
    free = simulated.hear(state.then(k=1, time=0.04))  # before the fault
    assert free.heard["x"][0].tolist()[0][1] == free.posture[0, 0, 1]
    assert np.isnan(heard.heard["x"][0, 0, 1])  # nobody hears a robot that failed


def test_decide_asks_the_law_and_aims_at_the_reference():
    simulated = simulation()
    state = ready(simulated, "sense", "hear", "decide")
    assert state.memory == 1
    assert (state.command.first == 0.2).all()
    assert state.target is state.reference
    assert (state.order == 0).all()  # not obeyed yet


@pytest.mark.parametrize(("kind", "order"), [("failure", 0.0), ("stall", 0.0), ("delay", 0.07), ("silence", 0.2)])
def test_obey_lets_a_fault_hold_or_stop_its_robot_only(kind, order):
    simulated = simulation(faults=(Fault(robot=2, kind=kind, start=0.0, duration=0.5),))
    state = ready(simulated, "sense", "hear", "decide")
    state = simulated.obey(state.then(order=np.full((2, 1, 2), 0.07)))
    assert state.order[0].tolist() == [[0.2, order]]
    assert not state.lost.any()


def test_obey_stops_by_the_watchdog_a_robot_without_commands():
    simulated = simulation(faults=(Fault(robot=1, kind="delay", start=0.0, duration=0.5),))
    state = ready(simulated, "sense", "hear", "decide")
    orders = []
    for _ in range(4):
        state = simulated.obey(state.then(order=np.full((2, 1, 2), 0.07)))
        orders.append(float(state.order[0, 0, 0]))
    assert orders == [0.07, 0.07, 0.0, 0.0]  # it holds for 0.1 s


@pytest.mark.parametrize("far", [False, True])
def test_obey_notices_who_is_lost(far):
    simulated = simulation(divergence=0.5)
    state = ready(simulated, "sense", "hear", "decide")
    if far:
        state.truth[p.Y, 0, 1] += 0.6
    else:
        state.command.second[0, 1] = np.nan
    assert simulated.obey(state).lost.tolist() == [[False, True]]


def test_say_puts_a_message_on_its_way_once():
    simulated = simulation(radio=Radio(period=0.1))
    state = ready(simulated, "sense", "hear", "decide", "obey")
    assert len(simulated.say(state).air.flying) == 1
    assert simulated.say(state.then(k=1)).air.flying == ()  # it speaks every other period


def test_move_advances_the_plant_by_the_orders_and_keeps_the_lost_at_rest():
    simulated = simulation()
    state = ready(simulated, "sense", "hear", "decide", "obey")
    state = state.then(lost=np.array([[False, True]]))
    after = simulated.move(state)
    assert (after.k, after.time) == (1, 0.05)
    # A kinematic robot drives the exact arc: 0.2 m/s and 0.5 rad/s for 0.05 s
    turn = 0.5 * 0.05
    found = after.truth[[p.X, p.Y, p.HEADING], 0, 0]
    np.testing.assert_allclose(found, [0.4 * np.sin(turn), 0.4 * (1 - np.cos(turn)), turn], atol=1e-12)
    np.testing.assert_allclose(after.truth[[p.X, p.Y, p.HEADING], 0, 1], [0.0, 1.0, 0.0], atol=1e-12)
    assert after.stopped.tolist() == [[-1, 0]]
    assert after.order[:, 0, 1].tolist() == [0.0, 0.0]


def test_move_delays_orders_by_the_latency():
    simulated = simulation(latency=0.1)
    state = ready(simulated, "sense", "hear", "decide", "obey")
    places = []
    for _ in range(3):
        state = simulated.move(state)
        places.append(float(state.truth[p.X, 0, 0]))
    np.testing.assert_allclose(places, [0.0, 0.0, 0.4 * np.sin(0.025)], atol=1e-12)


def test_a_drive_is_its_steps_one_after_the_other():
    simulated = simulation(faults=(Fault(robot=2, kind="delay", start=0.2, duration=0.2),))
    state = simulated.start()
    for driven in drive(simulated.setting, simulated.law, simulated.seeds):
        for step in ("sense", "hear", "decide", "obey"):
            state = getattr(simulated, step)(state)
        assert driven.order.tobytes() == state.order.tobytes()
        assert driven.truth.tobytes() == state.truth.tobytes()
        state = simulated.move(simulated.say(state))
    assert driven.k == simulated.setting.ticks
