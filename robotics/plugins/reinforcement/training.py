"""Training a policy by proximal policy optimisation, with Stable-Baselines3 on our vector environment.

The learner is paid −ln(1 + c) a sample, with c the sample's cost (distance / 1 cm + heading error / 5° + change of
the turn rate / period), at most that of a failure, from the start on; and as much as the worst that could follow where
the episode ends by divergence or a contact. The logarithm makes a centimetre matter beside a metre. What is told of a
policy is the arena's cost all the same, on scenarios and seeds that it has not learnt on.
"""

import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from fuzzy.compiled.threads import processors
from fuzzy.extras import install_command
from robotics.plugins.reinforcement.learning import Learning
from robotics.plugins.reinforcement.policyfile import Policy
from robotics.plugins.reinforcement.task import Task, TaskError
from robotics.plugins.reinforcement.vector import TrackingVectorEnv
from robotics.simulation.scenario.description import Scenario

try:
    import stable_baselines3
    import torch
    from stable_baselines3.common.vec_env import VecNormalize
except ModuleNotFoundError:
    raise TaskError(f"training needs stable-baselines3: {install_command('rl')}") from None
from robotics.plugins.reinforcement.sb3 import EpisodeVectorEnv, EpisodeWatch

FASTER, SHARPER = 1.5, 2.0  # times the references' greatest speed and turn rate: the command of an output 1
_INPUT_RANGE = 10.0  # times what is much of an entry


@dataclass(frozen=True)
class Trained:
    """A policy and what it took."""

    policy: Policy
    seed: int
    steps: int
    seconds: float
    curve: tuple[tuple[int, float], ...]  # steps, and the mean cost of the episodes ended meanwhile


def train(
    scenarios: Sequence[Scenario],
    learning: Learning | None = None,
    *,
    seed: int = 0,
    announce: Callable[[int], None] | None = None,
) -> Trained:
    """Learn a policy on ``scenarios`` of one robot each.

    Args:
        scenarios: Each episode drives one of them, with a seed of its own.
        learning: How; by default as the packaged policy was learnt.
        seed: Of the learner and of its episodes.
        announce: Called now and then with the number of steps taken so far.

    Raises TaskError where Stable-Baselines3 is not installed, or the scenarios do not suit.
    """
    about, scenarios = learning or Learning(), tuple(scenarios)
    task = Task(scenarios)
    far = max(float(np.hypot(*(s.starts[0, :2] - _begin(s)))) for s in scenarios)
    v, w = (max(float(np.abs(getattr(s.trajectory.sampled(s.times), name)).max()) for s in scenarios) for name in "vw")
    most = task.most_of.min(axis=1)
    vector = TrackingVectorEnv(
        about.lanes,
        list(scenarios),
        autoreset="same-step",
        approach=1.0,
        divergence=min(far + about.divergence, scenarios[0].divergence),
        most=(min(float(most[0]), FASTER * v), min(float(most[1]), max(SHARPER * w, 1.0))),
    )
    scale = _scales(vector.task)
    lanes = EpisodeVectorEnv(vector, about.discount, scale, _INPUT_RANGE)
    normal = VecNormalize(lanes, norm_obs=False, gamma=about.discount)
    began = time.perf_counter()
    threads = torch.get_num_threads()
    torch.set_num_threads(1)
    watch = EpisodeWatch(announce)
    try:
        model = stable_baselines3.PPO(
            "MlpPolicy",
            normal,
            seed=seed,
            n_steps=about.rollout,
            batch_size=_batch(about.rollout * about.lanes, about.batch),
            n_epochs=about.epochs,
            gamma=about.discount,
            learning_rate=lambda left: about.rate * max(left, 0.05),
            policy_kwargs={
                "net_arch": {"pi": [about.units] * 2, "vf": [about.units] * 2},
                "log_std_init": float(np.log(about.spread)),
            },
            device="cpu",
        )
        model.learn(about.steps, callback=watch)
    finally:
        torch.set_num_threads(threads)
        vector.close()
    seconds = time.perf_counter() - began
    policy = _policy(model, scale, vector.task, _about(about, scenarios, seed, model.num_timesteps, seconds))
    return Trained(policy, seed, int(model.num_timesteps), seconds, tuple(watch.curve))


def _batch(samples: int, wanted: int) -> int:
    """The size of equal batches of all samples of a rollout, at most as large as wanted."""
    count = -(-samples // wanted)
    while samples % count:
        count += 1
    return samples // count


def _begin(scenario: Scenario) -> np.ndarray:
    """Where the reference begins (2,) [m]."""
    at = scenario.trajectory.at(0.0)
    return np.array([at.x[0], at.y[0]])


def _about(about: Learning, scenarios: Sequence[Scenario], seed: int, steps: int, seconds: float) -> dict[str, Any]:
    return {
        "algorithm": f"PPO of stable-baselines3 {stable_baselines3.__version__}",
        "seed": seed,
        "steps": int(steps),
        "minutes": round(seconds / 60, 2),
        "cores": processors(),
        "scenarios": len(scenarios),
        **{name: getattr(about, name) for name in ("lanes", "rollout", "batch", "epochs", "rate", "discount", "units")},
    }


def _scales(task: Task) -> np.ndarray:
    """By what each entry of an observation is multiplied (entries,): one over what is much of it."""
    v, w = task.most_of[:, 0] if task.level == "velocity" else (1.0, 1.0)
    much = {"m": 0.1, "rad": 0.2, "m/s": v / 2, "rad/s": w / 2, "1/m": 1.0, "N m": task.most_of[0, 0] / 2}
    return np.array([1 / (entry.high / 2 if entry.positive else much[entry.unit]) for entry in task.entries])


def _policy(model: Any, scale: np.ndarray, task: Task, about: dict[str, Any]) -> Policy:
    """The deterministic part of what was learnt: the mean of the actions, with the scales of its inputs."""
    network = model.policy.state_dict()
    names = ("mlp_extractor.policy_net.0", "mlp_extractor.policy_net.2", "action_net")
    layers = [(network[f"{n}.weight"].double().numpy(), network[f"{n}.bias"].double().numpy()) for n in names]
    most = (float(task.most_of[0, 0]), float(task.most_of[1, 0]))
    inputs = tuple(entry.name for entry in task.entries)
    return Policy(task.level, inputs, np.zeros(len(scale)), scale, _INPUT_RANGE, tuple(layers), most, about)
