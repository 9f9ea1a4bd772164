"""The starts that fuzzy itself offers."""

from functools import partial

from fuzzy.plugins.designer.starts import samples
from fuzzy.plugins.designer.starts.control import CONTROL_KINDS, CONTROL_TERMS, rule_table
from fuzzy.plugins.designer.starts.grid import GRID_SHAPES, grid
from fuzzy.plugins.designer.starts.start import Choice, NumberOption, Start
from fuzzy.system import Sugeno

EMPTY, CONTROL, _DATA = "Empty", "Control tables", "From data"
_OUTPUTS = {"pd": "the control u", "pi": "the change du of the control", "pid": "the control u and its change du"}


def control_table(kind: str, terms: str) -> Sugeno:
    """The rule table of that kind with so many terms a variable, see :func:`.control.rule_table`."""
    return rule_table(kind, int(terms))


def starts() -> list[Start]:
    """An empty grid, control tables, clusters of a table, a grid over a table."""
    sizes = {str(n): f"{n} x {n} rules" for n in CONTROL_TERMS}
    tables = [
        Start(
            f"fuzzy-{kind}",
            CONTROL,
            f"Fuzzy {kind.upper()}",
            f"The usual table of an error and its rate, from -1 to 1, for {_OUTPUTS[kind]}.",
            partial(control_table, kind),
            (Choice("terms", "Rules", sizes, "7"),),
        )
        for kind in CONTROL_KINDS
    ]
    return [
        Start(
            "grid",
            EMPTY,
            "Empty grid",
            "Evenly spread terms and a rule for each combination, which all say the middle: fill in the rest.",
            grid,
            (
                NumberOption("inputs", "Inputs", 1, 6, 2),
                NumberOption("outputs", "Outputs", 1, 6, 1),
                NumberOption("terms", "Terms of each", 2, 9, 3),
                Choice("shape", "Membership function", GRID_SHAPES, "trimf"),
                NumberOption("low", "Lowest value", -1e9, 1e9, -1, whole=False),
                NumberOption("high", "Highest value", -1e9, 1e9, 1, whole=False),
            ),
        ),
        *tables,
        Start(
            "clusters",
            _DATA,
            "Clusters of a table",
            "A rule where the samples of a .csv file are dense (subtractive clustering), with fitted consequents.",
            samples.from_clusters,
            (*samples.TABLE_OPTIONS, NumberOption("radius", "Radius, a share of the range", 0.05, 2, 0.5, whole=False)),
            samples.clusters_example,
        ),
        Start(
            "data-grid",
            _DATA,
            "Grid over a table",
            "Evenly spread terms over the ranges of a .csv file, a rule for each combination, fitted consequents.",
            samples.from_grid,
            (
                *samples.TABLE_OPTIONS,
                NumberOption("terms", "Terms of each input", 2, 9, 3),
                Choice("shape", "Membership function", GRID_SHAPES, "gaussmf"),
                Choice("order", "Consequents", {"0": "constant", "1": "linear"}, "1"),
            ),
            samples.grid_example,
        ),
    ]
