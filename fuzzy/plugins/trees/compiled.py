"""A tree compiled for speed: the numbers of its systems one by one, in one call of compiled code for many points."""

from dataclasses import dataclass
from typing import Any

import numpy as np

from fuzzy.compiled.composite import composite_row
from fuzzy.compiled.jit import kernel
from fuzzy.compiled.kernel import evaluate_batch
from fuzzy.compiled.packed import PackedColumns, packed, packed_work
from fuzzy.compiled.sugeno import BLOCK, MANY
from fuzzy.compiled.threads import share_out
from fuzzy.inference import say_no_rule_fires, say_out_of_range
from fuzzy.plugins.trees.tree import Tree


@dataclass(frozen=True, eq=False)
class CompiledTree:
    """A tree together with its numbers, which :func:`compile_tree` lays out. It is called as the tree is.

    Attributes:
        tree: The tree that was laid out.
        numbers: (n,): those of its systems, one after the other in the tree's order, float64.
        ends: (systems,): where those of each system end.
        wires: (inputs of all systems,): the columns that these take.
        answers: (outputs,): the columns of the tree's outputs.
    """

    tree: Tree
    numbers: np.ndarray
    ends: np.ndarray
    wires: np.ndarray
    answers: np.ndarray

    def __call__(self, x: Any) -> np.ndarray:
        """Evaluate the outputs (..., outputs) at ``x``, points or values by name; warns and raises as the tree does."""
        points = np.asarray(self.tree.point(x), dtype=np.float64)
        rows = np.ascontiguousarray(points.reshape(-1, points.shape[-1]))
        y = np.empty((len(rows), len(self.answers)))
        blocks = range(-(-len(rows) // BLOCK))
        outside = np.zeros((len(blocks), len(self.wires)), dtype=np.bool_)
        missing = np.zeros((len(blocks), len(self.tree.columns) - len(self.tree.inputs)), dtype=np.bool_)

        def evaluate(k: int) -> bool:
            part = slice(k * BLOCK, (k + 1) * BLOCK)
            plan = self.numbers, self.ends, self.wires, self.answers
            return bool(evaluate_tree(*plan, rows[part], y[part], outside[k], missing[k]))

        if any(share_out(evaluate, blocks, None if len(rows) >= MANY else 1)):
            self._say(np.any(outside, axis=0), np.any(missing, axis=0))
        return y.reshape(*points.shape[:-1], len(self.answers))

    @property
    def row(self) -> np.ndarray:
        """All numbers (n,), as :func:`fuzzy.compiled.composite.evaluate_composite` takes them."""
        systems = np.split(self.numbers, self.ends[:-1])
        most = max(len(fis.inputs) for fis in self.tree.systems.values())
        room = len(self.tree.columns) + most + max(map(packed_work, systems))
        return composite_row(self.tree, systems, room, wires=self.wires, answers=self.answers)

    def _say(self, outside: Any, missing: Any) -> None:
        """Warn, or raise, of each system as it says, by the marks of all systems' inputs and outputs."""
        for fis in map(self.tree.systems.__getitem__, self.tree.order):
            left, none = outside[: len(fis.inputs)], missing[: len(fis.outputs)]
            outside, missing = outside[len(fis.inputs) :], missing[len(fis.outputs) :]
            if fis.out_of_range in ("warn", "error") and left.any():
                say_out_of_range(fis, left)
            if none.any():
                say_no_rule_fires(fis, none)


def compile_tree(tree: Tree) -> CompiledTree:
    """Lay a tree out for the compiled inference; its first evaluation in an installation compiles for seconds.

    Args:
        tree: The tree; parameters that are arrays are read now, and not again later.

    Returns:
        What is called as the tree is, with the same numbers, sooner.

    Raises:
        FuzzySystemError: A membership function for which the compiled inference has no branch.
    """
    rows = [packed(tree.systems[name]) for name in tree.order]
    return CompiledTree(
        tree,
        np.concatenate(rows),
        np.cumsum([len(row) for row in rows]),
        np.concatenate(tree.wires),
        np.array(tree.answer_columns),
    )


@kernel(nogil=True)
def evaluate_tree(
    numbers: np.ndarray,
    ends: np.ndarray,
    wires: np.ndarray,
    answers: np.ndarray,
    x: np.ndarray,
    output: np.ndarray,
    outside: np.ndarray,
    missing: np.ndarray,
) -> bool:
    """Evaluate n points; return whether anything is written in ``outside`` or ``missing``.

    Args:
        numbers: As of :class:`CompiledTree`, as are ``ends``, ``wires`` and ``answers``.
        ends: Likewise.
        wires: Likewise.
        answers: Likewise.
        x: The points (n, inputs).
        output: Where the outputs (n, outputs) are written.
        outside: Where is written of the inputs of all systems, as :func:`fuzzy.compiled.kernel.evaluate_batch` does.
        missing: Likewise, of the outputs.
    """
    n, inputs = x.shape
    columns = np.empty((inputs + len(missing), n))
    for i in range(inputs):
        columns[i] = x[:, i]
    told, begin, wire, place = False, 0, 0, 0
    for end in ends:
        system = numbers[begin:end]
        header = PackedColumns(system)
        taken, given = int(header.inputs), int(header.outputs)
        points, values = np.empty((n, taken)), np.empty((n, given))
        for i in range(taken):
            points[:, i] = columns[wires[wire + i]]
        told |= evaluate_batch(system, points, values, outside[wire : wire + taken], missing[place : place + given])
        for o in range(given):
            columns[inputs + place + o] = values[:, o]
        begin, wire, place = end, wire + taken, place + given
    for o in range(len(answers)):
        output[:, o] = columns[answers[o]]
    return told
