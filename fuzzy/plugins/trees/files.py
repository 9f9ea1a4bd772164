"""Trees in folders: a file tree.toml, and a .fis file of each system beside it.

    name = "approach"
    connections = [
        ["grip/friction", "speed/friction"],
    ]
    answers = ["speed/v"]

    [systems]
    grip = "grip.fis"
    speed = "speed.fis"

Without ``connections`` they follow from the names of the variables, without ``answers`` the tree answers with all that
no system takes; see :class:`fuzzy.plugins.trees.tree.Tree`.
"""

import os
import tomllib
from collections.abc import Callable
from pathlib import Path
from typing import Any

from fuzzy.errors import InputError, quoted
from fuzzy.files.fisfile import read_fis
from fuzzy.naming import check_known
from fuzzy.plugins.trees.tree import TREE_FILE, Tree, TreeError
from fuzzy.system import Sugeno

_KEYS = {"name": str, "connections": list, "answers": list, "systems": dict}


def read_tree(path: str | os.PathLike[str]) -> Tree:
    """Read the tree in a folder, or that of a tree.toml.

    Args:
        path: The folder or the file.

    Returns:
        The tree, equal to the one that was written.

    Raises:
        TreeError: A text that describes no tree, with the file and the key.
        FisFileError: A .fis file that holds no Sugeno system.
    """
    file = Path(path) / TREE_FILE if Path(path).is_dir() else Path(path)
    return tree_of(file, lambda at: read_fis(file.parent / at))


def tree_of(file: Path, read: Callable[[str], Sugeno]) -> Tree:
    """The tree that a tree.toml describes; ``read`` reads the file of a system, by its name there.

    Raises TreeError, and what ``read`` does.
    """
    try:
        table = tomllib.loads(file.read_text(encoding="utf-8"))
    except OSError as error:
        raise TreeError(f"{file}: cannot be read: {error.strerror or error}") from None
    except ValueError as error:
        raise TreeError(f"{file}: no TOML in UTF-8: {error}") from None
    for key, value in table.items():
        check_known(key, _KEYS, "key", TreeError, where=str(file))
        if not isinstance(value, _KEYS[key]):
            raise TreeError(f"{file}: {key} must be a {_KEYS[key].__name__}, got {quoted(value)}")
    names: dict[str, Any] = table.pop("systems", {})
    if wrong := [name for name, at in names.items() if not isinstance(at, str)]:
        raise TreeError(f"{file}: systems.{wrong[0]} must be the name of a .fis file, got {quoted(names[wrong[0]])}")
    systems = {name: read(at) for name, at in names.items()}
    try:
        return Tree(systems, **table)
    except InputError as error:
        raise TreeError(f"{file}: {error}") from None
