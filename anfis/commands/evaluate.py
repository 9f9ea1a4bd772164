"""The command ``anfis evaluate``: a system's errors on a table."""

from anfis.commands.shared import Data, Fis
from fuzzy.commands.datafile import SkipBad
from fuzzy.commands.samples import system_samples
from fuzzy.commands.shared import read_either
from fuzzy.shell.options import Json
from fuzzy.shell.terminal import print_json
from fuzzy.shown import shown


def evaluate(fis: Fis, data: Data, skip_bad: SkipBad = False, json: Json = False) -> None:
    """Measure a system's errors on a table that holds its inputs and outputs, found by their names.

    Other columns may hold anything.

    \b
    Example:
      fuzzy example samples check
      anfis train samples.csv --rules 8 -o net.fis
      anfis evaluate net.fis check.csv --json
    """
    from anfis.accuracy import accuracy

    system = read_either(fis)
    samples = system_samples(system, data, skip_bad)
    rows = accuracy(system, samples.x, samples.y)
    if json:
        counted = {"samples": len(samples.x), "skipped": samples.skipped}
        print_json({**counted, "outputs": {name: row._asdict() for name, row in rows.items()}})
        return
    for variable, row in zip(system.outputs, rows.values(), strict=True):
        rmse, mae, largest = (f"{shown(error)} {variable.unit}".rstrip() for error in row[:3])
        print(f"{variable.name}: RMSE {rmse}, MAE {mae}, largest {largest}, R² {row.r2:.4f}")
