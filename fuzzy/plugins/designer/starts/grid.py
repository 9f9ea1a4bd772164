"""A grid of evenly spread terms with a rule for each combination, to be filled in by hand."""

from itertools import product

from fuzzy.errors import quoted
from fuzzy.fitting.identification import grid_terms
from fuzzy.membershipfunction import MATLAB_NAMES, MembershipFunction
from fuzzy.plugins.designer.starts.start import StartError
from fuzzy.rule import Clause, Rule
from fuzzy.system import Sugeno, Variable

_MOST_RULES = 2000  # as many as the designer shows
GRID_SHAPES = {name: function.title for name, function in MATLAB_NAMES.items() if function.grid is not None}
_WORDS = {
    2: "low high",
    3: "low medium high",
    4: "lowest low high highest",
    5: "lowest low medium high highest",
    6: "lowest lower low high higher highest",
    7: "lowest lower low medium high higher highest",
}


def names_of(count: int) -> list[str]:
    """Names for ``count`` terms from the lowest to the highest."""
    return _WORDS[count].split() if count in _WORDS else [f"mf{k}" for k in range(1, count + 1)]


def evenly(shape: str, low: float, high: float, count: int) -> dict[str, MembershipFunction]:
    """``count`` terms spread evenly from ``low`` to ``high``, with names; see fuzzy.fitting.identification.grid_terms.

    Neighbours cross at 0.5; triangles add up to 1 everywhere.
    """
    return dict(zip(names_of(count), grid_terms(shape, low, high, count), strict=True))


def grid(inputs: int, outputs: int, terms: int, shape: str, low: float, high: float) -> Sugeno:
    """A system with a rule for each combination of the inputs' terms, all of which say the outputs' middle term.

    Args:
        inputs: The number of inputs, input1, input2, ...
        outputs: The number of outputs, each with as many constants as an input has terms, evenly spread.
        terms: The number of terms of each variable, at least 2.
        shape: The membership function, by MATLAB's name.
        low: The lowest value of each variable.
        high: The highest value.

    Raises StartError for an empty range and for more rules than the designer shows.
    """
    if not low < high:
        raise StartError(f"low must lie below high, got {low:g} and {high:g}")
    if terms**inputs > _MOST_RULES:
        raise StartError(
            f"{terms} terms of each of {inputs} inputs make {terms**inputs} rules, more than {_MOST_RULES}: "
            "take fewer terms or inputs"
        )
    if shape not in GRID_SHAPES:
        raise StartError(f"{quoted(shape)} cannot be spread; known: {', '.join(GRID_SHAPES)}")
    names = names_of(terms)
    ins = [Variable(f"input{i}", (low, high), evenly(shape, low, high, terms)) for i in range(1, inputs + 1)]
    step = (high - low) / (terms - 1)
    values = {name: low + k * step for k, name in enumerate(names)} | {names[-1]: high}
    outs = [Variable(f"output{j}", (low, high), values) for j in range(1, outputs + 1)]
    middle = names[(terms - 1) // 2]
    rules = [
        Rule(
            tuple(Clause(v.name, term) for v, term in zip(ins, chosen, strict=True)),
            tuple((v.name, middle) for v in outs),
        )
        for chosen in product(names, repeat=inputs)
    ]
    return Sugeno(ins, outs, rules, name="grid")
