"""Random problems of predictive control: what a tracking robot may meet, and worse."""

import numpy as np

from benchmarks.predictivesolving import Problem
from robotics.plugins.predictive.model import response, wheel_rate
from robotics.plugins.predictive.nmpc import PredictiveControl
from robotics.plugins.predictive.terminal import tail_table
from robotics.world.vehicle.plant import saturate, velocity_limits
from robotics.world.vehicle.robot import Robot
from robotics.world.vehicle.wheel_loop import wheel_lag

PERIOD = 0.05  # s
PENDING = 2  # commands that are still to act
POSITION, TURN = 0.5, 1.0  # m, rad: the greatest errors at the time of the last measurement
SPEEDS, CURVATURE = (0.05, 0.6), 2.0  # m/s, 1/m: of the reference
SPEED_RATE, CURVATURE_RATE = 0.3, 1.0  # m/s², 1/(m s): at most
LAW = PredictiveControl(
    along_scale=0.1, cross_scale=0.1, heading_scale=0.5, v_scale=0.2, w_scale=1.0, change_scale=0.05, horizon=20
)  # spelt out: stored costs are those of these scales
PARTS = 10  # of a period, in which the reference is integrated


def random_problems(count: int, seed: int, robot: Robot, law: PredictiveControl | None = None) -> list[Problem]:
    """Problems of ``robot`` that is up to 0.5 m and 1 rad off a reference of random speed and curvature.

    The robot's velocities and its earlier commands, two periods of which are still to act, are random ones as well, and
    so is how speed and curvature change. The first guess is the solver's own, by the Lyapunov law.
    """
    rng = np.random.default_rng(seed)
    return [_problem(rng, robot, law or LAW) for _ in range(count)]


def _problem(rng: np.random.Generator, robot: Robot, law: PredictiveControl) -> Problem:
    lag, limits = wheel_lag(robot), velocity_limits([robot])
    v_max, w_max, half_axle, wheel = (float(row[0]) for row in limits)
    rate = wheel_rate(robot) * PERIOD
    sent = [_allowed(limits, *rng.uniform([-0.2, -w_max], [v_max, w_max]))]
    for _ in range(PENDING):
        right, left = rng.uniform(-rate, rate, 2)
        sent.append(_allowed(limits, sent[-1][0] + (right + left) / 2, sent[-1][1] + (right - left) / (2 * half_axle)))
    distance, angle = POSITION * np.sqrt(rng.uniform()), rng.uniform(0, 2 * np.pi)
    state = np.array([distance * np.cos(angle), distance * np.sin(angle), rng.uniform(-TURN, TURN), 0.0, 0.0])
    state[3:] = sent[0] + rng.normal(0, [0.05, 0.3])
    for command in sent[1:]:
        state = _driven(state, command, lag)
    places, velocities = _reference(rng, law.horizon)
    weights = law.weights(robot)
    table = tail_table(weights, response(PERIOD, lag), wheel)
    follow = velocities[:-1]
    return Problem(
        period=PERIOD,
        lag=lag,
        weights=weights,
        half_axle=half_axle,
        tops=np.array([v_max, w_max, wheel, wheel]),
        rates=np.array([np.inf, np.inf, rate, rate]),
        before=sent[-1],
        state=state,
        to=places[1:],
        follow=follow,
        end=velocities[-2],
        tail=np.array([np.interp(velocities[-2, 0], table[:, 0], column) for column in table[:, 1:].T]),
        guess=np.full((law.horizon, 2), np.nan),
    )


def _allowed(limits: np.ndarray, v: float, w: float) -> np.ndarray:
    return np.ravel(saturate(limits, np.array([v]), np.array([w])))


def _driven(state: np.ndarray, command: np.ndarray, lag: float) -> np.ndarray:
    """The state a period later: the velocities exactly, the place by a thousand small steps."""
    x, y, heading, v, w = state
    h = PERIOD / 1000
    t = h * (np.arange(1000) + 0.5)
    left, turned = np.exp(-t / lag), heading + command[1] * t + (w - command[1]) * lag * (1 - np.exp(-t / lag))
    way = h * (command[0] + (v - command[0]) * left)
    end = np.exp(-PERIOD / lag)
    turn = command[1] * PERIOD + (w - command[1]) * lag * (1 - end)
    return np.array(
        [
            x + (way * np.cos(turned)).sum(),
            y + (way * np.sin(turned)).sum(),
            heading + turn,
            *(command + (state[3:] - command) * end),
        ]
    )


def _reference(rng: np.random.Generator, horizon: int) -> tuple[np.ndarray, np.ndarray]:
    """Where it is at the beginning of the plan and at the ends of its periods, and its velocities then and once more.

    At the time of the last measurement it is at the origin with the heading 0.
    """
    speed, curvature = rng.uniform(*SPEEDS), rng.uniform(-CURVATURE, CURVATURE)
    faster, more = rng.uniform(-SPEED_RATE, SPEED_RATE), rng.uniform(-CURVATURE_RATE, CURVATURE_RATE)
    h = PERIOD / PARTS
    t = h * np.arange(PARTS * (PENDING + horizon + 1) + 1)
    v = np.clip(speed + faster * t, *SPEEDS)
    w = v * np.clip(curvature + more * t, -CURVATURE, CURVATURE)
    heading = np.concatenate([[0.0], np.cumsum(h * (w[1:] + w[:-1]) / 2)])
    forward, aside = v * np.cos(heading), v * np.sin(heading)
    x, y = (np.concatenate([[0.0], np.cumsum(h * (rate[1:] + rate[:-1]) / 2)]) for rate in (forward, aside))
    at = slice(PARTS * PENDING, None, PARTS)
    return np.stack([x, y, heading], axis=-1)[at][:-1], np.stack([v, w], axis=-1)[at]
