"""The simpler reactive laws: who waits goes on when the way is free, and a field pushes away."""

import numpy as np
import pytest

from robotics.laws.catalogue import as_law
from robotics.laws.law import ControllerError
from robotics.plugins.stress.obstaclecourse import obstacle_ensemble
from robotics.plugins.stress.outcome import StressOutcome
from robotics.plugins.stress.tally import run_ensemble
from robotics.simulation.loop import simulate
from robotics.simulation.scenario.reading import parse_scenario

SCENARIO = """
duration = 60.0
[[robots]]
start = [0.0, 0.0, 0.0]
path = {{ shape = "line", start = [0.0, 0.0], end = [4.0, 0.0] }}
timing = {{ duration = 20.0 }}
[[sensors]]
preset = "sonar"
[[obstacles]]
shape = "disc"
radius = 0.2
position = {position}
{moving}
"""


def positions(law, position="[2.0, 0.0]", moving=""):
    scenario = parse_scenario(SCENARIO.format(position=position, moving=moving), "alone")
    run = simulate(scenario, as_law(law), [0])
    return run["x"][0, 0], run["y"][0, 0]


def test_who_waits_stands_before_what_stands():
    x, y = positions("stop-and-wait")
    assert x[-1] == pytest.approx(x[-200], abs=1e-3)
    assert 1.2 < x[-1] < 2.0 - 0.2 - 0.115
    assert abs(y).max() < 0.02


def test_who_waits_goes_on_when_the_way_is_free():
    moving = 'path = { shape = "line", start = [2.0, 0.0], end = [2.0, 3.0] }\ntiming = { duration = 30.0 }'
    x, _ = positions("stop-and-wait", "[0.0, 0.0]", moving)
    assert x[-1] == pytest.approx(4.0, abs=0.05)


def test_without_its_look_ahead_it_drives_into_it():
    seeds = range(12)
    ensemble = obstacle_ensemble(seeds, "A", 1)
    caused = [
        run_ensemble(StressOutcome, ensemble, as_law(law), seeds).caused.any(axis=1).sum()
        for law in ("stop-and-wait", "stop-and-wait:near=0.001,beside=0.001,delay=0.001,braking=20")
    ]
    assert caused[0] == 0
    assert caused[1] >= 2


@pytest.mark.parametrize(("side", "sign"), [("[1.5, 0.28]", -1), ("[1.5, -0.28]", 1)])
def test_a_field_pushes_away_from_what_is_beside_the_way(side, sign):
    x, y = positions("potential-field", side)
    beside = y[np.argmin(abs(x - 1.5))]
    assert sign * beside > 0.03
    far = positions("potential-field:influence=0.05", side)[1]
    assert abs(far).max() < abs(beside)


def test_numbers_out_of_range_are_said():
    with pytest.raises(ControllerError, match="near must be"):
        as_law("stop-and-wait:near=-1")
