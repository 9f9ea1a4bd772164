"""What rule bases would have said of their inputs: that one left its universe, or that no rule fired.

A compiled period says nothing of either. After a run its recorded inputs tell.
"""

from collections.abc import Mapping

import numpy as np

from fuzzy.compiled.sugeno import compile_sugeno
from fuzzy.system import Sugeno


def say_of_inputs(systems: Mapping[str, Sugeno], inputs: np.ndarray) -> None:
    """Warn, or raise FuzzySystemError, as each of ``systems`` does where it is called with what it was told in a run.

    Args:
        systems: The rule bases, as of :attr:`robotics.laws.law.Law.fuzzy_systems`.
        inputs: The inputs of all of them, one system after the other, (samples, inputs, runs, robots) float32, as
            recorded; a robot that is told nothing is not-a-number in all of a system's.
    """
    first = 0
    for system in systems.values():
        own = np.moveaxis(inputs[:, first : first + len(system.inputs)], 1, -1).reshape(-1, len(system.inputs))
        first += len(system.inputs)
        if system.out_of_range in ("clip", "ignore") and system.no_rule_fires != "error":
            continue  # it was told to say nothing of its inputs
        points = own[~np.isnan(own).any(axis=1)].astype(float)
        for column, variable in zip(points.T, system.inputs, strict=True):
            for end in variable.universe:  # an end itself is recorded a little off, and is not outside
                column[column == np.float32(end)] = end
        if len(points):
            compile_sugeno(system, sample=True)(points)
