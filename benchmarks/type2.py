"""How much longer does type-2 take than type-1? Compiled, one point and 10,000 points, on one processor.

Both take turns, so that a busy machine disturbs them alike; a number is the least of its rounds.

    python -m benchmarks.type2
"""

import time
from collections.abc import Callable
from typing import Any

import numpy as np

import fuzzy
from benchmarks.inference import system

ROUNDS, MANY = 200, 10_000


def least(calls: list[Callable[[], Any]], repeat: int) -> list[float]:
    """The least time [s] of one call of each, over rounds in which they take turns."""
    best = [np.inf] * len(calls)
    for _ in range(ROUNDS):
        for k, call in enumerate(calls):
            start = time.perf_counter()
            for _ in range(repeat):
                call()
            best[k] = min(best[k], (time.perf_counter() - start) / repeat)
    return best


def main() -> None:
    """Print a row a system."""
    systems = {"tipper": fuzzy.read_fis("fuzzy/examples/tipper.fis"), "8 rules, linear": system()}
    systems |= {name: fuzzy.read_fis(fuzzy.find_fis(name)) for name in ("tracking", "lateral")}
    print(
        "system                rules   one point: type-1, type-2 [us], ratio   many: type-1, type-2 [ns a point], ratio"
    )
    for name, fis in systems.items():
        low, high = np.array([v.universe for v in fis.inputs]).T
        x = np.random.default_rng(0).uniform(low, high, (MANY, len(fis.inputs)))
        both: list[Any] = [fuzzy.compile_sugeno(fis), fuzzy.compile_type2(fuzzy.to_type2(fis, 0.0, 0.8))]
        for compiled in both:
            compiled(x)
        one = least([lambda c=c, p=x[0]: c(p) for c in both], 20)  # type: ignore[misc]
        many = least([lambda c=c, p=x: c(p) for c in both], 1)  # type: ignore[misc]
        told = [f"{t * s:8.2f}" for t, s in zip((*one, *many), (1e6, 1e6, 1e9 / MANY, 1e9 / MANY), strict=True)]
        ratios = [f"{b / a:6.2f}" for a, b in (one, many)]
        print(f"{name:20} {len(fis.rules):6}   {told[0]} {told[1]} {ratios[0]}      {told[2]} {told[3]} {ratios[1]}")


if __name__ == "__main__":
    main()
