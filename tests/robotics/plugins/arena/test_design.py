"""What knowledge is worth under conditions: from costs that are given, and in a small arena that is held again."""

from dataclasses import replace

import numpy as np
import pandas as pd
import pytest

from robotics.plugins.arena.answer import answer
from robotics.plugins.arena.description import parse_arena
from robotics.plugins.arena.design import Cells, called
from robotics.plugins.arena.figures import plot_conditions
from robotics.plugins.arena.plan import ArenaError
from robotics.plugins.arena.report import panels, run_arena
from robotics.studies.tuning.cost import COST_TERMS, Term
from tests.robotics.plugins.arena.synthetic import noisy, outcome

COSTS = {
    "lyapunov": 2.0,
    "lyapunov:lead=auto": 1.2,
    "lyapunov:lead=auto,smooth=0.2": 0.7,
    "lqr": 3.0,
    "lqr:lead=auto,smooth=0.2": 0.9,
    "nmpc": 1.0,
}
BOTH = frozenset({"lead", "smooth"})


def given(**times):
    return outcome({law: times.get(law.partition(":")[0], 1) * noisy(c, n) for n, (law, c) in enumerate(COSTS.items())})


def test_what_knowledge_is_worth_is_a_mean_over_the_laws_that_have_it():
    cells = Cells(given())
    found = {called(parts): (laws, ratio) for parts, laws, ratio in cells.worth()}
    assert [*found] == ["lead", "lead, low-pass"]  # of predictive control there is no law without
    assert [laws for laws, _ in found.values()] == [1, 2]
    assert float(found["lead"][1].value) == pytest.approx(1.2 / 2, rel=0.01)
    assert float(found["lead, low-pass"][1].value) == pytest.approx(np.sqrt(0.7 / 2 * 0.9 / 3), rel=0.01)
    assert all(r.low < r.value < r.high < 1.05 * r.value for _, r in found.values())


def test_laws_that_know_the_same_are_set_beside_each_other():
    cells = Cells(given())
    assert [cells.of.laws[k] for k in cells.among(BOTH)] == [
        "lyapunov:lead=auto,smooth=0.2",
        "lqr:lead=auto,smooth=0.2",
        "nmpc",  # which reads ahead and filters by itself
    ]
    assert float(cells.spread(BOTH).value) == pytest.approx(1 / 0.7, rel=0.01)


def test_a_part_that_is_switched_off_is_not_known():
    laws = ["fuzzy-correcting:lead=0,smooth=0", "fuzzy-correcting:smooth=0", "fuzzy-correcting"]
    cells = Cells(outcome({law: noisy(1.0, n) for n, law in enumerate(laws)}))
    assert cells.given == [frozenset(), {"lead"}, BOTH]
    assert cells.rows == [[0, 1, 2]]


def test_the_floor_is_what_the_reference_varies():
    """On a circle at constant speed the reference turns at v/r until it slows down at the end."""
    cost = (*COST_TERMS, Term(metric="v_variation_mps2", scale=0.2))
    found = outcome({"lyapunov": noisy(1.0, 0), "lqr": noisy(1.0, 1)}, cost=COST_TERMS)
    circles = tuple(f for f in found.arena.test if f.path == "circle")
    arena = replace(found.arena, test=circles)
    turning, moving = [], []
    for scenario in arena.scenarios("test"):
        radius = 1 / np.abs(scenario.trajectory.paths[0].table[3]).max()
        speed = scenario.robots[0].timing.speed
        turning.append(speed / radius / (scenario.duration - 6.0))
        moving.append(2 * speed / scenario.duration)  # from rest, and to rest
    floor = Cells(replace(found, arena=arena)).floor
    assert floor == pytest.approx(np.exp(np.mean(np.log(turning))), rel=0.01)
    both = Cells(replace(found, arena=replace(arena, cost=cost))).floor
    assert both == pytest.approx(np.exp(np.mean(np.log(np.array(turning) + np.array(moving) / 0.2))), rel=0.02)


def test_each_condition_has_a_sentence_a_panel_and_its_laws():
    first = given()
    first = replace(first, under={"noise ×2": given(lqr=2.0)})
    said = [s for s in answer(first) if s.startswith(("As it is:", "Noise ×2:"))]
    assert len(said) == 2
    assert "with a lead 0.60 (" in said[0]
    assert "of the three laws with a lead and a low-pass Predictive control, the last, costs 4" in said[0]
    assert "a low-pass LQR (lead=auto,smooth=0.2), the last, costs 2.6 times as much as Lyapunov (lead" in said[1]
    figure = plot_conditions(panels(first))
    assert [ax.get_title() for ax in figure.axes if ax.get_visible()] == ["as it is", "noise ×2"]
    assert [t.get_text() for t in figure.axes[0].get_xticklabels()] == ["as it is", "lead", "lead,\nlow-pass"]


TEXT = """
laws = ["lyapunov", "lyapunov:estimator=kalman"]
engines = ["random"]
evaluations = 4
runs = 1
repeats = 1
choosing_runs = 2
testing_runs = 3
robustness_runs = 2
[conditions]
title = "perfect encoders"
latency = 0.05
[[under]]
title = "encoders 5 % wrong"
encoder_error = 0.05
[[tune]]
path = "sine"
duration = 12.5
[[choose]]
path = "sine"
duration = 12.5
[[test]]
path = "circle"
duration = 12.5
"""


def test_an_arena_is_held_again_and_every_law_tuned_anew(tmp_path):
    arena = parse_arena(TEXT, "small")
    assert arena.under[0].latency == 0.05  # as told for all
    found = run_arena(arena, tmp_path)
    other = found.under["encoders 5 % wrong"]
    (own,) = (tmp_path / "under").iterdir()
    for law in ("lyapunov", "lyapunov-estimator=kalman"):
        histories = [next((at / "searches" / law).glob("*/history.csv")).read_text() for at in (tmp_path, own)]
        assert (histories[0] == histories[1]) == (law == "lyapunov")  # which has no use for encoders
    assert (found.tuned[0] == other.tuned[0]).all()
    assert (found.tuned[1] != other.tuned[1]).all()
    table = pd.read_csv(tmp_path / "conditions.csv")
    assert table.groupby("condition")["law"].agg(set).to_dict() == {
        "perfect encoders": {*arena.laws},
        "encoders 5 % wrong": {*arena.laws},
    }
    page = (tmp_path / "arena.html").read_text(encoding="utf-8")
    assert "Law, knowledge and conditions" in page
    assert "Encoders 5 % wrong: a tuned law costs with a filter" in page


@pytest.mark.parametrize("title", ["", "perfect encoders"])
def test_conditions_have_titles_of_their_own(title):
    with pytest.raises(ArenaError, match=r"mine\.toml:13: under: each of the conditions needs a title of its own"):
        parse_arena(TEXT.replace("encoders 5 % wrong", title), file="mine.toml")
