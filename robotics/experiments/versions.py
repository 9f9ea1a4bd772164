"""The versions, of packages and of files, on which a result depends."""

import hashlib
import sys
from importlib.metadata import version
from pathlib import Path


def digest_of(path: Path) -> str:
    """The SHA-256 of a file, in hexadecimal. Raises OSError."""
    return hashlib.sha256(path.read_bytes()).hexdigest()


def versions() -> dict[str, str]:
    """The versions of the packages on which numbers and pictures depend, and Python's, by name."""
    names = ("fuzzyfleet", "numpy", "numba", "scipy", "pandas", "matplotlib")
    return {name: version(name) for name in names} | {"python": ".".join(map(str, sys.version_info[:3]))}
