"""How fast and how well does ANFIS learn? Jang's problems of 1993 and formation data, beside other Python packages.

Every engine starts from the same grid. Times are wall time an epoch with one thread, median over the rounds, engines
in turn, with all that comes before and after the epochs (ours measures the checking error in every epoch too); errors
are RMSE after the given number of epochs. Beside them stands which part of hybrid learning's time second-order learning
needs to come as low as hybrid learning gets. Then one big problem: 100,000 samples, 4 inputs, 16 rules, with one thread
and with all, and ten million samples where torch finds an accelerator.

Run ``python -m benchmarks.learning [--json]``.
"""

import os
import time
import warnings
from collections.abc import Callable, Iterator
from contextlib import contextmanager, nullcontext
from statistics import median
from typing import Any

import numpy as np
import torch

import anfis
from anfis.compiled.threads import count as threads
from benchmarks.anfisrivals import RIVALS, Predict, Rival, installed, learn
from benchmarks.problems import JANG_APE, Problem, grid, problems
from benchmarks.reporting import heading, machine, start

ROUNDS = 5
TIMED = 60  # epochs of a round, as many as the shortest problem has
SECOND_ORDER = 100  # epochs of the second-order method; it converges before
OURS: dict[str, dict[str, Any]] = {
    "hybrid": {},
    "hybrid, step 0.1": {"step": 0.1},
    "second-order": {"method": "second-order"},
}


def ours(problem: Problem, epochs: int, **options: Any) -> anfis.Training:
    """Our own learning."""
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", anfis.DataWarning)
        return anfis.train(
            grid(problem),
            problem.x,
            problem.y,
            anfis.Options(epochs=epochs, **options),
            check=(problem.check_x, problem.check_y),
        )


def errors(problem: Problem, predict: Predict) -> dict[str, float]:
    """Training and checking RMSE, and Jang's APE [%] where the problem has it."""
    result = {}
    for name, x, y in (("train", problem.x, problem.y), ("check", problem.check_x, problem.check_y)):
        error = np.asarray(predict(x), dtype=float) - y
        result[name] = float(np.sqrt(np.mean(error**2)))
        if problem.relative:
            result[f"{name}_ape"] = float(100 * np.mean(np.abs(error / y)))
    return result


def complete(problem: Problem, options: dict[str, Any], aim: float | None) -> dict[str, Any]:
    """One whole run of ours: errors, and when it is as good as Jang's, and as the training error ``aim``."""
    epochs = SECOND_ORDER if options.get("method") == "second-order" else problem.epochs
    begin = time.perf_counter()
    result = ours(problem, epochs, **options)
    seconds = (time.perf_counter() - begin) / len(result.history)
    row: dict[str, Any] = {"epochs": len(result.history) - 1, "hybrid": True, "seconds": seconds * len(result.history)}
    row["least"] = min(r.train for r in result.history)
    if aim is not None:
        reached = next((r.epoch for r in result.history if r.train <= aim), None)
        row["to_aim_s"] = None if reached is None else seconds * (reached + 1)
    row |= errors(problem, lambda x: result.system(x).ravel())
    if problem.goal is not None:
        reached = next((r.epoch for r in result.history if r.check <= problem.goal), None)
        row["to_goal_s"] = None if reached is None else seconds * (reached + 1)
    return row


def one_problem(problem: Problem, rivals: list[Rival]) -> dict[str, Any]:
    """Times an epoch, in turn, then every engine's errors after a whole run."""
    engines: dict[str, Callable[[], Any]] = {
        name: lambda options=options: ours(problem, TIMED - 1, **options)  # type: ignore[misc]
        for name, options in OURS.items()
    }
    engines |= {r.name: lambda r=r: learn(r, problem, TIMED) for r in rivals}  # type: ignore[misc]
    wall: dict[str, list[float]] = {name: [] for name in engines}
    rows: dict[str, Any] = {}
    for round_ in range(ROUNDS + 1):
        for name in list(engines):
            begin = time.perf_counter()
            try:
                engines[name]()
            except Exception as error:  # another package's: whatever it is, the rest goes on
                rows[name] = {"failed": f"{type(error).__name__}: {str(error).partition(chr(10))[0][:80]}"}
                del engines[name], wall[name]
                continue
            if round_:  # the first warms up
                wall[name].append((time.perf_counter() - begin) / TIMED)
    for name in engines:
        if name in OURS:
            row = complete(problem, OURS[name], rows["hybrid"]["least"] if "hybrid" in rows else None)
        else:
            rival = next(r for r in rivals if r.name == name)
            row = {"epochs": problem.epochs, "hybrid": rival.hybrid}
            row |= errors(problem, learn(rival, problem, problem.epochs))
        row["ms_an_epoch"] = 1e3 * median(wall[name])
        row["ratio"] = median(w / o for w, o in zip(wall[name], wall["hybrid"], strict=True))
        rows[name] = row
    return rows


def large(samples: int, device: str, dtype: str = "float64") -> float:
    """Seconds of one hybrid epoch, 4 inputs, 16 rules, in blocks."""
    random = np.random.default_rng(0)
    x = random.uniform(size=(samples, 4))
    y = np.sin(4 * x[:, 0]) * x[:, 1] + x[:, 2] ** 2 - x[:, 3]
    fis = grid(Problem("large", x, y, x, y, 2, 3))
    batch = 0 if device == "cpu" else 1_048_576
    arrived: list[float] = []
    for _ in range(3):
        began = len(arrived)
        anfis.train(
            fis,
            x,
            y,
            anfis.Options(epochs=3, batch=batch, device=device, dtype=dtype),  # type: ignore[arg-type]
            callback=lambda _: arrived.append(time.perf_counter()),
        )
        arrived[began:] = np.diff(arrived[began:]).tolist()  # without what is done once
    return median(arrived)


@contextmanager
def single_thread() -> Iterator[None]:
    """Our own learning in one thread."""
    before = os.environ.get("OMP_NUM_THREADS")
    os.environ["OMP_NUM_THREADS"] = "1"
    try:
        yield
    finally:
        if before is None:
            del os.environ["OMP_NUM_THREADS"]
        else:
            os.environ["OMP_NUM_THREADS"] = before


def measure() -> dict[str, Any]:
    """Every number of the benchmark."""
    rivals, notes = installed()
    result: dict[str, Any] = machine(
        ["fuzzyfleet", "torch", "numpy", *dict.fromkeys(rival.package for rival in RIVALS)]
    )
    cores = torch.get_num_threads()  # before the limit, which is torch's too
    try:
        from threadpoolctl import threadpool_limits

        alone: Any = threadpool_limits(1)
    except ImportError:
        alone = nullcontext()
        notes.append("threadpoolctl is not installed: numpy's engines may use more than one thread")
    torch.set_num_threads(1)
    with alone, single_thread():
        result["problems"] = {problem.name: one_problem(problem, rivals) for problem in problems()}
        result["large_alone"] = {"samples": 100_000, "device": "1 thread", "seconds": large(100_000, "cpu")}
    torch.set_num_threads(cores)
    result["large"] = {"samples": 100_000, "device": f"{threads()} threads", "seconds": large(100_000, "cpu")}
    if torch.cuda.is_available():
        result["accelerator"] = {
            "samples": 10_000_000,
            "device": torch.cuda.get_device_name(),
            "seconds": large(10_000_000, "cuda"),
        }
    return result | {"rounds": ROUNDS, "notes": notes}


def report(result: dict[str, Any]) -> str:
    """The result as tables: times an epoch, and how many times our hybrid's."""
    lines = [heading(result), f"one thread; median of {result['rounds']} rounds of {TIMED} epochs, engines in turn"]
    for problem, rows in result["problems"].items():
        lines += ["", f"{problem:32}{'ms an epoch':>12}{'ratio':>8}{'epochs':>8}{'train':>11}{'check':>11}"]
        for name, row in rows.items():
            if "failed" in row:
                lines.append(f"  {name:30}{row['failed']}")
                continue
            line = (
                f"  {name:30}{row['ms_an_epoch']:>12.2f}{row['ratio']:>8.1f}{row['epochs']:>8}"
                f"{row['train']:>11.2e}{row['check']:>11.2e}"
            )
            if "train_ape" in row:
                line += f"   APE {row['train_ape']:.3f} %, {row['check_ape']:.3f} % (Jang {JANG_APE[0]}, {JANG_APE[1]})"
            if row.get("to_goal_s"):
                line += f"   Jang's error after {row['to_goal_s']:.2f} s"
            lines.append(line)
        second, hybrid = rows["second-order"], rows["hybrid"]
        if second.get("to_aim_s") is None:
            lines.append("  second-order does not come as low as hybrid")
        else:
            part = second["to_aim_s"] / hybrid["seconds"]
            lines.append(f"  second-order is as low as hybrid's least error after {part:.0%} of hybrid's time")
        learnt = [n for n, row in rows.items() if row.get("hybrid") and n not in OURS]
        if learnt:
            fastest = min(learnt, key=lambda n: rows[n]["ms_an_epoch"])
            lines.append(f"  fastest hybrid rival: {fastest}, {rows[fastest]['ratio']:.1f} x ours")
    for key in ("large_alone", "large", "accelerator"):
        if found := result.get(key):
            rate = found["samples"] / found["seconds"] / 1e6
            lines += [
                "",
                f"{found['samples']:,} x 4, 16 rules, {found['device']}: {1e3 * found['seconds']:.1f} ms a hybrid "
                f"epoch, {rate:.2f} million samples a second",
            ]
    return "\n".join([*lines, "", *result["notes"]])


if __name__ == "__main__":
    start(__doc__, measure, report)
