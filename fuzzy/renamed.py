"""Earlier names of modules: they import as ever, with a DeprecationWarning that says what the module is called now."""

import sys
from collections.abc import Mapping
from importlib import import_module
from importlib.machinery import ModuleSpec
from types import ModuleType
from typing import Any
from warnings import warn

_NOW: dict[str, str] = {}  # today's dotted names by the earlier ones, each with all that is below it
_LASTING: set[str] = set()  # second names, of which nobody is warned


def name_now(name: str) -> str | None:
    """Today's name of a module that had the dotted name ``name``; None if it was never renamed."""
    above = name
    while above and above not in _NOW:
        above = above.rpartition(".")[0]
    if not above:
        return None
    now = _NOW[above] + name[len(above) :]
    return name_now(now) or now  # what was moved twice


class _Renamed:
    """Finds modules by their earlier names, before a second copy is made of the file that they are now."""

    def find_spec(self, name: str, path: Any = None, target: Any = None) -> ModuleSpec | None:
        return ModuleSpec(name, self) if name_now(name) else None  # type: ignore[arg-type]

    def create_module(self, spec: ModuleSpec) -> None:
        return None

    def exec_module(self, module: ModuleType) -> None:
        old, now = module.__name__, str(name_now(module.__name__))
        if old not in _LASTING:
            warn(f"{old} is now called {now}; the old name goes in the next release", DeprecationWarning, stacklevel=2)
        sys.modules[old] = import_module(now)  # which is what the import statement gives


def redirect(table: Mapping[str, str], lasting: Mapping[str, str] | None = None) -> None:
    """Let modules be imported by other dotted names.

    Args:
        table: Today's names by the earlier ones, each with all below it: ``{"fuzzy.loop": "fuzzy.plugins.loop"}``.
        lasting: The same of names that stay beside today's; nobody is warned of them.
    """
    _NOW.update({**table, **(lasting or {})})
    _LASTING.update(lasting or ())
    if not any(isinstance(finder, _Renamed) for finder in sys.meta_path):
        sys.meta_path.insert(0, _Renamed())
