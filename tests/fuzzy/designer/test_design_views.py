"""What is shown of a design is what inference says."""

import json

import numpy as np
import pytest

import fuzzy
from fuzzy.designer.design import Design, design_of
from fuzzy.designer.edits import apply
from fuzzy.designer.views import compared_data, design_data, surface_data, viewer_data
from fuzzy.system import Sugeno, Variable
from tests.fuzzy.designer.design_messages import system


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
    assert shown["words"] == str(fuzzy.explain(d.in_force, [0.75, -0.5]))
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
