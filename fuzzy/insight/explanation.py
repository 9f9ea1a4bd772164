"""Why a system gives a result: what every rule contributes to it, as data and in words."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from fuzzy.detached import detached
from fuzzy.inference import firing_at, infer_quietly
from fuzzy.rule import Rule
from fuzzy.shown import shown
from fuzzy.system import FuzzySystemError, Sugeno, Variable


@dataclass(frozen=True)
class RuleShare:
    """The part of one rule in a result. Tuples over the outputs hold NaN for an output that the rule leaves out."""

    number: int  # the rule's place, from 1
    rule: Rule
    degrees: tuple[float, ...]  # of the clauses, in their order, after hedges and "not", in [0, 1]
    firing: float  # the firing strength, with the rule's weight
    share: tuple[float, ...]  # (outputs,): the part of the result, w / Σ w over the rules for that output
    proposed: tuple[float, ...]  # (outputs,): the consequent's value, in the output's unit
    contribution: tuple[float, ...]  # (outputs,): what the rule adds; they sum to the output where any rule fires
    least: float | None = None  # of an interval type-2 system the least firing strength; ``firing`` is the greatest


@dataclass(frozen=True)
class Explanation:
    """One evaluation and all that led to it. ``str()`` gives it in words, ``as_dict()`` as plain data.

    Attributes:
        system: The system that was asked.
        x: (inputs,): the point as it was given.
        memberships: (inputs,): each term's degree, by its name.
        rows: What each rule adds, in the order of the rules.
        output: (outputs,), in the outputs' units.
        fired: (outputs,): did any rule for that output fire?
        outside: The names of the inputs outside their universe.
        interval: (outputs,): of an interval type-2 system the ends of the type-reduced set; else empty.
    """

    system: Sugeno
    x: tuple[float, ...]
    memberships: tuple[Mapping[str, float], ...]
    rows: tuple[RuleShare, ...]
    output: tuple[float, ...]
    fired: tuple[bool, ...]
    outside: tuple[str, ...]
    interval: tuple[tuple[float, float], ...] = ()

    def as_dict(self) -> dict[str, Any]:
        """The explanation as dictionaries and lists, ready for JSON except that numbers may be NaN."""
        outputs = [v.name for v in self.system.outputs]
        inputs = [v.name for v in self.system.inputs]
        return {
            "system": self.system.name,
            "inputs": dict(zip(inputs, self.x, strict=True)),
            "outputs": dict(zip(outputs, self.output, strict=True)),
            "fired": dict(zip(outputs, self.fired, strict=True)),
            "outside": list(self.outside),
            "memberships": {name: dict(terms) for name, terms in zip(inputs, self.memberships, strict=True)},
            "rules": [
                {
                    "number": row.number,
                    "rule": str(row.rule),
                    "clauses": [
                        {"clause": str(clause), "degree": degree}
                        for clause, degree in zip(row.rule.when, row.degrees, strict=True)
                    ],
                    "firing": row.firing,
                    "share": dict(zip(outputs, row.share, strict=True)),
                    "proposed": dict(zip(outputs, row.proposed, strict=True)),
                    "contribution": dict(zip(outputs, row.contribution, strict=True)),
                }
                for row in self.rows
            ],
        }

    def __str__(self) -> str:
        return "\n".join([*self._inputs(), "", *self._rules(), "", *self._outputs()])

    def _inputs(self) -> list[str]:
        lines = []
        for variable, value, degrees in zip(self.system.inputs, self.x, self.memberships, strict=True):
            if np.isnan(value):
                lines.append(f"{variable.name} is not a number, so no result is one")
                continue
            line = f"{variable.name} = {_quantity(value, variable)}"
            terms = sorted(((d, t) for t, d in degrees.items() if d >= 0.005), key=lambda pair: -pair[0])
            line += " is " + (", ".join(f"{term} ({degree:.2f})" for degree, term in terms) or "none of its terms")
            if variable.name in self.outside:
                low, high = variable.universe
                line += f"; it lies outside [{shown(low)} {shown(high)}]"
                clipped = self.system.out_of_range == "clip"
                line += " and was moved to its edge" if clipped else ", where no rule is meant: do not trust the answer"
            lines.append(line)
        return lines

    def _rules(self) -> list[str]:
        # What rounds to nothing in every output is counted, not told.
        fires = [row for row in self.rows if row.firing > 0 or any(share > 0 for share in row.share)]
        fires.sort(key=lambda row: -max(_known(row.share), default=0.0))
        told = [row for row in fires if max(_known(row.share), default=0.0) >= 5e-4]
        if not fires:
            return [f"None of the {len(self.rows)} rules fires."]
        lines = [f"{len(fires)} of {len(self.rows)} rules {'fires' if len(fires) == 1 else 'fire'}:"]
        for row in told:
            least = "" if row.least is None else f"{_strength(row.least)} to "
            lines.append(f"  rule {row.number} fires {least}{_strength(row.firing)}: {row.rule}")
            clauses = [f"{clause} {degree:.2f}" for clause, degree in zip(row.rule.when, row.degrees, strict=True)]
            if len(clauses) > 1 or row.rule.weight != 1:
                weight = [f"weight {row.rule.weight:g}"] if row.rule.weight != 1 else []
                lines.append("    because " + ", ".join(clauses + weight))
            for variable, share, z, part in zip(
                self.system.outputs, row.share, row.proposed, row.contribution, strict=True
            ):
                if not np.isnan(z):
                    lines.append(
                        f"    proposes {variable.name} = {_quantity(z, variable)} with a share of {100 * share:.1f} %, "
                        f"which contributes {_quantity(part, variable)}"
                    )
        if len(fires) > len(told):
            rest = len(fires) - len(told)
            lines.append(f"  and {rest} more with less than 0.05 % of the result each")
        return lines

    def _outputs(self) -> list[str]:
        how = "the average of the proposals, weighted by firing strength"
        if self.system.defuzzification == "wtsum":
            how = "the sum of the proposals, weighted by firing strength"
        lines = []
        for j, (variable, value, fired) in enumerate(zip(self.system.outputs, self.output, self.fired, strict=True)):
            if self.interval:
                low, high = (_quantity(end, variable) for end in self.interval[j])
                how = f"the middle of the type-reduced set, {low} to {high}"
            line = f"{variable.name} = {_quantity(value, variable)}"
            if any(np.isnan(self.x)):
                line += ", because an input is not a number"
            elif fired:
                line += f": {how}"
            elif self.system.no_rule_fires == "midrange":
                line += ": no rule for it fires, so the middle of its range stands there"
            elif self.system.no_rule_fires == "nan":
                line += ": no rule for it fires"
            else:
                line += ": no rule for it fires, and the system is told to refuse such inputs"
            lines.append(line)
        return lines


def explain(fis: Sugeno, x: Any) -> Explanation:
    """Evaluate ``fis`` at one point ``x`` (inputs,) and keep what led to the result.

    Args:
        fis: The system.
        x: The point (inputs,), in the inputs' units.

    Returns:
        The explanation, which says also what :func:`fuzzy.inference.infer` would warn of.

    Raises:
        FuzzySystemError: A point of the wrong shape, and a point outside the universe if the system is told to
            refuse it.
    """
    fis = detached(fis)
    x = np.asarray(x, dtype=float)
    if x.shape != (len(fis.inputs),):
        names = ", ".join(v.name for v in fis.inputs)
        raise FuzzySystemError(
            f"{fis.name}: one point of {len(fis.inputs)} inputs ({names}) can be explained, got shape {x.shape}"
        )
    result = infer_quietly(fis, x)
    takes_part = fis.structure.consequent.T >= 0  # (rules, outputs)
    share = np.where(takes_part, result.weights[:, None], 0.0)
    total = share.sum(axis=0)
    share = share / np.where(total > 0, total, 1.0)
    parts = result.firing[:, None] if fis.defuzzification == "wtsum" else share
    share, proposed, contribution = (
        np.where(takes_part, values, np.nan) for values in (share, result.rule_outputs, parts * result.rule_outputs)
    )
    memberships = tuple(
        dict(zip(v.terms, degrees.tolist(), strict=True))
        for v, degrees in zip(fis.inputs, result.memberships, strict=True)
    )
    degrees = {v.name: terms for v, terms in zip(fis.inputs, memberships, strict=True)}
    rows = tuple(
        RuleShare(
            r + 1,
            rule,
            tuple(clause.degree(degrees[clause.variable][clause.term]) for clause in rule.when),
            float(result.firing[r]),
            tuple(share[r].tolist()),
            tuple(proposed[r].tolist()),
            tuple(contribution[r].tolist()),
        )
        for r, rule in enumerate(fis.rules)
    )
    outside = tuple(
        v.name
        for v, value in zip(fis.inputs, x.tolist(), strict=True)
        if value < v.universe[0] or value > v.universe[1]
    )
    return Explanation(
        fis, tuple(x.tolist()), memberships, rows, tuple(result.output.tolist()), tuple(result.fired.tolist()), outside
    )


def firing_strengths(fis: Sugeno, x: Any) -> np.ndarray:
    """The firing strengths (..., rules) of :func:`explain` at the points ``x`` (..., inputs), and no warnings.

    At a point of which an input is not a number they are not numbers. Raises FuzzySystemError for points of the wrong
    shape.
    """
    fis = detached(fis)
    x = np.asarray(x, dtype=float)
    return np.where(np.isnan(x).any(axis=-1, keepdims=True), np.nan, firing_at(fis, x))


def _known(values: tuple[float, ...]) -> list[float]:
    return [value for value in values if not np.isnan(value)]


def _strength(firing: float) -> str:
    return f"{firing:.2f}" if firing >= 0.005 or firing == 0 else f"{firing:.1e}"


def _quantity(value: float, variable: Variable) -> str:
    if np.isnan(value):
        return shown(value)
    return f"{shown(value, variable.span)} {variable.unit}".rstrip()
