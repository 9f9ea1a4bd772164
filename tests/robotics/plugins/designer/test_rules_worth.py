"""What each rule of a design is worth over several seeds, as the page says it."""

import pytest

from robotics.laws.tracking.fuzzy_tracking import load_rule_base
from robotics.plugins.designer.severalseeds import rival_seeds, rules_worth, summary, without_rules
from robotics.plugins.designer.tryout import TryoutTrial, course_data, settled

METRIC = {"name": "late", "title": "lateness: of all", "unit": "s", "larger": False}


def told(contact: int = 0, stopped: int = 0, late: float | str | None = 1.0) -> dict[str, object]:
    return {"runs": 20, "contact": contact, "stopped": stopped, "refused": 0, "median": {"late": late}}


def test_the_rule_that_is_missed_most_comes_first() -> None:
    fis = load_rule_base("tracking")
    whole = told(contact=1)
    without = {
        "without 1": told(contact=1),
        "without 2": told(contact=1, late=2.0),
        "without 3": told(contact=4, stopped=2, late="never"),
        "without 4": told(contact=1, stopped=1),
        "without 5": told(contact=0, late=1.0004),
    }
    rows = rules_worth(fis, whole, without, METRIC)
    assert [row["rule"] for row in rows] == [3, 4, 2, 1, 5]
    assert [row["told"] for row in rows] == [
        "4 of 20 touch (1 with it), 2 of 20 are stopped (0 with it), lateness never (1)",
        "1 of 20 are stopped (0 with it)",
        "lateness 2 s (1)",
        "nothing changes",
        "0 of 20 touch (1 with it)",
    ]
    assert [row["worse"] for row in rows] == [True, True, True, False, False]
    assert rows[0]["text"] == str(fis.rules[2])
    assert rules_worth(fis, whole, without, None) == []


@pytest.mark.long
def test_a_rule_of_parking_is_missed() -> None:
    """Without the rule for a goal behind on the right, runs go astray; what is told is of the same seeds."""
    fis = load_rule_base("park")
    trial = settled(fis, TryoutTrial(scenario="parking"), "park")
    metrics = course_data(trial)["metrics"]
    (ranked,) = (m for m in metrics if m["name"] == "goal_time_s")
    found = {name: rival_seeds(other, trial, "", range(20)) for name, other in without_rules(fis).items()}
    whole = summary(rival_seeds(fis, trial, "", range(20)), metrics)
    rows = rules_worth(fis, whole, {name: summary(rows, metrics) for name, rows in found.items()}, ranked)
    assert rows[0]["rule"] == 6
    assert "stopped" in rows[0]["told"]
    assert whole["stopped"] == 0
