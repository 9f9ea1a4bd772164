"""Names of a package that are imported from their modules when they are first used, so that a command line is quick.

The three packages share it: ``dir()``, tab completion and ``help()`` show all names, and nothing else. The names stand
once, in the stub ``__init__.pyi`` beside ``__init__.py`` (scientific Python's SPEC 1), which type checkers read too.
"""

import os
from collections.abc import Callable
from importlib import import_module
from typing import Any

from fuzzy.renamed import name_now


def lazy_names(package: str) -> tuple[Callable[[str], object], Callable[[], list[str]], list[str]]:
    """The functions ``__getattr__`` and ``__dir__`` of a package, PEP 562, and its ``__all__``.

    A submodule is imported when it is first used as well: ``robotics.laws.catalogue`` after ``import robotics``. The
    names of a plug-in, a folder in ``plugins``, are left out where it is not installed; who asks for one is told so.

    Args:
        package: Its name. Each line of its stub is a public name and the module that defines it:
            ``from fuzzy.rule import Rule as Rule``.
    """
    module: Any = import_module(package)
    stub = f"{module.__file__.rpartition('.')[0]}.pyi"
    # Read by words: to parse it would double the time of an import.
    lines = module.__loader__.get_data(stub).decode().splitlines()
    home = {name: source for _, source, _, name, *_ in map(str.split, lines)}
    plugins = {name: source.split(".")[2] for name, source in home.items() if ".plugins." in source}
    folder = f"{module.__path__[0]}/plugins"
    missing = {name: each for name, each in plugins.items() if not os.path.isdir(f"{folder}/{each}")}  # noqa: PTH112
    there = sorted(home.keys() - missing.keys())

    def submodules() -> set[str]:
        from pkgutil import iter_modules  # which takes a third of the time of importing a package

        return {found.name for found in iter_modules(module.__path__) if found.name[0] != "_"}

    def get(name: str) -> object:
        if name in missing:
            plugin = f"{package}.plugins.{missing[name]}"
            raise ModuleNotFoundError(f"{package}.{name} needs the plug-in {plugin}, which is not installed")
        if name in home:
            found: object = getattr(import_module(home[name]), name)
            return found
        if name[0] != "_" and (name in submodules() or name_now(f"{package}.{name}")):
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
        return sorted({*there, *submodules()})

    return get, names, there
