"""The equations of the fuzzy team and of rule bases of one's own say, in the same situations, what arrays say."""

from collections.abc import Callable, Sequence
from itertools import product
from typing import Any

import numpy as np
import pandas as pd
import pytest

from fuzzy.files.fisfile import read_fis
from robotics.laws.law import ControllerError
from robotics.laws.rules.formation_networks import FormationNetworks, RobotNetworks
from robotics.laws.rules.fuzzy_team import FuzzyTeam
from robotics.laws.rules.own_rules import RULE_OUTPUTS, OwnRules, PerceivingRules
from robotics.laws.rules.quantities import PATTERNS, RULE_QUANTITIES
from robotics.plugins.stress.crossings import crossing_ensemble, stress_crossing
from robotics.plugins.stress.disturbance import UNDISTURBED, Disturbance
from robotics.plugins.stress.obstaclecourse import obstacle_ensemble
from robotics.simulation.channels import RECORDS
from robotics.simulation.loop import Simulation, simulate
from robotics.simulation.scenario.reading import load_scenario, parse_scenario
from robotics.simulation.scenario.robots import load_robot
from tests.robotics.laws.rules.arrayform.laws import InterpretedTeam
from tests.robotics.laws.rules.arrayteam import BothTeams
from tests.robotics.laws.rules.handmade import linear_base

EXACT = 1e-9  # m, rad, ...: numpy's cosines and exponentials differ from those of compiled code in the last bit
HARD = Disturbance(loss=0.2, latency=0.3, freeze=6.0)
CASES: dict[str, tuple[Callable[..., Any], tuple[Any, ...], dict[str, Any]]] = {
    "crossings": (crossing_ensemble, (3,), {}),
    "crossings of four, ends near paths": (crossing_ensemble, (4,), {"kind": "B"}),
    "obstacles, alone": (obstacle_ensemble, (), {}),
    "obstacles": (obstacle_ensemble, (), {"kind": "A", "robots": 3, "moving": 2}),
    "obstacles, tight": (obstacle_ensemble, (), {"kind": "B", "robots": 3}),
    "traps": (obstacle_ensemble, (), {"kind": "U", "robots": 3}),
}


def check(
    ensemble: Any, team: FuzzyTeam | OwnRules, seeds: Sequence[int], disturbance: Disturbance, periods: int
) -> None:
    """Drive at most so many periods, and hold what the two forms said against each other."""
    both, faults = BothTeams(team=team), disturbance.faults(ensemble, seeds)
    for k, _ in Simulation(ensemble, both, tuple(seeds), faults).periods():
        if k >= periods:
            break
    assert len(both.farthest) > 15
    assert {name: worst for name, worst in both.farthest.items() if not worst <= EXACT} == {}


def ensemble(case: str, seeds: Sequence[int], disturbance: Disturbance, **more: Any) -> Any:
    make, first, options = CASES[case]
    given = (*first, seeds) if first else (seeds,)
    return make(*given, **options, **more, disturbance=disturbance)


@pytest.mark.parametrize("case", CASES)
def test_it_says_the_same(case: str) -> None:
    check(ensemble(case, range(2), HARD), FuzzyTeam(), range(2), HARD, 150)


@pytest.mark.long
@pytest.mark.parametrize("disturbance", [UNDISTURBED, HARD])
@pytest.mark.parametrize("case", CASES)
def test_it_says_the_same_to_the_end(case: str, disturbance: Disturbance) -> None:
    check(ensemble(case, range(8), disturbance), FuzzyTeam(), range(8), disturbance, 1000)


@pytest.mark.parametrize("robot", ["mir100", "pioneer-3dx", "turtlebot3-burger"])
def test_it_says_the_same_of_other_robots(robot: str) -> None:
    check(ensemble("obstacles", range(1), HARD, robot=load_robot(robot)), FuzzyTeam(), range(1), HARD, 120)


def test_it_says_the_same_on_a_plan() -> None:
    check(ensemble("crossings", range(6), HARD), FuzzyTeam(plan="reservation"), range(6), HARD, 150)


ALONE = tuple(name for name, q in RULE_QUANTITIES.items() if not q.pair)
PAIRS = tuple(name for name, q in RULE_QUANTITIES.items() if q.pair)
SOME = "target_v:0.5", "target_w:1", "target_curvature:2.5", "range:front-left", "range:right"
NUMBERED = tuple(name.replace("N", n) for name in PATTERNS if name.startswith("robotN_") for n in "12")


def bases(folder: Any, names: dict[str, Sequence[str]], rules: int) -> dict[str, Any]:
    """Rule bases, by their tasks, of inputs of these names."""
    outputs = {"cooperation": "rate", "crash": "speed", "obstacles": "turn", "supervisor": "cooperation"}
    return {
        f"{task}_rule_base": str(
            linear_base(
                folder / f"{task}.fis",
                dict.fromkeys(inputs, (-9.0, 9.0)),
                {outputs[task]: [*([0.02] * len(inputs)), 0.5]},
                rules,
            )
        )
        for task, inputs in names.items()
    }


STEERED: dict[str, dict[str, float]] = {  # outputs, each with its constant
    "turned": {"turn": 0.1, "speed": 0.3},
    "itself": {"v": 0.2, "w": 0.1},
    "factor": {"speed_factor": 0.8, "keep": 1.0, "turn": 0.2},
    "corrected": {"dv": 0.02, "dw": 0.05, "bend": 0.1},
    "clocked": {"rate": 0.7, "bend": 0.2},
    "late": {"rate": 0.7, "speed": 0.4},
}


ASKED = {"alone": ALONE, "pairs": (*PAIRS, "y_err", "late"), "numbered": (*NUMBERED, *SOME)}
FEW = {("obstacles", *pair) for pair in zip(STEERED, [*ASKED, *ASKED], strict=True)}
EVERY = [
    pytest.param(*one, marks=() if one in FEW else pytest.mark.long)
    for one in product(("obstacles", "crossings"), STEERED, ASKED)
]


@pytest.mark.parametrize(("case", "outputs", "asked"), EVERY)
def test_a_rule_base_of_ones_own_says_the_same(case: str, outputs: str, asked: str, tmp_path: Any) -> None:
    names = [name for name in ASKED[asked] if case == "obstacles" or not name.startswith("range")][:32]
    given = {name: [*([0.003] * len(names)), constant] for name, constant in STEERED[outputs].items()}
    base = linear_base(tmp_path / "own.fis", dict.fromkeys(names, (-9.0, 9.0)), given)
    law = OwnRules(rule_base=str(base), leader=2.0 if asked == "alone" else 0.0)
    assert isinstance(law, PerceivingRules)
    check(ensemble(case, range(2), HARD), law, range(2), HARD, 60)


def test_a_rule_base_of_the_room_may_have_a_lead_where_it_corrects(tmp_path: Any) -> None:
    def law(**outputs: float) -> OwnRules:
        given = {name: [0.0, value] for name, value in outputs.items()}
        return OwnRules(rule_base=str(linear_base(tmp_path / "own.fis", {"front": (0.0, 9.0)}, given)), lead=0.1)

    assert law(bend=0.1).lead == 0.1
    with pytest.raises(ControllerError, match="lead is nothing for PerceivingRules"):
        law(turn=0.1)
    assert {*STEERED["turned"]} < {*RULE_OUTPUTS}


@pytest.mark.parametrize("rules", [0, 1])
@pytest.mark.parametrize("case", ["crossings", "obstacles"])
def test_it_knows_every_quantity(case: str, rules: int, tmp_path: Any) -> None:
    half = len(ALONE) // 2
    numbered = [*NUMBERED, *(name for name in SOME if case == "obstacles" or not name.startswith("range"))]
    together: dict[str, Sequence[str]] = {"cooperation": ALONE[:half], "crash": (*PAIRS, "v"), "supervisor": numbered}
    apart: dict[str, Sequence[str]] = {"cooperation": ALONE[half:]}
    for names in (together, apart):
        team = FuzzyTeam(**bases(tmp_path, names, rules))
        check(ensemble(case, range(2), HARD), team, range(2), HARD, 150)


def outcomes(stress: Callable[[Any], Any]) -> tuple[pd.DataFrame, pd.DataFrame]:
    return stress(FuzzyTeam()).table, stress(InterpretedTeam()).table


@pytest.mark.parametrize("runs", [10, pytest.param(100, marks=pytest.mark.long)])
def test_whole_crossings_end_alike(runs: int) -> None:
    own, arrays = outcomes(lambda law: stress_crossing(law, 3, range(runs)))
    pd.testing.assert_frame_equal(own, arrays, rtol=0.0, atol=0.051)


def test_what_a_run_records_is_there_from_both() -> None:
    scenario = load_scenario("three-cross")
    own, arrays = (simulate(scenario, law(), (3,)) for law in (FuzzyTeam, InterpretedTeam))
    assert own.recorded.keys() == arrays.recorded.keys()
    early = own.time < 20.0
    for name in ("samples", "inputs", "modes", "guarded"):
        axis = RECORDS[name].axes.index("sample")
        one, other = (np.compress(early, run.recorded[name].values, axis) for run in (own, arrays))
        np.testing.assert_allclose(one, other, rtol=0, atol=1e-6, err_msg=name)


ROUND = (
    """
kind = "formation"
duration = 31.0
[sensing]
posture = "pose"
position_noise = 0.003
heading_noise = 0.003
[radio]
graph = "complete"
period = 0.05
"""
    + "".join(
        f"""
[[robots]]
start = [{radius}, 0.05, 1.6]
path = {{ shape = "circle", radius = {radius} }}
timing = {{ duration = 30.0 }}
"""
        for radius in (0.8, 1.2, 1.6)
    )
    + """
[[sensors]]
name = "front"
[[sensors]]
name = "left"
axis = 1.5
[[obstacles]]
shape = "disc"
position = [0.0, 1.0]
radius = 0.1
"""
)
ONES = ("leader_ahead", "stretch", "onward_bearing", "x_err", "lag", "path_away", "curvature", "room", "target_v:0.5")
HEARD = (*ONES, "robot1_gap", "robot2_bearing", "robot2_lag", "robot3_ahead", "range:front")


@pytest.mark.parametrize("names", [ONES, HEARD])
def test_networks_of_a_formation_say_the_same(names: Sequence[str], tmp_path: Any) -> None:
    """They read where the others are, or are told it."""
    networks = []
    for i, output in product((1, 2, 3), "vw"):
        base = linear_base(
            tmp_path / f"{output}_{i}.fis",
            dict.fromkeys(names, (-9.0, 9.0)),
            {f"{output}_{i}": [*([0.01] * len(names)), 0.15 if output == "v" else 0.0]},
        )
        networks.append(read_fis(base))
    law = FormationNetworks(networks=tuple(networks))
    assert isinstance(law, RobotNetworks)
    scenario = parse_scenario(ROUND, "round")
    both = BothTeams(team=law)
    for k, _ in Simulation(scenario.setting, both, (1, 2), None).periods():
        if k >= 150:
            break
    assert len(both.farthest) > (7 if names is ONES else 15)
    assert {name: worst for name, worst in both.farthest.items() if not worst <= EXACT} == {}
