"""Rankings: against sorting by hand, and where the answer is known."""

import numpy as np
import pytest

from robotics.measures.statistics.costs import StatisticsError
from robotics.measures.statistics.ranking import gap_closed, pareto_front, reweighted


def runs(centres: list[float], noise: float = 0.3, seed: int = 0) -> np.ndarray:
    random = np.random.default_rng(seed)
    return np.exp(np.array(centres)[:, None, None] + noise * random.normal(size=(len(centres), 3, 20)))


def test_other_weights_change_the_order_where_terms_disagree():
    """Law 0 is precise, law 1 gentle: 1 + 4 = 5 against 4 + 2 = 6; the third is worse in both."""
    terms = np.array([[1.0, 4.0, 5.0], [4.0, 2.0, 6.0]])[:, :, None, None] * np.ones((1, 1, 2, 4))
    found = reweighted(terms, np.array([1.0, 1.0]))
    assert found.weights.tolist() == [[1, 1], [0.5, 1], [2, 1], [1, 0.5], [1, 2]]
    assert found.values.tolist() == [[5, 6, 11], [4.5, 4, 8.5], [6, 10, 16], [3, 5, 8], [9, 8, 17]]
    assert found.order.tolist() == [[0, 1, 2], [1, 0, 2], [0, 1, 2], [0, 1, 2], [1, 0, 2]]
    assert found.changed.tolist() == [False, True, False, False, True]
    assert found.swapped.tolist() == [0, 1, 0, 0, 1]
    with pytest.raises(StatisticsError, match="a weight > 0 for each term"):
        reweighted(terms, np.array([1.0, 0.0]))


def test_the_gap_that_tuning_closes():
    reference = runs([0.0])[0]
    before = np.stack([2 * reference, 3 * reference, 0.5 * reference])
    after = np.stack([1.5 * reference, reference, 0.5 * reference])
    found = gap_closed(before, after, reference, generator=np.random.default_rng(4), draws=100)
    assert found.value[:2] == pytest.approx([0.5, 1.0])
    assert found.low[:2] == pytest.approx(found.high[:2])  # the ratios are the same in every run, and so is the share
    assert np.isnan(found.value[2])
    assert (found.low[2], found.high[2]) == (-np.inf, np.inf)


def test_the_front_is_what_none_beats():
    points = np.array([[1, 5], [2, 3], [2, 4], [4, 1], [4, 1], [5, 5], [0, np.inf]])
    assert pareto_front(points).tolist() == [True, True, False, True, True, False, False]
    random = np.random.default_rng(5).random((40, 3))
    by_hand = [not any((other <= point).all() and (other < point).any() for other in random) for point in random]
    assert pareto_front(random).tolist() == by_hand
