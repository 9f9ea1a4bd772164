"""Other Python ANFIS packages, each behind one function: problem and epochs in, a predictor out.

Every one starts from the problem's grid of bells as far as it lets us (xanfis and torchanfis choose Gaussians and rules
of their own), with its own batches where it learns by gradient alone. Not here: scikit-anfis, pytsk and anfis-pytorch
(jfpower), which the package index does not have under these names, and pyanfis, which does not learn premises.
"""

import contextlib
import importlib.metadata
import io
from collections.abc import Callable
from typing import Any, NamedTuple

import numpy as np

from benchmarks.problems import Problem

Predict = Callable[[np.ndarray], np.ndarray]  # (samples, inputs) -> (samples,)


class Rival(NamedTuple):
    """A package and how it learns."""

    name: str
    package: str
    hybrid: bool  # does it solve for the consequents by least squares in every epoch?
    learn: Callable[[Problem, int], Predict]


def _toolbox(trainer: str, rate: float) -> Callable[[Problem, int], Predict]:
    def learn(problem: Problem, epochs: int) -> Predict:
        from anfis_toolbox import optim
        from anfis_toolbox.membership import BellMF
        from anfis_toolbox.model import TSKANFIS

        model = TSKANFIS({f"x{i}": [BellMF(*bell) for bell in bells] for i, bells in enumerate(problem.terms())})
        model.fit(problem.x, problem.y[:, None], trainer=getattr(optim, trainer)(learning_rate=rate, epochs=epochs))
        return lambda x: model.predict(x).ravel()

    return learn


def _sanfis(problem: Problem, epochs: int) -> Predict:
    import torch
    from sanfis import SANFIS

    torch.manual_seed(0)
    bells = [
        {
            "function": "bell",
            "n_memb": problem.bells,
            "params": {
                k: {"value": list(v), "trainable": True} for k, v in zip("abc", zip(*own, strict=True), strict=True)
            },
        }
        for own in problem.terms()
    ]
    model = SANFIS(membfuncs=bells, n_input=len(bells))
    data = [_tensor(problem.x), _tensor(problem.y[:, None])]
    check = [_tensor(problem.check_x), _tensor(problem.check_y[:, None])]
    optimiser = torch.optim.Adam(model.parameters(), lr=0.01)
    model.fit(
        data,
        check,
        optimiser,
        torch.nn.MSELoss(),
        epochs=epochs,
        patience=epochs + 1,
        disable_output=True,
    )
    return lambda x: _numbers(model.predict([_tensor(x), _tensor(x)]))


def _anfispy(problem: Problem, epochs: int) -> Predict:
    import torch
    from ANFISpy import ANFIS

    torch.manual_seed(0)
    count, names = problem.x.shape[1], [f"mf{k}" for k in range(problem.bells)]
    variables = {
        "inputs": {
            "n_sets": [problem.bells] * count,
            "uod": problem.bounds,
            "var_names": [f"x{i}" for i in range(count)],
            "mf_names": [names] * count,
        },
        "output": {"var_names": "y", "n_classes": 1},
    }
    model = ANFIS(variables, "bell")
    optimiser = torch.optim.Adam(model.parameters(), lr=0.05)
    x, y = _tensor(problem.x), _tensor(problem.y[:, None])
    for _ in range(epochs):
        optimiser.zero_grad()
        torch.nn.functional.mse_loss(model(x).reshape(y.shape), y).backward()
        optimiser.step()

    def predict(x: np.ndarray) -> np.ndarray:
        with torch.no_grad():
            return _numbers(model(_tensor(x)))

    return predict


def _highfis(problem: Problem, epochs: int) -> Predict:
    from highfis import TSKRegressor

    model = TSKRegressor(
        n_mfs=problem.bells,
        mf_init="grid",
        rule_base="cartesian",
        mf="bell",
        random_state=0,
        epochs=epochs,
        learning_rate=0.05,
        patience=None,
        eval_metrics_every=0,
    )
    model.fit(problem.x, problem.y)
    return lambda x: np.ravel(model.predict(x))


def _xanfis(problem: Problem, epochs: int) -> Predict:
    from xanfis import AnfisRegressor

    model = AnfisRegressor(
        num_rules=problem.rules,
        mf_class="Gaussian",
        epochs=epochs,
        batch_size=len(problem.x),
        optim="Adam",
        optim_params={"lr": 0.01},
        early_stopping=False,
        valid_rate=None,
        seed=0,
        verbose=False,
    )
    model.fit(problem.x, problem.y)
    return lambda x: np.ravel(model.predict(x))


def _torchanfis(problem: Problem, epochs: int) -> Predict:
    import torch
    from torchanfis import ANFISRegressor

    torch.manual_seed(0)
    model = ANFISRegressor(n_mfs=problem.bells, n_rules=problem.rules, training="hybrid", epochs=epochs, lr=0.01)
    model.fit(problem.x, problem.y)
    return lambda x: np.ravel(model.predict(x))


RIVALS = (
    Rival("anfis-toolbox, hybrid", "anfis-toolbox", True, _toolbox("HybridTrainer", 0.01)),
    Rival("anfis-toolbox, hybrid + Adam", "anfis-toolbox", True, _toolbox("HybridAdamTrainer", 0.001)),
    Rival("xanfis", "xanfis", True, _xanfis),
    Rival("torchanfis, hybrid", "torchanfis", True, _torchanfis),
    Rival("sanfis", "sanfis", False, _sanfis),
    Rival("highfis", "highfis", False, _highfis),
    Rival("anfispy", "anfispy", False, _anfispy),
)


def installed() -> tuple[list[Rival], list[str]]:
    """Those that are here, and a line for each package that is not."""
    here, notes = [], []
    for rival in RIVALS:
        try:
            importlib.metadata.version(rival.package)
            here.append(rival)
        except importlib.metadata.PackageNotFoundError:
            note = f"{rival.package} is not installed (`make bench` does): left out"
            notes += [note] if note not in notes else []
    return here, notes


def learn(rival: Rival, problem: Problem, epochs: int) -> Predict:
    """Learn without a word on stdout."""
    with contextlib.redirect_stdout(io.StringIO()):
        return rival.learn(problem, epochs)


def _tensor(values: np.ndarray) -> Any:
    import torch

    return torch.tensor(values, dtype=torch.float32)


def _numbers(values: Any) -> np.ndarray:
    return np.ravel(values.detach().numpy() if hasattr(values, "detach") else np.asarray(values)).astype(float)
