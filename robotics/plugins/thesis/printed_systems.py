"""The thesis's own trained systems as .fis files, from its Tables 5.2 to 5.5 (``datasets/thesis``).

Which antecedents belong to which consequents is read off the numbers (``datasets/thesis/README.md``): the printed
antecedents "1" with the consequents of network 3 give an almost constant v_f along the curve, as they should, and
"2" with network 4 give ω_f. Table 5.2 repeats Table 5.3, and so the antecedents of the leader's networks 1 and 2 are
lost; these two are written as printed, for whoever wants to see what comes of it.
"""

from pathlib import Path

import numpy as np

from fuzzy.errors import InputError
from fuzzy.files.table import read_table
from fuzzy.membership import Gaussian
from fuzzy.rule import Clause, Rule
from fuzzy.system import Linear, Sugeno, Variable

# Inputs and their universes: x from the lead-in to the end, y = 0.5 cos x, θ = −atan(0.5 sin x); the widths of the
# printed clusters give the same extents, σ √8/0.9 = 10.0 m, 1.06 m and 0.84 rad.
_STEEPEST = float(np.round(np.arctan(0.5), 6))
_INPUTS = {"x_l": ((-4.0, 6.0), "m"), "y_l": ((-0.5, 0.5), "m"), "theta_l": ((-_STEEPEST, _STEEPEST), "rad")}
# Output, its universe in its unit (those of the literal data), tables of antecedents and consequents, and whether
# the two belong together
NETWORKS = {
    1: ("v_l", (0.0, 0.3), "m/s", "table-5-2.csv", "table-5-4.csv", "network-1-v_l-as-printed"),
    2: ("w_l", (-0.15, 0.05), "rad/s", "table-5-2.csv", "table-5-4.csv", "network-2-w_l-as-printed"),
    3: ("v_f", (0.0, 0.1), "m/s", "table-5-3.csv", "table-5-5.csv", "network-3-v_f"),
    4: ("w_f", (-0.05, 0.05), "rad/s", "table-5-3.csv", "table-5-5.csv", "network-4-w_f"),
}


class ThesisTableError(InputError):
    """A folder without the thesis's tables, or a table without the columns of a network."""


def thesis_system(number: int, folder: str | Path) -> Sugeno:
    """The fuzzy network ``number`` (1 to 4) from the tables in ``folder``; it has the name of its file.

    Antecedents are Gaussians, printed as [σ c] although the heading says [c, σ]; consequents stand in MATLAB's order
    P1, P2, P3, P0: those of (5.7) with the constant last.
    """
    output, universe, unit, antecedents, consequents, name = NETWORKS[number]
    first = 7 if number in (2, 4) else 1
    shapes = _columns(Path(folder) / antecedents, f"network_{number}_input_", first, 6).reshape(-1, 3, 2)
    second = 5 if number in (2, 4) else 1
    planes = _columns(Path(folder) / consequents, f"network_{number}_", second, 4)
    inputs = [
        Variable(
            label,
            span,
            {f"cluster{r}": Gaussian(*pair) for r, pair in enumerate(shapes[:, i].tolist(), 1)},
            unit=metric,
        )
        for i, (label, (span, metric)) in enumerate(_INPUTS.items())
    ]
    terms = {f"plane{r}": Linear(row[:-1], row[-1]) for r, row in enumerate(planes.tolist(), 1)}
    rules = [
        Rule(tuple(Clause(label, f"cluster{r}") for label in _INPUTS), ((output, f"plane{r}"),))
        for r in range(1, len(planes) + 1)
    ]
    return Sugeno(inputs, [Variable(output, universe, terms, unit)], rules, name=name)


def thesis_comment(number: int) -> str:
    """The comment at the head of the .fis file of network ``number``: its title, and whether its parts fit."""
    output, _, _, antecedents, consequents, name = NETWORKS[number]
    first, second = (table[len("table-") : -len(".csv")].replace("-", ".") for table in (antecedents, consequents))
    title = f"The thesis's network {number}, {output}: antecedents of Table {first}, consequents of Table {second}"
    fit = "The two do not belong together" if name.endswith("as-printed") else "The two belong together"
    return f"{title}.\n{fit}; see datasets/thesis/README.md."


def _columns(path: Path, prefix: str, first: int, count: int) -> np.ndarray:
    """``count`` columns of a table from column ``first`` on (rows, count), whose names begin with ``prefix``."""
    table = read_table(path)
    wanted = table.names[first : first + count]
    if len(wanted) != count or not all(name.startswith(prefix) for name in wanted):
        raise ThesisTableError(f"{path}: columns {first + 1} to {first + count} must be those of {prefix.rstrip('_')}")
    return table.values[:, first : first + count]
