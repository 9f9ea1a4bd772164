"""The command ``anfis predict``: a system's outputs for a table."""

from pathlib import Path
from typing import Annotated

from anfis.commands.shared import Data, Fis
from fuzzy.commands.datafile import SkipBad, columns_of, numbers, opened
from fuzzy.commands.shared import read_system
from fuzzy.files.atomic import check_target
from fuzzy.shell.options import Json, option
from fuzzy.shell.terminal import print_json


def predict(
    fis: Fis,
    data: Data,
    out: Annotated[
        Path | None, option("Write the outputs here. Default: standard output.", "--out", "-o", "OUT.csv")
    ] = None,
    skip_bad: SkipBad = False,
    json: Json = False,
) -> None:
    """Compute a system's outputs for every row of a table; the inputs' columns are found by their names.

    The outputs get a header "name [unit]". What other columns hold does not matter.

    \b
    Example:
      fuzzy example samples check
      anfis train samples.csv --rules 8 -o net.fis
      anfis predict net.fis check.csv -o predicted.csv
    """
    from fuzzy.files.table import table_text, write_table

    check_target(out)
    system = read_system(fis)
    text = opened(data, system.inputs)
    table = numbers(text, columns_of(text, system.inputs), skip_bad)
    found = system(table.values)
    names, units = [v.name for v in system.outputs], [v.unit for v in system.outputs]
    if out is not None:
        write_table(out, names, found, units)
    if json:
        outputs = {name: found[:, k] for k, name in enumerate(names)}
        counted = {"samples": len(found), "skipped": len(table.skipped)}
        print_json({**counted, "outputs": outputs} | ({"file": str(out)} if out is not None else {}))
    elif out is None:
        print(table_text(names, found, units), end="")
