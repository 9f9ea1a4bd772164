"""Each step of a period alone, against what it must do by hand; and the two loops over them."""

import pickle
from dataclasses import dataclass, replace
from typing import Any, NamedTuple

import numpy as np
import pytest

import robotics.simulation.loop
from fuzzy.compiled.columns import Ints1
from robotics.laws.catalogue import make_controller
from robotics.laws.equation import CommandColumns, SeenColumns
from robotics.laws.law import Command, Law
from robotics.simulation.loop import Simulation, drive, simulate
from robotics.simulation.observer import Observer, observer
from robotics.simulation.scenario.description import Member, Scenario
from robotics.simulation.scenario.reading import load_scenario
from robotics.world.environment.world import Disc
from robotics.world.paths.path import Line
from robotics.world.paths.trajectory import Timing
from robotics.world.radio.channel import AirColumns
from robotics.world.radio.description import Radio
from robotics.world.radio.faults import Fault
from robotics.world.sensing.posture import LABORATORY, Sensing
from robotics.world.vehicle.plant import TruthColumns as Truth


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


def simulation(seeds=(4,), **settings):
    given: dict[str, Any] = {
        "kind": "team",
        "plant": "kinematic",
        "duration": 1.0,
        "sensing": Sensing(posture="pose"),
    } | settings
    scenario = Scenario(name="steps", robots=members(2), **given)
    return Simulation(scenario.setting, Told(), seeds)


def after(simulated, *steps, k=0):
    """The columns of a simulation after some steps of period ``k``."""
    for step in steps:
        getattr(simulated, step)(*([] if step == "obey" else [k]))
    return simulated.lanes


def test_sense_measures_and_looks_up_the_reference_and_moves_nothing():
    simulated = simulation()
    simulated.lanes.body.truth[Truth.x.row] = 0.3
    before = simulated.lanes.body.truth.copy()
    lanes = after(simulated, "sense", k=10)
    seen = SeenColumns(lanes.known.seen)
    np.testing.assert_array_equal(seen.robot.array[:3], [[0.3, 0.3], [0.0, 1.0], [0.0, 0.0]])
    np.testing.assert_allclose(seen.aim.x, [0.1, 0.1])  # 5 m in 25 s, after 0.5 s
    assert lanes.body.truth.tobytes() == before.tobytes()


def test_look_reads_the_range_sensors_and_moves_nothing():
    simulated = simulation(obstacles=(Disc(position=(0.0, 1.5), radius=0.2),))
    simulated.lanes.body.truth[Truth.x.row] = 0.3
    before = simulated.lanes.body.truth.copy()
    after(simulated, "sense", "look", k=10)
    assert simulated.lanes.body.truth.tobytes() == before.tobytes()
    assert np.isinf(simulated.ranges["right"][0, 0])
    assert abs(simulated.ranges["right"][0, 1] - 0.8) < 0.05  # the first robot: 1 m less half a width and the mounting
    alone = simulation(obstacles=(Disc(position=(0.0, 1.5), radius=0.2),))
    after(alone, "sense", "look")
    assert abs(alone.ranges["left"][0, 1] - 0.2) < 0.05  # 0.5 m less the radius and the mounting
    assert abs(alone.ranges["left"][0, 0] - 0.8) < 0.05  # the second robot


def test_hear_brings_what_was_said_a_period_ago_and_who_is_at_fault():
    faults = (Fault(robot=2, kind="failure", start=0.1, duration=0.5),)
    simulated = simulation(faults=faults)
    lanes = after(simulated, "sense", "hear")
    assert not lanes.trouble.failed.any()
    assert np.isnan(AirColumns(lanes.air.heard).values).all()
    after(simulated, "decide", "obey", "say", "move")
    told = SeenColumns(lanes.known.seen).robot.x.copy()
    lanes = after(simulated, "sense", "hear", "decide", "obey", "say", "move", k=1)
    assert AirColumns(lanes.air.heard, 0, 1).values[0] == told[1]
    lanes = after(simulated, "sense", "hear", k=2)
    assert lanes.trouble.failed.tolist() == [False, True]
    heard = AirColumns(lanes.air.heard, 0, 1)
    assert heard.values[0] == told[1]  # nobody hears a robot that failed: it is the old message
    assert heard.age == 2 * simulated.setting.period


def test_decide_asks_the_law_and_aims_at_the_reference():
    simulated = simulation()
    lanes = after(simulated, "sense", "hear", "decide")
    assert simulated.memory == 1
    command = CommandColumns(lanes.command)
    assert (command.first == 0.2).all()
    np.testing.assert_array_equal(command.target.array, SeenColumns(lanes.known.seen).aim.array)
    assert (lanes.order == 0).all()  # not obeyed yet


@pytest.mark.parametrize(("kind", "order"), [("failure", 0.0), ("stall", 0.0), ("delay", 0.07), ("silence", 0.2)])
def test_obey_lets_a_fault_hold_or_stop_its_robot_only(kind, order):
    simulated = simulation(faults=(Fault(robot=2, kind=kind, start=0.0, duration=0.5),))
    lanes = after(simulated, "sense", "hear", "decide")
    lanes.order[:] = 0.07
    after(simulated, "obey")
    assert lanes.order[0].tolist() == [0.2, order]
    assert not lanes.lost.any()


def test_obey_stops_by_the_watchdog_a_robot_without_commands():
    simulated = simulation(faults=(Fault(robot=1, kind="delay", start=0.0, duration=0.5),))
    lanes = after(simulated, "sense", "hear", "decide")
    orders = []
    lanes.order[:] = 0.07
    for _ in range(4):
        after(simulated, "obey")
        orders.append(float(lanes.order[0, 0]))
    assert orders == [0.07, 0.07, 0.0, 0.0]  # it holds for 0.1 s


@pytest.mark.parametrize("far", [False, True])
def test_obey_notices_who_is_lost(far):
    simulated = simulation(divergence=0.5)
    lanes = after(simulated, "sense", "hear", "decide")
    if far:
        lanes.body.truth[Truth.y.row, 1] += 0.6
    else:
        CommandColumns(lanes.command, 1).second = np.nan
    after(simulated, "obey")
    assert lanes.lost.tolist() == [False, True]


def test_say_puts_a_message_on_its_way_once():
    simulated = simulation(radio=Radio(period=0.1))
    lanes = after(simulated, "sense", "hear", "decide", "obey", "say")
    assert lanes.air.sent.tolist() == [0]
    assert lanes.air.arrives[0].tolist() == [[-1, 1], [1, -1]]  # nobody hears itself
    after(simulated, "say", k=1)
    assert lanes.air.sent.tolist() == [0]  # it speaks every other period


def test_move_advances_the_plant_by_the_orders_and_keeps_the_lost_at_rest():
    simulated = simulation()
    lanes = after(simulated, "sense", "hear", "decide", "obey")
    lanes.lost[:] = [False, True]
    after(simulated, "move")
    # A kinematic robot drives the exact arc: 0.2 m/s and 0.5 rad/s for 0.05 s
    turn = 0.5 * 0.05
    found = lanes.body.truth[[Truth.x.row, Truth.y.row, Truth.heading.row], 0]
    np.testing.assert_allclose(found, [0.4 * np.sin(turn), 0.4 * (1 - np.cos(turn)), turn], atol=1e-12)
    np.testing.assert_allclose(
        lanes.body.truth[[Truth.x.row, Truth.y.row, Truth.heading.row], 1],
        [0.0, 1.0, 0.0],
        atol=1e-12,
    )
    assert lanes.stopped.tolist() == [-1, 0]
    assert lanes.order[:, 1].tolist() == [0.0, 0.0]


def test_a_run_that_is_over_is_left_as_it_is_and_beside_it_all_is_the_same():
    left, other = simulation((4, 5, 6)), simulation((4, 5, 6))
    start = left.rows(left.lanes.body.truth.copy())
    left.lanes.goes_on[1] = False
    for k in range(3):
        for one in (left, other):
            after(one, "sense", "hear", "decide", "obey", "move", k=k)
    truth, seen = left.rows(left.lanes.body.truth), left.rows(left.lanes.known.seen)
    np.testing.assert_array_equal(truth[:, 1], start[:, 1])
    assert not seen[:, 1].any()
    for rows, whole in ((truth, other.lanes.body.truth), (seen, other.lanes.known.seen)):
        np.testing.assert_array_equal(rows[:, [0, 2]], other.rows(whole)[:, [0, 2]])
    assert (truth[Truth.x.row, [0, 2]] > start[Truth.x.row, [0, 2]]).all()


def test_move_delays_orders_by_the_latency():
    simulated = simulation(latency=0.1)
    lanes = after(simulated, "sense", "hear", "decide", "obey")
    places = []
    for k in range(3):
        after(simulated, "move", k=k)
        places.append(float(lanes.body.truth[Truth.x.row, 0]))
    np.testing.assert_allclose(places, [0.0, 0.0, 0.4 * np.sin(0.025)], atol=1e-12)


def test_a_drive_is_its_steps_one_after_the_other_and_its_states_stay():
    simulated = simulation(faults=(Fault(robot=2, kind="delay", start=0.2, duration=0.2),))
    states = list(drive(simulated.setting, Told(), (4,)))
    assert [state.k for state in states] == list(range(simulated.setting.ticks + 1))
    for state in states:
        lanes = after(simulated, "sense", "hear", "decide", "obey", k=state.k)
        assert state.order.tobytes() == lanes.order.tobytes()
        assert state.truth.tobytes() == lanes.body.truth.tobytes()
        after(simulated, "say", "move", k=state.k)


@pytest.mark.parametrize("seeds", [(1,), (1, 2, 3)])
def test_both_loops_give_the_same_bits(seeds):
    scenario = replace(
        load_scenario("reference"),
        duration=2.0,
        latency=0.03,
        sensing=replace(LABORATORY, filter_gain=0.3, wheel_error=0.01),
        faults=(Fault(robot=1, kind="delay", start=0.5, start_until=1.0, duration=0.4),),
    )
    law = make_controller("lyapunov")
    run, states = simulate(scenario, law, seeds), list(drive(scenario.setting, law, seeds))
    truth = np.stack([state.truth[: Truth.w.row + 1] for state in states])
    assert np.ascontiguousarray(run.samples[:, :5]).tobytes() == truth.tobytes()


def test_the_number_of_threads_and_of_runs_in_a_chunk_change_no_bit(monkeypatch):
    scenario = replace(load_scenario("reference"), duration=1.0, sensing=LABORATORY)
    one = simulate(scenario, "lyapunov", range(5), threads=1).samples
    for chunk, threads in ((2, 1), (2, 3), (1000, 2)):
        monkeypatch.setattr(robotics.simulation.loop, "CHUNK", chunk * len(scenario.robots))
        assert simulate(scenario, "lyapunov", range(5), threads=threads).samples.tobytes() == one.tobytes()


class Counted(NamedTuple):
    periods: Ints1


@observer
def count(moment, notes):
    notes.periods[0] += 1
    return False


def test_machine_code_for_two_observers_is_found_again_on_disk():
    """A file of machine code says for which types it is: they must be the same ones in another process."""
    one = Observer(count, Counted(np.zeros(1, np.int64)))
    of = type(one.beside(one).notes)
    assert pickle.loads(pickle.dumps(of)) is of
    law, setting = make_controller("lyapunov"), replace(load_scenario("lyapunov-sine"), duration=0.1).setting
    robotics.simulation.loop.record_run(setting, law, (0,), observer=one.beside(one))
    assert one.notes.periods[0] == 2 * (setting.ticks + 1)
