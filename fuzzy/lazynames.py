"""Names of a package that are imported from their modules when they are first used, so that a command line is quick.

The three packages share it: ``dir()``, tab completion and ``help()`` show all names, and nothing else. The names stand
once, in the stub ``__init__.pyi`` beside ``__init__.py`` (scientific Python's SPEC 1), which type checkers read too.
"""

import sys
import warnings
from collections.abc import Callable, Mapping
from importlib import import_module
from importlib.machinery import ModuleSpec
from types import ModuleType
from typing import Any


class MovedModules:
    """Finds modules by the names that they had before they were moved: the same modules, not copies.

    It stands in ``sys.meta_path`` before what looks into folders. Whoever imports by a former name is warned.
    """

    def __init__(self, moved: Mapping[str, str], kept: tuple[str, ...]) -> None:
        self._moved, self._kept = moved, kept

    def find_spec(self, name: str, path: object = None, target: object = None) -> ModuleSpec | None:
        """The spec of a module by its former name, None by any other."""
        return ModuleSpec(name, self) if _room(name) in self._moved else None  # type: ignore[arg-type]

    def create_module(self, spec: ModuleSpec) -> None:
        """Nothing: Python makes an empty module, in whose place :meth:`exec_module` puts the one that is meant."""

    def exec_module(self, module: ModuleType) -> None:
        """Import the module by its name of today."""
        former = module.__name__
        name = self._moved[_room(former)] + former.removeprefix(_room(former))
        if former not in self._kept:
            warnings.warn(f"{former} is now {name}", DeprecationWarning, stacklevel=2)
        sys.modules[former] = import_module(name)


def _room(name: str) -> str:
    """The first two words of a module's name."""
    return ".".join(name.split(".")[:2])


def lazy_names(
    package: str, moved: Mapping[str, str] | None = None, kept: tuple[str, ...] = ()
) -> tuple[Callable[[str], object], Callable[[], list[str]], list[str]]:
    """The functions ``__getattr__`` and ``__dir__`` of a package, PEP 562, and its ``__all__``.

    A submodule is imported when it is first used as well: ``robotics.laws.catalogue`` after ``import robotics``.

    Args:
        package: Its name. Each line of its stub is a public name and the module that defines it:
            ``from fuzzy.rule import Rule as Rule``.
        moved: The former names of folders and modules in it and those of today, in full:
            ``{"robotics.paths": "robotics.world.paths"}``.
        kept: Those of the former names that stay good, of which nobody is warned.
    """
    module: Any = import_module(package)
    stub = f"{module.__file__.rpartition('.')[0]}.pyi"
    # Read by words: to parse it would double the time of an import.
    lines = module.__loader__.get_data(stub).decode().splitlines()
    home = {name: source for _, source, _, name, *_ in map(str.split, lines)}
    moved = moved or {}
    sys.meta_path.insert(0, MovedModules(moved, kept))

    def submodules() -> set[str]:
        from pkgutil import iter_modules  # which takes a third of the time of importing a package

        return {found.name for found in iter_modules(module.__path__) if found.name[0] != "_"}

    def get(name: str) -> object:
        if name in home:
            found: object = getattr(import_module(home[name]), name)
            return found
        if name[0] != "_" and (f"{package}.{name}" in moved or name in submodules()):
            return import_module(f"{package}.{name}")
        raise AttributeError(f"module {package!r} has no attribute {name!r}{_hint(name)}")

    def _hint(name: str) -> str:
        """What was probably meant by a name; nothing of what Python and notebooks ask every object for."""
        if name[0] == "_":
            return ""
        from difflib import get_close_matches

        close = get_close_matches(name, names(), n=1, cutoff=0.7)
        return f"; did you mean {close[0]!r}?" if close else ""

    def names() -> list[str]:
        return sorted({*home, *submodules()})

    return get, names, sorted(home)
