"""Simulations of random crossings, with disturbances, many in one pass."""

from collections.abc import Sequence
from typing import Any

from fuzzy.shell.progress import Begin, unwatched
from robotics.laws.catalogue import as_law
from robotics.laws.law import Law
from robotics.plugins.stress.crossings import crossing_ensemble
from robotics.plugins.stress.disturbance import UNDISTURBED, Disturbance
from robotics.plugins.stress.outcome import StressOutcome
from robotics.plugins.stress.tally import run_ensemble


def stress_crossing(
    controller: Law[Any] | str,
    robots: int,
    seeds: Sequence[int],
    kind: Any = "A",
    disturbance: Disturbance = UNDISTURBED,
    begin: Begin | None = None,
) -> StressOutcome:
    """Drive a random crossing for every seed, and judge what became of it.

    Args:
        controller: The law that drives the robots, or its specification, as worker processes are given it: the class
            of a law in a user's file is known only where that file has run.
        robots: Number of robots of each crossing.
        seeds: One crossing for each.
        kind: Class of the crossings, "A" or "B".
        disturbance: What is wrong in every run.
        begin: Starts a bar of a progress display, by its text and total.

    Returns:
        What became of every run.
    """
    start = begin or unwatched
    drawn = start("drawing crossings", len(seeds))
    ensemble = crossing_ensemble(robots, seeds, kind, disturbance=disturbance, advance=drawn)
    advance = start("simulating", ensemble.ticks + 1)
    faults = disturbance.faults(ensemble, seeds)
    return run_ensemble(StressOutcome, ensemble, as_law(controller), seeds, faults, advance, disturbance.extra)
