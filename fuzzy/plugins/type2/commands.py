"""The command ``fuzzy type2``: an interval type-2 system of a type-1 one."""

from pathlib import Path
from typing import Annotated

from fuzzy.commands.shared import FisFile, parsed, read_system, usage
from fuzzy.plugins.type2.reduction import Reduction
from fuzzy.shell.options import Json, option
from fuzzy.shell.terminal import print_json


def type2(
    file: FisFile,
    output_file: Annotated[Path, option("The .fis file to write.", "-o", "--output-file", "OUT.fis")],
    lag: Annotated[
        str, option("The upper degree from which on a lower one is positive; two: left,right.", "--lag", "LAG")
    ] = "0.2",
    scale: Annotated[float, option("The greatest lower degree, in (0, 1].")] = 1.0,
    reduction: Annotated[Reduction, option("The type reduction; the first four are one interval.")] = "karnikmendel",
    matlab: Annotated[bool, option("Also write OUT.m, which makes MATLAB's own system of it.", "--matlab")] = False,
    json: Json = False,
) -> None:
    """Make an interval type-2 system: each term lies between FILE's membership function and a lower one.

    "fuzzy evaluate" takes the written file, and "fuzzy plot" draws its footprint of uncertainty. MATLAB reads
    it as the upper system. The documentation measures whether type-2 pays: "Does type-2 help?".

    \b
    Example:
      fuzzy example tipper meals
      fuzzy type2 tipper.fis --lag 0.2 --scale 0.9 -o tipper2.fis
      fuzzy evaluate tipper2.fis meals.csv
      fuzzy plot tipper2.fis -o footprint.pdf
    """
    from fuzzy.files.atomic import write_whole
    from fuzzy.files.fisfile import write_fis
    from fuzzy.plugins.type2.files import matlab_type2
    from fuzzy.plugins.type2.system import to_type2

    if output_file.suffix.lower() != ".fis":
        usage(f"the file to write ends in .fis, got {str(output_file)!r}")
    lags = [parsed(float, word, "--lag takes one number or two with a comma between them") for word in lag.split(",")]
    fis = to_type2(read_system(file), lags[0] if len(lags) == 1 else tuple(lags), scale, reduction)  # type: ignore[arg-type]
    script = matlab_type2(fis, output_file.name) if matlab else None
    write_fis(fis, output_file)
    written = [str(output_file)]
    if script is not None:
        write_whole(output_file.with_suffix(".m"), script)
        written.append(str(output_file.with_suffix(".m")))
    print_json({"files": written}) if json else print("\n".join(written))
