"""Simulations of random crossings, with disturbances, many in one pass."""

from collections.abc import Callable, Sequence
from typing import Any

import numpy as np

from robotics.environment.swept import Watch
from robotics.experiments.stress.crossings import crossing_ensemble
from robotics.experiments.stress.outcome import HELD, LIMIT, Disturbance, StressOutcome
from robotics.laws.law import Law
from robotics.laws.setting import Setting
from robotics.measures.arrival import at_goal
from robotics.radio.description import Radio
from robotics.radio.faults import Fault, Faults
from robotics.random_streams import FAULT_STREAM
from robotics.simulation.loop import drive
from robotics.vehicle import plant as p

UNDISTURBED = Disturbance()


def stress_crossing(
    controller: Law[Any],
    robots: int,
    seeds: Sequence[int],
    kind: Any = "A",
    disturbance: Disturbance = UNDISTURBED,
    begin: Callable[[str, int], Callable[[], None]] | None = None,
) -> StressOutcome:
    """Drive a random crossing for every seed, and judge what became of it.

    Args:
        controller: The law that drives the robots.
        robots: Number of robots of each crossing.
        seeds: One crossing for each.
        kind: Class of the crossings, "A" or "B".
        disturbance: What is wrong in every run.
        begin: Starts a bar of a progress display, by its text and total.
    """
    start = begin or (lambda text, total: lambda: None)
    ensemble, faults = disturbed_crossing(robots, seeds, kind, disturbance, start("drawing crossings", len(seeds)))
    return run_ensemble(
        ensemble, controller, seeds, faults, start("simulating", ensemble.ticks + 1), HELD * disturbance.freeze
    )


def disturbed_crossing(
    robots: int,
    seeds: Sequence[int],
    kind: Any,
    disturbance: Disturbance,
    advance: Callable[[], None] | None = None,
) -> tuple[Setting, Faults | None]:
    """The crossings of ``seeds``, long enough to judge them, and the faults in them, if there are any.

    Args:
        robots: Number of robots of each crossing.
        seeds: One crossing for each.
        kind: Class of the crossings, "A" or "B".
        disturbance: What is wrong in every run.
        advance: Called after every crossing that is drawn.
    """
    radio = Radio(loss=disturbance.loss, latency=disturbance.latency)
    held = HELD * disturbance.freeze
    ensemble = crossing_ensemble(robots, seeds, kind, radio=radio, factor=LIMIT, extra=held, advance=advance)
    return ensemble, _freeze(ensemble, seeds, disturbance.freeze) if disturbance.freeze > 0 else None


def _freeze(ensemble: Setting, seeds: Sequence[int], duration: float) -> Faults:
    """The faults that hold up one robot of each run once, from a moment in the first 80 % of the nominal time."""
    robots, durations = len(ensemble.robots), ensemble.references.ends[:, 0]
    faults = tuple(Fault(robot=i + 1, kind="stall", duration=duration) for i in range(robots))
    starts = np.full((len(seeds), robots), np.inf)
    for k, seed in enumerate(seeds):
        rng = np.random.default_rng([seed, FAULT_STREAM])
        starts[k, rng.integers(robots)] = rng.uniform(0.0, 0.8) * durations[k]
    return Faults(faults, robots, starts, starts + duration)


def run_ensemble(
    ensemble: Setting,
    controller: Law[Any],
    seeds: Sequence[int],
    faults: Faults | None = None,
    advance: Callable[[], None] | None = None,
    extra: float = 0.0,
) -> StressOutcome:
    """Drive until all robots of every run have arrived, or the time is up.

    After 4 nominal durations nothing of a run counts, so that it does not matter which runs are beside it.

    Args:
        ensemble: The crossings.
        controller: The law that drives the robots.
        seeds: The seed of each run.
        faults: The faults of the runs.
        advance: Called after every period.
        extra: The time [s] by which runs may take longer than 4 nominal durations.
    """
    runs, robots = len(seeds), len(ensemble.robots)
    paths, durations = ensemble.references.joined, ensemble.references.ends[:, 0]
    ends = paths.at(paths.lengths)
    arrivals = np.full((runs, robots), np.inf)
    watch: Watch | None = None
    nearest = np.full(runs, np.inf)
    refused = np.zeros(runs, dtype=bool)
    pairs = np.triu_indices(robots, 1)
    limit = LIMIT * durations + extra
    goes_on = np.ones(runs, dtype=bool)
    for state in drive(ensemble, controller, seeds, faults):
        if state.k == 0 and state.command.refused is not None:
            refused = state.command.refused
        x, y = state.truth[: p.Y + 1]
        gaps = np.hypot(x[:, pairs[0]] - x[:, pairs[1]], y[:, pairs[0]] - y[:, pairs[1]]).min(axis=1)
        nearest = np.where(goes_on, np.minimum(nearest, gaps), nearest)
        if watch is None:
            watch = Watch.opened(ensemble.robots, state.time, state.truth[: p.W + 1])
        else:
            watch, _ = watch.to(state.time, state.truth[: p.W + 1], going=goes_on)
        there = at_goal(x, y, ends, paths.lengths)
        arrivals = np.where(there & np.isinf(arrivals) & goes_on[:, None], state.time, arrivals)
        goes_on = ~(np.isfinite(arrivals).all(axis=1) | refused) & (state.time < limit)
        if advance is not None:
            advance()
        if not goes_on.any():
            break
    assert watch is not None  # there is a first state
    collided, clearance = np.isfinite(watch.first).any(axis=(0, 2)), watch.least.min(axis=(0, 2))
    return StressOutcome(tuple(seeds), durations, arrivals, collided, refused, nearest, clearance)
