"""The sentences of an arena, on outcomes that are known beforehand."""

import re

import numpy as np
import pytest

from robotics.measures.statistics.intervals import Interval
from robotics.plugins.arena.answer import MOST_SENTENCES, answer, compared
from robotics.plugins.arena.report import arena_chapters, standings
from robotics.studies.tuning.cost import COST_TERMS
from tests.robotics.plugins.arena.synthetic import SHAPE, noisy, outcome


def said(found):
    sentences = answer(found)
    assert len(sentences) <= MOST_SENTENCES
    for sentence in sentences:
        assert re.fullmatch(r"[A-Z].*[.]", sentence), sentence
        assert not re.search(r"\bnan\b|\binf\b|None|  ", sentence), sentence
    return " ".join(sentences)


def interval(value, low, high):
    return Interval(np.array(value), np.array(low), np.array(high))


def test_fuzzy_wins():
    text = said(outcome({"fuzzy": noisy(1.0, 0), "lyapunov": noisy(1.3, 1), "lqr": noisy(1.6, 2)}))
    assert "Fuzzy leads" in text
    assert "A fuzzy law leads the entrants: Lyapunov" in text
    assert re.search(r"Lyapunov, the best that is neither fuzzy nor predicts, costs (29|30|31) % more than Fuzzy", text)


def test_fuzzy_loses():
    text = said(outcome({"fuzzy": noisy(1.5, 0), "lyapunov": noisy(1.0, 1), "lqr": noisy(1.2, 2)}))
    assert "Lyapunov leads: its cost is the least, and LQR, the next, costs" in text
    assert re.search(
        r"A law that is not fuzzy leads the entrants: Fuzzy, the best fuzzy law, costs (49|50|51) % more than Lyapunov",
        text,
    )


def test_two_that_are_alike_are_called_so():
    text = said(outcome({"fuzzy": noisy(1.0, 0), "lyapunov": noisy(1.01, 1), "lqr": noisy(1.6, 2)}))
    assert "Fuzzy has the least cost, and Lyapunov is as good within 5 %" in text
    assert "Fuzzy or nonlinear? Either:" in text


def test_too_few_runs_are_not_made_to_decide():
    scattered = np.random.default_rng(0)
    both = {law: np.exp(scattered.normal(0.0, 1.5, SHAPE)) for law in ("fuzzy", "lyapunov")}
    text = said(outcome(both))
    assert "cannot tell it apart" in text
    assert "These runs do not decide it" in text


def test_a_law_that_fails_stands_last_and_is_counted():
    failing = noisy(0.5, 0)
    failing[0, :20] = np.inf  # half of one scenario
    found = outcome({"fuzzy": failing, "lyapunov": noisy(1.0, 1), "lqr": noisy(1.2, 2)})
    text = said(found)
    assert found.order[-1] == 0
    assert "Lyapunov leads" in text
    assert "A law that is not fuzzy leads the entrants: Fuzzy, the best fuzzy law, fails" in text
    assert "Of 480 runs each, these failed: Fuzzy in 4.2 % (2.7 % to 6.3 %)" in text  # Wilson of 20 in 480


def test_where_all_fail_nobody_leads():
    text = said(outcome(dict.fromkeys(("fuzzy", "lyapunov"), np.full(SHAPE, np.inf))))
    assert "No law leads" in text
    assert "Lyapunov in 100 %" in text


def test_a_reference_that_fails_is_no_unit():
    failing = np.full(SHAPE, np.inf)
    found = outcome({"fuzzy": noisy(1.0, 0), "lyapunov": failing}, reference="lyapunov")
    assert found.laws[found.reference] == "fuzzy"
    assert "multiples" not in said(found)


def test_where_every_law_fails_a_scenario_the_least_mean_is_the_unit_there():
    costs = {"fuzzy": noisy(1.0, 1), "lyapunov": noisy(1.3, 2), "lqr": noisy(0.9, 3)}
    for place, own in enumerate(costs.values()):
        own[place] = np.inf
    found = outcome(costs)
    unit = found.scenario_costs[found.reference].copy()
    unit[found.reference] = np.delete(found.scenario_costs[:, found.reference], found.reference).min()
    np.testing.assert_allclose(found.relative[2, 3:], costs["lqr"][3:] / unit[3:, None], rtol=1e-12)
    assert np.isinf(found.relative[found.reference, found.reference]).all()
    assert np.isfinite(found.pooled.value).all()
    assert "No law leads" in said(found)


def test_of_a_cost_without_variation_no_effort_is_told():
    costs = {"fuzzy": noisy(1.0, 1), "lyapunov": noisy(1.3, 2), "lqr": noisy(0.9, 3)}
    found = outcome(costs, cost=COST_TERMS[:2])  # distance and heading
    assert found.effort("tuned") is None
    assert np.isnan(standings(found).effort).all()
    (chapter,) = [each for each in arena_chapters(found) if each.name == "costs"]
    assert [picture.name for picture in chapter.pictures] == ["improvement"]


def test_distances_are_told_to_the_reference():
    tuned = {"fuzzy": noisy(1.2, 0), "lyapunov": noisy(1.0, 1), "lqr": noisy(1.5, 2)}
    assert re.search(
        r"As multiples of Lyapunov's cost.*Fuzzy 1\.[12]\d?.*LQR 1\.[45]", said(outcome(tuned, reference="lyapunov"))
    )
    assert "As multiples" not in said(outcome(tuned))


def test_engines_that_rank_otherwise_are_told():
    tuned = {"fuzzy": noisy(1.0, 0), "lyapunov": noisy(1.2, 1)}
    alike = {"fuzzy": np.array([3.0, 1.0, 1.1]), "lyapunov": np.array([3.0, 2.0, 2.1])}
    assert "Both engines rank the laws alike" in said(outcome(tuned, choosing=alike))
    other = {"fuzzy": np.array([3.0, 1.0, 2.5]), "lyapunov": np.array([3.0, 2.0, 2.0])}
    assert "by cmaes Fuzzy leads and by random Lyapunov leads" in said(outcome(tuned, choosing=other))
    assert "Only one engine searched" in said(outcome(tuned, engines=("cmaes",)))


def test_what_tuning_did_is_told_also_where_it_did_harm():
    tuned = {"fuzzy": noisy(1.0, 0), "lyapunov": noisy(1.3, 1), "lqr": noisy(1.6, 2)}
    before = {"fuzzy": 2 * tuned["fuzzy"], "lyapunov": 0.5 * tuned["lyapunov"], "lqr": tuned["lqr"]}
    text = said(outcome(tuned, before))
    assert "Tuning lowered the cost of Fuzzy by 50 %; it raised that of Lyapunov; for one other law it makes" in text


def test_an_expensive_leader_is_told_what_a_cheap_law_costs():
    tuned = {"fuzzy": noisy(1.1, 0), "lyapunov": noisy(1.0, 1)}
    text = said(outcome(tuned, computing={"fuzzy": 0.5, "lyapunov": 80.0}))
    assert re.search(r"Lyapunov computes for 80 µs a period; Fuzzy, the best of the laws .* \(0.5 µs\), costs", text)
    text = said(outcome(tuned, computing={"fuzzy": 0.5, "lyapunov": 0.5}))
    assert "no law that does not fail computes for less than a tenth" in text


def test_exceptions_from_the_budget_are_told():
    tuned = {"fuzzy": noisy(1.1, 0), "lyapunov": noisy(1.0, 1)}
    text = said(outcome(tuned, exceptions={"lyapunov": 20}))
    assert "Lyapunov only 20" in text
    assert "the same budget" not in text


@pytest.mark.parametrize(
    ("ratio", "words"),
    [
        (interval(1.08, 1.06, 1.11), "costs 8.0 % more than X (95 %: 6.0 to 11 %)"),
        (interval(0.9, 0.88, 0.93), "costs 10 % less than X (95 %: 7.0 to 12 %)"),
        (interval(1.02, 0.97, 1.05), "costs 2.0 % more than X (95 %: 3.0 % less to 5.0 % more)"),
        (interval(2.9, 2.7, 3.1), "costs 2.9 times as much as X (95 %: 2.7 to 3.1)"),
        (interval(np.inf, 3.0, np.inf), "fails"),
        (interval(np.nan, -np.inf, np.inf), "fails as X does"),
        (interval(0.0, 0.0, 0.0), "does not fail as X does"),
    ],
)
def test_comparisons_in_words(ratio, words):
    assert compared(ratio, "X") == words


def test_what_a_law_is_given_is_told_apart_from_the_law():
    laws = {
        "lyapunov": 2.0,
        "lyapunov:lead=auto": 1.2,
        "lyapunov:lead=auto,smooth=0.2": 0.7,
        "lqr:lead=auto,smooth=0.2": 0.9,
    }
    text = said(outcome({law: noisy(level, n) for n, (law, level) in enumerate(laws.items())}))
    assert re.search(
        r"What a law is given counts, a lead .* a tuned law costs with a lead 0\.60 \(0.60 to 0.60\) and "
        r"with a lead and a low-pass 0\.35 \(0.35 to 0.35\) times what it costs without",
        text,
    )
    assert re.search(r"of the two laws with a lead and a low-pass LQR, the last, costs (28|29|30) % more than L", text)
    assert "What a law is given" not in said(outcome({"fuzzy": noisy(1.0, 0), "lyapunov": noisy(1.3, 1)}))
