"""Tuning through the closed loop: spaces of laws, costs and files."""

import math
from dataclasses import replace

import numpy as np
import pytest

import robotics
from fuzzy.tuning.parameter import TuningError
from robotics.laws.catalogue import CATALOGUE, gains_of, make_controller
from robotics.laws.tracking.fuzzy_tracking import FuzzyTracking
from robotics.studies.tuning.cost import Cost, Term, costs_of
from robotics.studies.tuning.file import TuningFile, load_tuning, parse_tuning
from robotics.studies.tuning.space import Bound, LawSpace
from robotics.studies.tuning.tune import CHOOSING, TESTING, TUNING, TuningInterrupt, tune
from robotics.world.sensing.posture import LABORATORY

SINE = replace(robotics.load_scenario("lyapunov-sine"), duration=4.0, sensing=LABORATORY)
QUICK = Cost(terms=(Term(metric="rms_cross_track_m", scale=0.01), Term(metric="w_variation_radps2")))


@pytest.mark.parametrize("name", CATALOGUE)
def test_every_law_has_something_to_tune_and_starts_as_it_is(name):
    law = make_controller(name)
    space = LawSpace(law)
    assert space.made([p.start for p in space.parameters]).fuzzy_systems == law.fuzzy_systems
    gains = space.gains_at([p.start for p in space.parameters])
    made = space.made([p.start for p in space.parameters])
    assert {n: gains_of(made)[n] for n in gains} == gains
    for parameter in space.parameters:
        assert parameter.name in gains or "." in parameter.name or "gap" in parameter.name


def test_gains_move_tenfold_by_their_logarithm_within_what_the_law_accepts():
    parameters = {p.name: p for p in LawSpace(make_controller("esm")).parameters}
    k, mu0 = parameters["k"], parameters["mu0"]
    assert (k.lower, k.upper) == pytest.approx((0.02, 2.0))
    assert k.scale == "log"
    assert mu0.upper == 1.0  # most = 1 of the law, not ten times 0.1 by chance only
    assert parameters["outer.ky"].upper == pytest.approx(100)
    values = [p.start for p in parameters.values()]
    values[[*parameters].index("outer.ky")] = 20.0
    assert gains_of(LawSpace(make_controller("esm")).made(values))["outer.ky"] == 20.0


def test_what_moves_can_be_narrowed():
    law = make_controller("fuzzy")
    space = LawSpace(law, ("gains",), gains=("look_ahead",), bounds={"look_ahead": Bound(low=0.3, high=0.5)})
    assert [(p.name, p.lower, p.upper) for p in space.parameters] == [("look_ahead", 0.3, 0.5)]
    assert "v.Zero" not in {p.name for p in LawSpace(law, fixed=("v.Zero",)).parameters}
    # A gain that is 0 moves only between bounds that the user says
    still = make_controller("lyapunov:catch_up=0")
    assert "catch_up" not in {p.name for p in LawSpace(still).parameters}
    assert "catch_up" in {p.name for p in LawSpace(still, bounds={"catch_up": Bound(low=0.0, high=1.0)}).parameters}


@pytest.mark.parametrize(
    ("fields", "message"),
    [
        ({"move": ("gain",)}, "did you mean 'gains'"),
        ({"gains": ("lookahead",)}, "did you mean 'look_ahead'"),
        ({"tasks": ("track",)}, "did you mean 'tracking'"),
        ({"bounds": {"look": Bound(low=0, high=1)}}, "look"),
        ({"fixed": ("v.Zer",)}, "did you mean 'v.Zero'"),
        ({"move": ()}, "nothing that moves"),
    ],
)
def test_what_a_law_does_not_have_is_refused(fields, message):
    with pytest.raises(TuningError, match=message):
        LawSpace(make_controller("fuzzy"), **fields)


def test_a_cost_is_the_sum_of_its_terms_and_a_failed_run_costs_the_same_whatever_it_measures():
    cost = Cost(
        terms=(Term(metric="a", scale=0.1, objective="one"), Term(metric="b", weight=3.0, objective="other")), failed=50
    )
    metrics = {"a": np.array([[0.2, 0.4], [0.2, 0.2], [np.nan, 1.0], [9.0, 9.0]]), "b": np.full((4, 2), 2.0)}
    stopped = np.array([[False, False], [False, True], [False, False], [False, False]])
    found = cost.objectives_of(metrics, stopped)
    assert found[0] == pytest.approx([3.0, 6.0])
    assert found[1:].tolist() == [[25.0, 25.0]] * 3  # stopped, not a number, more than a failed run
    assert cost.of(metrics, stopped).tolist() == pytest.approx([9.0, 50.0, 50.0, 50.0])
    assert cost.weighted({"b": 0.5}).of(metrics, stopped)[0] == pytest.approx(6.0)


def test_a_touch_is_a_failure():
    cost = Cost(terms=(Term(metric="a"),), failed=7)
    found = cost.of({"a": np.ones((2, 2)), "contacts": np.array([[0, 0], [0, 1]])}, np.zeros((2, 2), bool))
    assert found.tolist() == [1.0, 7.0]


def test_costs_are_those_of_runs_made_alone():
    laws = ["lyapunov", "fuzzy", "esm"]
    costs = costs_of(QUICK, [SINE], laws, [3, 4])
    assert costs.shape == (3, 1, 2, 1)
    for law, row in zip(laws, costs, strict=True):
        run = robotics.simulate(SINE, make_controller(law), seeds=[3, 4])
        measured = robotics.measure_all(run)
        expected = measured["rms_cross_track_m"] / 0.01 + measured["w_variation_radps2"]
        assert row[0, :, 0] == pytest.approx(expected[:, 0], rel=1e-12)


def test_a_function_of_ones_own_is_a_cost():
    def late(run):
        return np.nanmean(np.abs(run["v_demand"] - run["v"]), axis=-1)

    cost = Cost(terms=(Term(metric="late", scale=0.1, measure=late),))
    found = tune("lyapunov", [SINE], runs=2, evaluations=20, cost=cost)
    run = robotics.simulate(SINE, found.law, seeds=range(TUNING, TUNING + 2))
    assert found.after == pytest.approx(float(late(run).mean() / 0.1), rel=1e-12)
    assert found.after < found.before


def test_tuning_does_not_depend_on_threads_and_its_result_costs_what_it_says():
    one = tune("fuzzy", [SINE], runs=3, evaluations=40, threads=1, cost=QUICK)
    two = tune("fuzzy", [SINE], runs=3, evaluations=40, threads=2, cost=QUICK)
    assert one.evaluated.values.tobytes() == two.evaluated.values.tobytes()
    assert one.evaluated.costs.tobytes() == two.evaluated.costs.tobytes()
    assert one.after < one.before
    again = costs_of(QUICK, [SINE], [one.law], range(TUNING, TUNING + 3))
    assert again.mean() == one.after
    assert one.history["best"].iloc[-1] == one.after
    assert len(one.history) == one.evaluations == 40


def test_blocks_of_seeds_are_apart():
    assert 0 < TUNING < CHOOSING < TESTING
    assert min(CHOOSING - TUNING, TESTING - CHOOSING) >= 1_000_000


def test_a_candidate_that_cannot_drive_is_a_failure_and_not_the_end():
    team = replace(robotics.load_scenario("concentric-circles"), duration=1.0)
    bounds = {"kappa": Bound(low=0.01, high=4.0, scale="log")}  # theorem 4.1 forbids the lower ones
    space = LawSpace(make_controller("virtual-structure-virtual"), ("gains",), gains=("kappa",), bounds=bounds)
    cost = Cost(terms=(Term(metric="rms_cross_track_m"),))
    found = tune(space, [team], runs=1, evaluations=30, cost=cost, engine="random", seed=3)
    refused = found.evaluated.costs == cost.failed
    assert refused.any()
    assert not refused.all()
    worst = found.evaluated.values[refused].max()
    assert worst < found.evaluated.values[~refused].min()


def test_ctrl_c_hands_over_what_was_found():
    def stop(found):
        if len(found) > 20:
            raise KeyboardInterrupt

    with pytest.raises(TuningInterrupt) as caught:
        tune("lyapunov", [SINE], runs=2, evaluations=100, cost=QUICK, progress=stop)
    assert 20 < caught.value.tuned.evaluations < 40
    assert caught.value.tuned.after <= caught.value.tuned.before


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"scenarios": []}, "at least one scenario"),
        ({"runs": 0}, "runs must be"),
        ({"engine": "cmas"}, "did you mean 'cmaes'"),
        ({"pareto": True}, "two objectives; the cost has cost"),
    ],
)
def test_a_tuning_that_cannot_be_is_refused(change, message):
    told = {"scenarios": [SINE], "cost": QUICK, "runs": 1, "evaluations": 4} | change
    with pytest.raises(TuningError, match=message):
        tune("lyapunov", **told)


# Files -----------------------------------------------------------------------------------------------------------


def test_the_packaged_tuning_is_the_default_one():
    assert load_tuning("tracking").made_cost() == TuningFile().made_cost() == Cost()


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ('move = ["gains", "weight"]', r"mine.toml:1: .*did you mean 'weights'"),
        ("failed = -1", "mine.toml:1: failed must be a finite number, > 0"),
        ('title = "x"\n[bounds]\nlook_ahead = { low = 2.0, high = 1.0 }', "mine.toml:3: low must be less than high"),
        ('[[cost]]\nmetric = "rms_cross_trak_m"', "mine.toml:2: .*did you mean 'rms_cross_track_m'"),
        ('[[cost]]\nmetric = "gone.py:f"', "mine.toml:2: there is no file 'gone.py'"),
        ('[[cost]]\nmetric = "rms_cross_track_m"\nscale = 0', "mine.toml:3: scale must be"),
        ("moves = []", "mine.toml:1: .*did you mean 'move'"),
        ("failed = ", "mine.toml:1: this is not TOML"),
    ],
)
def test_what_is_wrong_in_a_file_is_said_with_its_line(text, message):
    with pytest.raises(TuningError, match=message):
        parse_tuning(text, "mine.toml")


def test_a_function_of_a_file_beside_the_tuning_is_found(tmp_path):
    (tmp_path / "mycost.py").write_text(
        "import numpy as np\n\n\ndef far(run):\n    return np.nanmax(run['x'], axis=-1)\n"
    )
    (tmp_path / "mine.toml").write_text('[[cost]]\nmetric = "mycost.py:far"\n')
    cost = load_tuning(tmp_path / "mine.toml").made_cost()
    found = tune("lyapunov", [SINE], runs=1, evaluations=5, cost=cost)
    assert math.isfinite(found.after)


class Silent(FuzzyTracking):
    """A law that does not tell what it asks its rule base."""

    def control(self, seen, memory, dt):
        command, memory = super().control(seen, memory, dt)
        return command._replace(inputs=None), memory

    has_equation = False


def test_of_a_law_that_does_not_tell_its_inputs_nothing_is_held():
    law = make_controller("fuzzy")
    assert tune(law, [SINE], runs=1, evaluations=2).space.held
    silent = Silent()
    assert not tune(silent, [SINE], runs=1, evaluations=2).space.held
