"""The problems of the learning benchmark: Jang's of 1993, and formation data.

Every engine starts from the same grid: bells whose neighbours cross at 0.5, and a rule for every combination.
"""

from dataclasses import dataclass
from itertools import product
from pathlib import Path

import numpy as np

import fuzzy
from benchmarks.mackeyglass import pairs
from fuzzy.files.table import read_table

JANG_RMSE = 0.0015  # checking error on Mackey-Glass after 500 epochs   [Jang 1993, section VI-D]
JANG_APE = (0.043, 1.066)  # %, training and checking, of the three-input function   [Jang 1993, section VI-B]


@dataclass(frozen=True, eq=False)
class Problem:
    """Data to learn from and to check with, and how many bells an input has."""

    name: str
    x: np.ndarray  # (samples, inputs)
    y: np.ndarray  # (samples,)
    check_x: np.ndarray  # the training data again where the source has no others
    check_y: np.ndarray
    bells: int
    epochs: int
    goal: float | None = None  # checking RMSE that Jang reports
    relative: bool = False  # are errors also given as Jang's APE, the mean of |y − ŷ|/|y| in %?

    @property
    def bounds(self) -> list[tuple[float, float]]:
        """Each input's range in the training data."""
        return list(zip(self.x.min(axis=0).tolist(), self.x.max(axis=0).tolist(), strict=True))

    @property
    def rules(self) -> int:
        """One for every combination."""
        return self.bells ** self.x.shape[1]

    def terms(self) -> list[list[tuple[float, float, float]]]:
        """Per input its bells (half-width, steepness, center)."""
        result = []
        for low, high in self.bounds:
            centers = np.linspace(low, high, self.bells)
            result.append([((high - low) / 2 / (self.bells - 1), 2.0, float(c)) for c in centers])
        return result


def grid(problem: Problem) -> fuzzy.Sugeno:
    """Where learning starts, in our own words; the last input varies fastest."""
    names = [f"mf{k + 1}" for k in range(problem.bells)]
    inputs = [
        fuzzy.Variable(f"in{i + 1}", bounds, dict(zip(names, (fuzzy.Bell(*b) for b in bells), strict=True)))
        for i, (bounds, bells) in enumerate(zip(problem.bounds, problem.terms(), strict=True))
    ]
    combinations = list(product(names, repeat=len(inputs)))
    proposals = {f"out1mf{r + 1}": fuzzy.Linear([0.0] * len(inputs), 0.0) for r in range(len(combinations))}
    rules = [
        fuzzy.Rule(tuple(fuzzy.Clause(v.name, mf) for v, mf in zip(inputs, c, strict=True)), (("out1", name),))
        for c, name in zip(combinations, proposals, strict=True)
    ]
    return fuzzy.Sugeno(
        inputs, [fuzzy.Variable("out1", (0, 2), proposals)], rules, name=problem.name, out_of_range="ignore"
    )


def mackey_glass() -> Problem:
    """500 pairs to learn from, 500 to check with; 16 rules, 104 parameters   [Jang 1993, section VI-D]."""
    x, y = pairs()
    return Problem("Mackey-Glass", x[:500], y[:500], x[500:], y[500:], 2, 500, goal=JANG_RMSE)


def sinc() -> Problem:
    """sin x/x · sin y/y at 121 points of [−10, 10]², four bells an input   [Jang 1993, section VI-A]."""
    x = np.stack(np.meshgrid(*[np.linspace(-10, 10, 11)] * 2, indexing="ij"), axis=-1).reshape(-1, 2)
    y = np.sinc(x / np.pi).prod(axis=1)
    return Problem("sinc", x, y, x, y, 4, 250)


def three_inputs() -> Problem:
    """(1 + √x + 1/y + z^−1.5)²: 216 points of [1, 6]³, 125 of [1.5, 5.5]³ to check   [Jang 1993, section VI-B]."""

    def points(low: float, high: float, count: int) -> tuple[np.ndarray, np.ndarray]:
        x = np.stack(np.meshgrid(*[np.linspace(low, high, count)] * 3, indexing="ij"), axis=-1).reshape(-1, 3)
        return x, (1 + x[:, 0] ** 0.5 + x[:, 1] ** -1 + x[:, 2] ** -1.5) ** 2

    return Problem("three inputs", *points(1, 6, 6), *points(1.5, 5.5, 5), 2, 200, relative=True)


def formation(kind: str, output: str = "w_l") -> Problem:
    """A formation set of ``datasets/``, one output [m/s or rad/s], two bells an input."""
    folder = Path(__file__).parents[1] / "datasets"
    tables = []
    for name in (f"formation-{kind}.csv", f"formation-{kind}-check.csv"):
        table = read_table(folder / name)
        names, values = table.names, table.values
        inputs = [k for k, column in enumerate(names) if column in ("x_l", "y_l", "theta_l", "dx", "alpha_l")]
        tables += [values[:, inputs], values[:, names.index(output)]]
    x, y, x_check, y_check = tables
    return Problem(f"formation, {kind}, {output}", x, y, x_check, y_check, 2, 60)


def problems() -> list[Problem]:
    """All of them."""
    return [mackey_glass(), sinc(), three_inputs(), formation("literal"), formation("well-posed")]
