"""How readable a rule base is, in numbers: its partitions, its rules, and the formula that they unfold to.

That a number is high is no reason to believe that a rule base is right, and no number says that names mean what people
take them for. They compare rule bases for one task, such as before and after training.
"""

from dataclasses import dataclass
from itertools import combinations

import numpy as np

from fuzzy.detached import detached
from fuzzy.insight.universe import universe_grid
from fuzzy.system import Linear, Sugeno, Variable

_POINTS = 2001  # of a universe, beside all corners


@dataclass(frozen=True)
class PartitionMeasures:
    """The terms of one input, over its universe; each measure is in [0, 1], and 1 is best.

    Attributes:
        variable: The input's name.
        terms: How many it has.
        coverage: The least over the universe of the greatest degree: every value is called something to this degree
            (ε-completeness).
        complementarity: 1 − mean of |Σ μ − 1|, not below 0: 1 where the degrees sum to 1 everywhere
            [Ruspini 1969].
        distinguishability: 1 − the greatest similarity ∫ min(μ, ν) / ∫ max(μ, ν) of two terms
            [Setnes et al. 1998].
        alike: The two terms of that similarity; empty where there are fewer than two.
        normality: The least over the terms of the greatest degree.
    """

    variable: str
    terms: int
    coverage: float
    complementarity: float
    distinguishability: float
    alike: tuple[str, ...]
    normality: float


@dataclass(frozen=True)
class Interpretability:
    """What :func:`interpretability` measures.

    Attributes:
        partitions: Of each input with terms.
        rules: The number of rules.
        conditions: The clauses of all rules.
        longest: The clauses of the longest rule.
        nauck: Nauck's index, in [0, 1] [Nauck 2003]: m / Σ conditions, m being the consequents that rules propose,
            times the mean over the inputs of ∫ ĥ / width, ĥ = Σ μ up to 1 and (n − Σ μ) / (n − 1) above it, times the
            mean of 1 / (n − 1), n being the number of an input's terms. It was made for classes; a consequent stands
            for one.
        operations: Of the formula written out, nothing shared: a degree for each clause, what joins them, the
            consequents, the weighted sums and the division of each output. It is a proxy for how long a person takes to
            work out an answer [Kohler et al. 2025].
    """

    partitions: tuple[PartitionMeasures, ...]
    rules: int
    conditions: int
    longest: int
    nauck: float
    operations: int

    def __str__(self) -> str:
        head = f"{'':16}{'terms':>6}{'coverage':>10}{'sum to 1':>10}{'distinct':>10}{'normal':>8}   most alike"
        rows = [
            f"{p.variable[:15]:16}{p.terms:6}{p.coverage:10.2f}{p.complementarity:10.2f}{p.distinguishability:10.2f}"
            f"{p.normality:8.2f}   {', '.join(p.alike) or '-'}"
            for p in self.partitions
        ]
        size = f"rules {self.rules}, conditions {self.conditions}, in the longest rule {self.longest}"
        return "\n".join([head, *rows, f"{size}, operations {self.operations}, Nauck's index {self.nauck:.3g}"])


def interpretability(fis: Sugeno) -> Interpretability:
    """Measure how readable ``fis`` is; see :class:`Interpretability` for each measure and its source.

    Args:
        fis: The system; its parameters may be in training.

    Returns:
        The measures; ``print`` shows them as a table.
    """
    fis = detached(fis)
    inputs = [variable for variable in fis.inputs if len(variable.terms)]
    degrees = [_degrees(variable) for variable in inputs]
    clauses = [len(rule.when) for rule in fis.rules]
    proposed = {pair for rule in fis.rules for pair in rule.then}
    complexity = min(1.0, len(proposed) / sum(clauses)) if clauses else 0.0
    parts = [(_covered(x, mu), 1 / max(1, len(mu) - 1)) for x, mu in degrees]
    covered, split = np.mean(parts, axis=0) if parts else (0.0, 0.0)
    return Interpretability(
        tuple(_partition(v, x, mu) for v, (x, mu) in zip(inputs, degrees, strict=True)),
        len(clauses),
        sum(clauses),
        max(clauses, default=0),
        float(complexity * covered * split),
        _operations(fis),
    )


def _degrees(variable: Variable) -> tuple[np.ndarray, np.ndarray]:
    """Places of the universe (places,) and the degrees there (terms, places)."""
    x = universe_grid(variable, _POINTS)
    return x, np.array([np.asarray(function(x), dtype=float) for function in variable.terms.values()])


def _partition(variable: Variable, x: np.ndarray, degrees: np.ndarray) -> PartitionMeasures:
    width = x[-1] - x[0]
    off = np.trapezoid(np.abs(degrees.sum(axis=0) - 1), x) / width
    similar = {
        (a, b): np.trapezoid(np.minimum(degrees[a], degrees[b]), x)
        / (np.trapezoid(np.maximum(degrees[a], degrees[b]), x) or np.inf)
        for a, b in combinations(range(len(degrees)), 2)
    }
    names, alike = list(variable.terms), max(similar, key=similar.__getitem__, default=())
    return PartitionMeasures(
        variable.name,
        len(names),
        float(degrees.max(axis=0).min()),
        float(max(0.0, 1 - off)),
        1 - float(similar[alike]) if alike else 1.0,
        tuple(names[n] for n in alike),
        float(degrees.max(axis=1).min()),
    )


def _covered(x: np.ndarray, degrees: np.ndarray) -> float:
    total, n = degrees.sum(axis=0), len(degrees)
    beyond = (n - total) / (n - 1) if n > 1 else total
    return float(np.trapezoid(np.where(total <= 1, total, beyond), x) / (x[-1] - x[0]))


def _operations(fis: Sugeno) -> int:
    outputs = {variable.name: variable.terms for variable in fis.outputs}
    count = len(outputs)  # divisions by the sum of the firing strengths
    for rule in fis.rules:
        # A degree for each clause, what "not" and hedges make of it, and what joins them; then the weight.
        count += sum(1 + clause.negated + (clause.power != 1) for clause in rule.when) + len(rule.when) - 1
        count += rule.weight != 1
        for output, name in rule.then:
            term = outputs[output][name]
            slopes = sum(slope != 0 for slope in term.slopes) if isinstance(term, Linear) else 0
            count += 2 * slopes + 3  # the plane; the product with the firing strength, and two sums
    return count
