"""What every law can be given: a feed-forward read ahead, and a low-pass of its correction; against closed forms."""

import math
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
import pytest

from fuzzy.quantity import quantity
from robotics.laws.catalogue import gains_of, make_controller
from robotics.laws.equation import EquationLaw, equation
from robotics.laws.knowledge import Knowledge, KnowledgeError, share_of
from robotics.laws.law import ControllerError, Observation
from robotics.laws.setting import Setting
from robotics.laws.tracking.lyapunov import Lyapunov
from robotics.laws.tracking.sliding_mode import SlidingMode
from robotics.simulation.loop import Simulation, simulate
from robotics.simulation.run import Run
from robotics.simulation.scenario.description import Scenario
from robotics.simulation.scenario.reading import ScenarioError, load_scenario, parse_scenario
from robotics.simulation.scenario.robots import load_robot
from robotics.studies.tuning.space import LawSpace
from robotics.world.vehicle.wheel_loop import step_response, wheel_lag

SCENARIO = load_scenario("reference")


@equation
def offset(aim, gain):
    return aim.v + gain.more, aim.w - gain.more


@dataclass(frozen=True, kw_only=True)
class Offset(EquationLaw):
    """The velocity of the reference, and more."""

    more: float = quantity(0.0, "m/s")
    equation = offset


def commands(law: EquationLaw, scenario: Scenario = SCENARIO) -> np.ndarray:
    run = simulate(scenario, law, [0])
    return np.stack([run["v_demand"][0, 0], run["w_demand"][0, 0]])


def test_the_lead_reads_the_velocity_of_a_later_time_and_leaves_the_target_where_it_is() -> None:
    run = simulate(SCENARIO, Offset(lead=0.37), [0])
    later = SCENARIO.setting.references.sampled(run.time + 0.37)
    now = SCENARIO.setting.references.sampled(run.time)
    assert run["v_demand"][0, 0] == pytest.approx(later.v[:, 0], abs=1e-12)
    assert run["w_demand"][0, 0] == pytest.approx(later.w[:, 0], abs=1e-12)
    assert np.array_equal(run.target("v")[0], now.v[:, 0])
    assert np.array_equal(run.target("x")[0], now.x[:, 0])


def test_auto_is_latency_wheel_lag_and_half_a_period() -> None:
    robot = load_robot("etsro").robot
    setting = SCENARIO.setting
    assert setting.auto_lead("velocity") == pytest.approx([0.03 + wheel_lag(robot) + 0.025])
    assert setting.auto_lead("torque") == pytest.approx([0.03 + 0.025])  # nothing follows a torque
    kinematic = replace(SCENARIO, plant="kinematic", latency=0.1)
    assert kinematic.setting.auto_lead("velocity") == pytest.approx([0.1 + 0.025])
    # The wheel's lag is the area above its step response
    response = step_response(robot, "straight", 0.2)
    area = np.trapezoid(1 - response.speed / response.command, response.time)
    assert wheel_lag(robot) == pytest.approx(area, abs=0.01)
    assert np.array_equal(commands(Offset(lead="auto")), commands(Offset(lead=setting.auto_lead("velocity")[0])))


@pytest.mark.parametrize("latency", [0.0, 0.1, 0.3])
def test_with_it_a_robot_is_where_it_shall_be_and_without_it_late(latency: float) -> None:
    told = replace(SCENARIO, latency=latency)
    off = {}
    for law in (Lyapunov(lead=0.0), Lyapunov(lead="auto")):
        run = simulate(told, law, [0])
        late = run.time > 5
        off[law.lead] = np.hypot(run["x"] - run.target("x"), run["y"] - run.target("y"))[0, 0, late].max()
    assert off["auto"] < off[0.0] / 8


def test_the_low_pass_is_the_exponential_of_first_order() -> None:
    constant, period = 0.4, SCENARIO.period
    told = replace(SCENARIO, duration=5.0)
    v, w = commands(Offset(more=0.2, smooth=constant), told)
    time = told.times
    now = SCENARIO.setting.references.sampled(time)
    answer = 0.2 * (1 - np.exp(-(time + period) / constant))  # of a correction of 0.2 from the first period on
    assert v - now.v[:, 0] == pytest.approx(answer, abs=1e-12)
    assert w - now.w[:, 0] == pytest.approx(-answer, abs=1e-12)
    assert share_of(constant, period) == pytest.approx(1 - math.exp(-period / constant))
    assert share_of(0.0, period) == 1.0


def test_white_noise_of_the_command_is_less_by_the_root_of_share_over_two_less_share() -> None:
    noisy = parse_scenario(
        """
duration = 600.0
plant = "kinematic"
divergence = 100.0
sensing = { posture = "pose", position_noise = 0.01 }
[[robots]]
start = [0, 0, 0]
path = { shape = "line", start = [0, 0], end = [0.001, 0] }
timing = { duration = 600.0 }
""",
        "still",
    )
    law = Lyapunov(kx=0.01, ky=0.01, kpsi=0.01)
    share = share_of(0.3, noisy.period)
    rough, smooth = (np.std(simulate(noisy, replace(law, smooth=s), [1])["v_demand"]) for s in (0.0, 0.3))
    assert smooth / rough == pytest.approx(math.sqrt(share / (2 - share)), rel=0.03)


def test_scenarios_give_it_to_every_law_that_can_use_it_and_a_law_can_say_otherwise() -> None:
    given = replace(SCENARIO, knowledge=Knowledge(lead="auto", smooth=0.2))
    of_law = commands(Lyapunov(lead="auto", smooth=0.2))
    assert np.array_equal(commands(Lyapunov(), given), of_law)
    assert np.array_equal(commands(Lyapunov(lead=0.0, smooth=0.0), given), commands(Lyapunov()))
    for name in ("nmpc", "fuzzy", "right-of-way"):  # what cannot use it drives as before
        law = make_controller(name)
        assert isinstance(law, EquationLaw)
        lead, share, *_ = law.knowledge_rows(given.setting)
        assert lead == 0.0
        assert (share == 1.0) == (name == "right-of-way")


def test_it_stands_in_a_file() -> None:
    path = 'path = { shape = "line", start = [0, 0], end = [3, 0] }'
    text = f"[[robots]]\nstart = [0, 0, 0]\n{path}\ntiming = {{ duration = 20 }}\n"
    read = parse_scenario(f'{text}[knowledge]\nlead = "auto"\nsmooth = 0.2\n', "mine")
    assert read.setting.knowledge == Knowledge(lead="auto", smooth=0.2)
    for wrong in ('lead = "soon"', "lead = -0.1", "smooth = true"):
        with pytest.raises(ScenarioError, match=r":6: (lead|smooth) must be a finite number in s, >= 0"):
            parse_scenario(f"{text}[knowledge]\n{wrong}\n", "mine")
    with pytest.raises(KnowledgeError, match=r'lead must be .*, or "auto"'):
        Knowledge(lead=9.0)


@pytest.mark.parametrize(
    ("specification", "why"),
    [
        ("fuzzy:lead=auto", "its target is look_ahead ahead"),
        ("nmpc:lead=0.1", "reads its reference ahead by its own model"),
        ("csm:smooth=0.2", "commands torques"),
        ("right-of-way:smooth=0.1", "delay its braking"),
        ("cooperation:lead=auto", "does not drive by the velocity of the reference"),
        ("lyapunov:lead=now", "\"auto\"; got 'now'"),
    ],
)
def test_a_law_that_cannot_have_it_says_why(specification: str, why: str) -> None:
    with pytest.raises(ControllerError, match=why):
        make_controller(specification)


def test_it_is_no_matter_of_a_part() -> None:
    with pytest.raises(ControllerError, match="lead belongs to SlidingMode, not to its part outer"):
        SlidingMode(outer=Lyapunov(lead=0.1))
    assert make_controller("esm:lead=0.1").lead == 0.1  # type: ignore[attr-defined]
    with pytest.raises(TypeError, match=r"Mine\.lead: every law has a gain of that name"):

        class Mine(EquationLaw):
            lead: float = 0.4


def test_it_is_a_gain_where_it_is_said_and_a_number_of_it_can_be_tuned() -> None:
    assert "lead" not in gains_of(make_controller("lyapunov"))
    assert gains_of(make_controller("lyapunov:lead=auto,smooth=0.2"))["lead"] == "auto"
    found = [p.name for p in LawSpace(make_controller("lyapunov:lead=auto,smooth=0.2")).parameters]
    assert "smooth" in found
    assert "lead" not in found
    assert "lead" in [p.name for p in LawSpace(make_controller("lyapunov:lead=0.09")).parameters]


def test_the_loop_in_python_and_the_law_by_hand_do_the_same() -> None:
    law, setting = make_controller("lyapunov:lead=auto,smooth=0.2"), replace(SCENARIO, duration=3.0).setting
    run = simulate(replace(SCENARIO, duration=3.0), law, [4])
    stepped = Simulation(setting, law, (4,))
    for k, command in stepped.periods():
        assert (command.v[0, 0], command.w[0, 0]) == (run["v_demand"][0, 0, k], run["w_demand"][0, 0, k])
    by_hand(law, setting, run)


def by_hand(law: Any, setting: Setting, run: Run) -> None:
    memory = law.init(setting, 1)
    for k, time in enumerate(run.time):
        now = setting.references.sampled(np.array([time]))
        still = np.zeros((1, 1))  # this law reads no encoders
        seen = [run[name][:, :, k] for name in ("x_measured", "y_measured", "heading_measured")]
        aim = type(now)(*(row[0][None] for row in now))
        command, memory = law.control(
            Observation(float(time), seen[0], seen[1], seen[2], still, still, aim, setting.references),
            memory,
            setting.period,
        )
        assert command.v[0, 0] == pytest.approx(run["v_demand"][0, 0, k], abs=1e-12)
