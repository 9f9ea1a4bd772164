"""Shares of runs: against scipy's tests, against counting by hand, and under what must not change them."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.stats import binomtest

from robotics.measures.statistics.intervals import wilson
from robotics.measures.statistics.shares import failure_rate, probability_of_improvement


def costs(laws: int = 3, scenarios: int = 4, seeds: int = 20, seed: int = 0) -> np.ndarray:
    """Costs with ties, and with failures."""
    random = np.random.default_rng(seed)
    found = np.round(np.exp(random.normal(size=(laws, scenarios, seeds)) + 0.3 * np.arange(laws)[:, None, None]), 1)
    found[random.random(found.shape) < 0.05] = np.inf
    return found


@pytest.mark.parametrize("level", [0.9, 0.95])
@pytest.mark.parametrize(("count", "trials"), [(0, 20), (1, 7), (55, 200), (7, 7)])
def test_wilsons_interval_is_scipys(count, trials, level):
    expected = binomtest(count, trials).proportion_ci(level, method="wilson")
    found = wilson(count, trials, level)
    assert (float(found.low), float(found.high)) == pytest.approx((expected.low, expected.high), abs=1e-12)


def test_failures_are_counted_over_all_scenarios():
    found = costs()
    rates = failure_rate(found)
    for law in range(3):
        count = sum(1 for cost in found[law].ravel() if cost == np.inf)
        assert rates.value[law] == count / 80
        assert rates.high[law] == pytest.approx(binomtest(count, 80).proportion_ci(method="wilson").high)


def test_the_probability_counts_seeds():
    found, random = costs(), np.random.default_rng(1)
    paired = probability_of_improvement(found, generator=random, draws=50).value
    for a in range(3):
        for b in range(3):
            scores = [
                1.0 if x < y else 0.5 if x == y else 0.0
                for x, y in zip(found[a].ravel(), found[b].ravel(), strict=True)
            ]
            assert paired[a, b] == pytest.approx(np.mean(scores), abs=1e-12)
    assert paired + paired.T == pytest.approx(np.ones((3, 3)))


def test_intervals_are_those_of_resampling_by_hand():
    found = costs(laws=2, seeds=12)
    own = probability_of_improvement(found, generator=np.random.default_rng(2), draws=4000)[0, 1]
    random, by_hand = np.random.default_rng(3), []
    for _ in range(4000):
        chosen = random.integers(0, 12, size=(4, 11))
        first, second = np.take_along_axis(found, chosen[None], axis=2)
        by_hand.append(np.mean((first < second) + 0.5 * (first == second)))
    assert (own.low, own.high) == pytest.approx(tuple(np.quantile(by_hand, [0.025, 0.975])), abs=0.013)


def test_pairing_tells_a_small_lead_that_noise_hides():
    common = np.random.default_rng(4).normal(size=(1, 4, 30))
    found = np.exp(common + np.array([0.0, 0.01])[:, None, None])
    paired = probability_of_improvement(found, generator=np.random.default_rng(5))[0, 1]
    assert paired.value == 1.0
    assert float(paired.low) == pytest.approx(binomtest(120, 120).proportion_ci(method="wilson").low)  # never [1, 1]


@given(st.integers(0, 2**32 - 1))
def test_probabilities_hang_on_the_order_of_costs_only_and_not_on_that_of_seeds(seed):
    found, random = costs(seeds=6, seed=seed), np.random.default_rng(seed)
    chosen = random.permuted(np.broadcast_to(np.arange(6), (4, 6)), axis=1)[None]
    changed = np.take_along_axis(np.log1p(found) ** 3, np.broadcast_to(chosen, found.shape), axis=2)
    values = [probability_of_improvement(each, generator=random, draws=2).value for each in (found, changed)]
    assert values[0] == pytest.approx(values[1], abs=1e-12)
