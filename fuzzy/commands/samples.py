"""What commands that learn of samples share: the table of samples, the search for clusters and its picture."""

import sys
from dataclasses import asdict
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, NamedTuple

from fuzzy.commands.datafile import columns_of, numbers, opened
from fuzzy.commands.shared import parsed
from fuzzy.files.columnchoice import chosen_columns, names_of
from fuzzy.shell.options import argument, option

if TYPE_CHECKING:
    from collections.abc import Callable

    import numpy as np

    from fuzzy import Type2Sugeno
    from fuzzy.files.table import TableText
    from fuzzy.fitting.search import SearchResult, Trial
    from fuzzy.system import Sugeno

Table = Annotated[
    Path, argument('Samples, a row each, with or without a header of names "speed [m/s]" or "speed (m/s)".', "DATA.csv")
]
Inputs = Annotated[
    str | None, option("Columns by name, title or number from 1. Default: all that are no outputs.", "A,B")
]
Outputs = Annotated[str | None, option("Columns by name, title or number from 1. Default: the last.", "Y")]
Plot = Annotated[Path | None, option("Draw the search: error against rules, .png, .pdf or .svg.", "PICTURE")]
Order = Annotated[int, option("Consequents: 1 linear, 0 constant.", min=0, max=1)]
Ridge = Annotated[float, option("Weight of the squared consequents beside the mean error.", min=0)]


class SampleTable(NamedTuple):
    """The chosen columns of a table."""

    x: "np.ndarray"  # (samples, inputs)
    y: "np.ndarray"  # (samples, outputs)
    names: dict[str, list[str]]  # the names and units, as identify and search_clusters take them
    skipped: int  # rows that were left out


def sample_table(file: Path, inputs: str | None, outputs: str | None, skip_bad: bool = False) -> SampleTable:
    """The chosen columns of the table. Raises InputError."""
    text = opened(file)
    of, to = chosen_columns(text, inputs, outputs)
    return _sample_table(text, [*of, *to], len(of), skip_bad)


def system_samples(fis: "Sugeno | Type2Sugeno", file: Path, skip_bad: bool = False) -> SampleTable:
    """The columns of the table for a system's inputs and outputs, found by their names. Raises InputError."""
    text = opened(file, fis.inputs)
    return _sample_table(text, columns_of(text, [*fis.inputs, *fis.outputs]), len(fis.inputs), skip_bad)


def _sample_table(text: "TableText", columns: list[int], n: int, skip_bad: bool) -> SampleTable:
    table = numbers(text, columns, skip_bad, n)
    return SampleTable(table.values[:, :n], table.values[:, n:], names_of(table, n), len(table.skipped))


def searched(samples: SampleTable, rules: int, order: int, ridge: float, radii: str | None = None) -> "SearchResult":
    """Search the settings of subtractive clustering for ``rules`` rules, with a progress line on a terminal."""
    from fuzzy.fitting.search import RADII, search_clusters

    return search_clusters(
        samples.x,
        samples.y,
        rules,
        radii=RADII if radii is None else [parsed(float, text, "expected a number") for text in radii.split(",")],
        order=order,  # type: ignore[arg-type]
        ridge=ridge,
        progress=_counting("setting"),
        **samples.names,  # type: ignore[arg-type]
    )


def _counting(what: str) -> "Callable[[int, int], None] | None":
    """What counts on a terminal how much of a search is done; None: there is no terminal."""

    def progress(done: int, total: int) -> None:
        print(f"\r{what} {done} of {total}", end="\r\033[K" if done == total else "", file=sys.stderr, flush=True)

    return progress if sys.stderr.isatty() else None


def selected(
    samples: SampleTable, make: "Callable[[np.ndarray, np.ndarray], Sugeno]", folds: int, order: str
) -> tuple[list[dict[str, Any]], SampleTable]:
    """The steps of :func:`fuzzy.fitting.selection.select_inputs` with names, and the samples with the inputs chosen."""
    from fuzzy.fitting.selection import select_inputs

    found = select_inputs(samples.x, samples.y, make, folds=folds, order=order, progress=_counting("input"))
    names = samples.names["input_names"]
    steps = [
        {"inputs": [names[k] for k in step.inputs], "error": step.error, "deviation": step.deviation}
        for step in found.steps
    ]
    kept = {key: [of[k] for k in found.chosen] if key.startswith("input") else of for key, of in samples.names.items()}
    return steps, samples._replace(x=samples.x[:, found.chosen], names=kept)


def setting_of(trial: "Trial") -> dict[str, float]:
    """The setting of clustering that a trial used, by name."""
    return {"radius": trial.radius, **asdict(trial.options)}


def draw_search(result: "SearchResult", plot: Path | None) -> None:
    """Draw the search, if a picture was asked for."""
    if plot is not None:
        from fuzzy.figures.drawing import save_figure
        from fuzzy.figures.search import plot_rules_error

        save_figure(plot_rules_error(result), plot)
