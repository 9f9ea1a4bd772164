"""Systems of all kinds that data tune: plain ones, trees of systems, and interval type-2 ones."""

from hashlib import sha256
from typing import Any, TypeVar

import numpy as np

from fuzzy.compiled.sugeno import compile_sugeno
from fuzzy.files.fisfile import format_fis
from fuzzy.inference import forgiving
from fuzzy.plugins.trees.compiled import compile_tree
from fuzzy.plugins.trees.tree import Tree
from fuzzy.plugins.type2.compiled import compile_type2
from fuzzy.plugins.type2.system import Type2Sugeno
from fuzzy.system import FuzzySystemError, Sugeno

System = TypeVar("System", bound=Sugeno | Tree | Type2Sugeno)


def systems_of(fis: Any) -> list[Sugeno]:
    """The type-1 systems of a system of any kind."""
    if isinstance(fis, Tree):
        return [fis.systems[name] for name in fis.order]
    return [fis.upper]


def digest(fis: Any) -> str:
    """What tells a system from others."""
    text = "".join(map(format_fis, systems_of(fis) if isinstance(fis, Tree) else [fis]))
    wired = repr((fis.order, fis.connections, fis.answers)) if isinstance(fis, Tree) else ""
    return sha256((text + wired).encode()).hexdigest()


def answers_of(fis: Any, x: np.ndarray) -> np.ndarray:
    """The outputs (samples, outputs) at ``x`` (samples, inputs), the middle of a range where no rule fires.

    In compiled code, where it knows all functions.
    """
    fis = forgiving(fis, "midrange")
    compiled: Any = {Tree: compile_tree, Type2Sugeno: compile_type2}.get(type(fis), compile_sugeno)
    try:
        return np.asarray(compiled(fis)(x))
    except FuzzySystemError:  # a membership function of somebody's own
        return np.asarray(fis(x))
