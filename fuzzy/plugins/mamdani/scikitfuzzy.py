"""scikit-fuzzy's control systems as Sugeno systems, with what was changed and how far the outputs are apart.

found = from_skfuzzy(control_system)
fuzzy.write_fis(found.system, "tip.fis")
print(*found.changes, *found.difference, sep="\\n")
"""

import warnings
from collections.abc import Callable, Mapping, Sequence
from typing import Any, NamedTuple

import numpy as np

from fuzzy.extras import needed
from fuzzy.plugins.mamdani.likeness import Difference, differences, input_grid
from fuzzy.plugins.mamdani.sampled import EXACT, recognise
from fuzzy.plugins.mamdani.system import Mamdani
from fuzzy.rule import Clause, Rule
from fuzzy.system import FuzzySystemError, Sugeno, Terms, Variable

_COMPARED = 256  # points; scikit-fuzzy evaluates one at a time
_MOST_RULES = 1000  # of one with brackets, split up


class FromScikitFuzzy(NamedTuple):
    """A control system of scikit-fuzzy as a Sugeno system.

    Attributes:
        system: The Sugeno system.
        original: The same sets, rules and methods as scikit-fuzzy's.
        changes: What became another thing, a sentence each.
        difference: Of the Sugeno system from scikit-fuzzy's own outputs, an output each.
    """

    system: Sugeno
    original: Mamdani
    changes: tuple[str, ...]
    difference: tuple[Difference, ...]


def from_skfuzzy(control_system: Any) -> FromScikitFuzzy:
    """Make a Sugeno system of a control system of scikit-fuzzy.

    Sampled memberships become the functions that they were sampled from, or the nearest, which is told with its error.
    Each output set becomes a constant at its centroid. A rule with brackets becomes several, which is exact for min and
    max.

    Args:
        control_system: A ``skfuzzy.control.ControlSystem``.

    Returns:
        The system, the Mamdani system that it comes from, what was changed, and how far both are apart.

    Raises:
        FuzzySystemError: What has no equivalent, by the name of the rule or the variable: other functions for "and" and
            "or", brackets with these, a variable twice in one "and", an output that is another rule's input.
    """
    control = needed("skfuzzy.control", "from_skfuzzy", "scikit-fuzzy")
    if not isinstance(control_system, control.ControlSystem):
        raise FuzzySystemError(f"expected a skfuzzy.control.ControlSystem, got {type(control_system).__name__}")
    changes: list[str] = []
    inputs, outputs = (
        [_variable(v, changes) for v in sorted(found, key=lambda v: str(v.label))]
        for found in (control_system.antecedents, control_system.consequents)
    )
    if not inputs or not outputs:
        raise FuzzySystemError("a control system needs a rule with an antecedent and a consequent")
    both = {v.name for v in inputs} & {v.name for v in outputs}
    if both:
        raise FuzzySystemError(f"{', '.join(sorted(both))}: an output that other rules ask for has no equivalent")
    rules, conjunctions, disjunctions = [], set(), set()
    for number, rule in enumerate(control_system.rules, start=1):
        made, connectives = _rules(rule, f"rule {number}", changes)
        rules += made
        if "and" in connectives:
            conjunctions.add(_method(rule.and_func, f"rule {number}: and_func", {0.3: "min", 0.18: "prod"}))
        if "or" in connectives:
            disjunctions.add(_method(rule.or_func, f"rule {number}: or_func", {0.6: "max", 0.72: "probor"}))
    for what, found in (("and_func", conjunctions), ("or_func", disjunctions)):
        if len(found) > 1:
            raise FuzzySystemError(
                f"all rules need the same {what}, but these rules have {' and '.join(sorted(found))}"
            )
    settings: dict[str, Any] = {
        "and_method": next(iter(conjunctions), "min"),
        "or_method": next(iter(disjunctions), "max"),
        "defuzzification": _same("defuzzify_method", [str(v.defuzzify_method) for v in control_system.consequents]),
        "aggregation": _same("accumulation_method", [_accumulation(v) for v in control_system.consequents]),
    }
    if settings["aggregation"] != "max":
        changes.append("scikit-fuzzy accumulates the degrees of each term; here the sets of rules are joined instead")
    original = Mamdani(inputs, outputs, rules, "scikit-fuzzy", **settings)
    system, said = original.as_sugeno()
    x = input_grid(inputs, _COMPARED)
    reference = _simulated(control, control_system, [v.name for v in inputs], [v.name for v in outputs])
    return FromScikitFuzzy(system, original, (*changes, *said), differences(system, reference, x))


def _simulated(
    control: Any, system: Any, inputs: Sequence[str], outputs: Sequence[str]
) -> Callable[[np.ndarray], np.ndarray]:
    """scikit-fuzzy's own outputs at places (points, inputs); not-a-number where it has none."""

    def at(x: np.ndarray) -> np.ndarray:
        simulation = control.ControlSystemSimulation(system, cache=False)
        found = np.full((len(x), len(outputs)), np.nan)
        for row, point in zip(found, x, strict=True):
            for name, value in zip(inputs, point, strict=True):
                simulation.input[name] = float(value)
            try:
                # What scikit-fuzzy uses of numpy is deprecated
                with warnings.catch_warnings(action="ignore", category=DeprecationWarning):
                    simulation.compute()
                row[:] = [simulation.output.get(name, np.nan) for name in outputs]
            except (ValueError, AssertionError):  # it gives no answer where no rule fires
                continue
        return found

    return at


def _variable(variable: Any, changes: list[str]) -> Variable:
    x = np.asarray(variable.universe, dtype=float)
    terms = {}
    for label, term in variable.terms.items():
        try:
            function, error = recognise(x, np.asarray(term.mf))
        except FuzzySystemError as wrong:
            raise FuzzySystemError(f"{variable.label} is {label}: {wrong}") from None
        terms[str(label)] = function
        if error > EXACT:
            numbers = " ".join(f"{number:g}" for number in function.numbers)
            changes.append(
                f"{variable.label} is {label}: the samples became {function.matlab} [{numbers}], which is up to "
                f"{error:.2g} away from them"
            )
    return Variable(str(variable.label), (x[0], x[-1]), Terms(terms))


def _accumulation(variable: Any) -> str:
    known = {0.6: "max", 0.9: "sum", 0.72: "probor"}
    return _method(variable.accumulation_method, f"{variable.label}: accumulation_method", known)


def _method(function: Callable[[float, float], float], what: str, known: Mapping[float, str]) -> str:
    value = float(function(0.3, 0.6))
    for wanted, name in known.items():
        if abs(value - wanted) < 1e-12:
            return name
    raise FuzzySystemError(f"{what} must be {', '.join(known.values())}; this one makes {value:g} of 0.3 and 0.6")


def _same(what: str, found: Sequence[str]) -> str:
    if len(set(found)) > 1:
        raise FuzzySystemError(f"all outputs need the same {what}, got {', '.join(sorted(set(found)))}")
    return found[0]


_Product = tuple[Clause, ...]


def _rules(rule: Any, what: str, changes: list[str]) -> tuple[list[Rule], set[str]]:
    """The rules that one of scikit-fuzzy's becomes, and the connectives that it has."""
    connectives: set[str] = set()
    products = _sum_of_products(rule.antecedent, False, connectives)
    if len(products) > _MOST_RULES:
        raise FuzzySystemError(f"{what}: its brackets make more than {_MOST_RULES} rules")
    exact = all(
        abs(float(function(0.3, 0.6)) - wanted) < 1e-12
        for name, function, wanted in (("and", rule.and_func, 0.3), ("or", rule.or_func, 0.6))
        if name in connectives
    )
    if exact:  # the least of a degree and itself is that degree
        products = [tuple(dict.fromkeys(product)) for product in products]
    variables = [clause.variable for product in products for clause in product]
    flat_or = len(products) > 1 and all(len(product) == 1 for product in products)
    antecedents: list[tuple[_Product, Any]]
    if flat_or and len(set(variables)) == len(variables):
        antecedents = [(tuple(clause for (clause,) in products), "or")]
    else:
        if len(products) > 1 and not exact:
            raise FuzzySystemError(f"{what}: brackets, or a variable twice, have an equivalent only with min and max")
        if len(products) > 1:
            changes.append(
                f"{what} became {len(products)} rules, as it joins 'and' with 'or', or names a variable twice"
            )
        antecedents = [(product, "and") for product in products]
    for product, _ in antecedents:
        names = [clause.variable for clause in product]
        if len(set(names)) < len(names):
            twice = next(name for name in names if names.count(name) > 1)
            raise FuzzySystemError(f"{what}: {twice!r} stands twice in one 'and', which has no equivalent")
    weights: dict[float, list[tuple[str, str]]] = {}
    for each in rule.consequent:
        weights.setdefault(float(each.weight), []).append((str(each.term.parent.label), str(each.term.label)))
    made = [
        Rule(when, tuple(then), connective, weight)
        for when, connective in antecedents
        for weight, then in weights.items()
    ]
    return made, connectives


def _sum_of_products(term: Any, negated: bool, connectives: set[str]) -> list[_Product]:
    """An antecedent as alternatives of clauses that all hold, by De Morgan and by the distributive law."""
    kind = getattr(term, "kind", None)
    if kind is None:
        return [(Clause(str(term.parent.label), str(term.label), negated),)]
    if kind == "not":
        return _sum_of_products(term.term1, not negated, connectives)
    left = _sum_of_products(term.term1, negated, connectives)
    right = _sum_of_products(term.term2, negated, connectives)
    connectives.add(kind)
    joint = {"and": "or", "or": "and"}[kind] if negated else kind
    connectives.add(joint)
    if joint == "or":
        return left + right
    return [(*one, *other) for one in left for other in right]
