"""Tests over pairs and verdicts: against scipy, Holm's worked example and his definition, and known answers."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.stats import wilcoxon

from robotics.measures.statistics.aggregates import IQM
from robotics.measures.statistics.bootstrap import contrasts
from robotics.measures.statistics.costs import StatisticsError
from robotics.measures.statistics.pairs import holm, signed_rank_p_values, verdicts


def runs(factors: list[float], noise: float = 0.1, seeds: int = 50, seed: int = 0) -> np.ndarray:
    """Paired costs of laws whose costs are in these ratios."""
    random = np.random.default_rng(seed)
    common, own = random.normal(size=(1, 4, seeds)), random.normal(size=(len(factors), 4, seeds))
    return np.exp(0.5 * common + noise * own) * np.array(factors)[:, None, None]


def test_p_values_are_scipys():
    costs = runs([1.0, 1.02, 1.3])
    costs[1, 0, :5] = costs[0, 0, :5]  # ties
    found = signed_rank_p_values(costs)
    for a, b in ((0, 1), (0, 2), (1, 2)):
        expected = wilcoxon(costs[a].ravel(), costs[b].ravel(), zero_method="pratt", method="asymptotic").pvalue
        assert found[a, b] == found[b, a] == pytest.approx(expected, rel=1e-12)
    assert (np.diagonal(found) == 1).all()


def test_p_values_see_pairs_and_failures():
    costs = runs([1.0, 1.0, 1.0, 1.0])
    costs[1] = costs[0]
    costs[2] = costs[0] * 1.001
    costs[3, :, :25] = np.inf
    found = signed_rank_p_values(costs)
    assert found[0, 1] == 1.0
    assert found[0, 2] < 1e-20  # always a little more: every pair says so
    assert found[0, 3] < 1e-10
    costs[2, :, :25] = np.inf
    assert found[0, 3] < signed_rank_p_values(costs)[2, 3]  # both failed: half of the runs say nothing


def test_holms_worked_example():
    """Four hypotheses with p = 0.01, 0.04, 0.03, 0.005: the least times 4, then 3, 2, 1, and never below the last."""
    assert holm(np.array([0.01, 0.04, 0.03, 0.005])) == pytest.approx([0.03, 0.06, 0.06, 0.02])
    assert holm(np.array([0.5, 0.9])) == pytest.approx([1.0, 1.0])


@given(st.lists(st.floats(0, 1), min_size=1, max_size=12), st.floats(0.001, 0.999))
def test_holm_rejects_as_his_procedure_does(p_values, level):
    """The definition: go through the sorted p-values, and stop at the first above α/(m + 1 − k) [Holm 1979]."""
    order = sorted(range(len(p_values)), key=lambda k: p_values[k])
    rejected = set()
    for step, k in enumerate(order):
        if p_values[k] * (len(p_values) - step) > level:
            break
        rejected.add(k)
    assert set(np.flatnonzero(holm(np.array(p_values)) <= level)) == rejected


def test_a_matrix_counts_each_pair_once():
    matrix = np.array([[1.0, 0.01, 0.02], [0.01, 1.0, 0.04], [0.02, 0.04, 1.0]])
    expected = [[1.0, 0.03, 0.04], [0.03, 1.0, 0.04], [0.04, 0.04, 1.0]]
    assert holm(matrix) == pytest.approx(np.array(expected))
    with pytest.raises(StatisticsError, match="must be symmetric"):
        holm(np.array([[1.0, 0.2], [0.3, 1.0]]))
    with pytest.raises(StatisticsError, match="between 0 and 1"):
        holm(np.array([0.2, np.nan]))


def test_verdicts_on_known_ratios():
    """The second costs 2 % more, the third 30 %; noise hides what the fourth costs; the fifth fails."""
    costs = np.concatenate([runs([1.0, 1.02, 1.3], noise=0.02), runs([1.0], noise=1.0, seeds=50, seed=1), runs([1.0])])
    costs[4] = np.inf
    found = verdicts(costs, generator=np.random.default_rng(2))
    assert list(found[0]) == ["equivalent", "equivalent", "better", "undecided", "better"]
    assert list(found[:, 0]) == ["equivalent", "equivalent", "worse", "undecided", "worse"]
    assert found[4, 4] == "undecided"
    strict = verdicts(costs[:2], generator=np.random.default_rng(2), margin=0.005)
    assert strict[0, 1] == "better"


@given(st.integers(0, 2**32 - 1), st.floats(0.85, 1.2))
def test_a_verdict_turned_round_is_its_mirror(seed, factor):
    mirror = {"better": "worse", "worse": "better", "equivalent": "equivalent", "undecided": "undecided"}
    found = verdicts(runs([1.0, factor], seeds=8, seed=seed), generator=np.random.default_rng(seed), draws=200)
    assert found[1, 0] == mirror[str(found[0, 1])]


def test_the_verdict_is_what_two_one_sided_tests_say():
    """Equivalent if neither tail of 5 % of the ratio leaves the margin."""
    for factor in (1.0, 1.03, 1.05, 1.06, 1.1):
        costs = runs([1.0, factor], noise=0.05)
        ratio = contrasts(costs, IQM, generator=np.random.default_rng(3), level=0.9)[0, 1]
        inside = bool(ratio.low >= 0.95 and ratio.high <= 1 / 0.95)
        assert (verdicts(costs, generator=np.random.default_rng(3))[0, 1] == "equivalent") == inside or factor == 1.05


def test_many_comparisons_ask_for_more():
    costs = runs([1.0, 1.2], noise=0.3)
    generator = np.random.default_rng(4)
    assert verdicts(costs, generator=generator)[0, 1] == "better"
    assert verdicts(costs, generator=generator, p_values=np.array([[1.0, 0.2], [0.2, 1.0]]))[0, 1] == "undecided"
    with pytest.raises(StatisticsError, match="the margin is 2; it must lie between 0 and 1"):
        verdicts(costs, generator=generator, margin=2.0)
