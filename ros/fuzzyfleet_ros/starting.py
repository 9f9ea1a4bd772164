"""How a command starts its node, or says that ROS is missing."""

import importlib
import sys
from collections.abc import Sequence

from fuzzy.extras import install_command


def start(program: str, node: str, arguments: Sequence[str] | None = None) -> int:
    """Run the class ``node`` of the module ``<program>node``; return the exit status.

    Args:
        program: The name of the command.
        node: The name of the class.
        arguments: With the program's name first; by default ``sys.argv``.
    """
    for module in ("rclpy", "geometry_msgs", "nav_msgs", "rosgraph_msgs", "sensor_msgs"):
        try:
            importlib.import_module(module)
        except ImportError as error:
            print(
                f"{program}: {module} cannot be imported ({error}); source the setup file of a ROS 2 installation, or "
                f"{install_command('ros')}",
                file=sys.stderr,
            )
            return 2
    run = importlib.import_module("fuzzyfleet_ros.running").run
    made = getattr(importlib.import_module(f"fuzzyfleet_ros.{program}node"), node)
    return int(run(made, program, arguments))
