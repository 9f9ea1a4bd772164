"""What data say nothing of: rules that do not act by themselves, gaps that are not crossed."""

import numpy as np
import pytest

import fuzzy
from fuzzy.tuning.systemspace import SystemSpace

TEXT = """
[System]
Name='three'
Type='sugeno'
NumInputs=1
NumOutputs=1
NumRules=3
AndMethod='prod'
OrMethod='probor'
DefuzzMethod='wtaver'
[Input1]
Name='e'
Range=[-2 2]
NumMFs=3
MF1='low':'trapmf',[-3 -3 -1 0]
MF2='mid':'trimf',[-1 0 1]
MF3='high':'trapmf',[0 1 3 3]
[Output1]
Name='u'
Range=[-1 1]
NumMFs=3
MF1='back':'constant',[-0.5]
MF2='stay':'constant',[0.1]
MF3='on':'constant',[0.7]
[Rules]
1, 1 (1) : 1
2, 2 (1) : 1
3, 3 (1) : 1
"""
SPACE = SystemSpace(fuzzy.parse_fis(TEXT), move=("memberships", "consequents", "weights", "rules"))


def unreached(*points: float) -> set[str]:
    return set(SPACE.unreached(np.array(points)[:, None]))


def test_points_everywhere_reach_all():
    assert unreached(*np.linspace(-2, 2, 41)) == set()


def test_a_rule_that_only_acts_beside_others_is_not_reached():
    found = unreached(*np.linspace(-0.1, 0.45, 50))  # "high" comes to 0.45 of the firing strength
    assert {"u.back", "u.on", "rule 1", "rule 3", "rule 1.weight", "rule 3.weight"} < found
    assert not {"u.stay", "rule 2", "rule 2.weight"} & found
    assert "u.on" not in unreached(*np.linspace(-0.1, 0.55, 50))


def test_a_gap_is_reached_where_points_lie_beyond_both_ends():
    gaps = {p.name for p in SPACE.parameters if ".gap " in p.name}
    assert gaps == {"e.gap -1 to 0", "e.gap 0 to 1", "e.gap 1 to 2"}
    assert gaps & unreached(-0.5, 0.5) == gaps
    assert gaps & unreached(-1.5, 0.5) == {"e.gap 0 to 1", "e.gap 1 to 2"}
    assert gaps & unreached(-0.5, 1.5) == {"e.gap -1 to 0"}  # within the last gap is enough: nothing lies beyond


@pytest.mark.parametrize("far", [1, 3])
def test_one_point_of_a_thousand_is_none(far):
    points = np.zeros(1000)
    points[:far] = 1.5
    assert ("u.on" in unreached(*points)) == (far == 1)
