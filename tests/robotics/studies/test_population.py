"""Many laws in one pass: each run is the one that its law makes alone."""

from dataclasses import replace
from typing import Any

import numpy as np
import pytest

import robotics
from robotics.laws.law import Command, Law
from robotics.measures.registry import measure_all
from robotics.simulation.loop import simulate
from robotics.studies.population import PopulationError, simulate_many
from robotics.world.sensing.posture import LABORATORY

SCENARIO = replace(robotics.load_scenario("lyapunov-sine"), duration=2.0, sensing=LABORATORY)
TEAM = replace(robotics.load_scenario("concentric-circles"), duration=1.0)
LAWS = ("lyapunov", "lyapunov:kx=2", "fuzzy", "fuzzy:look_ahead=0.3", "fuzzy:rule_base=tracking-literal", "csm", "esm")


class Slow(Law[None]):
    """A law in plain numpy."""

    def init(self, setting, runs):
        """Remember nothing."""

    def control(self, seen, memory, dt):
        v, w = np.full_like(seen.x, 0.1), 0.5 * (seen.reference.y - seen.y)
        return Command(v, w, v, w), None


def same(one, other):
    return all(one.recorded[name].values.tobytes() == array.values.tobytes() for name, array in other.recorded.items())


@pytest.mark.parametrize("seeds", [(3,), (5, 1, 4)])
def test_every_run_is_the_one_that_its_law_makes_alone(seeds):
    laws: list[Any] = [*LAWS, Slow()]
    runs = simulate_many(SCENARIO, laws, seeds)
    for law, run in zip(laws, runs, strict=True):
        assert same(run, simulate(SCENARIO, law, seeds))
        assert run.seeds == seeds


def test_a_team_of_many_seeds_is_measured_as_its_runs_are_whatever_is_beside_it():
    laws = ("virtual-structure", "virtual-structure:kappa=2", "cooperation")
    seeds = range(40)
    found = simulate_many(TEAM, laws, seeds, keep="metrics", threads=2)
    alone = simulate_many(TEAM, laws, seeds, keep="metrics", threads=1)
    for place, law in enumerate(laws):
        run = simulate(TEAM, law, seeds)
        for name, numbers in measure_all(run).items():
            if name in found.metrics:
                np.testing.assert_array_equal(found[name][place], numbers)
                np.testing.assert_array_equal(alone[name][place], numbers)
        assert (found.stopped[place] == run.diverged).all()


def test_only_the_metrics_that_were_asked_for_are_measured():
    found = simulate_many(SCENARIO, LAWS[:2], (1, 2), keep="metrics", metrics=["rms_cross_track_m"])
    assert list(found.metrics) == ["rms_cross_track_m"]
    assert found["rms_cross_track_m"].shape == (2, 2, 1)
    with pytest.raises(PopulationError, match="did you mean 'rms_cross_track_m'"):
        simulate_many(SCENARIO, LAWS[:1], keep="metrics", metrics=["rms_cross_trak_m"])
    with pytest.raises(PopulationError, match="metric"):
        found["effort"]


def test_each_law_may_have_robots_of_its_own():
    heavy = [replace(member.robot, body_mass=2 * member.robot.body_mass) for member in SCENARIO.robots]
    own = [member.robot for member in SCENARIO.robots]
    laws = ("csm", "csm", "lyapunov")
    runs = simulate_many(SCENARIO, laws, (1, 2), robots=[own, heavy, heavy])
    for law, robots_of, run in zip(laws, (own, heavy, heavy), runs, strict=True):
        scenario = replace(
            SCENARIO, robots=tuple(replace(m, robot=r) for m, r in zip(SCENARIO.robots, robots_of, strict=True))
        )
        assert same(run, simulate(scenario, law, (1, 2)))
        assert run.about.robots == tuple(robots_of)
    with pytest.raises(PopulationError, match="robots must be 1 for each of 3 laws"):
        simulate_many(SCENARIO, laws, robots=[own, heavy])


def test_what_cannot_be_is_refused():
    with pytest.raises(PopulationError, match="at least one law"):
        simulate_many(SCENARIO, [])
    with pytest.raises(PopulationError, match="way to keep runs"):
        simulate_many(SCENARIO, ["lyapunov"], keep="numbers")  # type: ignore[call-overload]
    with pytest.raises(robotics.SimulationError, match="at least one seed"):
        simulate_many(SCENARIO, ["lyapunov"], [])


def test_progress_is_told_after_every_law():
    told = []
    one = ["rms_cross_track_m"]
    simulate_many(SCENARIO, LAWS, (1, 2), keep="metrics", metrics=one, progress=lambda: told.append(1))
    assert len(told) == len(LAWS)
