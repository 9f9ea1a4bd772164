"""Leader-follower formations, thesis 5.2: the scenario, and figures of merit of a run.

Robot 1 leads. The sine of the thesis's figures is lost; the centers of its Tables 5.2 and 5.3 lie on y = 0.5 cos x,
and its initial poses [-3, 0.5, 0] and [3, -0.5, 0] on it too if a straight line y = 0.5 leads in before x = 0. The
followers drive the same curve one metre to the left and to the right, from x = 0.

A formation has no reference in time. Each robot's trajectory runs along its own path with the desired speed from
x = 0 on, so the leader's reference drives beside the followers'; the laws of
:mod:`robotics.controllers.leader_follower` use the paths only. A run counts until the leader reaches the end of its
path, where all robots stop.
"""

from collections.abc import Callable
from math import pi

import numpy as np

from robotics.metrics import Metric, cross_track_error
from robotics.path import Sine
from robotics.run import Run
from robotics.scenario import Member, Scenario, Sensing
from robotics.trajectory import Timing

AMPLITUDE, WAVENUMBER = 0.5, 1.0  # m, rad/m: y = 0.5 cos x, fitted to the centers of Tables 5.2 and 5.3
PERIOD = 2 * pi  # m
SIDES = (1.0, -1.0)  # m, the followers' offsets in y: [0, 1.5, 0] and [0, -0.5, 0]
ALIGNED = 0.1  # m: leader and followers are level


def leader_path(end: float = PERIOD, lead_in: float = 4.0) -> Sine:
    """y = 0.5 cos x up to x = ``end`` [m], after a straight line of ``lead_in`` metres."""
    return Sine(amplitude=AMPLITUDE, wavenumber=WAVENUMBER, phase=pi / 2, x_end=end, lead_in=lead_in)


def formation_scenario(start: float, speed: float = 0.1, end: float = PERIOD) -> Scenario:
    """A formation that begins with the leader at x = ``start`` [m] on its path and the followers at x = 0.

    The plant is the kinematic one, so that a robot which knows its path stays on it: what is sampled from such a run
    is the law, not the wheels' lag. ``speed`` is v_d [m/s]. It lasts until either law of the teacher has ended.
    """
    lead_in = max(0.0, -start)
    curve = AMPLITUDE * np.cos(WAVENUMBER * max(start, 0.0))
    slope = -AMPLITUDE * WAVENUMBER * np.sin(WAVENUMBER * max(start, 0.0))
    leader = Member(
        start=(float(start), float(curve), float(np.arctan(slope))),
        path=leader_path(end, lead_in),
        timing=Timing(speed=speed, start=lead_in),
    )
    followers = [
        Member(
            start=(0.0, AMPLITUDE + side, 0.0),
            path=Sine(amplitude=AMPLITUDE, wavenumber=WAVENUMBER, phase=pi / 2, x_end=end, offset=side),
            timing=Timing(speed=speed),
        )
        for side in SIDES
    ]
    # The curve is 1.06 times as long as its x. While a leader far behind catches up with 5 v_d / 2, the followers lose
    # v_d / 2: a fifth of its way; and a little more until it is level.
    longest = (1.07 * end + 0.2 * lead_in + 1.5) / speed
    return Scenario(
        name=f"formation-{start:g}",
        robots=(leader, *followers),
        duration=float(np.ceil(longest)),
        plant="kinematic",
        divergence=1e3,
        sensing=Sensing(posture="pose"),
        kind="formation",
    )


def leads(run: Run) -> np.ndarray:
    """dx [m] (runs, samples): the leader's true x less the followers' mean."""
    x = run["x"]
    return np.asarray(x[:, 0] - x[:, 1:].mean(axis=1))


def last_samples(run: Run) -> np.ndarray:
    """(runs,) int: the sample at which the leader reaches the end of its path; -1 if it never does."""
    there = run["x"][:, 0] >= run.paths[0][0, -1]
    return np.where(there.any(-1), np.argmax(there, axis=-1), -1)


def alignment_time(run: Run) -> np.ndarray:
    """(runs,) s: from when on |dx| stays below 10 cm until the leader's end; infinite if it does not, or never ends."""
    gap, last = np.abs(leads(run)), last_samples(run)
    counted = np.arange(gap.shape[1]) <= last[:, None]
    apart = counted & ~(gap < ALIGNED)
    first = np.where(apart.any(-1), gap.shape[1] - np.argmax(apart[:, ::-1], axis=-1), 0)
    return np.where((last >= 0) & (first <= last), run.time[np.minimum(first, gap.shape[1] - 1)], np.inf)


def final_spread(run: Run) -> np.ndarray:
    """(runs,) m: between the foremost and the rearmost x when the leader ends; infinite if it never does."""
    x, last = run["x"], last_samples(run)
    now = np.take_along_axis(x, last[:, None, None], axis=-1)[..., 0]
    return np.where(last >= 0, now.max(axis=1) - now.min(axis=1), np.inf)


def lateral_error(run: Run) -> np.ndarray:
    """(runs, robots) m: each robot's largest distance from its own path until the leader ends (or the run does)."""
    counted = np.arange(len(run.time)) <= np.where(last_samples(run) >= 0, last_samples(run), len(run.time))[:, None]
    distance = np.where(counted[:, None], np.abs(cross_track_error(run)), 0.0)
    return np.asarray(np.nanmax(distance, axis=-1))


def _same_for_all(measure: Callable[[Run], np.ndarray]) -> Callable[[Run], np.ndarray]:
    """A figure of the whole formation (runs,) as one a robot (runs, robots)."""
    return lambda run: np.repeat(measure(run)[:, None], run.stopped.shape[1], axis=1)


FORMATION_METRICS: dict[str, Metric] = {
    "alignment_time_s": Metric(_same_for_all(alignment_time), "s", "leader level with followers (10 cm) for good"),
    "final_spread_m": Metric(_same_for_all(final_spread), "m", "spread of x when the leader ends"),
    "max_lateral_error_m": Metric(lateral_error, "m", "largest distance from the own path until then"),
}


def measure_formation(run: Run) -> dict[str, np.ndarray]:
    """Every formation metric of a run, each (runs, robots)."""
    return {name: metric.measure(run) for name, metric in FORMATION_METRICS.items()}
