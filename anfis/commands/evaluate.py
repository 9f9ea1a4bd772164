"""The command ``anfis evaluate``: a system's errors on a table."""

from anfis.commands.shared import Data, Fis, Json, read
from fuzzy.shell.terminal import print_json
from fuzzy.shown import shown


def evaluate(fis: Fis, data: Data, json: Json = False) -> None:
    """Measure a system's errors on a table that holds its inputs and outputs, found by their names.

    \b
    Example:
      fuzzy example samples check
      anfis train samples.csv --rules 8 -o net.fis
      anfis evaluate net.fis check.csv --json
    """
    from anfis.accuracy import accuracy
    from fuzzy.files.fisfile import read_fis
    from fuzzy.files.packaged import find_fis

    system, table = read_fis(find_fis(fis)), read(data)
    x, y = (table.columns([v.name for v in variables]) for variables in (system.inputs, system.outputs))
    rows = accuracy(system, x, y)
    if json:
        print_json({"samples": len(y), "outputs": {name: row._asdict() for name, row in rows.items()}})
        return
    for name, row in rows.items():
        rmse, mae, largest = (shown(value) for value in (row.rmse, row.mae, row.max))
        print(f"{name}: RMSE {rmse}, MAE {mae}, largest {largest}, R² {row.r2:.4f}")
