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

from fuzzy.compiled.columns import codes
from robotics.laws.equation import EquationLaw, equation
from robotics.laws.law import Law
from robotics.plugins.arena.description import Arena
from robotics.simulation.loop import simulate
from robotics.simulation.scenario.description import Scenario
from robotics.world.vehicle.plant import Level

REPEATS = 15  # of which the quickest counts: what else the machine does only adds
SEEDS = 8  # runs that are driven at a time
_LONG = 2.0  # s: fewer repeats where one takes long
_LEVEL = codes(Level)
_LEAST = 0.01  # µs: what is less is lost in the measurement


@equation
def _nothing(aim, gain):  # type: ignore[no-untyped-def]
    """Command the reference's velocity, or no torques."""
    share = 1.0 if gain.at == _LEVEL.velocity else 0.0
    return share * aim.v, share * aim.w


@dataclass(frozen=True, kw_only=True)
class NullLaw(EquationLaw):
    """A law that computes nothing: what a simulation takes without one."""

    at: Level = "velocity"
    equation = _nothing

    @property
    def level(self) -> Level:
        """That of the law that it stands beside, since the plant does other work for torques."""
        return self.at


@dataclass(frozen=True)
class Timed:
    """What was timed of a law."""

    period: float  # µs: what the law computes a period
    run: float  # s: what a whole run of one robot takes, with all there is to it


def timed(arena: Arena, law: str) -> Timed:
    """Time a law on the first scenario that is tuned on. The first runs, which may compile, are not counted."""
    scenario, made = arena.scenarios("tune")[0], arena.law(law)
    pair = made, NullLaw(at=made.level)
    for one in pair:
        simulate(scenario, one, [0], threads=1)
    rows: list[tuple[float, float]] = []
    while len(rows) < REPEATS and np.sum(rows) < _LONG:
        rows.append((_seconds(scenario, pair[0]), _seconds(scenario, pair[1])))
    whole, without = (float(v) for v in np.min(rows, axis=0))
    return Timed(max(1e6 * (whole - without) / (SEEDS * scenario.ticks), _LEAST), whole / SEEDS)


def _seconds(scenario: Scenario, law: Law[Any]) -> float:
    """What the runs of SEEDS robots take, driven by one thread."""
    began = time.perf_counter()
    simulate(scenario, law, range(SEEDS), threads=1)
    return time.perf_counter() - began


def machine() -> str:
    """This machine in a few words."""
    return f"{platform.machine()}, {os.cpu_count()} cores, {platform.system()}"
