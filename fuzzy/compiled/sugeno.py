"""A Sugeno system compiled for speed. It gives the numbers of :func:`fuzzy.inference.infer`, in float64 on the CPU.

Importing this module imports Numba; ``import fuzzy`` does not.
"""

from dataclasses import dataclass, field
from typing import Any

import numpy as np

from fuzzy.compiled.kernel import evaluate_batch
from fuzzy.compiled.packed import evaluate_one, packed
from fuzzy.compiled.threads import share_out
from fuzzy.inference import say_no_rule_fires, say_out_of_range
from fuzzy.system import FuzzySystemError, Sugeno

BLOCK = 16_384  # points that a thread takes at a time, a whole number of the kernel's blocks


@dataclass(frozen=True, eq=False)
class CompiledSugeno:
    """A system together with its numbers, which :func:`compile_sugeno` lays out. It is called as the system is.

    A function that Numba compiles uses the numbers::

        work = np.empty(packed_work(compiled.system))  # once; from fuzzy.compiled.packed
        evaluate_packed(compiled.system, x, output, work)  # x (inputs,), output (outputs,)
    """

    fis: Sugeno
    system: np.ndarray
    _point: tuple[int] = field(init=False, repr=False)  # the shape of one point
    _outputs: int = field(init=False, repr=False)

    def __post_init__(self) -> None:
        object.__setattr__(self, "_point", (len(self.fis.inputs),))
        object.__setattr__(self, "_outputs", len(self.fis.outputs))

    def __call__(self, x: Any) -> np.ndarray:
        """Evaluate the outputs (..., outputs) at ``x`` (..., inputs), both float64, each in the unit of its variable.

        Warns and raises as :func:`fuzzy.inference.infer` does. The result at a point does not depend on other points,
        nor on the number of processors, over which very many points are shared out.
        """
        points = np.asarray(x, dtype=np.float64)
        if points.shape == self._point and points.flags.carray:
            output = np.empty(self._outputs)
            if not evaluate_one(self.system, points, output):
                return output
        return self._evaluated(points)

    def _evaluated(self, points: np.ndarray) -> np.ndarray:
        """Evaluate points of any shape, with warnings and errors."""
        inputs, outputs = len(self.fis.inputs), len(self.fis.outputs)
        if points.ndim == 0 or points.shape[-1] != inputs:
            raise FuzzySystemError(
                f"{self.fis.name}: the last axis of the input must hold {inputs} values "
                f"({', '.join(v.name for v in self.fis.inputs)}), got shape {points.shape}"
            )
        output = np.empty((*points.shape[:-1], outputs))
        rows, values = points.reshape(-1, inputs), output.reshape(-1, outputs)
        if not rows.flags.carray:  # read-only and strided arrays are other types to Numba: compiled again
            rows = rows.copy()
        blocks = -(-len(rows) // BLOCK)
        outside, missing = np.empty((blocks, inputs), dtype=np.bool_), np.empty((blocks, outputs), dtype=np.bool_)
        told = [False] * blocks

        def work(first: int, end: int) -> None:
            k = first // BLOCK
            told[k] = evaluate_batch(self.system, rows[first:end], values[first:end], outside[k], missing[k])

        if blocks == 1:
            work(0, len(rows))
        else:
            share_out(work, len(rows), BLOCK)
        if any(told):
            if self.fis.out_of_range in ("warn", "error") and outside.any():
                say_out_of_range(self.fis, outside.any(axis=0))
            if missing.any():
                say_no_rule_fires(self.fis, missing.any(axis=0))
        return output


def compile_sugeno(fis: Sugeno) -> CompiledSugeno:
    """Lay ``fis`` out for the compiled inference.

    Parameters that are arrays (torch tensors in training, for example) are read now, and not again later. The first
    evaluation in an installation compiles for some seconds; the machine code is kept on disk.

    Raises FuzzySystemError for a membership function that the compiled kernel has no branch for.
    """
    return CompiledSugeno(fis, packed(fis))
