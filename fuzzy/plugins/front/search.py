"""Accuracy against size: rules are searched for by NSGA-II, from samples and nothing else.

A candidate says how many Gaussian terms each input has (a grid's: in order, neighbours cross at 0.5), which term of
which inputs each rule asks for, and whether consequents are constant or linear. Consequents follow by least squares,
so the two objectives are the cross-validated error and the number of operations of the formula written out
(:class:`fuzzy.Interpretability`). This is the multi-objective search for rules of [Ishibuchi & Nojima 2007] by NSGA-II
[Deb et al. 2002], for a Sugeno system instead of a classifier.
"""

import warnings
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from fuzzy.extras import needed
from fuzzy.fitting.clustering import DataWarning
from fuzzy.fitting.consequents import IdentificationError, fit_consequents
from fuzzy.fitting.folds import FoldOrder, fold_rows
from fuzzy.fitting.identification import Partition, checked, system_of
from fuzzy.fitting.selection import held_back_error
from fuzzy.fitting.termnames import with_telling_names
from fuzzy.insight.interpretability import interpretability
from fuzzy.plugins.front.space import Candidate, RuleSpace
from fuzzy.system import Sugeno


@dataclass(frozen=True)
class RuleFrontPoint:
    """A system that no other one found beats in both error and size.

    Attributes:
        system: It, with consequents fitted to all samples. Inputs that no rule asks for are none of its inputs.
        rules: The number of rules.
        conditions: The clauses of all rules.
        operations: Of the formula written out, as :class:`fuzzy.Interpretability` counts them.
        error: The cross-validated error: RMSE over samples and outputs, each output in units of its own spread, which
            has no unit.
        deviation: Its standard error over the folds, without a unit.
    """

    system: Sugeno
    rules: int
    conditions: int
    operations: int
    error: float
    deviation: float


@dataclass(frozen=True)
class RuleFront:
    """What :func:`search_rules` finds.

    Attributes:
        points: From few operations to many; each errs less than those before it.
        chosen: The place of the smallest whose error is within one standard error of the least.
        evaluated: How many different candidates were judged.
    """

    points: tuple[RuleFrontPoint, ...]
    chosen: int
    evaluated: int

    def table(self) -> Any:
        """The points as a pandas table: rules, conditions, operations, inputs, error, deviation."""
        import pandas as pd

        rows = [
            (p.rules, p.conditions, p.operations, " ".join(v.name for v in p.system.inputs), p.error, p.deviation)
            for p in self.points
        ]
        return pd.DataFrame(rows, columns=["rules", "conditions", "operations", "inputs", "error", "deviation"])


def search_rules(
    x: Any,
    y: Any,
    *,
    rules: int = 8,
    terms: Sequence[int] = (2, 3, 5),
    orders: Sequence[int] = (0, 1),
    ridge: float = 1e-4,
    folds: int = 5,
    fold_order: FoldOrder | str = "shuffled",
    generations: int = 100,
    seed: int = 0,
    progress: Callable[[int, int], None] | None = None,
    **names: Any,
) -> RuleFront:
    """Search for rules, and keep those systems that are exact for their size.

    Errors are of samples held back, but the rules were chosen by them: of samples that nobody has looked at the error
    is somewhat larger (hold some back to know by how much).

    Args:
        x: The inputs (samples, inputs), in any units.
        y: The outputs (samples,) or (samples, outputs), in any units.
        rules: The most rules.
        terms: How many terms an input may have, each at least 2.
        orders: Which consequents are tried: 0 constants, 1 linear in the inputs that a system asks for.
        ridge: As of :func:`fuzzy.fit_consequents`, above 0.
        folds: Number of folds.
        fold_order: Which rows a fold holds back, "shuffled" or "blocks" (for time series).
        generations: Of 60 candidates each.
        seed: Of folds and search: the same seed gives the same front.
        progress: Called with the generations that are done, and all of them.
        names: Names and units, as of :func:`fuzzy.identify`.

    Returns:
        The front.

    Raises:
        ClusteringError: Data that are not finite.
        IdentificationError: Shapes that do not fit, settings out of their range, or no rule that fits.
        FoldError: Folds that cannot be made.
        MissingPackageError: Without the package pymoo.
    """
    data = checked(x, y, **names)
    for value, least, what in ((rules, 1, "rules"), (generations, 1, "generations")):
        if isinstance(value, bool) or not isinstance(value, (int, np.integer)) or value < least:
            raise IdentificationError(f"{what} must be a whole number >= {least}, got {value!r}")
    if not terms or min(terms) < 2:
        raise IdentificationError(f"terms must be whole numbers >= 2, got {min(terms, default='none')}")
    if not orders or set(orders) - {0, 1}:
        raise IdentificationError(f"orders must be of 0 (constants) and 1 (linear), got {tuple(orders)!r}")
    if not ridge > 0:
        raise IdentificationError(f"ridge must be a number > 0, got {ridge!r}")
    held = fold_rows(len(data.x), folds, fold_order, seed)
    space = RuleSpace(data, tuple(terms), tuple(orders), rules, ridge, held)
    needed("pymoo", "the search for a front")
    from fuzzy.plugins.front.evolution import evolved

    found = {space.candidate(genes) for genes in evolved(space, generations, seed, progress)}
    judged = [p for candidate in sorted(found) if candidate.rules and (p := point_of(space, candidate))]
    points: list[RuleFrontPoint] = []
    for point in sorted(judged, key=lambda p: (p.operations, p.error)):
        if not points or point.error < points[-1].error:
            points.append(point)
    if not points:
        raise IdentificationError("no rule fits the samples: give more samples, or other settings")
    limit = points[-1].error + points[-1].deviation
    return RuleFront(tuple(points), next(k for k, p in enumerate(points) if p.error <= limit), len(space.known))


def point_of(space: RuleSpace, candidate: Candidate) -> RuleFrontPoint | None:
    """The system itself, judged by fits of its own; None where one of them fails."""
    data, taken = space.data, list(candidate.inputs)
    columns = [*taken, *range(len(data.inputs), len(data.low))]
    own = data._replace(
        x=data.x[:, taken], low=data.low[columns], high=data.high[columns], inputs=[data.inputs[i] for i in taken]
    )
    functions = [space.functions[i, candidate.terms[i]] if candidate.terms[i] else [] for i in taken]
    rules = [tuple(rule[i] for i in taken) for rule in candidate.rules]
    draft = system_of(Partition(functions, rules, "mf"), own, "front", candidate.order)
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", DataWarning)
        errors = held_back_error(own.x, space.y, space.held, lambda x, y: fit_consequents(draft, x, y, space.ridge))
        if errors is None:
            return None
        system = with_telling_names(fit_consequents(draft, own.x, own.y, space.ridge))
    size = interpretability(system)
    return RuleFrontPoint(system, size.rules, size.conditions, size.operations, *errors)
