"""A tree from data: systems of two inputs in a row, each of which corrects the estimate of the one before.

Where a grid over all inputs has a rule for each combination of terms, such an incremental tree has as many rules for
each further input. What two inputs say only together, neither of which is in the first system, it finds only in part.
"""

from collections.abc import Sequence
from dataclasses import replace
from typing import Any

import numpy as np

from fuzzy.fitting.clustering import finite_table
from fuzzy.fitting.consequents import output_table
from fuzzy.fitting.folds import FoldOrder
from fuzzy.fitting.identification import IdentificationError, identify
from fuzzy.fitting.selection import select_inputs
from fuzzy.plugins.trees.tree import Tree
from fuzzy.system import Sugeno


def identify_tree(
    x: Any,
    y: Any,
    *,
    input_names: Sequence[str] | None = None,
    output_name: str = "output",
    mfs: int = 2,
    kind: str = "gbellmf",
    folds: int = 5,
    order: FoldOrder | str = "shuffled",
    most: int | None = None,
    seed: int = 0,
) -> Tree:
    """Propose a tree for many inputs: which of them, in which order, and the systems, fitted to the data.

    The first system has the first two inputs, each further one the estimate of the one before and the next input; all
    are grids with linear consequents, fitted by least squares to ``y``. Inputs are added by the error on samples that
    are held back (:func:`fuzzy.select_inputs`), and those that bring nothing are left out. Values outside the data are
    clipped. :func:`fuzzy.train_tree` then learns the whole.

    Args:
        x: The inputs (samples, inputs).
        y: The output (samples,).
        input_names: The names of the inputs; input1, input2 and so on by default.
        output_name: The name of the output.
        mfs: The number of terms of each input of a system.
        kind: Their membership function by MATLAB's name.
        folds: Number of folds.
        order: Which rows a fold holds back, see :func:`fuzzy.select_inputs`.
        most: The most inputs; by default as many as make the error less.
        seed: Seed of shuffled folds.

    Returns:
        The tree; its inputs are those that were taken, in the order in which they were.

    Raises:
        IdentificationError: Data of which no tree can be made.
        ClusteringError: Values that are not finite.
    """
    x, y = finite_table(x, "x"), output_table(y)
    names = [f"input{k}" for k in range(1, x.shape[1] + 1)] if input_names is None else list(input_names)
    if y.shape[1] != 1 or len(names) != x.shape[1]:
        raise IdentificationError(
            f"a name for each of {x.shape[1]} inputs, and one output; got {len(names)}, {y.shape}"
        )

    def make(x: np.ndarray, y: np.ndarray, names: Sequence[str] | None = None) -> Tree:
        return _incremental(x, y, names or [f"input{k}" for k in range(x.shape[1])], output_name, mfs, kind)

    found = select_inputs(x, y, make, folds=folds, order=order, most=most, seed=seed)
    columns = list(found.steps[len(found.chosen) - 1].inputs)
    return make(x[:, columns], y, [names[k] for k in columns])


def _incremental(x: np.ndarray, y: np.ndarray, names: Sequence[str], output: str, mfs: int, kind: str) -> Tree:
    """The tree of all columns of ``x`` in their order."""
    systems: dict[str, Sugeno] = {}
    given, labels, last = x[:, :2], list(names[:2]), max(x.shape[1] - 1, 1)
    for k in range(1, last + 1):
        answer = output if k == last else f"{output} {k}"
        fis = identify(given, y, "grid", mfs=mfs, kind=kind, input_names=labels, output_names=[answer])
        systems[f"stage {k}"] = replace(fis, name=f"stage {k}", out_of_range="clip")
        if k > 1:  # what the stage before answered is what this one learnt from
            before = systems[f"stage {k - 1}"]
            narrower = replace(before.outputs[0], universe=fis.inputs[0].universe)
            systems[f"stage {k - 1}"] = replace(before, outputs=(narrower,))
        if k < last:
            given, labels = np.column_stack([fis(given), x[:, k + 1]]), [answer, names[k + 1]]
    return Tree(systems, name=output)
