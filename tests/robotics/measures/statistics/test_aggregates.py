"""The quantile means: against scipy, against copies of the runs, and against closed forms."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.stats import expon, norm, trim_mean

from robotics.measures.statistics.aggregates import CVAR, IQM, MEAN, SCENARIO_IQM, QuantileMean
from robotics.measures.statistics.costs import StatisticsError

FINE = 200_000  # points by which a distribution is cut into equal parts


def costs(shape: tuple[int, ...], seed: int = 0) -> np.ndarray:
    return np.exp(np.random.default_rng(seed).normal(size=shape))


def test_the_interquartile_mean_is_scipys_trimmed_mean_where_four_divides_the_runs():
    found = costs((5, 3, 8))
    assert IQM(found) == pytest.approx(trim_mean(found.reshape(5, -1), 0.25, axis=1), rel=1e-12)


@pytest.mark.parametrize("statistic", [IQM, CVAR, QuantileMean("most", 0.13, 0.71)])
@pytest.mark.parametrize("seeds", [2, 7, 13])
def test_runs_at_the_levels_count_in_part(statistic, seeds):
    found = costs((3, seeds))
    copies = np.sort(np.repeat(found.ravel(), 100))  # 100 of each: the levels fall between two copies
    first, last = round(statistic.low * copies.size), round(statistic.high * copies.size)
    assert statistic(found) == pytest.approx(copies[first:last].mean(), rel=1e-12)


@pytest.mark.parametrize("share", [0.1, 0.25])
def test_the_conditional_value_at_risk_has_the_closed_forms_of_the_normal_and_the_exponential(share):
    middles = (np.arange(FINE) + 0.5) / FINE
    normal, exponential = (law.ppf(middles).reshape(1, -1) for law in (norm, expon))
    worst = QuantileMean("mean of the worst", 1 - share, 1.0)
    assert worst(normal) == pytest.approx(norm.pdf(norm.ppf(1 - share)) / share, rel=1e-4)
    assert worst(exponential) == pytest.approx(1 - np.log(share), rel=1e-4)


def test_the_worst_tenth_of_fifteen_runs_is_one_and_a_half():
    found = np.arange(15.0).reshape(3, 5)
    assert CVAR(found) == pytest.approx((14 + 0.5 * 13) / 1.5)


def test_failures_are_trimmed_up_to_a_quarter_and_make_the_worst_tenth_infinite():
    found = costs((2, 20))
    whole = IQM(found)
    ranked = np.sort(found.ravel())
    found[found >= ranked[30]] = np.inf  # the ten worst of forty
    assert IQM(found) == whole
    found[found == ranked[29]] = np.inf
    assert IQM(found) == np.inf
    one = costs((2, 20))
    one[1, 3] = np.inf
    assert CVAR(one) == MEAN(one) == np.inf
    assert IQM(np.full((2, 4), np.inf)) == np.inf


def test_by_scenario_a_law_that_fails_one_scenario_fails():
    found = costs((10, 20))
    found[0] = np.inf
    assert np.isfinite(IQM(found))
    assert SCENARIO_IQM(found) == np.inf


def test_by_scenario_a_ratio_does_not_see_the_scenarios_scales():
    found, scale = costs((2, 4, 12)), np.array([1.0, 10.0, 0.1, 3.0])[:, None]
    first, second = SCENARIO_IQM(found), SCENARIO_IQM(found * scale)
    assert second[0] / second[1] == pytest.approx(first[0] / first[1], rel=1e-12)
    pooled, scaled = IQM(found), IQM(found * scale)
    assert scaled[0] / scaled[1] != pytest.approx(pooled[0] / pooled[1], rel=1e-3)
    with pytest.raises(StatisticsError, match="needs costs > 0"):
        SCENARIO_IQM(found - 100.0)


@given(st.integers(0, 2**32 - 1), st.floats(0.01, 100.0))
def test_the_order_of_seeds_says_nothing_and_the_unit_goes_through(seed, factor):
    found, random = costs((3, 9), seed), np.random.default_rng(seed)
    mixed = random.permuted(found, axis=1)
    for statistic in (IQM, CVAR, MEAN, SCENARIO_IQM):
        assert statistic(mixed) == pytest.approx(statistic(found), rel=1e-12)
        assert statistic(factor * found) == pytest.approx(factor * statistic(found), rel=1e-12)


@pytest.mark.parametrize("statistic", [IQM, CVAR, MEAN, SCENARIO_IQM], ids=lambda s: s.name)
def test_the_influence_of_a_run_is_what_one_more_copy_of_it_changes(statistic):
    found, copies = costs((2, 100), 3), 2000
    # Every run often, and one of them once more: the derivative by its weight
    counts = np.full((2, 100, 1), copies)
    more = counts.copy()
    more[1, 17] += 1
    pool = {"costs": found, "slope": statistic.slopes(found, np.ones((2, 100, 1), dtype=int))[1, 17, 0]}
    runs = 100 if statistic.by_scenario else 200
    whole = statistic(found)
    repeated = [np.repeat(row, n[:, 0]) for row, n in zip(pool["costs"], more, strict=True)]
    if statistic.by_scenario:
        levels = QuantileMean("", statistic.low, statistic.high)
        changed = np.mean([np.log(levels(row[None])) for row in repeated]) - np.log(whole)
        changed *= 2  # of one scenario of two
    else:
        joined = np.concatenate(repeated)
        changed = statistic(joined[None]) - whole
        # A stratum's centre is taken off: what moves is the run against its own scenario
        shift = statistic.slopes(found.reshape(1, 200), np.ones((1, 200, 1), dtype=int))[0, 100:].mean()
        changed -= shift / (copies * runs)
    assert changed * copies * runs == pytest.approx(pool["slope"], rel=0.01, abs=1e-3)


def test_levels_that_are_none_are_refused():
    with pytest.raises(StatisticsError, match=r"the levels are 0\.9 and 0\.1; give two from 0 to 1, the lower first"):
        QuantileMean("turned round", 0.9, 0.1)
