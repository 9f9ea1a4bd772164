"""The bootstrap: against scipy's, against resampling by hand, and by how often its intervals hold the truth."""

import numpy as np
import pytest
from scipy.stats import bootstrap

from robotics.measures.statistics.aggregates import CVAR, IQM, MEAN, SCENARIO_IQM
from robotics.measures.statistics.bootstrap import contrasts, interval, resampled, resamples
from robotics.measures.statistics.costs import StatisticsError


def paired(laws: int = 3, scenarios: int = 4, seeds: int = 25, seed: int = 0) -> np.ndarray:
    """Costs in which most of the noise is common to all laws."""
    random = np.random.default_rng(seed)
    common, own = random.normal(size=(1, scenarios, seeds)), random.normal(size=(laws, scenarios, seeds))
    return np.exp(common + 0.2 * own + 0.1 * np.arange(laws)[:, None, None])


def test_of_every_scenario_one_run_less_is_drawn_and_a_seed_gives_the_same_bits():
    first, again = (resamples((3, 7), 50, np.random.default_rng(4)) for _ in range(2))
    assert first.shape == (3, 7, 50)
    assert (first.sum(axis=1) == 6).all()
    assert np.array_equal(first, again)
    assert first.mean(axis=2) == pytest.approx(np.full((3, 7), 6 / 7), abs=0.6)


@pytest.mark.parametrize("statistic", [IQM, CVAR, MEAN, SCENARIO_IQM], ids=lambda s: s.name)
@pytest.mark.parametrize("failures", [0, 9])
def test_counting_copies_gives_what_repeating_the_runs_gives(statistic, failures):
    costs, random = paired(seeds=11), np.random.default_rng(1)
    costs.ravel()[random.choice(costs.size, failures, replace=False)] = np.inf
    counts = resamples((4, 11), 40, random)
    found = resampled(costs, statistic, counts)
    by_hand = np.empty_like(found)
    for draw in range(40):
        rows = [np.repeat(np.arange(11), n) for n in counts[:, :, draw]]
        runs = np.stack([costs[:, k, row] for k, row in enumerate(rows)], axis=1)
        by_hand[draw] = statistic(runs)
    assert np.array_equal(np.isinf(found), np.isinf(by_hand))
    finite = np.isfinite(found)
    assert found[finite] == pytest.approx(by_hand[finite], rel=1e-12)
    # Any function is resampled, too, with the same resamples
    assert resampled(costs, lambda runs: statistic(runs), counts)[finite] == pytest.approx(found[finite], rel=1e-12)


@pytest.mark.parametrize("statistic", [IQM, MEAN], ids=lambda s: s.name)
def test_percentiles_of_one_scenario_are_scipys(statistic):
    costs, random = paired(laws=2, scenarios=1, seeds=60), np.random.default_rng(2)

    def one(runs: np.ndarray, axis: int = -1) -> np.ndarray:
        return statistic(np.moveaxis(runs, axis, -1)[..., None, :])

    own = interval(costs, statistic, generator=random, draws=20000, method="percentile")
    apart = contrasts(costs, statistic, "difference", generator=random, draws=20000, method="percentile")[0, 1]
    expected = bootstrap((costs[0, 0],), one, n_resamples=20000, method="percentile", rng=3)
    between = bootstrap(
        (costs[0, 0], costs[1, 0]), lambda x, y, axis=-1: one(x, axis) - one(y, axis),
        paired=True, n_resamples=20000, method="percentile", rng=3,
    )  # fmt: skip
    for found, theirs in ((own[0], expected), (apart, between)):
        ends = theirs.confidence_interval
        assert float(found.low) == pytest.approx(ends.low, abs=0.12 * theirs.standard_error)
        assert float(found.high) == pytest.approx(ends.high, abs=0.12 * theirs.standard_error)


def test_pairing_takes_out_what_the_laws_have_in_common():
    costs = paired()
    alone = costs.copy()
    alone[1] = np.random.default_rng(5).permuted(alone[1], axis=1)  # the same runs, at other seeds
    widths = []
    for each in (costs, alone):
        found = contrasts(each, generator=np.random.default_rng(6))[0, 1]
        widths.append(float(np.log(found.high / found.low)))
    assert widths[1] > 3 * widths[0]


def test_strata_take_out_the_scenarios_scale():
    costs = paired(scenarios=4) * np.array([1.0, 10.0, 100.0, 1000.0])[:, None]
    stratified = interval(costs, MEAN, generator=np.random.default_rng(7), method="percentile")[0]
    pooled = interval(costs.reshape(3, 1, -1), MEAN, generator=np.random.default_rng(7), method="percentile")[0]
    # The textbook's errors of the mean: of independent strata in equal parts, and of one sample
    own = np.sqrt((costs[0].var(axis=1, ddof=1) / 25).sum()) / 4
    all_together = costs[0].std(ddof=1) / np.sqrt(100)
    assert own < 0.85 * all_together
    assert float(stratified.high - stratified.low) == pytest.approx(2 * 1.96 * own, rel=0.05)
    assert float(pooled.high - pooled.low) == pytest.approx(2 * 1.96 * all_together, rel=0.05)


def test_a_ratio_turned_round_has_the_reciprocal_interval():
    found = contrasts(paired(), generator=np.random.default_rng(8))
    assert np.diagonal(found.value) == pytest.approx(np.ones(3))
    assert pytest.approx(1 / found.high, rel=1e-12) == found.low.T


def test_failures_make_ratios_infinite_zero_or_unknown():
    costs = paired(laws=4)
    costs[2:] = np.inf
    found = contrasts(costs, generator=np.random.default_rng(9))
    assert (found.value[2, 0], found.low[2, 0], found.high[2, 0]) == (np.inf, np.inf, np.inf)
    assert (found.value[0, 2], found.low[0, 2], found.high[0, 2]) == (0.0, 0.0, 0.0)
    assert np.isnan(found.value[2, 3])
    assert (found.low[2, 3], found.high[2, 3]) == (0.0, np.inf)
    apart = contrasts(costs, IQM, "difference", generator=np.random.default_rng(9))
    assert (apart.value[2, 0], apart.value[0, 2]) == (np.inf, -np.inf)
    # Some failures: the worst tenth is infinite, and so is its upper end; resamples without a failure bound it below.
    costs = paired()
    costs[0, 0, 0] = np.inf
    worst = interval(costs, CVAR, generator=np.random.default_rng(9))[0]
    assert worst.value == worst.high == np.inf
    assert np.isfinite(worst.low)


@pytest.mark.parametrize(
    ("costs", "words"),
    [
        (np.ones((2, 3)), r"costs have the shape \(2, 3\); it must be \(laws, scenarios, seeds\), none of them 0"),
        (np.ones((2, 3, 1)), "costs of one seed have no interval; give two seeds or more"),
        (np.array([[[1.0, np.nan]]]), "the cost of law 0, scenario 0, seed 1 is nan"),
        (np.array([[[-np.inf, 1.0]]]), "the cost of law 0, scenario 0, seed 0 is -inf"),
        (np.array([[[-2.0, 1.0]]]), "a ratio needs costs > 0; take the difference"),
    ],
)
def test_what_is_no_cost_is_refused(costs, words):
    with pytest.raises(StatisticsError, match=words):
        contrasts(costs, generator=np.random.default_rng(0), draws=10)


def test_only_quantile_means_have_studentised_intervals():
    with pytest.raises(StatisticsError, match='"studentised" is for quantile means'):
        interval(
            paired(), lambda runs: runs.mean(axis=(-2, -1)), generator=np.random.default_rng(0), method="studentised"
        )


@pytest.mark.parametrize(("statistic", "method"), [(IQM, "percentile"), (CVAR, "studentised"), (MEAN, "studentised")])
def test_statistics_that_reach_the_greatest_costs_are_studentised_by_default(statistic, method):
    for found in (interval, contrasts):
        default = found(paired(), statistic, generator=np.random.default_rng(1), draws=200)
        asked = found(paired(), statistic, generator=np.random.default_rng(1), draws=200, method=method)
        assert np.array_equal(default.low, asked.low)


def test_the_studentised_interval_of_a_mean_divides_by_the_resamples_own_errors():
    """By hand: one scenario, the textbook's s/√n, on the plain scale since some costs are not > 0."""
    costs, counts = paired(laws=1, scenarios=1, seeds=40) - 0.5, resamples((1, 40), 2000, np.random.default_rng(3))
    runs = np.stack([np.repeat(costs[0, 0], n) for n in counts[0].T])
    value, t = costs.mean(), (runs.mean(axis=1) - costs.mean()) / (runs.std(axis=1, ddof=1) / np.sqrt(39))
    error = costs[0, 0].std(ddof=1) / np.sqrt(40)
    found = interval(costs, MEAN, generator=np.random.default_rng(3), method="studentised")[0]
    assert float(found.low) == pytest.approx(value - np.quantile(t, 0.975) * error, rel=0.01)
    assert float(found.high) == pytest.approx(value - np.quantile(t, 0.025) * error, rel=0.01)


@pytest.mark.parametrize("statistic", [IQM, CVAR, MEAN, SCENARIO_IQM], ids=lambda s: s.name)
@pytest.mark.parametrize("kind", ["ratio", "difference"])
def test_standard_errors_by_slopes_are_how_much_resamples_vary(statistic, kind):
    """Many seeds, so that intervals by either way agree: the influence functions know the pairs and the strata."""
    costs = paired(laws=2, scenarios=3, seeds=200)
    plain, studentised = (
        contrasts(costs, statistic, kind, generator=np.random.default_rng(4), draws=600, method=method)[0, 1]
        for method in ("percentile", "studentised")
    )
    assert studentised.high - studentised.low == pytest.approx(plain.high - plain.low, rel=0.2)
    assert float(studentised.low + studentised.high) / 2 == pytest.approx(float(plain.value), rel=0.05)


def test_where_failures_reach_the_statistic_the_percentiles_stand_instead():
    costs = paired()
    costs[0, 0, 0] = np.inf
    plain, studentised = (
        interval(costs, CVAR, generator=np.random.default_rng(4), method=method)
        for method in ("percentile", "studentised")
    )
    assert studentised.low[0] == plain.low[0]
    assert studentised.high[0] == np.inf
    assert studentised.high[1] != plain.high[1]
