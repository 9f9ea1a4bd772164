"""The versions, of packages and of files, on which a result depends."""

import hashlib
import json
import sys
from importlib.metadata import version
from pathlib import Path
from typing import Any


def digest_of(path: Path) -> str:
    """The SHA-256 of a file, in hexadecimal. Raises OSError."""
    return hashlib.sha256(path.read_bytes()).hexdigest()


def digest(value: Any) -> str:
    """The SHA-256 of a value in JSON's types, in hexadecimal."""
    text = json.dumps(value, sort_keys=True, ensure_ascii=False, default=str)
    return hashlib.sha256(text.encode()).hexdigest()


def versions(*packages: str) -> dict[str, str]:
    """The versions of ``packages``; by default of those on which numbers and pictures depend, and of Python."""
    if packages:
        return {name: version(name) for name in packages}
    python = {"python": ".".join(map(str, sys.version_info[:3]))}
    return versions("fuzzyfleet", "numpy", "numba", "scipy", "pandas", "matplotlib") | python
