"""Posture sensors: the true pose with noise, odometry, and the filter that joins both.

Encoders tell how far each wheel has turned, as a whole number of counts; a robot that has its wheels' or its axle's
size a little wrong drifts. A pose sensor is noisy but does not drift. A filter predicts by odometry and corrects the
prediction: the complementary one by a share of its difference from the pose sensor, the extended Kalman filter
(:mod:`robotics.world.sensing.kalman`) by what the noise and what it has learnt of the wheels make of it.
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass, fields, replace
from functools import partial
from math import pi
from typing import Literal, NamedTuple, cast

import numpy as np

from fuzzy.compiled.columns import Bools1, Floats1, Floats2, Floats4
from fuzzy.compiled.jit import compiled_only, without_refcounts
from fuzzy.errors import InputError
from fuzzy.quantity import check_quantities, described, part, quantity
from robotics.world.random_streams import RELATIVE_STREAM, WHEEL_STREAM
from robotics.world.sensing.kalman import EstimateColumns, begin, joined
from robotics.world.vehicle.plant import ParameterColumns, TruthColumns

# Noise is drawn for many periods at a time: fewer calls, in bounded memory
_NOISE_BLOCK, _FEW_DRAWS = 256, 32_768  # periods, or numbers, at least
_MOST_DRAWS = 4_000_000  # numbers


class SensingError(InputError):
    """A way of sensing that cannot be. The message names the field, its value and what is accepted."""


SLIP = 0.0003  # m after 1 m: a choice. The wheels of the simulator do not slip; those of robots do, and more
SURE = 0.02  # how well a Kalman filter takes wheels and axle to be known at best: one that is surer never learns them
KALMAN: Literal["kalman"] = "kalman"
_OF_POSE_SENSOR = (  # fields that say nothing of odometry
    "position_noise", "heading_noise", "relative_noise", "noise_start", "noise_end", "filter_gain", "estimator", "slip",
)  # fmt: skip
# Standard deviations
_in_m = partial(quantity, 0.0, "m", least=0, most=10)
_in_rad = partial(quantity, 0.0, "rad", least=0, most=pi)
_relative = partial(quantity, 0.0, "1", least=0, most=0.2)


@dataclass(frozen=True, kw_only=True)
class Sensing:
    """The posture sensor of a robot.

    ``posture`` "odometry": the posture comes from the encoders alone, beginning where the robot believes to stand
    (``start``). "pose": it is the true pose with white noise, drawn afresh every period; an ``estimator`` "kalman", or
    the complementary filter with a ``filter_gain`` below 1, joins it with odometry. The Kalman filter knows what is
    told here of noise, wheels and axle, and begins with a spread of 2 % of these at least.

    Raises:
        SensingError: Fields that do not suit each other.
    """

    posture: Literal["odometry", "pose"] = described(
        "How a robot knows where it is: by its encoders alone (odometry), or by a pose sensor with noise.", "odometry"
    )
    position_noise: float = _in_m(doc="The standard deviation of a pose sensor in x and in y.")
    heading_noise: float = _in_rad(doc="The standard deviation of a pose sensor's heading.")
    relative_noise: float = part(0.0, doc="A pose sensor's x and y are times 1 + this × a normal number, such as 0.1.")
    noise_start: float = quantity(0.0, "s", least=0, doc="When a pose sensor's noise begins.")
    noise_end: float | None = quantity(
        None, "s", above=0, doc="When a pose sensor's noise ends; left out: with the run.", example=30.0
    )
    filter_gain: float = quantity(
        1.0, "1", above=0, most=1, doc="The share by which a filter corrects odometry by the pose sensor; 1: no filter."
    )
    estimator: Literal["complementary", "kalman"] = described(
        "How a pose sensor and odometry are joined: by filter_gain, or by an extended Kalman filter.", "complementary"
    )
    slip: float = quantity(
        SLIP, "sqrt(m)", least=0, most=0.1, doc="What a Kalman filter takes a wheel's way to err by after 1 m, in m."
    )
    wheel_error: float = _relative(doc="The relative standard deviation, over seeds, of the radii odometry assumes.")
    axle_error: float = _relative(doc="The relative standard deviation, over seeds, of the axle odometry assumes.")
    start_position: float = _in_m(doc="The standard deviation, over seeds, of the true start from the believed one.")
    start_heading: float = _in_rad(doc="Likewise of the true heading at the start from the believed one.")

    def __post_init__(self) -> None:
        check_quantities(self, SensingError)
        for field in fields(self):
            said = field.name in _OF_POSE_SENSOR and getattr(self, field.name) != field.default
            if said and self.posture == "odometry":
                raise SensingError(f'{field.name} belongs to posture = "pose"; odometry has its own')
        if self.estimator == KALMAN and self.filter_gain != 1:
            raise SensingError('filter_gain belongs to estimator = "complementary"; the other makes its own')
        if self.noise_end is not None and self.noise_end <= self.noise_start:
            raise SensingError(
                f"noise_end must be > noise_start, {self.noise_start:g} s; got {self.noise_end:g}"
            ).about("noise_end")

    def joined_by(self, estimator: float | str | None) -> "Sensing":
        """The same with another filter.

        Args:
            estimator: The ``filter_gain`` of a complementary filter, or "kalman"; None: as it is.

        Raises:
            SensingError: There is no pose sensor.
        """
        if estimator is None:
            return self
        kalman = estimator == KALMAN
        return replace(
            self,
            estimator=KALMAN if kalman else "complementary",
            filter_gain=1.0 if kalman else cast(float, estimator),
        )


# The noise of the thesis's laboratory, which it does not print: assumed wherever a scenario is to have some
LABORATORY = Sensing(posture="pose", position_noise=0.003, heading_noise=0.003)


class Senses(NamedTuple):
    """The posture sensors of all robots as columns, for compiled functions; a lane is one robot of one run."""

    posed: Bools1  # (robots,): by a pose sensor; else by odometry
    noise: Floats2  # (3, robots) m, m, rad: standard deviations
    relative: Floats1  # (robots,) 1: standard deviation of x and y as a share of each
    since: Floats1  # (robots,) s: the noise begins
    until: Floats1  # (robots,) s: the noise ends
    gain: Floats1  # (robots,) 1: of the complementary filter; 1 where there is none, 0 of a Kalman filter
    spread: Floats2  # (3, robots) 1, 1, √m: of wheels and of axle, and the slip, as a Kalman filter takes them
    estimate: Floats2  # (EstimateColumns, lanes), or no lanes: no robot has a Kalman filter
    counts: Floats2  # (2, lanes): of the encoders in the last period
    draws: Floats4  # (runs, periods, 3, robots): normal numbers; no periods: there is no such noise
    relative_draws: Floats4  # likewise, of the relative noise
    drawn: int  # the period of the first of them


@dataclass(frozen=True, eq=False)
class PostureNoise:
    """The noise of the posture sensors of a simulation; each run draws from its own generators."""

    sensing: tuple[Sensing, ...]  # one for each robot
    periods: int  # drawn at a time
    generators: tuple[np.random.Generator, ...]  # of the absolute noise; none where there is none
    relative: tuple[np.random.Generator, ...]

    @classmethod
    def opened(
        cls, sensing: Sequence[Sensing], ticks: int, generators: Sequence[np.random.Generator], seeds: Sequence[int]
    ) -> "PostureNoise":
        """Open the noise of a simulation.

        Args:
            sensing: One for each robot.
            ticks: The number of control periods.
            generators: One for each run; the absolute noise comes from these.
            seeds: One for each run; the relative noise comes from these.
        """
        noisy = any(s.position_noise or s.heading_noise for s in sensing)
        scaled = any(s.relative_noise for s in sensing)
        own = tuple(np.random.default_rng([seed, RELATIVE_STREAM]) for seed in seeds if scaled)
        numbers = 3 * len(sensing) * len(seeds)  # a period
        periods = min(max(_NOISE_BLOCK, _FEW_DRAWS // numbers), ticks + 1, max(1, _MOST_DRAWS // numbers))
        return cls(tuple(sensing), periods, tuple(generators) if noisy else (), own)

    def senses(self, counts: np.ndarray) -> Senses:
        """The columns before the first period, with the encoders' ``counts`` (2, lanes)."""
        sensing = self.sensing
        none = np.empty((0, 0, 3, len(sensing)))
        return Senses(
            np.array([s.posture == "pose" for s in sensing]),
            np.array([[s.position_noise] * 2 + [s.heading_noise] for s in sensing], dtype=float).T.copy(),
            np.array([s.relative_noise for s in sensing], dtype=float),
            np.array([s.noise_start for s in sensing], dtype=float),
            np.array([np.inf if s.noise_end is None else s.noise_end for s in sensing], dtype=float),
            np.array([0.0 if s.estimator == KALMAN else s.filter_gain for s in sensing], dtype=float),
            np.array([[max(s.wheel_error, SURE), max(s.axle_error, SURE), s.slip] for s in sensing]).T.copy(),
            np.zeros((EstimateColumns.size, counts.shape[1] * any(s.estimator == KALMAN for s in sensing))),
            counts,
            none,
            none,
            0,
        )

    def supplied(self, senses: Senses, k: int, goes_on: np.ndarray) -> Senses:
        """The same with the random numbers of period ``k`` and of some after it; every period needs its own.

        Those of a run that does not go on (runs,) are not drawn.
        """
        if k < senses.drawn + max(senses.draws.shape[1], senses.relative_draws.shape[1]):
            return senses
        draws, relative_draws = (self._normal(own, goes_on) for own in (self.generators, self.relative))
        return senses._replace(draws=draws, relative_draws=relative_draws, drawn=k)

    def _normal(self, generators: Sequence[np.random.Generator], goes_on: np.ndarray) -> np.ndarray:
        draws = np.empty((len(generators), self.periods if generators else 0, 3, len(self.sensing)))
        for run in np.flatnonzero(goes_on[: len(generators)]).tolist():
            generators[run].standard_normal(out=draws[run])
        return draws


def wheel_errors(sensing: Sequence[Sensing], seeds: Sequence[int]) -> np.ndarray | None:
    """The sizes of right wheel, left wheel and axle that odometry assumes, over the true ones (3, lanes).

    None where every robot knows its sizes.
    """
    spread = np.array([[s.wheel_error, s.wheel_error, s.axle_error] for s in sensing]).T
    if not spread.any():
        return None
    draws = [np.random.default_rng([seed, WHEEL_STREAM]).standard_normal(spread.shape) for seed in seeds]
    return np.concatenate([1 + np.clip(spread * d, -0.5, 0.5) for d in draws], axis=1)


@without_refcounts
def read_encoders(parameters, truth, counts, period, velocity):  # type: ignore[no-untyped-def]
    """Read all encoders, and the velocities since the last ``counts`` (2, lanes), which are brought up to date.

    Args:
        parameters: The plant's (ParameterColumns, lanes).
        truth: The plant's state (TruthColumns, lanes).
        counts: Of the last period (2, lanes).
        period: The time since then [s].
        velocity: Where v [m/s] and ω [rad/s] are written (2, lanes)   thesis (2.25).
    """
    for i in range(truth.shape[1]):
        encoders_of(i, parameters, truth, counts, period, velocity)


@compiled_only
def encoders_of(i, parameters, truth, counts, period, velocity):  # type: ignore[no-untyped-def]
    """Do the same for one lane."""
    robot, wheels = ParameterColumns(parameters, i), TruthColumns(truth, i)
    right, left = np.floor(wheels.right.angle * robot.count), np.floor(wheels.left.angle * robot.count)
    right_speed = (right - counts[0, i]) / period / robot.count * robot.odometry.right
    left_speed = (left - counts[1, i]) / period / robot.count * robot.odometry.left
    counts[0, i], counts[1, i] = right, left
    velocity[0, i] = (right_speed + left_speed) / 2
    velocity[1, i] = (right_speed - left_speed) / (2 * robot.odometry.half_axle)


@compiled_only
def measure_of(  # type: ignore[no-untyped-def]
    i, run, robot, senses, parameters, truth, posture, velocity, k, place, dt
):
    """Measure the posture of one lane in period ``k``: by odometry, or the truth with noise, filtered where it is.

    Args:
        i: The lane, a ``robot`` of a ``run``.
        run, robot: From 0.
        senses: The sensors.
        parameters: The plant's (ParameterColumns, lanes).
        truth: The plant's state (TruthColumns, lanes).
        posture: Those of the period before, where the new ones are written (3, lanes): x [m], y [m], heading [rad].
        velocity: v [m/s] and ω [rad/s] since then, by the encoders (2, lanes).
        k: The control period.
        place: Of the period's random numbers.
        dt: The time since the last [s].
    """
    here = TruthColumns(truth, i)
    if not senses.posed[robot]:
        posture[0, i], posture[1, i], posture[2, i] = here.odo_x, here.odo_y, here.odo_heading
        return
    now = k * dt + 1e-9
    x, y, heading = here.x, here.y, here.heading
    if senses.since[robot] <= now < senses.until[robot]:
        if len(senses.relative_draws) > 0:
            x *= 1 + senses.relative_draws[run, place, 0, robot] * senses.relative[robot]
            y *= 1 + senses.relative_draws[run, place, 1, robot] * senses.relative[robot]
        if len(senses.draws) > 0:
            x += senses.draws[run, place, 0, robot] * senses.noise[0, robot]
            y += senses.draws[run, place, 1, robot] * senses.noise[1, robot]
            heading += senses.draws[run, place, 2, robot] * senses.noise[2, robot]
    gain = senses.gain[robot]
    if gain == 0:
        noise, share = senses.noise[:, robot], senses.relative[robot]
        variances = noise[0] ** 2 + (share * x) ** 2, noise[1] ** 2 + (share * y) ** 2, noise[2] ** 2
        estimate = EstimateColumns(senses.estimate, i)
        if k == 0:
            begin(estimate, variances, senses.spread[0, robot], senses.spread[1, robot])
        else:
            half = ParameterColumns(parameters, i).odometry.half_axle
            ways = (velocity[0, i] + half * velocity[1, i]) * dt, (velocity[0, i] - half * velocity[1, i]) * dt
            before = posture[0, i], posture[1, i], posture[2, i]
            x, y, heading = joined(estimate, before, ways, half, senses.spread[2, robot], (x, y, heading), variances)
    elif gain < 1 and k > 0:
        forward, turn = velocity[0, i] * dt, velocity[1, i] * dt
        middle = posture[2, i] + turn / 2
        px, py = posture[0, i] + forward * math.cos(middle), posture[1, i] + forward * math.sin(middle)
        predicted = posture[2, i] + turn
        x, y, heading = px + gain * (x - px), py + gain * (y - py), predicted + gain * (heading - predicted)
    posture[0, i], posture[1, i], posture[2, i] = x, y, heading
