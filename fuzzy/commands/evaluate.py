"""The command ``fuzzy evaluate``: a system at every row of a table."""

import sys
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from fuzzy.commands.shared import FisFile, Json, read_system
from fuzzy.shell.terminal import plain, print_json

if TYPE_CHECKING:
    import numpy as np

    from fuzzy.system import Sugeno


def evaluate(
    file: FisFile,
    inputs: Annotated[Path, typer.Argument(metavar="INPUTS.csv", help="A column for each input.", show_default=False)],
    output_file: Annotated[
        Path | None, typer.Option("-o", "--output-file", metavar="OUTPUTS.csv", help="Instead of stdout.")
    ] = None,
    json: Json = False,
) -> None:
    """Evaluate the system at every row of a table.

    A header that names the inputs says which column is which, in any order; otherwise the columns are the inputs
    in their order. The outputs get a header if the inputs have one.

    \b
    Example:
      fuzzy example tipper meals errors
      fuzzy evaluate tipper.fis meals.csv -o tips.csv
      fuzzy evaluate lateral errors.csv
    """
    from fuzzy.files.table import read_table, table_text, write_table

    fis = read_system(file)
    names, table = read_table(inputs)
    outputs = _evaluated(fis, _columns(fis, inputs, names, table))
    header = None if names is None else [v.name for v in fis.outputs]
    if output_file is not None:
        write_table(output_file, header, outputs)
    if json:
        values = {v.name: plain(outputs[:, j]) for j, v in enumerate(fis.outputs)}
        print_json({"rows": len(outputs), "outputs": values})
    elif output_file is None:
        sys.stdout.write(table_text(header, outputs))


def _columns(fis: "Sugeno", path: Path, names: Sequence[str] | None, table: "np.ndarray") -> "np.ndarray":
    """The table's columns (rows, inputs) in the order of the inputs."""
    from fuzzy.files.table import DataError

    inputs = [v.name for v in fis.inputs]
    if names is not None and all(name in names for name in inputs):
        ignored = [name for name in names if name not in inputs]
        if ignored:
            print(f"ignored: {', '.join(ignored)}", file=sys.stderr)
        return table[:, [list(names).index(name) for name in inputs]]
    known = [name for name in inputs if names is not None and name in names]
    if known:
        missing = ", ".join(name for name in inputs if name not in known)
        raise DataError(f"{path}: the header names {', '.join(known)}, but not {missing}")
    if table.shape[1] != len(inputs):
        raise DataError(
            f"{path}: {table.shape[1]} columns, but {fis.name} has {len(inputs)} inputs: {', '.join(inputs)}"
        )
    if names is not None:
        print(f"the header names no input: the columns are taken to be {', '.join(inputs)}", file=sys.stderr)
    return table


def _evaluated(fis: "Sugeno", x: "np.ndarray") -> "np.ndarray":
    """The outputs (rows, outputs), in portions that keep the memory small."""
    import numpy as np

    portion = 50_000
    return np.concatenate([fis(x[start : start + portion]) for start in range(0, len(x), portion)])
