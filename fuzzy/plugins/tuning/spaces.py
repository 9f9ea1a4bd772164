"""Systems of all kinds that data tune: plain ones, trees of systems, and interval type-2 ones."""

from collections.abc import Collection
from hashlib import sha256
from typing import Any, TypeVar

import numpy as np

from fuzzy.compiled.sugeno import compile_sugeno
from fuzzy.files.fisfile import format_fis
from fuzzy.inference import forgiving
from fuzzy.plugins.trees.compiled import compile_tree
from fuzzy.plugins.trees.space import TreeSpace
from fuzzy.plugins.trees.tree import Tree
from fuzzy.plugins.type2.compiled import compile_type2
from fuzzy.plugins.type2.space import Type2Space
from fuzzy.plugins.type2.system import Type2Sugeno
from fuzzy.system import FuzzySystemError, Sugeno
from fuzzy.tuning.systemspace import MOVED, SystemSpace, reach_of

System = TypeVar("System", bound=Sugeno | Tree | Type2Sugeno)


def space_of(
    fis: Any, move: Collection[str] | None, symmetric: bool, x: np.ndarray, y: np.ndarray
) -> SystemSpace | TreeSpace | Type2Space:
    """What may move of a system of any kind, about as far as data reach.

    Args:
        fis: The system.
        move: What may move; None: memberships and consequents, of a type-2 system footprints too.
        symmetric: Whether a symmetry is kept; of a tree that of each of its systems.
        x: The inputs (samples, inputs).
        y: The outputs (samples, outputs).

    Raises TuningError for an unknown part.
    """
    if isinstance(fis, Tree | Type2Sugeno):
        return fis.search_space(move, symmetric, (x, y))
    return SystemSpace(fis, move or MOVED, symmetric, reach=reach_of(fis, x, np.ptp(y, axis=0)))


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
