"""Leader-follower formations, thesis 5.2: the scenario.

Robot 1 leads. The sine of the thesis's figures is lost; the centers of its Tables 5.2 and 5.3 lie on y = 0.5 cos x,
and its initial poses [-3, 0.5, 0] and [3, -0.5, 0] on it too if a straight line y = 0.5 leads in before x = 0. The
followers drive the same curve one metre to the left and to the right, from x = 0.

A formation has no reference in time. Each robot's trajectory runs along its own path with the desired speed from
x = 0 on, so the leader's reference drives beside the followers'; the laws of
:mod:`robotics.laws.formation.leader_follower` use the paths only. A run counts until the leader reaches the end of
its path, where all robots stop.
"""

from math import pi

import numpy as np

from robotics.simulation.scenario.description import Member, Scenario
from robotics.world.paths.path import Sine
from robotics.world.paths.trajectory import Timing
from robotics.world.sensing.posture import Sensing

# y = 0.5 cos x, fitted to the centers of Tables 5.2 and 5.3
AMPLITUDE = 0.5  # m
WAVENUMBER = 1.0  # rad/m
PERIOD = 2 * pi  # m
_SIDES = (1.0, -1.0)  # m, the followers' offsets in y: [0, 1.5, 0] and [0, -0.5, 0]


def leader_path(end: float = PERIOD, lead_in: float = 4.0) -> Sine:
    """The leader's path: y = 0.5 cos x up to x = ``end`` [m], after a straight line of ``lead_in`` metres."""
    return Sine(amplitude=AMPLITUDE, wavenumber=WAVENUMBER, phase=pi / 2, x_end=end, lead_in=lead_in)


def formation_scenario(start: float, speed: float = 0.1, end: float = PERIOD) -> Scenario:
    """Make a formation whose leader begins at x = ``start`` [m] on its path, and whose followers begin at x = 0.

    The plant is the kinematic one, so that a robot that knows its path stays on it: samples of such a run show the law,
    not the wheels' lag. The scenario lasts until the teacher's leader has arrived under either of its ``speeds``.

    Args:
        start: The leader's x at the start [m].
        speed: v_d [m/s].
        end: The x at which the paths end [m].

    Returns:
        The scenario.
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
        for side in _SIDES
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
