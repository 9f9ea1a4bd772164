"""What ``fuzzy identify`` and ``fuzzy search`` share: the table of samples, the search and its picture."""

import re
import sys
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, NamedTuple

import typer

from fuzzy.commands.shared import usage

if TYPE_CHECKING:
    import numpy as np

    from fuzzy.fitting.search import SearchResult, Trial

Table = Annotated[
    Path, typer.Argument(metavar="DATA.csv", help="Samples, a row each, with or without a header.", show_default=False)
]
Inputs = Annotated[
    str | None,
    typer.Option(metavar="A,B", help="Columns by name or number from 1; by default all that are no outputs."),
]
Outputs = Annotated[
    str | None, typer.Option(metavar="Y", help="Columns by name or number from 1; by default the last.")
]
Plot = Annotated[
    Path | None, typer.Option(metavar="PICTURE", help="Draw the search: error against rules, .png, .pdf or .svg.")
]
Order = Annotated[int, typer.Option(min=0, max=1, help="Consequents: 1 linear, 0 constant.")]
Ridge = Annotated[float, typer.Option(min=0, help="Weight of the squared consequents beside the mean error.")]


class SampleTable(NamedTuple):
    """The chosen columns of a table."""

    x: "np.ndarray"  # (samples, inputs)
    y: "np.ndarray"  # (samples, outputs)
    names: dict[str, list[str]]  # the names and units, as identify and search_clusters take them


def sample_table(file: Path, inputs: str | None, outputs: str | None) -> SampleTable:
    """The chosen columns of the table; a header "name [unit]" is taken apart."""
    from fuzzy.files.table import DataError, read_table

    header, table = read_table(file)
    columns = table.shape[1]
    if columns < 2:
        raise DataError(f"{file}: one column; inputs and outputs need at least two")
    parts = [re.fullmatch(r"(.*\S)\s*\[([^\[\]]*)\]", text) for text in header or ()]
    names = [part[1] if part else text for part, text in zip(parts, header or (), strict=True)]
    units = [part[2] if part else "" for part in parts]
    known: dict[str, int] = {str(i + 1): i for i in range(columns)}
    known |= {text: i for labels in (header or (), names) for i, text in enumerate(labels)}
    to = [columns - 1] if outputs is None else _places(outputs, known)
    if outputs is None and inputs is not None and columns - 1 in _places(inputs, known):
        usage("the last column is among the inputs: say which are the --outputs")
    of = [i for i in range(columns) if i not in to] if inputs is None else _places(inputs, known)
    both = [i for i in of if i in to]
    if both:
        usage(f"column {both[0] + 1} is both an input and an output")
    if not of:
        usage("every column is an output: no inputs are left")
    named: dict[str, list[str]] = {}
    if header is not None:
        named = {
            "input_names": [names[i] for i in of],
            "output_names": [names[i] for i in to],
            "input_units": [units[i] for i in of],
            "output_units": [units[i] for i in to],
        }
    return SampleTable(table[:, of], table[:, to], named)


def _places(texts: str, known: dict[str, int]) -> list[int]:
    from fuzzy.naming import expected

    places: list[int] = []
    # A name that holds a comma is taken whole.
    for text in [texts] if texts in known else [part.strip() for part in texts.split(",")]:
        if text not in known:
            # Each column by the last of its names: the bare one, or the number in a table without a header.
            usage(expected(text, {place: name for name, place in known.items()}.values(), "column"))
        if known[text] in places:
            usage(f"column {text!r} is named twice")
        places.append(known[text])
    return places


def searched(samples: SampleTable, rules: int, order: int, ridge: float, radii: str | None = None) -> "SearchResult":
    """Search the settings of subtractive clustering for ``rules`` rules, with a progress line on a terminal."""
    from fuzzy.fitting.search import RADII, search_clusters

    def progress(done: int, total: int) -> None:
        print(f"\rsetting {done} of {total}", end="\r\033[K" if done == total else "", file=sys.stderr, flush=True)

    return search_clusters(
        samples.x,
        samples.y,
        rules,
        radii=RADII if radii is None else [_number(text) for text in radii.split(",")],
        order=order,  # type: ignore[arg-type]
        ridge=ridge,
        progress=progress if sys.stderr.isatty() else None,
        **samples.names,  # type: ignore[arg-type]
    )


def setting_of(trial: "Trial") -> dict[str, float]:
    """The setting of clustering that a trial used, by name."""
    options = trial.options
    return {
        "radius": trial.radius,
        "squash": options.squash,
        "accept": options.accept,
        "reject": options.reject,
    }


def check_search_picture(plot: Path | None) -> None:
    """Refuse a picture of an unknown kind before anything is computed."""
    if plot is not None:
        from fuzzy.figures.drawing import check_picture

        check_picture(plot)


def draw_search(result: "SearchResult", plot: Path | None) -> None:
    """Draw the search, if a picture was asked for."""
    if plot is not None:
        from fuzzy.figures.drawing import save_figure
        from fuzzy.figures.search import plot_rules_error

        save_figure(plot_rules_error(result), plot)


def _number(text: str) -> float:
    try:
        return float(text)
    except ValueError:
        usage(f"expected a number, got {text!r}")
