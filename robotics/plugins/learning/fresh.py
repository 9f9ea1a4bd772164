"""Errors over sets of formation data drawn afresh: evidence on learning that does not rest on one draw.

The literal set has nothing random in it: its errors are exact numbers, and there is nothing to draw.
"""

from collections.abc import Sequence
from dataclasses import replace
from typing import NamedTuple, Protocol

import numpy as np

from fuzzy.fitting.identification import identify
from fuzzy.system import Sugeno
from robotics.plugins.learning.formationdata import FormationRecipe, formation_data
from robotics.plugins.learning.formationlearning import Learnt, input_columns

FRESH = 20  # sets


class NamedColumns(Protocol):
    """A table with the names of its columns."""

    @property
    def names(self) -> Sequence[str]:
        """The columns' names."""
        ...

    @property
    def values(self) -> np.ndarray:
        """The numbers (rows, columns)."""
        ...


class FreshErrors(NamedTuple):
    """RMSE of one output, in its unit, over the sets; every field is (sets,)."""

    clustering: np.ndarray  # training error of each set's own clusters, with consequents by least squares
    learnt: np.ndarray  # of the network learnt, on each set
    rules: np.ndarray  # how many rules the setting gives on each set


def fresh_errors(networks: Sequence[Learnt], recipe: FormationRecipe, sets: int = FRESH) -> dict[str, FreshErrors]:
    """Measure networks, and the setting of their clusters, on sets of ``recipe`` that are drawn afresh; by output.

    The first set is that of ``recipe``'s own seed, the next those of the seeds that follow. On each one the clusters
    are found again with the setting that the search took for the network; the search and the epochs are not repeated.

    Args:
        networks: The networks, as :func:`learn_networks` returns them.
        recipe: What the networks were learnt from, of the kind "well-posed".
        sets: The number of sets.
    """
    errors: dict[str, list[tuple[float, float, int]]] = {network.output: [] for network in networks}
    for k in range(sets):
        table = formation_data(replace(recipe, seed=recipe.seed + k))
        for network in networks:
            x, y = columns_of(network.after, table)
            trial = network.trial
            again = identify(x, y, "subtractive", radius=trial.radius, options=trial.options)
            errors[network.output].append((_rmse(again, x, y), _rmse(network.after, x, y), len(again.rules)))
    return {output: FreshErrors(*np.transpose(rows)) for output, rows in errors.items()}


def columns_of(fis: Sugeno, table: NamedColumns) -> tuple[np.ndarray, np.ndarray]:
    """The inputs (samples, inputs) and the output (samples,) of ``fis``, of one output, in ``table``, by name."""
    inputs = [table.names.index(name) for name in input_columns(fis)]
    return table.values[:, inputs], table.values[:, table.names.index(fis.outputs[0].name)]


def _rmse(fis: Sugeno, x: np.ndarray, y: np.ndarray) -> float:
    return float(np.sqrt(np.mean((fis(x)[:, 0] - y) ** 2)))
