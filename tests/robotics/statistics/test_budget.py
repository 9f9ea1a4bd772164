"""What a search is worth at a budget: against every draw that there is, and against the distribution itself."""

from itertools import combinations

import numpy as np
import pytest

from robotics.statistics.budget import best_so_far, expected_best, over_budget
from robotics.statistics.costs import StatisticsError


def test_the_best_so_far_never_grows_and_what_is_no_number_failed():
    found = best_so_far(np.array([np.nan, 3.0, 5.0, np.inf, 1.0, np.nan]))
    assert list(found) == [np.inf, 3.0, 3.0, 3.0, 1.0, 1.0]


def test_over_a_budget_it_is_the_median_and_the_range_of_the_repeats():
    costs = np.array([[4.0, 2.0, 2.0], [3.0, 3.0, 1.0], [9.0, 8.0, 7.0]])
    found = over_budget(costs, np.array([1, 3]))
    assert [list(x) for x in (found.low, found.value, found.high)] == [[3, 1], [4, 2], [9, 7]]
    two = over_budget(np.stack([costs[:2], costs[1:]]), np.array([2]))  # of an even number: between the middle two
    assert two.value.tolist() == [[2.5], [5.5]]
    failed = over_budget(np.array([[np.inf, 2.0], [1.0, 1.0], [np.inf, np.inf]]), np.array([1, 2]))
    assert failed.value.tolist() == [np.inf, 2.0]
    assert failed.low.tolist() == [1.0, 1.0]
    for budget in (0, 4):
        with pytest.raises(StatisticsError, match="from 1 to the 3 evaluations"):
            over_budget(costs, np.array([budget]))


@pytest.mark.parametrize("number", range(1, 8))
def test_the_expected_best_is_the_mean_over_all_draws(number):
    costs = np.exp(np.random.default_rng(number).normal(size=(2, 7)))
    expected = [np.mean([min(draw) for draw in combinations(row, number)]) for row in costs]
    assert expected_best(costs, number) == pytest.approx(expected, rel=1e-12)


def test_the_expected_best_has_no_bias():
    """Of exponential costs the least of n has the mean 1/n; with replacement it would come out too small or large."""
    costs = np.random.default_rng(1).exponential(size=(40_000, 10))
    found = expected_best(costs, 5)
    assert found.mean() == pytest.approx(0.2, abs=4 * found.std() / 200)


def test_failures_count_where_all_that_is_drawn_can_have_failed():
    costs = np.array([1.0, 2.0, np.inf, np.inf])
    assert expected_best(costs, 2) == np.inf
    assert expected_best(costs, 3) == pytest.approx((3 * 1.0 + 1 * 2.0) / 4)
    for number in (0, 5):
        with pytest.raises(StatisticsError, match="ask for 1 to 4"):
            expected_best(costs, number)


def test_a_long_search_is_no_trouble():
    costs = np.arange(1.0, 5001.0)
    assert expected_best(costs, 500) == pytest.approx(5001 / 501, rel=1e-9)  # the mean of the least of n out of 1 ... N
