"""The command that starts the simulator as a node.

python -m fuzzyfleet_ros.simulator --ros-args -p scenario:=reference
"""

import sys
from collections.abc import Sequence

from fuzzyfleet_ros.starting import start


def main(arguments: Sequence[str] | None = None) -> int:
    """Run the node; return the exit status."""
    return start("simulator", "Simulator", arguments)


if __name__ == "__main__":
    sys.exit(main())
