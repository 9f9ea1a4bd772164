"""The environments by the checks of Gymnasium and PettingZoo, how they begin anew, and what they refuse."""

import importlib
import subprocess
import sys
from dataclasses import replace
from typing import Any

import numpy as np
import pytest

import robotics
from robotics.plugins.reinforcement.observed import command_limits
from robotics.plugins.reinforcement.task import TaskError
from robotics.world.sensing.posture import LABORATORY

gymnasium = pytest.importorskip("gymnasium", reason="needs gymnasium")
pytest.importorskip("pettingzoo", reason="needs pettingzoo")
from gymnasium.utils.env_checker import check_env  # noqa: E402
from pettingzoo.test import parallel_api_test, parallel_seed_test  # noqa: E402

import robotics.plugins.reinforcement  # noqa: E402
from robotics.plugins.reinforcement.reward import reward_observer  # noqa: E402
from robotics.plugins.reinforcement.single import TrackingEnv  # noqa: E402
from robotics.plugins.reinforcement.team import TeamEnv  # noqa: E402
from robotics.plugins.reinforcement.vector import TrackingVectorEnv  # noqa: E402

SHORT = replace(robotics.load_scenario("lyapunov-circle"), duration=3.0, sensing=LABORATORY)
TEAM = replace(robotics.load_scenario("three-cross"), duration=4.0)


@pytest.mark.parametrize("first", ["gymnasium", "robotics.plugins.reinforcement"])
def test_the_id_is_known_whichever_is_imported_first(first):
    code = (
        f"import {first}, gymnasium, robotics.plugins.reinforcement, sys; before = len(sys.meta_path)\n"
        "gymnasium.spec('fuzzyfleet/Tracking-v0'); robotics.plugins.reinforcement.register()\n"
        "print(len(sys.meta_path) - before)"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True, timeout=60)
    assert done.stdout == "0\n", "the finder stays behind"


@pytest.mark.parametrize("options", [{"scenario": SHORT}, {"scenario": SHORT, "level": "torque"}, {"draws": 2}])
def test_gymnasium_finds_nothing_wrong(options):
    env = gymnasium.make("fuzzyfleet/Tracking-v0", **options)
    check_env(env.unwrapped)  # warnings are errors
    env.close()


def test_an_env_in_units_is_right_but_for_the_advice_to_normalise():
    env = gymnasium.make("fuzzyfleet/Tracking-v0", scenario=SHORT, units=True)
    with pytest.warns(UserWarning, match="normalized space"):
        check_env(env.unwrapped)


def test_pettingzoo_finds_nothing_wrong():
    for options in ({}, {"level": "torque", "units": True}, {"reward": "cost"}):
        parallel_api_test(TeamEnv(TEAM, **options), num_cycles=100)
        parallel_seed_test(lambda options=options: TeamEnv(TEAM, **options))


def test_make_vec_makes_the_lanes_and_declares_how_they_begin_anew():
    env = gymnasium.make_vec("fuzzyfleet/Tracking-v0", num_envs=5, scenario=SHORT)
    assert isinstance(env, TrackingVectorEnv)
    assert env.metadata["autoreset_mode"] is gymnasium.vector.AutoresetMode.NEXT_STEP
    assert env.observation_space.shape == (5, 15)
    assert env.action_space.shape == (5, 2)
    other = gymnasium.make_vec("fuzzyfleet/Tracking-v0", num_envs=2, scenario=SHORT, autoreset="same-step")
    assert other.metadata["autoreset_mode"] is gymnasium.vector.AutoresetMode.SAME_STEP


def high(space: Any) -> Any:
    return space.high


def test_actions_and_observations_have_the_limits_of_the_robot():
    robot = SHORT.setting.robots[0]
    env = TrackingEnv(SHORT, units=True)
    assert tuple(high(env.action_space)) == (robot.v_max, robot.w_max) == command_limits(robot, "velocity")
    assert tuple(high(TrackingEnv(SHORT, units=True, level="torque").action_space)) == (robot.torque_limit,) * 2
    assert tuple(high(TrackingEnv(SHORT).action_space)) == (1.0, 1.0)
    names = [entry.name for entry in env.task.entries]
    assert high(env.observation_space)[names.index("x_error")] == SHORT.divergence
    assert high(env.observation_space)[names.index("v_reference")] == 2 * robot.v_max


def test_an_action_of_1_is_the_greatest_command():
    for most in (None, (0.4, 0.8)):
        one, two = TrackingEnv(SHORT, most=most), TrackingEnv(SHORT, units=True)
        one.reset(seed=1), two.reset(seed=1)
        robot = SHORT.setting.robots[0]
        limits = np.array([robot.v_max, robot.w_max] if most is None else most)
        for share in ([1.0, -1.0], [0.3, 0.5], [7.0, 0.0]):  # what is beyond 1 counts as 1
            a, b = one.step(share), two.step(np.clip(share, -1, 1) * limits)
            assert (a[0][:7] == b[0][:7]).all()
            assert a[1] == b[1]


def test_the_same_seed_gives_the_same_episodes():
    def told(env):
        env.action_space.seed(3)
        found = [env.reset(seed=11)[0]]
        for _ in range(3 * (SHORT.ticks + 1)):
            observed, reward, terminated, truncated, infos = env.step(env.action_space.sample())
            found += [observed, reward, infos.get("cost")]
            if terminated or truncated:
                observed, infos = env.reset()
                found += [observed, infos["seed"]]
        return found

    first, second = told(TrackingEnv(draws=3)), told(TrackingEnv(draws=3))
    assert all(np.array_equal(a, b) for a, b in zip(first, second, strict=True))
    assert {s for s in first if isinstance(s, int)}.isdisjoint(range(4_000_000)), "seeds that arenas use"


def test_episodes_have_the_scenarios_and_seeds_asked_for():
    env = TrackingVectorEnv(200, draws=4)
    _, infos = env.reset(seed=40)
    assert infos["seed"].tolist() == list(range(40, 240))
    assert {*infos["scenario"].tolist()} == {0, 1, 2, 3}
    _, infos = env.reset(seed=[5] * 200, options={"scenario": 2})
    assert {*infos["scenario"].tolist()} == {2}
    assert {*infos["seed"].tolist()} == {5}
    names = [scenario.name for scenario in env.scenarios]
    blocks = [
        s.name for arena in [robotics.load_arena()] for b in ("tune", "choose", "test") for s in arena.scenarios(b)
    ]
    assert {*names}.isdisjoint(blocks)


def test_the_three_ways_of_beginning_anew():
    actions, last = np.zeros((3, 2)), SHORT.ticks
    kept = {}
    for mode in ("next-step", "same-step", "disabled"):
        env = TrackingVectorEnv(3, SHORT, autoreset=mode)
        env.reset(seed=0)
        for _ in range(last):
            _, _, terminated, truncated, infos = env.step(actions)
            assert not (terminated | truncated).any()
            assert infos == {}
        kept[mode] = env, env.step(actions)
        assert kept[mode][1][3].all()
    env, (observed, *_, infos) = kept["next-step"]
    assert (infos["cost"] > 0).all()
    assert infos["_cost"].all()
    assert infos["end"].tolist() == ["time"] * 3
    begun, rewards, terminated, truncated, infos = env.step(actions + 1)
    assert (rewards == 0).all()
    assert not (terminated | truncated).any()
    assert infos == {}
    same, (same_observed, *_, same_infos) = kept["same-step"]
    assert (same_observed == begun).all()
    assert same_infos["_final_obs"].all()
    assert (np.stack(list(same_infos["final_obs"])) == observed).all()
    assert (same_infos["final_info"]["cost"] > 0).all()
    assert (same.step(actions)[0] == env.step(actions)[0]).all()
    disabled, _ = kept["disabled"]
    with pytest.raises(TaskError, match=r"lane 0 has ended: reset\(\) it"):
        disabled.step(actions)
    observed, _ = disabled.reset(options={"reset_mask": np.array([True, True, True])})
    assert (observed == begun).all()


def test_a_robot_that_touches_another_is_an_agent_no_more():
    env = TeamEnv("three-cross", units=True)
    observed, infos = env.reset(seed=0)
    assert env.agents == ["robot_1", "robot_2", "robot_3"]
    everybody, agents = dict.fromkeys(env.agents, np.array([0.3, 0.0])), 3
    ends: dict[str, str] = {}
    while env.agents:
        before = list(env.agents)
        observed, rewards, terminated, truncated, infos = env.step({a: everybody[a] for a in before})
        assert [*observed] == [*rewards] == [*terminated] == [*truncated] == [*infos] == before
        ends |= {a: infos[a]["end"] for a in before if terminated[a] or truncated[a]}
        assert env.agents == [a for a in before if not (terminated[a] or truncated[a])]
        agents = min(agents, len(env.agents))
    assert set(ends.values()) <= {"diverged", "collided", "time"}
    assert "diverged" in ends.values()
    with pytest.raises(TaskError, match="no episode goes on"):
        env.step({})


def test_a_team_drives_as_in_a_run_and_hears_what_the_radio_brings():
    scenario = replace(TEAM, duration=10.0, radio=replace(TEAM.radio, loss=0.3, latency=0.1, period=0.2))
    observer = reward_observer(scenario)
    run = robotics.simulate(scenario, "virtual-structure", seeds=[4], observer=observer)
    env = TeamEnv(scenario, units=True)
    returned = dict.fromkeys(env.possible_agents, 0.0)
    observed, _ = env.reset(seed=4)
    names = [entry.name for entry in env.entries["robot_2"]]
    ages = set()
    for k in range(scenario.ticks + 1):
        truth = env.simulation.lanes.body.truth
        assert (truth[0] == run["x"][0, :, k]).all()
        assert (truth[2] == run["heading"][0, :, k]).all()
        x, y, heading = (run[f"{n}_measured"][0, :, k] for n in ("x", "y", "heading"))
        age = observed["robot_2"][names.index("robot1_age")]
        ages.add(round(float(age), 3))
        if age < 5:  # where robot 1 said that it was, then
            then = k - round(age / scenario.period)
            dx, dy = run["x_measured"][0, 0, then] - x[1], run["y_measured"][0, 0, then] - y[1]
            ahead = np.cos(heading[1]) * dx + np.sin(heading[1]) * dy
            assert observed["robot_2"][names.index("robot1_ahead")] == pytest.approx(ahead, abs=1e-12)
        else:
            assert observed["robot_2"][names.index("robot1_ahead")] == 0
        command = {a: [run["command_1"][0, n, k], run["command_2"][0, n, k]] for n, a in enumerate(env.agents)}
        observed, rewards, *_, infos = env.step(command)
        returned = {a: returned[a] + rewards[a] for a in returned}
    assert {info["end"] for info in infos.values()} == {"time"}
    assert [*returned.values()] == observer.notes.returned.tolist()
    assert not env.agents
    assert 5.0 in ages
    assert max(ages - {5.0}) > 0.3
    assert len(ages) > 6


def test_what_is_wrong_is_said():
    wrongs: list[tuple[Any, dict[str, Any], str]] = [
        (TrackingEnv, {"scenario": "three-cross"}, r"has a team; an environment of one robot .* robotics.TeamEnv"),
        (TrackingEnv, {"scenario": "wall"}, "scenario"),
        (TrackingEnv, {"scenario": SHORT, "arena": "default"}, "got both"),
        (TrackingEnv, {"scenario": SHORT, "level": "speed"}, "level"),
        (TrackingEnv, {"scenario": SHORT, "reward": "coast"}, "did you mean 'cost'"),
        (TrackingEnv, {"scenario": SHORT, "approach": -1.0}, "approach must be a number >= 0"),
        (TrackingEnv, {"scenario": SHORT, "divergence": 0.0}, r"divergence must be a number > 0 \[m\]"),
        (TrackingEnv, {"scenario": SHORT, "most": (1.0,)}, "most must be two numbers > 0"),
        (TrackingEnv, {"draws": 0}, "draws must be a whole number >= 1"),
        (TrackingEnv, {"scenario": []}, "at least one scenario"),
        (TrackingEnv, {"scenario": [SHORT, replace(SHORT, latency=0.3)]}, "have the same latency"),
        (TrackingEnv, {"scenario": replace(SHORT, plant="kinematic"), "level": "torque"}, "takes no torques"),
        (TrackingVectorEnv, {"scenario": SHORT, "num_envs": 0}, "whole number >= 1"),
        (TrackingVectorEnv, {"scenario": SHORT, "autoreset": "never"}, "autoreset must be one of next-step"),
        (TeamEnv, {"scenario": SHORT}, "has one robot; that is robotics.TrackingEnv"),
        (TeamEnv, {"scenario": TEAM, "reward": "x"}, "reward"),
    ]
    for wrong, options, says in wrongs:
        with pytest.raises(robotics.ScenarioError if options.get("scenario") == "wall" else TaskError, match=says):
            wrong(**options)
    several, one, team = TrackingVectorEnv(3, SHORT), TrackingEnv(SHORT), TeamEnv(TEAM)
    with pytest.raises(TaskError, match=r"reset\(\) begins"):
        several.step(np.zeros((3, 2)))
    several.reset(), one.reset(), team.reset()
    env: Any
    action: Any
    seed: Any
    for env, action, says in [
        (several, np.zeros((2, 2)), r"actions must have the shape \(3, 2\); got \(2, 2\)"),
        (several, "left", "actions must be numbers"),
        (one, [0.0, 0.0, 0.0], "an action must be two numbers"),
        (one, "left", "an action must be two numbers"),
        (team, {"robot_1": [0.0, 0.0]}, "robot_2 has none"),
        (team, dict.fromkeys(team.agents, 1.0), "robot_1: an action must be two numbers"),
        (team, [0.0, 0.0], "actions must be a dict"),
    ]:
        with pytest.raises(TaskError, match=says):
            env.step(action)
    for env, seed in [(several, -1), (several, [1, 2]), (one, -3), (team, -1)]:
        with pytest.raises((TaskError, gymnasium.error.Error), match=r"seed|Seed"):
            env.reset(seed=seed)
    with pytest.raises(TaskError, match="scenario must be a place from 0 to 0"):
        one.reset(options={"scenario": 1})


@pytest.mark.parametrize(
    ("package", "module", "says"),
    [
        ("gymnasium", "single", "environments need gymnasium: pip install"),
        ("pettingzoo", "team", "environments of teams need pettingzoo: pip install"),
    ],
)
def test_without_the_package_it_says_how_to_get_it(package, module, says, monkeypatch):
    monkeypatch.setitem(sys.modules, package, None)
    for name in ("packages", "vector", "single", "team"):
        monkeypatch.delitem(sys.modules, f"robotics.plugins.reinforcement.{name}")
    with pytest.raises(TaskError, match=says):
        importlib.import_module(f"robotics.plugins.reinforcement.{module}")
