"""The versions on which a result depends."""

import sys
from importlib.metadata import version


def versions() -> dict[str, str]:
    """The versions of the packages on which numbers and pictures depend, and Python's, by name."""
    names = ("fuzzyfleet", "numpy", "numba", "scipy", "pandas", "matplotlib")
    return {name: version(name) for name in names} | {"python": ".".join(map(str, sys.version_info[:3]))}
