"""What an environment is about: its scenarios, what is observed and commanded, and the reward.

A step is a control period: the command of a sample, the reward of that sample, and what is observed in the next one.
An episode has as many steps as a run of its scenario has samples.
"""

from dataclasses import dataclass, replace
from functools import cached_property
from math import isfinite
from typing import Any, Literal, get_args

import numpy as np

from fuzzy.errors import InputError
from fuzzy.naming import check_known
from robotics.plugins.reinforcement.observed import Entry, command_limits, entries
from robotics.simulation.scenario.description import Scenario
from robotics.world.environment.world import World, compile_worlds
from robotics.world.vehicle.plant import Level

RewardKind = Literal["dense", "cost"]
SHARED = (
    "period",
    "latency",
    "plant",
    "sensing",
    "divergence",
    "patches",
)  # what scenarios of one environment have in common


class TaskError(InputError):
    """An environment that cannot be, or an action that it cannot take. The message says what is accepted."""


def check_reward(level: str, reward: str, approach: float) -> None:
    """Raise TaskError for a level of commands, a reward or what a sample of the approach counts that cannot be."""
    for name, value, choices in (("level", level, get_args(Level)), ("reward", reward, get_args(RewardKind))):
        check_known(value, choices, name, TaskError)
    if not (isfinite(approach) and approach >= 0):
        raise TaskError(f"approach must be a number >= 0; got {approach!r}")


def checked_action(action: Any, who: str = "") -> np.ndarray:
    """An action as two numbers (2,); ``who`` takes it, for the message. Raises TaskError for another."""
    try:
        found = np.asarray(action, dtype=float)
    except (TypeError, ValueError):
        found = np.empty(0)
    if found.shape != (2,):
        raise TaskError(f"{who}an action must be two numbers; got {action!r}")
    return found


def checked_seed(seed: Any) -> int:
    """A seed. Raises TaskError for what is no whole number >= 0."""
    if isinstance(seed, bool) or not isinstance(seed, (int, np.integer)) or seed < 0:
        raise TaskError(f"a seed is a whole number >= 0, got {seed!r}")
    return int(seed)


@dataclass(frozen=True, eq=False)
class Task:
    """Scenarios of one robot each, and what is observed, commanded and rewarded. Raises TaskError."""

    scenarios: tuple[Scenario, ...]
    level: Level = "velocity"
    units: bool = False  # whether actions are in m/s and rad/s, or N m; else between -1 and 1
    most: tuple[float, float] | None = None  # the command of an action 1; None: the robot's own limits
    reward: RewardKind = "dense"
    approach: float = 0.0  # what a sample before those of the arena's cost counts, in those
    divergence: float | None = None  # m: an episode ends so far from the reference; None: that of the scenario

    def __post_init__(self) -> None:
        if not self.scenarios:
            raise TaskError("an environment needs at least one scenario")
        check_reward(self.level, self.reward, self.approach)
        if self.divergence is not None:
            if not (isfinite(self.divergence) and self.divergence > 0):
                raise TaskError(f"divergence must be a number > 0 [m]; got {self.divergence!r}")
            nearer = tuple(replace(s, divergence=float(self.divergence)) for s in self.scenarios)
            object.__setattr__(self, "scenarios", nearer)
        if self.most is not None and not (len(self.most) == 2 and all(isfinite(m) and m > 0 for m in self.most)):
            raise TaskError(f"most must be two numbers > 0, the command of an action 1; got {self.most!r}")
        first = self.scenarios[0]
        for scenario in self.scenarios:
            self._check(scenario, first)

    def _check(self, scenario: Scenario, first: Scenario) -> None:
        """Raise TaskError for a scenario that does not suit an environment of one robot, or the others."""
        name, setting = scenario.name, scenario.setting
        if scenario.kind != "tracking" or len(setting.robots) != 1:
            what = f"{len(setting.robots)} robots" if scenario.kind == "tracking" else f"a {scenario.kind}"
            raise TaskError(
                f"the scenario {name!r} has {what}; an environment of one robot needs a tracking scenario with one. "
                "A team's is robotics.TeamEnv"
            )
        if setting.faults:
            raise TaskError(f"the scenario {name!r} has faults; those of one robot are in no environment")
        if self.level == "torque" and setting.plant == "kinematic":
            raise TaskError(f"the scenario {name!r} has a kinematic plant, which takes no torques")
        if any(obstacle.path is not None for obstacle in scenario.obstacles):
            raise TaskError(f"the scenario {name!r} has obstacles that move; only those that stand are taken")
        unlike = f"{first.name!r} and {name!r} differ"
        for field in SHARED:
            if getattr(scenario, field) != getattr(first, field):
                raise TaskError(f"all scenarios of an environment have the same {field}; {unlike}")
        if scenario.setting.sensing != first.setting.sensing or self._carried(scenario) != self._carried(first):
            raise TaskError(f"the robots of all scenarios of an environment sense alike; {unlike}")

    def _carried(self, scenario: Scenario) -> dict[str, Any]:
        return dict(scenario.setting.sensors[0]) if any(s.obstacles for s in self.scenarios) else {}

    @property
    def sensors(self) -> tuple[str, ...]:
        """The names of the range sensors that are observed: those that the robot carries, where there are obstacles."""
        return tuple(self._carried(self.scenarios[0]))

    @cached_property
    def entries(self) -> tuple[Entry, ...]:
        """The entries of an observation; where robots differ, the limits are the widest."""
        found = [entries(s.setting, self.level, self.sensors) for s in self.scenarios]
        return tuple(max(row, key=lambda entry: entry.high) for row in zip(*found, strict=True))

    @cached_property
    def most_of(self) -> np.ndarray:
        """The commands of the action 1 (2, scenarios): m/s and rad/s, or N m."""
        own = [self.most or command_limits(s.setting.robots[0], self.level) for s in self.scenarios]
        return np.array(own, dtype=float).T.copy()

    @cached_property
    def action_limits(self) -> np.ndarray:
        """The limits of an action (2,): 1, or in units the widest of all robots'."""
        return self.most_of.max(axis=1) if self.units else np.ones(2)

    @cached_property
    def obstacles(self) -> Any:
        """The obstacles of all scenarios, or None where there are none."""
        if not any(s.obstacles for s in self.scenarios):
            return None
        return compile_worlds([World(obstacles=s.obstacles, known=False) for s in self.scenarios])
