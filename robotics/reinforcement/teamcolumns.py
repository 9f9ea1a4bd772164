"""What the agents of a team observe of each other, and the columns by which they are rewarded."""

from math import pi

import numpy as np

from fuzzy.compiled.columns import within
from robotics.laws.equation import HeardColumns, RobotColumns
from robotics.laws.setting import Setting
from robotics.laws.tracking.observed import FIXED_ENTRIES, Entry, entries, highs_of
from robotics.measures.tracking import moves_on
from robotics.paths.posture import wrapped
from robotics.reinforcement.stepping import REWARD, EpisodeLanes, SumColumns
from robotics.reinforcement.task import FAILED_COST, SCALES, RewardKind
from robotics.scenario.description import Scenario
from robotics.simulation.loop import Simulation
from robotics.vehicle.plant import Level, velocity_limits

BROADCAST = RobotColumns.leaves()  # what every robot broadcasts
OLDEST = 5.0  # s: a message is told to be no older; also before the first


class TeamHeard(HeardColumns):
    """What one robot has heard of another."""

    said = within(RobotColumns)


def team_entries(setting: Setting, level: Level, robot: int, sees: bool) -> tuple[Entry, ...]:
    """The entries of what one robot of a team observes: those of a robot alone, then five of each other robot.

    Args:
        setting: The team's.
        level: What is commanded.
        robot: Its place.
        sees: Whether it reads its range sensors.
    """
    found = list(entries(setting, level, tuple(setting.sensors[robot]) if sees else (), robot))
    on = setting.references
    ends = [on.at(float(t)) for t in np.linspace(0.0, setting.ticks * setting.period, 50)]
    far = 2 * setting.divergence + max(float(np.hypot(np.ptp(at.x), np.ptp(at.y))) for at in ends)
    fastest = max(one.v_max for one in setting.robots)
    for n in range(len(setting.robots)):
        if n != robot:
            who = f"robot{n + 1}"
            found += [
                Entry(f"{who}_ahead", "m", far, f"{who} was so far ahead when it sent the last message that was heard"),
                Entry(f"{who}_left", "m", far, f"{who} was then so far to the left"),
                Entry(f"{who}_heading", "rad", pi, f"{who} was then turned so far to the left of this robot"),
                Entry(f"{who}_v", "m/s", 2 * fastest, f"{who} then had this speed"),
                Entry(f"{who}_age", "s", OLDEST, "so long ago; this much and more: nothing was heard", positive=True),
            ]
    return tuple(found)


def heard_of(robot: int, seen: np.ndarray, heard: np.ndarray) -> np.ndarray:
    """What one robot has heard of the others (5 a robot,), in its own frame; 0 before the first message.

    Args:
        robot: Its place.
        seen: What the robots measure (SeenColumns, robots).
        heard: What they have heard (HeardColumns and values, receivers, senders).
    """
    others = np.arange(heard.shape[2]) != robot
    theirs, own = TeamHeard(heard[:, robot][:, others]), RobotColumns(seen, robot)
    said, age = theirs.said, np.minimum(theirs.age, OLDEST)
    dx, dy = said.x - own.x, said.y - own.y
    cos, sin = np.cos(own.heading), np.sin(own.heading)
    rows = np.stack([cos * dx + sin * dy, cos * dy - sin * dx, wrapped(said.heading - own.heading), said.v, age])
    return np.nan_to_num(rows).T.ravel()


def columns(scenario: Scenario, one: Simulation, level: Level, reward: RewardKind, approach: float) -> EpisodeLanes:
    """The columns of a team's episode, a lane for each robot; they look at the arrays of the simulation."""
    setting, lanes = scenario.setting, one.lanes
    robots, body = len(setting.robots), lanes.body
    on = scenario.trajectory.sampled(scenario.times)
    counted = np.argmax(moves_on(on.v.T, scenario.times), axis=1)
    ends = np.full(robots, setting.ticks)
    highs = np.stack([highs_of(entries(setting, level, (), n)) for n in range(robots)], axis=1)
    none = np.zeros(robots, dtype=np.int64)
    return EpisodeLanes(
        float(setting.period), float(setting.divergence), body.steps, body.code, body.late_periods, body.late_steps,
        getattr(REWARD, reward), approach, float(FAILED_COST), np.array(SCALES), np.ones((2, robots)),
        np.ascontiguousarray(velocity_limits(setting.robots)), highs,
        np.stack([ends, counted, ends + 1 - counted]).astype(np.int64),
        setting.references.road, lanes.senses, body.parameters, body.truth, body.pending, lanes.known.seen,
        np.empty((0, robots)), np.arange(robots), none.copy(), none,
        np.zeros(robots, dtype=bool), np.zeros((2, robots)), np.full(robots, np.nan),
        np.zeros((SumColumns.size, robots)),
        np.zeros(robots), np.zeros((robots, FIXED_ENTRIES)),
    )  # fmt: skip
