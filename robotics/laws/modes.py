"""A robot's operating mode: the codes of Command.mode and Run.modes."""

TRACK, AVOID, FOLLOW, YIELD = range(4)
LEFT_BEHIND = 4  # added to the others: timed out, the group goes on without the robot
STOPPED = 8  # its controller diverged, or it was lost
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
