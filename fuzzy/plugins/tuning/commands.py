"""The command ``fuzzy tune``: a system's numbers and choices, tuned on a table."""

import time
from collections.abc import Sequence
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

from fuzzy.commands.completion import rule_bases
from fuzzy.commands.datafile import Folds, FoldsOrder, SkipBad
from fuzzy.commands.samples import system_samples
from fuzzy.commands.shared import read_either, read_tree
from fuzzy.errors import InputError
from fuzzy.files.atomic import check_folder, check_target
from fuzzy.shell.interrupts import interrupted
from fuzzy.shell.options import Json, Quiet, argument, option
from fuzzy.shell.progress import Mover, progress_bar
from fuzzy.shell.terminal import print_json
from fuzzy.shown import shown
from fuzzy.words import split_list

if TYPE_CHECKING:
    from fuzzy.plugins.tuning.data import TunedFold, TunedSystem
    from fuzzy.tuning.search import Evaluations


def tune(
    data: Annotated[Path, argument("Columns for the system's inputs and outputs.", "DATA.csv")],
    file: Annotated[
        Path,
        argument(
            "The Sugeno system to start from: a .fis file, also of type-2, a packaged one's name, or a tree's folder.",
            "SYSTEM",
            autocompletion=rule_bases,
        ),
    ],
    out: Annotated[Path, option("Where the tuned system goes; of a tree a folder.", "--out", "-o", "TUNED.fis")],
    move: Annotated[
        str | None,
        option(
            "What may move: memberships, consequents, weights, choices, rules; of type-2 footprints. By default the "
            "first two, and footprints.",
            "A,B",
        ),
    ] = None,
    solve: Annotated[bool, option("Solve each candidate's consequents by least squares: they need not move.")] = False,
    symmetric: Annotated[bool, option("Keep the symmetry of a system that answers to both sides alike.")] = False,
    check: Annotated[Path | None, option("Data not tuned on; they choose among the best so far.", "CHECK.csv")] = None,
    evaluations: Annotated[int, option("How many systems are tried.", min=1)] = 1000,
    seed: Annotated[int, option("The seed of the search, and of shuffled folds.", min=0)] = 1,
    engine: Annotated[str, option("cmaes, or random.")] = "cmaes",
    folds: Folds = None,
    fold_order: FoldsOrder = "shuffled",
    folder: Annotated[
        Path | None, option("Keep the search here: after a stop the same command goes on from there.", "FOLDER")
    ] = None,
    fresh: Annotated[bool, option("Discard what FOLDER holds of a search.")] = False,
    history: Annotated[
        Path | None, option("Write a row an evaluation here: its error, its numbers.", "FILE.csv")
    ] = None,
    skip_bad: SkipBad = False,
    json: Json = False,
    quiet: Quiet = False,
) -> None:
    """Tune a system on a table: search the memberships and consequents with which it errs least.

    Memberships stay ordered and covering. The search needs no gradient, so weights of rules, choices of consequents and
    rules that are left out may move too. If only numbers move, `anfis train --start` learns faster. With
    --solve memberships move and the consequents follow, which gains far more in the same number of evaluations. Columns
    are found by name. Ctrl-C writes the best so far.

    \b
    Example:
      fuzzy example samples check
      fuzzy identify samples.csv --outputs v --rules 5 -o start.fis
      fuzzy tune samples.csv start.fis --check check.csv --solve --evaluations 200 --engine random -o t.fis
    """
    from fuzzy.files.fisfile import write_system
    from fuzzy.plugins.tuning.data import cross_validate_tuning
    from fuzzy.plugins.tuning.data import tune as tuned_on

    fis: Any = read_tree(file)
    if fis is None:
        check_target(out, ".fis")
        fis = read_either(file)
    else:
        check_folder(out)
    check_target(history)
    if folder is not None:
        check_folder(folder)
    samples = system_samples(fis, data, skip_bad)
    checking = system_samples(fis, check, skip_bad) if check is not None else None
    options: dict[str, Any] = {
        "move": None if move is None else _parts(move),
        "solve": solve,
        "symmetric": symmetric,
        "evaluations": evaluations,
        "seed": seed,
        "engine": engine,
        "check": None if checking is None else (checking.x, checking.y),
        "fresh": fresh,
    }
    began = time.monotonic()
    crossed: Sequence[TunedFold] = ()
    with progress_bar(quiet, width=44) as begin:
        if folds is not None:
            bar = Mover(begin("folds", folds * evaluations))
            crossed = cross_validate_tuning(
                fis,
                samples.x,
                samples.y,
                folds=folds,
                order=fold_order,  # type: ignore[arg-type]
                folder=folder,
                progress=lambda fold, of: _told(bar, of, fold * evaluations, f"fold {fold + 1}: "),
                **options,
            )
        found = tuned_on(
            fis,
            samples.x,
            samples.y,
            folder=folder,
            progress=partial(_told, Mover(begin(fis.name, evaluations))),
            **options,
        )
    write_system(found.system, out, _comment(found, data, check, options))
    if history is not None:
        from fuzzy.files.table import write_frame

        write_frame(found.table(), history)
    skipped = samples.skipped + (checking.skipped if checking is not None else 0)
    seconds = time.monotonic() - began
    if json:
        print_json(_as_json(found, crossed, fold_order, out, skipped, seconds))
    else:
        _print(found, crossed, out, seconds)
    if found.stopped == "interrupted":
        interrupted(f"the best of {found.evaluations} evaluations is in {out}")


def _told(moved: Mover, found: "Evaluations", done: int = 0, prefix: str = "") -> None:
    """Move the bar beyond the ``done`` evaluations of other folds, and say the least error so far."""
    before, best = shown(float(found.costs[0])), shown(float(found.costs.min()))
    moved(done + len(found), f"{prefix}RMSE {before} before, best {best}")


def _parts(text: str) -> list[str]:
    parts = split_list(text)
    if not parts:
        raise InputError(
            "--move: at least one of memberships, consequents, weights, choices, rules, footprints is needed"
        )
    return parts


def _comment(found: "TunedSystem[Any]", data: Path, check: Path | None, options: dict[str, Any]) -> str:
    """What stands at the top of the tuned system: a title, and how it was made."""
    checked = f", chosen on {check.name}" if check is not None else ""
    solved = ", consequents solved by least squares" if options["solve"] else ""
    return (
        f"{found.space.fis.name}, tuned on {data.name}{checked}\n"
        f"What moved: {', '.join(found.space.move)}{solved}; {found.evaluations} evaluations of {options['engine']}, "
        f"seed {options['seed']}; RMSE {shown(found.before)} before, {shown(found.after)} after"
    )


def _as_json(
    found: "TunedSystem[Any]", crossed: "Sequence[TunedFold]", order: str, out: Path, skipped: int, seconds: float
) -> dict[str, Any]:
    import numpy as np

    errors = [fold.after for fold in crossed]
    folds = {
        "count": len(crossed),
        "order": order,
        "mean": float(np.mean(errors)) if errors else None,
        "std": float(np.std(errors, ddof=1)) if errors else None,
        "each": [{"held": len(f.held), "before": f.before, "after": f.after} for f in crossed],
    }
    return {
        "before": found.before,
        "after": found.after,
        "check": {"before": found.check_before, "after": found.check_after},
        "evaluations": found.evaluations,
        "parameters": len(found.space.parameters),
        "result": str(out),
        "stopped": found.stopped,
        "skipped": skipped,
        "seconds": seconds,
        **({"folds": folds} if crossed else {}),
    }


def _print(found: "TunedSystem[Any]", crossed: "Sequence[TunedFold]", out: Path, seconds: float) -> None:
    import numpy as np

    units = {v.unit for v in found.system.outputs}
    unit = f" {next(iter(units))}".rstrip() if len(units) == 1 else ""
    if crossed:
        print(
            f"RMSE{f' [{unit.strip()}]' if unit else ''} of {len(crossed)} folds, at the samples that were held back:"
        )
        print("  fold  held back     before      after")
        for k, fold in enumerate(crossed):
            print(f"  {k + 1:4d}  {len(fold.held):9d}  {shown(fold.before):>9}  {shown(fold.after):>9}")
        errors = [fold.after for fold in crossed]
        print(f"  mean {shown(float(np.mean(errors)))}, standard deviation {shown(float(np.std(errors, ddof=1)))}")
    checked = ""
    if found.check_after == found.check_after:
        checked = f"; checking {shown(found.check_before)}{unit} before, {shown(found.check_after)}{unit} after"
    print(
        f"{out}: RMSE {shown(found.before)}{unit} before, {shown(found.after)}{unit} after {found.evaluations} "
        f"evaluations of {len(found.space.parameters)} parameters{checked}; {seconds:.0f} s"
    )
