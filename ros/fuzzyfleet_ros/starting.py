"""How a command starts: with its node, or with a sentence that says what is missing."""

import importlib
import sys
from collections.abc import Sequence

ROS = ("rclpy", "geometry_msgs", "nav_msgs", "rosgraph_msgs", "sensor_msgs")


def missing(modules: Sequence[str]) -> str:
    """What must be installed before any of ``modules`` can be imported, in a sentence; nothing: all can be."""
    for module in modules:
        try:
            importlib.import_module(module)
        except ImportError as error:
            failed = f"{module} cannot be imported ({error})"
            if module not in ROS:
                return f"{failed}; install fuzzyfleet for this Python, {sys.executable}"
            return f"{failed}; source the setup file of a ROS 2 installation, or {_wheels()}"
    return ""


def _wheels() -> str:
    """The command that installs wheels of ROS 2."""
    from fuzzy.extras import install_command

    try:
        return install_command("ros")
    except KeyError:  # a fuzzyfleet of before
        return "install the extra ros of fuzzyfleet"


def start(program: str, node: str, arguments: Sequence[str] | None = None) -> int:
    """Run the class ``node`` of the module ``<program>node``; return the exit status.

    Args:
        program: The name of the command.
        node: The name of the class.
        arguments: With the program's name first; by default ``sys.argv``.
    """
    if lacks := missing(("fuzzy", "robotics", *ROS)):
        print(f"{program}: {lacks}", file=sys.stderr)
        return 2
    run = importlib.import_module("fuzzyfleet_ros.running").run
    made = getattr(importlib.import_module(f"fuzzyfleet_ros.{program}node"), node)
    return int(run(made, program, arguments))
