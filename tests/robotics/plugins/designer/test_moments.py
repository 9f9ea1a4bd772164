"""A tried run in time: its moments, the rules that ruled, and its curves, against the run itself."""

from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from fuzzy.inference import infer
from fuzzy.insight.explanation import firing_strengths
from fuzzy.system import Sugeno
from robotics.laws.catalogue import make_controller
from robotics.laws.tracking.fuzzy_tracking import load_rule_base
from robotics.measures.decisions import shares
from robotics.plugins.designer.moments import RunMoments, asked_of, bends, motion_curves, reference_curves, rule_times
from robotics.plugins.designer.tryout import TryoutTrial, run_design, settled
from robotics.plugins.designer.uses import TryoutError
from robotics.simulation.loop import simulate
from robotics.simulation.run import Run
from robotics.simulation.scenario.reading import load_scenario


@pytest.fixture(scope="module")
def fis() -> Sugeno:
    return load_rule_base("tracking")


@pytest.fixture(scope="module")
def run(fis: Sugeno) -> Run:
    return run_design(fis, settled(fis, TryoutTrial(scenario="lyapunov-circle"))).run


def test_what_was_asked_at_a_time_gives_the_command_of_that_period(fis: Sugeno, run: Run) -> None:
    asked = asked_of(run, "tracking")
    assert asked is not None
    assert asked_of(run, "eta") is None
    for place in (0, 7, 200):
        now = asked.at(float(run.time[place]))
        assert now is not None
        np.testing.assert_array_equal(now, run.inputs[place, :, 0, 0])
        # until the next period begins it is the last one that counts
        np.testing.assert_array_equal(asked.at(float(run.time[place]) + 0.049), now)
    assert asked.at(1e9) is not None
    with pytest.raises(TryoutError, match="no robot 2"):
        asked.at(0.0, 1)


def test_shares_weigh_the_rules_consequents_to_the_output(fis: Sugeno, run: Run) -> None:
    """With "wtaver" the output is the sum of share times consequent: another way to the same number."""
    asked = asked_of(run, "tracking")
    assert asked is not None
    x = asked.inputs[::20, 0].astype(float)
    found = shares(firing_strengths(fis, x))
    np.testing.assert_allclose(found.sum(axis=-1), 1.0, atol=1e-9)
    for number, output in enumerate(fis.outputs):
        values = [output.terms[dict(rule.then)[output.name]].value for rule in fis.rules]
        np.testing.assert_allclose(found @ values, infer(fis, x).output[:, number], atol=1e-9)


def test_the_strip_has_all_rules_that_fire_the_strongest_first(fis: Sugeno, run: Run) -> None:
    asked = asked_of(run, "tracking")
    assert asked is not None
    strip = rule_times(fis, asked)
    whole = shares(firing_strengths(fis, asked.inputs[:, 0]))
    rows = {row["rule"] - 1: row["shares"] for row in strip["rows"]}
    assert set(rows) == set(np.flatnonzero(np.nansum(whole, axis=0) > 0))
    means = [np.mean(row) for row in rows.values()]
    assert means == sorted(means, reverse=True)
    assert len(strip["edges"]) == len(next(iter(rows.values()))) + 1 <= 301
    np.testing.assert_allclose(np.sum(list(rows.values()), axis=0), 1.0, atol=0.01)
    assert strip["rows"][0]["text"] == str(fis.rules[strip["rows"][0]["rule"] - 1])


def test_torques_are_those_that_the_effort_was_made_of() -> None:
    """The plant sums their squares up itself; torques change little within a period, so that this is nearly that."""
    run = simulate(load_scenario("reference"), make_controller("lyapunov"), torques=True)
    assert run.torques is not None
    effort = 0.05 * np.cumsum((run.torques[1:, :, 0, 0].astype(float) ** 2).sum(axis=-1))
    assert effort[-1] == pytest.approx(run["effort"][0, 0, -1], rel=0.15)
    assert simulate(load_scenario("reference"), make_controller("lyapunov")).torques is None
    curves = motion_curves(run)
    assert len(curves["torque_left"][0]) == len(curves["time"]) == len(reference_curves(run)["v"][0])


class Bench:
    """What a panel asks of the page."""

    def __init__(self, fis: Sugeno) -> None:
        self.document = SimpleNamespace(design=SimpleNamespace(system=fis))
        self.done: list[Any] = []

    def look_at(self, point: Any) -> None:
        self.done.append(tuple(float(value) for value in point))

    def open_rule(self, key: int) -> None:
        self.done.append(key)


def test_a_time_leads_to_its_point_and_its_rule(fis: Sugeno, run: Run) -> None:
    bench, keys = Bench(fis), tuple(range(100, 100 + len(fis.rules)))
    moments = RunMoments(bench)
    assert moments.look({"time": 1.0, "count": 1}) == {"time": 1.0, "count": 1, "known": False}
    asked = asked_of(run, "tracking")
    assert asked is not None
    assert moments.take(fis, keys, {"label": "x", "asked": asked}) == {"label": "x", "number": 1}
    point = asked.at(3.0)
    assert point is not None
    best = int(np.argmax(shares(firing_strengths(fis, point))))
    assert moments.look({"time": 3.0, "count": 2, "rule": "strongest"})["rule"] == best + 1
    assert bench.done == [tuple(float(v) for v in point), 100 + best]
    for wrong in ({"time": None}, {"time": True}, {"time": float("nan")}, {"time": 1.0, "robot": "x"}):
        with pytest.raises(TryoutError):
            moments.look(wrong)


def test_a_path_has_its_places_where_it_bends() -> None:
    """A quarter of a circle between two straight ways, which is driven in a tenth of the time; then it stands."""
    angle = np.linspace(0.0, np.pi / 2, 101)[1:]
    x = np.concatenate([np.linspace(-5.0, 0.0, 500), np.sin(angle), np.full(300, 1.0), np.full(400, 1.0)])
    y = np.concatenate([np.zeros(500), 1 - np.cos(angle), np.linspace(1.0, 6.0, 301)[1:], np.full(400, 6.0)])
    kept = bends(x, y, 60)
    assert (kept[0], kept[-1], len(kept) <= 60) == (0, len(x) - 1, True)
    assert np.count_nonzero((kept >= 500) & (kept < 600)) >= 25
    assert np.count_nonzero(kept > 900) <= 3
    x[700:], y[700:] = np.nan, np.nan  # nothing is known of a robot that was stopped
    assert set(bends(x, y, 60)) <= set(range(len(x)))
    assert bends(x, y, len(x)).tolist() == list(range(len(x)))
