"""Names of a package that are imported from their modules when they are first used, so that a command line is quick.

The three packages share it: ``dir()``, tab completion and ``help()`` show all names, and nothing else.
"""

from collections.abc import Callable, Mapping
from importlib import import_module


def lazy_names(
    package: str, homes: Mapping[str, tuple[str, ...]]
) -> tuple[Callable[[str], object], Callable[[], list[str]]]:
    """The functions ``__getattr__`` and ``__dir__`` of a package, PEP 562.

    A submodule is imported when it is first used as well: ``robotics.laws.catalogue`` after ``import robotics``.

    Args:
        package: Its name.
        homes: Its public names by the modules that define them.
    """
    home = {name: module for module, names in homes.items() for name in names}

    def submodules() -> set[str]:
        from pkgutil import iter_modules  # which takes a third of the time of importing a package

        return {found.name for found in iter_modules(import_module(package).__path__) if found.name[0] != "_"}

    def get(name: str) -> object:
        if name in home:
            found: object = getattr(import_module(home[name]), name)
            return found
        if name[0] != "_" and name in submodules():
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

    return get, names
