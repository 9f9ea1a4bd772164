"""The rules over two inputs as a matrix: a cell has the consequents of the rules that ask for exactly its terms."""

from collections import Counter

import numpy as np
from matplotlib.figure import Figure

from fuzzy.detached import detached
from fuzzy.figures.drawing import DOUBLE, shortened, styled_figure, text_width
from fuzzy.figures.palette import ROLES
from fuzzy.insight.universe import consequent_range, universe_grid
from fuzzy.rule import Rule
from fuzzy.system import FuzzySystemError, Sugeno, Variable

_SIZE = 7.0  # of letters, in points
_DARK = 0.45  # of the colours, from 0 to 1: on those below letters are white


def matrix_inputs(fis: Sugeno) -> tuple[int, int] | None:
    """The two inputs, by place, for which most rules ask and for no other; None where no rule asks for just two."""
    places = {v.name: k for k, v in enumerate(fis.inputs)}
    asked = [sorted(places[clause.variable] for clause in rule.when) for rule in fis.rules if _plain(rule)]
    pairs = Counter((first, second) for first, second in asked)
    return max(pairs, key=pairs.__getitem__) if pairs else None


def matrix_rules(fis: Sugeno, inputs: tuple[int, int]) -> dict[tuple[str, ...], list[Rule]]:
    """The rules of each cell, by its terms of the two inputs."""
    names, cells = [fis.inputs[i].name for i in inputs], dict[tuple[str, ...], list[Rule]]()
    for rule in fis.rules:
        terms = {clause.variable: clause.term for clause in rule.when}
        if _plain(rule) and {*names} == {*terms}:
            cells.setdefault(tuple(terms[name] for name in names), []).append(rule)
    return cells


def plot_rule_matrix(fis: Sugeno, inputs: tuple[int, int] | None = None, output: int = 0) -> Figure:
    """Draw the rules over two inputs as a matrix, a cell's colour by the middle of its consequent's range.

    Terms stand in the order of their places. Rules that ask for other inputs, use "or", "not" or a hedge have no cell.

    Args:
        fis: The system.
        inputs: The inputs of the rows and of the columns, by place; those of :func:`matrix_inputs` by default.
        output: The output, by place.

    Raises FuzzySystemError where no rule asks for just two inputs.
    """
    fis = detached(fis)
    inputs = matrix_inputs(fis) if inputs is None else inputs
    if inputs is None:
        raise FuzzySystemError(f"{fis.name} has no rule that asks for just two inputs, so there is no rule matrix")
    down, along = (fis.inputs[i] for i in inputs)
    rows, columns, aim = _ordered(down), _ordered(along), fis.outputs[output]
    cells = {
        key: list(dict.fromkeys(term for rule in rules for name, term in rule.then if name == aim.name))
        for key, rules in matrix_rules(fis, inputs).items()
    }
    middles = {name: float(np.mean(consequent_range(fis, term))) for name, term in aim.terms.items()}
    values = np.array([[np.mean([middles[t] for t in cells.get((a, b), [])] or np.nan) for b in columns] for a in rows])
    left = max(text_width(name, _SIZE) for name in rows) + 0.5
    longest = max(text_width(text, _SIZE) for text in (*columns, *map(", ".join, cells.values())))
    wide = min(longest + 0.15, (DOUBLE - left) / len(columns))
    with styled_figure(left + wide * len(columns), 0.7 + 0.24 * len(rows)) as figure:
        ax = figure.add_subplot()
        low, high = min(middles.values()), max(middles.values())
        ax.pcolormesh(values, cmap="viridis", vmin=low, vmax=high, edgecolors="white", linewidth=1)
        for (i, j), value in np.ndenumerate(values):
            text = ", ".join(cells.get((rows[i], columns[j]), []))
            pale = (value - low) / ((high - low) or 1.0) > _DARK or np.isnan(value)
            color = ROLES["ink"].light if pale else "white"
            label = shortened(text, wide - 0.06, _SIZE)
            ax.text(j + 0.5, i + 0.5, label, ha="center", va="center", size=_SIZE, color=color, parse_math=False)
        ax.set_xticks(np.arange(len(columns)) + 0.5, [shortened(name, wide - 0.06, _SIZE) for name in columns])
        ax.set_yticks(np.arange(len(rows)) + 0.5, rows)
        ax.tick_params(length=0)
        ax.grid(False)
        ax.invert_yaxis()
        ax.xaxis.set_ticks_position("top")
        ax.xaxis.set_label_position("top")
        ax.set_xlabel(along.name, parse_math=False)
        ax.set_ylabel(down.name, parse_math=False)
        ax.spines[:].set_visible(False)
        return figure


def _plain(rule: Rule) -> bool:
    """Whether it asks for two terms as they are."""
    asked = all(not clause.negated and clause.power == 1 for clause in rule.when)
    return asked and len(rule.when) == 2 and rule.connective == "and"


def _ordered(variable: Variable) -> list[str]:
    """The terms in the order of their places: the middle of where each is greatest."""
    x = universe_grid(variable)
    degrees = {name: function(x) for name, function in variable.terms.items()}
    places = {name: float(x[d >= d.max() - 1e-9].mean()) for name, d in degrees.items()}
    return sorted(places, key=places.__getitem__)
