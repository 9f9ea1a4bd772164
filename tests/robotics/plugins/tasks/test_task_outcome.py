"""The ranking of an arena of tasks: lexicographic, by classes, with exact bounds, whatever the laws are called."""

from itertools import product
from typing import Any

import numpy as np
import pandas as pd
import pytest
from scipy.stats import binom

from robotics.plugins.arena.kinds import parse_plan
from robotics.plugins.tasks.answer import answer
from robotics.plugins.tasks.description import CLASSES, knowledge_of
from robotics.plugins.tasks.outcome import KEY, TaskEntry, TaskOutcome, key_of, paired_p
from robotics.plugins.tasks.report import ranking_table, results_table
from robotics.plugins.tasks.running import search_cost, tail_of
from tests.robotics.plugins.tasks.test_task_families import TEXT

RUNS = 7
GOOD = {
    "caused": 0.0,
    "touched": 0.0,
    "deadlock": 0.0,
    "refused": 0.0,
    "time": 1.1,
    "spread_s": 0.5,
    "gap": 0.1,
    "restlessness": 0.2,
    "clearance_m": 0.2,
    "emergency": np.nan,
}


def table(runs=RUNS, **changes):
    """Runs of one law; a change is a number for all, or for the first run only as (number,)."""
    found = pd.DataFrame({"scenario": range(runs), "candidate": 0, **GOOD}, index=range(runs))
    for name, value in changes.items():
        if isinstance(value, tuple):
            found.loc[0, name] = value[0]
        else:
            found[name] = value
    return found


def outcome(**tables):
    """The outcome of an arena of laws by their names, with _ for -."""
    laws = [name.replace("_", "-") for name in tables]
    plan: Any = parse_plan(TEXT).with_laws(laws)
    entries = [
        TaskEntry(law, (), (), (0,), 0, None, own, own, None) for law, own in zip(laws, tables.values(), strict=True)
    ]
    return TaskOutcome(plan, tuple(entries))


def test_each_number_counts_only_where_all_before_it_are_the_same():
    worse = {
        "caused": 1.0,
        "deadlock": 1.0,
        "time": 3.0,
        "spread_s": 9.0,
        "gap": 1.0,
        "restlessness": 5.0,
        "clearance_m": 0.0,
    }
    for first, later in product(range(len(KEY)), repeat=2):
        if first < later:
            # Worse in one number, however little, and better in all later ones
            little = {KEY[first]: GOOD[KEY[first]] + (-1e-3 if KEY[first] == "clearance_m" else 1e-3)}
            much = {name: worse[name] for name in KEY[first + 1 : later + 1]}
            assert key_of(table(**much)) < key_of(table(**little))


def test_the_ranking_follows_the_runs_and_not_the_names():
    tables = [table(), table(time=1.2), table(deadlock=(1.0,)), table(caused=(1.0,), time=1.0)]
    names = ["stop_and_wait", "potential_field", "dynamic_window", "lyapunov"]
    for turn in range(4):
        turned = names[turn:] + names[:turn]
        found = outcome(**dict(zip(turned, tables, strict=True)))
        assert [found.laws[k] for k in found.order] == [name.replace("_", "-") for name in turned]


def test_classes_are_ranked_apart():
    found = outcome(
        stop_and_wait=table(caused=(1.0,)), orca=table(time=1.4), fuzzy_team=table(), right_of_way=table(deadlock=1.0)
    )
    assert found.classes == ["own sensors", "radio", "radio", "everything beforehand"]
    assert [[found.laws[k] for k in found.among(name)] for name in CLASSES] == [
        ["stop-and-wait"],
        ["fuzzy-team", "orca"],
        ["right-of-way"],
    ]
    assert ranking_table(found)["rank"].tolist() == [1, 1, 2, 1]


@pytest.mark.parametrize(
    ("law", "knowledge"),
    [("dynamic-window", 0), ("potential-field", 0), ("orca", 1), ("cooperation", 1), ("fuzzy-team-planned", 2)],
)
def test_what_a_law_knows_is_read_of_the_law(law, knowledge):
    assert knowledge_of(parse_plan(TEXT).law(law)) == CLASSES[knowledge]


def test_bounds_of_none_are_exact_and_refusing_makes_nobody_safer():
    nothing = dict.fromkeys(("caused", "touched", "clearance_m"), (np.nan,))
    found = outcome(stop_and_wait=table(), right_of_way=table(refused=(1.0,), deadlock=(1.0,), **nothing))
    share = found.share("caused")
    for k, trials in enumerate((RUNS, RUNS - 1)):
        assert share.value[k] == share.low[k] == 0
        assert share.high[k] == pytest.approx(1 - 0.025 ** (1 / trials), rel=1e-12)
    assert found.share("deadlock").value[1] == pytest.approx(1 / RUNS)


def test_pairs_are_compared_by_the_runs_in_which_they_differ():
    first, second = np.array([1] * 9 + [0] * 31), np.array([0] * 8 + [1] + [1, 0] * 15 + [0])
    only, other = int((first > second).sum()), int((second > first).sum())
    expected = min(1.0, 2 * binom.cdf(min(only, other), only + other, 0.5))
    assert paired_p(first, second) == pytest.approx(expected)
    assert paired_p(first, first) == 1.0
    assert paired_p([1.0, np.nan], [0.0, 1.0]) == 1.0


def test_the_tail_tells_apart_who_nearly_touched():
    clearance = np.array([0.5] * 18 + [0.02, -0.03])
    assert tail_of(clearance, 0.1, 0.1) == pytest.approx((0.8 + 1.3) / 2)
    assert tail_of(np.full(20, 0.5), 0.1, 0.1) == 0
    plan: Any = parse_plan(TEXT)
    near, far = table(20, clearance_m=(0.01,)), table(20)
    assert search_cost(plan, near) > search_cost(plan, far)
    without: Any = parse_plan("tail = 0\n" + TEXT)
    assert search_cost(without, near) == search_cost(without, far)  # of rare contacts it is the tail that tells


def test_a_contact_weighs_more_in_a_search_than_a_deadlock_and_that_more_than_time():
    plan: Any = parse_plan(TEXT)
    contact, deadlock, slow = table(20, caused=(1.0,)), table(20, deadlock=(1.0,)), table(20, time=1.5)
    assert search_cost(plan, contact) > 2 * search_cost(plan, deadlock)
    assert search_cost(plan, deadlock) > search_cost(plan, slow) > search_cost(plan, table(20))


def test_the_answer_has_ten_sentences_at_most_with_its_numbers():
    found = outcome(stop_and_wait=table(), potential_field=table(caused=1.0), right_of_way=table(time=2.0))
    sentences = answer(found)
    assert 4 <= len(sentences) <= 10
    assert sentences[0].startswith("With own sensors, Stop and wait is first")
    assert "1e+03 of 1,000" in sentences[0]
    assert "may be chance" not in sentences[0]
    assert any(s.startswith(f"No contact in {RUNS} runs was caused by Stop and wait") for s in sentences)


def test_a_difference_that_may_be_chance_is_called_so():
    found = outcome(stop_and_wait=table(), potential_field=table(caused=(1.0,)))
    assert answer(found)[0].endswith("a difference that may be chance.")


def test_a_row_of_the_results_is_a_run_with_what_was_drawn():
    rows = results_table(outcome(stop_and_wait=table(), right_of_way=table()))
    assert len(rows) == 2 * RUNS
    assert rows["robots"].between(3, 3).all()
    assert {"law", "task", "loss", "latency_s", "caused", "clearance_m"} <= {*rows.columns}
