"""What the statistics accept: paired costs, infinite where a run failed."""

import numpy as np

from fuzzy.errors import InputError


class StatisticsError(InputError):
    """Numbers of which a statistic cannot be made. The message says which, and what is accepted."""


def checked(costs: np.ndarray) -> np.ndarray:
    """The costs as an array of floats (laws, scenarios, seeds).

    Raises StatisticsError for another number of axes, for fewer than two seeds, and for a cost that is not a number or
    is minus infinity.
    """
    costs = np.asarray(costs, dtype=float)
    if costs.ndim != 3 or 0 in costs.shape:
        raise StatisticsError(
            f"costs have the shape {costs.shape}; it must be (laws, scenarios, seeds), none of them 0"
        )
    if costs.shape[2] < 2:
        raise StatisticsError("costs of one seed have no interval; give two seeds or more")
    wrong = np.argwhere(np.isnan(costs) | (costs == -np.inf))
    if wrong.size:
        law, scenario, seed = wrong[0]
        raise StatisticsError(
            f"the cost of law {law}, scenario {scenario}, seed {seed} is {costs[law, scenario, seed]}; "
            "a cost is a number, or infinity where a run failed"
        )
    return costs
