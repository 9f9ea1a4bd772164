"""A team as an environment of PettingZoo: every robot is an agent, and hears of the others what the radio brings."""

from pathlib import Path
from typing import Any

import numpy as np

from fuzzy.extras import install_command
from robotics.laws.law import Command
from robotics.plugins.reinforcement.choosing import Chooser
from robotics.plugins.reinforcement.episodes import BROADCAST, Agents
from robotics.plugins.reinforcement.observed import FIXED_ENTRIES, command_limits, heard_of, highs_of, team_entries
from robotics.plugins.reinforcement.reward import END, RewardColumns, costs, pay, reward_observer, settle
from robotics.plugins.reinforcement.stepping import EpisodeLanes, observe_lanes
from robotics.plugins.reinforcement.task import RewardKind, TaskError, check_reward, checked_action, checked_seed
from robotics.plugins.reinforcement.vector import spaces
from robotics.simulation.loop import Simulation
from robotics.simulation.observer import moment_of
from robotics.simulation.scenario.description import Scenario
from robotics.simulation.scenario.reading import load_scenario
from robotics.world.vehicle.plant import Level

try:
    from pettingzoo import ParallelEnv
except ModuleNotFoundError:
    raise TaskError(f"environments of teams need pettingzoo: {install_command('gym')}") from None


class TeamEnv(ParallelEnv):
    """The robots of a scenario, each an agent: ``robot_1``, ``robot_2`` and so on; an environment of PettingZoo.

    Observations (entries,) and actions (2,) are float64; ``entries[agent]`` names the entries with units and limits. A
    robot that has diverged or touched something is stopped where it is, and is an agent no more.

    Args:
        scenario: A scenario of two robots or more, its name or its file.
        level: Whether actions are velocities or wheel torques.
        units: Whether they are in m/s and rad/s, or N m; else between -1 and 1.
        reward: "dense" or "cost", as docs/howto/environments.md tells.
        approach: What a sample before those that the arena's cost counts, counts in the dense reward.

    Raises:
        TaskError: A scenario or options that do not suit.
    """

    metadata: dict[str, Any] = {"name": "fuzzyfleet_team_v0", "render_modes": [], "is_parallelizable": True}  # noqa: RUF012

    def __init__(
        self,
        scenario: str | Path | Scenario = "three-cross",
        *,
        level: Level = "velocity",
        units: bool = False,
        reward: RewardKind = "dense",
        approach: float = 0.0,
    ) -> None:
        """Open it; the arguments are as of :class:`robotics.plugins.reinforcement.vector.TrackingVectorEnv`."""
        self.scenario = scenario if isinstance(scenario, Scenario) else load_scenario(scenario)
        setting = self.scenario.setting
        if len(setting.robots) < 2:
            raise TaskError(
                f"the scenario {self.scenario.name!r} has one robot; that is robotics.TrackingEnv, not a team"
            )
        check_reward(level, reward, approach)
        if level == "torque" and setting.plant == "kinematic":
            raise TaskError(f"the scenario {self.scenario.name!r} has a kinematic plant, which takes no torques")
        self.level, self.reward, self.approach = level, reward, float(approach)
        self.law = Agents(level, any(setting.sensors) and setting.world is not None)
        self.most = np.array([command_limits(robot, level) for robot in setting.robots]).T
        self.possible_agents = [f"robot_{n}" for n in range(1, len(setting.robots) + 1)]
        self.agents: list[str] = []
        found = [team_entries(setting, level, n, self.law.looks) for n in range(len(setting.robots))]
        self.entries = dict(zip(self.possible_agents, found, strict=True))
        self.action_most = self.most if units else np.ones_like(self.most)
        self.factor = np.ones_like(self.most) if units else self.most
        self.observation_spaces, self.action_spaces = {}, {}
        for n, agent in enumerate(self.possible_agents):
            self.observation_spaces[agent], self.action_spaces[agent] = spaces(found[n], self.action_most[:, n])
        self.chooser, self.render_mode = Chooser(1), None
        self.simulation: Simulation | None = None

    def observation_space(self, agent: str) -> Any:
        """The Box of what ``agent`` observes."""
        return self.observation_spaces[agent]

    def action_space(self, agent: str) -> Any:
        """The Box of the action of ``agent``."""
        return self.action_spaces[agent]

    def reset(
        self, seed: int | None = None, options: dict[str, Any] | None = None
    ) -> tuple[dict[str, np.ndarray], dict[str, dict[str, Any]]]:
        """Begin an episode.

        Args:
            seed: That of its run, a whole number >= 0; the later ones follow from it.
            options: There are none.

        Returns:
            What each agent observes (entries,), and infos, by the names of the agents.

        Raises:
            TaskError: A seed that is none.
        """
        if seed is not None:
            self.chooser.seed(checked_seed(seed))
        self.seed = self.chooser.next()[1]
        self.k, self.simulation = 0, Simulation(self.scenario.setting, self.law, (self.seed,))
        self.notes = reward_observer(self.scenario, level=self.level, reward=self.reward, approach=self.approach).notes
        self.columns = self._columns(self.simulation)
        self.agents = list(self.possible_agents)
        settle(moment_of(self.simulation.lanes, 0), self.notes)
        self._perceive()
        return self._observed(self.agents), {agent: {"seed": self.seed} for agent in self.agents}

    def step(
        self, actions: dict[str, Any]
    ) -> tuple[dict[str, np.ndarray], dict[str, float], dict[str, bool], dict[str, bool], dict[str, dict[str, Any]]]:
        """Take a step with an action of every agent.

        Args:
            actions: The action (2,) of each agent, by its name.

        Returns:
            By the names of those that were agents before it: what they observe (entries,), rewards, whether their
            episodes have ended by divergence or a contact, whether by time, and infos.

        Raises:
            TaskError: An agent without an action, and an action of another shape.
        """
        one, before = self.simulation, list(self.agents)
        if one is None or not before:
            raise TaskError("no episode goes on: reset() begins one")
        wanted = self._wanted(actions)
        lanes, mine, setting = one.lanes, self.notes.episodes, self.scenario.setting
        seen = lanes.known.seen[:, None]
        speeds = wanted if self.level == "velocity" else lanes.body.truth[3:5]
        message = dict(zip(BROADCAST, seen[:5], strict=True))
        one.told(Command(wanted[:1], wanted[1:], speeds[:1], speeds[1:], message))
        one.obey()
        one.keep(self.k)
        pay(0, len(self.possible_agents), moment_of(one.lanes, self.k), mine)
        one.lanes.lost[:] |= (mine.ended != END.running) & (mine.ended != END.time) & (one.lanes.stopped < 0)
        if self.k < setting.ticks:
            one.say(self.k)
            one.move(self.k)
            self.k += 1
            settle(moment_of(one.lanes, self.k), self.notes)
            self._perceive()
        places = [self.possible_agents.index(agent) for agent in before]
        ended = [int(mine.ended[n]) for n in places]
        costed = np.empty(len(places))
        costs(mine, np.array(places), costed)
        terminated = {a: end not in (END.running, END.time) for a, end in zip(before, ended, strict=True)}
        truncated = {a: end == END.time for a, end in zip(before, ended, strict=True)}
        paid = RewardColumns(mine.columns).reward
        rewards = {a: float(paid[n]) for a, n in zip(before, places, strict=True)}
        infos: dict[str, dict[str, Any]] = {
            a: {"cost": float(cost), "end": END._fields[end]} if end != END.running else {}
            for a, end, cost in zip(before, ended, costed, strict=True)
        }
        self.agents = [a for a, end in zip(before, ended, strict=True) if end == END.running]
        return self._observed(before), rewards, terminated, truncated, infos

    def render(self) -> None:
        """There is nothing to see."""

    def _wanted(self, actions: dict[str, Any]) -> np.ndarray:
        """The commands (2, robots); those of robots that are no agents are 0."""
        wanted = np.zeros_like(self.most)
        if not isinstance(actions, dict):
            raise TaskError(f"actions must be a dict, an action by agent; got {type(actions).__name__}")
        for agent in self.agents:
            if agent not in actions:
                raise TaskError(f"every agent needs an action; {agent} has none")
            action = checked_action(actions[agent], f"{agent}: ")
            n, high = self.possible_agents.index(agent), self.action_spaces[agent].high
            wanted[:, n] = np.clip(action, -high, high) * self.factor[:, n]
        return wanted

    def _perceive(self) -> None:
        one = self.simulation
        assert one is not None
        one.sense(self.k)
        one.look(self.k)
        one.hear(self.k)

    def _columns(self, one: Simulation) -> EpisodeLanes:
        """The columns of an episode, a lane for each robot; they look at the arrays of the simulation."""
        lanes, setting, robots = one.lanes, self.scenario.setting, len(self.possible_agents)
        highs = [highs_of(found)[:FIXED_ENTRIES] for found in self.entries.values()]
        return EpisodeLanes(
            moment_of(lanes, 0),
            self.notes.episodes,
            lanes.body,
            lanes.senses,
            setting.references.road,
            np.ones((2, robots)),
            np.stack(highs, axis=1),
            np.empty((0, robots)),
            np.zeros((robots, FIXED_ENTRIES)),
        )

    def _observed(self, agents: list[str]) -> dict[str, np.ndarray]:
        one, setting = self.simulation, self.scenario.setting
        assert one is not None
        observe_lanes(self.columns, np.arange(len(self.possible_agents)))
        found = {}
        for agent in agents:
            n = self.possible_agents.index(agent)
            parts = [self.columns.observed[n]]
            if one.ranges is not None:
                names = list(one.ranges.names)
                carried = [names.index(name) for name in setting.sensors[n]]
                parts.append(one.ranges.values[0, n, carried])
            parts.append(heard_of(n, one.lanes.known.seen, one.lanes.air.heard))
            box = self.observation_spaces[agent]
            found[agent] = np.clip(np.concatenate(parts), box.low, box.high)
        return found
