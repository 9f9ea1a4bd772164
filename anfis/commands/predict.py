"""The command ``anfis predict``: a system's outputs for a table."""

from pathlib import Path
from typing import Annotated

from anfis.commands.shared import CommandError, Data, Fis
from fuzzy.commands.datafile import SkipBad, columns_of, numbers, opened
from fuzzy.commands.samples import system_samples
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
    interval: Annotated[
        float | None,
        option("Add the bounds of the outputs for this share of new samples, such as 0.9.", "LEVEL"),
    ] = None,
    held_out: Annotated[
        Path | None, option("--interval: samples with outputs, from which NET was not learnt.", "DATA.csv")
    ] = None,
    skip_bad: SkipBad = False,
    json: Json = False,
) -> None:
    """Compute a system's outputs for every row of a table; the inputs' columns are found by their names.

    The outputs get a header "name [unit]". Other columns may hold anything. With --interval two columns follow
    each output, "name low" and "name high", and "outside" is 1 where the row lies outside the held-out data.

    \b
    Example:
      fuzzy example samples check
      anfis train samples.csv --rules 8 -o net.fis
      anfis predict net.fis check.csv -o predicted.csv
      anfis predict net.fis samples.csv --interval 0.9 --held-out check.csv
    """
    import numpy as np

    from fuzzy.files.table import table_text, write_table

    check_target(out)
    if (interval is None) != (held_out is None):
        raise CommandError(
            "--interval needs --held-out, samples from which the system was not learnt, and that needs it"
        )
    system = read_system(fis)
    text = opened(data, system.inputs)
    table = numbers(text, columns_of(text, system.inputs), skip_bad)
    found = system(table.values)
    names, units = [v.name for v in system.outputs], [v.unit for v in system.outputs]
    if interval is not None and held_out is not None:
        from anfis.intervals import calibrate

        samples = system_samples(system, held_out, skip_bad)
        told = calibrate(system, samples.x, samples.y)
        ends = told.interval(table.values, interval)
        found = np.column_stack(
            [*np.stack([found, ends.low, ends.high], axis=2).reshape(len(found), -1).T, told.outside(table.values)]
        )
        names = [*(f"{name}{end}" for name in names for end in ("", " low", " high")), "outside"]
        units = [*(unit for unit in units for _ in range(3)), ""]
    if out is not None:
        write_table(out, names, found, units)
    if json:
        outputs = {name: found[:, k] for k, name in enumerate(names)}
        counted = {"samples": len(found), "skipped": len(table.skipped)}
        print_json({**counted, "outputs": outputs} | ({"file": str(out)} if out is not None else {}))
    elif out is None:
        print(table_text(names, found, units), end="")
