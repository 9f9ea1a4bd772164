"""The emergency rule: a robot stops before what it would touch, whatever its rules say.

A robot that drives at v and brakes by a stands after v t + v²/(2 a), t being the time until a command acts. As long as
the room ahead is larger, it can still stop; the rule lets no command through after which that were not so:

    v ≤ the largest speed with  v t + v²/(2 a) + u (t + v/a) ≤ room − least

u is the speed of the other towards the robot. If all robots obey it and none is faster than it was heard to be, no
robot that moves touches another: each stands before the other arrives, and what stands touches nothing. A team-mate's
room is that between the circles in which the two turn; of obstacles it is what the sensors read.
"""

from dataclasses import dataclass

import numpy as np

from robotics.laws.law import ControllerError, Observation
from robotics.laws.rules.clearances import FRONT_LEFT, FRONT_RIGHT
from robotics.laws.rules.situation import Others
from robotics.quantity import check_quantities, quantity

TURNING = 0.03  # m: a robot that drives ahead has so much more room than one that turns, whose corners swing out
ASIDE = 0.1  # cosine of the bearing from which on a robot comes no nearer to another by driving on
FAR = 2.0  # m: robots farther away are in nobody's way
UNSURE = 0.1  # of the way that the other has driven since its last message


@dataclass(frozen=True, kw_only=True)
class Guard:
    """The emergency rule's numbers."""

    braking: float = quantity(1.0, "m/s²", above=0)  # a
    delay: float = quantity(0.15, "s", least=0)  # t: a control period, and the wheels' lag
    least: float = quantity(0.02, "m", least=0)  # room that is always left
    on: float = quantity(1.0, "1", least=0, most=1)  # 0: it does nothing, to show what the rules do alone

    def __post_init__(self) -> None:
        check_quantities(self, ControllerError)

    @property
    def idle(self) -> frozenset[str]:
        """The numbers that have no effect."""
        return frozenset() if self.on else frozenset({"braking", "delay", "least"})

    def kept(self, seen: Observation, them: Others, clear: np.ndarray, v: np.ndarray) -> np.ndarray:
        """The speeds ``v`` [m/s] (runs, robots) brought down to what is safe.

        ``them`` are the other robots, ``clear`` the clearances [m] (sectors, runs, robots) of
        :mod:`robotics.laws.rules.clearances`.
        """
        if not self.on:
            return v
        front = np.minimum(clear[FRONT_LEFT], clear[FRONT_RIGHT]) + TURNING
        v = np.minimum(v, np.maximum(self._fastest(front - self.least, 0.0), 0.0))
        if not seen.heard.fields:
            return v
        forward = np.sign(np.where(v == 0, 1.0, v))[:, :, None]
        cos = np.cos(them.bearing) * forward
        dx, dy = them.x - seen.x[:, :, None], them.y - seen.y[:, :, None]
        distance = np.maximum(np.hypot(dx, dy), 1e-6)
        approach = np.maximum(-(dx * them.v_x + dy * them.v_y) / distance, 0.0)
        # An old message says less of where the other is.
        unsure = UNSURE * np.minimum(them.age, 1.0) * np.hypot(them.v_x, them.v_y)
        room = them.gap - self.least - approach * self.delay - unsure
        fastest = self._fastest(room, approach) / np.maximum(cos, ASIDE)
        limit = np.where((cos > ASIDE) & (them.gap < FAR), fastest, np.inf).min(axis=-1)
        return np.asarray(np.sign(v) * np.minimum(np.abs(v), limit))

    def _fastest(self, room: np.ndarray, approach: np.ndarray | float) -> np.ndarray:
        """The largest v [m/s] with v t + v²/(2 a) + u v/a ≤ ``room`` [m]."""
        b = self.delay + np.asarray(approach) / self.braking
        root = np.sqrt(b**2 + 2 * np.maximum(room, 0.0) / self.braking)
        return np.asarray(self.braking * (root - b))
