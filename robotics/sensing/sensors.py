"""Posture sensors: the true pose with noise, odometry, and the filter that joins both.

Encoders tell how far each wheel has turned, a whole number of counts; a robot that believes its wheels or its axle
to be a little other than they are drifts. A pose sensor is noisy but does not drift. The complementary filter
predicts by odometry and corrects the prediction by a share of what the pose sensor says.
"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numba import njit

from robotics import plant as p
from robotics.radio import RELATIVE_STREAM, WHEEL_STREAM
from robotics.scenario import Scenario

# Periods of noise drawn at a time, and numbers in all: bounds memory without a call a period and run
_NOISE_BLOCK, _MOST_DRAWS = 256, 4_000_000


@dataclass(frozen=True)
class PostureSensors:
    """How all robots of a scenario know their postures. Arrays are (robots,), or (3, robots) for x, y, heading."""

    pose: np.ndarray  # bool: by a pose sensor; else by odometry
    posed: int  # how many are
    noise: np.ndarray  # (3, robots) m, m, rad: standard deviations
    relative: np.ndarray  # 1: standard deviation of x and y as a share of each
    since: np.ndarray  # s: noise from then on
    until: np.ndarray  # s: and no longer
    gain: np.ndarray  # of the filter; 1: none
    draws: Iterator[np.ndarray] | None  # normal numbers (3, runs, robots), period by period
    relative_draws: Iterator[np.ndarray] | None
    # Which robots those concern: an index
    noisy: Any
    scaled: Any
    filtered: Any  # None: no robot
    # s: no robot's noise goes on for longer
    noise_ends: float
    relative_ends: float

    @classmethod
    def of(
        cls, scenario: Scenario, generators: Sequence[np.random.Generator], seeds: Sequence[int]
    ) -> "PostureSensors":
        """The sensors of ``scenario``; the absolute noise comes from ``generators``, one a run."""
        sensing = [member.sensing or scenario.sensing for member in scenario.robots]
        pose = np.array([s.posture == "pose" for s in sensing])
        noise = np.array([[s.position_noise] * 2 + [s.heading_noise] for s in sensing]).T
        relative = np.array([s.relative_noise for s in sensing])
        until = np.array([np.inf if s.noise_end is None else s.noise_end for s in sensing])
        gain = np.array([s.filter_gain for s in sensing])
        noisy, scaled = noise.max(axis=0) > 0, relative > 0
        periods = min(_NOISE_BLOCK, scenario.ticks + 1, max(1, _MOST_DRAWS // (3 * len(sensing) * len(seeds))))
        own = [np.random.default_rng([seed, RELATIVE_STREAM]) for seed in seeds] if relative.any() else []
        return cls(
            pose,
            int(pose.sum()),
            noise,
            relative,
            np.array([s.noise_start for s in sensing]),
            until,
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
        """The measured postures (3, runs, robots) at ``time`` [s].

        ``state`` is the plant's (channels, runs, robots); ``estimate`` the postures of the period before, ``v`` and
        ``w`` (runs, robots) what the encoders told since, ``dt`` [s] ago.
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
            measured[:, :, self.noisy] += (
                next(self.draws)[:, :, self.noisy] * (self.noise * self._active(now))[:, None, self.noisy]
            )
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
    """An index of the ``robots`` (robots,) bool; of all of them one that copies nothing."""
    return slice(None) if robots.all() else np.flatnonzero(robots)


def _normal(generators: Sequence[np.random.Generator], periods: int, robots: int) -> Iterator[np.ndarray]:
    """Normal numbers (3, runs, robots), period by period; each run draws from its own generator."""
    draws = np.empty((len(generators), periods, 3, robots))
    while True:
        for generator, rows in zip(generators, draws, strict=True):
            generator.standard_normal(out=rows)
        yield from draws.transpose(1, 2, 0, 3)


def wheel_errors(scenario: Scenario, seeds: Sequence[int]) -> np.ndarray | None:
    """What each robot takes its right wheel, left wheel and axle to be, as a share of the truth: (3, lanes).

    None where every robot knows its own wheels.
    """
    spread = np.array(
        [[s.wheel_error, s.wheel_error, s.axle_error] for s in (m.sensing or scenario.sensing for m in scenario.robots)]
    ).T
    if not spread.any():
        return None
    draws = [np.random.default_rng([seed, WHEEL_STREAM]).standard_normal(spread.shape) for seed in seeds]
    return np.concatenate([1 + np.clip(spread * d, -0.5, 0.5) for d in draws], axis=1)


@njit(cache=True, error_model="numpy")
def wheel_odometry(parameters, state, before, period):  # type: ignore[no-untyped-def]
    """What the encoders have counted (2, lanes), and v [m/s] and ω [rad/s] (2, lanes) since   thesis (2.25).

    ``before`` (2, lanes) are the counts ``period`` seconds ago.
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
