"""What a search may move of a tree: that of each of its systems."""

import warnings
from collections.abc import Collection
from dataclasses import dataclass
from itertools import chain
from typing import Any

import numpy as np

from fuzzy.tuning.parameter import SearchParameter
from fuzzy.tuning.systemspace import MOVED, SystemSpace, reach_of


@dataclass(frozen=True, eq=False)
class TreeSpace:
    """A tree and what may move of each of its systems, in the tree's order; universes and connections stay."""

    fis: Any  # a Tree
    move: Collection[str]
    spaces: tuple[SystemSpace, ...]

    @property
    def parameters(self) -> tuple[SearchParameter, ...]:
        """What may move, called "system/parameter"."""
        return tuple(chain.from_iterable(space.parameters for space in self.spaces))

    def made(self, values: np.ndarray) -> Any:
        """The tree that ``values`` (parameters,) make."""
        ends = np.cumsum([len(space.parameters) for space in self.spaces])
        rows = np.split(np.asarray(values), ends[:-1])
        made = [space.made(row) for space, row in zip(self.spaces, rows, strict=True)]
        return self.fis.with_systems(dict(zip(self.fis.order, made, strict=True)))

    def unreached(self, x: np.ndarray) -> tuple[str, ...]:
        """The names of the parameters of which the tree's inputs ``x`` (points, inputs) say too little."""
        with warnings.catch_warnings(action="ignore"):  # of points outside the universe
            asked = _asked(self.fis, x)
        return tuple(chain.from_iterable(s.unreached(points) for s, points in zip(self.spaces, asked, strict=True)))


def tree_space(
    fis: Any, move: Collection[str] | None, symmetric: bool, data: tuple[np.ndarray, np.ndarray] | None
) -> TreeSpace:
    """What may move of a tree; see :meth:`Tree.search_space`."""
    spaces = []
    asked = _asked(fis, data[0]) if data else [None] * len(fis.order)
    known = (
        dict(zip(fis.answers or (), np.ptp(data[1], axis=0), strict=True)) if data else dict.fromkeys(fis.answers or ())
    )
    for name, points in zip(fis.order, asked, strict=True):
        part, reach = fis.systems[name], None
        if points is not None:
            spans = [known.get(f"{name}/{v.name}", v.span) for v in part.outputs]
            reach = reach_of(part, points, np.array(spans))
        taken = [v.name for v in part.outputs if f"{name}/{v.name}" not in known]  # by other systems' universes
        spaces.append(SystemSpace(part, move or MOVED, symmetric, f"{name}/", reach, taken))
    return TreeSpace(fis, move or MOVED, tuple(spaces))


def _asked(fis: Any, x: np.ndarray) -> list[np.ndarray]:
    """The inputs (points, inputs) of each system at the tree's inputs ``x`` (points, inputs)."""
    values = fis.values(x)
    return [np.stack([values[k] for k in wires], axis=-1) for wires in fis.wires]
