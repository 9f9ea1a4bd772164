"""ANFISRegressor: scikit-learn's own checks, and that it is :func:`anfis.train` underneath."""

import pickle
import subprocess
import sys
from typing import Any

import numpy as np
import pandas as pd
import pytest
import torch

import anfis
import fuzzy

pytest.importorskip("sklearn")
from sklearn.model_selection import GridSearchCV, cross_val_score
from sklearn.pipeline import make_pipeline
from sklearn.preprocessing import StandardScaler
from sklearn.utils.estimator_checks import parametrize_with_checks

from anfis.plugins.regressor.estimator import ANFISRegressor, EstimatorError

torch.set_num_threads(1)
X = np.random.default_rng(2).uniform([-1, 0, 10], [1, 4, 20], (150, 3))
Y = np.sin(2 * X[:, 0]) + 0.1 * X[:, 1] * X[:, 2]


@pytest.mark.filterwarnings("ignore::fuzzy.fitting.clustering.DataWarning")
@parametrize_with_checks([ANFISRegressor(epochs=2)])
def test_scikit_learns_checks(estimator, check):
    check(estimator)


def test_it_is_training():
    fitted = ANFISRegressor("grid", epochs=4).fit(X, Y)
    start = fuzzy.identify(X, Y, "grid", kind="gaussmf", input_names=["x1", "x2", "x3"], output_names=["y"], fit=False)
    trained = anfis.train(start, X, Y, anfis.Options(epochs=4))
    assert fitted.system_.inputs == trained.system.inputs
    assert fitted.system_.outputs == trained.system.outputs
    assert fitted.n_iter_ == len(trained.history) == 5
    np.testing.assert_array_equal(fitted.predict(X), trained.system(X)[:, 0])
    assert fitted.score(X, Y) > 0.99


def test_several_outputs_and_names():
    x = pd.DataFrame(X, columns=["heading", "distance", "speed"])
    y = pd.DataFrame({"v": Y, "w": -2 * Y + X[:, 1]})
    fitted = ANFISRegressor(epochs=2).fit(x, y)
    assert [v.name for v in fitted.system_.inputs] == list(fitted.feature_names_in_) == list(x)
    assert [v.name for v in fitted.system_.outputs] == ["v", "w"]
    assert fitted.predict(x).shape == (150, 2)
    assert fitted.score(x, y) > 0.9
    assert ANFISRegressor(epochs=0).fit(x, y["v"]).system_.outputs[0].name == "v"
    one = ANFISRegressor(epochs=0).fit(x, y[["v"]])
    assert one.predict(x).shape == (150, 1)
    with pytest.raises(ValueError, match="feature names"):
        fitted.predict(x[["speed", "heading", "distance"]])


def test_a_system_to_start_from():
    start = fuzzy.identify(X, Y, "subtractive", radius=0.9)
    fitted = ANFISRegressor(start, epochs=3).fit(X, Y)
    assert fitted.system_.rules == start.rules
    with pytest.raises(ValueError, match=r"training inputs must be \(samples, 3\)"):
        ANFISRegressor(start).fit(X[:, :2], Y)


def test_samples_held_back_choose_the_system():
    noisy = Y + np.random.default_rng(0).normal(size=150)
    settings: dict[str, Any] = {"method": "second-order", "epochs": 15, "validation_fraction": 0.3, "radius": 0.9}
    fitted = ANFISRegressor(**settings, random_state=1).fit(X, noisy)
    history = fitted.training_.history
    assert fitted.training_.best == min(history, key=lambda row: row.check).epoch
    np.testing.assert_array_equal(
        fitted.predict(X), ANFISRegressor(**settings, random_state=1).fit(X, noisy).predict(X)
    )
    assert (fitted.predict(X) != ANFISRegressor(**settings, random_state=2).fit(X, noisy).predict(X)).any()


def test_in_a_pipeline_a_search_and_a_pickle():
    pipeline = make_pipeline(StandardScaler(), ANFISRegressor(epochs=2))
    assert cross_val_score(pipeline, X, Y, cv=3).min() > 0.9
    search = GridSearchCV(ANFISRegressor(epochs=1), {"radius": [0.5, 0.9]}, cv=2).fit(X, Y)
    copy = pickle.loads(pickle.dumps(search.best_estimator_))
    np.testing.assert_array_equal(copy.predict(X), search.predict(X))


@pytest.mark.parametrize(
    ("settings", "message"),
    [
        ({"start": "gird"}, "did you mean 'grid'"),
        ({"start": 3}, "unknown start '3'"),
        ({"method": "hybird"}, "did you mean 'hybrid'"),
        ({"validation_fraction": 1.0}, r"validation_fraction must be in \[0, 1\)"),
        ({"validation_fraction": 0.999}, "leaves less than 2"),
        ({"radius": -1}, "radius"),
    ],
)
def test_settings_that_make_no_sense(settings, message):
    with pytest.raises(fuzzy.InputError, match=message):
        ANFISRegressor(**settings).fit(X, Y)


def test_it_is_exported_but_imported_only_when_asked_for():
    assert anfis.ANFISRegressor is ANFISRegressor
    assert issubclass(EstimatorError, fuzzy.InputError)
    code = "import anfis, sys; anfis.train; print('sklearn' in sys.modules)"
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True, timeout=60)
    assert done.stdout.strip() == "False"


def test_without_scikit_learn():
    code = (
        "import sys; sys.modules['sklearn'] = sys.modules['sklearn.base'] = None\n"
        "import anfis, fuzzy\n"
        "try:\n    anfis.ANFISRegressor\n"
        "except fuzzy.InputError as error:\n    print(error)\n"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True, timeout=60)
    assert "needs scikit-learn" in done.stdout
    assert "pip install 'scikit-learn>=" in done.stdout
