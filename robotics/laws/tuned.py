"""Laws at their best: presets whose gains and rule bases a search has found, as data in ``tuned.toml``."""

from collections.abc import Mapping
from dataclasses import replace
from functools import cache
from importlib import resources
from typing import Any

from robotics.laws.law import ControllerError, Preset
from robotics.tables.text import parse_table

FILE = "tuned.toml"


def tuned_presets(catalogue: Mapping[str, Preset]) -> dict[str, Preset]:
    """The presets of the file, by name: each is one of the ``catalogue`` with other gains; others are left out.

    Raises ControllerError for a file that has been spoilt.
    """
    found = {}
    for name, about in _tables().items():
        base = catalogue.get(about.get("of", ""))
        if not isinstance(about.get("of"), str) or not isinstance(about.get("gains"), dict):
            raise ControllerError(f"{FILE}: {name} needs of = a law of the catalogue, and a table gains")
        if base is None:  # of a plug-in that is not installed
            continue
        gains = base.gains | about["gains"]
        found[name] = replace(base, gains=gains, title=f"{base.title}, tuned", note=str(about.get("note", "")))
    return found


def tuned_from() -> dict[str, str]:
    """The law of the catalogue of which each tuned one has other gains, by name."""
    return {name: str(about.get("of", "")) for name, about in _tables().items()}


@cache
def _tables() -> dict[str, dict[str, Any]]:
    text = (resources.files("robotics") / "laws" / FILE).read_text(encoding="utf-8")
    return parse_table(text, FILE, ControllerError)
