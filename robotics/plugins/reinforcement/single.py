"""One episode after the other, as an environment of Gymnasium: a vector environment of one lane."""

from typing import Any

import numpy as np

from robotics.plugins.reinforcement.packages import gymnasium
from robotics.plugins.reinforcement.task import TaskError, checked_action
from robotics.plugins.reinforcement.vector import TrackingVectorEnv


class TrackingEnv(gymnasium.Env):
    """A robot that tracks its reference, as an environment of Gymnasium; observations (entries,) and actions (2,) are
    float64.

    Args:
        scenario: As of :class:`robotics.plugins.reinforcement.vector.TrackingVectorEnv`.
        options: Its other arguments but ``num_envs`` and ``autoreset``.
    """

    metadata: dict[str, Any] = {"render_modes": []}  # noqa: RUF012

    def __init__(self, scenario: Any = None, **options: Any) -> None:
        """Open it; :meth:`reset` begins an episode. Raises TaskError."""
        self.lane = TrackingVectorEnv(1, scenario, autoreset="disabled", **{"threads": 1, **options})
        self.task = self.lane.task  # what it is about
        self.observation_space = self.lane.single_observation_space
        self.action_space = self.lane.single_action_space
        self.render_mode = None
        self.over = False

    def reset(
        self, *, seed: int | None = None, options: dict[str, Any] | None = None
    ) -> tuple[np.ndarray, dict[str, Any]]:
        """Begin an episode; ``seed`` is that of its run, and the later episodes follow from it.

        Args:
            seed: A whole number >= 0.
            options: ``scenario``: the place of the scenario.

        Returns:
            What is observed (entries,), and infos: the scenario's name and the seed.
        """
        super().reset(seed=seed)
        observed, infos = self.lane.reset(seed=seed, options=options)
        self.over = False
        scenario = self.task.scenarios[int(infos["scenario"][0])]
        return observed[0], {"scenario": scenario.name, "seed": int(infos["seed"][0])}

    def step(self, action: Any) -> tuple[np.ndarray, float, bool, bool, dict[str, Any]]:
        """Take a step with ``action`` (2,).

        Returns:
            What is observed (entries,), the reward, whether the episode has ended by divergence or a contact, whether
            by time, and infos, as of the vector environment.

        Raises:
            TaskError: The episode has ended.
        """
        if self.over:
            raise TaskError("the episode has ended: reset() begins the next one")
        observed, rewards, terminated, truncated, infos = self.lane.step(checked_action(action)[None])
        self.over = bool(terminated[0] or truncated[0])
        told = {"cost": float(infos["cost"][0]), "end": str(infos["end"][0])} if self.over else {}
        return observed[0], float(rewards[0]), bool(terminated[0]), bool(truncated[0]), told

    def close(self) -> None:
        """Let go of what it holds."""
        self.lane.close()
