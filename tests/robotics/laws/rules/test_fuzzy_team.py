"""Each rule base of the fuzzy team is needed: without it its task fails, with all of them nothing does."""

from dataclasses import replace
from functools import cache
from typing import NamedTuple

import numpy as np
import pytest

from robotics.laws.catalogue import make_controller
from robotics.laws.rules.fuzzy_team import TEAM_OUTPUTS
from robotics.measures.registry import measure_all
from robotics.simulation.loop import simulate
from robotics.simulation.scenario.description import Scenario
from robotics.simulation.scenario.reading import load_scenario, parse_scenario
from tests.robotics.laws.rules.handmade import linear_base, lines

NOISE = '[sensing]\nposture = "pose"\nposition_noise = 0.003\nheading_noise = 0.003\n'
SEEDS = (0, 1, 2)
ARRIVED = 1.0  # s: between robots that arrive together


def crossing() -> Scenario:
    """Three straight paths of 4 m through one point, where all would be at the same time at 0.3 m/s."""
    robots = []
    for angle in (-0.9, 0.0, 0.9):
        x, y = 2.0 * np.cos(angle), 2.0 * np.sin(angle)
        robots.append(
            f"""
[[robots]]
start = [{-x}, {-y}, {angle}]
path = {{ shape = "line", start = [{-x}, {-y}], end = [{x}, {y}] }}
timing = {{ duration = 13.0 }}
"""
        )
    head = 'kind = "team"\nduration = 22.0\n[radio]\ngraph = "complete"\nperiod = 0.05\n'
    return parse_scenario(head + NOISE + "".join(robots), "crossing")


def lanes() -> Scenario:
    """Two lanes side by side, a box on one of them; the timetable leaves no time to catch up."""
    box = '\n[[obstacles]]\nshape = "box"\nlength = 0.4\nwidth = 0.4\nposition = [2.0, 0.05]\n'
    text = lines((0.0, 0.0), (0.0, 2.0), length=4.0, duration=9.0, more=box)
    return replace(parse_scenario(text.replace("[radio]", NOISE + "[radio]"), "lanes"), duration=18.0)


SETTINGS = {"crossing": crossing, "lanes": lanes}


class Outcome(NamedTuple):
    arrival: np.ndarray  # (runs, robots) s
    spread: np.ndarray  # (runs,) s
    touch: np.ndarray  # (runs,) bool
    emergency: float  # mean share


@cache
def outcome(setting: str, without: str = "", guard: bool = True) -> Outcome:
    gains = [f"{task}_rule_base=none" for task in without.split()] + ([] if guard else ["guard.on=0"])
    run = simulate(SETTINGS[setting](), make_controller(f"fuzzy-team:{','.join(gains)}"), SEEDS)
    found = measure_all(run)
    return Outcome(
        found["arrival_time_s"],
        found["arrival_spread_s"][:, 0],
        np.asarray(found["contacts"].any(axis=1)),
        float(found["emergency_share"].mean()),
    )


@pytest.mark.parametrize("setting", SETTINGS)
def test_with_all_of_them_robots_arrive_together_and_touch_nothing(setting: str) -> None:
    full = outcome(setting)
    assert np.isfinite(full.arrival).all()
    assert (full.spread < ARRIVED).all()
    assert not full.touch.any()
    assert full.emergency < 0.05


def test_without_tracking_nobody_arrives() -> None:
    assert np.isinf(outcome("crossing", "tracking").arrival).all()


def test_without_cooperation_they_do_not_arrive_together() -> None:
    assert (outcome("lanes", "cooperation").spread > ARRIVED).all()


@pytest.mark.long
def test_without_crash_the_emergency_rule_alone_keeps_them_apart() -> None:
    alone = outcome("crossing", "crash")
    assert not alone.touch.any()
    assert alone.emergency > 0.05
    assert outcome("crossing", "crash", guard=False).touch.all()


@pytest.mark.parametrize("without", ["obstacles", "supervisor"])
def test_without_obstacles_or_who_decides_the_robot_stays_before_the_box(without: str) -> None:
    stays = outcome("lanes", without)
    assert np.isinf(stays.arrival[:, 0]).all()
    assert not stays.touch.any()


def test_without_who_decides_only_the_emergency_rule_keeps_it_from_the_box() -> None:
    assert outcome("lanes", "supervisor", guard=False).touch.all()


def test_a_rule_base_without_rules_is_one_left_out(tmp_path) -> None:
    setting = replace(crossing(), duration=5.0)
    empty = {task: linear_base(tmp_path / f"{task}.fis", {"time": (0, 9)}, {next(iter(TEAM_OUTPUTS[task])): [0, 0]}, 0)
             for task in TEAM_OUTPUTS}  # fmt: skip
    empty["tracking"] = linear_base(
        tmp_path / "tracking.fis", {"distance": (0, 9)}, {"v": [0, 0], "w": [0, 0]}, rules=0
    )
    for tasks in ([*TEAM_OUTPUTS], ["tracking", "crash"]):
        none, file = (
            simulate(setting, make_controller("fuzzy-team:" + ",".join(f"{t}_rule_base={value(t)}" for t in tasks)))
            for value in (lambda t: "none", empty.__getitem__)
        )
        np.testing.assert_array_equal(none.samples, file.samples)


def test_with_none_at_all_they_stand() -> None:
    nothing = ",".join(f"{task}_rule_base=none" for task in ("tracking", *TEAM_OUTPUTS))
    run = simulate(replace(crossing(), duration=1.0), make_controller(f"fuzzy-team:{nothing}"))
    assert run.inputs is None
    assert (run["v_demand"] == 0).all()


@pytest.mark.parametrize("setting", SETTINGS)
def test_a_seed_gives_the_same_run_to_the_last_bit_whatever_is_beside_it(setting: str) -> None:
    short, law = replace(SETTINGS[setting](), duration=6.0), make_controller("fuzzy-team")
    together = simulate(short, law, (5, 3, 9, 2))
    alone, again = simulate(short, law, (9,)), simulate(short, law, (9,))
    for name in ("samples", "team", "inputs", "guarded"):
        np.testing.assert_array_equal(getattr(alone, name), getattr(again, name))
        np.testing.assert_array_equal(together.only(9).recorded[name].values, alone.recorded[name].values)


@pytest.mark.long
@pytest.mark.parametrize(
    "name", ["two-meetings", "three-cross", "obstacles-on-two-paths", "obstacles-on-outer-paths", "trap-u-middle"]
)
def test_on_the_tests_of_chapter_6_the_emergency_rule_hardly_acts(name: str) -> None:
    found = measure_all(simulate(load_scenario(name), make_controller("fuzzy-team"), range(5)))
    assert not found["contacts"].any()
    assert found["emergency_share"].mean() < 0.01
