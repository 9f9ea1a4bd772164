"""Rules from nothing beside other packages: error on folds that nobody has seen, and the size of what is said.

    pip install pymoo pyfume ex-fuzzy anfis-toolbox scikit-learn
    python -m benchmarks.rulefronts -o rulefronts.json

Three tables that come with scikit-learn: what diabetes becomes in a year, the alcohol of wines, the width of petals.
Each of five folds is held back once, from everything: choice of rules, their number and their terms. The error is the
RMSE over the spread of the whole table's output; 1 is what the mean knows. Of the other packages each setting is shown,
so theirs may be chosen by what is measured here; ours are the one that the search marks itself, and the largest, whose
error was least where it searched. All evolve 6,000 candidates where they evolve.
"""

import argparse
import contextlib
import io
import tempfile
import time
import warnings
from collections.abc import Callable, Iterator
from functools import partial
from importlib.metadata import version
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

import fuzzy
from fuzzy.files.atomic import write_json
from fuzzy.fitting.folds import fold_rows
from fuzzy.inference import infer_quietly
from fuzzy.system import Sugeno

FOLDS, GENERATIONS, POPULATION = 5, 100, 60


class Found(NamedTuple):
    """What a package made of samples."""

    predict: Callable[[np.ndarray], np.ndarray]  # (samples, inputs) -> (samples,)
    rules: int
    conditions: int


Learn = Callable[[np.ndarray, np.ndarray], dict[str, Found]]  # by the name of the setting


def tables() -> Iterator[tuple[str, np.ndarray, np.ndarray]]:
    """The name, the inputs (samples, inputs) and the output (samples,) of each table."""
    from sklearn import datasets

    x, y = datasets.load_diabetes(return_X_y=True)
    yield "diabetes", x, y
    wine = datasets.load_wine().data
    yield "wine", wine[:, 1:], wine[:, 0]
    iris = datasets.load_iris().data
    yield "iris", iris[:, :3], iris[:, 3]


def ours(x: np.ndarray, y: np.ndarray) -> dict[str, Found]:
    """What the search marks, and the system of least cross-validated error."""
    front = fuzzy.search_rules(x, y, rules=8, generations=GENERATIONS)
    taken = (("marked", front.points[front.chosen]), ("least error", front.points[-1]))
    return {name: _of_system(point.system, point) for name, point in taken}


def _of_system(system: Sugeno, point: fuzzy.RuleFrontPoint) -> Found:
    places = [int(v.name.removeprefix("input")) - 1 for v in system.inputs]
    return Found(lambda x: infer_quietly(system, x[:, places]).output[:, 0], point.rules, point.conditions)


def linear(x: np.ndarray, y: np.ndarray) -> dict[str, Found]:
    """No rules: the plane of least squares."""
    theta = np.linalg.lstsq(np.column_stack([x, np.ones(len(x))]), y, rcond=None)[0]
    return {"least squares": Found(lambda x: np.column_stack([x, np.ones(len(x))]) @ theta, 1, 0)}


def pyfume(clusters: int, x: np.ndarray, y: np.ndarray) -> dict[str, Found]:
    """Clusters of fuzzy c-means, first-order consequents; all samples teach."""
    import pandas as pd
    from pyfume import pyFUME

    names = [f"x{i}" for i in range(x.shape[1])]
    made = pyFUME(
        dataframe=pd.DataFrame(np.column_stack([x, y]), columns=[*names, "y"]),
        nr_clus=clusters,
        percentage_training=1.0,
        variable_names=names,
    )
    model = made.get_model()

    def predict(x: np.ndarray) -> np.ndarray:
        result = np.empty(len(x))
        for k, row in enumerate(x):
            for name, value in zip(names, row, strict=True):
                model.set_variable(name, value)
            result[k] = model.Sugeno_inference(["OUTPUT"])["OUTPUT"]
        return result

    rules = set(model.get_rules())  # it lists each twice
    return {f"{clusters} clusters": Found(predict, len(rules), sum(rule.count(" IS ") - 1 for rule in rules))}


def ex_fuzzy(rules: int, x: np.ndarray, y: np.ndarray) -> dict[str, Found]:
    """Evolved rules of at most four conditions, constant consequents."""
    from ex_fuzzy import BaseFuzzyRulesRegressor

    model = BaseFuzzyRulesRegressor(nRules=rules, nAnts=4, n_linguistic_variables=3)
    model.fit(x, y, n_gen=GENERATIONS, pop_size=POPULATION, random_state=0)
    base = model.get_rulebase().get_rules()
    conditions = sum(int(np.sum(np.asarray(rule.antecedents) >= 0)) for rule in base)
    return {f"at most {rules} rules": Found(lambda x: np.ravel(model.predict(x)), len(base), conditions)}


def anfis_toolbox(clusters: int, x: np.ndarray, y: np.ndarray) -> dict[str, Found]:
    """Clusters of fuzzy c-means, a rule each, and 50 epochs of hybrid learning."""
    from anfis_toolbox import ANFISRegressor

    rules = [[k] * x.shape[1] for k in range(clusters)]
    model = ANFISRegressor(n_mfs=clusters, init="fcm", rules=rules, epochs=50, random_state=0)
    model.fit(x, y)
    return {
        f"{clusters} clusters": Found(lambda x: np.ravel(model.predict(x)), clusters, clusters * x.shape[1]),
    }


PACKAGES: dict[str, list[Learn]] = {
    "fuzzyfleet": [ours],
    "a plane": [linear],
    "pyFUME": [partial(pyfume, k) for k in (2, 3, 5)],
    "ex-fuzzy": [partial(ex_fuzzy, k) for k in (5, 10, 30)],
    "anfis-toolbox": [partial(anfis_toolbox, k) for k in (2, 3, 5)],
}


def measured(learn: Learn, x: np.ndarray, y: np.ndarray) -> dict[str, dict[str, float]]:
    """By the name of the setting: the error, its standard error over the folds, mean sizes and seconds a fold."""
    rows: dict[str, list[tuple[float, int, int]]] = {}
    begun = time.perf_counter()
    for held in fold_rows(len(x), FOLDS):
        rest = np.setdiff1d(np.arange(len(x)), held)
        # pyFUME writes files where it runs.
        with (
            warnings.catch_warnings(),
            contextlib.redirect_stdout(io.StringIO()),
            tempfile.TemporaryDirectory() as folder,
            contextlib.chdir(folder),
        ):
            warnings.simplefilter("ignore")
            # Not all scale what they are given; and some read the texts of numbers as NumPy 1 wrote them.
            low, high, middle, spread = x[rest].min(axis=0), x[rest].max(axis=0), y[rest].mean(), y[rest].std()
            with np.printoptions(legacy="1.25"):
                found = learn((x[rest] - low) / (high - low), (y[rest] - middle) / spread)
                told = {name: made.predict((x[held] - low) / (high - low)) for name, made in found.items()}
            for name, made in found.items():
                square = float(np.mean((told[name] * spread + middle - y[held]) ** 2) / y.var())
                rows.setdefault(name, []).append((square, made.rules, made.conditions))
    seconds = (time.perf_counter() - begun) / FOLDS
    result = {}
    for name, values in rows.items():
        squares, rules, conditions = np.array(values).T
        error = float(np.sqrt(squares.mean()))
        deviation = float(squares.std(ddof=1) / np.sqrt(FOLDS) / (2 * error))
        result[name] = {
            "error": error,
            "deviation": deviation,
            "rules": float(rules.mean()),
            "conditions": float(conditions.mean()),
            "seconds": seconds,
        }
    return result


def main() -> None:
    """Measure, print a table, and write it with -o."""
    parser = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    parser.add_argument("-o", "--output", type=Path, help="the .json file to write")
    parser.add_argument("--packages", default=",".join(PACKAGES), help="which, with commas between them")
    options = parser.parse_args()
    chosen = options.packages.split(",")
    rows: list[dict[str, Any]] = []
    for table, x, y in tables():
        for package in chosen:
            for learn in PACKAGES[package]:
                try:
                    found = measured(learn, x, y)
                except Exception as error:  # another package's failure is a row, too
                    print(f"{table:9} {package:14} failed: {type(error).__name__}: {error}")
                    rows.append({"table": table, "package": package, "failed": f"{type(error).__name__}: {error}"})
                    continue
                for setting, values in found.items():
                    print(
                        f"{table:9} {package:14} {setting:17} {values['error']:.3f} ± {values['deviation']:.3f}"
                        f"{values['rules']:7.1f} rules{values['conditions']:7.1f} conditions{values['seconds']:8.1f} s",
                        flush=True,
                    )
                    rows.append({"table": table, "package": package, "setting": setting, **values})
    if options.output is not None:
        versions = {name: version(name) for name in ("pymoo", *chosen) if " " not in name}
        write_json(options.output, {"folds": FOLDS, "versions": versions, "rows": rows})


if __name__ == "__main__":
    main()
