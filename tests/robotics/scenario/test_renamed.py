"""Old names of scenarios: they still load, and say the new one."""

import pytest

from robotics.experiments.sweeps.reading import load_sweep
from robotics.scenario.reading import load_scenario, scenario_names
from robotics.scenario.renamed import NEW_NAMES, RenamedWarning, current_name


def test_every_old_name_leads_to_a_scenario_and_is_none_itself():
    assert set(NEW_NAMES.values()) <= set(scenario_names())
    assert not set(NEW_NAMES) & set(scenario_names())
    assert len(set(NEW_NAMES.values())) == len(NEW_NAMES) == 18
    assert not [name for name in scenario_names() if "chapter" in name]


@pytest.mark.parametrize("category", [DeprecationWarning, RenamedWarning])
def test_an_old_name_loads_the_scenario_by_its_new_name(category):
    with pytest.warns(category, match="chapter-6-test-2 is now called three-cross") as caught:
        old = load_scenario("chapter-6-test-2")
    assert caught[0].filename == __file__
    assert old == load_scenario("three-cross")
    assert old.name == "three-cross"
    assert current_name("three-cross") == "three-cross"


def test_a_sweep_of_an_old_name_sweeps_the_new_one(tmp_path):
    file = tmp_path / "mine.toml"
    file.write_text('scenario = "chapter-4-faults"\nseeds = 2\n', encoding="utf-8")
    with pytest.warns(DeprecationWarning, match="outage-10s"):
        assert load_sweep(str(file)).scenario == "outage-10s"
