"""Training a policy by proximal policy optimisation, with Stable-Baselines3 on our vector environment.

The learner is paid −ln(1 + c) a sample, with c the sample's cost (distance / 1 cm + heading error / 5° + change of the
turn rate / period), at most that of a failure, from the start on; and as much as the worst that could follow where the
episode ends by divergence or a contact. The logarithm makes a centimetre matter beside a metre. What is told of a policy is the arena's
cost all the same, on scenarios and seeds that it has not learnt on.
"""

import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np

from fuzzy.extras import install_command
from robotics.laws.tracking.policyfile import Policy
from robotics.quantity import check_quantities, quantity, whole
from robotics.reinforcement.choosing import LEARNING, chosen_scenarios
from robotics.reinforcement.task import Task, TaskError
from robotics.scenario.description import Scenario

VALIDATION = 6_000_000  # the first number of the scenarios, and of the seeds, by which policies are chosen among
FASTER, SHARPER = 1.5, 2.0  # times the references' greatest speed and turn rate: the command of an output 1
_INPUT_RANGE = 10.0  # times what is much of an entry


@dataclass(frozen=True, kw_only=True)
class Learning:
    """How a policy is learnt. Raises TaskError for numbers that cannot be."""

    steps: int = whole(10_000_000, least=1, most=10**10, doc="Control periods that are driven, of all lanes together.")
    lanes: int = whole(512, least=1, most=100_000, doc="Robots that drive at a time.")
    rollout: int = whole(32, least=2, most=10_000, doc="Periods between two updates.")
    batch: int = whole(2048, least=2, doc="Samples of a gradient.")
    epochs: int = whole(5, least=1, most=1000, doc="How often an update sees each sample.")
    rate: float = quantity(1e-3, "1", above=0, doc="The learning rate at the start; it falls linearly to a 20th.")
    discount: float = quantity(0.95, "1", above=0, most=0.9999, doc="What a reward counts one period later.")
    spread: float = quantity(0.37, "1", above=0, doc="The standard deviation of the actions at the start.")
    units: int = whole(32, least=1, most=4096, doc="Units of each of the two hidden layers.")
    divergence: float = quantity(0.3, "m", above=0, doc="An episode ends so far beyond the farthest start.")

    def __post_init__(self) -> None:
        check_quantities(self, TaskError)


@dataclass(frozen=True)
class Trained:
    """A policy and what it took."""

    policy: Policy
    seed: int
    steps: int
    seconds: float
    curve: tuple[tuple[int, float], ...] = field(default=())  # steps, and the mean cost of the episodes ended meanwhile


def train(
    scenarios: Sequence[Scenario],
    learning: Learning | None = None,
    *,
    seed: int = 0,
    advance: Callable[[int], None] | None = None,
) -> Trained:
    """Learn a policy on ``scenarios`` of one robot each.

    Args:
        scenarios: Each episode drives one of them, with a seed of its own.
        learning: How; by default as the packaged policy was learnt.
        seed: Of the learner and of its episodes.
        advance: Called with the number of steps taken since the last call.

    Raises TaskError where Stable-Baselines3 is not installed, or the scenarios do not suit.
    """
    learner = _packages()
    about, scenarios = learning or Learning(), tuple(scenarios)
    task = Task(scenarios)
    far = max(float(np.hypot(*(s.starts[0, :2] - _begin(s)))) for s in scenarios)
    v, w = (max(float(np.abs(getattr(s.trajectory.sampled(s.times), name)).max()) for s in scenarios) for name in "vw")
    most = task.most_of.min(axis=1)
    vector = learner.vector(
        about.lanes,
        list(scenarios),
        autoreset="same-step",
        approach=1.0,
        divergence=min(far + about.divergence, scenarios[0].divergence),
        most=(min(float(most[0]), FASTER * v), min(float(most[1]), max(SHARPER * w, 1.0))),
    )
    scale = _scales(vector.task)
    lanes = learner.lanes(vector, about.discount, scale, _INPUT_RANGE)
    normal = learner.normalize(lanes, norm_obs=False, gamma=about.discount)
    began = time.perf_counter()
    threads = learner.torch.get_num_threads()
    learner.torch.set_num_threads(1)
    watch = learner.watch(advance)
    try:
        model = learner.ppo(
            "MlpPolicy",
            normal,
            seed=seed,
            n_steps=about.rollout,
            batch_size=about.batch,
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
        learner.torch.set_num_threads(threads)
        vector.close()
    seconds = time.perf_counter() - began
    policy = _policy(model, scale, vector.task, _about(about, scenarios, seed, model.num_timesteps, seconds, learner))
    return Trained(policy, seed, int(model.num_timesteps), seconds, tuple(watch.curve))


def _begin(scenario: Scenario) -> np.ndarray:
    """Where the reference begins (2,) [m]."""
    at = scenario.trajectory.at(0.0)
    return np.array([at.x[0], at.y[0]])


def _about(
    about: Learning, scenarios: Sequence[Scenario], seed: int, steps: int, seconds: float, learner: Any
) -> dict[str, Any]:
    return {
        "algorithm": f"PPO of stable-baselines3 {learner.version}",
        "seed": seed,
        "steps": int(steps),
        "minutes": round(seconds / 60, 2),
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


@dataclass(frozen=True)
class _Learner:
    """What is taken of packages that need not be there."""

    torch: Any
    ppo: Any
    normalize: Any
    lanes: Any
    vector: Any
    watch: Any
    version: str


def _packages() -> _Learner:
    try:
        import stable_baselines3
        import torch
        from stable_baselines3.common.vec_env import VecNormalize
    except ModuleNotFoundError:
        raise TaskError(f"training needs stable-baselines3: {install_command('rl')}") from None
    from robotics.reinforcement.sb3 import Lanes, Watch
    from robotics.reinforcement.vector import TrackingVectorEnv

    return _Learner(
        torch, stable_baselines3.PPO, VecNormalize, Lanes, TrackingVectorEnv, Watch, stable_baselines3.__version__
    )


def learning_scenarios(arena: str | Path | None = None, draws: int = 96) -> tuple[Scenario, ...]:
    """Scenarios to learn on: drawn from the sorts that an arena tunes on, by default those of the packaged policy."""
    return chosen_scenarios(None, arena or Path(__file__).parent / "learning.toml", draws, LEARNING)


def validation_scenarios(arena: str | Path | None = None, draws: int = 12) -> tuple[Scenario, ...]:
    """Others of the same sorts, to choose by."""
    return chosen_scenarios(None, arena or Path(__file__).parent / "learning.toml", draws, VALIDATION)
