"""How long a robot has heard nobody, and the smallest of the values that it has heard.

In equations of one robot ``heard`` is :attr:`robotics.laws.equation.Known.heard` and ``i`` the robot's lane.
"""

from fuzzy.compiled.jit import without_refcounts
from robotics.laws.equation import HeardColumns

OUTAGE = 0.5  # s without a message: the robot is alone, and its watchdog stops it
SEARCH_REACH = 0.5  # m: how far from its last place on the path a robot looks for the next
SEARCH_REACH_AFTER_OUTAGE = 3.0  # m: the same for a robot that was alone


# Of one robot -----------------------------------------------------------------------------------------------------


@without_refcounts
def alone(heard, i, time):  # type: ignore[no-untyped-def]
    """The time [s] since the newest message that the robot heard was sent, at most ``time`` [s]."""
    for j in range(heard.shape[2]):
        one = HeardColumns(heard, i, j)
        if one.hears > 0 and one.age < time:
            time = one.age
    return time


@without_refcounts
def reach(heard, i, time):  # type: ignore[no-untyped-def]
    """The distance [m] from its last place within which the robot looks for the next on its path, at ``time`` [s]."""
    return SEARCH_REACH_AFTER_OUTAGE if alone(heard, i, time) > OUTAGE else SEARCH_REACH


# Of all robots at once --------------------------------------------------------------------------------------------
