"""What every benchmark says of the machine, and how it is started: a table, or one JSON object with --json."""

import argparse
import importlib.metadata
import json
import platform
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any


def processor() -> str:
    """The processor's name, as far as the system tells."""
    info = Path("/proc/cpuinfo")
    if info.exists():
        for line in info.read_text().splitlines():
            if line.startswith("model name"):
                return line.partition(":")[2].strip()
    return platform.processor() or platform.machine()


def versions(packages: Sequence[str]) -> dict[str, str]:
    """The installed version of each package, or "not installed"."""
    found = {}
    for package in packages:
        try:
            found[package] = importlib.metadata.version(package)
        except importlib.metadata.PackageNotFoundError:
            found[package] = "not installed"
    return found


def machine(packages: Sequence[str]) -> dict[str, Any]:
    """Processor, Python and packages: what a time means nothing without."""
    return {"processor": processor(), "python": platform.python_version(), "versions": versions(packages)}


def heading(result: dict[str, Any]) -> str:
    """The line above a table, of what :func:`machine` found."""
    listed = ", ".join(f"{name} {version}" for name, version in result["versions"].items())
    return f"{result['processor']}; Python {result['python']}, {listed}"


def start(
    text: str | None,
    measure: Callable[..., dict[str, Any]],
    report: Callable[[dict[str, Any]], str],
    quick: str | None = None,
) -> None:
    """The command line of a benchmark whose module says ``text`` of itself.

    With ``quick``, which says what is then left out, there is an option --quick: ``measure`` takes a Boolean of it.
    """
    parser = argparse.ArgumentParser(description=(text or "").partition("\n")[0])
    parser.add_argument("--json", action="store_true", help="print one JSON object instead of a table")
    if quick is not None:
        parser.add_argument("--quick", action="store_true", help=quick)
    arguments = parser.parse_args()
    result = measure() if quick is None else measure(arguments.quick)
    print(json.dumps(result) if arguments.json else report(result))
