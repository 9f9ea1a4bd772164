"""The starts that fuzzy itself offers."""

from fuzzy.starts.grid import SHAPES, grid
from fuzzy.starts.samples import TABLE_OPTIONS, clusters_example, from_clusters, from_grid, grid_example
from fuzzy.starts.start import Choice, Number, Start

EMPTY, DATA = "Empty", "From data"


def starts() -> list[Start]:
    """An empty grid, clusters of a table, a grid over a table."""
    return [
        Start(
            "grid",
            EMPTY,
            "Empty grid",
            "Evenly spread terms and a rule for each combination, which all say the middle: fill in the rest.",
            grid,
            (
                Number("inputs", "Inputs", 1, 6, 2),
                Number("outputs", "Outputs", 1, 6, 1),
                Number("terms", "Terms of each", 2, 9, 3),
                Choice("shape", "Membership function", SHAPES, "trimf"),
                Number("low", "Lowest value", -1e9, 1e9, -1, whole=False),
                Number("high", "Highest value", -1e9, 1e9, 1, whole=False),
            ),
        ),
        Start(
            "clusters",
            DATA,
            "Clusters of a table",
            "A rule where the samples of a .csv file are dense (subtractive clustering), with fitted consequents.",
            from_clusters,
            (*TABLE_OPTIONS, Number("radius", "Radius, a share of the range", 0.05, 2, 0.5, whole=False)),
            clusters_example,
        ),
        Start(
            "data-grid",
            DATA,
            "Grid over a table",
            "Evenly spread terms over the ranges of a .csv file, a rule for each combination, fitted consequents.",
            from_grid,
            (
                *TABLE_OPTIONS,
                Number("terms", "Terms of each input", 2, 9, 3),
                Choice("shape", "Membership function", SHAPES, "gaussmf"),
                Choice("order", "Consequents", {"0": "constant", "1": "linear"}, "1"),
            ),
            grid_example,
        ),
    ]
