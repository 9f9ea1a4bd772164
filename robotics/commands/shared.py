"""What several commands share: options, versions, and how a divergence is reported."""

import sys
from typing import Annotated

import typer

from fuzzy.shell.terminal import USAGE

Json = Annotated[bool, typer.Option("--json", help="Print one JSON object instead of text.")]
Quiet = Annotated[bool, typer.Option("--quiet", "-q", help="No progress bar.")]


def versions() -> dict[str, str]:
    """The versions that a result depends on."""
    from importlib.metadata import version

    names = ("fuzzyfleet", "numpy", "numba", "scipy", "pandas", "matplotlib")
    return {name: version(name) for name in names} | {"python": ".".join(map(str, sys.version_info[:3]))}


def report_divergences(lines: list[str]) -> None:
    """Say on stderr which robots were stopped, if any, and exit with 2."""
    if lines:
        more = f" (and {len(lines) - 1} more)" if len(lines) > 1 else ""
        print(f"robotics: {lines[0]}{more}; what it did until then is kept", file=sys.stderr)
        raise typer.Exit(USAGE)
