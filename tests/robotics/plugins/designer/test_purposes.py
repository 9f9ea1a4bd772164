"""What a rule base is for, found by the names of its variables."""

from dataclasses import replace
from importlib.resources import files

import pytest

from fuzzy import read_fis
from fuzzy.plugins.designer.panel import SessionPanel, find_panels, purpose_of, purposes_of
from fuzzy.plugins.designer.starts.control import rule_table
from robotics.plugins.designer.driving import drives
from tests.fuzzy.plugins.designer.served import tipper

FOLDER = files("robotics") / "data" / "rulebases"
PACKAGED = sorted(
    str(each) for place in (FOLDER, FOLDER / "formation") for each in place.iterdir() if each.name.endswith(".fis")
)


def panels():
    found, missing = find_panels()
    assert missing == []
    return found


@pytest.mark.parametrize("path", PACKAGED)
def test_packaged_rule_bases_are_of_robots(path):
    assert purpose_of(read_fis(path), panels()) == "robot"


@pytest.mark.parametrize("kind", ["pd", "pi", "pid"])
def test_a_control_table_is_of_a_loop(kind):
    assert purpose_of(rule_table(kind, 3), panels()) == "loop"


def test_what_nobody_knows_is_a_function_until_it_holds_a_loop():
    assert purpose_of(tipper(), panels()) == "function"
    assert purpose_of(replace(tipper(), loop="{}"), panels()) == "loop"


def test_one_unknown_input_is_enough_not_to_drive():
    known = read_fis(str(FOLDER / "tracking.fis"))
    assert drives(known)
    strange = replace(known, inputs=(replace(known.inputs[0], name="rainfall"), *known.inputs[1:]), rules=())
    assert not drives(strange)
    assert not drives(replace(known, outputs=(replace(known.outputs[0], name="tip"), known.outputs[1]), rules=()))


def test_purposes_follow_the_panels_and_a_panel_without_one_suits_all():
    assert purposes_of(panels()) == ["function", "loop", "robot", "tree"]
    assert purposes_of([]) == ["function"]
    assert SessionPanel("Own", 1, lambda bench: None).purpose == ""
    assert {panel.title for panel in panels() if getattr(panel, "improves", "")} == {"Train", "Tune", "Tune the loop"}
