"""A minute of commands that tells most of a robot, and keeps it within a square.

The minute is made of manoeuvres that lead back to where they began: steps of speed and turn rate, and then the same
steps backwards in time with the opposite sign, by which the robot goes back along its way. Two slow ramps come first,
for the dead band, which has no derivative, and in 45 s and more a third of the time of gentle drives, straight, on the
spot and around one wheel, in which no tyre slips, for wheels and axle. The others are chosen from a few dozen that are
drawn, one by one: the one that raises the logarithm of the determinant of the information matrix most for each second
(D-optimality, greedy), for the mean of a few robots drawn from :data:`RANGE`, with white noise of a fiftieth of full
speed.

Other robots drawn from the same range, with wheels and axle that odometry has wrong by :data:`STEP_SIZES`, do not
come back quite: a lag and a limit leave something over. A manoeuvre, or its mirror image, is therefore only taken if
by it all of them stay inside. In the end they drive the whole minute in the model; where one leaves the square less
its margin, the manoeuvres are made smaller and chosen anew."""

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from fuzzy.shown import shown
from robotics.plugins.identify.fit import information
from robotics.plugins.identify.model import COORDINATE_NAMES, COORDINATES, Stimulus, drive, least_gyration, values_of
from robotics.plugins.identify.replay import COMMAND_PERIOD, Program
from robotics.plugins.identify.signals import IdentifyError
from robotics.world.vehicle.robot import Robot

# From which factor of the robot's value to which others are drawn; limits of rates in units of full speed a second
RANGE = {
    "lag": (0.5, 2.0),
    "rise_time": (0.6, 1.8),
    "motor_time": (0.6, 1.6),
    "gyration": (0.8, 1.25),
    "friction": (0.5, 2.0),
    "right_gain": (0.97, 1.03),
    "left_gain": (0.97, 1.03),
    "v_max": (0.7, 1.3),
    "w_max": (0.7, 1.3),
    "force_limit": (0.6, 1.6),
}
GREATEST_LATENCY = 0.3  # s: latencies are drawn from 0 to it
RATES = (1.2, 20.0)  # of full speed a second: limits of the accelerations
STEP_SIZES = (0.03, 0.06)  # by which wheels and axle may be wrong at most
SQUARE_MARGIN = 0.05  # of the square's side, on each side
_ROBOTS, _SAFE = 3, 64  # that the information is a mean of, that must stay inside
_REST = 0.3  # s between manoeuvres
_DRAWN_MANOEUVRES = 48
_MOST = 1.15  # of full speed: what is beyond it shows the limit
_SHORTEST, _LONGEST = 0.25, 1.2  # s: of a step
_LASTS = (1.0, 3.5)  # s: of a manoeuvre one way
_STILL = 0.3  # of the steps of v, and of those of ω, are 0
_COMES_TO_REST = 1.0  # s: after a manoeuvre, for the slowest robot
_TRIES = 6
_POINTS = 10  # steps of the plant between points of a track that are looked at
_GENTLE = 0.3  # m/s²: of a rim in gentle drives, less than what counts as steady driving
_GENTLE_SHARE, _GENTLE_FROM = 1 / 3, 45.0  # of the time, for three of them; s: less is needed for steps
_PRIOR = 1.0  # of the information of each coordinate, so that the determinant is there from the first manoeuvre on


class Manoeuvre(NamedTuple):
    """A part of the minute, which ends where it began."""

    name: str
    v: np.ndarray  # (n,) m/s, a period each
    w: np.ndarray  # (n,) rad/s


@dataclass(frozen=True, eq=False)
class Excitation:
    """Commands, and what they are worth.

    Attributes:
        program: The commands.
        names: The manoeuvres, in their order.
        efficiency: How much more it tells than manoeuvres at random within the same square: the determinants' ratio to
            the power of one over the number of coordinates.
        room: The least distance [m] of a robot's outline from the square's edge, of those that were drawn.
    """

    program: Program
    names: tuple[str, ...]
    efficiency: float
    room: float


def excite(robot: Robot, square: float, seconds: float, seed: int = 0) -> Excitation:
    """Choose commands for a robot.

    Args:
        robot: The robot by its data sheet.
        square: The side [m] of the square in whose middle it begins.
        seconds: How long the commands are.
        seed: Of the robots that are drawn.

    Raises:
        IdentifyError: A square that is too small, or a time that is too short.
    """
    free = square / 2 - SQUARE_MARGIN * square - robot.turning_circle
    if free < 0.1:
        least = 2 * (robot.turning_circle + 0.1) / (1 - 2 * SQUARE_MARGIN)
        raise IdentifyError(
            f"a square of {shown(square)} m leaves the robot no room: {shown(np.ceil(10 * least) / 10)} m are the least"
        )
    if not 20 <= seconds <= 600:
        raise IdentifyError(f"the commands last from 20 to 600 s; got {shown(seconds)}")
    generator = np.random.default_rng(seed)
    judges, drivers = _drawn(robot, _ROBOTS, generator), _drawn(robot, _SAFE, generator)
    sizes = 1 + np.array([STEP_SIZES] * _SAFE).T * generator.uniform(-1, 1, (2, _SAFE))
    reach = free
    for _ in range(_TRIES):
        inside = (0.9 * free, drivers, sizes)
        chosen, other = _chosen(robot, reach, seconds, judges, seed, inside)
        program = _joined(chosen, seconds)
        room = square / 2 - robot.turning_circle - _farthest(_tracks(robot, program, drivers, sizes))
        if room >= SQUARE_MARGIN * square:
            told = _logarithm(robot, program, judges)
            efficiency = float(np.exp((told - _logarithm(robot, _joined(other, seconds), judges)) / _count()))
            return Excitation(program, tuple(each.name for each in chosen), efficiency, room)
        reach *= 0.8
    raise IdentifyError(f"no commands keep every robot of the range within {shown(square)} m: give a larger square")


def _count() -> int:
    return len(COORDINATE_NAMES) - 1  # all but the dead band


def full_speeds(robot: Robot) -> tuple[float, float]:
    """The highest speed [m/s] straight on, and the highest turn rate [rad/s] on the spot."""
    limit = robot.wheel_speed_limit
    return min(robot.v_max, limit), min(robot.w_max, limit / robot.half_axle)


def _drawn(robot: Robot, count: int, generator: np.random.Generator) -> np.ndarray:
    """Values (coordinates, robots) of robots of the range."""
    values = np.repeat(values_of(robot)[:, None], count, axis=1)
    for name, (low, high) in RANGE.items():
        values[COORDINATE_NAMES.index(name)] *= np.exp(generator.uniform(np.log(low), np.log(high), count))
    full = dict(zip(("v_rate_max", "w_rate_max"), full_speeds(robot), strict=True))
    for name, speed in full.items():
        drawn = np.exp(generator.uniform(np.log(RATES[0]), np.log(RATES[1]), count)) * speed
        values[COORDINATE_NAMES.index(name)] = np.minimum(values[COORDINATE_NAMES.index(name)], drawn)
    values[COORDINATE_NAMES.index("latency")] = generator.uniform(0, GREATEST_LATENCY, count)
    values[COORDINATE_NAMES.index("gyration")] = np.maximum(
        values[COORDINATE_NAMES.index("gyration")], 1.001 * least_gyration(robot)
    )
    return np.maximum(values, np.array([each.least for each in COORDINATES.values()])[:, None])


# Manoeuvres -------------------------------------------------------------------------------------------------------


def _ramp(robot: Robot, turns: bool) -> Manoeuvre:
    """Slowly through 0, forward and back."""
    up = np.linspace(0.0, 1.0, round(1.2 / COMMAND_PERIOD))
    shape = np.concatenate([up, up[::-1], -up, -up[::-1]])
    speed, turn = full_speeds(robot)
    shape = (0.12 * (turn if turns else speed)) * shape
    return Manoeuvre(
        "slow ramp, turning" if turns else "slow ramp", *((0 * shape, shape) if turns else (shape, 0 * shape))
    )


def _gentle(robot: Robot, reach: float, seconds: float) -> list[Manoeuvre]:
    """Drives whose speed rises, stays and falls, each for a third of its way there; and back."""
    if seconds < _GENTLE_FROM:
        return []
    count = round((_GENTLE_SHARE * seconds / 3 - _REST) / 2 / COMMAND_PERIOD)
    lasts = count * COMMAND_PERIOD
    rim = min(_GENTLE * lasts / 3, 0.7 * full_speeds(robot)[0], 0.7 * full_speeds(robot)[1] * robot.half_axle)
    rim = min(rim, reach / (1.2 * 2 / 3 * lasts))
    shape = rim * np.clip(3 * np.minimum(np.arange(count), np.arange(count)[::-1]) / count, 0.0, 1.0)
    shape = np.concatenate([shape, -shape[::-1]])
    turn = shape / robot.half_axle
    return [
        Manoeuvre("gently straight", shape, 0 * shape),
        Manoeuvre("gently on the spot", 0 * shape, turn),
        Manoeuvre("gently around a wheel", shape / 2, turn / 2),
    ]


def _library(robot: Robot, reach: float, seed: int) -> list[Manoeuvre]:
    """Drawn manoeuvres that stay within ``reach`` [m], with a fifth for what the robot does otherwise than its data."""
    generator = np.random.default_rng([seed, 1])
    found: list[Manoeuvre] = []
    while len(found) < _DRAWN_MANOEUVRES:
        count = round(generator.uniform(*_LASTS) / COMMAND_PERIOD)
        scale = generator.uniform(0.3, 1.0)
        rows = [_steps(full * _MOST, count, generator, scale) for full in full_speeds(robot)]
        heading = np.cumsum(rows[1]) * COMMAND_PERIOD
        x, y = (np.cumsum(rows[0] * along(heading)) * COMMAND_PERIOD for along in (np.cos, np.sin))
        far = 1.2 * max(np.abs(x).max(), np.abs(y).max())
        rows[0] *= min(1.0, reach / max(far, 1e-9))
        v, w = (np.concatenate([each, -each[::-1]]) for each in rows)
        name = f"steps up to {np.abs(v).max():.2g} m/s and {np.abs(w).max():.2g} rad/s, and back"
        found.append(Manoeuvre(name, v, w))
    return found


def _steps(most: float, count: int, generator: np.random.Generator, scale: float = 1.0) -> np.ndarray:
    """Random levels up to ``scale`` times ``most``, of which some are 0, each held for a while (count,)."""
    held = generator.integers(round(_SHORTEST / COMMAND_PERIOD), round(_LONGEST / COMMAND_PERIOD), count)
    levels = scale * most * generator.uniform(-1.0, 1.0, count) * (generator.uniform(size=count) > _STILL)
    extreme = generator.uniform(size=count) < 0.2
    return np.repeat(np.where(extreme, scale * most * np.sign(levels), levels), held)[:count]


def _joined(parts: list[Manoeuvre], seconds: float) -> Program:
    """Manoeuvres one after the other, filled up with rest."""
    rest, count, rows = np.zeros(round(_REST / COMMAND_PERIOD)), round(seconds / COMMAND_PERIOD), []
    for row in (1, 2):
        whole = np.concatenate([rest, *(np.concatenate([part[row], rest]) for part in parts)])
        rows.append(np.concatenate([whole, np.zeros(max(0, count - len(whole)))])[:count])
    return Program(COMMAND_PERIOD * np.arange(count), *rows)


def _lasting(part: Manoeuvre) -> float:
    return len(part.v) * COMMAND_PERIOD + _REST


def _chosen(
    robot: Robot,
    reach: float,
    seconds: float,
    judges: np.ndarray,
    seed: int,
    inside: tuple[float, np.ndarray, np.ndarray],
) -> tuple[list[Manoeuvre], list[Manoeuvre]]:
    """Ramps, gentle drives, and then manoeuvres until the time is over, the most telling first; and some at random.

    ``inside`` is how far [m] robots may come, and which these are, as of :func:`_tracks`.
    """
    far, *drivers = inside
    first = [_ramp(robot, False), _ramp(robot, True), *_gentle(robot, reach, seconds)]
    library = _library(robot, reach, seed)
    library += [Manoeuvre(f"{part.name}, mirrored", -part.v, -part.w) for part in library]
    alone = [_joined([part], _lasting(part) + _REST) for part in [*first, *library]]
    half = len(first) + len(library) // 2
    each_told = [_information(robot, each, judges) for each in alone[:half]]
    of_first, told = each_told[: len(first)], each_told[len(first) :] * 2
    settled = [_joined([part], _lasting(part) + _REST + _COMES_TO_REST) for part in [*first, *library]]
    tracks = [_tracks(robot, each, *drivers) for each in settled]
    lengths = np.array([_lasting(part) for part in library])
    begun = np.zeros((3, tracks[0].shape[2]))
    for each in tracks[: len(first)]:
        begun = _after(begun, each)[:, -1]

    def filled(best: bool) -> list[Manoeuvre]:
        """Manoeuvres until the time is over: of those that may be taken the best, or any."""
        chosen, poses, left = list(first), begun, seconds - _REST - sum(map(_lasting, first))
        total, generator = _PRIOR * np.eye(_count()) + sum(of_first), np.random.default_rng([seed, 2])
        while True:
            now = np.linalg.slogdet(total)[1]
            gains = np.array([np.linalg.slogdet(total + each)[1] - now for each in told]) / lengths
            for k in np.argsort(-gains) if best else generator.permutation(len(library)):
                track = _after(poses, tracks[len(first) + int(k)])
                if lengths[k] <= left and _farthest(track) <= far:
                    break
            else:
                return chosen
            chosen.append(library[int(k)])
            total, left, poses = total + told[int(k)], left - lengths[k], track[:, -1]

    return filled(True), filled(False)


# What they are worth, and where they lead -------------------------------------------------------------------------


def _stimulus(program: Program) -> Stimulus:
    return Stimulus.of(*program, 0.0, float(program.time[-1]) + 2 * COMMAND_PERIOD)


def _information(robot: Robot, program: Program, judges: np.ndarray) -> np.ndarray:
    """The mean information matrix of robots (coordinates, robots)."""
    speed, turn = full_speeds(robot)
    noise = np.array([speed, turn]) / 50
    stimulus, time = _stimulus(program), program.time[1:]
    return np.asarray(
        np.mean([information(robot, each, stimulus, time, COMMAND_PERIOD, noise) for each in judges.T], axis=0)
    )


def _logarithm(robot: Robot, program: Program, judges: np.ndarray) -> float:
    return float(np.linalg.slogdet(_PRIOR * np.eye(_count()) + _information(robot, program, judges))[1])


def _tracks(robot: Robot, program: Program, drivers: np.ndarray, sizes: np.ndarray) -> np.ndarray:
    """x [m], y [m] and heading [rad] (3, points, robots) of robots (coordinates, robots) that drive from rest at 0.

    ``sizes`` (2, robots): their wheels and their axle over what odometry takes them for.
    """
    done = drive(robot, drivers, _stimulus(program))
    ways, turns = done.forward * sizes[0], done.turn * sizes[0] / sizes[1]
    steps, middle = np.diff(ways, axis=0), (turns[1:] + turns[:-1]) / 2
    x, y = (np.cumsum(steps * along(middle), axis=0) for along in (np.cos, np.sin))
    places = np.append(np.arange(0, len(x) - 1, _POINTS), len(x) - 1)
    return np.stack([x[places], y[places], turns[1:][places]])


def _after(poses: np.ndarray, tracks: np.ndarray) -> np.ndarray:
    """Tracks (3, points, robots) of robots that begin at ``poses`` (3, robots)."""
    cos, sin = np.cos(poses[2]), np.sin(poses[2])
    x, y, turn = tracks
    return np.stack([poses[0] + cos * x - sin * y, poses[1] + sin * x + cos * y, poses[2] + turn])


def _farthest(tracks: np.ndarray) -> float:
    """How far [m] any robot comes from the middle, along x or y."""
    return float(np.abs(tracks[:2]).max())
