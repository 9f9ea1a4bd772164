"""The names of topics and frames in a log: those that ROS 2 nodes of such robots use.

A single robot has no namespace; robot 2 of a team has ``/robot2``, and its frames begin with ``robot2/``.
"""

import re
from typing import NamedTuple

MAP = "map"  # the frame in which all robots and obstacles stand
INFO, TRANSFORMS, STATIC_TRANSFORMS, SCENE = "/run_info", "/tf", "/tf_static", "/scene"
WHEELS = ("wheel_left_joint", "wheel_right_joint")


def token(name: str) -> str:
    """``name`` as a part of a topic's name, which holds letters, digits and underscores: front_left for front-left."""
    made = re.sub(r"[^A-Za-z0-9_]", "_", name)
    return made if made[:1].isalpha() else f"_{made}"


class Names(NamedTuple):
    """The topics and frames of one robot."""

    namespace: str  # "" or "/robot2"

    @classmethod
    def of(cls, robot: int, robots: int) -> "Names":
        """Those of robot number ``robot``, from 1, of so many."""
        return cls("" if robots == 1 else f"/robot{robot}")

    def topic(self, name: str) -> str:
        """The topic ``name`` of this robot."""
        return f"{self.namespace}/{name}"

    def frame(self, name: str) -> str:
        """The frame ``name`` of this robot: odom, base_link, base_link_true, or that of a sensor."""
        return f"{self.namespace}/{name}".removeprefix("/")

    def reading(self, sensor: str) -> str:
        """The topic of a range sensor."""
        return self.topic(f"range/{token(sensor)}")


def rule_base(task: str) -> str:
    """The topic on which the rule base of a task stands, once for all robots."""
    return f"/rule_base/{token(task)}"


def firing(names: Names, task: str) -> str:
    """The topic on which the firing strengths of that rule base stand."""
    return names.topic(f"firing/{token(task)}")
