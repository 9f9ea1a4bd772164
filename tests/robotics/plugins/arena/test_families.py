"""Random scenarios, and the blocks that they make."""

from dataclasses import replace

import numpy as np
import pytest

import robotics
from robotics.plugins.arena.families import RAMP, STAND, Conditions, Family
from robotics.plugins.arena.kinds import arena_names, load_plan
from robotics.plugins.arena.plan import BLOCKS, ArenaError

PATHS = ("sine", "winding", "circle", "eight", "corners")


@pytest.mark.parametrize("path", PATHS)
def test_a_number_is_a_scenario(path):
    family = Family(path=path, slowest=0.2, fastest=0.3, tightest=0.5, offset=0.2, duration=15.0)
    one, same, other = (family.scenario(n, Conditions()) for n in (1_000_000, 1_000_000, 1_000_001))
    assert repr(one) == repr(same)
    assert one.robots[0] != other.robots[0]
    reference = one.trajectory.sampled(one.times)
    cruising = (one.times > RAMP) & (one.times < one.times[-1] - STAND - RAMP - 0.1)
    assert cruising.sum() > 12 / 0.05
    assert np.all((reference.v[cruising] > 0.199) & (reference.v[cruising] < 0.301))
    assert not reference.v[one.times > one.times[-1] - STAND + 0.1].any()  # it stands at the end
    assert np.abs(np.diff(np.unwrap(reference.heading[:, 0]))).max() < 0.301 * 0.05 / 0.5 * 1.03
    beside = np.array(one.robots[0].start[:2]) - [reference.x[0, 0], reference.y[0, 0]]
    ahead = np.array([np.cos(reference.heading[0, 0]), np.sin(reference.heading[0, 0])])
    assert np.linalg.norm(beside) <= 0.2
    assert abs(beside @ ahead) < 1e-9


def test_a_load_is_carried_and_known():
    heavy = Family(path="circle", load=2.3).scenario(7, Conditions()).robots[0].robot
    light = Family(path="circle").scenario(7, Conditions()).robots[0].robot
    assert heavy.body_mass == pytest.approx(light.body_mass + 2.3)
    assert heavy.body_inertia / light.body_inertia == pytest.approx(heavy.body_mass / light.body_mass)
    assert (heavy.kp, heavy.ki) == (light.kp, light.ki)


def test_a_family_that_cannot_be_driven_is_refused_in_words():
    with pytest.raises(ArenaError, match=r"circle: 40 scenarios were drawn, and none can be driven: .* infeasible"):
        Family(path="circle", slowest=0.9, fastest=1.0).scenario(1, Conditions())
    with pytest.raises(ArenaError, match=r"slowest must be <= fastest, 0\.3"):
        Family(path="circle", slowest=0.4)


@pytest.mark.parametrize("name", [name for name in arena_names() if load_plan(name).kind == "tracking"])
def test_the_blocks_of_an_arena_have_nothing_in_common(name):
    arena = robotics.load_arena(name)
    tuned = {arena.tuning_seed(r) + n for r in range(arena.repeats) for n in range(arena.runs)}
    seeds = [tuned, {*arena.seeds("choose")}, {*arena.seeds("test")}]
    assert len(set.union(*seeds)) == sum(map(len, seeds))
    assert min(map(min, seeds)) >= 1_000_000  # none of those of ordinary commands
    scenarios = [scenario for block in BLOCKS for scenario in arena.scenarios(block)]
    paths = {repr(scenario.robots[0].path) for scenario in scenarios}
    assert len(paths) == len(scenarios)
    assert len(arena.unseen_sorts) >= 4
    others = [replace(f, title="") for f in arena.tune]
    assert not any(replace(f, title="") in others for f in arena.test if f.label in arena.unseen_sorts)


def test_the_default_arena_is_as_large_as_it_says():
    arena = robotics.load_arena()
    assert len(arena.laws) >= 10
    assert len(arena.scenarios("test")) >= 32
    assert (arena.testing_runs, arena.evaluations, arena.repeats, len(arena.engines)) == (25, 300, 2, 2)
    assert arena.runs * len(arena.scenarios("tune")) == 10
    full = robotics.load_arena("full")
    assert (full.evaluations, full.runs, full.repeats) == (1000, 20, 5)
    assert (full.laws, full.test) == (arena.laws, arena.test)
