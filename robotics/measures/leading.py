"""Who leads in a scenario: the law with the best mean of a metric, and those that cannot be told from it."""

from collections.abc import Mapping
from typing import NamedTuple

import numpy as np

from robotics.measures.evidence import Estimate, mean_of


class Standing(NamedTuple):
    """The place of one law in a scenario."""

    law: str  # its specification
    value: Estimate
    leads: bool  # it has the best mean, or the seeds cannot tell it from the one that has
    contacts: int  # runs with a contact; a law that has any does not lead


class Lead(NamedTuple):
    """The standings of all laws in a scenario."""

    scenario: str
    title: str  # of what is measured
    unit: str
    standings: tuple[Standing, ...]
    larger: bool = False  # whether larger is better

    @property
    def best(self) -> float:
        """The best mean of a law without contact; not-a-number if there is none."""
        return (max if self.larger else min)((s.value.value for s in self.standings if s.leads), default=float("nan"))


def lead(
    scenario: str,
    title: str,
    unit: str,
    values: Mapping[str, np.ndarray],
    contacts: Mapping[str, int] | None = None,
    larger: bool = False,
) -> Lead:
    """The standings by the ``values`` of every law (seeds,), of which less is better, or ``larger``.

    A law whose runs contain a contact never leads, whatever its numbers, and neither does one whose mean is infinite.
    """
    touched = {law: (contacts or {}).get(law, 0) for law in values}
    means = {law: float(np.mean(v)) for law, v in values.items() if not touched[law] and np.isfinite(v).all()}
    best = (max if larger else min)(means, key=means.__getitem__, default=None)
    standings = []
    for law, found in values.items():
        leads = law == best
        if best is not None and law in means and not leads:
            apart = mean_of(found - values[best])
            leads = len(found) > 1 and apart.low <= 0 <= apart.high
        standings.append(Standing(law, mean_of(found), leads, touched[law]))
    return Lead(scenario, title, unit, tuple(standings), larger)
