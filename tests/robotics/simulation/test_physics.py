"""Other physics in the plant's place: a toy one, by its entry point."""

import sys

import numpy as np
import pytest

from robotics import load_scenario, simulate
from robotics.simulation.physics import PhysicsError, physics_of
from tests.conftest import declare

TOY = '''
from dataclasses import dataclass

from fuzzy.quantity import quantity
from robotics.world.vehicle.plant import TruthColumns


@dataclass(frozen=True)
class Conveyor:
    """A belt that carries robots along y, whatever they do."""

    speed: float = quantity(0.1, "m/s")

    def opened(self, setting, body):
        def move(k, body, order, stopped, lost):
            TruthColumns(body.truth).y += self.speed * setting.period

        return move
'''


@pytest.fixture
def conveyor(tmp_path, monkeypatch):
    (tmp_path / "belts.py").write_text(TOY, encoding="utf-8")
    declare(tmp_path, "belts", {"fuzzyfleet.plants": {"conveyor": "belts:Conveyor"}})
    monkeypatch.syspath_prepend(tmp_path)
    yield
    sys.modules.pop("belts", None)


def test_physics_of_another_package_moves_the_robots(conveyor):
    """By a law with an equation and by one of arrays alike: only what moves is another."""
    scenario = load_scenario("fuzzy-off-path")
    run = simulate(scenario, "lyapunov", plant="conveyor:speed=0.2")
    np.testing.assert_allclose(run["y"][0, 0] - run["y"][0, 0, 0], 0.2 * run.time, atol=1e-9)
    assert np.ptp(run["x"]) == 0
    assert run.scenario == "fuzzy-off-path in conveyor:speed=0.2"
    assert np.ptp(run["command_2"]) > 0.1, "the law sees it and commands"


def test_a_name_an_option_and_a_value_that_there_are_not(conveyor):
    for text, message in (
        ("belt", "unknown plant 'belt'"),
        ("conveyor:sped=1", "plant conveyor: unknown option 'sped'; did you mean 'speed'"),
        ("conveyor:speed", "plant conveyor: speed must be a finite number in m/s; got ''"),
    ):
        with pytest.raises(PhysicsError, match=message):
            physics_of(text)
