"""Systems from a table of samples: clusters, or a grid over the data's ranges, with fitted consequents."""

from importlib import resources
from pathlib import Path
from typing import Any

import numpy as np

from fuzzy.files.columnchoice import chosen_columns, names_of
from fuzzy.files.table import open_table
from fuzzy.fitting.identification import identify
from fuzzy.fitting.termnames import with_telling_names
from fuzzy.plugins.designer.starts.start import Choice, ColumnsOption, File, Option
from fuzzy.system import Sugeno

# The options of every start that reads a table.
TABLE_OPTIONS: tuple[Option, ...] = (
    File("file", "Table of samples"),
    ColumnsOption("inputs", "Inputs", "file", "all that are no outputs"),
    ColumnsOption("outputs", "Outputs", "file", "the last"),
    Choice("bad", "Rows without a number", {"refuse": "say which, and stop", "skip": "leave them out"}, "refuse"),
)


def read_samples(file: Path, inputs: str, outputs: str, bad: str) -> tuple[np.ndarray, np.ndarray, dict[str, Any]]:
    """Read a table's chosen columns, by titles, names or numbers with commas between; raises InputError.

    With ``bad`` "skip" rows without a number in one of the columns are left out.

    Returns:
        x (samples, inputs), y (samples, outputs), and the names and units of the columns, as identify() takes them.
    """
    text = open_table(file)
    of, to = chosen_columns(text, inputs or None, outputs or None)
    table = text.numbers([*of, *to], skip_bad=bad == "skip")
    n = len(of)
    return table.values[:, :n], table.values[:, n:], names_of(table, n)


def from_clusters(file: Path, inputs: str, outputs: str, bad: str, radius: float) -> Sugeno:
    """A rule for each cluster of the samples, by subtractive clustering with that radius, a share of the ranges."""
    x, y, names = read_samples(file, inputs, outputs, bad)
    return with_telling_names(identify(x, y, "subtractive", radius=radius, name="clusters", **names))


def from_grid(file: Path, inputs: str, outputs: str, bad: str, terms: int, shape: str, order: str) -> Sugeno:
    """A rule for each combination of evenly spread terms over the data's ranges; order 0 constant, 1 linear."""
    x, y, names = read_samples(file, inputs, outputs, bad)
    made = identify(
        x,
        y,
        "grid",
        mfs=terms,
        kind=shape,
        order=0 if order == "0" else 1,
        name="grid",
        **names,
    )
    return with_telling_names(made)


def example_table() -> Path:
    """The packaged table of samples, for pictures of what is made from a table."""
    return Path(str(resources.files("fuzzy") / "examples" / "samples.csv"))


def clusters_example() -> Sugeno:
    """Clusters of the packaged samples."""
    return from_clusters(example_table(), "", "", "refuse", 0.5)


def grid_example() -> Sugeno:
    """A grid over the packaged samples."""
    return from_grid(example_table(), "", "", "refuse", 3, "gaussmf", "1")
