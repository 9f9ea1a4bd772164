"""A control law of one's own, ready to drive: change what control() computes.

robotics run lyapunov-sine --law mylaw.py:MyLaw:gain=3
robotics compare lyapunov-sine --controllers lyapunov --law mylaw.py:MyLaw --seeds 5
"""

from dataclasses import dataclass

import numpy as np

import robotics


# A law is a frozen dataclass of gains; what it remembers is passed in and handed back, here nothing (None); otherwise
# init(setting, runs) returns with what it begins. Compiled, as an equation of one robot, it is a hundred times faster
# for many runs: the page "Your own rule base, law and metric" shows both forms.
@dataclass(frozen=True, kw_only=True)
class MyLaw(robotics.Law[None]):
    """Turn towards a point ahead of the target, and drive there."""

    gain: float = 2.0  # 1/s: turn rate for each radian of the bearing, beside that of the target
    ahead: float = 0.3  # m: how far ahead of the target the point lies
    top: float = 0.6  # m/s: the highest speed

    def control(self, seen: robotics.Observation, memory: None, dt: float) -> tuple[robotics.Command, None]:
        """Return the command for what the robots have seen; every array is (runs, robots), units are SI."""
        target = seen.reference  # where each robot shall be now: x, y, heading, v, w
        dx, dy = target.x - seen.x, target.y - seen.y
        ahead = np.cos(seen.heading) * dx + np.sin(seen.heading) * dy  # m: the target is so far ahead,
        left = np.cos(seen.heading) * dy - np.sin(seen.heading) * dx  # m: and so far to the left
        v = np.clip(target.v + ahead, 0.0, self.top)
        w = target.w + self.gain * np.arctan2(left, ahead + self.ahead)
        # The speeds that the wheels are to drive, and those that the law wants; a law of torques differs in these.
        return robotics.Command(v, w, v, w), memory
