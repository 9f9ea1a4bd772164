"""The vector environment as Stable-Baselines3 takes it: lanes begin the next episode in the same step."""

from collections.abc import Callable, Sequence
from typing import Any

import numpy as np
from gymnasium import spaces
from stable_baselines3.common.callbacks import BaseCallback
from stable_baselines3.common.vec_env import VecEnv

from robotics.plugins.reinforcement.reward import SpanColumns
from robotics.plugins.reinforcement.vector import TrackingVectorEnv
from robotics.studies.tuning.cost import FAILED_COST


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
            told[lane] = {
                "terminal_observation": self._scaled(infos["final_obs"][lane]),
                "TimeLimit.truncated": bool(truncated[lane]),
                "cost": float(infos["final_info"]["cost"][lane]),
            }
        return self._scaled(observed), rewards, done, told

    def close(self) -> None:
        """Close the environment."""
        self.env.close()

    def get_attr(self, attr_name: str, indices: Any = None) -> list[Any]:
        """An attribute, which is the same in all lanes."""
        return [getattr(self.env, attr_name)] * self._count(indices)

    def set_attr(self, attr_name: str, value: Any, indices: Any = None) -> None:
        """EpisodeVectorEnv have no attributes of their own."""
        raise NotImplementedError

    def env_method(self, method_name: str, *method_args: Any, indices: Any = None, **method_kwargs: Any) -> list[Any]:
        """EpisodeVectorEnv have no methods of their own."""
        raise NotImplementedError

    def env_is_wrapped(self, wrapper_class: type[Any], indices: Any = None) -> list[bool]:
        """No lane is wrapped."""
        return [False] * self._count(indices)

    def _count(self, indices: int | Sequence[int] | None) -> int:
        return self.num_envs if indices is None else 1 if isinstance(indices, int) else len(list(indices))


class EpisodeWatch(BaseCallback):
    """Tells how many steps were taken, and keeps what the episodes cost that ended between two updates."""

    def __init__(self, announce: Callable[[int], None] | None) -> None:
        super().__init__()
        self.announce = announce
        self.ended: list[float] = []
        self.curve: list[tuple[int, float]] = []

    def _on_step(self) -> bool:
        self.ended += [info["cost"] for info in self.locals["infos"] if "cost" in info]
        return True

    def _on_rollout_end(self) -> None:
        if self.ended:
            self.curve.append((int(self.num_timesteps), float(np.mean(self.ended))))
            self.ended = []
        if self.announce is not None:
            self.announce(int(self.num_timesteps))
