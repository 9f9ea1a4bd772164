"""Optional packages, by the extras of ``pyproject.toml``, and the command that installs them wherever we came from."""

import re
import shlex
from importlib import import_module
from importlib.metadata import PackageNotFoundError, requires
from typing import Any

from fuzzy.errors import InputError

_OWN = "fuzzyfleet"


class MissingPackageError(InputError):
    """A package that is not installed, and that only some of what is here needs."""


def needed(module: str, what: str, project: str = "") -> Any:
    """Import a module of a large package that only ``what`` needs. Raises MissingPackageError without the package.

    ``project`` is its name where it is installed from, by default that of the package.
    """
    package = module.partition(".")[0]
    try:
        return import_module(module)
    except ModuleNotFoundError as error:
        if error.name != package:
            raise
        raise MissingPackageError(f"{what} needs {project or package}: pip install {project or package}") from None


def install_command(extra: str) -> str:
    """The command that installs what an extra asks for, such as ``design``: ``pip install 'nicegui>=3.18'``.

    It names the packages themselves, as the installed metadata do, because an extra of ours can be named only where
    the wheel or the checkout lies. Raises KeyError for an extra that there is not.
    """
    try:
        declared = requires(_OWN) or []
    except PackageNotFoundError:  # a bare folder of sources
        return f"pip install '.[{extra}]' in the folder of {_OWN}"
    belongs = re.compile(rf"""(.+?)\s*;\s*extra\s*==\s*['"]{re.escape(extra)}['"]""")
    found = [match[1] for line in declared if (match := belongs.fullmatch(line))]
    if not found:
        raise KeyError(extra)
    return f"pip install {' '.join(map(shlex.quote, found))}"
