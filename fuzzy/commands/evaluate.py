"""The command ``fuzzy evaluate``: a system at every row of a table."""

import sys
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

from fuzzy.commands.datafile import SkipBad, columns_of, numbers, opened
from fuzzy.commands.shared import FisOrTree, read_either, read_tree
from fuzzy.files.atomic import check_target
from fuzzy.shell.options import Json, argument, option
from fuzzy.shell.terminal import plain, print_json

if TYPE_CHECKING:
    import numpy as np

    from fuzzy import Tree, Type2Sugeno
    from fuzzy.files.table import TableText
    from fuzzy.system import Sugeno

_LISTED = 20  # names that a message lists


def evaluate(
    file: FisOrTree,
    inputs: Annotated[Path, argument("A column for each input.", "INPUTS.csv")],
    output_file: Annotated[Path | None, option("Instead of stdout.", "-o", "--output-file", "OUTPUTS.csv")] = None,
    skip_bad: SkipBad = False,
    json: Json = False,
) -> None:
    """Evaluate the system at every row of a table.

    A header that names the inputs, as "speed" or "speed [m/s]", says which column is which, in any order; otherwise the
    columns are the inputs in their order. The outputs get a header of the same kind if the inputs have one.

    \b
    Example:
      fuzzy example tipper meals errors
      fuzzy evaluate tipper.fis meals.csv -o tips.csv
      fuzzy evaluate lateral errors.csv
    """
    from fuzzy.files.table import table_text, write_table

    check_target(output_file)
    fis = read_tree(file) or read_either(file)
    text = opened(inputs, fis.inputs)
    table = numbers(text, _columns(fis, text), skip_bad)
    outputs = _evaluated(fis, table.values)
    names, units = ([v.name for v in fis.outputs], [v.unit for v in fis.outputs]) if table.headed else (None, None)
    if output_file is not None:
        write_table(output_file, names, outputs, units)
    if json:
        values = {v.name: plain(outputs[:, j]) for j, v in enumerate(fis.outputs)}
        print_json({"rows": len(outputs), "skipped": len(table.skipped), "outputs": values})
    elif output_file is None:
        sys.stdout.write(table_text(names, outputs, units))


def _columns(fis: "Sugeno | Type2Sugeno | Tree", text: "TableText") -> list[int]:
    """The table's columns in the order of the inputs."""
    from fuzzy.files.table import DataError

    missing: list[str] = []
    for variable in fis.inputs:
        try:
            text.place(variable.name, variable.unit)
        except DataError:
            if variable.name in (column.name for column in text.columns):
                raise  # several have this name
            missing.append(variable.name)
    known = [v.name for v in fis.inputs if v.name not in missing]
    if not missing:
        places = columns_of(text, fis.inputs)
        ignored = [column.title for place, column in enumerate(text.columns) if place not in places and column.title]
        if ignored:
            more = f" and {len(ignored) - _LISTED} more" if len(ignored) > _LISTED else ""
            print(f"ignored: {', '.join(ignored[:_LISTED])}{more}", file=sys.stderr)
        return places
    if known:
        raise DataError(f"{text.file}: the header names {', '.join(known)}, but not {', '.join(missing)}")
    inputs = [v.name for v in fis.inputs]
    if len(text.columns) != len(inputs):
        raise DataError(
            f"{text.file}: {len(text.columns)} columns, but {fis.name} has {len(inputs)} inputs: {', '.join(inputs)}"
        )
    if text.headed:
        print(f"the header names no input: the columns are taken to be {', '.join(inputs)}", file=sys.stderr)
    return list(range(len(inputs)))


def _evaluated(fis: "Sugeno | Type2Sugeno | Tree", x: "np.ndarray") -> "np.ndarray":
    """The outputs (rows, outputs), in portions that keep the memory small."""
    import numpy as np

    portion = 50_000
    return np.concatenate([fis(x[start : start + portion]) for start in range(0, len(x), portion)])
