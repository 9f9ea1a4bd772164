"""Pruning: what a rule contributes, against refitting without each sample; the path, the choice and what is left."""

from dataclasses import replace

import numpy as np
import pytest

import anfis
import fuzzy
from anfis.accuracy import total_rmse
from anfis.pruning import leave_out_errors, schedule, without_rules

RNG = np.random.default_rng(5)
X = RNG.uniform(-1, 1, (90, 2))
Y = np.where(X[:, 0] < 0, X[:, 0] * X[:, 1], 0.5) + 0.05 * RNG.normal(size=90)
CHECK, TEST = (X[:30], Y[:30]), (X[30:45], Y[30:45])
LEARNT = X[45:], Y[45:]
OPTIONS = anfis.Options(epochs=2)
pytestmark = pytest.mark.filterwarnings("ignore:.* samples for .* parameters of the consequents")


def grid(mfs: int = 3, kind: str = "gaussmf", **choices) -> fuzzy.Sugeno:
    fis = fuzzy.identify(X, Y, "grid", mfs=mfs, kind=kind, input_names=["a", "b"], output_names=["y"])
    return replace(fis, out_of_range="ignore", **choices)


def left_out(fis: fuzzy.Sugeno, x: np.ndarray, y: np.ndarray, ridge: float) -> float:
    """The mean square error of each sample by the ridge regression on all others, one after the other."""
    weights = fuzzy.infer(fis, x).weights
    scaled = np.column_stack([2 * (x - x.min(0)) / np.ptp(x, axis=0) - 1, np.ones(len(x))])
    design = np.einsum("nr,nk->nrk", weights, scaled).reshape(len(x), -1)
    target, errors = y - y.mean(), []
    for k in range(len(x)):
        rest = np.arange(len(x)) != k
        rows = np.vstack([design[rest], np.sqrt(ridge * len(x)) * np.eye(design.shape[1])])
        theta = np.linalg.lstsq(rows, np.append(target[rest], np.zeros(design.shape[1])))[0]
        errors.append(target[k] - design[k] @ theta)
    return float(np.mean(np.square(errors)))


def test_what_a_rule_contributes_is_the_error_without_it():
    fis, ridge = grid(2), 10.0  # above the ridges that are tried: it is the one that counts
    found = leave_out_errors(fis, X, Y[:, None], ridge)
    theirs = [left_out(without_rules(fis, [k]), X, Y, ridge) for k in range(4)]
    np.testing.assert_allclose(found, theirs, rtol=1e-9)


def test_a_rule_that_says_what_another_says_contributes_nothing():
    fis = grid(2)
    double = replace(fis, rules=[*fis.rules, fis.rules[1]])
    errors = leave_out_errors(double, X, Y[:, None])
    assert set(np.argsort(errors)[:2]) == {1, 4}
    assert errors[[0, 2, 3]].min() > 1.05 * errors[[1, 4]].max()


@pytest.mark.filterwarnings("ignore:no rule fires")
def test_where_a_rule_stands_alone_the_middle_of_the_range_counts():
    """Triangles that do not overlap: without a rule its samples have the middle of the output's range."""
    terms = {"l": fuzzy.Triangle(-2, -0.5, 0), "h": fuzzy.Triangle(0, 0.5, 2)}
    y = fuzzy.Variable("y", (0, 1), {"p": 0.2, "q": 0.7})
    fis = fuzzy.Sugeno([fuzzy.Variable("a", (-1, 1), terms)], [y], ["if a is l then y is p", "if a is h then y is q"])
    x, low = X[:, :1], X[:, 0] < 0
    found = leave_out_errors(fis, x, Y[:, None])
    for rule, mine in ((0, low), (1, ~low)):
        # The other's constant is the mean of its samples, but for a ridge of 10⁻² at most.
        n, rest = (~mine).sum(), Y[~mine]
        alone = np.sum(((rest - rest.mean()) * n / (n - 1)) ** 2)
        assert found[rule] == pytest.approx((np.sum((Y[mine] - 0.5) ** 2) + alone) / len(X), rel=1e-2)
    assert anfis.prune(fis, x, Y, OPTIONS, keep=1).error.silent in (low.sum(), (~low).sum())


def test_rules_fire_at_inputs_that_are_clipped():
    terms = {"l": fuzzy.Triangle(-1.5, -0.5, 0.5), "h": fuzzy.Triangle(-0.5, 0.5, 1.5)}
    y = fuzzy.Variable("y", (0, 1), {"p": 0.2, "q": 0.7})
    fis = fuzzy.Sugeno([fuzzy.Variable("x", (-1, 1), terms)], [y], ["if x is l then y is p", "if x is h then y is q"])
    fis = replace(fis, out_of_range="clip")
    x = np.append(np.linspace(-1, 1, 20), [2.0, 3.0])[:, None]  # beyond 1.5 no rule would fire
    assert anfis.prune(fis, x, x[:, 0], OPTIONS, keep=2).error.silent == 0


def test_pruning_makes_a_grid_that_knows_its_samples_by_heart_better():
    pruned = anfis.prune(grid(5), *LEARNT, OPTIONS, check=CHECK, test=TEST, choice="least")
    assert [s.rules for s in pruned.path] == schedule(25) == [len(s.rules) for s in pruned.systems]
    assert pruned.chosen == int(np.argmin([s.check for s in pruned.path]))
    assert pruned.error.rules == len(pruned.system.rules) < 15
    assert pruned.error.check <= pruned.path[pruned.chosen].check < pruned.path[0].check
    assert pruned.error.test < pruned.path[0].test
    for data, value in ((LEARNT, pruned.error.train), (CHECK, pruned.error.check), (TEST, pruned.error.test)):
        assert value == pytest.approx(total_rmse(pruned.system, data[0], data[1][:, None]))
    used = {(c.variable, c.term) for r in pruned.system.rules for c in r.when}
    assert used == {(v.name, t) for v in pruned.system.inputs for t in v.terms}
    again = anfis.prune(grid(5), *LEARNT, OPTIONS, check=CHECK, choice="least")
    assert again.system == pruned.system  # the test data change nothing


def test_one_standard_error_keeps_no_more_rules():
    least = anfis.prune(grid(4), *LEARNT, OPTIONS, check=CHECK, retrain=0, choice="least")
    fewest = anfis.prune(grid(4), *LEARNT, OPTIONS, check=CHECK, retrain=0)
    assert fewest.systems == least.systems
    assert fewest.chosen >= least.chosen
    squares = [
        (s(CHECK[0])[:, 0] - CHECK[1]) ** 2 for s in (fewest.systems[fewest.chosen], least.systems[least.chosen])
    ]
    assert np.mean(squares[0] - squares[1]) <= np.std(squares[0] - squares[1], ddof=1) / 30**0.5


def test_without_checking_data_a_quarter_is_held_back_and_learnt_from_in_the_end():
    pruned = anfis.prune(grid(3), *LEARNT, OPTIONS, seed=4)
    assert len(pruned.held) == round(45 / 4)
    assert pruned.error.train == pytest.approx(total_rmse(pruned.system, LEARNT[0], LEARNT[1][:, None]))
    assert np.isnan(pruned.error.check)
    assert (anfis.prune(grid(3), *LEARNT, OPTIONS, seed=5).held != pruned.held).any()


@pytest.mark.parametrize("method", ["hybrid", "backprop", "second-order", "least-squares"])
def test_a_number_of_rules_is_kept_with_every_method(method):
    pruned = anfis.prune(grid(3), *LEARNT, replace(OPTIONS, method=method), keep=5)
    assert len(pruned.system.rules) == 5
    assert len(pruned.held) == 0
    assert pruned.error.train < np.std(LEARNT[1])


def test_several_outputs_and_shared_consequents(tmp_path):
    fis = grid(2)
    both = replace(
        fis,
        outputs=[fis.outputs[0], replace(fis.outputs[0], name="z", terms={"c": 0.0, "d": 1.0})],
        rules=[replace(r, then=(*r.then, ("z", "cdcd"[k]))) for k, r in enumerate(fis.rules)],
    )
    pruned = anfis.prune(both, X, np.column_stack([Y, 2 * Y]), OPTIONS, keep=1)
    assert len(pruned.system.rules) == 1
    assert [len(v.terms) for v in pruned.system.inputs] == [1, 1]
    fuzzy.write_fis(pruned.system, tmp_path / "one.fis")
    assert fuzzy.read_fis(tmp_path / "one.fis").rules == pruned.system.rules


def test_an_interrupt_keeps_the_best_so_far():
    def stop(stage, rules, row):
        if stage == "pruning" and rules == 19:
            raise KeyboardInterrupt

    pruned = anfis.prune(grid(5), *LEARNT, OPTIONS, check=CHECK, callback=stop)
    assert pruned.stopped == "interrupted"
    assert min(s.rules for s in pruned.path) == 19
    assert pruned.system is pruned.systems[pruned.chosen]


@pytest.mark.parametrize(
    ("settings", "message"),
    [
        ({"keep": 0}, r"keep must be a whole number from 1 to the number of rules \(4\), got 0"),
        ({"keep": 5}, "from 1 to"),
        ({"choice": "leats"}, "did you mean 'least'"),
        ({"retrain": -1}, "retrain must be"),
    ],
)
def test_settings_that_make_no_pruning(settings, message):
    with pytest.raises(anfis.TrainingError, match=message):
        anfis.prune(grid(2), X, Y, **settings)


def test_too_few_samples_to_hold_some_back():
    with pytest.raises(anfis.DataError, match="7 samples are too few to hold some back"):
        anfis.prune(grid(2), X[:7], Y[:7])


def test_the_picture_has_the_errors_and_the_choice():
    pruned = anfis.prune(grid(2), *LEARNT, OPTIONS, check=CHECK, retrain=0)
    ax = anfis.plot_pruning(pruned, "m").axes[0]
    assert ax.get_ylabel() == "RMSE [m]"
    np.testing.assert_allclose(np.asarray(ax.lines[1].get_ydata()), np.array([s.check for s in pruned.path]))
    assert ax.lines[-1].get_xdata() == [pruned.path[pruned.chosen].rules]
