"""The command that records a drive that others command, and identifies the robot from it.

python -m fuzzyfleet_ros.identify --ros-args -p robot:=turtlebot3-burger -p out:=myrobot.toml
"""

import sys
from collections.abc import Sequence

from fuzzyfleet_ros.starting import start


def main(arguments: Sequence[str] | None = None) -> int:
    """Run the node; return the exit status."""
    return start("identify", "Identifier", arguments)


if __name__ == "__main__":
    sys.exit(main())
