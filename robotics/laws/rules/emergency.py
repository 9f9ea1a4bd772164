"""The emergency rule: a robot stops before what it would touch, whatever its rules say.

A robot that drives at v and brakes by a stands after v t + v²/(2 a), t being the time until a command acts. As long as
the room ahead is larger, it can still stop; the rule lets no command through after which that were not so:

    v ≤ the largest speed with  v t + v²/(2 a) + u (t + v/a) ≤ room − least

u is the speed of the other towards the robot. If all robots obey it and none is faster than it was heard to be, no
robot that moves touches another: each stands before the other arrives, and what stands touches nothing. A team-mate's
room is that between the circles in which the two turn; of obstacles it is what the sensors read.

Two things that follow from what the sensors do not tell:

* A thing that is near and comes nearer may move, from any side. The robot stands until it comes no nearer: then it may
  be run into, but does not drive or turn into a thing that moves.
* There may be no sensor behind. A robot goes back only over ground that it has just driven.
"""

import math
from dataclasses import dataclass, fields

from fuzzy.compiled.columns import Columns, column
from fuzzy.compiled.jit import compiled_only
from fuzzy.quantity import check_quantities, quantity
from robotics.laws.law import ControllerError
from robotics.laws.rules.clearances import SECTOR
from robotics.laws.rules.perception import KNOWN, other_of
from robotics.laws.rules.situation import TeamColumns

TURNING = 0.03  # m: a robot that drives ahead has so much more room than one that turns, whose corners swing out
ASIDE = 0.1  # cosine of the bearing from which on a robot comes no nearer to another by driving on
FAR = 2.0  # m: robots farther away are in nobody's way
UNSURE = 0.1  # of the way that the other has driven since its last message
COMES_NEARER = 0.018  # m: what has come nearer by more within a second comes nearer
SETTLED = 0.008  # m: by less, and it stands


@dataclass(frozen=True, kw_only=True)
class EmergencySettings:
    """The emergency rule's numbers."""

    braking: float = quantity(1.0, "m/s²", above=0)  # a
    delay: float = quantity(0.15, "s", least=0)  # t: a control period, and the wheels' lag
    least: float = quantity(0.02, "m", least=0)  # room that is always left
    near: float = quantity(0.04, "m", least=0)  # for what comes nearer than this the robot stands still
    on: float = quantity(1.0, "1", least=0, most=1)  # 0: it does nothing, to show what the rules do alone

    def __post_init__(self) -> None:
        check_quantities(self, ControllerError)

    @property
    def idle(self) -> frozenset[str]:
        """The numbers that have no effect."""
        return frozenset() if self.on else frozenset({"braking", "delay", "least", "near"})


EmergencyColumns = Columns.named(
    "EmergencyColumns", {f.name: column(f.metadata["unit"]) for f in fields(EmergencySettings)}
)


@compiled_only(forceinline=True)
def kept_safe(v, w, halted, guard, robot, known, table, now, readings):  # type: ignore[no-untyped-def]
    """Bring the command of one robot down to what is safe.

    Args:
        v: The speed wanted [m/s].
        w: The turn rate wanted [rad/s].
        halted: For how long the robot has stood still for what comes nearer [s]; 0: it does not.
        guard: EmergencyColumns.
        robot: RobotColumns.
        known: What the law knows.
        table: What the team knows before the start.
        now: What the robot knows, robotics.laws.rules.perception.PerceivedColumns.
        readings: What it is told of the others, likewise.

    Returns the safe speed and turn rate, and for how long the robot has stood still now.
    """
    if guard.on == 0:
        return v, w, halted
    room, nearing = now.known[KNOWN.room], now.nearing
    begins = room < guard.near and nearing > COMES_NEARER and halted == 0
    goes_on = halted > 0 and nearing > SETTLED
    halted = halted + known.dt if begins or (goes_on and room < 2 * guard.near) else 0.0
    # Where a team-mate is known to be there may be something else as well.
    clear, echoes = now.clear, now.echoes
    left = min(clear[SECTOR.front_left], echoes[SECTOR.front_left])
    right = min(clear[SECTOR.front_right], echoes[SECTOR.front_right])
    behind = min(clear[SECTOR.behind], echoes[SECTOR.behind])
    v = min(v, max(_fastest(guard, min(left, right) + TURNING - guard.least, 0.0), 0.0))
    v = max(v, -max(_fastest(guard, behind - guard.least, 0.0), 0.0))
    if halted > 0:
        v, w = 0.0, 0.0
    if v < 0 and now.known[KNOWN.way_back] <= 0:
        v = 0.0
    forward, limit = -1.0 if v < 0 else 1.0, math.inf
    head, robots = TeamColumns(table), known.heard.shape[2]
    for j in range(robots):
        other = other_of(readings, head, robots, j)
        if other.counts == 0 or not other.gap < FAR:
            continue
        cos = math.cos(other.bearing) * forward
        if not cos > ASIDE:
            continue
        distance = max(other.distance, 1e-6)
        approach = max(-(other.dx * other.v_x + other.dy * other.v_y) / distance, 0.0)
        # An old message says less of where the other is.
        unsure = UNSURE * min(other.age, 1.0) * other.speed
        free = other.gap - guard.least - approach * guard.delay - unsure
        limit = min(limit, _fastest(guard, free, approach) / max(cos, ASIDE))
    v = min(abs(v), limit) * (-1.0 if v < 0 else 1.0)
    return v, w, halted


@compiled_only
def _fastest(guard, room, approach):  # type: ignore[no-untyped-def]
    """The largest v [m/s] with v t + v²/(2 a) + u v/a ≤ ``room`` [m]."""
    b = guard.delay + approach / guard.braking
    return guard.braking * (math.sqrt(b**2 + 2 * max(room, 0.0) / guard.braking) - b)
