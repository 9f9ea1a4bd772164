"""A tree in words: what it is made of, and why it answers what it answers."""

from collections.abc import Mapping
from dataclasses import dataclass
from textwrap import indent
from typing import Any

import numpy as np

from fuzzy.insight.description import as_dict, describe
from fuzzy.insight.explanation import Explanation, explain
from fuzzy.plugins.trees.tree import Tree, TreeError
from fuzzy.system import Variable
from fuzzy.words import counted, listed


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


def describe_tree(tree: Tree) -> str:
    """Describe the tree in words: what goes where, and then each system."""
    asks, answers = (", ".join(v.label for v in variables) for variables in (tree.inputs, tree.outputs))
    lines = [f"{tree.name}: {counted(len(tree.systems), 'system')}", f"inputs: {asks}", f"outputs: {answers}"]
    lines += [f"{source} -> {target}" for source, target in tree.connections or ()]
    lines += [f"{port}: no rule uses it" for port in tree.unused_inputs]
    return "\n".join([*lines, *(f"\n{name}\n{indent(describe(tree.systems[name]), '  ')}" for name in tree.order)])


def tree_as_dict(tree: Tree) -> dict[str, Any]:
    """Describe the tree as dictionaries, lists, strings and floats."""
    return {
        "name": tree.name,
        "type": "tree",
        "inputs": [v.name for v in tree.inputs],
        "outputs": [v.name for v in tree.outputs],
        "connections": [list(pair) for pair in tree.connections or ()],
        "unused": list(tree.unused_inputs),
        "systems": {name: as_dict(tree.systems[name]) for name in tree.order},
    }


def _sources(tree: Tree, name: str) -> list[tuple[Variable, str]]:
    """The inputs of a system that another one answers, with the port that does."""
    wires = tree.wires[tree.order.index(name)]
    pairs = zip(tree.systems[name].inputs, wires, strict=True)
    return [(v, tree.columns[k]) for v, k in pairs if k >= len(tree.inputs)]
