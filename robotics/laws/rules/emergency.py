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

    def kept(
        self, seen: Observation, them: Others, clear: np.ndarray, radii: np.ndarray, v: np.ndarray, w: np.ndarray
    ) -> tuple[np.ndarray, np.ndarray]:
        """The commands ``v`` [m/s] and ``w`` [rad/s] (runs, robots), brought down to what is safe.

        ``them`` are the other robots, ``clear`` the clearances [m] (sectors, runs, robots) of
        :mod:`robotics.laws.rules.clearances`.
        """
        if not self.on:
            return v, w
        front = np.minimum(clear[FRONT_LEFT], clear[FRONT_RIGHT]) + 0.03
        v = np.minimum(v, np.maximum(self._fastest(front - self.least, 0.0), 0.0))
        if not seen.heard.fields:
            return v, w
        forward = np.sign(np.where(v == 0, 1.0, v))[:, :, None]
        cos = np.cos(them.bearing) * forward
        theirs = np.hypot(them.v_x, them.v_y)
        dx, dy = them.x - seen.x[:, :, None], them.y - seen.y[:, :, None]
        distance = np.maximum(np.hypot(dx, dy), 1e-6)
        approach = np.maximum(-(dx * them.v_x + dy * them.v_y) / distance, 0.0)
        late = np.minimum(np.nan_to_num(seen.heard.age, posinf=0.0), 1.0)
        room = them.gap - self.least - approach * self.delay - 0.1 * late * theirs
        fastest = self._fastest(room, approach) / np.maximum(cos, 1e-3)
        limit = np.where((cos > 0.1) & (np.nan_to_num(them.gap, nan=np.inf) < 2.0), np.maximum(fastest, 0.0), np.inf)
        limit = limit.min(axis=-1)
        return np.sign(v) * np.minimum(np.abs(v), limit), w

    def _fastest(self, room: np.ndarray, approach: np.ndarray | float) -> np.ndarray:
        """The largest v [m/s] with v t + v²/(2 a) + u v/a ≤ ``room`` [m]."""
        b = self.delay + np.asarray(approach) / self.braking
        root = np.sqrt(b**2 + 2 * np.maximum(room, 0.0) / self.braking)
        return np.asarray(self.braking * (root - b))
