"""The command that drives one robot by a law.

python -m fuzzyfleet_ros.controller --ros-args -p law:=fuzzy -p scenario:=reference
"""

import sys
from collections.abc import Sequence

from fuzzyfleet_ros.starting import start


def main(arguments: Sequence[str] | None = None) -> int:
    """Run the node; return the exit status."""
    return start("controller", "Controller", arguments)


if __name__ == "__main__":
    sys.exit(main())
