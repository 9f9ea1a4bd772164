"""Posture sensors: the true pose with noise, odometry, and the filter that joins both.

Encoders tell how far each wheel has turned, as a whole number of counts; a robot that has its wheels' or its axle's
size a little wrong drifts. A pose sensor is noisy but does not drift. The complementary filter predicts by odometry
and corrects the prediction by a share of its difference from the pose sensor.
"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from math import pi
from typing import Any, Literal

import numpy as np

from fuzzy.compiled.jit import kernel
from fuzzy.errors import InputError
from robotics.quantity import check_quantities, described, quantity
from robotics.random_streams import RELATIVE_STREAM, WHEEL_STREAM
from robotics.vehicle import plant as p

# Noise is drawn for many periods at a time: fewer calls, in bounded memory
_NOISE_BLOCK = 256  # periods
_MOST_DRAWS = 4_000_000  # numbers


class SensingError(InputError):
    """A way of sensing that cannot be. The message names the field, its value and what is accepted."""


@dataclass(frozen=True, kw_only=True)
class Sensing:
    """The posture sensor of a robot. Raises SensingError for fields that do not suit each other.

    ``posture`` "odometry": the posture comes from the encoders alone, beginning where the robot believes to stand
    (``start``). "pose": it is the true pose with white noise, drawn afresh every period; with a ``filter_gain`` below 1
    a complementary filter predicts by odometry and corrects by that share.
    """

    posture: Literal["odometry", "pose"] = described(
        "How a robot knows where it is: by its encoders alone (odometry), or by a pose sensor with noise.", "odometry"
    )
    position_noise: float = quantity(
        0.0, "m", least=0, most=10, doc="The standard deviation of a pose sensor in x and in y."
    )
    heading_noise: float = quantity(
        0.0, "rad", least=0, most=pi, doc="The standard deviation of a pose sensor's heading."
    )
    relative_noise: float = quantity(
        0.0, "1", least=0, most=1, doc="A pose sensor's x and y are times 1 + this × a normal number (thesis 4.5: 0.1)."
    )
    noise_start: float = quantity(0.0, "s", least=0, doc="When a pose sensor's noise begins.")
    noise_end: float | None = quantity(
        None, "s", above=0, doc="When a pose sensor's noise ends; left out: with the run.", example=30.0
    )
    filter_gain: float = quantity(
        1.0, "1", above=0, most=1, doc="The share by which a filter corrects odometry by the pose sensor; 1: no filter."
    )
    wheel_error: float = quantity(
        0.0, "1", least=0, most=0.2, doc="The relative standard deviation, over seeds, of the radii odometry assumes."
    )
    axle_error: float = quantity(
        0.0, "1", least=0, most=0.2, doc="The relative standard deviation, over seeds, of the axle odometry assumes."
    )
    start_position: float = quantity(
        0.0, "m", least=0, most=10, doc="The standard deviation, over seeds, of the true start from the believed one."
    )
    start_heading: float = quantity(
        0.0, "rad", least=0, most=pi, doc="Likewise of the true heading at the start from the believed one."
    )

    def __post_init__(self) -> None:
        check_quantities(self, SensingError)
        own: dict[str, float | None] = {"position_noise": 0, "heading_noise": 0, "relative_noise": 0, "filter_gain": 1}
        own |= {"noise_start": 0, "noise_end": None}
        for name, default in own.items():
            if self.posture == "odometry" and getattr(self, name) != default:
                raise SensingError(f'{name} belongs to posture = "pose"; odometry has its own')
        if self.noise_end is not None and self.noise_end <= self.noise_start:
            raise SensingError(
                f"noise_end must be > noise_start, {self.noise_start:g} s; got {self.noise_end:g}"
            ).about("noise_end")


# The noise of the thesis's laboratory, which it does not print: assumed wherever a scenario is to have some
LABORATORY = Sensing(posture="pose", position_noise=0.003, heading_noise=0.003)


@dataclass(frozen=True)
class PostureSensors:
    """The posture sensors of all robots. Arrays are (robots,), or (3, robots) for x, y, heading."""

    pose: np.ndarray  # bool: whether by a pose sensor; else by odometry
    posed: int  # the number of robots with a pose sensor
    noise: np.ndarray  # (3, robots) m, m, rad: standard deviations
    relative: np.ndarray  # 1: standard deviation of x and y as a share of each
    since: np.ndarray  # s: the noise begins
    until: np.ndarray  # s: the noise ends
    always: bool  # all noise acts from the start to the end
    gain: np.ndarray  # 1: of the filter; 1 where there is none
    draws: Iterator[np.ndarray] | None  # normal numbers (3, runs, robots), period by period
    relative_draws: Iterator[np.ndarray] | None
    noisy: Any  # an index of the robots with absolute noise
    scaled: Any  # of those with relative noise
    filtered: Any  # of those with a filter; None: no robot
    noise_ends: float  # s: no robot has absolute noise after that
    relative_ends: float  # s: no robot has relative noise after that

    @classmethod
    def of(
        cls,
        sensing: Sequence[Sensing],
        ticks: int,
        generators: Sequence[np.random.Generator],
        seeds: Sequence[int],
    ) -> "PostureSensors":
        """Make the posture sensors of a simulation.

        Args:
            sensing: One for each robot.
            ticks: The number of control periods.
            generators: One for each run; the absolute noise comes from these.
            seeds: One for each run; the relative noise comes from these.
        """
        pose = np.array([s.posture == "pose" for s in sensing])
        noise = np.array([[s.position_noise] * 2 + [s.heading_noise] for s in sensing]).T
        relative = np.array([s.relative_noise for s in sensing])
        until = np.array([np.inf if s.noise_end is None else s.noise_end for s in sensing])
        gain = np.array([s.filter_gain for s in sensing])
        noisy, scaled = noise.max(axis=0) > 0, relative > 0
        periods = min(_NOISE_BLOCK, ticks + 1, max(1, _MOST_DRAWS // (3 * len(sensing) * len(seeds))))
        own = [np.random.default_rng([seed, RELATIVE_STREAM]) for seed in seeds] if relative.any() else []
        return cls(
            pose,
            int(pose.sum()),
            noise,
            relative,
            np.array([s.noise_start for s in sensing]),
            until,
            all(s.noise_start == 0 and s.noise_end is None for s in sensing),
            gain,
            _normal(generators, periods, len(sensing)) if noise.any() else None,
            _normal(own, periods, len(sensing)) if own else None,
            _which(noisy),
            _which(scaled),
            _which(gain < 1) if (gain < 1).any() else None,
            until[noisy].max(initial=0.0),
            until[scaled].max(initial=0.0),
        )

    def measure(
        self, time: float, state: np.ndarray, estimate: np.ndarray | None, v: np.ndarray, w: np.ndarray, dt: float
    ) -> np.ndarray:
        """Measure the postures (3, runs, robots): x [m], y [m], heading [rad].

        Args:
            time: The time [s].
            state: The plant's state (channels, runs, robots).
            estimate: The postures of the period before (3, runs, robots); None before the first.
            v: The speed since then by the encoders (runs, robots) [m/s].
            w: The angular velocity since then by the encoders (runs, robots) [rad/s].
            dt: The time since then [s].
        """
        odometry = state[p.ODO_X : p.ODO_HEADING + 1]
        if not self.posed:
            return odometry.copy()
        truth = state[p.X : p.HEADING + 1]
        measured = truth.copy() if self.posed == len(self.pose) else np.where(self.pose, truth, odometry)
        now = time + 1e-9
        # Noise that is over need not be drawn; noise that is yet to come must be, or it would come too early.
        if self.relative_draws is not None and now < self.relative_ends:
            share = next(self.relative_draws)[:2, :, self.scaled] * (self.relative * self._active(now))[self.scaled]
            measured[:2, :, self.scaled] *= 1 + share
        if self.draws is not None and now < self.noise_ends:
            noise = self.noise if self.always else self.noise * self._active(now)
            measured[:, :, self.noisy] += next(self.draws)[:, :, self.noisy] * noise[:, None, self.noisy]
        if self.filtered is not None and estimate is not None:
            forward, turn = v[:, self.filtered] * dt, w[:, self.filtered] * dt
            predicted = estimate[:, :, self.filtered]
            middle = predicted[2] + turn / 2
            predicted = predicted + np.stack([forward * np.cos(middle), forward * np.sin(middle), turn])
            gap = measured[:, :, self.filtered] - predicted
            measured[:, :, self.filtered] = predicted + self.gain[self.filtered] * gap
        return measured

    def _active(self, now: float) -> np.ndarray:
        return (self.since <= now) & (now < self.until)


def _which(robots: np.ndarray) -> Any:
    """An index of the ``robots`` (robots,) bool; for all of them a slice, which copies nothing."""
    return slice(None) if robots.all() else np.flatnonzero(robots)


def _normal(generators: Sequence[np.random.Generator], periods: int, robots: int) -> Iterator[np.ndarray]:
    """Normal numbers (3, runs, robots), period by period; each run draws from its own generator."""
    draws = np.empty((len(generators), periods, 3, robots))
    while True:
        for generator, rows in zip(generators, draws, strict=True):
            generator.standard_normal(out=rows)
        yield from draws.transpose(1, 2, 0, 3)


def wheel_errors(sensing: Sequence[Sensing], seeds: Sequence[int]) -> np.ndarray | None:
    """The sizes of right wheel, left wheel and axle that odometry assumes, over the true ones (3, lanes).

    None where every robot knows its sizes.
    """
    spread = np.array([[s.wheel_error, s.wheel_error, s.axle_error] for s in sensing]).T
    if not spread.any():
        return None
    draws = [np.random.default_rng([seed, WHEEL_STREAM]).standard_normal(spread.shape) for seed in seeds]
    return np.concatenate([1 + np.clip(spread * d, -0.5, 0.5) for d in draws], axis=1)


@kernel
def wheel_odometry(parameters, state, before, period):  # type: ignore[no-untyped-def]
    """Return the encoders' counts (2, lanes), and v [m/s] and ω [rad/s] (2, lanes) since the last   thesis (2.25).

    Args:
        parameters: The plant's (PARAMETERS, lanes).
        state: The plant's state (CHANNELS, lanes).
        before: The counts of the last period (2, lanes).
        period: The time since then [s].
    """
    counts, velocities = np.empty_like(before), np.empty_like(before)
    for lane in range(before.shape[1]):
        for wheel in range(2):
            counts[wheel, lane] = np.floor(state[p.ANGLE_R + wheel, lane] * parameters[p.P_COUNT, lane])
        a_second = (counts[:, lane] - before[:, lane]) / period / parameters[p.P_COUNT, lane]
        right = a_second[0] * parameters[p.P_ODO_RIGHT, lane]
        left = a_second[1] * parameters[p.P_ODO_LEFT, lane]
        velocities[0, lane] = (right + left) / 2
        velocities[1, lane] = (right - left) / (2 * parameters[p.P_ODO_HALF_AXLE, lane])
    return counts, velocities
