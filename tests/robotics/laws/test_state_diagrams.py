"""State diagrams against recorded runs: each observed transition is drawn, and each drawn one is observed."""

from collections.abc import Iterable
from typing import Any

import numpy as np
import pytest

from robotics.laws.catalogue import CATALOGUE, make_controller
from robotics.laws.modes import MODES, STOPPED, StateDiagram
from robotics.laws.teams.cooperation import CooperationMemory
from robotics.plugins.stress.disturbance import Disturbance
from robotics.plugins.stress.single import single_run
from robotics.simulation.loop import drive, simulate
from robotics.simulation.run import Run
from robotics.simulation.scenario.reading import load_scenario, parse_scenario
from robotics.studies.together import run_together

COURSES = ("turn-into-neighbour", "trap-u", "turn-towards-each-other", "neighbour-stops", "trap-u-middle")
PAIR = """
kind = "team"
duration = 25.0
[sensing]
posture = "pose"
position_noise = {noise}
[[robots]]
start = [{start}]
path = {{ shape = "line", start = [0.0, 0.0], end = [3.0, 0.0] }}
timing = {{ duration = 20.0 }}
[[robots]]
start = [0.0, 1.0, 0.0]
path = {{ shape = "line", start = [0.0, 1.0], end = [2.0, 2.0] }}
timing = {{ duration = 20.0 }}
"""


def changes(codes: np.ndarray, mask: int) -> set[tuple[int, int]]:
    """The pairs of states that follow each other in ``codes`` (samples, ...); stopped robots have none."""
    pairs = {}
    before, after = codes[:-1].astype(int), codes[1:].astype(int)
    driving = (before < STOPPED) & (after < STOPPED)
    for a, b in zip((before & mask)[driving].tolist(), (after & mask)[driving].tolist(), strict=True):
        pairs[a, b] = a != b
    return {pair for pair, changed in pairs.items() if changed}


def drawn(diagram: StateDiagram) -> set[tuple[int, int]]:
    pairs = [(t.before, t.after) for t in diagram.transitions]
    assert len(set(pairs)) == len(pairs)
    assert all(t.condition and t.before in diagram.states and t.after in diagram.states for t in diagram.transitions)
    return set(pairs)


def check(law: str, runs: Iterable[Run]) -> None:
    runs = list(runs)
    for diagram in make_controller(law).diagrams:
        observed = set().union(*(changes(run.modes, diagram.mask) for run in runs if run.modes is not None))
        assert observed == drawn(diagram), law


def test_obstacle_avoidance_goes_through_its_diagrams() -> None:
    scenarios = [load_scenario(name) for name in COURSES]
    check("obstacles-literal", run_together(scenarios, "obstacles-literal", [1]))
    # A disc that crosses its lane stops the robot while it follows the wall of a trap.
    trapped, _ = single_run("obstacles", make_controller("obstacles"), 36, kind="U", moving=3, name="obstacles")
    check("obstacles", [*run_together(scenarios, "obstacles", [0]), trapped])


@pytest.mark.long
def test_the_fuzzy_team_goes_through_its_diagrams() -> None:
    law = "fuzzy-team"
    courses = run_together([load_scenario(name) for name in COURSES[:1]], law, [0])
    traps: dict[str, Any] = {"kind": "U", "robots": 3, "moving": 2, "name": law}
    trapped = [single_run("obstacles", make_controller(law), seed, **traps)[0] for seed in (4, 12, 23)]
    check(law, [*courses, *trapped])


def test_the_hierarchy_goes_through_its_diagrams() -> None:
    courses = run_together([load_scenario(name) for name in COURSES[:3]], "hierarchy-literal", [1])
    check(
        "hierarchy-literal", [*courses, simulate(load_scenario("two-meetings"), make_controller("hierarchy-literal"))]
    )


@pytest.mark.parametrize("law", ["crash-literal", "crash-yielding"])
def test_crash_avoidance_goes_through_its_diagram(law: str) -> None:
    check(law, [simulate(load_scenario("three-cross"), make_controller(law))])


def test_right_of_way_goes_through_its_diagram() -> None:
    """The plan alone stops nobody: ``near`` is wider than the plan's clearance, messages are lost, a robot is held."""
    wrong = Disturbance(freeze=8.0, loss=0.3, latency=0.5)
    law = "right-of-way:near=0.6"
    run, _ = single_run("crossing", make_controller(law), 1001, robots=4, disturbance=wrong, name=law)
    check(law, [run])


def phases(law: str, text: str) -> np.ndarray:
    scenario = load_scenario(text) if "\n" not in text else parse_scenario(text, "pair")
    found = [
        CooperationMemory(state.memory).phase.copy() for state in drive(scenario.setting, make_controller(law), (0,))
    ]
    return np.array(found[1:])


def test_cooperation_goes_through_its_diagram() -> None:
    texts = ["start-off-paths", "outage-10s"]
    texts += [PAIR.format(noise=0.0, start="0.0, 0.6, 3.0"), PAIR.format(noise=0.02, start="0.5, 0.3, 0.0")]
    texts += [PAIR.format(noise=0.0, start="3.0, 0.0, 0.0")]  # ahead of time, where its path ends
    (diagram,) = make_controller("cooperation").diagrams
    observed = set().union(*(changes(phases("cooperation", text), diagram.mask) for text in texts))
    assert observed == drawn(diagram)
    (printed,) = make_controller("cooperation-literal").diagrams
    assert changes(phases("cooperation-literal", "outage-10s"), printed.mask) == drawn(printed)


def test_states_are_the_modes_that_runs_record() -> None:
    for law in ("obstacles", "obstacles-literal", "crash-literal", "hierarchy-literal", "right-of-way"):
        for diagram in make_controller(law).diagrams:
            assert all(0 <= code < len(MODES) and code & diagram.mask == code for code in diagram.states)
    assert [name for name in CATALOGUE if make_controller(name).diagrams] != []
    assert make_controller("lyapunov").diagrams == ()
