"""Why an interval type-2 system gives a result: the rules' firing intervals, and what each adds to both ends."""

import warnings
from dataclasses import replace
from typing import Any

import numpy as np

from fuzzy.inference import InferenceWarning, forgiving, within_universe
from fuzzy.insight.explanation import Explanation, explain
from fuzzy.plugins.type2.system import Type2Sugeno

_NEAR = 1e-9  # of an output's range: a rule that proposes an end moves it by neither bound


def explain_type2(fis: Type2Sugeno, x: Any) -> Explanation:
    """Evaluate a type-2 system at one point ``x`` (inputs,), and keep what led to the result.

    A rule's share is the mean of its shares in both ends of the type-reduced set, so that contributions sum to the
    output. The degrees are those of the clauses' upper bounds: of "not" from the lower function.

    Args:
        fis: The system.
        x: The point (inputs,), in the inputs' units.

    Returns:
        The explanation, in whose rows ``firing`` is the greatest firing strength and ``least`` the least one.

    Raises:
        FuzzySystemError: A point of the wrong shape.
    """
    fis = forgiving(fis)
    told = explain(fis.upper, x)
    with warnings.catch_warnings(action="ignore", category=InferenceWarning):
        found = fis.infer(told.x)
    takes_part = fis.upper.structure.consequent.T >= 0  # (rules, outputs), as all below
    least, most, proposed = found.lower[:, None], found.upper[:, None], found.rule_outputs
    near = _NEAR * np.array([v.span for v in fis.outputs])
    if fis.reduction == "nietan":
        ends = [(least + most) / 2]
    else:
        ends = [np.where(gap <= near, most, least) for gap in (proposed - found.low, found.high - proposed)]
    ends = [np.where(takes_part, end, 0.0) for end in ends]
    share = np.mean([end / np.where(end.sum(axis=0) > 0, end.sum(axis=0), 1.0) for end in ends], axis=0)
    share = np.where(takes_part, share, np.nan)
    lower = {
        v.name: {term: float(fis.degrees(v.name, term, value)[0]) for term in v.terms}
        for v, value in zip(fis.inputs, within_universe(fis.upper, np.array(told.x)), strict=True)
    }
    rows = tuple(
        replace(
            row,
            degrees=tuple(
                clause.degree(lower[clause.variable][clause.term]) if clause.negated else degree
                for clause, degree in zip(row.rule.when, row.degrees, strict=True)
            ),
            firing=float(found.upper[r]),
            least=float(found.lower[r]),
            share=tuple(share[r].tolist()),
            contribution=tuple((share[r] * proposed[r]).tolist()),
        )
        for r, row in enumerate(told.rows)
    )
    return replace(
        told,
        rows=rows,
        output=tuple(found.output.tolist()),
        fired=tuple(found.fired.tolist()),
        interval=tuple(zip(found.low.tolist(), found.high.tolist(), strict=True)),
    )
