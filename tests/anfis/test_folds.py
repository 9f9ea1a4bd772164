"""k-fold cross-validation: scikit-learn's numbers, and that what is held back is not learnt from."""

import numpy as np
import pytest

import anfis
import fuzzy
from fuzzy.fitting.folds import FoldError, fold_rows
from tests.anfis.training_problem import FIS, X, Y, rmse

OPTIONS = anfis.Options(epochs=2)


@pytest.mark.parametrize(("order", "seed"), [("blocks", 0), ("shuffled", 3)])
def test_the_errors_are_those_of_scikit_learn(order, seed):
    pytest.importorskip("sklearn")
    from sklearn.model_selection import KFold, cross_val_score

    from anfis.plugins.regressor.estimator import ANFISRegressor

    rows = fold_rows(len(X), 3, order, seed)
    if order == "blocks":
        for held, (_, theirs) in zip(rows, KFold(3).split(X), strict=True):
            np.testing.assert_array_equal(held, theirs)
    found = anfis.cross_validate(
        lambda x, y: fuzzy.identify(x, y, "grid", kind="gaussmf", fit=False),
        X, Y, OPTIONS, folds=3, order=order, seed=seed,
    )  # fmt: skip
    pairs = [(np.setdiff1d(np.arange(len(X)), held), held) for held in rows]
    theirs = -cross_val_score(ANFISRegressor("grid", epochs=2), X, Y, cv=pairs, scoring="neg_root_mean_squared_error")
    np.testing.assert_allclose(found.rmse, theirs, rtol=1e-12)
    assert found.mean == pytest.approx(np.mean(theirs))
    assert found.std == pytest.approx(np.std(theirs, ddof=1))
    assert list(found.table()["held"]) == [27, 27, 26]


def test_what_is_held_back_does_not_count():
    clean = anfis.cross_validate(FIS, X, Y, OPTIONS, folds=4, order="blocks")
    bent = Y.copy()
    bent[:20] += 100.0
    found = anfis.cross_validate(FIS, X, bent, OPTIONS, folds=4, order="blocks")
    assert found.folds[0].training.system == clean.folds[0].training.system
    assert found.folds[0].rmse > 90
    assert found.folds[1].training.system != clean.folds[1].training.system
    for fold in clean.folds:
        assert fold.rmse == pytest.approx(rmse(fold.training.system, X[fold.held], Y[fold.held]))


def test_the_folds_part_the_samples_and_follow_the_seed():
    for order in ("blocks", "shuffled"):
        rows = fold_rows(23, 5, order, 1)
        np.testing.assert_array_equal(np.sort(np.concatenate(rows)), np.arange(23))
        assert {len(r) for r in rows} == {4, 5}
    assert any((a != b).any() for a, b in zip(fold_rows(20, 4, seed=1), fold_rows(20, 4, seed=2), strict=True))


def test_a_callback_sees_the_folds_and_an_interrupt_ends_them():
    seen = []

    def look(fold, row):
        seen.append((fold, row.epoch))
        if fold == 1 and row.epoch == 1:
            raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        anfis.cross_validate(FIS, X, Y, OPTIONS, folds=3, callback=look)
    assert seen == [(0, 0), (0, 1), (0, 2), (1, 0), (1, 1)]


@pytest.mark.parametrize(
    ("settings", "message"),
    [
        ({"folds": 1}, r"folds must be a whole number from 2 to the number of samples \(80\), got 1"),
        ({"folds": 81}, "from 2 to"),
        ({"order": "block"}, "did you mean 'blocks'"),
    ],
)
def test_settings_that_make_no_folds(settings, message):
    with pytest.raises(FoldError, match=message):
        anfis.cross_validate(FIS, X, Y, **settings)


def test_data_that_make_no_folds():
    with pytest.raises(fuzzy.InputError, match="row 4"):
        anfis.cross_validate(FIS, np.where(np.arange(80)[:, None] == 3, np.nan, X), Y)
    with pytest.raises(anfis.DataError, match="80 rows of inputs but 79"):
        anfis.cross_validate(FIS, X, Y[1:])
