import json

import numpy as np
import pytest

from fuzzy.inference import infer
from fuzzy.insight.explanation import explain
from fuzzy.membership import Triangle
from fuzzy.system import FuzzySystemError, Linear, Sugeno, Variable

DISTANCE = Variable("distance", (0, 2), {"near": Triangle(-2, 0, 2), "far": Triangle(0, 2, 4)}, "m")
BEARING = Variable("bearing", (-1, 1), {"left": Triangle(-2, -1, 0), "right": Triangle(0, 1, 2)}, "rad")
SPEED = Variable("v", (0, 1), {"slow": 0.1, "fast": 0.9, "line": Linear([0.2, 0], 0.1)}, "m/s")
TURN = Variable("w", (-2, 2), {"left": 1.5, "right": -1.5}, "rad/s")
RULES = [
    "if distance is near then v is slow with 0.5",
    "if distance is very far and bearing is not left then v is fast",
    "if bearing is left then w is left",
    "if distance is far or bearing is right then v is line and w is right",
]


def system(**options) -> Sugeno:
    return Sugeno([DISTANCE, BEARING], [SPEED, TURN], RULES, **options)


@pytest.mark.parametrize("defuzzification", ["wtaver", "wtsum"])
def test_contributions_sum_to_the_output(defuzzification: str) -> None:
    fis = system(defuzzification=defuzzification)
    explanation = explain(fis, [0.8, 0.3])
    parts = np.array([row.contribution for row in explanation.rows])
    assert np.nansum(parts, axis=0) == pytest.approx(fis([0.8, 0.3]))
    assert explanation.output == tuple(fis([0.8, 0.3]))
    shares = np.array([row.share for row in explanation.rows])
    assert np.nansum(shares, axis=0) == pytest.approx([1, 1])


def test_rows_hold_every_layer() -> None:
    fis = system()
    x = [0.8, 0.3]
    explanation = explain(fis, x)
    assert [row.firing for row in explanation.rows] == pytest.approx(infer(fis, np.array(x)).firing)
    assert explanation.memberships == ({"near": 0.6, "far": 0.4}, {"left": 0.0, "right": 0.3})
    degrees = [row.degrees for row in explanation.rows]
    assert degrees == [pytest.approx(d) for d in ((0.6,), (0.16, 1.0), (0.0,), (0.4, 0.3))]
    assert explanation.rows[3].proposed == pytest.approx((0.1 + 0.2 * 0.8, -1.5))
    assert np.isnan(explanation.rows[0].proposed[1])


def test_words() -> None:
    said = str(explain(system(), [0.8, 0.3]))
    assert "distance = 0.8 m is near (0.60), far (0.40)" in said
    assert "3 of 4 rules fire:" in said
    assert "rule 1 fires 0.30: if distance is near then v is slow with 0.5" in said
    assert "because distance is near 0.60, weight 0.5" in said
    assert "because distance is very far 0.16, bearing is not left 1.00" in said
    assert "rule 3" not in said
    assert "proposes w = -1.5 rad/s with a share of 100.0 %, which contributes -1.5 rad/s" in said
    assert "w = -1.5 rad/s: the average of the proposals" in said
    # the rule with most to say stands first
    assert said.index("rule 4 fires") < said.index("rule 1 fires") < said.index("rule 2 fires")


@pytest.mark.parametrize(
    ("choice", "words"),
    [
        ("midrange", "w = 0 rad/s: no rule for it fires, so the middle of its range stands there"),
        ("nan", "w = not a number: no rule for it fires"),
        ("error", "no rule for it fires, and the system is told to refuse such inputs"),
    ],
)
def test_nothing_fires_is_said(choice: str, words: str) -> None:
    fis = Sugeno([DISTANCE, BEARING], [TURN], ["if bearing is left then w is left"], no_rule_fires=choice)  # type: ignore[arg-type]
    said = str(explain(fis, [1, 0.5]))
    assert "None of the 1 rules fires." in said
    assert words in said


def test_an_input_outside_is_said() -> None:
    explanation = explain(system(), [3, 0.3])
    assert explanation.outside == ("distance",)
    assert "distance = 3 m is far (0.50); it lies outside [0 2]" in str(explanation)
    said = str(explain(system(out_of_range="clip"), [3, 0.3]))
    assert "distance = 3 m is far (1.00); it lies outside [0 2] and was moved to its edge" in said
    with pytest.raises(FuzzySystemError, match="distance outside"):
        explain(system(out_of_range="error"), [3, 0.3])


def test_not_a_number_is_said() -> None:
    said = str(explain(system(), [np.nan, 0.3]))
    assert "distance is not a number, so no result is one" in said
    assert "v = not a number, because an input is not a number" in said


def test_plain_data_go_through_json() -> None:
    data = json.loads(json.dumps(explain(system(), [0.8, -0.5]).as_dict()))
    assert data["outputs"]["v"] == pytest.approx(system()([0.8, -0.5])[0])
    assert data["rules"][1]["clauses"][1] == {"clause": "bearing is not left", "degree": 0.5}


def test_only_one_point() -> None:
    with pytest.raises(FuzzySystemError, match=r"one point of 2 inputs \(distance, bearing\) .* got shape \(3, 2\)"):
        explain(system(), np.zeros((3, 2)))
