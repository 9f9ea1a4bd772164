"""Random type-2 systems of few rules, whose firing strengths are computed here once more, by other code."""

from itertools import product
from typing import Any

import numpy as np

import fuzzy


def drawn(rng: np.random.Generator, gaussian: bool = True) -> fuzzy.Type2Sugeno:
    """A system of two inputs and one output, "and" the product: triangles, and Gaussians without a lag."""
    inputs: list[fuzzy.Variable] = []
    lower: dict[str, dict[str, fuzzy.Lower]] = {}
    for name in ("x", "y"):
        terms: dict[str, Any] = {}
        lower[name] = {}
        for t in range(rng.integers(2, 5)):
            scale, lag = rng.uniform(0.2, 1), rng.uniform(0, 0.6, 2)
            if gaussian and rng.random() < 0.4:
                terms[f"t{t}"], lag = fuzzy.Gaussian(rng.uniform(0.5, 2), rng.uniform(0, 10)), np.zeros(2)
            else:
                terms[f"t{t}"] = fuzzy.Triangle(*np.sort(rng.uniform(-5, 15, 3)))
            lower[name][f"t{t}"] = fuzzy.Lower(scale, tuple(lag))
        inputs.append(fuzzy.Variable(name, (0, 10), terms))
    count = rng.integers(2, 9)
    consequents = {f"c{r}": fuzzy.Linear(rng.uniform(-1, 1, 2).tolist(), rng.uniform(-5, 5)) for r in range(count)}
    pairs = list(product(inputs[0].terms, inputs[1].terms))
    chosen = rng.permutation(len(pairs))[:count]
    rules = [f"if x is {pairs[k][0]} and y is {pairs[k][1]} then z is c{r}" for r, k in enumerate(chosen)]
    output = fuzzy.Variable("z", (-20, 20), consequents)
    return fuzzy.Type2Sugeno(fuzzy.Sugeno(inputs, [output], rules, out_of_range="ignore"), lower)


def lower_triangle(function: fuzzy.Triangle, lower: fuzzy.Lower, x: float) -> float:
    """The lower degree of a triangle: another triangle, whose feet are where the upper one reaches the lags."""
    (left, right), (a, b, c) = lower.lag, function.numbers
    foot = (a + left * (b - a), c - right * (c - b))
    return lower.scale * float(np.interp(x, [foot[0], b, foot[1]], [0, 1, 0]))


def bounds(fis: fuzzy.Type2Sugeno, x: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Least and greatest firing strengths and proposals (rules,) at one point, rule by rule in scalars."""
    least, most, proposed = [], [], []
    for rule in fis.rules:
        low = high = 1.0
        for clause in rule.when:
            place = ["x", "y"].index(clause.variable)
            function, lower = fis.inputs[place].terms[clause.term], fis.lower[clause.variable][clause.term]
            if isinstance(function, fuzzy.Gaussian):
                degree = float(np.exp(-0.5 * ((x[place] - function.c) / function.sigma) ** 2))
                low, high = low * lower.scale * degree, high * degree
            else:
                a, b, c = function.numbers
                low *= lower_triangle(function, lower, x[place])
                high *= float(np.interp(x[place], [a, b, c], [0, 1, 0]))
        consequent = fis.outputs[0].terms[rule.then[0][1]]
        least.append(low)
        most.append(high)
        proposed.append(float(np.dot(consequent.slopes, x)) + consequent.constant)
    return np.array(least), np.array(most), np.array(proposed)
