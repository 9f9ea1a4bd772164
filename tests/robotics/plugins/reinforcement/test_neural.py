"""Learnt policies: the law against the network in numpy and against the environment; files that are no policies."""

import json
from dataclasses import replace
from typing import Any

import numpy as np
import pytest

import robotics
from robotics.laws.law import ControllerError
from robotics.plugins.reinforcement.neural import NeuralPolicy
from robotics.plugins.reinforcement.observed import entries
from robotics.plugins.reinforcement.policyfile import Policy, load_policy, parse_policy
from robotics.world.sensing.posture import LABORATORY

SCENARIO = replace(robotics.load_scenario("lyapunov-circle"), duration=4.0, sensing=LABORATORY, latency=0.03)
NAMES = tuple(entry.name for entry in entries(SCENARIO.setting, "velocity"))


def network(policy, observed):
    """The policy's answer, in numpy."""
    z = np.clip((observed - policy.offset) * policy.scale, -policy.clip, policy.clip)
    for n, (weights, bias) in enumerate(policy.layers, start=1):
        z = weights @ z + bias
        z = np.tanh(z) if n < len(policy.layers) else np.clip(z, -1, 1)
    return z * policy.most


def drawn(sizes, seed=0, most=(0.6, 2.0), names=NAMES):
    """A random policy with hidden layers of these sizes."""
    random, before, layers = np.random.default_rng(seed), len(names), []
    for units in (*sizes, 2):
        layers.append((random.normal(size=(units, before)) / np.sqrt(before), random.normal(size=units) / 5))
        before = units
    offset, scale = random.normal(size=len(names)) / 10, random.uniform(0.5, 2, len(names))
    return Policy("velocity", names, offset, scale, 3.0, tuple(layers), most)


@pytest.mark.parametrize("sizes", [(), (3,), (20, 5), (4, 31, 7)])
def test_it_commands_what_the_network_answers_to_what_the_environment_observes(sizes):
    pytest.importorskip("gymnasium", reason="needs gymnasium")
    from robotics.plugins.reinforcement.single import TrackingEnv

    policy = drawn(sizes)
    run = robotics.simulate(SCENARIO, NeuralPolicy(policy=policy, first=0.9, second=1.1), seeds=[7])
    env = TrackingEnv(SCENARIO, units=True)
    observed, _ = env.reset(seed=7)
    for k in range(len(run.time)):
        wanted = network(policy, observed) * (0.9, 1.1)
        command = np.array([run["command_1"][0, 0, k], run["command_2"][0, 0, k]])
        assert command == pytest.approx(wanted, rel=1e-9, abs=1e-12)
        observed, *_ = env.step(command)


def test_runs_beside_it_and_other_policies_change_nothing():
    laws = [NeuralPolicy(policy=drawn((4, 9))), NeuralPolicy(policy=drawn((16,), 1)), NeuralPolicy(policy=drawn((), 2))]
    together = robotics.simulate_many(SCENARIO, laws, range(3), keep="metrics", metrics=["rms_cross_track_m"])
    for n, law in enumerate(laws):
        alone = robotics.measure(robotics.simulate(SCENARIO, law, seeds=range(3)))["rms_cross_track_m"]
        assert (together["rms_cross_track_m"][n] == alone).all()


def test_a_file_keeps_a_policy_to_single_precision_and_drives(tmp_path):
    policy = drawn((6, 6))
    policy.write(tmp_path / "mine.json")
    read = load_policy(tmp_path / "mine.json")
    for (a, b), (c, d) in zip(policy.layers, read.layers, strict=True):
        assert (np.float32(a) == np.float32(c)).all()
        assert (np.float32(b) == np.float32(d)).all()
    assert read.text() == parse_policy(read.text()).text() == (tmp_path / "mine.json").read_text()
    law: Any = robotics.make_controller(f"ppo:policy={tmp_path / 'mine.json'},second=0.5")
    assert law.second == 0.5
    robotics.simulate(SCENARIO, law)


def test_the_packaged_policy_follows_random_paths_better_than_the_fuzzy_rule_base_does():
    from robotics.plugins.reinforcement.choosing import chosen_scenarios
    from robotics.studies.tuning.cost import Cost, costs_of

    scenarios = chosen_scenarios(None, "default", 4, 8_000_000)
    ppo, fuzzy = costs_of(Cost(), scenarios, ["ppo", "fuzzy"], range(5)).sum(axis=-1).mean(axis=(1, 2))
    assert ppo < 0.8 * fuzzy


def test_what_is_no_policy_is_refused(tmp_path):
    good = json.loads(drawn((3,)).text())
    for change, says in [
        ({"format": 2}, "no policy of format 1"),
        ({"level": "speed"}, "unknown level 'speed'"),
        ({"inputs": []}, "inputs must be names"),
        ({"offset": [0.0]}, "offset must be 15 finite numbers"),
        ({"scale": [None] * 15}, "scale must be 15 finite numbers"),
        ({"clip": 0}, "clip must be a number > 0"),
        ({"most": [1.0, -1.0]}, "most must be two numbers > 0"),
        ({"layers": []}, "layers must be a list"),
        ({"layers": good["layers"][:1]}, "last layer must have 2 outputs; it has 3"),
        ({"layers": [{"bias": [0.0, 0.0], "weights": [[1.0]]}]}, "layer 1: weights must be 2 x 15 finite numbers"),
        ({"layers": [{"weights": [[1.0]]}]}, "layer 1: bias must be 1 to 4096 numbers"),
    ]:
        with pytest.raises(ControllerError, match=f"mine.json: .*{says}"):
            parse_policy(json.dumps(good | change), "mine.json")
    for text, says in [("{", "no JSON"), ("[]", "no policy"), ("[" * 100_000, "no JSON")]:
        with pytest.raises(ControllerError, match=f"mine.json: .*{says}"):
            parse_policy(text, "mine.json")
    with pytest.raises(ControllerError, match="scale is missing"):
        parse_policy(json.dumps({k: v for k, v in good.items() if k != "scale"}))
    (tmp_path / "bytes.json").write_bytes(b"\xff\xfe\xff")
    with pytest.raises(ControllerError, match=r"bytes.json: this is no text"):
        robotics.make_controller(f"ppo:policy={tmp_path / 'bytes.json'}")
    with pytest.raises(ControllerError, match=r"cannot be read: No such file"):
        robotics.make_controller("ppo:policy=nowhere.json")
    with pytest.raises(ControllerError, match=r"unknown policy 'pp'; did you mean 'ppo'"):
        robotics.make_controller("ppo:policy=pp")
    with pytest.raises(ControllerError, match="three-cross is a team; a learnt policy drives tracking"):
        robotics.simulate(robotics.load_scenario("three-cross"), "ppo")
    with pytest.raises(ControllerError, match="the policy at hand observes strange"):
        robotics.simulate(SCENARIO, NeuralPolicy(policy=drawn((3,), names=("strange", *NAMES[1:]))))
    with pytest.raises(ControllerError, match=r"must carry|sensor"):
        robotics.simulate(SCENARIO, NeuralPolicy(policy=drawn((3,), names=(*NAMES, "range_radar"))))
