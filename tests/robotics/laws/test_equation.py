"""Laws that are derived from laws with an equation, and laws that are called by hand."""

from dataclasses import dataclass, replace
from typing import Any

import numpy as np
import pytest

from fuzzy.compiled.columns import ColumnError, Columns, column
from robotics.laws.catalogue import CATALOGUE, gains_of, make_controller
from robotics.laws.equation import EquationLaw, equation
from robotics.laws.law import ControllerError, Observation
from robotics.laws.tracking.lyapunov import Lyapunov
from robotics.laws.tracking.pid import TrackingPID
from robotics.simulation.loop import drive, simulate
from robotics.simulation.opening import has_equation
from robotics.simulation.scenario.reading import load_scenario

SCENARIO = replace(load_scenario("lyapunov-sine"), duration=1.0)


@dataclass(frozen=True, kw_only=True)
class Slower(Lyapunov):
    """Half as fast as the law that it is derived from."""

    def control(self, seen, memory, dt):
        """Halve what the law says."""
        command, memory = super().control(seen, memory, dt)
        v, w = command.first / 2, command.second / 2
        return command._replace(first=v, second=w, v=v, w=w), memory


@dataclass(frozen=True, kw_only=True)
class Renamed(Lyapunov):
    """Another name, and nothing else."""


def test_a_derived_law_drives_by_the_control_that_it_defines():
    assert not has_equation(Slower())
    assert has_equation(Renamed())
    slow, fast = (simulate(SCENARIO, law, (1,)) for law in (Slower(), Lyapunov()))
    np.testing.assert_array_equal(slow["command_1"][0, 0, :1], fast["command_1"][0, 0, :1] / 2)
    assert slow["x"][0, 0, -1] < fast["x"][0, 0, -1] - 0.05
    assert simulate(SCENARIO, Renamed(), (1,)).samples.tobytes() == fast.samples.tobytes()


def test_a_law_that_is_called_by_hand_needs_the_memory_that_it_gave():
    seen, *_ = list(drive(SCENARIO.setting, Lyapunov(), (1,)))
    x, y, heading = seen.posture
    known = Observation(0.0, x, y, heading, seen.v, seen.w, seen.reference, SCENARIO.setting.references)
    with pytest.raises(ControllerError, match=r"Lyapunov\.control needs the memory that its init"):
        Lyapunov().control(known, None, 0.05)
    command, _ = Lyapunov().control(known, Lyapunov().init(SCENARIO.setting, 1), 0.05)
    np.testing.assert_array_equal(command.first, seen.command.first)


def test_every_law_of_the_catalogue_has_an_equation():
    for name in CATALOGUE:
        law = make_controller(name)
        assert isinstance(law, EquationLaw), name
        assert has_equation(law), name


class Count(Columns):
    """What laws here remember."""

    turns = column("1")


def test_a_misspelt_column_is_an_error_where_the_law_is_defined():
    def counts(gain, memory):
        memory.trns = 1.0
        return gain.v, 0.0

    def asks(robot, gain):
        return robot.sped, gain.v

    def commands(command):
        command.target.headin = 0.0

    def adjusts(gain):
        return gain.w, 0.0

    cases: list[tuple[Any, str]] = [
        (counts, "Count: unknown column 'trns'; did you mean 'turns'"),
        (asks, "RobotColumns: unknown column 'sped'. Known: x, y, heading, v, w"),
        (commands, "AimColumns: unknown column 'headin'; did you mean 'heading'"),
        (adjusts, "Wrong.gain: unknown column 'w'. Known: v"),
    ]
    for wrong, says in cases:
        line = wrong.__code__.co_firstlineno + 1
        with pytest.raises(ColumnError, match=rf"test_equation\.py:{line}: {says}"):

            class Wrong(EquationLaw):
                v: float = 1.0
                equation, remembers = equation(wrong), Count


def test_an_equation_asks_only_for_what_there_is():
    with pytest.raises(ControllerError, match="steer: unknown argument of an equation 'goal'; did you mean 'road'"):

        @equation
        def steer(robot, goal):
            return robot.v, 0.0


@dataclass(frozen=True, kw_only=True)
class Later(TrackingPID):
    """A gain before the numbers that the law derives: its rows are others."""

    patience: float = 1.0


def test_a_derived_law_with_a_gain_more_drives_as_before():
    mine, its = (simulate(SCENARIO, law, (1,)).samples for law in (Later(), TrackingPID()))
    assert mine.tobytes() == its.tobytes()


def test_a_helper_that_is_not_compiled_is_a_sentence(tmp_path):
    (tmp_path / "mine.py").write_text(
        "from dataclasses import dataclass\n"
        "from robotics.laws.equation import EquationLaw, equation\n"
        "def base(x):\n    return 2 * x\n"
        "@dataclass(frozen=True, kw_only=True, eq=False)\n"
        "class Mine(EquationLaw):\n"
        "    @equation\n"
        "    def equation(robot, aim):\n"
        "        return base(aim.v), aim.w\n"
    )
    with pytest.raises(
        ControllerError, match=r"mine\.py: Mine\.equation calls base, a function of Python; put @compil"
    ):
        simulate(load_scenario("lyapunov-sine"), f"{tmp_path / 'mine.py'}:Mine")


def test_a_field_that_is_no_law_is_no_part(tmp_path):
    (tmp_path / "mine.py").write_text(
        "from dataclasses import dataclass, field\n"
        "from robotics.laws.catalogue import make_controller\n"
        "from robotics.laws.equation import EquationLaw, equation\n"
        "@dataclass(frozen=True, kw_only=True, eq=False)\n"
        "class Mine(EquationLaw):\n"
        "    rules: object = field(default_factory=lambda: make_controller('fuzzy').fuzzy_systems['tracking'])\n"
        "    @equation\n"
        "    def equation(robot, aim):\n"
        "        return aim.v, aim.w\n"
    )
    law = make_controller(f"{tmp_path / 'mine.py'}:Mine")
    assert gains_of(law)["rules"].name == "tracking"
