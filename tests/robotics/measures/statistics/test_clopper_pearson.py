"""Clopper and Pearson's interval: closed forms at its ends, and the tails of the binomial distribution between."""

import numpy as np
import pytest
from scipy.stats import binom

from robotics.measures.statistics.intervals import clopper_pearson, wilson


@pytest.mark.parametrize("trials", [1, 7, 400, 100_000])
def test_of_none_and_of_all_there_is_a_closed_form(trials):
    none, every = clopper_pearson(0, trials), clopper_pearson(trials, trials)
    bound = 1 - 0.025 ** (1 / trials)
    assert (float(none.low), float(every.high)) == (0.0, 1.0)
    assert float(none.high) == pytest.approx(bound, rel=1e-9)
    assert float(every.low) == pytest.approx(1 - bound, rel=1e-9)


@pytest.mark.parametrize(("count", "trials"), [(1, 10), (3, 400), (199, 200), (50, 100)])
def test_at_its_ends_a_tail_has_half_of_what_is_left(count, trials):
    found = clopper_pearson(count, trials)
    assert binom.sf(count - 1, trials, float(found.low)) == pytest.approx(0.025)
    assert binom.cdf(count, trials, float(found.high)) == pytest.approx(0.025)


def test_it_holds_rare_rates_as_often_as_it_says_where_wilson_does_not():
    trials, rate = 400, 0.0004
    counts = np.arange(20)
    chances = binom.pmf(counts, trials, rate)
    held = [
        float(chances[(found.low <= rate) & (rate <= found.high)].sum())
        for found in (clopper_pearson(counts, trials), wilson(counts, trials))
    ]
    assert held[0] >= 0.95
    assert held[1] < 0.9
