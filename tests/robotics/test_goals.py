"""Tasks without a timetable: goals that rest, regions, goals that move, random starts, and the laws that park."""

from dataclasses import replace
from math import pi
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import fuzzy
import robotics
from robotics.laws.tracking.fuzzy_tracking import load_rule_base
from robotics.laws.tracking.polar import Polar
from robotics.measures.goals import at_goal, goal_error, goal_share, goal_time
from robotics.simulation.loop import simulate
from robotics.simulation.run import load_run
from robotics.simulation.scenario.description import Member, Scenario, ScenarioError
from robotics.simulation.scenario.reading import load_scenario, parse_scenario
from robotics.studies.inspection import inspect_scenario
from robotics.world.paths.goal import Goal
from robotics.world.paths.path import PathError

SQUARE = ((0.0, 0.0), (2.0, 0.0), (2.0, 1.0), (0.0, 1.0))
TEXT = """
kind = "goal"
duration = 20.0
[[robots]]
start = [0.0, 0.0, 0.0]
goal = { %s }
"""


# Goals -----------------------------------------------------------------------------------------------------------


@given(x=st.floats(-3, 5), y=st.floats(-3, 4))
def test_the_way_to_a_rectangle_is_that_of_its_closed_form(x: float, y: float) -> None:
    outside = Goal(region=SQUARE).reach.outside(x, y)
    assert outside == pytest.approx(np.hypot(max(-x, 0, x - 2), max(-y, 0, y - 1)), abs=1e-12)


def test_a_region_may_be_hollow_and_then_needs_a_point_of_it() -> None:
    hollow = ((0.0, 0.0), (3.0, 0.0), (3.0, 3.0), (2.0, 3.0), (2.0, 1.0), (1.0, 1.0), (1.0, 3.0), (0.0, 3.0))
    with pytest.raises(PathError, match="may need a point of it"):
        Goal(region=hollow)
    reach = Goal(region=hollow, at=(0.5, 2.0)).reach
    assert reach.outside(np.array([0.5, 1.5, 2.5]), np.array([2.5, 2.0, 2.5])).tolist() == [0.0, 0.5, 0.0]


@pytest.mark.parametrize(("goal", "said"), [
    ("within = 0.1", "give a point, such as at"),
    ("at = [1.0, 2.0], path = { shape = 'sine' }, timing = { speed = 0.3 }", "not both"),
    ("path = { shape = 'sine' }", "belong together"),
    ("region = [[0.0, 0.0], [1.0, 0.0]]", "three corners"),
    ("at = [5.0, 5.0], region = [[0.0, 0.0], [1.0, 0.0], [0.0, 1.0]]", "must lie in the region"),
    ("at = [1.0, 2.0], heading = 90.0", "heading must be"),
    ("at = [1.0, 2.0], hold = -1.0", "hold must be"),
    ("at = [1.0, 2.0], to = 3", "unknown key 'to'"),
])  # fmt: skip
def test_a_wrong_goal_is_told_with_its_line(goal: str, said: str) -> None:
    with pytest.raises(ScenarioError, match=rf"mine\.toml:6: .*{said}"):
        parse_scenario(TEXT % goal, "mine", "mine.toml")


def test_a_goal_and_its_kind_belong_together() -> None:
    with pytest.raises(ScenarioError, match=r'mine\.toml:\d: robot 1 has a goal: kind = "goal"'):
        parse_scenario((TEXT % "at = [1.0, 1.0]").replace('kind = "goal"', 'kind = "tracking"'), "mine", "mine.toml")
    with pytest.raises(ScenarioError, match=r"robot 1 has no goal"):
        parse_scenario(
            (TEXT % "at = [1.0, 1.0]").replace(
                "goal = { at = [1.0, 1.0] }", "path = { shape = 'sine' }\ntiming = { speed = 0.2 }"
            ),
            "mine",
        )
    with pytest.raises(ScenarioError, match="give goal or timing, not both"):
        parse_scenario(TEXT % "at = [1.0, 1.0]" + "timing = { speed = 0.2 }", "mine")


def test_a_reference_that_rests_is_at_the_end_of_its_path_from_the_first() -> None:
    setting = parse_scenario(TEXT % "at = [3.0, 4.0], heading = 1.0", "mine").setting
    for time in (0.0, 0.5, 7.0):
        there = setting.references.at(time)
        assert [float(v[0]) for v in there[:5]] == pytest.approx([3.0, 4.0, 1.0, 0.0, 0.0])
        assert there.s[0] == pytest.approx(5.0)  # the lane is as long as the way
    assert setting.divergence == pytest.approx(10.0 + 5.0)
    assert inspect_scenario(parse_scenario(TEXT % "at = [3.0, 4.0]", "mine"), "polar").findings == ()


# What is measured --------------------------------------------------------------------------------------------------


def test_metrics_are_those_of_a_made_up_run() -> None:
    """A robot that is at its goal from 2 to 2.5 s, and from 4 s on."""
    text = TEXT % "at = [1.0, 0.0], heading = 0.0, within = 0.1, heading_within = 0.2, hold = 1.0"
    run = simulate(parse_scenario(text, "mine"), "polar", [0])
    x, heading = np.full(len(run.time), 2.0), np.full(len(run.time), 2 * pi)  # a whole turn counts for nothing
    x[(run.time >= 2.0) & (run.time < 2.5)] = 1.05
    x[run.time >= 4.0], heading[-1] = 0.95, 0.3
    run["x"][0, 0], run["y"][0, 0], run["heading"][0, 0] = x, 0.0, heading
    fresh = replace(run)
    assert goal_time(fresh)[0, 0] == pytest.approx(4.0)
    after = int((run.time >= 4.0).sum())
    assert goal_share(fresh)[0, 0] == pytest.approx((after - 1) / after)  # its last sample is turned away
    away, off = goal_error(fresh)
    assert (away[0, 0, -1], off[0, 0, -1]) == (pytest.approx(0.05), pytest.approx(0.3))
    assert at_goal(fresh)[0, 0].sum() == int(((run.time >= 2.0) & (run.time < 2.5)).sum()) + after - 1


def test_a_saved_run_knows_what_its_goal_was(tmp_path: Path) -> None:
    run = simulate(load_scenario("come-in"), "fuzzy-park", [3])
    run.save(tmp_path / "run.npz")
    again = load_run(tmp_path / "run.npz")
    assert again.about.goals == run.about.goals
    assert again.about.goals[0].region is not None
    found = robotics.measure_all(again)
    assert {n: v.tolist() for n, v in found.items()} == {n: v.tolist() for n, v in robotics.measure_all(run).items()}
    assert next(iter(found)) == "goal_reached"
    assert "settling_time_s" not in found


# Random starts -----------------------------------------------------------------------------------------------------


def test_each_seed_starts_where_it_says_alone_or_beside_others() -> None:
    scenario = load_scenario("lyapunov-sine").spread((0.5, 0.2, 3.0))
    together = simulate(scenario, "lyapunov", range(40))
    first = np.stack([together[n][:, 0, 0] for n in ("x", "y", "heading")]) - np.reshape(scenario.starts[0], (3, 1))
    assert (np.abs(first) <= np.reshape([0.5, 0.2, 3.0], (3, 1))).all()
    assert (np.ptp(first, axis=1) > [0.7, 0.3, 4.0]).all()
    for law in ("lyapunov", "fuzzy", "mppi:samples=16"):  # compiled, and one that is not
        alone, beside = simulate(scenario, law, [7]), simulate(scenario, law, [6, 7])
        assert (alone["x"][0] == beside["x"][1]).all()
    plain = simulate(load_scenario("lyapunov-sine"), "lyapunov", [7])
    assert (plain["x"][0, 0, 0], plain["y"][0, 0, 0]) == tuple(scenario.starts[0][:2])


def test_a_spread_must_be_one() -> None:
    with pytest.raises(ScenarioError, match="start_spread must be three numbers >= 0"):
        load_scenario("lyapunov-sine").spread((0.5, -0.2, 3.0))


# Laws --------------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("law", ["fuzzy-park", "polar"])
@pytest.mark.parametrize("scenario", ["parking", "come-in", "moving-goal"])
def test_both_come_to_goals_of_all_kinds(law: str, scenario: str) -> None:
    reached = np.isfinite(goal_time(simulate(load_scenario(scenario), law, range(300, 500))))
    assert reached.mean() >= 0.99, (law, scenario)


def test_the_rules_of_parking_are_needed() -> None:
    """Without them, with their consequents dealt out anew, and under laws for timetables, the robot does not park."""
    scenario, seeds = load_scenario("parking"), range(100)

    def share(law: object) -> float:
        return float(np.isfinite(goal_time(simulate(scenario, law, seeds))).mean())  # type: ignore[arg-type]

    fis = load_rule_base("park")
    dealt = [fis.rules[k].then for k in np.random.default_rng(1).permutation(len(fis.rules))]
    rules = tuple(replace(rule, then=then) for rule, then in zip(fis.rules, dealt, strict=True))
    shuffled = replace(fis, rules=rules)
    whole = robotics.make_controller("fuzzy-park")
    assert share(whole) == 1.0
    assert share(replace(whole, rule_base=shuffled)) < 0.1  # type: ignore[type-var]
    assert max(share("fuzzy"), share("lyapunov")) < 0.3


def test_the_parking_law_makes_its_function_fall() -> None:
    """V = (e² + α² + h θ²)/2 never rises [Aicardi et al. 1995], and is nearly 0 where the goal is 2 cm away."""
    text = TEXT % "at = [0.0, 0.0], heading = 0.0" + "start_spread = [2.0, 2.0, 3.14]"
    text = text.replace("duration = 20.0", 'duration = 30.0\nplant = "kinematic"\nperiod = 0.01')
    law = Polar(h=2.0, near=0.0)
    run = simulate(parse_scenario(text, "mine"), law, range(50))
    x, y, heading = (run[n][:, 0] for n in ("x", "y", "heading"))
    e, line = np.hypot(x, y), np.arctan2(-y, -x)
    turned = [(a + pi) % (2 * pi) - pi for a in (line - heading, line)]  # α, and θ from the goal's heading 0
    v = (e**2 + turned[0] ** 2 + 2.0 * turned[1] ** 2) / 2
    far = e[:, :-1] > 0.02
    jumps = np.abs(np.diff(turned[1], axis=1)) > pi  # θ passes ±π: V has no derivative there
    assert (np.diff(v, axis=1)[far & ~jumps] < 1e-9).all()
    last = far.shape[1] - 1 - far[:, ::-1].argmax(axis=1)
    assert v[np.arange(50), last][e[:, 0] > 1].max() < 0.05


def test_a_robot_with_a_goal_is_made_in_python() -> None:
    goal = Goal(at=(1.0, 1.0), heading=pi / 2, within=0.05)
    scenario = Scenario(name="mine", kind="goal", duration=30.0, robots=(Member.reaching(goal, (0.0, 0.0, 0.0)),))
    assert np.isfinite(goal_time(simulate(scenario, "polar", [0]))).all()


def test_the_packaged_rule_base_has_no_findings() -> None:
    assert fuzzy.check(load_rule_base("park")) == []
