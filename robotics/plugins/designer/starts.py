"""The starts that robotics offers for a new rule base: tracking, and following a wall."""

from functools import partial

from fuzzy.plugins.designer.starts.packaged import packaged
from fuzzy.plugins.designer.starts.start import Start

ROBOTS = "Robots"


def starts() -> list[Start]:
    """The shipped rule bases with which a robot's own begins best."""
    return [
        Start(
            "tracking",
            ROBOTS,
            "Tracking a path",
            "The rules of fuzzy tracking: v and w from the distance and bearing of a target that moves along a path.",
            partial(packaged, "tracking"),
            own_name=True,
        ),
        Start(
            "wall-follower",
            ROBOTS,
            "Wall follower",
            "Follows a wall on its right with range sensors: v and w from the room on the right, ahead, and between.",
            partial(packaged, "wall-follower"),
            own_name=True,
        ),
    ]
