"""Courses that several tracking laws are asked on."""

from dataclasses import replace

import numpy as np

from robotics.simulation.scenario.reading import load_scenario


def from_random_starts(scenario, low, high, count=120, **changes):
    """The scenario, 30 ms late, with robots at places from ``low`` to ``high`` [m, m, rad], all at once."""
    scenario = replace(load_scenario(scenario), latency=0.03, **changes)
    starts = np.random.default_rng(3).uniform(low, high, (count, 3)).tolist()
    members = tuple(replace(scenario.robots[0], start=tuple(start)) for start in starts)
    return replace(scenario, robots=members)
