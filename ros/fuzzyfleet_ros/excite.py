"""The command that drives a minute that tells most of a robot, records it, and identifies the robot from it.

python -m fuzzyfleet_ros.excite --ros-args -p robot:=turtlebot3-burger -p square:=3.0 -p out:=myrobot.toml
"""

import sys
from collections.abc import Sequence

from fuzzyfleet_ros.starting import start


def main(arguments: Sequence[str] | None = None) -> int:
    """Run the node; return the exit status."""
    return start("excite", "Exciter", arguments)


if __name__ == "__main__":
    sys.exit(main())
