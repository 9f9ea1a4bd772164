"""What a team knows before a run, and what its robots remember in it: the numbers that perception begins with.

What they find out in a period is told by :mod:`robotics.laws.rules.perception`.
"""

import numpy as np

from fuzzy.compiled.columns import Columns, column, several
from robotics.laws.avoidance.planned_way import PlannedTiming
from robotics.laws.rules.clearances import MARKED, SECTOR, Sensors
from robotics.laws.rules.meetings import CELL, Meetings
from robotics.laws.setting import Setting
from robotics.laws.teams.neighbours import SEARCH_REACH_AFTER_OUTAGE

BACK_TO_PATH = 0.4  # m: the point of the path by whose bearing a robot comes back to its path
ONWARD = 0.3  # m: the point of the path to which a robot of a formation steers
BEST_GROWTH = 0.05  # m: a place on the path that has grown by more is progress
BESIDE, AHEAD_SEEN = 0.4, 0.7  # m: an obstacle that is nearer is seen beside, and ahead
STUCK_PATIENCE = 12.0  # s without progress: from then on the robot expects less
EXPECTATION_LOSS = 0.05  # m/s: by which it does
CORRIDOR = 0.1  # m: a standing robot nearer to the path than this beyond both circles is in the way
LOOK_ALONG_PATH = 1.2  # m of the path ahead that it may stand in the way of
LONGEST_WAY_BACK = 0.3  # m: a robot remembers no more of the ground that it has driven
SWING = 0.3  # m: a robot that turns by 1 rad forgets so much of it
ACCELERATING = 0.2  # m/s²: by which a robot's speed may have changed since it told it
STANDS = 0.03  # m/s: a robot that is slower stands
NEAR_END = 0.1  # m: a robot this near to its path's end is parked
ON_PLAN = 0.1  # m: a robot no farther behind a plan, which may have it stand, is on time
NOTICED = 1.0  # m: with less room ahead it is smoothed where there is more of it
SMOOTHING = 0.8  # s: the time constant of that
SWINGING = 0.05  # m/rad: a robot that turns sees other corners of what is near
QUICK, SLOW = 0.1, 1.0  # s: the time constants by which it is noticed that something comes nearer
FARTHEST = 2.0  # m: room beyond is no more room
TURN_TIME = 0.4  # s: a turn [rad] is made in this time, as by the tracking rule base's look-ahead
SMOOTH_TIME = 0.2  # s: the time constant of the errors that are smoothed
SIDE_TIME = 0.5  # s: the time constant with which a side is taken and forgotten
NOTHING_NEAR = 9.0  # what is told where there is nothing to tell, in the unit of the quantity
MARK_COUNT = len(MARKED)


class RecallColumns(Columns):
    """What a robot remembers from one period to the next."""

    place = column("m", "the abscissa of the path's nearest point")
    clock = column("s", "of the timetable: its copy of the group's clock")
    best = column("m", "the largest place, less the way back to the path")
    stuck = column("s", "since that grew")
    side = column("1", "from -1 to 1: the side that it keeps of an obstacle; > 0: it goes round to the left of it")
    clear = several(len(SECTOR), "m", "the clearances, which grow slowly")
    yields = column("1", "0 to 1: how much it gives way")
    way_back = column("m", "of ground behind that it has just driven")
    lost = column("s", "for which nothing was seen on the side that is kept")
    driven = column("m", "within the last second")
    fast = column("m", "the least clearance, smoothed over QUICK")
    slow = column("m", "the same, over SLOW")
    lean = column("m", "how much more room there is ahead on the left than on the right, smoothed")
    x_err = column("m", "smoothed over SMOOTH_TIME; not-a-number: there was no period before")
    y_err = column("m", "likewise")
    heading_err = column("rad", "likewise")
    v_command = column("m/s", "the last")
    w_command = column("rad/s", "the last")
    mark_x = several(MARK_COUNT, "m", "in the world's axes: where the nearest thing in each of MARKED was seen")
    mark_y = several(MARK_COUNT, "m")
    mark_age = several(MARK_COUNT, "s", "since then; infinite: nothing is remembered")


class TeamColumns(Columns):
    """What a team knows before the start of a run: numbers, and where each list begins in the row behind them."""

    cells = column("", "of the paths")
    sensors = column("", "range sensors that some robot carries")
    end = column("s", "the last reference arrives")
    planned = column("", "1: the references are a plan's")
    stays = column("", "1: it lacks one, and the robots stay where they are")
    radii = column("", "(robots,) m: of the circles in which they turn")
    begin = column("", "(robots,) m: the abscissae at which the references begin")
    first = column("", "(robots, robots): 1: the row's robot goes first, as far as the paths' ends demand it")
    last = column("", "(robots, robots, cells): as robotics.laws.rules.meetings.Meetings")
    peaks = column("", "(robots, robots, blocks, 2): likewise")
    points = column("", "(robots, cells, 2): likewise")
    reached = column("", "(robots, cells) s: when a plan has each robot at the cells")
    sights = column("", "(robots, sensors, SightColumns)")


class SightColumns(Columns):
    """A range sensor: robotics.laws.rules.clearances.Sensors tells of each what it is."""

    sector = several(len(SECTOR))
    x = column("m")
    y = column("m")
    axis = column("rad")
    half_cone = column("rad")
    inner = column("m")
    minimum = column("m")


def turning_circles(setting: Setting) -> np.ndarray:
    """The radii of the circles in which the robots turn (robots,) [m]."""
    return np.array([robot.turning_circle for robot in setting.robots])


def team_rows(setting: Setting, margin: float, sensors: tuple[str, ...], *, meet: bool = True) -> np.ndarray:
    """What a team knows before the start (rows, numbers): a row for each run, or one where they are alike.

    Args:
        setting: Whose references are a plan's, if there is one.
        margin: Between the circles of robots that do not meet [m].
        sensors: The names of those that they look with, in the order of ``setting``; none: they do not look.
        meet: Whether to look where the paths meet, which takes a while.
    """
    references, robots, radii = setting.references, len(setting.robots), turning_circles(setting)
    plan = references if isinstance(references, PlannedTiming) else None
    sights = np.zeros((robots, len(sensors), SightColumns.size))
    if sensors:
        every = Sensors.of(setting.robots, setting.sensors)
        sights[:, :, : len(SECTOR)] = np.moveaxis(every.sector, 0, -1)
        sights[:, :, len(SECTOR) :] = np.stack(every[2:], axis=-1)
    begin = references.at(-references.road.since).s
    lists: dict[str, np.ndarray] = {"radii": radii[None], "begin": begin.reshape(-1, robots)}
    cells = 0
    if robots > 1 and meet:
        meetings = Meetings.of(references.joined, robots, radii, margin)
        cells = meetings.last.shape[-1]
        lists |= meetings._asdict() | ({} if plan is None else {"reached": plan.reached(CELL, cells)})
    lists["sights"] = sights[None]
    ends = np.reshape(references.ends.max(axis=-1, keepdims=True), -1)
    found = np.array([True]) if plan is None else np.reshape(plan.found, -1)
    rows = max(len(ends), len(found), *map(len, lists.values()))
    at = TeamColumns.size + np.cumsum([0, *(part[0].size for part in lists.values())])
    numbers = dict.fromkeys(TeamColumns.columns, 0.0) | dict(zip(lists, at[:-1].tolist(), strict=True))
    numbers |= {"cells": cells, "sensors": len(sensors), "planned": float(plan is not None)}
    table = np.empty((rows, at[-1]))
    table[:, : TeamColumns.size] = TeamColumns.stacked(numbers)
    heads = TeamColumns(table.T)
    heads.end, heads.stays = ends, ~found
    for (_, part), first, last in zip(lists.items(), at, at[1:], strict=False):
        table[:, first:last] = part.reshape(len(part), -1)
    return table


def recall_at_start(setting: Setting, runs: int, reach: float | np.ndarray = SEARCH_REACH_AFTER_OUTAGE) -> np.ndarray:
    """What robots remember before the first period, RecallColumns (rows, runs, robots): only where they are.

    They look for that along their paths within ``reach`` [m], a number or (runs, robots), of where they should begin.
    """
    memory = RecallColumns.zeros(runs, len(setting.robots))
    memory.place = memory.best = setting.starting_places(runs, setting.references.at(0.0).s, reach)
    memory.fast = memory.slow = FARTHEST
    memory.x_err = memory.y_err = memory.heading_err = np.nan
    memory.clear[...] = memory.mark_age[...] = np.inf
    return np.asarray(memory.array)
