"""How often intervals hold the truth: paired, stratified, skewed costs of which the truth is known in closed form."""

from typing import Any

import numpy as np
import pytest
from scipy.optimize import brentq
from scipy.stats import binom, norm

from robotics.measures.statistics.aggregates import CVAR, IQM, MEAN, SCENARIO_IQM, UNSEEN_IQM, QuantileMean
from robotics.measures.statistics.bootstrap import contrasts
from robotics.measures.statistics.shares import probability_of_improvement

SCENARIOS = 8
# Log-normal costs of two laws: means and spreads of the logarithm differ by law and by scenario
CENTRES = np.array([np.linspace(-0.7, 0.7, SCENARIOS), np.linspace(-0.8, 1.1, SCENARIOS)])
SPREADS = np.array([np.linspace(0.5, 1.0, SCENARIOS), np.linspace(0.9, 0.4, SCENARIOS)])
COMMON = 0.6  # the correlation of both laws' logarithms at one seed


def experiment(seeds: int, random: np.random.Generator) -> np.ndarray:
    """The costs (2, SCENARIOS, seeds) of one synthetic experiment."""
    common, own = random.normal(size=(1, SCENARIOS, seeds)), random.normal(size=(2, SCENARIOS, seeds))
    noise = np.sqrt(COMMON) * common + np.sqrt(1 - COMMON) * own
    return np.exp(CENTRES[..., None] + SPREADS[..., None] * noise)


def truth(statistic: QuantileMean, centres: np.ndarray, spreads: np.ndarray) -> float:
    """The quantile mean of a mixture of log-normal laws in equal parts, by partial expectations."""
    if statistic.by_scenario:
        plain = QuantileMean("", statistic.low, statistic.high)
        return float(np.exp(np.mean([np.log(truth(plain, *pair)) for pair in zip(centres, spreads, strict=True)])))

    def below(limit: float) -> float:
        return float(np.mean(norm.cdf((np.log(limit) - centres) / spreads)))

    def partial(level: float) -> float:
        if level in (0.0, 1.0):
            return level * float(np.mean(np.exp(centres + spreads**2 / 2)))
        limit = brentq(lambda x: below(x) - level, 1e-9, 1e6)
        inside = norm.cdf((np.log(limit) - centres - spreads**2) / spreads)
        return float(np.mean(np.exp(centres + spreads**2 / 2) * inside))

    return (partial(statistic.high) - partial(statistic.low)) / (statistic.high - statistic.low)


def ratio(statistic: QuantileMean) -> float:
    return truth(statistic, CENTRES[0], SPREADS[0]) / truth(statistic, CENTRES[1], SPREADS[1])


def chance(correlation: float) -> float:
    """The probability that the first law costs less, a mean over scenarios."""
    spread = np.sqrt((SPREADS**2).sum(axis=0) - 2 * correlation * SPREADS.prod(axis=0))
    return float(np.mean(norm.cdf((CENTRES[1] - CENTRES[0]) / spread)))


def held(name: str, seeds: int, experiments: int, seed: int, **options: Any) -> float:
    """The share of experiments whose 95 % interval holds the truth, in percent."""
    random, count = np.random.default_rng(seed), 0
    statistics = {"iqm": IQM, "scenario-iqm": SCENARIO_IQM, "cvar": CVAR, "mean": MEAN}
    true = ratio(statistics[name]) if name in statistics else chance(COMMON)
    for _ in range(experiments):
        costs = experiment(seeds, random)
        if name in statistics:
            found = contrasts(costs, statistics[name], generator=random, **options)[0, 1]
        else:
            found = probability_of_improvement(costs, generator=random, **options)[0, 1]
        count += bool(found.low <= true <= found.high)
    return 100 * count / experiments


def test_the_truth_is_that_of_a_large_sample():
    costs = experiment(100_000, np.random.default_rng(0))
    for statistic in (IQM, SCENARIO_IQM, CVAR, MEAN):
        first, second = statistic(costs)
        assert first / second == pytest.approx(ratio(statistic), rel=0.01)
    assert (costs[0] < costs[1]).mean() == pytest.approx(chance(COMMON), abs=0.002)


# Of 100 experiments the count of a true 95 % lies between these but once in 5,000
FEWEST, MOST = binom.ppf([1e-4, 1 - 1e-4], 100, 0.95)


@pytest.mark.parametrize("name", ["iqm", "scenario-iqm", "paired"])
def test_intervals_hold_the_truth_as_often_as_they_say(name):
    assert FEWEST <= held(name, 30, 100, 1, draws=400) <= MOST


def held_of_others(experiments: int, seed: int, *, scenarios: int = 32, seeds: int = 25, draws: int = 400) -> float:
    """The same of scenarios that are drawn at random themselves: the truth is that of all of their sort."""
    random, count, apart, spread = np.random.default_rng(seed), 0, 0.3, np.array([0.4, 0.6])
    for _ in range(experiments):
        hard = random.normal(size=(1, scenarios, 1))
        centres = (
            hard + np.array([apart, 0.0])[:, None, None] + spread[:, None, None] * random.normal(size=(2, scenarios, 1))
        )
        noise = random.normal(size=(1, scenarios, seeds)) + random.normal(size=(2, scenarios, seeds))
        found = contrasts(np.exp(centres + 0.3 * noise), UNSEEN_IQM, generator=random, draws=draws)[0, 1]
        count += bool(found.low <= np.exp(apart) <= found.high)
    return 100 * count / experiments


def test_intervals_over_scenarios_hold_the_truth_of_all_scenarios_of_their_sort():
    assert FEWEST <= held_of_others(100, 1) <= MOST
    # Within scenarios alone they would hold it far less often
    random = np.random.default_rng(3)
    costs = np.exp(random.normal(size=(2, 32, 1)) + 0.1 * random.normal(size=(2, 32, 25)))
    wide, narrow = (
        contrasts(costs, statistic, generator=np.random.default_rng(1))[0, 1]
        for statistic in (UNSEEN_IQM, SCENARIO_IQM)
    )
    assert wide.value == narrow.value
    assert wide.high / wide.low > (narrow.high / narrow.low) ** 4


@pytest.mark.long
@pytest.mark.parametrize("scenarios", [16, 32])
def test_of_a_thousand_experiments_over_scenarios_95_percent_hold_the_truth(scenarios):
    assert 93 <= held_of_others(1000, 2, scenarios=scenarios, draws=500) <= 97


@pytest.mark.long
@pytest.mark.parametrize("name", ["iqm", "scenario-iqm", "mean", "cvar", "paired"])
def test_of_a_thousand_experiments_95_percent_hold_the_truth(name):
    """Of few seeds, with which it is hardest; a thousand experiments leave 0.7 % of chance.

    The mean of 30 seeds is what its tail makes hard: of 3,000 such experiments 93.6 % held the truth.
    """
    fewest = 92 if name == "mean" else 93
    assert fewest <= held(name, 30, 1000, 2, draws=500) <= 97
