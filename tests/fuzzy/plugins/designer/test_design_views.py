"""What is shown of a design is what inference says."""

import json
import re
from pathlib import Path

import numpy as np
import pytest

import fuzzy
from fuzzy.plugins.designer.design import Design, design_of
from fuzzy.plugins.designer.edits import apply
from fuzzy.plugins.designer.keys import SHORTCUTS
from fuzzy.plugins.designer.views import (
    compared_data,
    design_data,
    findings_data,
    refusal_data,
    surface_data,
    viewer_data,
)
from fuzzy.system import Sugeno, Variable
from tests.fuzzy.plugins.designer.design_messages import system


def edit(design: Design, op: str, **fields) -> Design:
    return apply(design, {"edit": op, **fields})


def test_views_show_what_inference_says():
    d = edit(design_of(system()), "rule_enabled", key=0, enabled=False)
    d = apply(d, {"look": "point", "point": [0.75, -0.5]})
    shown = viewer_data(d)
    layers = fuzzy.infer(d.in_force, [0.75, -0.5])
    assert shown["output"] == layers.output.tolist()
    assert [rule["key"] for rule in shown["rules"]] == [1, 2]
    assert [rule["firing"] for rule in shown["rules"]] == layers.firing.tolist()
    assert [rule["proposed"] for rule in shown["rules"]] == [[0.6875, None], [None, -1.0]]
    assert shown["memberships"] == [m.tolist() for m in layers.memberships]
    assert shown["words"].replace("−", "-") == str(fuzzy.explain(d.in_force, [0.75, -0.5]))
    assert "bearing = −0.5 rad" in shown["words"]  # a page has true minus signs
    picture = surface_data(d, [1, 0], 1)
    assert np.shape(picture["z"]) == (41, 41)
    grid = np.array([[[y, x] for x in picture["x"]] for y in picture["y"]])
    assert np.array(picture["z"]) == pytest.approx(d.in_force(grid)[..., 1], abs=1e-12)
    curve = surface_data(d, [0], 0, points=11)
    assert curve["y"] is None
    assert curve["z"] == pytest.approx(d.in_force([[x, -0.5] for x in curve["x"]])[:, 0].tolist())
    assert compared_data(d.system, "before", [0, 5])["surface"] is None
    with pytest.raises(fuzzy.FuzzySystemError, match="there is no input 5"):
        surface_data(d, [0, 5])


@pytest.mark.parametrize("none", ["nan", "midrange", "error"])
def test_views_mark_where_no_rule_fires(none):
    gap = Sugeno(
        [Variable("x", (0, 4), {"low": fuzzy.trimf(0, 0, 1), "high": fuzzy.trimf(3, 4, 4)})],
        [Variable("z", (0, 1), {"off": 0.25, "on": 0.75})],
        ["if x is low then z is off", "if x is high then z is on"],
        no_rule_fires=none,
        out_of_range="error",
    )
    d = design_of(gap)
    assert d.point == (2.0,)
    shown, curve = viewer_data(d), surface_data(d, points=5)
    middle = 0.5 if none == "midrange" else None
    assert (shown["output"], shown["fired"]) == ([middle], [False])
    assert curve["fired"] == [True, False, False, False, True]
    assert curve["z"] == [0.25, middle, middle, middle, 0.75]
    assert (curve["low"], curve["high"]) == (0.25, 0.75)
    outside = viewer_data(d, [5.0])
    assert outside["outside"] == ["x"]
    assert "refuses such a point" in outside["words"]
    json.dumps([shown, curve, outside, design_data(d)], allow_nan=False)


def test_findings_lead_to_rules_and_terms():
    """They are those of `fuzzy check` for the rules that are on, numbered as in the table."""
    fis = system()
    clash = ["if bearing is right then w is cw", "if bearing is right then w is ccw"]
    far_out = Variable("w", (-1, 1), {"ccw": 1.0, "cw": -1.0, "wild": -30.0}, "rad/s")
    fis = Sugeno(fis.inputs, [fis.outputs[0], far_out], [*map(str, fis.rules[:2]), *clash])
    d = edit(design_of(fis), "rule_enabled", key=0, enabled=False)
    d = edit(d, "rule_text", key=1, text="if nothing")
    found = findings_data(d)
    assert [f["severity"] for f in found] == sorted(
        (f["severity"] for f in found), key=["error", "warning", "note"].index
    )
    checked = {f.sentence for f in fuzzy.check(d.in_force)}
    assert {f["sentence"].replace("−", "-").replace("rules 3 and 4", "rules 2 and 3") for f in found[1:]} == checked
    assert found[0]["sentence"].startswith("the sentence of rule 2 is no rule: ")
    assert found[0]["places"] == [{"rule": 1, "text": "rule 2"}]
    (pair,) = (f for f in found if f["sentence"].startswith("rules 3 and 4 have the same antecedent"))
    assert pair["places"] == [{"rule": 2, "text": "rule 3"}, {"rule": 3, "text": "rule 4"}]
    (wild,) = (f for f in found if "leaves its range" in f["sentence"])
    assert "wild (−30)" in wild["sentence"]
    assert wild["places"] == [{"kind": "output", "variable": "w", "term": "wild", "text": "wild of w"}]
    json.dumps(found, allow_nan=False)
    with pytest.raises(ValueError, match="the 3 rules need a number each, got 1"):
        fuzzy.check(d.in_force, numbers=[1])


def test_a_refusal_names_the_field_that_asked():
    error = fuzzy.InputError("the peak, -0.5, is too far left")
    told = refusal_data(error, {"edit": "term", "field": "f1"}, 7)
    assert told == {"message": "the peak, −0.5, is too far left", "number": 7, "field": "f1"}
    assert refusal_data(error, {"field": ["f1"]}, 8)["field"] is refusal_data(error, None, 9)["field"] is None


def test_the_keys_of_the_page_are_those_of_its_documentation():
    text = (Path(__file__).parents[4] / "docs" / "howto" / "designer.md").read_text(encoding="utf-8")
    table = re.search(r"\| key \| where \| what \|\n\| --- .*\n((?:\|.*\n)+)", text)
    assert table is not None
    rows = [tuple(cell.strip() for cell in line.strip("|\n").split("|")) for line in table[1].splitlines()]
    assert tuple(rows) == SHORTCUTS
