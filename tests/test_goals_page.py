"""The page docs/howto/goals.md: its scenario drives, and its snippet prints what it says."""

import re
from pathlib import Path

import pytest

import robotics
from tests.snippets import run_python, snippets

DOCK, NOISE = (
    text
    for kind, text in snippets(Path(__file__).parent.parent / "docs" / "howto" / "goals.md")
    if kind == "python" or text.startswith("# dock.toml")
)


def test_the_scenario_of_the_page_docks():
    dock = robotics.parse_scenario(DOCK, "dock")
    found = robotics.measure_all(robotics.simulate(dock, dock.controller, seeds=range(10)))
    assert found["goal_reached"].sum() >= 9


@pytest.mark.long
def test_a_filter_parks_in_noise_where_the_law_alone_does_not(capsys):
    run_python(NOISE, "goals.md")
    parked = {
        (n, law): int(of) for n, law, of in re.findall(r"(\d+) mm, (\S+) +parked: (\d+) of", capsys.readouterr().out)
    }
    assert parked.pop(("20", "polar")) < 50
    assert len(parked) == 3
    assert min(parked.values()) >= 98
