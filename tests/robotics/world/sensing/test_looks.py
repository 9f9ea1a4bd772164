"""The step that reads range sensors in a simulation: both loops, any sharing out, moving obstacles, other sensors."""

from dataclasses import dataclass, replace
from typing import ClassVar

import numpy as np
import pytest

from robotics.laws.equation import EquationLaw, equation
from robotics.plugins.stress.obstaclecourse import obstacle_ensemble
from robotics.simulation.loop import drive, driven, record_run
from robotics.simulation.opening import Driver, PreparedRuns
from robotics.simulation.recorder import Recorder
from robotics.simulation.scenario.reading import load_scenario
from robotics.world.environment.collision import footprints
from robotics.world.environment.world import Disc, Wall
from robotics.world.paths.path import Line
from robotics.world.paths.trajectory import Timing
from robotics.world.sensing.sonar import SONAR, RangeSensor
from tests.robotics.world.sensing.echoes import exact_echoes


@equation
def brake(known, lane):
    """Drive straight on, the slower the less the sensors read."""
    nearest = min(known.ranges[0, lane], known.ranges[1, lane], 2.0)
    return 0.2 * nearest, 0.0


@dataclass(frozen=True, kw_only=True)
class Brake(EquationLaw):
    """Drives straight on and looks."""

    needs: ClassVar[tuple[str, ...]] = ("right", "front-left")
    equation: ClassVar = brake


CROSSING = Disc(radius=0.2, path=Line(start=(1.0, -1.5), end=(1.0, 1.5)), timing=Timing(speed=0.5), orientation="fixed")


@pytest.fixture(scope="module")
def scenario():
    course = load_scenario("obstacles-on-two-paths")
    arm = Wall(points=((0.3, 0.0), (0.6, 0.3)), path=CROSSING.path, timing=CROSSING.timing, position=(0.0, 0.2))
    failing = {name: replace(s, failure_start=1.0, failure_end=2.0) for name, s in SONAR.items()}
    often = {"rear": RangeSensor(axis=3.0, period=0.1), **{n: replace(s, period=0.15) for n, s in SONAR.items()}}
    robots = course.robots
    robots = (robots[0], replace(robots[1], sensors=failing), replace(robots[2], sensors=often), *robots[3:])
    return replace(course, duration=3.0, obstacles=(*course.obstacles, CROSSING, arm), robots=robots)


def test_both_loops_read_the_same(scenario):
    run = record_run(scenario.setting, Brake(), (3, 8), name="brake")
    assert (np.isfinite(run.ranges).mean(axis=(0, 1)) > 0.05).any()
    for k, state in enumerate(drive(scenario.setting, Brake(), (3, 8))):
        np.testing.assert_array_equal(run.ranges[k], state.ranges.values.astype(np.float32))
        np.testing.assert_array_equal(run.samples[k, :5], state.truth[:5])


def test_the_sensors_see_obstacles_where_they_are_in_each_period(scenario):
    sensors = {name: replace(s, noise=0.0, relative_noise=0.0, minimum=0.0) for name, s in SONAR.items()}
    quiet = replace(scenario, sensors=sensors, robots=tuple(replace(r, sensors=None) for r in scenario.robots))
    sizes, seen = footprints(quiet.setting.robots), 0
    for state in drive(quiet.setting, Brake(), (3,)):
        x, y, heading = state.truth[:3]
        here = quiet.setting.world.at(state.time)
        expected = exact_echoes([*sensors.values()], x, y, heading, sizes, here)
        np.testing.assert_array_equal(state.ranges.values, expected)
        seen += np.isfinite(expected).sum()
    assert seen > 100


def ranges_of(seeds, threads=None):
    """What robots on courses of their own, whose obstacles move, read in 20 periods."""
    setting = replace(obstacle_ensemble(seeds, "A", 3, moving=2), ticks=20)
    recorder = Recorder(setting, Brake(), len(seeds))
    driven(PreparedRuns.of([Driver(setting, Brake())], seeds), recorder.observer, lambda more: None, threads)
    return recorder.arrays["ranges"]


def test_a_run_of_an_ensemble_reads_what_it_reads_alone():
    """40 runs of 3 robots are more than one chunk."""
    together = ranges_of(tuple(range(40)), threads=1)
    assert 0.05 < np.isfinite(together).mean() < 0.95
    for n in (0, 17, 39):
        np.testing.assert_array_equal(ranges_of((n,))[:, 0], together[:, n])
    np.testing.assert_array_equal(ranges_of(tuple(range(40)), threads=3), together)
