"""Thousands of random crossings, in chunks that several processes may share."""

import os
from collections.abc import Sequence
from typing import Any

from fuzzy.shell.progress import Begin
from robotics.experiments.executors import processes
from robotics.experiments.stress.crossing_runs import UNDISTURBED, stress_crossing
from robotics.experiments.stress.outcome import Disturbance, StressOutcome, joined
from robotics.laws.law import Controller

CHUNK, MOST = 600, 20_000  # robots, and pairs of robots, that one pass simulates at most


def stress_crossings(
    controller: Controller[Any],
    robots: int,
    seeds: Sequence[int],
    kind: Any,
    disturbance: Disturbance = UNDISTURBED,
    *,
    jobs: int | None = None,
    begin: Begin,
) -> StressOutcome:
    """Stress a controller as :func:`robotics.experiments.stress.crossing_runs.stress_crossing` does, in chunks.

    Args:
        controller: The law that drives the robots.
        robots: Number of robots of each crossing.
        seeds: One crossing for each.
        kind: Class of the crossings, "A" or "B".
        disturbance: What is wrong in every run.
        jobs: Number of processes, by default one for each core; it does not change the outcome.
        begin: Starts a bar of a progress display, by its text and total.
    """
    size = max(1, min(CHUNK // robots, MOST // robots**2))
    chunks = [seeds[k : k + size] for k in range(0, len(seeds), size)]
    workers = min(len(chunks), jobs or _cores())
    if workers == 1:
        return joined([stress_crossing(controller, robots, chunk, kind, disturbance, begin) for chunk in chunks])
    advance = begin("crossings", len(chunks))
    with processes(workers, ["robotics.experiments.stress.outcome", "robotics.laws.catalogue"]) as crew:
        work = [crew.executor.submit(stress_crossing, controller, robots, chunk, kind, disturbance) for chunk in chunks]
        parts = []
        for future in work:
            parts.append(future.result())
            advance()
    return joined(parts)


def _cores() -> int:
    """How many cores this process may use."""
    return len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1
