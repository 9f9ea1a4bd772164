"""How long laws compute, measured on this machine: what no other number of an arena depends on.

A robot's run is timed under the law, and under a law that commands the reference's velocity and computes nothing; the
difference over the number of periods is the law's.
"""

import os
import platform
import time
from dataclasses import dataclass
from typing import Any

import numpy as np

from robotics.arena.description import Arena
from robotics.laws.equation import AT_V, AT_W, FIRST, SECOND, WISH_V, WISH_W, EquationLaw, equation
from robotics.laws.law import Law
from robotics.laws.setting import Setting
from robotics.scenario.description import Scenario
from robotics.simulation.loop import simulate

REPEATS = 7  # of which the median counts
SEEDS = 4  # runs that are driven at a time
LEAST = 0.05  # µs: what is less is lost in the measurement


@equation
def _feed_forward(i, known, memory, command, work):  # type: ignore[no-untyped-def]
    """Command the reference's velocity."""
    command[FIRST, i] = command[WISH_V, i] = known.seen[AT_V, i]
    command[SECOND, i] = command[WISH_W, i] = known.seen[AT_W, i]


@dataclass(frozen=True, kw_only=True)
class FeedForward(EquationLaw):
    """A law that looks at nothing: what a simulation takes without one."""

    equation = _feed_forward

    def gain_rows(self, setting: Setting) -> list[Any]:
        """It has no gains."""
        return []


@dataclass(frozen=True)
class Timed:
    """What was timed of a law."""

    period: float  # µs: what the law computes a period, the median over runs
    run: float  # s: what a whole run of one robot takes, with all there is to it


def timed(arena: Arena, law: str) -> Timed:
    """Time a law on the first scenario that is tuned on. The first run, which may compile, is not counted."""
    scenario = arena.scenarios("tune")[0]
    whole, without = _seconds(scenario, arena.law(law)), _seconds(scenario, FeedForward())
    periods = SEEDS * scenario.ticks
    return Timed(max(1e6 * (whole - without) / periods, LEAST), whole / SEEDS)


def _seconds(scenario: Scenario, law: Law[Any]) -> float:
    """What the runs of SEEDS robots take, driven by one thread."""
    simulate(scenario, law, [0], threads=1)
    found: list[float] = []
    while len(found) < REPEATS and sum(found) < 2.0:
        began = time.perf_counter()
        simulate(scenario, law, range(SEEDS), threads=1)
        found.append(time.perf_counter() - began)
    return float(np.median(found))


def machine() -> str:
    """This machine in a few words."""
    return f"{platform.machine()}, {os.cpu_count()} cores, {platform.system()}"
