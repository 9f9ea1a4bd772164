"""How fast is predictive control? Microseconds a period in the loop and a solve by itself, and IPOPT's beside it.

In the loop: an EtsRo on the sine with 3 mm of posture noise; a period is all that the law does in it, the look-up of
the reference included. By themselves: random problems, up to 0.5 m and 1 rad off, without an earlier plan. Every
period and every problem is done several times, and its least time counts: what else the machine does takes time from
some of them. Medians and 95th percentiles are over periods and problems; the load is that before and after.

Run ``python -m benchmarks.predictive [--json]``. IPOPT is left out where CasADi, the extra mpc, is not installed.
"""

import os
import time
from collections.abc import Callable, Iterator
from dataclasses import replace
from importlib.util import find_spec
from typing import Any

import numpy as np

from benchmarks.ipopt import Ipopt
from benchmarks.predictiveproblems import LAW, random_problems
from benchmarks.predictivesolving import plans_of, solve_rows
from benchmarks.reporting import heading, machine, start
from robotics.laws.equation import compiled
from robotics.plugins.predictive.ilqr import SolverColumns
from robotics.plugins.predictive.nmpc import PredictiveControl
from robotics.simulation.loop import Simulation
from robotics.simulation.scenario.reading import load_scenario
from robotics.simulation.scenario.robots import load_robot

REPEATS, PROBLEMS, IPOPT_PROBLEMS, SEEDS = 7, 300, 30, 3
AIM = 100.0  # us: of a solve at a horizon of 20 on a quiet core
LOOPS = {"real-time, 1 iteration": 1, "real-time, the default": PredictiveControl().iterations, "converged": 100}


def least_time(call: Callable[[], Any], prepare: Callable[[], Any]) -> float:
    """The least time [us] of several calls, each after its preparation."""
    times = []
    for _ in range(REPEATS):
        prepare()
        begin = time.perf_counter()
        call()
        times.append(time.perf_counter() - begin)
    return 1e6 * min(times)


def periods(law: PredictiveControl, seed: int) -> Iterator[tuple[float, float]]:
    """The time [us] and the iterations of every period of a run."""
    simulation = Simulation(load_scenario("lyapunov-sine").setting, law, (seed,))
    equation, lanes = compiled(type(law).equation), simulation.lanes
    before, memory, command, work = (array.copy() for array in (lanes.memory, lanes.memory, lanes.command, lanes.work))
    for k, _ in simulation.periods():
        known = lanes.known._replace(time=k * lanes.known.dt)

        def call(known: Any = known) -> None:
            equation(0, 1, known, memory, command, work)

        def prepare(memory: np.ndarray = memory, before: np.ndarray = before) -> None:
            memory[...] = before

        yield least_time(call, prepare), SolverColumns(work).count
        before[...] = lanes.memory


def summary(times: Any, iterations: Any) -> dict[str, float]:
    """Median and 95th percentile [us], and how many iterations there were."""
    each, counts = np.array(times, dtype=float), np.array(iterations, dtype=float)
    return {
        "median_us": float(np.median(each)),
        "p95_us": float(np.percentile(each, 95)),
        "iterations_median": float(np.median(counts)),
        "iterations_p95": float(np.percentile(counts, 95)),
    }


def cold(iterations: int) -> dict[str, float]:
    """Random problems by themselves, from the first guess."""
    problems = random_problems(PROBLEMS, 5, load_robot("etsro").robot)
    rows = np.array([problem.row for problem in problems])
    one, times, counts = rows[:1].copy(), [], []
    for row in rows:

        def prepare(row: np.ndarray = row) -> None:
            one[0] = row

        times.append(least_time(lambda: solve_rows(one, LAW.horizon, iterations, 1e-7), prepare))
        counts.append(SolverColumns(one[0]).count)
    return summary(times, counts)


def ipopt() -> dict[str, float] | None:
    """IPOPT's times [us] of random problems, from the same first guess; None: it is not there."""
    if find_spec("casadi") is None:
        return None
    problems = random_problems(IPOPT_PROBLEMS, 5, load_robot("etsro").robot)
    guess, solver = plans_of(problems, iterations=0), Ipopt(problems[0])
    times, counts = [], []
    for problem, states, commands in zip(problems, guess.states, guess.commands, strict=True):
        begin = time.perf_counter()
        solver.solve(problem, states, commands)
        times.append(1e6 * (time.perf_counter() - begin))
        counts.append(solver.solver.stats()["iter_count"])
    return summary(times, counts)


def measure() -> dict[str, Any]:
    """All numbers; times in microseconds."""
    load = [os.getloadavg()[0]]
    cases = {}
    for name, iterations in LOOPS.items():
        law = replace(PredictiveControl(), iterations=iterations)
        found = [pair for seed in range(SEEDS) for pair in periods(law, seed)]
        cases[f"in the loop, {name}"] = summary(*zip(*found, strict=True))
    cases["by itself, 3 iterations"] = cold(3)
    cases["by itself, converged"] = cold(100)
    other = ipopt()
    if other is not None:
        cases["by itself, IPOPT"] = other
    load.append(os.getloadavg()[0])
    return machine(["numba", "numpy", "casadi"]) | {"horizon": LAW.horizon, "load": load, "aim_us": AIM, "cases": cases}


def report(result: dict[str, Any]) -> str:
    """The numbers as a table."""
    lines = [
        heading(result),
        f"horizon {result['horizon']}; load {result['load'][0]:.1f} before and {result['load'][1]:.1f} after; "
        f"aim: {result['aim_us']:g} us",
        f"{'':42}{'median us':>12}{'95 % us':>12}{'iterations':>12}{'95 %':>8}",
    ]
    for name, case in result["cases"].items():
        times = f"{case['median_us']:12.1f}{case['p95_us']:12.1f}"
        lines.append(f"{name:42}{times}{case['iterations_median']:12.0f}{case['iterations_p95']:8.0f}")
    return "\n".join(lines)


if __name__ == "__main__":
    start(__doc__, measure, report)
