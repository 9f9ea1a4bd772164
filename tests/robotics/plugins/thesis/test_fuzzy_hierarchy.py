"""The printed rules in one law: (6.4), (6.5) and (6.7) on made observations, and each part alone."""

from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from fuzzy.inference import infer
from robotics.laws.catalogue import CATALOGUE, gains_of, make_controller
from robotics.laws.equation import Memory
from robotics.laws.law import Command, ControllerError, Observation
from robotics.laws.modes import AVOID, LEFT_BEHIND, TRACK, YIELD
from robotics.plugins.thesis.fuzzy_hierarchy import FuzzyHierarchy, HierarchyMemory
from robotics.simulation.loop import drive, simulate
from robotics.simulation.scenario.reading import load_scenario
from robotics.world.radio.channel import Heard
from robotics.world.sensing.sonar import SONAR, Ranges

FREE = np.inf
APART = np.array([(-0.3, 2.0, 0.0), (-1.3, 0.0, 0.0), (-0.3, -2.0, 0.0)])  # behind the starts, all with a way to go
LAW: Any = make_controller("hierarchy-literal:lateral=none")
CROSSING = load_scenario("three-cross")


def seen(poses: np.ndarray, sonars: tuple[float, ...] = (FREE,) * 4, robot: int = 0) -> Observation:
    """What three robots at ``poses`` (3, 3) hear of each other, and one of them sees."""
    values = np.zeros((len(LAW.message), 1, 3, 3))
    for k, name in enumerate(("x", "y")):
        values[LAW.message.index(name)] = poses[:, k]
    heard = Heard(LAW.message, values, age=np.zeros((1, 3, 3)), hears=~np.eye(3, dtype=bool))
    still = np.zeros((1, 3))
    x, y, heading = poses.T[:, None]
    readings = np.full((1, 3, 4), FREE)
    readings[0, robot] = sonars
    at = CROSSING.trajectory.at(0.0)
    return Observation(
        10.0, x, y, heading, still, still, at, CROSSING.trajectory, heard, Ranges(tuple(SONAR), readings)
    )


def begin(law: Any = LAW, **remembered: Any) -> Memory:
    memory = law.init(CROSSING.setting, 1)
    for name, row in remembered.items():
        setattr(HierarchyMemory(memory.rows), name, row)
    return memory


def decide(observation: Observation, law: Any = LAW, **remembered: Any) -> Command:
    return law.control(observation, begin(law, **remembered), 0.05)[0]


def stalled_after(observation: Observation, memory: Memory) -> list[float]:
    return HierarchyMemory(LAW.control(observation, memory, 0.05)[1].rows).stalled.tolist()


def beside(distance: float) -> np.ndarray:
    """Robot 2 a little ahead of robot 1 and to its left, so far away [m]."""
    poses = APART.copy()
    poses[1] = poses[0] + [0.1, np.sqrt(distance**2 - 0.01), 0.0]
    return poses


@pytest.mark.parametrize(("left", "right", "way"), [(0.74, FREE, -1), (FREE, 0.74, 1)])
def test_theta_is_added_away_from_the_smaller_reading(left: float, right: float, way: int) -> None:
    """(6.7): Θ = 1.6 (0.8 − ro) / 0.65 rad; ω = 2 α / 0.4 s while α is small, and v falls as ro."""
    free, near = decide(seen(APART)), decide(seen(APART, (left, right, FREE, FREE)))
    assert near.w[0, 0] - free.w[0, 0] == pytest.approx(way * 5 * 1.6 * 0.06 / 0.65)
    assert near.v[0, 0] == pytest.approx(free.v[0, 0] * 0.74 / 0.8)
    assert near.mode is not None
    assert near.mode[0].tolist() == [AVOID, TRACK, TRACK]
    np.testing.assert_array_equal(near.w[0, 1:], free.w[0, 1:])


def test_eta_and_theta_are_added() -> None:
    """(6.4) and (6.7): η = 1.2 (0.6 − d) / 0.3 rad away from robot 2, which stands by (6.5)."""
    both = decide(seen(beside(0.57), (0.74, FREE, FREE, FREE)))
    eta, theta = 1.2 * 0.03 / 0.3, 1.6 * 0.06 / 0.65
    assert both.w[0, 0] == pytest.approx(-5 * (eta + theta), abs=1e-6)
    assert both.mode is not None
    assert both.mode[0].tolist() == [AVOID, YIELD, TRACK]
    assert (both.v[0, 1], both.w[0, 1]) == (0.0, 0.0)


def test_who_avoids_stands_for_a_lower_number_too() -> None:
    poses = APART.copy()
    for distance, mode in ((0.59, YIELD), (0.61, AVOID)):
        poses[0] = poses[1] + [0.0, distance, 0.0]
        command = decide(seen(poses, (0.3, 0.4, FREE, FREE), robot=1))
        assert command.mode is not None
        assert command.mode[0, 1] == mode
        assert (command.v[0, 1] > 0, command.w[0, 1] != 0) == (mode == AVOID, mode == AVOID)


def test_lambda_is_added_while_tracking_only() -> None:
    """λ = 0.2 rad at 0.15 m by (6.4); (6.7) is printed without it."""
    law = make_controller("hierarchy-literal")
    aside = APART - [0.0, 0.03, 0.0]  # the target is 3 cm to the left
    for sonars, wanted in (((FREE,) * 4, 5 * 0.2 / 0.15 * 0.03), ((0.79, FREE, FREE, FREE), 0.0)):
        by_it, without = (decide(seen(aside, sonars), each).w[0, 0] for each in (law, LAW))
        assert by_it - without == pytest.approx(wanted, rel=0.02)


def test_who_is_stuck_is_left_behind_and_standing_does_not_count() -> None:
    late = np.array([15.1, 15.1, 0.0])
    command = decide(seen(beside(0.57)), stalled=late, best=9.0)
    assert command.mode is not None
    assert command.mode[0].tolist() == [TRACK + LEFT_BEHIND, YIELD + LEFT_BEHIND, TRACK]
    assert command.message is not None
    assert np.isnan(command.message["place"][0]).tolist() == [True, True, False]  # the clock does not wait for it
    near = seen(beside(0.57), (0.5, 0.5, FREE, FREE), robot=1)
    memory = begin(best=9.0)
    assert stalled_after(near, memory) == [0.0, 0.0, 0.0]
    near = seen(APART, (0.5, 0.5, FREE, FREE), robot=1)
    assert stalled_after(near, memory) == [0.0, 0.05, 0.0]


def test_without_obstacles_it_is_crash_avoidance() -> None:
    scenario = replace(CROSSING, duration=26.0)  # until after the first contact
    joined, alone = (simulate(scenario, make_controller(n)) for n in ("hierarchy-literal", "crash-lag-clock"))
    np.testing.assert_array_equal(joined.samples, alone.samples)
    np.testing.assert_array_equal(joined.modes, alone.modes)
    assert joined.modes is not None
    assert (joined.modes == YIELD).any()


def test_gains_are_those_of_its_parts() -> None:
    law: Any = make_controller("hierarchy-literal:d_min=0.8,ro_min=1,obstacles.patience=5")
    assert (law.crash.d_min, law.obstacles.ro_min, law.obstacles.patience) == (0.8, 1.0, 5.0)
    assert (law.crash.lateral, law.obstacles.variant, law.safety_distance) == ("world", "literal", 0.8)
    gains = gains_of(law)
    assert gains["crash.eta"] == 1.0
    assert not {"obstacles.d_pass", "obstacles.rule_base", "obstacles.reach"} & set(gains)
    for name, value in (("crash", "yielding"), ("obstacles", "committed")):
        with pytest.raises(ControllerError, match=rf"{name}.variant must be .*; got '{value}'"):
            make_controller(f"hierarchy-literal:{name}.variant={value}")
    assert LAW.misgivings(load_scenario("two-meetings").setting) == FuzzyHierarchy().crash.misgivings(
        load_scenario("two-meetings").setting
    )


@pytest.mark.parametrize(
    "name", ["fuzzy", "fuzzy-lateral", "cooperation-literal", "crash-literal", "obstacles-literal", "hierarchy-literal"]
)
def test_a_command_carries_the_inputs_of_all_rule_bases(name: str) -> None:
    """Checked by the inference of every system, which is not the compiled one that the laws use."""
    law = make_controller(name)
    kind = CATALOGUE[name].kind
    scenario = load_scenario("turn-into-neighbour" if kind == "team" else "fuzzy-off-path")
    states = drive(scenario.setting, law, [0, 1])
    for state in (next(states) for _ in range(240)):
        command = state.command
    assert command.inputs is not None
    counts = [len(fis.inputs) for fis in law.fuzzy_systems.values()]
    assert command.inputs.shape == (sum(counts), 2, len(scenario.robots))
    parts = dict(zip(law.fuzzy_systems, np.split(command.inputs, np.cumsum(counts)[:-1]), strict=True))
    said = {task: infer(law.fuzzy_systems[task], np.moveaxis(x, 0, -1)).output for task, x in parts.items()}
    if {"eta", "theta"} & set(said):  # they are part of the α that tracking was asked for
        free = command.mode == TRACK
        assert command.mode is None or free.any()
    else:
        free = np.ones(command.v.shape, dtype=bool)
    np.testing.assert_allclose(said["tracking"][free], np.stack([command.v, command.w], axis=-1)[free], atol=1e-12)
    if "theta" in said:
        assert (parts["theta"] < 0.8).any()
        assert (said["theta"][..., 0][free] == 0.0).any()
