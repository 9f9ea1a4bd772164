"""A robot's operating mode: the codes of Command.mode and Run.modes."""

TRACK, AVOID, FOLLOW, YIELD = range(4)
LEFT_BEHIND = 4  # added to one of those: the robot timed out, and the group goes on without it
STOPPED = 8  # the robot's controller diverged, or the robot was lost
MODES = (
    "tracking",
    "avoiding",
    "following the wall",
    "yielding",
    "tracking, left behind",
    "avoiding, left behind",
    "following the wall, left behind",
    "yielding, left behind",
    "stopped",
)
