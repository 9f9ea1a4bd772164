"""Many episodes at once, as a vector environment of Gymnasium: a step touches all lanes in compiled code."""

from collections.abc import Sequence
from pathlib import Path
from typing import Any, Literal, get_args

import numpy as np

from robotics.plugins.reinforcement.choosing import LEARNING, Chooser, Scenarios, chosen_scenarios
from robotics.plugins.reinforcement.episodes import Episodes
from robotics.plugins.reinforcement.observed import Entry
from robotics.plugins.reinforcement.packages import gymnasium
from robotics.plugins.reinforcement.reward import END, RewardColumns
from robotics.plugins.reinforcement.task import RewardKind, Task, TaskError, checked_seed
from robotics.simulation.scenario.description import Scenario
from robotics.world.vehicle.plant import Level

Autoreset = Literal["next-step", "same-step", "disabled"]
_MODES = {name: gymnasium.vector.AutoresetMode[name.replace("-", "_").upper()] for name in get_args(Autoreset)}


def spaces(entries: Sequence[Entry], limits: np.ndarray) -> tuple[Any, Any]:
    """The Box of an observation of these ``entries``, and that of an action within ``limits`` (2,)."""
    high = np.array([entry.high for entry in entries])
    low = np.array([0.0 if entry.positive else -entry.high for entry in entries])
    return gymnasium.spaces.Box(low, high, dtype=np.float64), gymnasium.spaces.Box(-limits, limits, dtype=np.float64)


class TrackingVectorEnv(gymnasium.vector.VectorEnv):
    """Robots that track their references, each in a lane of its own with its own clock, scenario and seed; a vector
    environment of Gymnasium.

    Observations (lanes, entries) and actions (lanes, 2) are float64; ``task.entries`` names the entries with units and
    limits.

    Args:
        num_envs: How many lanes.
        scenario: A scenario of one robot, its name or its file, or several; by default those of ``arena``.
        arena: The arena whose scenarios are drawn; by default the packaged one.
        draws: How many of these are drawn.
        first: The number of the first draw.
        level: Whether actions are velocities or wheel torques.
        units: Whether they are in m/s and rad/s, or N m; else between -1 and 1.
        most: The command of an action 1; by default the robot's own limits.
        reward: "dense" or "cost", as docs/howto/environments.md tells.
        approach: What a sample before those that the arena's cost counts, counts in the dense reward.
        divergence: The distance from the reference [m] at which an episode ends; by default that of the scenario.
        autoreset: When a lane whose episode has ended begins the next one.
        threads: How many threads share the lanes out; by default as many as there are cores.
        render_mode: None: there is nothing to see; record an episode as a run instead.

    Raises:
        TaskError: Scenarios and options that do not suit.
    """

    metadata: dict[str, Any] = {"render_modes": [], "autoreset_mode": _MODES["next-step"]}  # noqa: RUF012

    def __init__(
        self,
        num_envs: int = 1,
        scenario: Scenarios | None = None,
        *,
        arena: str | Path | None = None,
        draws: int = 16,
        first: int = LEARNING,
        level: Level = "velocity",
        units: bool = False,
        most: tuple[float, float] | None = None,
        reward: RewardKind = "dense",
        approach: float = 0.0,
        divergence: float | None = None,
        autoreset: Autoreset = "next-step",
        threads: int | None = None,
        render_mode: None = None,
    ) -> None:
        """Open the lanes; :meth:`reset` begins their episodes. The arguments are those of the class."""
        if autoreset not in _MODES:
            raise TaskError(f"autoreset must be one of {', '.join(_MODES)}; got {autoreset!r}")
        self.task = Task(
            chosen_scenarios(scenario, arena, draws, first), level=level, units=units, most=most, reward=reward,
            approach=approach, divergence=divergence,
        )  # fmt: skip
        self.num_envs, self.render_mode, self.autoreset = num_envs, render_mode, autoreset
        self.metadata = {"render_modes": [], "autoreset_mode": _MODES[autoreset]}
        self.episodes = Episodes(self.task, num_envs, threads)
        self.single_observation_space, self.single_action_space = spaces(self.task.entries, self.task.action_limits)
        batch = gymnasium.vector.utils.batch_space
        self.observation_space = batch(self.single_observation_space, num_envs)
        self.action_space = batch(self.single_action_space, num_envs)
        self.choosers = [Chooser(len(self.task.scenarios)) for _ in range(num_envs)]
        self.begun = np.zeros(num_envs, dtype=bool)

    @property
    def scenarios(self) -> tuple[Scenario, ...]:
        """The scenarios of its episodes."""
        return self.task.scenarios

    def reset(
        self, *, seed: int | Sequence[int | None] | None = None, options: dict[str, Any] | None = None
    ) -> tuple[np.ndarray, dict[str, Any]]:
        """Begin an episode in every lane, or in those of ``options["reset_mask"]``.

        Args:
            seed: The seed of the first lane's run, the next lane has the next one; or one for each lane. Later
                episodes follow from it.
            options: ``reset_mask``: (lanes,) bool; ``scenario``: the place of the scenario that all of them drive.

        Returns:
            What is observed (lanes, entries), and infos with the place of the scenario and the seed of each lane.

        Raises:
            TaskError: Seeds or a mask that are not one for each lane.
        """
        options = options or {}
        mask = np.asarray(options.get("reset_mask", np.ones(self.num_envs, dtype=bool)))
        if mask.shape != (self.num_envs,) or mask.dtype != np.bool_:
            raise TaskError(f"reset_mask must be {self.num_envs} truth values; got {mask.dtype} {mask.shape}")
        for chooser, own in zip(self.choosers, _seeds(seed, self.num_envs), strict=True):
            if own is not None:
                chooser.seed(own)
        self._begin(np.flatnonzero(mask), options.get("scenario"))
        places, run = self.episodes.lanes.notes.robot.copy(), self.episodes.seeds.copy()
        return self.episodes.lanes.observed.copy(), self._told(slice(None), scenario=places, seed=run)

    def step(self, actions: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray, dict[str, Any]]:
        """Take a step in every lane, with ``actions`` (lanes, 2).

        Returns:
            What is observed (lanes, entries), rewards (lanes,), whether episodes have ended by divergence or a contact
            (lanes,), whether by time (lanes,), and infos: where some have ended, ``cost`` is the arena's cost of the
            episode and ``end`` says how, with the masks ``_cost`` and ``_end``.

        Raises:
            TaskError: Actions of another shape.
        """
        actions = checked_actions(actions, self.num_envs)
        episodes, notes = self.episodes, self.episodes.lanes.notes
        if not self.begun.all():
            raise TaskError("reset() begins the first episodes; step() comes after it")
        over = np.flatnonzero(notes.ended != END.running)
        if len(over) and self.autoreset == "disabled":
            raise TaskError(f"the episode of lane {over[0]} has ended: reset() it by options['reset_mask']")
        episodes.step(actions)
        if len(over):  # the next-step mode: their action has no effect
            self._begin(over)
        ended = notes.ended.copy()
        rewards, truncated = RewardColumns(notes.columns).reward.copy(), ended == END.time
        done = np.flatnonzero(ended != END.running)
        infos = self._ended(done, ended) if len(done) else {}
        if len(done) and self.autoreset == "same-step":
            infos = self._final(done, infos)
            self._begin(done)
        return episodes.lanes.observed.copy(), rewards, (ended != END.running) & ~truncated, truncated, infos

    def _begin(self, chosen: np.ndarray, scenario: Any = None) -> None:
        drawn = [self.choosers[lane].next() for lane in chosen.tolist()]
        places = np.array([place for place, _ in drawn], dtype=np.int64)
        if scenario is not None:
            if type(scenario) is not int or not 0 <= scenario < len(self.scenarios):
                raise TaskError(f"scenario must be a place from 0 to {len(self.scenarios) - 1}; got {scenario!r}")
            places[:] = scenario
        self.episodes.begin(chosen, places, [seed for _, seed in drawn])
        self.begun[chosen] = True

    def _ended(self, done: np.ndarray, ended: np.ndarray) -> dict[str, Any]:
        cost, end = np.zeros(self.num_envs), np.full(self.num_envs, None, dtype=object)
        cost[done], end[done] = self.episodes.costs(done), [END._fields[kind] for kind in ended[done].tolist()]
        return self._told(done, cost=cost, end=end)

    def _final(self, done: np.ndarray, infos: dict[str, Any]) -> dict[str, Any]:
        """The infos of the same-step mode: what is returned beside them is already of the next episodes."""
        last = np.full(self.num_envs, None, dtype=object)
        for lane in done.tolist():
            last[lane] = self.episodes.lanes.observed[lane].copy()
        return self._told(done, final_obs=last, final_info=infos)

    def _told(self, lanes: Any, **values: Any) -> dict[str, Any]:
        """Infos, each with the mask of the ``lanes`` of which it tells."""
        masks = np.zeros((len(values), self.num_envs), dtype=bool)
        masks[:, lanes] = True
        found: dict[str, Any] = {}
        for (name, value), mask in zip(values.items(), masks, strict=True):
            found |= {name: value, f"_{name}": mask}
        return found


def checked_actions(actions: Any, count: int) -> np.ndarray:
    """Actions as numbers (count, 2). Raises TaskError for others."""
    try:
        found = np.asarray(actions, dtype=float)
    except (TypeError, ValueError):
        raise TaskError(f"actions must be numbers ({count}, 2); got {type(actions).__name__}") from None
    if found.shape != (count, 2):
        raise TaskError(f"actions must have the shape ({count}, 2); got {found.shape}")
    return found


def _seeds(seed: int | Sequence[int | None] | None, count: int) -> list[int | None]:
    """A seed for each lane, or None."""
    if seed is None:
        return [None] * count
    several = [seed + n for n in range(count)] if isinstance(seed, (int, np.integer)) else list(seed)
    if len(several) != count:
        raise TaskError(f"one seed, or one for each of {count} lanes, is needed; got {len(several)}")
    return [None if one is None else checked_seed(one) for one in several]
