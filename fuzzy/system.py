"""The Sugeno system: its variables, terms, rules and choices. :mod:`fuzzy.inference` evaluates it.

The structure is Python, the parameters are numbers or arrays, and nothing changes after construction.
"""

from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from html import escape
from typing import Any, ClassVar, Generic, Literal, NamedTuple, TypeVar, get_args

import numpy as np
from array_api_compat import is_array_api_obj

import fuzzy.membership  # noqa: F401 - what files and editors call a function is known once it is defined
from fuzzy.errors import InputError
from fuzzy.language import parse_rule
from fuzzy.membershipfunction import Array, MembershipFunction, as_number
from fuzzy.naming import expected
from fuzzy.rule import Rule
from fuzzy.shown import shown
from fuzzy.sketch import lines, table, titled
from fuzzy.words import counted

NoRuleFires = Literal["midrange", "nan", "error"]
OutOfRange = Literal["warn", "ignore", "clip", "error"]
# In a notebook
_RULES_SHOWN = 50
_TERMS_SHOWN = 12  # of a variable
_SKETCH_POINTS = 61  # of a sketch
T = TypeVar("T")
AnySystem = TypeVar("AnySystem")  # Sugeno, or what has its ``mapped``: an interval type-2 system, a tree


class FuzzySystemError(InputError):
    """The error for a description that makes no system, and for an input that the system was told to refuse."""


class Terms(Mapping[str, T], Generic[T]):
    """An ordered, immutable mapping of term names to membership functions or consequents."""

    __slots__ = ("_items",)

    def __init__(self, items: "Mapping[str, T] | Iterable[tuple[str, T]]" = ()) -> None:
        self._items: dict[str, T] = dict(items)

    def __getitem__(self, name: str) -> T:
        return self._items[name]

    def __iter__(self) -> Iterator[str]:
        return iter(self._items)

    def __len__(self) -> int:
        return len(self._items)

    def __eq__(self, other: object) -> bool:
        return isinstance(other, Terms) and list(self._items.items()) == list(other._items.items())

    def __hash__(self) -> int:
        return hash(tuple(self._items.items()))

    def __repr__(self) -> str:
        return repr(self._items)


@dataclass(frozen=True)
class Constant:
    """A zero-order consequent: z = value.

    Attributes:
        value: A number, or an array scalar in training; in the unit of the output.
    """

    value: Any
    matlab: ClassVar[str] = "constant"  # MATLAB's name

    @property
    def parameters(self) -> tuple[Any, ...]:
        """The parameters as MATLAB lists them: the constant alone."""
        return (self.value,)


@dataclass(frozen=True)
class Linear:
    """A first-order consequent: z = slopes · x + constant, with one slope per input.

    Attributes:
        slopes: (inputs,): numbers or an array; in the output's unit over each input's.
        constant: In the unit of the output.
    """

    slopes: Any
    constant: Any
    matlab: ClassVar[str] = "linear"  # MATLAB's name

    def __post_init__(self) -> None:
        if not is_array_api_obj(self.slopes):
            object.__setattr__(self, "slopes", tuple(self.slopes))

    @property
    def parameters(self) -> tuple[Any, ...]:
        """The parameters [p1 ... pn p0] as MATLAB lists them: the slopes, then the constant."""
        return (*(self.slopes[i] for i in range(len(self.slopes))), self.constant)


Consequent = Constant | Linear


@dataclass(frozen=True)
class Variable:
    """An input or an output: its name, universe of discourse and terms.

    The terms of an input are membership functions. The terms of an output are consequents (:class:`Constant`,
    :class:`Linear`, or a plain number, which is a constant).

    Attributes:
        name: What rules call it.
        universe: Its lowest and highest value, in ``unit``.
        terms: The terms by their names.
        unit: A label for axes and tables; nothing is converted by it.

    Raises:
        FuzzySystemError: Names, universes and terms that cannot be used.
    """

    name: str
    universe: tuple[float, float]
    terms: Mapping[str, Any] = field(default_factory=Terms)
    unit: str = ""

    def __post_init__(self) -> None:
        try:
            low, high = (float(end) for end in self.universe)
        except (TypeError, ValueError):
            raise FuzzySystemError(
                f"{self.name}: the universe of discourse is a pair of numbers (low, high), got {self.universe!r}"
            ) from None
        if not (np.isfinite(low) and np.isfinite(high) and low <= high):
            raise FuzzySystemError(
                f"{self.name}: the universe of discourse must be finite and ascending, got [{low:g} {high:g}]"
            )
        object.__setattr__(self, "universe", (low, high))
        items = self.terms.items() if isinstance(self.terms, Mapping) else self.terms
        terms = Terms({name: self._term(name, term) for name, term in items})
        object.__setattr__(self, "terms", terms)

    def _term(self, name: str, term: Any) -> Any:
        if isinstance(term, (MembershipFunction, Constant, Linear)):
            return term
        if isinstance(term, (int, float, np.number)) and not isinstance(term, bool):
            return Constant(float(term))
        raise FuzzySystemError(
            f"{self.name}: term {name!r} must be a membership function, a consequent or a number, got {term!r}"
        )

    @property
    def span(self) -> float:
        """The width of the universe of discourse, in ``unit``."""
        return self.universe[1] - self.universe[0]

    @property
    def midrange(self) -> float:
        """The middle of the universe of discourse."""
        return (self.universe[0] + self.universe[1]) / 2

    @property
    def label(self) -> str:
        """The name with the unit, as an axis shows it."""
        return f"{self.name} [{self.unit}]" if self.unit else self.name


class TermKind(NamedTuple):
    """All terms with one type of membership function. Terms are numbered from the first input's to the last input's."""

    function: type[MembershipFunction]
    terms: np.ndarray  # (n,) int
    inputs: np.ndarray  # (n,) int: the input that each belongs to


@dataclass(frozen=True, eq=False)
class Structure:
    """The rules as index arrays, derived once from the names."""

    term: np.ndarray  # (inputs, rules) int: the term's place, or -1 where the rule leaves the input out
    negated: np.ndarray  # (inputs, rules) bool
    power: np.ndarray  # (inputs, rules) float
    is_or: np.ndarray  # (rules,) bool
    weight: np.ndarray  # (rules,) float
    consequent: np.ndarray  # (outputs, rules) int: the consequent's place, or -1
    kinds: tuple["TermKind", ...]  # the membership functions, by type
    first: np.ndarray  # (inputs + 1,) int: the number of each input's first term among all, and of all terms

    @cached_property
    def incidence(self) -> np.ndarray:
        """The power (terms, rules) with which a rule asks for a term; 0 where it does not. Made when first used."""
        terms = np.zeros((self.first[-1], self.term.shape[1]))
        place, rule = np.nonzero(self.term >= 0)
        terms[self.first[place] + self.term[place, rule], rule] = self.power[place, rule]
        return terms


@dataclass(frozen=True)
class Sugeno:
    """A Takagi-Sugeno system of order zero or one. Its rules may be given as sentences.

    It is called with a point (inputs,) or a batch (..., inputs), numpy or torch, and gives (..., outputs). The defaults
    are those of MATLAB's ``sugfis``: "and" is the product, "or" the probabilistic or, and the output the weighted
    average. Where no rule fires, the output is the middle of its universe of discourse. An input outside its universe
    is evaluated without clipping, with a warning.

    Attributes:
        inputs: The inputs, whose terms are membership functions.
        outputs: The outputs, whose terms are consequents.
        rules: Each a :class:`Rule`, or a sentence, which is read on construction: afterwards all are :class:`Rule`.
        name: The system's name.
        and_method: How "and" joins degrees.
        or_method: How "or" joins degrees.
        defuzzification: The weighted average ("wtaver") or the weighted sum ("wtsum") of the rules' proposals.
        no_rule_fires: What the output is where no rule fires: the middle of its universe, not-a-number, or an error.
        out_of_range: What becomes of an input outside its universe.
        implication: What a MATLAB file records of it. There is no choice in a Sugeno system: always the product. Kept
            so that a file survives reading and writing.
        aggregation: Likewise; always the sum.
        loop: The control loop that it was designed in, one line of JSON; it goes with the system, and nothing is
            evaluated by it.
        structure: The rules as arrays of numbers, for inference; made on construction.

    Raises:
        FuzzySystemError: Parts that do not fit together; the message names the place.
        RuleError: A sentence that is no rule of the system; the message marks the place.
    """

    inputs: Sequence[Variable]
    outputs: Sequence[Variable]
    rules: Sequence[Any] = ()
    name: str = "fuzzy"
    and_method: Literal["prod", "min"] = "prod"
    or_method: Literal["probor", "max"] = "probor"
    defuzzification: Literal["wtaver", "wtsum"] = "wtaver"
    no_rule_fires: NoRuleFires = "midrange"
    out_of_range: OutOfRange = "warn"
    implication: str = "prod"
    aggregation: str = "sum"
    loop: str = ""
    structure: Structure = field(init=False, repr=False, compare=False)

    def __post_init__(self) -> None:
        for name in ("inputs", "outputs", "rules"):
            object.__setattr__(self, name, tuple(getattr(self, name)))
        for name, accepted in _CHOICES.items():
            if getattr(self, name) not in accepted:
                raise FuzzySystemError(f"{self.name}: " + expected(str(getattr(self, name)), accepted, name))
        _check_variables(self.inputs, MembershipFunction, "input", "a membership function")
        _check_variables(self.outputs, (Constant, Linear), "output", "a consequent (a number, Constant or Linear)")
        for output in self.outputs:
            for label, term in output.terms.items():
                if isinstance(term, Linear) and len(term.slopes) != len(self.inputs):
                    raise FuzzySystemError(
                        f"{output.name} is {label}: a linear consequent has one slope an input "
                        f"({len(self.inputs)}) and a constant, got {len(term.slopes)} slopes"
                    )
        antecedents = {v.name: tuple(v.terms) for v in self.inputs}
        consequents = {v.name: tuple(v.terms) for v in self.outputs}
        rules = tuple(parse_rule(r, antecedents, consequents) if isinstance(r, str) else r for r in self.rules)
        object.__setattr__(self, "rules", rules)
        object.__setattr__(self, "structure", _resolve(rules, self.inputs, self.outputs))

    def __call__(self, *x: Any) -> Array:
        """Evaluate the outputs (..., outputs) at one array ``x`` (..., inputs); see :func:`fuzzy.inference.infer`.

        Raises FuzzySystemError for several arguments in place of one array.
        """
        from fuzzy.inference import infer

        if len(x) != 1:
            names = ", ".join(v.name for v in self.inputs)
            raise FuzzySystemError(
                f"{self.name or 'a system'} is called with one array of all inputs, fis([{names}]), or of many rows of "
                f"them (..., {len(self.inputs)}); got {len(x)} arguments"
            )
        return infer(self, x[0]).output

    def __repr__(self) -> str:
        ends = (", ".join(v.name for v in variables) for variables in (self.inputs, self.outputs))
        return f"Sugeno({self.name!r}: {' -> '.join(ends)}; {counted(len(self.rules), 'rule')})"

    def _repr_html_(self) -> str:
        """What a notebook shows: the variables, a drawing of the inputs' terms, and the rules."""
        rows = [
            [variable.label, f"{shown(variable.universe[0])} to {shown(variable.universe[1])}", words, drawn]
            for variables in (self.inputs, self.outputs)
            for variable in variables
            for words, drawn in [_sketched(variable)]
        ]
        listed = "".join(f"<li>{escape(str(rule))}</li>" for rule in self.rules[:_RULES_SHOWN])
        more = f"<p>and {len(self.rules) - _RULES_SHOWN} more</p>" if len(self.rules) > _RULES_SHOWN else ""
        rules = f"<details><summary>Rules</summary><ol>{listed}</ol>{more}</details>" if self.rules else ""
        return titled(self.name, sizes(self), table(("variable", "range", "terms", ""), rows), rules)

    @property
    def upper(self) -> "Sugeno":
        """Itself: the upper membership functions of an interval type-2 system are here the only ones."""
        return self

    def mapped(self, change: "Callable[[Sugeno], Sugeno]") -> "Sugeno":
        """The system with each of the type-1 systems in it as ``change`` makes it: here the one that it is."""
        return change(self)

    def without_rule(self, place: int) -> "Sugeno":
        """The system without one of its rules, the one at ``place``, counted from 0."""
        return replace(self, rules=(*self.rules[:place], *self.rules[place + 1 :]))

    def __getitem__(self, name: str) -> Variable:
        """Return the input or output of this name."""
        for variable in (*self.inputs, *self.outputs):
            if variable.name == name:
                return variable
        raise KeyError(expected(name, [v.name for v in (*self.inputs, *self.outputs)], "variable"))


_CHOICES: dict[str, tuple[str, ...]] = {
    "and_method": ("prod", "min"),
    "or_method": ("probor", "max"),
    "defuzzification": ("wtaver", "wtsum"),
    "no_rule_fires": get_args(NoRuleFires),
    "out_of_range": get_args(OutOfRange),
}


def sizes(fis: Sugeno) -> str:
    """Say how large a system is: "2 inputs, 1 output, 9 rules"."""
    parts = {"input": fis.inputs, "output": fis.outputs, "rule": fis.rules}
    return ", ".join(counted(len(those), what) for what, those in parts.items())


def _sketched(variable: Variable) -> tuple[str, str]:
    """The terms of a variable in words, and those that are membership functions as a drawing."""
    low, high = variable.universe
    words, curves = [], []
    for name, term in variable.terms.items():
        if isinstance(term, MembershipFunction):
            plain = type(term)(*map(as_number, term.parameters))  # its parameters may be in training
            x = np.linspace(low, high, _SKETCH_POINTS)
            curves.append(list(zip(x.tolist(), np.asarray(plain(x)).tolist(), strict=True)))
        words.append(f"{name} {shown(as_number(term.value), high - low)}" if isinstance(term, Constant) else name)
    more = [f"and {len(words) - _TERMS_SHOWN} more"] if len(words) > _TERMS_SHOWN else []
    return ", ".join(words[:_TERMS_SHOWN] + more), lines(curves, size=(180.0, 36.0))


def _check_variables(variables: Sequence[Variable], kind: Any, what: str, term: str) -> None:
    names: set[str] = set()
    if not variables:
        raise FuzzySystemError(f"a system needs at least one {what}")
    for variable in variables:
        if variable.name in names:
            raise FuzzySystemError(f"two {what}s are named {variable.name!r}")
        names.add(variable.name)
        for label, function in variable.terms.items():
            if not isinstance(function, kind):
                raise FuzzySystemError(f"{what} {variable.name!r}: term {label!r} must be {term}, got {function!r}")


def _resolve(rules: Sequence[Rule], inputs: Sequence[Variable], outputs: Sequence[Variable]) -> Structure:
    asked, proposed = _numbered(inputs), _numbered(outputs)
    term = np.full((len(inputs), len(rules)), -1)
    negated = np.zeros_like(term, dtype=bool)
    power = np.ones_like(term, dtype=float)
    consequent = np.full((len(outputs), len(rules)), -1)
    for r, rule in enumerate(rules):
        if not rule.when or not rule.then:
            raise FuzzySystemError(f"rule {r + 1} needs an antecedent and a consequent: {rule!r}")
        if rule.connective not in ("and", "or"):
            raise FuzzySystemError(f"rule {r + 1}: " + expected(rule.connective, ("and", "or"), "connective"))
        if not 0 <= rule.weight <= 1:
            raise FuzzySystemError(f"rule {r + 1}: the weight must lie in [0, 1], got {rule.weight!r} in {rule}")
        for clause in rule.when:
            i, labels = _place(clause.variable, asked, "input", r)
            if term[i, r] != -1:
                raise FuzzySystemError(f"rule {r + 1}: input {clause.variable!r} appears twice in {rule}")
            if not (clause.power > 0 and np.isfinite(clause.power)):
                raise FuzzySystemError(f"rule {r + 1}: a hedge's power must be > 0, got {clause.power!r}")
            term[i, r] = _place(clause.term, labels, f"term of {clause.variable!r}", r)
            negated[i, r], power[i, r] = clause.negated, clause.power
        for output, label in rule.then:
            j, labels = _place(output, proposed, "output", r)
            if consequent[j, r] != -1:
                raise FuzzySystemError(f"rule {r + 1}: output {output!r} appears twice in {rule}")
            consequent[j, r] = _place(label, labels, f"term of {output!r}", r)
    is_or = np.array([rule.connective == "or" for rule in rules], dtype=bool)
    weight = np.array([rule.weight for rule in rules], dtype=float)
    functions = [(type(f), i) for i, variable in enumerate(inputs) for f in variable.terms.values()]
    kinds = []
    for function in dict.fromkeys(kind for kind, _ in functions):
        terms = np.array([t for t, (kind, _) in enumerate(functions) if kind is function])
        kinds.append(TermKind(function, terms, np.array([functions[t][1] for t in terms])))
    first = np.cumsum([0, *(len(v.terms) for v in inputs)])
    return Structure(term, negated, power, is_or, weight, consequent, tuple(kinds), first)


def _numbered(variables: Sequence[Variable]) -> dict[str, tuple[int, dict[str, int]]]:
    """The place of each variable, and those of its terms."""
    return {v.name: (place, {term: t for t, term in enumerate(v.terms)}) for place, v in enumerate(variables)}


def _place(name: str, known: Mapping[str, T], what: str, rule: int) -> T:
    if name not in known:
        raise FuzzySystemError(f"rule {rule + 1}: " + expected(name, known, what))
    return known[name]
