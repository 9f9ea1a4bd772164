"""The command ``anfis train``: learn a system from a table."""

import sys
import warnings
from collections.abc import Sequence
from contextlib import suppress
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

from anfis.commands.pruning import pruned, pruning_object, say_pruning
from anfis.commands.shared import CommandError, Data, TrainingData
from anfis.commands.validation import crossed, folds_object, say_folds
from anfis.methods.catalogue import METHODS
from fuzzy.commands.completion import completed, rule_bases
from fuzzy.commands.datafile import Folds, FoldsOrder, SkipBad, columns_of, numbers, opened
from fuzzy.commands.samples import Inputs, Outputs
from fuzzy.commands.shared import check_plot, read_either
from fuzzy.errors import quoted
from fuzzy.files.atomic import check_target
from fuzzy.files.columnchoice import chosen_columns, names_of
from fuzzy.shell.interrupts import interrupted
from fuzzy.shell.options import FieldOptions, Json, Quiet, Shown, option
from fuzzy.shell.progress import Mover, progress_bar
from fuzzy.shell.terminal import print_json
from fuzzy.shown import shown

if TYPE_CHECKING:
    import numpy as np

    from anfis import CrossValidation, Epoch, Options, Pruned, Training
    from fuzzy import Type2Sugeno
    from fuzzy.system import Sugeno

    _Tested = tuple[CrossValidation | None, Pruned | None]


@dataclass(frozen=True, kw_only=True)
class TrainingStart:
    """Where training starts; exactly one of the first four is given."""

    start: Annotated[
        Path | None,
        option(
            "Start from this .fis file, or a packaged one's name; one of type 2 learns by backprop.",
            "START",
            autocompletion=rule_bases,
        ),
    ] = None
    rules: Annotated[int | None, option("Start from that many clusters; their settings are searched.", min=1)] = None
    radius: Annotated[float | None, option("Start from clusters of this radius, a share of the data's ranges.")] = None
    grid: Annotated[int | None, option("Start from a grid of that many terms an input.", min=2)] = None
    mf: Annotated[str | None, option("Membership function of --grid's terms. [default: gbellmf]", "NAME")] = None


def _methods(incomplete: str) -> list[str]:
    return completed(incomplete, METHODS)


_Options = Annotated[
    "Options",
    FieldOptions(
        "anfis.methods.options:Options",
        *("method", "epochs", "step", "patience", "goal", "ridge", "batch", "keep_order", "seed"),
        method=Shown(complete=_methods),
        epochs=Shown(default=60),
        seed=Shown(doc="Seed of mini-batches (backprop), of shuffled folds and of what --prune holds."),
    ),
]


def train(
    *,
    data: Data,
    out: Annotated[Path, option("Where the trained system goes.", "--out", "-o", "NET.fis")],
    inputs: Inputs = None,
    outputs: Outputs = None,
    one_hot: Annotated[
        list[str] | None,
        option("A column of texts, coded as one column of 0 and 1 for each; repeat it.", "--one-hot", "COLUMN"),
    ] = None,
    check: Annotated[Path | None, option("Checking data, not learnt from; same columns.", "CHECK.csv")] = None,
    test: Annotated[Path | None, option("Test data, whose error is only measured; same columns.", "TEST.csv")] = None,
    begin: Annotated["TrainingStart", FieldOptions("anfis.commands.train:TrainingStart")],
    options: _Options,
    folds: Folds = None,
    fold_order: FoldsOrder = "shuffled",
    prune: Annotated[bool, option("Take away rules that contribute least; the checking data choose how many.")] = False,
    keep_rules: Annotated[int | None, option("With --prune: keep N rules instead of a choice.", "N", min=1)] = None,
    choice: Annotated[
        str,
        option("With --prune: fewest rules within one-standard-error of the least checking error, or least.", "CHOICE"),
    ] = "one-standard-error",
    checkpoint: Annotated[Path | None, option("Write a checkpoint here after every epoch.", "FILE")] = None,
    resume: Annotated[Path | None, option("Go on from this checkpoint.", "FILE")] = None,
    history: Annotated[Path | None, option("Write the errors of every epoch here.", "FILE.csv")] = None,
    plot: Annotated[
        Path | None,
        option("Draw the errors of every epoch, with --prune of every number of rules: .png, .pdf or .svg.", "PICTURE"),
    ] = None,
    skip_bad: SkipBad = False,
    json: Json = False,
    quiet: Quiet = False,
) -> None:
    """Learn a system from a table and write the one of least checking error (training error without --check).

    Columns that are not used may hold anything. Numbers have a decimal point or a decimal comma. --one-hot codes
    texts; anfis predict and anfis evaluate code such a column of their table likewise.

    --folds tells the error on samples that were not learnt from; the written system learns from all. --prune
    trains, takes rules away step by step and trains again; without --check a quarter of the samples chooses how many
    stay.

    \b
    Example:
      fuzzy example samples check
      anfis train samples.csv --outputs v --check check.csv --rules 8 -o net.fis --plot error.png
      anfis train samples.csv --outputs v --rules 8 --folds 5 -o net.fis
      anfis train samples.csv --outputs v --grid 5 --prune --test check.csv -o small.fis --plot rules.png
    """
    # Before an hour of learning, not after.
    check_plot(plot)
    check_target(out, ".fis")
    check_target(history)
    check_target(checkpoint)
    if begin.mf is not None and begin.grid is None:
        raise CommandError("--mf says what --grid is made of: give --grid too")
    _check_together(folds, prune, keep_rules, checkpoint or resume)
    _say_unread(options, folds is not None or prune)
    given = _given_system(begin)
    if prune and given is not None and given.upper is not given:
        raise CommandError("--prune takes away rules of type-1 systems: leave it out, or start from one")
    samples = _samples(data, inputs, outputs, one_hot or (), check, test, given, skip_bad)
    fis = given or _starting_fold(begin, samples, samples.x, samples.y, exact=True)
    tested: _Tested = None, None
    if prune:
        found = pruned(fis, samples, options, keep_rules, choice, quiet)  # type: ignore[arg-type]
        result, tested = found.training, (None, found)
    else:
        if folds is not None:
            of = given or partial(_starting_fold, begin, samples)
            tested = crossed(of, samples, options, folds, fold_order, quiet), None
        result = _learn(fis, samples, options, checkpoint, resume, quiet)
    _write(result, out, history, plot, tested[1], given is None)
    _say(result, out, samples, tested, fold_order, json)
    if "interrupted" in (result.stopped, prune and found.stopped):
        interrupted(f"the best so far is in {out}")


def _check_together(folds: int | None, prune: bool, keep: int | None, checkpoint: Path | None) -> None:
    """Refuse options that do not go together."""
    if keep is not None and not prune:
        raise CommandError("--keep-rules says how many rules --prune keeps: give --prune too")
    if prune and folds is not None:
        raise CommandError("--prune chooses by the checking data and --folds by none: give one of them")
    if prune and checkpoint is not None:
        raise CommandError("--prune trains many times, and a checkpoint is of one training: leave --checkpoint out")


def _say_unread(options: "Options", seeded: bool) -> None:
    """Warn of options that are not the default and that nothing reads; ``seeded`` if something else reads the seed."""
    from anfis.methods.method import make_method

    others = {name for method in METHODS for name in make_method(method).reads}
    for name in sorted(others - {*make_method(options.method).reads, *(("seed",) if seeded else ())}):
        if getattr(options, name) != type(options).__dataclass_fields__[name].default:
            warnings.warn(f"--{name} changes nothing: the method {options.method} does not read it", stacklevel=2)


def _given_system(start: TrainingStart) -> "Sugeno | Type2Sugeno | None":
    """The system in the file to start from, if there is one."""
    if [start.start, start.rules, start.radius, start.grid].count(None) != 3:
        raise CommandError("say where to start: exactly one of --start, --rules, --radius and --grid")
    return None if start.start is None else read_either(start.start)


def _samples(
    data: Path,
    inputs: str | None,
    outputs: str | None,
    one_hot: Sequence[str],
    check: Path | None,
    test: Path | None,
    start: "Sugeno | Type2Sugeno | None",
    skip_bad: bool,
) -> TrainingData:
    """The chosen columns: those of the system to start from, where the header names all of them and none is chosen."""
    from fuzzy.files.table import DataError

    text = opened(data, () if start is None else start.inputs)
    for column in one_hot:
        text = text.coded(column)
        print(f"{text.file}: {quoted(column)} is coded as {', '.join(text.codes[-1].names)}", file=sys.stderr)
    places: list[int] | None = None
    if start is not None and inputs is None and outputs is None:
        with suppress(DataError):
            places = columns_of(text, [*start.inputs, *start.outputs])
        n = len(start.inputs)
    if places is None:
        of, to = chosen_columns(text, inputs, outputs)
        places, n = [*of, *to], len(of)
    table = numbers(text, places, skip_bad, n)
    x, y = table.values[:, :n], table.values[:, n:]
    skipped, others = len(table.skipped), list[tuple[Any, Any] | None]()
    for path in (check, test):
        if path is None:
            others.append(None)
            continue
        other = opened(path)
        for code in text.codes:
            other = other.coded(code.name, code.categories)
        held = numbers(other, [other.place(*column) for column in zip(table.names, table.units, strict=True)], skip_bad)
        others.append((held.values[:, :n], held.values[:, n:]))
        skipped += len(held.skipped)
    return TrainingData(names_of(table, n), x, y, others[0], others[1], skipped)


def _starting_fold(
    start: TrainingStart, samples: TrainingData, x: "np.ndarray", y: "np.ndarray", exact: bool = False
) -> "Sugeno":
    """The system to start from that some of the samples make; as near as they come to the wanted number of rules."""
    from fuzzy.fitting.identification import identify
    from fuzzy.fitting.search import search_clusters

    names: dict[str, Any] = {**samples.names}
    if start.grid is not None:
        return identify(x, y, "grid", mfs=start.grid, kind=start.mf or "gbellmf", **names)
    if start.radius is not None:
        return identify(x, y, "subtractive", radius=start.radius, **names)
    assert start.rules is not None
    best = search_clusters(x, y, start.rules, **names).by_rules
    if start.rules not in best and (exact or not best):
        known = ", ".join(map(str, best))
        raise CommandError(f"no setting of the clustering gives {start.rules} rules; they give {known}")
    wanted = start.rules
    trial = best[min(best, key=lambda rules: (abs(rules - wanted), rules))]
    return identify(x, y, "subtractive", radius=trial.radius, options=trial.options, **names)


def _learn(
    fis: "Sugeno | Type2Sugeno",
    samples: TrainingData,
    options: "Options",
    checkpoint: Path | None,
    resume: Path | None,
    quiet: bool,
) -> "Training":
    """The training, with a progress bar on stderr."""
    import anfis

    with progress_bar(quiet, width=44) as begin:
        move = Mover(begin("training", options.epochs + 1))

        def show(row: "Epoch") -> None:
            checked = f", checking {shown(row.check)}" if samples.check is not None else ""
            move(row.epoch + 1, f"epoch {row.epoch}: training {shown(row.train)}{checked}")

        return anfis.train(
            fis,
            samples.x,
            samples.y,
            options,
            check=samples.check,
            callback=show,
            checkpoint=checkpoint,
            resume=resume,
        )


def _write(
    result: "Training", out: Path, history: Path | None, plot: Path | None, found: "Pruned | None", made: bool
) -> None:
    """Write what was learnt; a system that was ``made`` from the data has its terms named by where they stand now."""
    from fuzzy.files.fisfile import write_fis
    from fuzzy.fitting.termnames import with_telling_names

    write_fis(with_telling_names(result.system) if made else result.system, out)
    if history is not None:
        from fuzzy.files.table import write_frame

        write_frame(result.table(), history)
    if plot is not None:
        from anfis.plot import plot_pruning, plot_training
        from fuzzy.figures.drawing import save_figure

        drawn = plot_training(result.history) if found is None else plot_pruning(found, _unit(result.system))
        save_figure(drawn, plot)


def _unit(fis: "Sugeno | Type2Sugeno") -> str:
    """The unit of all outputs, if they have the same."""
    units = {v.unit for v in fis.outputs}
    return units.pop() if len(units) == 1 else ""


def _say(result: "Training", out: Path, samples: TrainingData, tested: "_Tested", order: str, json: bool) -> None:
    from anfis.accuracy import total_rmse

    first, best, last = result.history[0], result.history[result.best], len(result.history) - 1
    count, (folds, found) = len(result.system.rules), tested
    of_test = float("nan") if samples.test is None else total_rmse(result.system, *samples.test)
    if json:
        print_json(
            {
                "file": str(out),
                "rules": count,
                "parameters": result.parameters,
                "start": first._asdict(),
                "best": best._asdict(),
                # Of the system as it was written
                "rmse": {"train": result.rmse, "check": result.check_rmse, "test": of_test},
                "epochs": last,
                "stopped": result.stopped,
                "skipped": samples.skipped,
                **({} if folds is None else {"folds": folds_object(folds, order, result.options.seed)}),
                **({} if found is None else {"pruning": pruning_object(found)}),
            }
        )
        return
    unit = _unit(result.system)

    def error(value: float) -> str:
        return f"{shown(value)} {unit}".rstrip()

    if folds is not None:
        say_folds(folds, order, unit)
    if found is not None:
        say_pruning(found, unit)
    more = (("checking", result.check_rmse), ("test", of_test))
    others = "".join(f", {error(value)} {name}" for name, value in more if value == value)
    print(
        f"{out}: {count} rules; RMSE {error(first.train)} at the start, {error(result.rmse)} training{others} at "
        f"epoch {best.epoch} of {last} (stopped: {result.stopped})",
        *(f"note: {remark}" for remark in result.remarks),
        sep="\n",
    )
