"""Training data from drives: what a robot knew at each moment, and what it was commanded then.

The drive is shown, moment after moment, to what computes the quantities of
:mod:`robotics.laws.rules.quantities` while robots drive, so that a rule base that learns from the table drives by the
very numbers that it has learnt by. What the robot was to follow is

* the moving target of the log, where it has one: all quantities of target, path and timetable are known;
* or a path without times: only what does not depend on a timetable is known;
* or the way that it drove itself: the target is then where it was a little later.

Odometry, commands and references come at rates of their own, and jitter. At each time of a grid

* the posture and the velocities are interpolated between the samples before and after it, the heading without its
  jumps of 2π;
* the command is the last one given, which holds until the next;
* the reference is interpolated like the posture.

Where the two samples around a time are farther apart than a limit, or the last command is older than it, nothing is
known: the drive is cut there, and goes on as another piece. It is cut, too, where the robot gets another path.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np

from fuzzy.errors import InputError
from fuzzy.quantity import check_quantities, described, quantity
from robotics.laws.law import Observation
from robotics.laws.rules.of_reference import later
from robotics.laws.rules.quantities import QUANTITY_GROUPS, Quantity, quantity_of
from robotics.laws.rules.situation import recall_at_start
from robotics.laws.setting import Setting
from robotics.laws.tracking.fuzzy_tracking import FuzzyTracking
from robotics.plugins.learning.datatable import COMMAND_OUTPUTS, TIMED_COLUMNS, DataColumn, DataTable
from robotics.plugins.learning.onlooker import Onlooker, OnlookerColumns, asking_for
from robotics.plugins.logs.drive import Drive, PlannedPath, Track
from robotics.plugins.logs.typestore import LogError
from robotics.simulation.scenario.robots import load_robot
from robotics.world.paths.joined import PathTable, join_paths
from robotics.world.paths.path import Line, PathError, Waypoints, compile_path
from robotics.world.paths.references import Reference, References
from robotics.world.paths.road import TIMED, road_of
from robotics.world.radio.channel import Heard
from robotics.world.radio.description import Radio
from robotics.world.sensing.posture import Sensing

DRIVE_OUTPUTS = tuple(COMMAND_OUTPUTS)
UNTIMED = ("cross_track", "path_bearing", "curvature")
DRIVEN = ("x_err", "y_err")  # more would be learnt by heart: of a way that was driven the rest follows from these
_APART, DRIVEN_APART = 0.02, 0.1  # m: between the points of a path made of a reference, of a way that was driven
NEAR_PLAN = 0.1  # m: a target that stays so near to the path of the log moves along that path
_AT_ONCE = 1e-6  # s: stamps are whole nanoseconds, and times of the grid are not
_LEAST = 2  # samples of a piece
_BLOCK = 5.0  # s: rows of the same block go to the same table
CHECKED = 4  # of so many blocks one is for checking
_BY_TIME = frozenset({*QUANTITY_GROUPS["The target"], "lag", "late", "stuck"})
_BY_PATH = frozenset({*QUANTITY_GROUPS["The path and the timetable"], "onward_bearing", "path_away"}) - {
    "late",
    "gives_way",
}


# Drives on one grid of times ----------------------------------------------------------------------------------------


@dataclass(frozen=True, eq=False)
class DrivePiece:
    """A part of a drive without gaps, at times that are equally far apart; arrays are (samples,)."""

    start: float  # s: of the drive, by the clock of its odometry
    time: np.ndarray  # s since then
    x: np.ndarray  # m
    y: np.ndarray  # m
    heading: np.ndarray  # rad, not wrapped
    v: np.ndarray  # m/s
    w: np.ndarray  # rad/s
    v_commanded: np.ndarray  # m/s
    w_commanded: np.ndarray  # rad/s
    plan: PlannedPath | None  # the path that the robot had


def pieces(
    drive: Drive, period: float = 0.05, gap: float = 0.5, delay: float = 0.0, *, whole: bool = False
) -> tuple[DrivePiece, ...]:
    """The parts of ``drive`` without gaps, on a grid of times.

    Args:
        drive: The drive.
        period: From time to time [s].
        gap: The longest time [s] without odometry, without a command, or without a reference.
        delay: From a posture to the command that answers it [s].
        whole: Whether the beginning and the end stay, where nothing is commanded.

    Raises LogError where nothing is left.
    """
    for name, value, least in (("period", period, 1e-3), ("gap", gap, period), ("delay", delay, 0.0)):
        if not least <= value <= 60.0:
            raise LogError(f"{name} must be a number of seconds from {least:g} to 60, got {value:g}")
    seen, given = _moving(drive.odometry), drive.commands
    start = max(seen.time[0], given.time[0] - delay)
    count = int(np.floor((min(seen.time[-1], given.time[-1] + gap - delay) - start) / period + _AT_ONCE)) + 1
    if count < _LEAST:
        raise LogError(
            f"{drive.log}: {drive.topics['odometry']} (from {seen.time[0]:.3f} to {seen.time[-1]:.3f} s) and "
            f"{drive.topics['commands']} (from {given.time[0]:.3f} to {given.time[-1]:.3f} s) do not overlap"
        )
    grid = start + period * np.arange(count)
    place = np.searchsorted(given.time, grid + delay + _AT_ONCE, side="right") - 1
    known = _known(seen.time, grid, gap) & (place >= 0) & (grid + delay - given.time[np.maximum(place, 0)] <= gap)
    if drive.reference is not None:
        known &= _known(drive.reference.time, grid, gap)
    v, w = given.v[np.maximum(place, 0)], given.w[np.maximum(place, 0)]
    if not whole:
        driven = np.flatnonzero(known & ((v != 0) | (w != 0)))
        if not len(driven):
            raise LogError(f"{drive.log}: {drive.topics['commands']} commands nothing but to stand still")
        known[: driven[0]] = known[driven[-1] + 1 :] = False
    plan = np.searchsorted(np.array([plan.time for plan in drive.plans[1:]]), grid, side="right")
    cuts = np.flatnonzero((np.diff(known.astype(int)) != 0) | (np.diff(plan) != 0)) + 1
    found = []
    for part in np.split(np.arange(count), cuts):
        if known[part[0]] and len(part) >= _LEAST:
            at = grid[part]
            x, y, heading, speed, turn = (np.interp(at, seen.time, values) for values in seen[1:])
            path = drive.plans[int(plan[part[0]])] if drive.plans else None
            found.append(DrivePiece(start, at - start, x, y, heading, speed, turn, v[part], w[part], path))
    if not found:
        raise LogError(
            f"{drive.log}: no {_LEAST} moments in a row are known: its messages are farther apart than {gap:g} s"
        )
    return tuple(found)


def _known(time: np.ndarray, grid: np.ndarray, gap: float) -> np.ndarray:
    """Whether the samples at ``time`` before and after each time of the ``grid`` are no farther apart than ``gap``."""
    after = np.searchsorted(time, grid - _AT_ONCE, side="left")
    before = np.searchsorted(time, grid + _AT_ONCE, side="right") - 1
    inside = (before >= 0) & (after < len(time))
    before, after = np.maximum(before, 0), np.minimum(after, len(time) - 1)
    return inside & (time[after] - time[before] <= gap)


def _moving(track: Track) -> Track:
    """The track with its velocities; those of its postures where it does not tell them.

    Raises LogError for a track of one sample.
    """
    if len(track.time) < _LEAST:
        raise LogError("the odometry has fewer than two messages")
    if np.isfinite(track.v).all() and np.isfinite(track.w).all():
        return track
    ahead = np.gradient(track.x, track.time) * np.cos(track.heading)
    ahead += np.gradient(track.y, track.time) * np.sin(track.heading)
    return track._replace(v=ahead, w=np.gradient(track.heading, track.time))


# The table ----------------------------------------------------------------------------------------------------------


class DriveDataError(InputError):
    """A drive of which no such table can be made. The message says what is missing."""


@dataclass(frozen=True, kw_only=True)
class DriveRecipe:
    """How a table is made of drives. Raises DriveDataError for numbers out of their ranges."""

    inputs: tuple[str, ...] = described(
        "Quantities that the rule base shall know (docs/reference/quantities.md). Default: "
        "x_err,y_err,heading_err,target_v,target_w; of a path without times cross_track,path_bearing,curvature; of the "
        "way driven x_err,y_err.",
        (),
    )
    period: float = quantity(0.05, "s", above=0, doc="From row to row.")
    gap: float = quantity(
        0.5, "s", least=0, doc="A drive is cut where odometry, command or reference is missing for longer."
    )
    delay: float = quantity(0.0, "s", least=0, doc="From a posture to the command that answers it.")
    look_ahead: float = quantity(
        FuzzyTracking.look_ahead, "s", least=0, doc="How far ahead the target is, as of the law fuzzy."
    )
    driven: bool = described("Take the way that was driven for what the robot was to follow.", False)
    whole: bool = described("Keep beginning and end of a drive, where nothing is commanded.", False)

    def __post_init__(self) -> None:
        check_quantities(self, DriveDataError)


@dataclass(frozen=True, eq=False)
class DriveTable(DataTable):
    """A table of moments: inputs, then v and w as commanded."""

    block: np.ndarray  # (rows,) int: moments that follow each other are of one block, BLOCK long
    followed: str  # what the robots were to follow, in words

    @property
    def for_checking(self) -> np.ndarray:
        """Whether each row (rows,) is one of the last block of every CHECKED."""
        return self.block % CHECKED == CHECKED - 1


def drive_data(drives: Sequence[Drive], recipe: DriveRecipe, advance: Callable[[], None] | None = None) -> DriveTable:
    """The table of all moments of drives, for learning.

    Args:
        drives: The drives, such as :func:`read_drive` reads them.
        recipe: How the table is made.
        advance: Called after each drive.

    Raises:
        DriveDataError: A drive of which no such table can be made.
        LogError: A drive that lacks what the recipe needs.
    """
    if not drives:
        raise DriveDataError("at least one drive is needed")
    ways = [_followed(drive, recipe) for drive in drives]
    names = recipe.inputs or (UNTIMED if "path" in ways else DRIVEN if "driven" in ways else TIMED_COLUMNS)
    known = _quantities(names)
    parts, blocks, first = [], [], 0
    for drive, way in zip(drives, ways, strict=True):
        for name in names:
            if way == "path" and name in _BY_TIME:
                raise DriveDataError(
                    f"inputs: {name} needs to know when the robot was to be where, and {drive.log} has a path without "
                    f"times ({drive.topics.get('path', 'none')}); take {', '.join(UNTIMED)}, or the way driven"
                )
        for piece in pieces(drive, recipe.period, recipe.gap, recipe.delay, whole=recipe.whole):
            rows, kept = _rows(drive, piece, way, names, recipe)
            number = ((piece.time - piece.time[0]) / _BLOCK).astype(int)[kept] + first
            first = int(number.max(initial=first - 1)) + 1
            parts.append(rows[kept])
            blocks.append(number)
        if advance is not None:
            advance()
    values = np.round(np.concatenate(parts), 9) + 0.0  # + 0.0: no -0
    if not len(values):
        raise DriveDataError("no row is left: the drives are shorter than the look-ahead, or nothing is known of them")
    columns = [DataColumn(name, q.unit, q.meaning) for name, q in zip(names, known, strict=True)]
    columns += [DataColumn(name, *words, True) for name, words in COMMAND_OUTPUTS.items()]
    said = {"reference": "the moving target in the log", "path": "the path in the log", "driven": "the way driven"}
    followed = ", ".join(dict.fromkeys(said[way] for way in ways))
    return DriveTable(tuple(columns), values, np.concatenate(blocks), followed)


def _followed(drive: Drive, recipe: DriveRecipe) -> str:
    if recipe.driven:
        return "driven"
    return "reference" if drive.reference is not None else "path" if drive.plans else "driven"


def _quantities(names: Sequence[str]) -> tuple[Quantity, ...]:
    """The quantities of these names. Raises DriveDataError for those that a log does not tell."""
    if len(set(names)) < len(names):
        raise DriveDataError(f"inputs: each quantity once; got {', '.join(names)}")
    found = tuple(quantity_of(name, "inputs") for name in names)
    for name, each in zip(names, found, strict=True):
        if each.pair or each.radio or each.robot:
            raise DriveDataError(f"inputs: {name} is of other robots, and the table of a drive is of one alone")
        if each.ranges:
            raise DriveDataError(f"inputs: {name} needs range sensors, which are not read from logs")
    return found


class DriveOnlooker(Onlooker):
    """Looks at a robot that drove alone, and is told what it was to follow."""

    def begin(self, setting: Setting, runs: int) -> np.ndarray:
        """Nothing is remembered but where the robot is."""
        start = recall_at_start(setting, runs)
        return np.concatenate([start, np.zeros((self.remembers.size + 1 - len(start), *start.shape[1:]))])


def _rows(
    drive: Drive, piece: DrivePiece, way: str, names: Sequence[str], recipe: DriveRecipe
) -> tuple[np.ndarray, np.ndarray]:
    """The rows (samples, columns) of a piece, and which of them (samples,) are known."""
    references = _references(drive, piece, way, {*names} & _BY_PATH != set())
    setting = _setting(drive, piece, references, recipe.period)
    table = references.joined.table
    nearest = int(np.argmin(np.hypot(table[0] - piece.x[0], table[1] - piece.y[0])))
    place = nearest / (table.shape[1] - 1) * float(references.joined.lengths[0])
    if way != "path":
        place = float(references.at(float(piece.time[0])).s[0])
    onlooker, end = DriveOnlooker(base=asking_for(names), along=True), float(references.ends[0])
    memory = onlooker.init(setting, 1)
    recall = OnlookerColumns(memory.rows)
    recall.place = recall.best = place
    rows = np.empty((len(piece.time), len(names) + len(DRIVE_OUTPUTS)))
    due = references.each_at(piece.time[:, None])
    ahead = references.each_at(np.minimum(piece.time + recipe.look_ahead, end)[:, None])
    columns = (piece.x, piece.y, piece.heading, piece.v, piece.w)
    for k, time in enumerate(piece.time.tolist()):
        x, y, heading, v, w = (column[k : k + 1, None] for column in columns)
        recall = OnlookerColumns(memory.rows)
        recall.target.array[...] = [row[k] for row in ahead]
        reference = Reference(*(row[k] for row in due))
        seen = Observation(time, x, y, heading, v, w, reference, references, Heard.nothing(1, 1))
        command, memory = onlooker.control(seen, memory, recipe.period)
        assert command.inputs is not None
        rows[k, : len(names)] = command.inputs[:, 0, 0]
        recall = OnlookerColumns(memory.rows)
        recall.v_command, recall.w_command = piece.v_commanded[k], piece.w_commanded[k]
    for k, name in enumerate(names):
        if at := later(name):  # of a log's target only it knows when it is where
            moved = references.each_at((piece.time + at[1])[:, None])
            curved = np.divide(moved.w, moved.v, out=np.zeros_like(moved.w), where=moved.v != 0)
            rows[:, k] = {"target_v": moved.v, "target_w": moved.w, "target_curvature": curved}[at[0]][:, 0]
    rows[:, len(names) :] = np.stack([piece.v_commanded, piece.w_commanded], axis=-1)
    told = np.asarray(np.isfinite(rows).all(axis=1))
    if way != "path" and not references.rests and {*names} & _BY_TIME:
        told &= piece.time + recipe.look_ahead <= end + 1e-6  # what comes after the log's end is not known
    return rows, told


# What was followed ------------------------------------------------------------------------------------------------


@dataclass(frozen=True, eq=False)
class TrackReferences(References):
    """A track over time as the references of one robot; their road has its path, and not its times."""

    track: Track  # its time [s] since the drive's start
    s: np.ndarray  # (n,) m: its abscissae

    @property
    def rests(self) -> bool:
        """Whether it stands at its end, so that it is known where it is afterwards."""
        return bool(abs(self.track.v[-1]) < 1e-6 and abs(self.track.w[-1]) < 1e-6)

    def each_at(self, times: np.ndarray) -> Reference:
        """The reference at ``times`` [s]; each field has their shape."""
        return Reference(*(np.interp(times, self.track.time, column) for column in (*self.track[1:], self.s)))


def _along(joined: PathTable, track: Track, s: np.ndarray) -> TrackReferences:
    road = road_of(joined, TIMED.evenly, track.time[-1:])
    return TrackReferences(joined, track.time[-1:], road, track, s)


def _references(drive: Drive, piece: DrivePiece, way: str, by_path: bool) -> TrackReferences:
    """What the robot followed in a piece; ``by_path``: whether its path matters, and not only its moving target."""
    plan = None if piece.plan is None or way == "driven" else piece.plan.points
    if way == "path" and plan is not None:
        track = Track(piece.time, *(np.zeros_like(piece.time),) * 5)
        return _along(_path(drive, plan, _APART, True), track, np.zeros(len(piece.time)))
    track, apart = Track(piece.time, piece.x, piece.y, piece.heading, piece.v, piece.w), DRIVEN_APART
    if way == "reference" and drive.reference is not None:
        track, apart = drive.reference._replace(time=drive.reference.time - piece.start), _APART
    driven = np.concatenate([[0.0], np.cumsum(np.hypot(np.diff(track.x), np.diff(track.y)))])
    if plan is not None and by_path:
        table = _path(drive, plan, _APART, False)
        first = np.argmin(np.hypot(table.table[0] - track.x[0], table.table[1] - track.y[0]))
        around = float(table.lengths[0]) * first / (table.table.shape[1] - 1) + driven
        s = table.nearest(track.x[:, None], track.y[:, None], around[:, None], np.full((len(around), 1), NEAR_PLAN))
        point = table.at(s)
        if np.hypot(point.x[:, 0] - track.x, point.y[:, 0] - track.y).max() < NEAR_PLAN:
            return _along(table, track, s[:, 0])
    table = _path(drive, np.stack([track.x, track.y], axis=-1), apart, by_path)
    return _along(table, track, driven * (float(table.lengths[0]) / max(driven[-1], 1e-9)))


def _path(drive: Drive, points: np.ndarray, apart: float, needed: bool) -> PathTable:
    """The path through ``points`` (n, 2), of which those at least ``apart`` are taken.

    Raises DriveDataError where that is none and one is needed; else any will do.
    """
    kept = [points[0]]
    for point in points[1:]:
        if np.hypot(*(point - kept[-1])) >= apart:
            kept.append(point)
    try:
        if len(kept) < 2:
            raise PathError("it has fewer than two different points")
        return join_paths([compile_path(Waypoints(points=tuple((float(x), float(y)) for x, y in kept)))])
    except PathError as error:
        if needed:
            raise DriveDataError(f"{drive.log}: what the robot followed is no path: {error}") from None
        return join_paths([compile_path(Line(start=(0.0, 0.0), end=(1.0, 0.0)))])


def _setting(drive: Drive, piece: DrivePiece, references: TrackReferences, period: float) -> Setting:
    """The setting of a robot that follows ``references``; what it is built like does not matter here."""
    return Setting(
        name=drive.log,
        kind="tracking",
        robots=(load_robot("etsro").robot,),
        starts=np.array([[piece.x[0], piece.y[0], piece.heading[0]]]),
        references=references,
        radio=Radio(),
        sensing=(Sensing(),),
        sensors=({},),
        world=None,
        faults=(),
        ticks=len(piece.time) - 1,
        period=period,
        latency=0.0,
        plant="dynamic",
        divergence=np.inf,
    )


def drive_facts(drives: Sequence[Drive], recipe: DriveRecipe, table: DriveTable, command: str) -> dict[str, str]:
    """What there is to say of a table for its card; ``command`` is what made it."""
    robots = [f"{drive.log} ({drive.robot})" if drive.robot else drive.log for drive in drives]
    topics = [f"{what} {name}, times by {d.clocks[what]}" for d in drives for what, name in d.topics.items()]
    return {
        "what": "what a robot knew at each moment of a drive, and what it was commanded then",
        "made by": f"`{command}`",
        "logs": ", ".join(robots),
        "topics": "; ".join(dict.fromkeys(topics)),
        "followed": table.followed,
        "rows every": f"{recipe.period:g} s; cut where nothing is known for {recipe.gap:g} s; commands "
        f"{recipe.delay:g} s after the posture",
        "look-ahead": f"{recipe.look_ahead:g} s",
    }
