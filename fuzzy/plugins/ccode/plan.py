"""What of a system is written in C, with the names that it has there: the same for every type of numbers."""

from dataclasses import dataclass

import numpy as np

from fuzzy.compiled.packed import proposed_numbers
from fuzzy.compiled.tables import NUMBERS
from fuzzy.inference import logarithmic
from fuzzy.membershipfunction import as_number
from fuzzy.plugins.ccode.identifier import identifier, identifiers
from fuzzy.plugins.ccode.numbertype import ExportError
from fuzzy.system import Linear, Sugeno

UNROLLED = 40  # rules; a system with more is written as tables and loops


@dataclass(frozen=True)
class CodeTerm:
    """A term that a rule asks for."""

    input: int
    place: int  # among the input's terms
    variable: str  # the input's identifier
    name: str  # its own identifier, such as "distance_near"
    function: str  # MATLAB's name
    parameters: tuple[float, ...]


@dataclass(frozen=True)
class CodeClause:
    """One clause of a rule."""

    term: int
    power: float
    negated: bool


@dataclass(frozen=True)
class CodePlan:
    """A system, laid out for C."""

    fis: Sugeno
    name: str  # the prefix of everything public
    inputs: tuple[str, ...]  # identifiers
    outputs: tuple[str, ...]
    terms: tuple[CodeTerm, ...]
    clauses: tuple[tuple[CodeClause, ...], ...]  # of each rule
    constants: np.ndarray  # (outputs, rules)
    slopes: np.ndarray  # (outputs, rules, inputs)
    logs: bool  # whether firing strengths are sums of logarithms

    @property
    def rules(self) -> int:
        """How many rules there are."""
        return len(self.fis.rules)

    @property
    def unrolled(self) -> bool:
        """Whether every rule is a line of its own."""
        return self.rules <= UNROLLED

    @property
    def all_clauses(self) -> tuple[CodeClause, ...]:
        """The clauses of all rules, one after the other."""
        return tuple(clause for row in self.clauses for clause in row)

    @property
    def has_powers(self) -> bool:
        """Whether a clause has a hedge."""
        return any(clause.power != 1 for clause in self.all_clauses)

    @property
    def has_negations(self) -> bool:
        """Whether a clause has a "not"."""
        return any(clause.negated for clause in self.all_clauses)

    @property
    def has_ors(self) -> bool:
        """Whether a rule joins by "or"."""
        return bool(self.fis.structure.is_or.any())

    @property
    def weights(self) -> np.ndarray:
        """The rules' weights (rules,)."""
        return np.asarray(self.fis.structure.weight)

    @property
    def is_weighted(self) -> bool:
        """Whether a rule has another weight than 1."""
        return bool((self.weights != 1).any())

    @property
    def sums(self) -> bool:
        """Whether the outputs are weighted sums, and not averages."""
        return self.fis.defuzzification == "wtsum"

    @property
    def takes_part(self) -> np.ndarray:
        """Whether a rule has a consequent for an output (outputs, rules)."""
        return np.asarray(self.fis.structure.consequent >= 0)

    def has_planes(self, output: int) -> bool:
        """Whether an output's terms are of first order, be their slopes 0."""
        return any(isinstance(term, Linear) for term in self.fis.outputs[output].terms.values())

    def is_linear(self, output: int) -> bool:
        """Whether an output has first-order consequents."""
        return bool((self.slopes[output] != 0).any())


def planned(fis: Sugeno, name: str = "") -> CodePlan:
    """Lay a system out. Raises ExportError for a membership function that C has no formula of.

    Args:
        fis: The system; parameters that are arrays are read now.
        name: The prefix of everything public; by default the system's own name.
    """
    prefix = identifier(name or fis.name)
    inputs = identifiers(variable.name for variable in fis.inputs)
    outputs = identifiers((variable.name for variable in fis.outputs), inputs)
    s = fis.structure
    asked = sorted({(int(i), int(s.term[i, r])) for i, r in zip(*np.nonzero(s.term >= 0), strict=True)})
    terms: list[CodeTerm] = []
    for i, t in asked:
        label, function = list(fis.inputs[i].terms.items())[t]
        if type(function) not in NUMBERS:
            raise ExportError(
                f"{fis.name}: there is no formula in C of the membership function {function.matlab}; it would stand in "
                "floating.c, floatterm.py and fixedpoint.py of fuzzy/plugins/ccode, its number in "
                "fuzzy/compiled/tables.py"
            )
        own = identifier(f"{inputs[i]}_{label}", [*inputs, *outputs, *(term.name for term in terms)])
        numbers = tuple(as_number(p) for p in function.parameters)
        terms.append(CodeTerm(i, t, inputs[i], own, function.matlab, numbers))
    place = {key: k for k, key in enumerate(asked)}
    clauses = tuple(
        tuple(
            CodeClause(place[i, int(s.term[i, r])], float(s.power[i, r]), bool(s.negated[i, r]))
            for i in range(len(inputs))
            if s.term[i, r] >= 0
        )
        for r in range(len(fis.rules))
    )
    constants, slopes = proposed_numbers(fis)
    return CodePlan(fis, prefix, inputs, outputs, tuple(terms), clauses, constants, slopes, logarithmic(fis))
