"""The command ``anfis predict``: a system's outputs for a table."""

from pathlib import Path
from typing import Annotated

import typer

from anfis.commands.shared import Data, Fis, Json, read
from fuzzy.shell.terminal import print_json


def predict(
    fis: Fis,
    data: Data,
    out: Annotated[
        Path | None,
        typer.Option("--out", "-o", metavar="OUT.csv", help="Write the outputs here. Default: standard output."),
    ] = None,
    json: Json = False,
) -> None:
    """Compute a system's outputs for every row of a table; the inputs' columns are found by their names.

    \b
    Example:
      fuzzy example samples check
      anfis train samples.csv --rules 8 -o net.fis
      anfis predict net.fis check.csv -o predicted.csv
    """
    from fuzzy.files.fisfile import read_fis
    from fuzzy.files.packaged import find_fis
    from fuzzy.files.table import table_text, write_table

    system = read_fis(find_fis(fis))
    x = read(data).columns([v.name for v in system.inputs])
    found, headers = system(x), [v.name for v in system.outputs]
    if out is not None:
        write_table(out, headers, found)
    if json:
        outputs = {name: found[:, k] for k, name in enumerate(headers)}
        print_json({"samples": len(x), "outputs": outputs} | ({"file": str(out)} if out is not None else {}))
    elif out is None:
        print(table_text(headers, found), end="")
