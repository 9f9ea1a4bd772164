"""How fast is inference? Ours and its peers side by side: one point, and 100,000 points.

The system has 3 inputs, 8 rules of Gaussian terms joined by the product, first-order consequents and the
weighted average. Engines take turns, one round after another, so that a busy machine disturbs all of them
alike; each number is the median over the rounds. Engines first have to give our answers.

Run ``python -m benchmarks.inference [--json]``. Peers that are not installed are left out with a note.
"""

import contextlib
import ctypes
import shutil
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from statistics import median
from typing import Any

import numpy as np
from numba import njit

from benchmarks.reporting import heading, machine, start, versions
from fuzzy.compiled.packed import evaluate_packed, packed, packed_work
from fuzzy.compiled.sugeno import compile_sugeno
from fuzzy.inference import infer
from fuzzy.membership import Gaussian
from fuzzy.rule import Clause, Rule
from fuzzy.system import Linear, Sugeno, Variable

INPUTS, RULES, POINTS, ROUNDS = 3, 8, 100_000, 9
RNG = np.random.default_rng(0)
CENTER = RNG.uniform(-1, 1, (RULES, INPUTS))
SIGMA = RNG.uniform(0.3, 0.8, (RULES, INPUTS))
CONSEQUENT = RNG.normal(size=(RULES, INPUTS + 1))  # slopes, constant
X = RNG.uniform(-1, 1, (POINTS, INPUTS))


@dataclass(frozen=True)
class Engine:
    """A way to evaluate the system. ``one`` takes a list of inputs, ``many`` an array (n, inputs)."""

    name: str
    one: Callable[[list[float]], Any] | None
    many: Callable[[np.ndarray], Any]
    points: int = POINTS  # how many a round measures; the time is scaled up to POINTS
    comparable: bool = True  # does it give our answers?


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
        Engine("compiled", compiled, compiled),
        Engine("compiled, point by point in a Numba loop", None, by_point),
    ]


def c_loop() -> Engine:
    """inference.c, compiled now for this machine."""
    compiler = shutil.which("cc") or shutil.which("gcc") or shutil.which("clang")
    if compiler is None:
        raise ImportError("no C compiler")
    with tempfile.TemporaryDirectory() as folder:
        target = Path(folder) / "inference.so"
        # Strict IEEE arithmetic: no contraction to fused multiply-add, no fast-math.
        flags = ["-O3", "-march=native", "-ffp-contract=off", "-shared", "-fPIC"]
        source = Path(__file__).with_suffix(".c")
        subprocess.run([compiler, *flags, str(source), "-o", str(target), "-lm"], check=True)
        library = ctypes.CDLL(str(target))
    tables = [a.ctypes.data_as(ctypes.c_void_p) for a in (CENTER, SIGMA, CONSEQUENT)]

    def many(x: np.ndarray) -> np.ndarray:
        output = np.empty((len(x), 1))
        place = ctypes.c_void_p
        library.infer(ctypes.c_ssize_t(len(x)), place(x.ctypes.data), *tables, place(output.ctypes.data))
        return output

    return Engine("C loop", None, many)


def pyfuzzylite() -> Engine:
    """Takagi-Sugeno engine; evaluates arrays from version 8 on, before that point by point."""
    import fuzzylite as fl

    if hasattr(fl.lib, "abs_tolerance"):
        fl.lib.abs_tolerance = 0.0  # by default it drops rules that fire with less than 1e-5

    inputs = [
        fl.InputVariable(
            f"x{i}", "", True, -1, 1, False, [fl.Gaussian(f"t{r}", CENTER[r, i], SIGMA[r, i]) for r in range(RULES)]
        )
        for i in range(INPUTS)
    ]
    output = fl.OutputVariable("y", minimum=-10, maximum=10, defuzzifier=fl.WeightedAverage("TakagiSugeno"))
    engine = fl.Engine("bench", "", inputs, [output])
    output.terms = [fl.Linear(f"f{r}", CONSEQUENT[r].tolist(), engine) for r in range(RULES)]
    rules = [
        fl.Rule.create("if " + " and ".join(f"x{i} is t{r}" for i in range(INPUTS)) + f" then y is f{r}", engine)
        for r in range(RULES)
    ]
    product = fl.AlgebraicProduct()
    engine.rule_blocks = [
        fl.RuleBlock("", conjunction=product, implication=product, activation=fl.General(), rules=rules)
    ]

    def evaluate(x: Any) -> np.ndarray:
        for i, variable in enumerate(inputs):
            variable.value = x[..., i] if isinstance(x, np.ndarray) else x[i]
        engine.process()
        return np.reshape(output.value, (-1, 1))

    if int(versions(["pyfuzzylite"])["pyfuzzylite"].partition(".")[0]) >= 8:
        return Engine("pyfuzzylite", evaluate, evaluate)
    return Engine(
        "pyfuzzylite", evaluate, lambda x: np.concatenate([evaluate(point) for point in x.tolist()]), points=100
    )


def simpful() -> Engine:
    """Sugeno inference of one point at a time."""
    from simpful import FuzzySystem, GaussianFuzzySet, LinguisticVariable

    engine = FuzzySystem(operators=["AND_PRODUCT"], show_banner=False, verbose=False)
    for i in range(INPUTS):
        sets = [GaussianFuzzySet(mu=CENTER[r, i], sigma=SIGMA[r, i], term=f"t{r}") for r in range(RULES)]
        engine.add_linguistic_variable(f"x{i}", LinguisticVariable(sets, universe_of_discourse=[-1, 1]))
    for r in range(RULES):
        *slopes, constant = CONSEQUENT[r].tolist()
        engine.set_output_function(
            f"f{r}", " + ".join(f"({s!r})*x{i}" for i, s in enumerate(slopes)) + f"+({constant!r})"
        )
        clauses = " AND ".join(f"(x{i} IS t{r})" for i in range(INPUTS))
        engine.add_rules([f"IF {clauses} THEN (y IS f{r})"])

    def one(x: Any) -> float:
        for i in range(INPUTS):
            engine.set_variable(f"x{i}", x[i])
        return engine.Sugeno_inference(["y"])["y"]

    return Engine("simpful", one, lambda x: np.array([[one(point)] for point in x]), points=50)


def scikit_fuzzy() -> Engine:
    """A Mamdani system of the same size: it has no Sugeno systems, so that only the times compare."""
    from skfuzzy import control, gaussmf

    inputs = [control.Antecedent(np.linspace(-1, 1, 101), f"x{i}") for i in range(INPUTS)]
    y = control.Consequent(np.linspace(-10, 10, 101), "y")
    rules = []
    for r in range(RULES):
        for i, variable in enumerate(inputs):
            variable[f"t{r}"] = gaussmf(variable.universe, CENTER[r, i], SIGMA[r, i])
        y[f"t{r}"] = gaussmf(y.universe, CONSEQUENT[r, -1], 1.0)
        first, second, third = (variable[f"t{r}"] for variable in inputs)
        rules.append(control.Rule(first & second & third, y[f"t{r}"]))
    engine = control.ControlSystemSimulation(control.ControlSystem(rules), cache=False)

    def one(x: Any) -> float:
        for i in range(INPUTS):
            engine.input[f"x{i}"] = x[i]
        engine.compute()
        return engine.output["y"]

    return Engine("scikit-fuzzy (Mamdani)", one, lambda x: [one(point) for point in x], points=5, comparable=False)


def seconds(call: Callable[[], Any]) -> float:
    start = time.perf_counter()
    call()
    return time.perf_counter() - start


def check(engine: Engine) -> float:
    """The greatest difference from the numpy inference; AssertionError from 1e-9 on."""
    x = X[: min(engine.points, 1000)]
    expected = infer(system(), x).output
    difference = float(np.abs(np.asarray(engine.many(x)) - expected).max())
    if engine.one is not None:
        difference = max(difference, float(np.abs(np.ravel(engine.one(x[0].tolist())) - expected[0]).max()))
    assert difference < 1e-9, f"{engine.name} differs by {difference:g}"
    return difference


def repetitions(engine: Engine, point: list[float]) -> int:
    """How many single points make a measurement of some 5 ms."""
    assert engine.one is not None
    engine.one(point)
    return max(1, min(1000, int(0.005 / seconds(lambda: engine.one(point)))))  # type: ignore[misc]


def measure() -> dict[str, Any]:
    """Every number of the report, by name; times in seconds."""
    engines, notes = ours(), []
    for make in (c_loop, pyfuzzylite, simpful, scikit_fuzzy):
        try:
            with contextlib.redirect_stdout(sys.stderr):  # simpful announces itself
                engines.append(make())
        except ImportError as error:
            notes.append(f"{make.__name__} left out: {error}")
    differences = {e.name: check(e) for e in engines if e.comparable}
    point = X[0].tolist()
    counts = {e.name: repetitions(e, point) for e in engines if e.one is not None}
    # After the numpy inference of a large array, whatever runs next takes twice its time (measured on Zen 5: the C
    # loop, Python itself) until a function compiled by Numba has run; presumably numpy leaves the upper halves of
    # the vector registers in use. Without this the engine whose turn is next would pay for it.
    clear = compile_sugeno(system())
    one: dict[str, list[float]] = {e.name: [] for e in engines}
    many: dict[str, list[float]] = {e.name: [] for e in engines}
    for _ in range(ROUNDS):
        for e in engines:
            clear(X[:1000])
            many[e.name].append(seconds(lambda e=e: e.many(X[: e.points])) * POINTS / e.points)  # type: ignore[misc]
            if e.one is None:  # called from compiled code: the time of a point in its loop
                one[e.name].append(many[e.name][-1] / POINTS)
            else:
                count = counts[e.name]
                clear(X[:1000])
                one[e.name].append(seconds(lambda e=e, n=count: [e.one(point) for _ in range(n)]) / count)  # type: ignore[misc]
    for e in engines:
        if e.points < POINTS:
            notes.append(f"{e.name}: measured {e.points} points and scaled")
    return machine(["numpy", "numba", "pyfuzzylite", "simpful", "scikit-fuzzy"]) | {
        "system": f"{INPUTS} inputs, {RULES} Gaussian rules, first order; {POINTS} points; median of {ROUNDS} rounds",
        "difference_from_infer": differences,
        "one_point_s": {name: median(times) for name, times in one.items()},
        "many_points_s": {name: median(times) for name, times in many.items()},
        "notes": notes,
    }


def report(result: dict[str, Any]) -> str:
    """The result as a table: times, and how many times the compiled inference's."""
    lines = [heading(result), result["system"], ""]
    lines.append(f"{'':42}{'one point':>12}{'ratio':>9}{f'{POINTS:,} points':>18}{'ratio':>9}")
    one, many = result["one_point_s"], result["many_points_s"]
    for name in one:
        lines.append(
            f"{name:42}{one[name] * 1e6:>9.2f} us{one[name] / one['compiled']:>9.3g}"
            f"{many[name] * 1e3:>15.3g} ms{many[name] / many['compiled']:>9.3g}"
        )
    lines += ["", "ratio: time over that of 'compiled'. Without a call from Python, one point is its share of a loop."]
    worst = max(result["difference_from_infer"].values())
    lines.append(f"Engines of the same system agree within {worst:.1e}.")
    return "\n".join(lines + result["notes"])


def main() -> None:
    start(__doc__, measure, report)


if __name__ == "__main__":
    main()
