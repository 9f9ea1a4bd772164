"""What the agents of a team observe of each other."""

from math import pi

import numpy as np

from fuzzy.compiled.columns import within
from robotics.laws.equation import HeardColumns, RobotColumns
from robotics.laws.setting import Setting
from robotics.plugins.reinforcement.observed import Entry, entries
from robotics.world.paths.posture import wrapped
from robotics.world.vehicle.plant import Level

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
