"""Why a tree answers what it answers: the explanations of its systems."""

from collections.abc import Mapping
from dataclasses import dataclass
from textwrap import indent
from typing import Any

import numpy as np

from fuzzy.insight.explanation import Explanation, explain
from fuzzy.plugins.trees.tree import Tree, TreeError
from fuzzy.system import Variable
from fuzzy.words import listed


@dataclass(frozen=True)
class TreeExplanation:
    """One evaluation of a tree: that of each system. ``str()`` gives it in words, ``as_dict()`` as plain data.

    Attributes:
        tree: The tree that was asked.
        systems: The explanation of each system, by name, in the order in which they are evaluated.
        output: (outputs,), in the outputs' units.
    """

    tree: Tree
    systems: Mapping[str, Explanation]
    output: tuple[float, ...]

    def as_dict(self) -> dict[str, Any]:
        """The explanation as dictionaries and lists, ready for JSON except that numbers may be NaN."""
        names = [v.name for v in self.tree.outputs]
        return {
            "tree": self.tree.name,
            "outputs": dict(zip(names, self.output, strict=True)),
            "systems": {name: each.as_dict() for name, each in self.systems.items()},
        }

    def __str__(self) -> str:
        parts = []
        for name, each in self.systems.items():
            takes = [f"{v.name} from {port}" for v, port in _sources(self.tree, name)]
            parts.append(f"{name}{f' takes {listed(takes)}' if takes else ''}:\n{indent(str(each), '  ')}")
        return "\n\n".join(parts)


def explain_tree(tree: Tree, x: Any) -> TreeExplanation:
    """Evaluate a tree at one point and keep what led to the result: which rules fired in each system, and how much.

    Args:
        tree: The tree.
        x: The point (inputs,), or the values by the inputs' names.

    Returns:
        The explanation of each system in its place.

    Raises:
        TreeError: More than one point, and names that are not those of the inputs.
        FuzzySystemError: A point outside a universe of discourse if the system is told to refuse it.
    """
    point = np.asarray(tree.point(x), dtype=float)
    if point.ndim != 1:
        raise TreeError(
            f"{tree.name}: one point of {len(tree.inputs)} inputs can be explained, got shape {point.shape}"
        )
    values, found = point.tolist(), dict[str, Explanation]()
    for name, wires in zip(tree.order, tree.wires, strict=True):
        found[name] = explain(tree.systems[name], [values[k] for k in wires])
        values += found[name].output
    return TreeExplanation(tree, found, tuple(values[k] for k in tree.answer_columns))


def _sources(tree: Tree, name: str) -> list[tuple[Variable, str]]:
    """The inputs of a system that another one answers, with the port that does."""
    wires = tree.wires[tree.order.index(name)]
    pairs = zip(tree.systems[name].inputs, wires, strict=True)
    return [(v, tree.columns[k]) for v, k in pairs if k >= len(tree.inputs)]
