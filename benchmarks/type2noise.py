"""Does type-2 help under noise? Two rule bases with ten tuned numbers each, tuned alike, on paths that neither saw.

Both steer by the cross-track error y_e and the heading error ψ_e, each with three terms, and four constants of the turn
rate; forwards they drive alike. They begin as the same rule base. Beyond the width a of its terms, of each error

- type-1 moves the shoulder of the middle term and the foot of the outer ones (as shares of a),
- type-2 moves the scale of the lower functions of both (the lag stays 0), reduced as Karnik and Mendel do.

For every cell (noise, latency, raw or filtered) each is tuned by CMA-ES with the same evaluations, seeds and paths, and
then driven on other paths with other seeds. Told is the ratio of the cost, type-2 by type-1, with a 95 % interval over
these paths (Student's t on its logarithm): a path is one number, the mean over seeds and, of logarithms, searches.

    python -m benchmarks.type2noise --seed 1 -o table.json
    python -m benchmarks.type2noise --seed 2 -o table.json   # adds a second search to each cell
    python -m benchmarks.type2noise --paths 3 --runs 2 -o few.json
"""

import argparse
import json
import math
from collections import namedtuple
from dataclasses import dataclass
from itertools import product
from pathlib import Path
from typing import Any

import numpy as np
from scipy.stats import t as student

import fuzzy
from fuzzy.compiled.jit import kernel
from fuzzy.quantity import quantity
from robotics.laws.equation import EquationLaw, equation
from robotics.simulation.scenario.description import Scenario
from robotics.simulation.scenario.reading import parse_scenario
from robotics.studies.tuning.cost import Cost, costs_of
from robotics.studies.tuning.space import Bound, LawSpace
from robotics.studies.tuning.tune import TESTING, tune
from robotics.world.paths.posture import wrapped_compiled

NOISES, LATENCIES, FILTERS = (0.0, 0.003, 0.010), (0.0, 0.05, 0.1), ("raw", "filtered")  # m and rad; s
PATHS_UNSEEN, SEEDS_UNSEEN = 16, 4


@kernel(nogil=True)
def type_1(e: float, a: float, shoulder: float, foot: float) -> tuple[float, float]:
    """The degrees of the middle term and of the outer one on the side of an error e."""
    share = abs(e) / a
    middle = (1.0 - share) / (1.0 - shoulder)
    outer = (share - foot) / (1.0 - foot)
    return min(max(middle, 0.0), 1.0), min(max(outer, 0.0), 1.0)


@kernel(nogil=True)
def end(z: Any, least: Any, most: Any, sign: float) -> float:
    """An end of the type-reduced set of four rules; ``sign`` 1: the lower one, -1: the upper one."""
    a = b = 0.0
    for r in range(4):
        mean = (least[r] + most[r]) / 2.0
        a, b = a + z[r] * mean, b + mean
    best, better = a / b, True
    while better:
        a = b = 0.0
        for r in range(4):
            w = most[r] if sign * (z[r] - best) < 0.0 else least[r]
            a, b = a + (z[r] - best) * w, b + w
        new = best + (a / b if b > 0.0 else 0.0)
        better = sign * (new - best) < 0.0
        best = new if better else best
    return best


@kernel(nogil=True)
def turn(kind: float, y: float, psi: float, gain: Any) -> float:
    """The turn rate [rad/s] beyond the reference's."""
    to_y, to_psi = math.copysign(1.0, y), math.copysign(1.0, psi)
    both = gain.same if to_y == to_psi else gain.against
    z = (0.0, to_psi * gain.by_psi, to_y * gain.by_y, to_y * both)
    if kind == 1.0:
        y_0, y_1 = type_1(y, gain.a_y, gain.p_y, gain.q_y)
        psi_0, psi_1 = type_1(psi, gain.a_psi, gain.p_psi, gain.q_psi)
        w = (y_0 * psi_0, y_0 * psi_1, y_1 * psi_0, y_1 * psi_1)
        total = w[0] + w[1] + w[2] + w[3]
        return (w[1] * z[1] + w[2] * z[2] + w[3] * z[3]) / total if total > 0.0 else 0.0
    y_0, y_1 = type_1(y, gain.a_y, 0.0, 0.0)
    psi_0, psi_1 = type_1(psi, gain.a_psi, 0.0, 0.0)
    most = (y_0 * psi_0, y_0 * psi_1, y_1 * psi_0, y_1 * psi_1)
    s, t = (1.0 - gain.p_y, 1.0 - gain.q_y), (1.0 - gain.p_psi, 1.0 - gain.q_psi)
    least = (most[0] * s[0] * t[0], most[1] * s[0] * t[1], most[2] * s[1] * t[0], most[3] * s[1] * t[1])
    return (end(z, least, most, 1.0) + end(z, least, most, -1.0)) / 2.0


@equation
def steer(robot, aim, gain):  # type: ignore[no-untyped-def]
    """Follow by the rules."""
    dx, dy = aim.x - robot.x, aim.y - robot.y
    cos, sin = math.cos(robot.heading), math.sin(robot.heading)
    x_e, y_e = cos * dx + sin * dy, cos * dy - sin * dx
    psi_e = wrapped_compiled(aim.heading - robot.heading)
    return aim.v * math.cos(psi_e) + 1.5 * x_e, aim.w + turn(gain.kind, y_e, psi_e, gain)


@dataclass(frozen=True, kw_only=True)
class Rules(EquationLaw):
    """Three terms an error, four constants; ``kind`` 1 or 2. Of type-2 p and q are 1 - scale of the lower functions."""

    kind: float = 1.0
    a_y: float = quantity(0.2, "m", above=0)
    p_y: float = quantity(0.05, "1", least=0)  # the shoulder of the middle term, as a share of a
    q_y: float = quantity(0.05, "1", least=0)  # the foot of the outer ones
    a_psi: float = quantity(0.5, "rad", above=0)
    p_psi: float = quantity(0.05, "1", least=0)
    q_psi: float = quantity(0.05, "1", least=0)
    by_y: float = quantity(1.0, "rad/s")  # y_e outer, ψ_e middle
    by_psi: float = quantity(1.5, "rad/s")  # y_e middle, ψ_e outer
    same: float = quantity(2.5, "rad/s")  # both outer, to the same side
    against: float = quantity(-0.5, "rad/s")  # both outer, to opposite sides; to the side of y_e

    equation = steer


BOUNDS = {
    "a_y": Bound(low=0.02, high=1.0, scale="log"),
    "a_psi": Bound(low=0.05, high=1.5, scale="log"),
    **{name: Bound(low=0.0, high=0.95) for name in ("p_y", "q_y", "p_psi", "q_psi")},
    **{name: Bound(low=0.0, high=6.0) for name in ("by_y", "by_psi", "same")},
    "against": Bound(low=-4.0, high=4.0),
}


Gains: Any = namedtuple("Gains", [*BOUNDS])  # type: ignore[misc]  # the law's, as compiled code reads them


def check() -> None:
    """The law's rules are those of a system: AssertionError where they answer otherwise."""
    rng = np.random.default_rng(0)
    table = {"on on": "0", "on left": "p", "left on": "y", "left left": "s", "left right": "a"}
    table |= {"on right": "-p", "right on": "-y", "right right": "-s", "right left": "-a"}
    rules = [f"if y is {k.split()[0]} and psi is {k.split()[1]} then u is {v}" for k, v in table.items()]
    for number in range(20):
        kind = 1 + number % 2
        law: Any = Gains(**{name: float(rng.uniform(max(b.low, 0.01), min(b.high, 0.9))) for name, b in BOUNDS.items()})
        sides, scale = {}, {}
        for name, a, p, q in (("y", law.a_y, law.p_y, law.q_y), ("psi", law.a_psi, law.p_psi, law.q_psi)):
            scale[name] = {"on": 1 - p, "left": 1 - q, "right": 1 - q}
            p, q = (p * a, q * a) if kind == 1 else (0.0, 0.0)
            on, left, right = fuzzy.Trapezoid(-a, -p, p, a), fuzzy.LinearS(q, a), fuzzy.LinearZ(-a, -q)
            sides[name] = fuzzy.Variable(name, (-3, 3), {"right": right, "on": on, "left": left})
        values = {"0": 0, "p": law.by_psi, "y": law.by_y, "s": law.same, "a": law.against}
        values |= {f"-{name}": -value for name, value in values.items()}
        fis = fuzzy.Sugeno([*sides.values()], [fuzzy.Variable("u", (-9, 9), values)], rules)
        x = rng.uniform(-1.2, 1.2, (50, 2))
        answers = (fis if kind == 1 else fuzzy.to_type2(fis, 0.0, scale))(x)[:, 0]
        assert np.allclose(answers, [turn(float(kind), *row, law) for row in x.tolist()], atol=1e-12)


def scenarios(count: int, seed: int, noise: float, latency: float, filtered: str) -> list[Scenario]:
    """Sines with random height, length, speed and start."""
    rng, found = np.random.default_rng(seed), []
    for number in range(count):
        amplitude, wave, rate = rng.uniform(0.2, 1.0), rng.uniform(0.6, 1.6), rng.uniform(0.12, 0.3)
        aside, turned = rng.uniform(-0.3, 0.3), rng.uniform(-0.5, 0.5)
        text = f"""
title = "{number}"
source = "random"
duration = 18.0
latency = {latency}
[sensing]
posture = "pose"
position_noise = {noise}
heading_noise = {noise}
{'estimator = "kalman"' if filtered == "filtered" else ""}
[[robots]]
start = [0.0, {aside}, {turned}]
path = {{ shape = "sine", amplitude = {amplitude}, wavenumber = {wave}, x_end = 8.0 }}
timing = {{ x_rate = {rate} }}
"""
        found.append(parse_scenario(text, f"sine-{seed}-{number}"))
    return found


def tuned(kind: int, cell: tuple[float, float, str], options: argparse.Namespace) -> Any:
    """The law that a search finds in a cell."""
    space = LawSpace(Rules(kind=float(kind)), ("gains",), gains=list(BOUNDS), bounds=BOUNDS)
    paths = scenarios(options.paths, 1, *cell)
    return tune(space, paths, runs=options.runs, evaluations=options.evaluations, seed=options.seed)


def measured(cell: tuple[float, float, str], options: argparse.Namespace) -> dict[str, Any]:
    """One search of each kind in a cell, and what each costs on the paths that were not tuned on."""
    found = [tuned(kind, cell, options) for kind in (1, 2)]
    unseen = scenarios(PATHS_UNSEEN, 2, *cell)
    seeds = range(TESTING, TESTING + SEEDS_UNSEEN)
    costs = costs_of(Cost(), unseen, [each.law for each in found], seeds).sum(axis=-1)
    return {
        "seed": options.seed,
        "tuned": [round(each.after, 4) for each in found],
        "unseen": costs.mean(axis=-1).round(4).tolist(),
        "failed": (costs >= Cost().failed).sum(axis=(1, 2)).tolist(),
        "laws": [{name: round(getattr(each.law, name), 4) for name in BOUNDS} for each in found],
    }


def summary(searches: list[dict[str, Any]]) -> dict[str, float]:
    """The geometric mean costs of a cell on unseen paths, their ratio with its 95 % interval over these, failures."""
    one, two = np.log([each["unseen"] for each in searches]).mean(axis=0)  # (paths,)
    apart = two - one
    half = student.ppf(0.975, len(apart) - 1) * apart.std(ddof=1) / math.sqrt(len(apart))
    ends = {"ratio": apart.mean(), "low": apart.mean() - half, "high": apart.mean() + half}
    found = {
        name: round(math.exp(value), 4) for name, value in {"type_1": one.mean(), "type_2": two.mean(), **ends}.items()
    }
    return found | {f"failed_{kind}": sum(each["failed"][kind - 1] for each in searches) for kind in (1, 2)}


def main() -> None:
    """Search in all cells, and write what is known after each; another seed's searches are added to the file."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").partition("\n")[0])
    parser.add_argument("--evaluations", type=int, default=1000)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--paths", type=int, default=12, help="that are tuned on")
    parser.add_argument("--runs", type=int, default=1, help="on each of them")
    parser.add_argument("-o", "--output", type=Path, default=Path("type2noise.json"))
    options = parser.parse_args()
    check()
    known = json.loads(options.output.read_text(encoding="utf-8"))["cells"] if options.output.exists() else []
    cells = {(each["noise_m"], each["latency_s"], each["pose"]): each for each in known}
    for cell in sorted(product(NOISES, LATENCIES, FILTERS), key=lambda cell: (cell[1] == LATENCIES[1], cell[0] == 0)):
        row = cells.setdefault(cell, dict(zip(("noise_m", "latency_s", "pose"), cell, strict=True)) | {"searches": []})
        row["searches"].append(measured(cell, options))
        row |= summary(row["searches"])
        print(*cell, {name: value for name, value in row.items() if name != "searches"}, flush=True)
        said = {name: getattr(options, name) for name in ("evaluations", "paths", "runs")}
        said |= {"cells": [cells[each] for each in sorted(cells)]}
        options.output.write_text(json.dumps(said) + "\n", encoding="utf-8")


if __name__ == "__main__":
    main()
