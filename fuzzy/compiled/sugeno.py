"""A Sugeno system compiled for speed. It gives the numbers of :func:`fuzzy.inference.infer`, in float64 on the CPU.

Importing this module imports Numba; ``import fuzzy`` does not.
"""

from dataclasses import dataclass, field
from typing import Any

import numpy as np

from fuzzy.compiled.kernel import evaluate_batch
from fuzzy.compiled.packed import evaluate_one, one_point, packed
from fuzzy.compiled.threads import share_out
from fuzzy.inference import check_points, say_no_rule_fires, say_out_of_range
from fuzzy.system import FuzzySystemError, Sugeno

BLOCK = 4_096  # points that a thread takes at a time, a whole number of the kernel's blocks
MANY = 16 * BLOCK  # from here on threads: fewer take 3 ms, for which another thread may keep one waiting


@dataclass(frozen=True, eq=False)
class CompiledSugeno:
    """A system together with its numbers, which :func:`compile_sugeno` lays out. It is called as the system is.

    A function that Numba compiles uses the numbers::

        work = np.empty(packed_work(compiled.system))  # once; from fuzzy.compiled.packed
        evaluate_packed(compiled.system, x, output, work)  # x (inputs,), output (outputs,)

    Attributes:
        fis: The system that was laid out.
        system: Its numbers (n,), float64: the row that a compiled function takes.
    """

    fis: Sugeno
    system: np.ndarray
    _shape: tuple[int] = field(init=False, repr=False)  # of one point
    _length: int = field(init=False, repr=False)  # of a list that is one point
    _ready: list[tuple[np.ndarray, np.ndarray, np.ndarray]] = field(init=False, repr=False, default_factory=list)

    def __post_init__(self) -> None:
        inputs = len(self.fis.inputs)
        object.__setattr__(self, "_shape", (inputs,))
        # [[1.0]] is no point, but can be copied as one.
        object.__setattr__(self, "_length", inputs if inputs > 1 else -1)

    def __reduce__(self) -> Any:
        return CompiledSugeno, (self.fis, self.system)

    def __call__(self, x: Any) -> np.ndarray:
        """Evaluate the outputs (..., outputs) at ``x`` (..., inputs), both float64, each in the unit of its variable.

        Warns and raises as :func:`fuzzy.inference.infer` does. The result at a point does not depend on other points,
        nor on the number of processors, over which very many points are shared out.
        """
        # One point takes a microsecond, most of it for arrays that are made and handed over: its place is made once.
        listed = type(x) is list and len(x) == self._length
        if not listed and (type(x) is not np.ndarray or x.shape != self._shape):
            x = np.asarray(x, dtype=np.float64)
            if x.shape != self._shape:
                return self._evaluated(x)
        try:
            memory, point, values = ready = self._ready.pop()  # of this thread from here on
        except IndexError:
            memory, point, values = ready = one_point(self.system)
        try:
            point[:] = x
        except (TypeError, ValueError):  # of a list of something else
            return self._evaluated(np.asarray(x, dtype=np.float64))
        told = evaluate_one(memory)
        output = values.copy()
        self._ready.append(ready)
        return self._evaluated(np.asarray(x, dtype=np.float64)) if told else output

    def _evaluated(self, points: np.ndarray) -> np.ndarray:
        """Evaluate points of any shape, with warnings and errors."""
        inputs, outputs = len(self.fis.inputs), len(self.fis.outputs)
        check_points(self.fis, points)
        output = np.empty((*points.shape[:-1], outputs))
        rows, values = points.reshape(-1, inputs), output.reshape(-1, outputs)
        if not rows.flags.carray:  # read-only and strided arrays are other types to Numba: compiled again
            rows = rows.copy()
        if len(rows) < MANY:
            outside, missing = np.empty((1, inputs), dtype=np.bool_), np.empty((1, outputs), dtype=np.bool_)
            told = evaluate_batch(self.system, rows, values, outside[0], missing[0])
        else:
            told, outside, missing = self._shared_out(rows, values)
        if told:
            if self.fis.out_of_range in ("warn", "error") and outside.any():
                say_out_of_range(self.fis, outside.any(axis=0))
            if missing.any():
                say_no_rule_fires(self.fis, missing.any(axis=0))
        return output

    def quietly(self, points: np.ndarray) -> np.ndarray:
        """The outputs (samples, outputs) at a few points, whatever the system says of them.

        They are as :func:`fuzzy.inference.infer` of :func:`fuzzy.inference.forgiving` finds them.

        Args:
            points: Inputs (samples, inputs), in their units.
        """
        inputs, outputs = len(self.fis.inputs), len(self.fis.outputs)
        values = np.empty((len(points), outputs))
        flags = np.empty(inputs, dtype=np.bool_), np.empty(outputs, dtype=np.bool_)
        evaluate_batch(self.system, np.ascontiguousarray(points, dtype=np.float64), values, *flags)
        return values

    def _shared_out(self, rows: np.ndarray, values: np.ndarray) -> tuple[bool, np.ndarray, np.ndarray]:
        """Evaluate very many points on all processors; what ``evaluate_batch`` tells, for each block."""
        blocks = -(-len(rows) // BLOCK)
        outside, missing = (np.empty((blocks, count), dtype=np.bool_) for count in (rows.shape[1], values.shape[1]))

        def evaluate(k: int) -> bool:
            part = slice(k * BLOCK, (k + 1) * BLOCK)
            return bool(evaluate_batch(self.system, rows[part], values[part], outside[k], missing[k]))

        return any(share_out(evaluate, range(blocks))), outside, missing


def outputs_of(fis: Sugeno, x: np.ndarray) -> np.ndarray:
    """The outputs (samples, outputs) at ``x`` (samples, inputs) in compiled code, where it knows all functions."""
    try:
        return compile_sugeno(fis)(x)
    except FuzzySystemError:  # a membership function of somebody's own
        return np.asarray(fis(x))


def compile_sugeno(fis: Sugeno, sample: bool = False) -> CompiledSugeno:
    """Lay ``fis`` out for the compiled inference.

    Parameters that are arrays (torch tensors in training, for example) are read now, and not again later. The first
    evaluation in an installation compiles for some seconds; the machine code is kept on disk.

    Args:
        fis: The system.
        sample: Whether membership functions of one's own, for which the compiled kernel has no branch, are read at many
            points, with a warning that says how near to them one comes.

    Returns:
        What is called as the system is, (..., inputs) to (..., outputs), with the same numbers, sooner.

    Raises:
        FuzzySystemError: There is such a function, and it is not to be sampled.
    """
    return CompiledSugeno(fis, packed(fis, sample))
