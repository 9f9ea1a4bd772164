"""The command ``fuzzy front``: systems of few rules and of many from a table of samples."""

import sys
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

from fuzzy.commands.datafile import FoldsOrder, SkipBad
from fuzzy.commands.samples import Inputs, Outputs, Table, sample_table, system_samples
from fuzzy.commands.shared import check_plot, parsed
from fuzzy.files.atomic import check_folder
from fuzzy.shell.options import Json, option
from fuzzy.shell.progress import Mover, progress_bar
from fuzzy.shell.terminal import print_json
from fuzzy.shown import shown

if TYPE_CHECKING:
    from fuzzy.plugins.front.search import RuleFrontPoint

_NUMBERS = "expected whole numbers with commas between them"


def front(
    *,
    file: Table,
    inputs: Inputs = None,
    outputs: Outputs = None,
    output_folder: Annotated[
        Path, option("The folder for the systems and front.csv.", "-o", "--output-folder", "FOLDER")
    ],
    rules: Annotated[int, option("The most rules.", "N", min=1)] = 8,
    terms: Annotated[str, option("How many terms an input may have.", "N,N")] = "2,3,5",
    orders: Annotated[str, option("Consequents that are tried: 0 constant, 1 linear.", "N,N")] = "0,1",
    ridge: Annotated[float, option("Weight of the squared consequents beside the mean error, above 0.")] = 1e-4,
    folds: Annotated[int, option("Number of folds that judge.", "K", min=2)] = 5,
    fold_order: FoldsOrder = "shuffled",
    generations: Annotated[int, option("Generations of the search, 60 candidates each.", "N", min=1)] = 100,
    test: Annotated[
        Path | None, option("A table of samples that the search does not see: each system's error there.", "TEST.csv")
    ] = None,
    plot: Annotated[Path | None, option("Draw error against size, .png, .pdf or .svg.", "PICTURE")] = None,
    seed: Annotated[int, option("Seed of the search and of the folds.", min=0)] = 0,
    skip_bad: SkipBad = False,
    json: Json = False,
) -> None:
    """Search for rules, and write the systems that are exact for their size: 1.fis, 2.fis and so on, smallest first.

    NSGA-II (needs pymoo) searches the number of rules, what each asks for, how many terms an input has and
    whether consequents are linear; these follow by least squares. Errors are of held-back samples, in units of the
    outputs' spread. They chose the rules, so samples that the search has not seen (--test) say more. The
    mark stands at the smallest system whose error is within one standard error of the least.

    \b
    Example:
      fuzzy example samples
      fuzzy front samples.csv --inputs x,y --outputs v --rules 4 --generations 10 -o front --plot front.png
    """
    from fuzzy.files.atomic import write_whole
    from fuzzy.files.fisfile import write_fis
    from fuzzy.fitting.selection import spread_of
    from fuzzy.plugins.front.search import search_rules

    check_plot(plot)
    check_folder(output_folder)
    counts, tried = ([parsed(int, n, _NUMBERS) for n in text.split(",")] for text in (terms, orders))
    samples = sample_table(file, inputs, outputs, skip_bad)
    with progress_bar(not sys.stderr.isatty()) as begin:
        move = Mover(begin("generations", generations))
        found = search_rules(
            samples.x,
            samples.y,
            rules=rules,
            terms=counts,
            orders=tried,
            ridge=ridge,
            folds=folds,
            fold_order=fold_order,
            generations=generations,
            seed=seed,
            progress=lambda done, total: move(done),
            **samples.names,
        )
    rows = found.table()
    if test is not None:
        rows["test"] = [_test_error(point, test, spread_of(samples.y), skip_bad) for point in found.points]
    output_folder.mkdir(parents=True, exist_ok=True)
    rows["file"] = [str(output_folder / f"{k}.fis") for k in range(1, len(rows) + 1)]
    for k, point in enumerate(found.points, 1):
        told = f"{k} of {len(rows)} of a front: error {shown(point.error)} of the outputs' spread"
        write_fis(replace(point.system, name=f"front-{k}"), output_folder / f"{k}.fis", told)
    write_whole(output_folder / "front.csv", rows.to_csv(index=False, lineterminator="\n"))
    if plot is not None:
        from fuzzy.figures.drawing import save_figure
        from fuzzy.plugins.front.figures import plot_rule_front

        save_figure(plot_rule_front(found), plot)
    if json:
        counted = {"samples": len(samples.x), "skipped": samples.skipped, "evaluated": found.evaluated}
        print_json({**counted, "chosen": found.chosen + 1, "points": rows.to_dict("records")})
        return
    print(f"{found.evaluated} candidates; error: cross-validated RMSE, in units of the outputs' spread")
    print(f"  file   rules  conditions  operations  error{'  test   ' if test is not None else ''}           inputs")
    for k, row in rows.iterrows():
        tested = f"  {shown(row['test']):>7}" if test is not None else ""
        print(
            f"  {Path(row['file']).name:6} {row['rules']:5d}  {row['conditions']:10d}  {row['operations']:10d}"
            f"  {shown(row['error']):>7} ± {shown(row['deviation']):7}{tested}  {row['inputs']}"
            f"{'  <- fewest' if k == found.chosen else ''}"
        )


def _test_error(point: "RuleFrontPoint", file: Path, spread: Any, skip_bad: bool) -> float:
    import numpy as np

    from fuzzy.inference import infer_quietly

    samples = system_samples(point.system, file, skip_bad)
    residual = infer_quietly(point.system, samples.x).output - samples.y
    return float(np.sqrt(np.mean((residual / spread) ** 2)))
