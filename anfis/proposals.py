"""The consequents between the units of a system and those of learning, in which inputs are (x − low)/span."""

from collections.abc import Sequence

import numpy as np

from fuzzy.fitting.consequents import output_groups
from fuzzy.system import Consequent, Constant, Linear, Sugeno


def consequent_terms(
    fis: Sugeno, solutions: Sequence[np.ndarray], low: np.ndarray, span: np.ndarray
) -> list[list[Consequent]]:
    """The consequents of every output, in the inputs' own units, from solutions in scaled units (x − low)/span.

    ``solutions`` are those of the groups of :func:`fuzzy.fitting.consequents.output_groups`, (parameters, outputs)
    each; ``low`` and ``span`` are (inputs,). A term that no rule proposes stays as it is.
    """
    result: list[list[Consequent]] = [[] for _ in fis.outputs]
    width = len(fis.inputs) + 1
    for group, values in zip(output_groups(fis), solutions, strict=True):
        full = np.zeros((len(group.linear) * width, values.shape[1]))
        full[group.columns] = values
        for column, o in enumerate(group.outputs):
            rows = full[:, column].reshape(-1, width)
            slopes = rows[:, :-1] / span
            constants = rows[:, -1] - slopes @ low
            for t, term in enumerate(fis.outputs[o].terms.values()):
                if not group.used[t]:
                    result[o].append(term)
                    continue
                constant = float(constants[t])
                result[o].append(
                    Linear(tuple(slopes[t].tolist()), constant) if isinstance(term, Linear) else Constant(constant)
                )
    return result


def present_values(fis: Sugeno, low: np.ndarray, span: np.ndarray) -> list[np.ndarray]:
    """The consequents that ``fis`` has now, in scaled units: the inverse of :func:`consequent_terms`."""
    result = []
    for group in output_groups(fis):
        columns = []
        for o in group.outputs:
            rows = []
            for term in fis.outputs[o].terms.values():
                *slopes, constant = [float(p) for p in term.parameters]
                slope = np.array(slopes or [0.0] * len(fis.inputs))
                rows.append(np.append(slope * span, constant + slope @ low))
            columns.append(np.concatenate([*rows, np.zeros(0)])[group.columns])
        result.append(np.stack(columns, axis=1))
    return result
