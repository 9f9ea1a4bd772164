"""The laws by name, as data: those that come with the package in ``presets.toml``, at their best in ``tuned.toml``."""

from collections.abc import Mapping
from dataclasses import replace
from functools import cache
from importlib import import_module, resources
from typing import Any

from robotics.laws.law import ControllerError, Preset
from robotics.tables.text import parse_table

_PUBLISHED, _TUNED = "presets.toml", "tuned.toml"


def published_presets() -> dict[str, Preset]:
    """The presets with the gains of their sources, by name. Raises ControllerError for a file that has been spoilt."""
    found = {}
    for name, about in _tables(_PUBLISHED).items():
        try:
            module, _, law = about["law"].partition(":")
            rest = {key: value for key, value in about.items() if key != "law"}
            found[name] = Preset(getattr(import_module(module), law), **{"gains": {}, **rest})
        except (AttributeError, ImportError, KeyError, TypeError) as error:
            raise ControllerError(f"{_PUBLISHED}: {name} is no preset: {error}") from None
    return found


def tuned_presets(catalogue: Mapping[str, Preset]) -> dict[str, Preset]:
    """The presets that a search has found, by name: each is one of the ``catalogue`` with other gains.

    Those of laws that are not there are left out. Raises ControllerError for a file that has been spoilt.
    """
    found = {}
    for name, about in _tables(_TUNED).items():
        base = catalogue.get(about.get("of", ""))
        if not isinstance(about.get("of"), str) or not isinstance(about.get("gains"), dict):
            raise ControllerError(f"{_TUNED}: {name} needs of = a law of the catalogue, and a table gains")
        if base is None:  # of a plug-in that is not installed
            continue
        gains = base.gains | about["gains"]
        found[name] = replace(base, gains=gains, title=f"{base.title}, tuned", note=str(about.get("note", "")))
    return found


def tuned_from() -> dict[str, str]:
    """The law of the catalogue of which each tuned one has other gains, by name."""
    return {name: str(about.get("of", "")) for name, about in _tables(_TUNED).items()}


@cache
def _tables(file: str) -> dict[str, dict[str, Any]]:
    text = (resources.files("robotics") / "laws" / file).read_text(encoding="utf-8")
    return parse_table(text, file, ControllerError)
