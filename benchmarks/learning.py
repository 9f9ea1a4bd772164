"""How fast and how well does ANFIS learn? Mackey-Glass as Jang set it, beside anfis-toolbox.

500 pairs to learn from, 500 to check with; two bells an input, 16 rules, 104 parameters. Every engine starts from the
same grid. Time is wall time an epoch with one thread (median over the rounds, engines in turn); errors are RMSE.
Then one big problem: 100,000 samples, 4 inputs, 16 rules.

Run ``python -m benchmarks.learning [--json]``.
"""

import argparse
import importlib.metadata
import json
import platform
import time
from itertools import product
from statistics import median
from typing import Any

import numpy as np
import torch

import anfis
import fuzzy
from benchmarks.mackeyglass import pairs

ROUNDS, EPOCHS = 5, 500
JANG = 0.0015  # the checking RMSE that Jang 1993 reports after 500 epochs


def grid(x: np.ndarray) -> fuzzy.Sugeno:
    """Two bells an input, neighbours crossing at 0.5, and a rule for every combination, the last input fastest."""
    inputs = []
    for i, (low, high) in enumerate(zip(x.min(axis=0), x.max(axis=0), strict=True)):
        bells = {f"mf{k + 1}": fuzzy.Bell((high - low) / 2, 2, c) for k, c in enumerate((low, high))}
        inputs.append(fuzzy.Variable(f"in{i + 1}", (low, high), bells))
    combinations = list(product(("mf1", "mf2"), repeat=x.shape[1]))
    names = [f"out1mf{r + 1}" for r in range(len(combinations))]
    output = fuzzy.Variable("out1", (0, 2), {name: fuzzy.Linear([0.0] * x.shape[1], 0.0) for name in names})
    rules = [
        fuzzy.Rule(tuple(fuzzy.Clause(f"in{i + 1}", mf) for i, mf in enumerate(c)), (("out1", name),))
        for c, name in zip(combinations, names, strict=True)
    ]
    return fuzzy.Sugeno(inputs, [output], rules)


def ours(method: str, epochs: int, **options: Any) -> tuple[float, dict[str, Any]]:
    """Seconds an epoch, and what came out."""
    x, y = pairs()
    start = time.perf_counter()
    result = anfis.train(
        grid(x[:500]),
        x[:500],
        y[:500],
        anfis.Options(method=method, epochs=epochs, **options),
        check=(x[500:], y[500:]),
    )
    seconds = (time.perf_counter() - start) / len(result.history)
    best = result.history[result.best]
    reached = next((row.epoch for row in result.history if row.check <= JANG), None)
    return seconds, {
        "epochs": len(result.history) - 1,
        "best_epoch": result.best,
        "train": best.train,
        "check": best.check,
        "to_jang_s": None if reached is None else seconds * (reached + 1),
    }


def toolbox(epochs: int) -> tuple[float, dict[str, Any]]:
    """anfis-toolbox's hybrid learning from the same grid."""
    from anfis_toolbox.membership import BellMF
    from anfis_toolbox.model import TSKANFIS
    from anfis_toolbox.optim import HybridTrainer

    x, y = pairs()
    low, high = x[:500].min(axis=0), x[:500].max(axis=0)
    terms = {
        f"x{i}": [BellMF((b - a) / 2, 2, a), BellMF((b - a) / 2, 2, b)]
        for i, (a, b) in enumerate(zip(low, high, strict=True))
    }
    model = TSKANFIS(terms)
    start = time.perf_counter()
    model.fit(x[:500], y[:500, None], trainer=HybridTrainer(learning_rate=0.01, epochs=epochs))
    seconds = (time.perf_counter() - start) / epochs
    errors = [
        float(np.sqrt(np.mean((model.predict(x[s]).ravel() - y[s]) ** 2))) for s in (slice(0, 500), slice(500, None))
    ]
    return seconds, {"epochs": epochs, "train": errors[0], "check": errors[1]}


def large() -> dict[str, float]:
    """One hybrid epoch on 100,000 samples, 4 inputs, 16 rules, in blocks."""
    random = np.random.default_rng(0)
    x = random.uniform(size=(100_000, 4))
    y = np.sin(4 * x[:, 0]) * x[:, 1] + x[:, 2] ** 2 - x[:, 3]
    seconds = []
    for _ in range(3):
        start = time.perf_counter()
        result = anfis.train(grid(x), x, y, anfis.Options(epochs=3, batch=8192))
        seconds.append((time.perf_counter() - start) / len(result.history))
    return {"seconds_an_epoch": median(seconds)}


def measure() -> dict[str, Any]:
    """Every number of the benchmark."""
    torch.set_num_threads(1)
    engines = {
        "hybrid": lambda: ours("hybrid", EPOCHS),
        "hybrid, step 0.1": lambda: ours("hybrid", EPOCHS, step=0.1),
        "second-order": lambda: ours("second-order", 200),
    }
    versions = {name: importlib.metadata.version(name) for name in ("fuzzyfleet", "torch", "numpy")}
    try:
        versions["anfis-toolbox"] = importlib.metadata.version("anfis-toolbox")
        engines["anfis-toolbox, hybrid"] = lambda: toolbox(60)
    except importlib.metadata.PackageNotFoundError:
        print("anfis-toolbox is not installed (`make bench` does): left out")
    times: dict[str, list[float]] = {name: [] for name in engines}
    results: dict[str, Any] = {}
    for _ in range(ROUNDS):
        for name, engine in engines.items():
            seconds, results[name] = engine()
            times[name].append(seconds)
    for name, values in times.items():
        results[name]["ms_an_epoch"] = 1e3 * median(values)
    torch.set_num_threads(2)
    return {
        "versions": versions,
        "machine": platform.processor() or platform.machine(),
        "mackey_glass": results,
        "large": large(),
    }


def main() -> None:
    """Measure and print."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--json", action="store_true", help="print one JSON object")
    found = measure() if (arguments := parser.parse_args()) else {}
    if arguments.json:
        print(json.dumps(found))
        return
    print(" ".join(f"{name} {version}" for name, version in found["versions"].items()))
    base = found["mackey_glass"]["hybrid"]["ms_an_epoch"]
    for name, row in found["mackey_glass"].items():
        jang = f", Jang's {JANG} after {row['to_jang_s']:.2f} s" if row.get("to_jang_s") else ""
        print(
            f"{name:24} {row['ms_an_epoch']:8.2f} ms an epoch ({row['ms_an_epoch'] / base:5.1f} x hybrid), after "
            f"{row['epochs']} epochs train {1e3 * row['train']:.2f}e-3, check {1e3 * row['check']:.2f}e-3{jang}"
        )
    print(f"100,000 x 4, 16 rules: {found['large']['seconds_an_epoch']:.2f} s a hybrid epoch, 2 threads")


if __name__ == "__main__":
    main()
