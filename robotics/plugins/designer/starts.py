"""The starts that robotics offers for a new rule base: tracking, and following a wall."""

from functools import partial

from fuzzy.plugins.designer.starts.packaged import packaged
from fuzzy.plugins.designer.starts.start import Start

ROBOTS = "Robots"


def starts() -> list[Start]:
    """The shipped rule bases with which a robot's own begins best."""
    tracking = "The rules of fuzzy tracking: v and w from the distance and bearing of a target that moves along a path."
    wall = "Follows a wall on its right with range sensors: v and w from the room on the right, ahead, and between."
    shipped = (("tracking", "Tracking a path", tracking), ("wall-follower", "Wall follower", wall))
    return [Start(name, ROBOTS, title, about, partial(packaged, name), own_name=True) for name, title, about in shipped]
