"""Intervals against scipy's, and the one rule that makes verdicts."""

import dataclasses
from itertools import product

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy import stats

from robotics.measures.evidence import Estimate, Part, adjusted, compared, exact, judge, mean_of, rate_of
from robotics.measures.leading import lead
from robotics.show.report.chapter import Claim
from robotics.show.report.wording import reading, sentence, shown

PART = Part(
    says="ours is small",
    form="corrected",
    estimate=Estimate(0.5, 0.4, 0.6, 20),
    bound=1.0,
    sense="below",
    unit="m",
    quantity="q",
    on="there",
    of="lyapunov",
)
HOLDS, FAILS, OPEN = (dataclasses.replace(PART, bound=bound) for bound in (1.0, 0.3, 0.5))


@given(st.integers(1, 500), st.data())
def test_a_rate_has_wilsons_interval_as_scipy_has_it(trials: int, data: st.DataObject) -> None:
    count = data.draw(st.integers(0, trials))
    theirs = stats.binomtest(count, trials).proportion_ci(0.95, method="wilson")
    found = rate_of(np.arange(trials) < count)
    assert (found.low, found.high) == pytest.approx((theirs.low, theirs.high), abs=1e-12)


@given(st.lists(st.floats(-1e3, 1e3), min_size=2, max_size=30))
def test_students_interval_is_scipys(values: list[float]) -> None:
    found = mean_of(np.array(values))
    error = stats.sem(values)
    low, high = stats.t.interval(0.95, len(values) - 1, np.mean(values), error) if error > 0 else (found.value,) * 2
    assert (found.low, found.high) == pytest.approx((low, high), rel=1e-9, abs=1e-9)


def test_runs_that_never_arrive_are_counted_and_say_nothing_of_the_others() -> None:
    found = mean_of(np.array([1.0, np.inf, 2.0]))
    assert (found.value, found.runs, found.lost) == (1.5, 3, 1)
    assert (found.low, found.high) == pytest.approx(stats.t.interval(0.95, 1, 1.5, stats.sem([1, 2])))
    assert shown(found, "s") == "1.5 ± 6.4 s, never in 1 of 3"
    none = mean_of(np.full(3, np.inf))
    assert (none.value, none.low, none.high, none.lost) == (np.inf, np.inf, np.inf, 3)
    assert dataclasses.replace(PART, estimate=mean_of(np.array([0.5]))).outcome == "open"  # one run tells nothing


def test_an_interval_decides_and_touching_the_bound_fails() -> None:
    assert [part.outcome for part in (HOLDS, FAILS, OPEN)] == ["holds", "fails", "open"]
    assert dataclasses.replace(PART, estimate=exact(1.0)).outcome == "fails"
    assert dataclasses.replace(PART, estimate=exact(1.0), sense="above").outcome == "fails"
    assert [dataclasses.replace(p, sense="above").outcome for p in (HOLDS, FAILS, OPEN)] == ["fails", "holds", "open"]


def test_the_rule_of_verdicts() -> None:
    """Written once more as a table: which outcomes a claim has, and what follows."""
    rule = {
        (True, False, False): "holds",
        (True, True, False): "holds in part",
        (True, True, True): "holds in part",
        (False, True, False): "does not hold",
        (False, True, True): "does not hold",
        (True, False, True): "cannot be told",
        (False, False, True): "cannot be told",
    }
    for parts in product((HOLDS, FAILS, OPEN), repeat=3):
        outcomes = {part.outcome for part in parts}
        assert judge(parts) == rule["holds" in outcomes, "fails" in outcomes, "open" in outcomes]


def test_comparisons_are_paired_and_against_the_best_of_the_others() -> None:
    rng = np.random.default_rng(1)
    shared = rng.normal(0, 5, 20)
    ours, theirs = 1.0 + shared, 1.1 + shared + rng.normal(0, 0.01, 20)
    estimate, bound, sense, kept = compared(ours, [theirs, theirs + 9])
    assert (bound, sense, kept) == (0.0, "below", 20)
    assert estimate.high < 0  # although each mean alone is known to ±1 only
    assert mean_of(ours).high - mean_of(ours).low > 2
    estimate, bound, sense, kept = compared(theirs, [ours, ours - 9], more=True)
    assert (sense, bound) == ("above", 0.0)
    assert estimate.low > 0


def test_where_a_law_never_arrives_the_runs_are_counted() -> None:
    never = np.full(20, np.inf)
    estimate, bound, sense, kept = compared(np.ones(20), [never])
    assert (estimate.kind, estimate.value, bound, sense) == ("rate", 0.0, 0.5, "below")
    assert kept == 20
    estimate, _, _, kept = compared(never, [never])
    assert (estimate.value, kept) == (1.0, 0)  # two that never arrive: neither is sooner


def test_sentences_follow_the_numbers() -> None:
    """The words about a number change with it, and so does the verdict."""
    claim = Claim(name="n", source="s", says="c", untested="u", parts=(HOLDS,))
    other = dataclasses.replace(claim, parts=(dataclasses.replace(HOLDS, estimate=Estimate(2.5, 2.4, 2.6, 20)),))
    assert claim.measured == "Corrected: ours is small: holds (Lyapunov 0.50 ± 0.10 m, asked for < 1 m)."
    assert other.measured == "Corrected: ours is small: fails (Lyapunov 2.50 ± 0.10 m, asked for < 1 m)."
    assert (claim.verdict, other.verdict) == ("holds", "does not hold")
    assert claim.row()["corrected"] == "holds"
    assert claim.row()["ideal"] == ""


@pytest.mark.parametrize(
    ("estimate", "unit", "words"),
    [
        (Estimate(0.00212, 0.00204, 0.00220, 20), "m", "2.120 ± 0.080 mm"),
        (Estimate(0.5, 0.43, 0.57, 200, "rate"), "1", "50 % (43 to 57)"),
        (Estimate(np.inf, np.inf, np.inf, 20), "s", "never"),
        (Estimate(np.inf, np.inf, np.inf, 20), "m", "without bound"),
        (exact(12.345), "s", "12.3 s"),
        (exact(-0.0), "m", "0 m"),
        (exact(3e-11), "", "3e−11"),
        (Estimate(3e-11, 2e-11, 4e-11, 20), "", "3e−11"),
        (Estimate(-1.5, -1.6, -1.4, 20), "", "−1.50 ± 0.10"),
        (Estimate(2.5, 2.5, 2.5, 20), "s", "2.50 s"),
    ],
)
def test_numbers_are_rounded_for_people(estimate: Estimate, unit: str, words: str) -> None:
    assert shown(estimate, unit) == words


def test_both_sides_of_a_comparison_are_told() -> None:
    ours, theirs = np.array([1.0, 1.1, 0.9]), np.array([2.0, 2.1, 1.9])
    estimate, bound, sense, _ = compared(ours, [theirs])
    part = dataclasses.replace(
        PART, estimate=estimate, bound=bound, sense=sense, against=("fuzzy",), sides=(mean_of(ours), mean_of(theirs))
    )
    assert reading(part) == "Lyapunov 1.00 ± 0.25 m, Fuzzy 2.00 ± 0.25 m; difference −1.00 m, asked for < 0"
    assert sentence(part).startswith("ours is small: holds (Lyapunov 1.00")


def test_who_leads_and_who_cannot_be_told_from_it() -> None:
    rng = np.random.default_rng(2)
    noise = rng.normal(0, 0.1, 20)
    values = {
        "best": 1.0 + noise,
        "same": 1.0 + noise + rng.normal(0, 0.01, 20),
        "worse": 1.2 + noise,
        "touches": 0.5 + noise,
        "never": np.full(20, np.inf),
    }
    found = lead("there", "time", "s", values, {"touches": 1})
    assert [s.leads for s in found.standings][2:] == [False, False, False]
    assert {s.law for s in found.standings if s.leads} == {"best", "same"}
    assert found.best == pytest.approx(1.0, abs=0.05)
    assert not any(s.leads for s in lead("there", "time", "s", {"touches": np.ones(3)}, {"touches": 3}).standings)
    turned = {law: -v for law, v in values.items()}
    more = lead("there", "clearance", "m", turned, {"touches": 1}, larger=True)
    assert [s.leads for s in more.standings] == [s.leads for s in found.standings]
    assert more.best == -found.best


@given(st.integers(1, 300), st.data())
def test_p_values_are_below_5_percent_where_the_interval_leaves_the_bound_out(runs: int, data: st.DataObject) -> None:
    rate = rate_of(np.arange(runs) < data.draw(st.integers(0, runs)))
    values = data.draw(st.lists(st.floats(-10, 10), min_size=2, max_size=20))
    for found, bound in (
        (rate, data.draw(st.floats(0.05, 0.95))),
        (mean_of(np.array(values)), data.draw(st.floats(-9, 9))),
    ):
        inside = found.low < bound < found.high
        assert (found.p_value(bound) < 0.05) != inside or min(abs(bound - found.low), abs(bound - found.high)) < 1e-6
    if np.std(values) > 1e-3:
        theirs = stats.ttest_1samp(values, 1.0).pvalue
        assert mean_of(np.array(values)).p_value(1.0) == pytest.approx(theirs, rel=1e-6, abs=1e-12)


def test_many_looks_are_counted() -> None:
    """A part that holds by itself is open where it is one of many; what is sure, or exact, stays."""
    shaky = dataclasses.replace(PART, estimate=mean_of(1.0 - 0.1 * np.arange(8) ** 0.2 + 0.04 * np.arange(8) % 0.07))
    sure = dataclasses.replace(PART, estimate=rate_of(np.ones(200, dtype=bool)), bound=0.5, sense="above")
    one = dataclasses.replace(PART, estimate=exact(0.5))
    (alone,) = adjusted([shaky])
    assert (shaky.outcome, alone.outcome) == ("holds", "holds")
    p = shaky.estimate.p_value(1.0)
    assert alone.adjusted == pytest.approx(p)
    many = adjusted([shaky] * 500 + [sure, one])
    assert many[0].adjusted == pytest.approx(min(1.0, 500 * p))
    assert [part.outcome for part in many[-3:]] == ["open", "holds", "holds"]
    assert many[-1].adjusted is None


def test_a_rate_is_a_share_of_bools() -> None:
    found = rate_of(np.array([True, False, True, True]))
    assert (found.value, found.runs, found.kind) == (0.75, 4, "rate")
