"""The peers of :mod:`benchmarks.inference`, each behind one function that makes an engine of the same system."""

import ctypes
import json
import os
import shutil
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from benchmarks.reporting import versions

INPUTS, RULES, POINTS = 3, 8, 100_000
RNG = np.random.default_rng(0)
CENTER = RNG.uniform(-1, 1, (RULES, INPUTS))
SIGMA = RNG.uniform(0.3, 0.8, (RULES, INPUTS))
CONSEQUENT = RNG.normal(size=(RULES, INPUTS + 1))  # slopes, constant
X = RNG.uniform(-1, 1, (POINTS, INPUTS))
BUILD = Path(__file__).parents[1] / "build"


def seconds(call: Callable[[], Any]) -> float:
    """How long a call takes."""
    start = time.perf_counter()
    call()
    return time.perf_counter() - start


@dataclass(frozen=True)
class Engine:
    """A way to evaluate the system. ``one`` takes a list of inputs, ``many`` an array (n, inputs)."""

    name: str
    one: Callable[[list[float]], Any] | None
    many: Callable[[np.ndarray], Any]
    points: int = POINTS  # how many a round measures; the time is scaled up to POINTS
    tolerance: float | None = 1e-9  # of its answers beside ours; None for a system of another kind
    threaded: bool = False  # does it share out many points over the processors?
    limit: Callable[[int], Any] | None = None  # how it is told the number of threads, beside the processors it may use

    def time_one(self, point: list[float], count: int) -> float:
        """The time of one point among ``count`` [s]."""
        one = self.one
        assert one is not None
        return seconds(lambda: [one(point) for _ in range(count)]) / count

    def time_many(self) -> float:
        """The time of all points [s]."""
        return seconds(lambda: self.many(X[: self.points])) * POINTS / self.points


def _library(source: Path, flags: list[str], compilers: tuple[str, ...]) -> ctypes.CDLL:
    """A source file beside this one, compiled now for this machine."""
    compiler = next(filter(None, map(shutil.which, compilers)), None)
    if compiler is None:
        raise ImportError(f"no compiler for {source.name}")
    with tempfile.TemporaryDirectory() as folder:
        target = Path(folder) / f"{source.stem}.so"
        # Strict IEEE arithmetic: no contraction to fused multiply-add, no fast-math.
        options = ["-O3", "-march=native", "-ffp-contract=off", "-shared", "-fPIC"]
        made = subprocess.run([compiler, *options, str(source), "-o", str(target), *flags], capture_output=True)
        if made.returncode:
            said = next((line for line in made.stderr.decode().splitlines() if "error" in line), "no message")
            raise ImportError(said.replace(f"{source.parent}/", ""))
        return ctypes.CDLL(str(target))


def c_loop() -> Engine:
    """inference.c."""
    library = _library(Path(__file__).with_name("inference.c"), ["-lm"], ("cc", "gcc", "clang"))
    place = ctypes.c_void_p
    tables = [a.ctypes.data_as(place) for a in (CENTER, SIGMA, CONSEQUENT)]

    kept = np.zeros((POINTS, 1))  # as a program of C has it: fresh memory costs as much as some engines' arithmetic

    def many(x: np.ndarray) -> np.ndarray:
        output = kept[: len(x)]
        library.infer(ctypes.c_ssize_t(len(x)), place(x.ctypes.data), *tables, place(output.ctypes.data))
        return output

    return Engine("C loop", None, many)


def exported_c() -> Engine:
    """The system as `fuzzy export c` writes it, with the flags of the C loop and called from a loop of C like it."""
    from benchmarks.inference import system
    from fuzzy.plugins.ccode.source import c_sources

    sources = c_sources(system(), "exported")
    loop = f"""
#include <stddef.h>
void infer_all(ptrdiff_t n, const double *x, double *y) {{
    for (ptrdiff_t p = 0; p < n; p++) exported_infer(x + p * {INPUTS}, y + p);
}}
"""
    with tempfile.TemporaryDirectory() as folder:
        source = Path(folder) / "exported.c"
        source.with_suffix(".h").write_text(sources.header)
        source.write_text(sources.source + loop)
        library = _library(source, ["-lm"], ("cc", "gcc", "clang"))
    place = ctypes.c_void_p

    kept = np.zeros((POINTS, 1))

    def many(x: np.ndarray) -> np.ndarray:
        output = kept[: len(x)]
        library.infer_all(ctypes.c_ssize_t(len(x)), place(x.ctypes.data), place(output.ctypes.data))
        return output

    return Engine("C as exported", None, many)


def fuzzylite() -> Engine:
    """fuzzylite's C++ library, where its development files are installed (Debian: libfuzzylite-dev)."""
    library = _library(Path(__file__).with_name("fuzzylite.cpp"), ["-lfuzzylite"], ("c++", "g++", "clang++"))
    library.make.restype = ctypes.c_void_p
    lines = ["Engine: bench"]
    for i in range(INPUTS):
        lines += [f"InputVariable: x{i}", "  enabled: true", "  range: -1 1", "  lock-range: false"]
        lines += [f"  term: t{r} Gaussian {float(CENTER[r, i])!r} {float(SIGMA[r, i])!r}" for r in range(RULES)]
    lines += ["OutputVariable: y", "  enabled: true", "  range: -10 10", "  lock-range: false", "  aggregation: none"]
    lines += ["  defuzzifier: WeightedAverage TakagiSugeno", "  default: nan", "  lock-previous: false"]
    lines += [f"  term: f{r} Linear {' '.join(map(repr, CONSEQUENT[r].tolist()))}" for r in range(RULES)]
    lines += ["RuleBlock: ", "  enabled: true", "  conjunction: AlgebraicProduct", "  disjunction: none"]
    lines += ["  implication: AlgebraicProduct", "  activation: General", *(f"  rule: {text}" for text in _sentences())]
    made = ctypes.c_void_p(library.make("\n".join(lines).encode()))

    def many(x: np.ndarray) -> np.ndarray:
        output = np.empty((len(x), 1))
        place = ctypes.c_void_p
        library.infer(made, ctypes.c_ssize_t(len(x)), place(x.ctypes.data), place(output.ctypes.data))
        return output

    return Engine("fuzzylite (C++)", None, many, points=10_000)


def _sentences() -> list[str]:
    """The rules in fuzzylite's words."""
    return ["if " + " and ".join(f"x{i} is t{r}" for i in range(INPUTS)) + f" then y is f{r}" for r in range(RULES)]


@dataclass(frozen=True)
class Elsewhere(Engine):
    """An engine in another process, which measures itself."""

    process: Any = None

    def ask(self, command: str) -> Any:
        """Send a line, and read the answer."""
        print(command, file=self.process.stdin, flush=True)
        return json.loads(self.process.stdout.readline())

    def time_one(self, point: list[float], count: int) -> float:
        """The time of one point among ``count`` [s]."""
        return self.ask(f"one {count}") / count

    def time_many(self) -> float:
        """The time of all points [s]."""
        return self.ask("many")


def pyfuzzylite() -> Engine:
    """Takagi-Sugeno engine that evaluates arrays with numpy 1, in an environment that is made for it."""
    folder = BUILD / "pyfuzzylite"
    python = folder / ("Scripts/python.exe" if os.name == "nt" else "bin/python")
    finished = folder / "finished"
    if not finished.exists():
        print("making an environment for pyfuzzylite 8, which needs numpy 1", file=sys.stderr)
        for command in (
            [sys.executable, "-m", "venv", "--clear", str(folder)],
            [str(python), "-m", "pip", "install", "--quiet", "numpy<2", "pyfuzzylite>=8,<9"],
        ):
            made = subprocess.run(command, capture_output=True, text=True)
            if made.returncode:
                last = (made.stderr.strip() or "no message").splitlines()[-1]
                raise ImportError(f"its environment cannot be installed ({last})")
        finished.touch()
    listed = "import importlib.metadata as m; print(m.version('pyfuzzylite'), 'with numpy', m.version('numpy'))"
    version = subprocess.run([str(python), "-c", listed], capture_output=True, text=True, check=True).stdout.strip()
    data = folder / "system.npz"
    np.savez(data, center=CENTER, sigma=SIGMA, consequent=CONSEQUENT, x=X)
    script = Path(__file__).with_name("fuzzylite8.py")
    process = subprocess.Popen(
        [str(python), str(script), str(data)], stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True
    )
    made_engine: Elsewhere

    def answers(x: np.ndarray) -> np.ndarray:
        return np.reshape(made_engine.ask("check")[: len(x)], (-1, 1))

    made_engine = Elsewhere(f"pyfuzzylite {version}", lambda _: made_engine.ask("check")[-1], answers, process=process)
    return made_engine


def ferrifuzz() -> Engine:
    """A Rust core behind Python, whose batches run on all processors."""
    import ferrifuzz as ff

    engine = ff.FuzzySystem(and_method="product", defuzz_method="weighted_average")
    for i in range(INPUTS):
        variable = ff.Variable(f"x{i}", -1, 1)
        for r in range(RULES):
            variable[f"t{r}"] = ff.mf.gaussian(CENTER[r, i], SIGMA[r, i])
        engine.add_input(variable)
    engine.add_output(ff.Variable("y", -10, 10))
    for r in range(RULES):
        *slopes, constant = CONSEQUENT[r].tolist()
        engine.add_consequent("y", f"f{r}", {f"x{i}": s for i, s in enumerate(slopes)}, bias=constant)
        engine.add_rule("IF " + " AND ".join(f"x{i} IS t{r}" for i in range(INPUTS)) + f" THEN y IS f{r}")

    def many(x: np.ndarray) -> np.ndarray:
        return np.reshape(engine.compute_batch({f"x{i}": x[:, i] for i in range(INPUTS)})["y"], (-1, 1))

    return Engine(f"ferrifuzz {_version('ferrifuzz')} (Rust)", engine.evaluate, many, threaded=True)


def torch_fis() -> Engine:
    """Tensor operations in float32."""
    import torch
    from fuzzy_torch import FuzzyRule, FuzzyVariable, GaussianMF, TSKConsequent, TSKSystem
    from fuzzy_torch.norm import Product

    inputs = [FuzzyVariable(f"x{i}", -1, 1) for i in range(INPUTS)]
    for i, variable in enumerate(inputs):
        for r in range(RULES):
            variable.add_term(f"t{r}", GaussianMF(CENTER[r, i], SIGMA[r, i]))
    rules = []
    for r in range(RULES):
        *slopes, constant = CONSEQUENT[r].tolist()
        coefficients = torch.tensor([constant, *slopes])
        consequent = TSKConsequent(order=1, coefficients=coefficients, normalize=False)
        rules.append(FuzzyRule([(v, f"t{r}") for v in inputs], consequent, t_norm=Product()))
    engine = TSKSystem(inputs=inputs, output=FuzzyVariable("y", -10, 10), rules=rules)

    def many(x: np.ndarray) -> np.ndarray:
        columns = torch.as_tensor(x, dtype=torch.float32)
        with torch.no_grad():
            return engine({f"x{i}": columns[:, i] for i in range(INPUTS)}).numpy().reshape(-1, 1)

    return Engine(
        f"torch-fis {_version('torch-fis')} (float32)",
        lambda point: many(np.array([point])),
        many,
        tolerance=1e-4,
        threaded=True,
        limit=torch.set_num_threads,
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

    return Engine(f"simpful {_version('simpful')}", one, lambda x: np.array([[one(p)] for p in x]), points=50)


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

    name = f"scikit-fuzzy {_version('scikit-fuzzy')} (Mamdani)"
    return Engine(name, one, lambda x: [one(point) for point in x], points=5, tolerance=None)


def _version(package: str) -> str:
    return versions([package])[package]


PEERS = (c_loop, exported_c, fuzzylite, pyfuzzylite, ferrifuzz, torch_fis, simpful, scikit_fuzzy)
