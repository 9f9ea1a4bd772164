"""The types of messages in a log: those of a ROS 2 distribution, and our own, ``fuzzyfleet_msgs``."""

from functools import cache
from pathlib import Path
from typing import Any

from fuzzy.errors import InputError
from fuzzy.extras import install_command
from fuzzy.naming import check_known

OWN = "fuzzyfleet_msgs"
DEFINITIONS = Path(__file__).parent / OWN
# The distributions that can be written, with the version of rosbag2's metadata that each reads: dashing to foxy are
# long over, and readers of older ones refuse the newer metadata.
DISTRIBUTIONS = {"humble": 8, "iron": 8, "jazzy": 9, "kilted": 9}
DEFAULT_DISTRIBUTION = "jazzy"


class LogError(InputError):
    """A log that cannot be written or read. The message says which, why, and what is accepted."""


def check_distribution(distribution: str) -> None:
    """Raise LogError for a distribution that is not known."""
    check_known(distribution, DISTRIBUTIONS, "ROS 2 distribution", LogError)


def check_installed() -> None:
    """Raise LogError, with the command that installs it, unless the package rosbags is there."""
    try:
        import rosbags.typesys  # noqa: F401
    except ImportError:
        raise LogError(f"logs need the package rosbags: {install_command('logs')}") from None


@cache
def typestore(distribution: str = DEFAULT_DISTRIBUTION) -> Any:
    """The typestore of ``rosbags`` with the messages of a distribution and our own. Raises LogError."""
    check_distribution(distribution)
    check_installed()
    from rosbags.typesys import Stores, get_types_from_msg, get_typestore

    store = get_typestore(Stores[f"ROS2_{distribution.upper()}"])
    types: dict[str, Any] = {}
    for file in sorted(DEFINITIONS.glob("*.msg")):
        types |= get_types_from_msg(file.read_text(encoding="utf-8"), f"{OWN}/msg/{file.stem}")
    store.register(types)
    return store
