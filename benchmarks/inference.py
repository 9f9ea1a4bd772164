"""How fast is inference? Ours and its peers side by side: one point, and 100,000 points.

The system has 3 inputs, 8 rules of Gaussian terms joined by the product, first-order consequents and the
weighted average. Engines take turns, one round after another, so that a busy machine disturbs all of them
alike; each number is the median over the rounds. Engines first have to give our answers. Many points are measured on
one processor, and on all of them where an engine uses more than one.

Run ``python -m benchmarks.inference [--json]``. Peers that are not installed are left out with a note.
"""

import contextlib
import os
import sys
from collections.abc import Iterator
from pathlib import Path
from statistics import median
from typing import Any

import numpy as np
from numba import njit

from benchmarks.inferencepeers import CENTER, CONSEQUENT, INPUTS, PEERS, POINTS, RULES, SIGMA, Engine, X
from benchmarks.reporting import heading, machine, start
from fuzzy.compiled.packed import evaluate_packed, packed, packed_work
from fuzzy.compiled.sugeno import compile_sugeno
from fuzzy.compiled.threads import processors
from fuzzy.inference import infer
from fuzzy.membership import Gaussian
from fuzzy.rule import Clause, Rule
from fuzzy.system import Linear, Sugeno, Variable

ROUNDS = 9
OURS = "compiled"


def system() -> Sugeno:
    """The system in our own words."""
    inputs = [
        Variable(f"x{i}", (-1, 1), {f"t{r}": Gaussian(SIGMA[r, i], CENTER[r, i]) for r in range(RULES)})
        for i in range(INPUTS)
    ]
    consequents = {f"t{r}": Linear(CONSEQUENT[r, :-1].tolist(), float(CONSEQUENT[r, -1])) for r in range(RULES)}
    rules = [Rule(tuple(Clause(v.name, f"t{r}") for v in inputs), (("y", f"t{r}"),)) for r in range(RULES)]
    return Sugeno(inputs, [Variable("y", (-10, 10), consequents)], rules)


@njit
def _point_by_point(system: np.ndarray, x: np.ndarray, output: np.ndarray, work: np.ndarray) -> None:
    for k in range(len(x)):
        evaluate_packed(system, x[k], output[k], work)


def ours() -> list[Engine]:
    """The package's own three ways."""
    fis = system()
    compiled = compile_sugeno(fis)
    row = packed(fis)
    work = np.empty(packed_work(row))

    def by_point(x: np.ndarray) -> np.ndarray:
        output = np.empty((len(x), 1))
        _point_by_point(row, x, output, work)
        return output

    return [
        Engine("infer (numpy)", lambda x: infer(fis, x).output, lambda x: infer(fis, x).output),
        Engine(OURS, compiled, compiled, threaded=True),
        Engine("compiled, point by point in a Numba loop", None, by_point),
    ]


def check(engine: Engine) -> float:
    """The greatest difference from the numpy inference; AssertionError beyond the engine's tolerance."""
    x = X[: min(engine.points, 1000)]
    expected = infer(system(), x).output
    difference = float(np.abs(np.asarray(engine.many(x)) - expected).max())
    if engine.one is not None:
        difference = max(difference, float(np.abs(np.ravel(engine.one(x[0].tolist())) - expected[0]).max()))
    assert engine.tolerance is not None
    assert difference < engine.tolerance, f"{engine.name} differs by {difference:g}"
    return difference


def repetitions(engine: Engine, point: list[float]) -> int:
    """How many single points make a measurement of some 5 ms."""
    engine.time_one(point, 1)
    return max(1, min(1000, int(0.005 / engine.time_one(point, 1))))


@contextlib.contextmanager
def on_one_processor(engine: Engine) -> Iterator[None]:
    """Keep every thread of this process on one processor, and an engine that can be told so to one thread."""
    if not hasattr(os, "sched_setaffinity"):
        yield
        return
    allowed = os.sched_getaffinity(0)
    _move({min(allowed)})
    if engine.limit is not None:
        engine.limit(1)
    try:
        yield
    finally:
        _move(allowed)
        if engine.limit is not None:
            engine.limit(len(allowed))


def _move(allowed: set[int]) -> None:
    for thread in Path("/proc/self/task").iterdir():
        with contextlib.suppress(ProcessLookupError):  # it has just ended
            os.sched_setaffinity(int(thread.name), allowed)


def engines_and_notes() -> tuple[list[Engine], list[str]]:
    """Ours and the peers that are there, and sentences about the others."""
    engines, notes = ours(), []
    for make in PEERS:
        try:
            with contextlib.redirect_stdout(sys.stderr):  # simpful announces itself
                engines.append(make())
        except ImportError as error:
            notes.append(f"{make.__name__} is left out: {error}")
    notes += [f"{e.name}: {e.points} points are measured, and scaled" for e in engines if e.points < POINTS]
    return engines, notes


def measure() -> dict[str, Any]:
    """Every number of the report, by name; times in seconds."""
    engines, notes = engines_and_notes()
    differences = {e.name: check(e) for e in engines if e.tolerance is not None}
    point = X[0].tolist()
    counts = {e.name: repetitions(e, point) for e in engines if e.one is not None}
    # After the numpy inference of a large array, whatever runs next takes twice its time (measured on Zen 5: the C
    # loop, Python itself) until a function compiled by Numba has run; presumably numpy leaves the upper halves of
    # the vector registers in use. Without this the engine whose turn is next would pay for it.
    clear = compile_sugeno(system())
    one: dict[str, list[float]] = {e.name: [] for e in engines}
    many: dict[str, list[float]] = {e.name: [] for e in engines}
    everywhere: dict[str, list[float]] = {e.name: [] for e in engines if e.threaded}
    for _ in range(ROUNDS):
        for e in engines:
            with on_one_processor(e):
                clear(X[:1000])
                many[e.name].append(e.time_many())
            if e.threaded:
                clear(X[:1000])
                everywhere[e.name].append(e.time_many())
            if e.one is None:  # called from compiled code: the time of a point in its loop
                one[e.name].append(many[e.name][-1] / POINTS)
            else:
                clear(X[:1000])
                one[e.name].append(e.time_one(point, counts[e.name]))
    about = machine(["numpy", "numba"]) | {"load": os.getloadavg()[0] if hasattr(os, "getloadavg") else None}
    return about | {
        "system": f"{INPUTS} inputs, {RULES} Gaussian rules, first order; {POINTS} points; median of {ROUNDS} rounds",
        "processors": processors(),
        "difference_from_infer": differences,
        "one_point_s": {name: median(times) for name, times in one.items()},
        "many_points_s": {name: median(times) for name, times in many.items()},
        "many_points_all_processors_s": {name: median(times) for name, times in everywhere.items()},
        "notes": notes,
    }


def report(result: dict[str, Any]) -> str:
    """The result as a table: times, and how many times the compiled inference's."""
    one, many = result["one_point_s"], result["many_points_s"]
    everywhere = many | result["many_points_all_processors_s"]
    lines = [heading(result), f"{result['system']}; {result['processors']} processors, load {result['load']}", ""]
    lines.append(
        f"{'':42}{'one point':>12}{'ratio':>9}{f'{POINTS:,} points':>18}{'ratio':>9}{'all processors':>18}{'ratio':>9}"
    )
    for name in one:
        line = f"{name:42}{one[name] * 1e6:>9.2f} us{one[name] / one[OURS]:>9.3g}"
        line += f"{many[name] * 1e3:>15.3g} ms{many[name] / many[OURS]:>9.3g}"
        shared = (
            f"{everywhere[name] * 1e3:>15.3g} ms" if name in result["many_points_all_processors_s"] else f"{'-':>18}"
        )
        lines.append(line + shared + f"{everywhere[name] / everywhere[OURS]:>9.3g}")
    lines += ["", f"ratio: time over that of '{OURS}'. Without a call from Python, one point is its share of a loop."]
    lines.append(f"'-': the engine has one thread, whose time is compared with that of '{OURS}' on all processors.")
    lines += verdicts(one, many, everywhere)
    if result["load"] and result["load"] > result["processors"]:
        lines.append(
            "The machine was busy, from which long measurements suffer more than short ones: these ratios flatter."
        )
    worst = max(result["difference_from_infer"].values())
    lines.append(f"Engines of the same system agree within {worst:.1e}.")
    return "\n".join(lines + result["notes"])


def verdicts(one: dict[str, float], many: dict[str, float], everywhere: dict[str, float]) -> list[str]:
    """Sentences that compare ours with the C loop and with the fastest of the peers."""
    own = {*(e.name for e in ours()), "C as exported"}
    lines = []
    for what, times in ((f"{POINTS:,} points on one processor", many), ("and on all", everywhere), ("one point", one)):
        peers = {name: t for name, t in times.items() if name not in own and name != "C loop"}
        others = {name: times[name] for name in ("C loop",) if name in times and times is not one}
        if peers:
            others |= {min(peers, key=lambda name: peers[name]): min(peers.values())}
        if "C as exported" in times and "C loop" in times and times is many:
            lines.append(
                f"C as exported takes {times['C as exported'] / times['C loop']:.3g} of the time of the C loop."
            )
        parts = [f"{times[OURS] / t:.3g} of the time of {name}" for name, t in others.items()]
        lines.append(f"{what}: {OURS} takes {' and '.join(parts)}." if parts else f"{what}: no peer is installed.")
    return lines


if __name__ == "__main__":
    start(__doc__, measure, report)
