"""A Sugeno system compiled for speed: the same numbers as :func:`fuzzy.inference.infer`, in float64 on the CPU.

Importing this module imports Numba; ``import fuzzy`` does not.
"""

from dataclasses import dataclass, fields
from typing import Any

import numpy as np

from fuzzy import membership
from fuzzy.compiled import tables as layout
from fuzzy.compiled.kernel import evaluate_batch
from fuzzy.compiled.tables import Tables
from fuzzy.inference import logarithmic, say_no_rule_fires, say_out_of_range
from fuzzy.system import FuzzySystemError, Linear, Sugeno

_KINDS: dict[type[membership.MembershipFunction], int] = {
    membership.Triangle: layout.TRIANGLE,
    membership.Trapezoid: layout.TRAPEZOID,
    membership.LinearS: layout.LINEAR_S,
    membership.LinearZ: layout.LINEAR_Z,
    membership.Gaussian: layout.GAUSSIAN,
    membership.TwoSidedGaussian: layout.TWO_SIDED_GAUSSIAN,
    membership.Bell: layout.BELL,
    membership.Sigmoid: layout.SIGMOID,
    membership.SigmoidDifference: layout.SIGMOID_DIFFERENCE,
    membership.SigmoidProduct: layout.SIGMOID_PRODUCT,
    membership.SShape: layout.S_SHAPE,
    membership.ZShape: layout.Z_SHAPE,
    membership.PiShape: layout.PI_SHAPE,
}


@dataclass(frozen=True, eq=False)
class CompiledSugeno:
    """A system together with its arrays. Made by :func:`compile_sugeno`; call it as you would the system.

    Inside a function that Numba compiles, use the arrays::

        work = workspace(compiled.tables, 1)  # once; from fuzzy.compiled.kernel
        evaluate_point(compiled.tables, x, output, work)  # x (inputs,), output (outputs,)
    """

    fis: Sugeno
    tables: Tables

    def __call__(self, x: Any) -> np.ndarray:
        """The outputs (..., outputs) at ``x`` (..., inputs), both float64, each in the unit of its variable.

        Warns and raises as :func:`fuzzy.inference.infer` does. A point's result does not depend on the others.
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

    Parameters that are arrays (torch tensors in training, say) are read once, now. The first evaluation in an
    installation compiles for some seconds; the result is kept on disk.
    """
    s = fis.structure
    first = np.cumsum([0, *(len(v.terms) for v in fis.inputs)])[:-1]  # the number of each input's first term
    functions = [(i, f) for i, v in enumerate(fis.inputs) for f in v.terms.values()]
    parameters = np.zeros((len(functions), max(len(fields(kind)) for kind in _KINDS)))
    for t, (_, function) in enumerate(functions):
        parameters[t, : len(function.parameters)] = [membership.as_number(p) for p in function.parameters]
    rules, inputs, outputs = len(fis.rules), len(fis.inputs), len(fis.outputs)
    constant, slopes = np.zeros((outputs, rules)), np.zeros((outputs, rules, inputs))
    for o, variable in enumerate(fis.outputs):
        consequents = [[membership.as_number(p) for p in term.parameters] for term in variable.terms.values()]
        for r in np.flatnonzero(s.consequent[o] >= 0):
            *slope, constant[o, r] = consequents[s.consequent[o, r]]
            slopes[o, r, : len(slope)] = slope
    arrays = Tables(
        low=np.array([v.universe[0] for v in fis.inputs]),
        high=np.array([v.universe[1] for v in fis.inputs]),
        clip=fis.out_of_range == "clip",
        kind=np.array([_KINDS[type(f)] for _, f in functions], dtype=np.int64),
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
