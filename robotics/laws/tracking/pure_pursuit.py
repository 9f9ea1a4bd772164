"""Regulated pure pursuit, as Nav2's controller of that name drives, for paths with a timing.

The robot drives along the arc that leads through a point of its path, the carrot, a look-ahead L away:

    κ = 2 y_c / L²,   ω = v κ                         (Coulter 1992), with the carrot at (x_c, y_c) from the robot
    L = T |v|, from L_min to L_max                    (Macenski, Singh, Martín and Ginés 2023)
    v ← v r / r_min where the arc's radius r = 1/|κ| is less than r_min          "regulated", there
    |atan2(y_c, x_c)| > θ: v = 0, ω = ± the turn rate                            rotation in place, there

Near a straight path the lateral poles at a constant speed are those of s² + (2 v/L) s + 2 v²/L²: damping 0.71, and
√2 v/L rad/s, which is √2/T while L = T |v|. So it is the loop of the fuzzy rules with the same look-ahead, whose target
is the reference in T seconds, as long as that is farther than their steering distance
(:mod:`robotics.laws.tracking.fuzzy_tracking`). That is a local certificate, without the wheel lag; from afar
convergence is shown by sampling.

Differences from nav2_regulated_pure_pursuit_controller, whose defaults these are where it has the number:

* Nav2 follows a path without times at ``desired_linear_vel``. Here v = v_d + K (s_d − s), with the abscissa s of the
  nearest point of the path, not below 0: feed-forward and correction as for the other laws. And regulation takes from a
  speed only what exceeds v_d, Nav2's ``regulated_linear_scaling_min_speed``: the timing already says how fast to turn.
* The nearest point is looked for within a metre of the last one, not in a costmap's window. The carrot lies
  √(L² − d²) on along the path, d being the distance to it, which on a straight path is Nav2's point at the distance L.
  Where d exceeds L it is the nearest point itself, as there. Beyond the path's end it lies straight on, as with
  ``interpolate_curvature_after_goal``.
* The speed is not scaled down towards the goal, since the reference comes to rest there, nor by a costmap, nor is the
  rotation in place limited in its acceleration. At the goal the heading is mended by the same rule as elsewhere.
* A turn in place towards what lies behind keeps its side. By the sign of the angle alone a robot whose carrot is
  exactly behind it dithers there for ever, since its turns take effect a period late.

It knows the posture, the speed by the encoders, the reference and the path ahead; not the wheel lag, nor the latency.
"""

import math
from dataclasses import dataclass

import numpy as np

from fuzzy.compiled.columns import Columns, column
from fuzzy.compiled.jit import compiled_only
from fuzzy.quantity import quantity
from robotics.laws.equation import EquationLaw, equation
from robotics.laws.setting import Setting
from robotics.laws.tracking.lyapunov import FEED_FORWARD, FeedForward
from robotics.world.paths.road import at, nearest

_REACH = 1.0  # m: how far from the last nearest point the next one is looked for
NEAREST = 0.05  # m: the bearing of a carrot that is nearer is noise


class PursuitMemory(Columns):
    """What the law remembers."""

    near = column("m", "the abscissa of the nearest point; not-a-number: none is known")
    turning = column("rad/s", "how it turns in place; 0: it does not")


@compiled_only
def carrot(road, path, x, y, near, reach):  # type: ignore[no-untyped-def]
    """The point [m, m] of a path that lies ``reach`` [m] from (x, y), on from the nearest point's abscissa ``near``."""
    to_x, to_y, _, _ = at(road, path, near)
    aside = (to_x - x) * (to_x - x) + (to_y - y) * (to_y - y)
    s = near + math.sqrt(max(reach * reach - aside, 0.0))
    to_x, to_y, heading, _ = at(road, path, s)
    beyond = max(s - road.lengths[path], 0.0)
    return to_x + beyond * math.cos(heading), to_y + beyond * math.sin(heading)


@equation
def pursue(robot, aim, gain, memory, road, path):  # type: ignore[no-untyped-def]
    """Drive along the arc through the carrot, at the regulated speed, or turn towards it."""
    around = aim.s if math.isnan(memory.near) else memory.near
    near = nearest(road, path, robot.x, robot.y, around, _REACH)
    memory.near = near
    reach = max(min(gain.look_ahead * abs(robot.v), gain.look_ahead_most), gain.look_ahead_least)
    to_x, to_y = carrot(road, path, robot.x, robot.y, near, reach)
    cos, sin = math.cos(robot.heading), math.sin(robot.heading)
    dx, dy = to_x - robot.x, to_y - robot.y
    ahead, aside = cos * dx + sin * dy, cos * dy - sin * dx
    angle = math.atan2(aside, ahead)
    if abs(angle) > gain.rotate_from:
        turning = memory.turning if memory.turning != 0 and abs(angle) > math.pi / 2 else angle
        memory.turning = math.copysign(gain.turn_rate, turning)
        return 0.0, memory.turning
    memory.turning = 0.0
    curvature = 2 * aside / max(dx * dx + dy * dy, NEAREST * NEAREST)
    full = 1.0 if gain.feed_forward == FEED_FORWARD.full else 0.0
    v = max(full * aim.v + gain.kx * (aim.s - near), 0.0)
    regulated = v / max(abs(curvature) * gain.radius, 1.0)
    v = max(regulated, min(v, aim.v))
    return v, v * curvature


@dataclass(frozen=True, kw_only=True)
class PurePursuit(EquationLaw):
    """Regulated pure pursuit: how far it looks ahead, and how it regulates its speed. Default: Nav2's numbers."""

    look_ahead: float = quantity(1.5, "s", least=0, most=10)  # T; lookahead_time
    look_ahead_least: float = quantity(0.3, "m", least=NEAREST)  # L_min; min_lookahead_dist
    look_ahead_most: float = quantity(0.9, "m", least=NEAREST)  # L_max, if that is more; max_lookahead_dist
    kx: float = quantity(1.0, "1/s", least=0)  # K, of the way that it is behind; Lyapunov's
    radius: float = quantity(0.9, "m", least=0)  # r_min; regulated_linear_scaling_min_radius
    rotate_from: float = quantity(0.785, "rad", above=0, most=math.pi)  # θ; rotate_to_heading_min_angle
    turn_rate: float = quantity(1.8, "rad/s", above=0)  # rotate_to_heading_angular_vel
    feed_forward: FeedForward = "full"  # none: v = K (s_d − s)

    equation, remembers = pursue, PursuitMemory
    knows = ("reference", "reference velocity", "preview", "wheel speeds")

    def begin(self, setting: Setting, runs: int) -> np.ndarray:
        """Begin with no nearest point known, and not turning."""
        memory = PursuitMemory.zeros(runs, len(setting.robots))
        memory.near = np.nan
        return memory.array
