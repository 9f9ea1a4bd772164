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
from robotics.plugins.reinforcement.reward import SpanColumns
from robotics.plugins.reinforcement.task import Task, TaskError
from robotics.plugins.reinforcement.vector import TrackingVectorEnv
from robotics.simulation.scenario.description import Scenario
from robotics.studies.tuning.cost import FAILED_COST

try:
    import stable_baselines3
    import torch
    from gymnasium import spaces
    from stable_baselines3.common.callbacks import BaseCallback
    from stable_baselines3.common.vec_env import VecEnv, VecNormalize
except ModuleNotFoundError:
    raise TaskError(f"training needs stable-baselines3: {install_command('rl')}") from None

FASTER, SHARPER = 1.5, 2.0  # times the references' greatest speed and turn rate: the command of an output 1
_INPUT_RANGE = 10.0  # times what is much of an entry


@dataclass(frozen=True)
class Trained:
    """A policy and what it took."""

    policy: Policy
    seed: int
    steps: int
    seconds: float


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
    begins = [(s.starts[0], s.trajectory.at(0.0)) for s in scenarios]
    far = max(float(np.hypot(start[0] - aim.x[0], start[1] - aim.y[0])) for start, aim in begins)
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
        model.learn(about.steps, callback=Announcer(announce))
    finally:
        torch.set_num_threads(threads)
        vector.close()
    seconds = time.perf_counter() - began
    policy = _policy(model, scale, vector.task, _about(about, scenarios, seed, model.num_timesteps, seconds))
    return Trained(policy, seed, int(model.num_timesteps), seconds)


def _batch(samples: int, wanted: int) -> int:
    """The size of equal batches of all samples of a rollout, at most as large as wanted."""
    fewest = -(-samples // wanted)
    return next(samples // count for count in range(fewest, samples + 1) if samples % count == 0)


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


# The vector environment as Stable-Baselines3 takes it: lanes begin the next episode in the same step ----------------


class EpisodeVectorEnv(VecEnv):
    """A vector environment in the same-step mode, for Stable-Baselines3."""

    def __init__(self, env: TrackingVectorEnv, discount: float, scale: np.ndarray, clip: float) -> None:
        """Take the lanes of ``env``, whose mode is "same-step".

        Args:
            env: The environment.
            discount: That of the learner.
            scale: By which observations are multiplied (entries,).
            clip: How far from 0 they can then be.
        """
        assert env.autoreset == "same-step"
        self.discount, self.scale, self.clip = discount, scale, clip
        self.env, self.actions = env, np.zeros((env.num_envs, 2))
        self.render_mode = None
        box = spaces.Box(-clip, clip, (len(scale),), dtype=np.float32)
        super().__init__(env.num_envs, box, env.single_action_space)

    def reset(self) -> np.ndarray:
        """Begin an episode in every lane."""
        observed, _ = self.env.reset(seed=None if self._seeds[0] is None else int(self._seeds[0]))
        self._reset_seeds()
        return self._scaled(observed)

    def _scaled(self, observed: np.ndarray) -> np.ndarray:
        return np.clip(observed * self.scale, -self.clip, self.clip).astype(np.float32)

    def step_async(self, actions: np.ndarray) -> None:
        """Keep the actions for :meth:`step_wait`."""
        self.actions = actions

    def step_wait(self) -> Any:
        """Take a step."""
        notes = self.env.episodes.lanes.notes
        many = SpanColumns(notes.spans).many[notes.robot]
        observed, rewards, terminated, truncated, infos = self.env.step(self.actions)
        rewards = -np.log1p(np.minimum(-rewards * many, FAILED_COST))
        rewards[terminated] /= 1 - self.discount
        told: list[dict[str, Any]] = [{} for _ in range(self.num_envs)]
        done = terminated | truncated
        for lane in np.flatnonzero(done).tolist():
            last = self._scaled(infos["final_obs"][lane])
            told[lane] = {"terminal_observation": last, "TimeLimit.truncated": bool(truncated[lane])}
        return self._scaled(observed), rewards, done, told

    def close(self) -> None:
        """Close the environment."""
        self.env.close()

    def get_attr(self, attr_name: str, indices: Any = None) -> list[Any]:
        """An attribute, which is the same in all lanes."""
        return [getattr(self.env, attr_name) for _ in self._get_indices(indices)]

    def set_attr(self, attr_name: str, value: Any, indices: Any = None) -> None:
        """EpisodeVectorEnv have no attributes of their own."""
        raise NotImplementedError

    def env_method(self, method_name: str, *method_args: Any, indices: Any = None, **method_kwargs: Any) -> list[Any]:
        """EpisodeVectorEnv have no methods of their own."""
        raise NotImplementedError

    def env_is_wrapped(self, wrapper_class: type[Any], indices: Any = None) -> list[bool]:
        """No lane is wrapped."""
        return [False for _ in self._get_indices(indices)]


class Announcer(BaseCallback):
    """Tells, before every update, how many steps were taken."""

    def __init__(self, announce: Callable[[int], None] | None) -> None:
        super().__init__()
        self.announce = announce

    def _on_step(self) -> bool:
        return True

    def _on_rollout_end(self) -> None:
        if self.announce is not None:
            self.announce(int(self.num_timesteps))
