"""A Sugeno system compiled for speed. It gives the numbers of :func:`fuzzy.inference.infer`, in float64 on the CPU.

Importing this module imports Numba; ``import fuzzy`` does not.
"""

from dataclasses import dataclass
from typing import Any

import numpy as np

from fuzzy.compiled.kernel import evaluate_batch
from fuzzy.compiled.tables import NUMBERS, Tables
from fuzzy.inference import logarithmic, say_no_rule_fires, say_out_of_range
from fuzzy.membershipfunction import as_number
from fuzzy.system import FuzzySystemError, Linear, Sugeno


@dataclass(frozen=True, eq=False)
class CompiledSugeno:
    """A system together with its arrays, which :func:`compile_sugeno` makes. It is called as the system is.

    A function that Numba compiles uses the arrays::

        work = workspace(compiled.tables, 1)  # once; from fuzzy.compiled.kernel
        evaluate_point(compiled.tables, x, output, work)  # x (inputs,), output (outputs,)
    """

    fis: Sugeno
    tables: Tables

    def __call__(self, x: Any) -> np.ndarray:
        """Evaluate the outputs (..., outputs) at ``x`` (..., inputs), both float64, each in the unit of its variable.

        Warns and raises as :func:`fuzzy.inference.infer` does. The result at a point does not depend on other points.
        """
        points = np.asarray(x, dtype=np.float64)
        inputs, outputs = len(self.fis.inputs), len(self.fis.outputs)
        if points.ndim == 0 or points.shape[-1] != inputs:
            raise FuzzySystemError(
                f"{self.fis.name}: the last axis of the input must hold {inputs} values "
                f"({', '.join(v.name for v in self.fis.inputs)}), got shape {points.shape}"
            )
        output = np.empty((*points.shape[:-1], outputs))
        outside, missing = np.empty(inputs, dtype=np.bool_), np.empty(outputs, dtype=np.bool_)
        rows = points.reshape(-1, inputs)
        if not rows.flags.carray:  # read-only and strided arrays are other types to Numba: compiled again
            rows = rows.copy()
        if evaluate_batch(self.tables, rows, output.reshape(-1, outputs), outside, missing):
            if self.fis.out_of_range in ("warn", "error") and outside.any():
                say_out_of_range(self.fis, outside)
            if missing.any():
                say_no_rule_fires(self.fis, missing)
        return output


def compile_sugeno(fis: Sugeno) -> CompiledSugeno:
    """Lay ``fis`` out as arrays for the compiled inference.

    Parameters that are arrays (torch tensors in training, for example) are read now, and not again later. The first
    evaluation in an installation compiles for some seconds; the machine code is kept on disk.

    Raises FuzzySystemError for a membership function that the compiled kernel has no branch for.
    """
    s = fis.structure
    first = np.cumsum([0, *(len(v.terms) for v in fis.inputs)])[:-1]  # the number of each input's first term
    functions = [(i, f) for i, v in enumerate(fis.inputs) for f in v.terms.values()]
    if strange := sorted({f.matlab for _, f in functions if type(f) not in NUMBERS}):
        raise FuzzySystemError(
            f"{fis.name}: the compiled kernel has no branch for {', '.join(strange)}; fuzzy.infer evaluates the system"
        )
    parameters = np.zeros((len(functions), max(len(kind.roles) for kind in NUMBERS)))
    for t, (_, function) in enumerate(functions):
        parameters[t, : len(function.parameters)] = [as_number(p) for p in function.parameters]
    rules, inputs, outputs = len(fis.rules), len(fis.inputs), len(fis.outputs)
    constant, slopes = np.zeros((outputs, rules)), np.zeros((outputs, rules, inputs))
    for o, variable in enumerate(fis.outputs):
        consequents = [[as_number(p) for p in term.parameters] for term in variable.terms.values()]
        for r in np.flatnonzero(s.consequent[o] >= 0):
            *slope, constant[o, r] = consequents[s.consequent[o, r]]
            slopes[o, r, : len(slope)] = slope
    arrays = Tables(
        low=np.array([v.universe[0] for v in fis.inputs]),
        high=np.array([v.universe[1] for v in fis.inputs]),
        clip=fis.out_of_range == "clip",
        kind=np.array([NUMBERS[type(f)] for _, f in functions], dtype=np.int64),
        parameters=parameters,
        place=np.array([i for i, _ in functions], dtype=np.int64),
        logarithmic=logarithmic(fis),
        clause=np.ascontiguousarray(np.where(s.term >= 0, s.term + first[:, None], -1).T),
        negated=np.ascontiguousarray(s.negated.T),
        power=np.ascontiguousarray(s.power.T),
        is_or=s.is_or.copy(),
        weight=s.weight.copy(),
        and_min=fis.and_method == "min",
        or_max=fis.or_method == "max",
        takes_part=s.consequent >= 0,
        constant=constant,
        slopes=slopes,
        linear=np.array([any(isinstance(t, Linear) for t in v.terms.values()) for v in fis.outputs]),
        weighted_sum=fis.defuzzification == "wtsum",
        default=np.array([v.midrange if fis.no_rule_fires == "midrange" else np.nan for v in fis.outputs]),
    )
    return CompiledSugeno(fis, arrays)
