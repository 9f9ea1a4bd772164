"""The command ``anfis train``: learn a system from a table."""

import sys
import warnings
from contextlib import suppress
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, NamedTuple

import typer

from anfis.commands.shared import CommandError, Data, Json
from anfis.methods.catalogue import METHODS
from fuzzy.commands.completion import completed, rule_bases
from fuzzy.commands.datafile import SkipBad, chosen_columns, columns_of, numbers, opened
from fuzzy.commands.samples import Inputs, Outputs
from fuzzy.shell.terminal import INTERRUPTED, print_json
from fuzzy.shown import shown

if TYPE_CHECKING:
    import numpy as np

    from anfis import Epoch, Options, Training
    from fuzzy.system import Sugeno


class _Samples(NamedTuple):
    names: dict[str, list[str]]  # and units, as identify and search_clusters take them
    x: "np.ndarray"  # (samples, inputs)
    y: "np.ndarray"  # (samples, outputs)
    check: "tuple[np.ndarray, np.ndarray] | None"
    skipped: int  # rows that were left out, checking data included


class _Start(NamedTuple):
    """Where training starts; exactly one of the first four is given."""

    start: Path | None
    rules: int | None
    radius: float | None
    grid: int | None
    mf: str | None


def _methods(incomplete: str) -> list[str]:
    return completed(incomplete, METHODS)


def train(
    data: Data,
    out: Annotated[Path, typer.Option("--out", "-o", metavar="NET.fis", help="Where the trained system goes.")],
    inputs: Inputs = None,
    outputs: Outputs = None,
    check: Annotated[
        Path | None, typer.Option(metavar="CHECK.csv", help="Checking data, not learnt from; same columns.")
    ] = None,
    start: Annotated[
        Path | None,
        typer.Option(
            metavar="START", help="Start from this .fis file, or a packaged one's name.", autocompletion=rule_bases
        ),
    ] = None,
    rules: Annotated[
        int | None, typer.Option(min=1, help="Start from that many clusters; their settings are searched.")
    ] = None,
    radius: Annotated[
        float | None, typer.Option(help="Start from clusters of this radius, a share of the data's ranges.")
    ] = None,
    grid: Annotated[int | None, typer.Option(min=2, help="Start from a grid of that many terms an input.")] = None,
    mf: Annotated[
        str | None, typer.Option(metavar="NAME", help="Membership function of --grid's terms. [default: gbellmf]")
    ] = None,
    method: Annotated[
        str, typer.Option(help=f"How to learn: {', '.join(METHODS)}.", autocompletion=_methods)
    ] = "hybrid",
    epochs: Annotated[int, typer.Option(min=0, help="The most epochs to learn for.")] = 60,
    step: Annotated[float, typer.Option(help="Length of the first step (hybrid), in units of the universes.")] = 0.01,
    patience: Annotated[
        int, typer.Option(min=0, help="Stop that many epochs after the least checking error; 0: never.")
    ] = 0,
    goal: Annotated[float, typer.Option(help="Stop at this training RMSE, in the outputs' unit.")] = 0.0,
    ridge: Annotated[
        float, typer.Option(help="Times the square of the consequents, added to the mean square error; no unit.")
    ] = 0.0,
    batch: Annotated[
        int, typer.Option(min=0, help="Samples a step (backprop), else samples held at a time; 0: the method's own.")
    ] = 0,
    keep_order: Annotated[
        bool, typer.Option("--keep-order", help="Keep an input's memberships in order and overlapping.")
    ] = False,
    seed: Annotated[int, typer.Option(min=0, help="Seed of the order of mini-batches (backprop).")] = 0,
    checkpoint: Annotated[
        Path | None, typer.Option(metavar="FILE", help="Write a checkpoint here after every epoch.")
    ] = None,
    resume: Annotated[Path | None, typer.Option(metavar="FILE", help="Go on from this checkpoint.")] = None,
    history: Annotated[
        Path | None, typer.Option(metavar="FILE.csv", help="Write the errors of every epoch here.")
    ] = None,
    plot: Annotated[
        Path | None, typer.Option(metavar="PICTURE", help="Draw the errors of every epoch: .png, .pdf or .svg.")
    ] = None,
    skip_bad: SkipBad = False,
    json: Json = False,
    quiet: Annotated[bool, typer.Option("--quiet", "-q", help="Show no progress bar.")] = False,
) -> None:
    """Learn a system from a table and write the one of least checking error (training error without --check).

    Columns that are not used may hold anything. Numbers have a decimal point or a decimal comma.

    \b
    Example:
      fuzzy example samples check
      anfis train samples.csv --outputs v --check check.csv --rules 8 -o net.fis --plot error.png
    """
    import anfis

    _check_files(out, history, plot, checkpoint)
    if mf is not None and grid is None:
        raise CommandError("--mf says what --grid is made of: give --grid too")
    options = anfis.Options(
        method=method,
        epochs=epochs,
        step=step,
        patience=patience,
        goal=goal,
        ridge=ridge,
        batch=batch,
        keep_order=keep_order,
        seed=seed,
    )
    _say_unread(options)
    begin = _Start(start, rules, radius, grid, mf)
    given = _given_system(begin)
    samples = _samples(data, inputs, outputs, check, given, skip_bad)
    fis = _starting_system(begin, samples) if given is None else given
    result = _learn(fis, samples, options, checkpoint, resume, quiet)
    _write(result, out, history, plot)
    _say(result, out, samples.skipped, json)
    if result.stopped == "interrupted":
        print(f"anfis: interrupted; the best so far is in {out}", file=sys.stderr)
        raise typer.Exit(INTERRUPTED)


def _check_files(out: Path, history: Path | None, plot: Path | None, checkpoint: Path | None) -> None:
    """Refuse files that cannot be written: before an hour of learning, not after."""
    if plot is not None:
        from fuzzy.figures.drawing import check_picture

        check_picture(plot)
    if out.suffix != ".fis":
        raise CommandError(f"{out}: the file's name must end in .fis")
    for path in (out, history, plot, checkpoint):
        if path is not None and (path.is_dir() or not path.resolve().parent.is_dir()):
            raise CommandError(f"{path}: cannot be written: it is a folder, or its folder does not exist")


def _say_unread(options: "Options") -> None:
    """Warn of options that are not the default and that the method does not read."""
    from anfis.methods.method import make_method

    others = {name for method in METHODS for name in make_method(method).reads}
    for name in sorted(others - set(make_method(options.method).reads)):
        if getattr(options, name) != type(options).__dataclass_fields__[name].default:
            warnings.warn(f"--{name} changes nothing: the method {options.method} does not read it", stacklevel=2)


def _given_system(start: _Start) -> "Sugeno | None":
    """The system in the file to start from, if there is one."""
    from fuzzy.files.fisfile import read_fis
    from fuzzy.files.packaged import find_fis

    if sum(choice is not None for choice in start[:4]) != 1:
        raise CommandError("say where to start: exactly one of --start, --rules, --radius and --grid")
    return None if start.start is None else read_fis(find_fis(start.start))


def _samples(
    data: Path, inputs: str | None, outputs: str | None, check: Path | None, start: "Sugeno | None", skip_bad: bool
) -> _Samples:
    """The chosen columns: those of the system to start from, where the header names all of them and none is chosen."""
    from fuzzy.files.table import DataError

    text = opened(data)
    places: list[int] | None = None
    if start is not None and inputs is None and outputs is None:
        with suppress(DataError):
            places = columns_of(text, [*start.inputs, *start.outputs])
        n = len(start.inputs)
    if places is None:
        of, to = chosen_columns(text, inputs, outputs)
        places, n = [*of, *to], len(of)
    table = numbers(text, places, skip_bad)
    names = {
        "input_names": list(table.names[:n]),
        "output_names": list(table.names[n:]),
        "input_units": list(table.units[:n]),
        "output_units": list(table.units[n:]),
    }
    x, y = table.values[:, :n], table.values[:, n:]
    if check is None:
        return _Samples(names, x, y, None, len(table.skipped))
    other = opened(check)
    held = numbers(other, [other.place(*column) for column in zip(table.names, table.units, strict=True)], skip_bad)
    checking = held.values[:, :n], held.values[:, n:]
    return _Samples(names, x, y, checking, len(table.skipped) + len(held.skipped))


def _starting_system(start: _Start, samples: _Samples) -> "Sugeno":
    """The system to start from, made of clusters or a grid."""
    from fuzzy.fitting.identification import identify
    from fuzzy.fitting.search import search_clusters

    x, y = samples.x, samples.y
    names: dict[str, Any] = {**samples.names}
    if start.grid is not None:
        return identify(x, y, "grid", mfs=start.grid, kind=start.mf or "gbellmf", **names)
    if start.radius is not None:
        return identify(x, y, "subtractive", radius=start.radius, **names)
    assert start.rules is not None
    best = search_clusters(x, y, start.rules, **names).by_rules
    if start.rules not in best:
        known = ", ".join(map(str, best))
        raise CommandError(f"no setting of the clustering gives {start.rules} rules; they give {known}")
    trial = best[start.rules]
    return identify(x, y, "subtractive", radius=trial.radius, options=trial.options, **names)


def _learn(
    fis: "Sugeno", samples: _Samples, options: "Options", checkpoint: Path | None, resume: Path | None, quiet: bool
) -> "Training":
    """The training, with a progress bar on stderr."""
    import anfis
    from fuzzy.shell.progress import progress_bar

    with progress_bar(quiet, width=44) as begin:
        done = 0
        advance = begin("training", options.epochs + 1)

        def show(row: "Epoch") -> None:
            nonlocal done
            checked = f", checking {shown(row.check)}" if samples.check is not None else ""
            while done <= row.epoch:  # resumed, the bar begins with the epochs that are not computed again
                advance(f"epoch {row.epoch}: training {shown(row.train)}{checked}")
                done += 1

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


def _write(result: "Training", out: Path, history: Path | None, plot: Path | None) -> None:
    from fuzzy.files.fisfile import write_fis

    write_fis(result.system, out)
    if history is not None:
        from fuzzy.files.table import write_frame

        write_frame(result.table(), history)
    if plot is not None:
        from anfis.plot import plot_training
        from fuzzy.figures.drawing import save_figure

        save_figure(plot_training(result.history), plot)


def _say(result: "Training", out: Path, skipped: int, json: bool) -> None:
    first, best, last = result.history[0], result.history[result.best], len(result.history) - 1
    count = len(result.system.rules)
    if json:
        print_json(
            {
                "file": str(out),
                "rules": count,
                "parameters": result.parameters,
                "start": first._asdict(),
                "best": best._asdict(),
                "rmse": {"train": result.rmse, "check": result.check_rmse},  # of the system as it was written
                "epochs": last,
                "stopped": result.stopped,
                "skipped": skipped,
            }
        )
        return
    units = {v.unit for v in result.system.outputs}
    unit = units.pop() if len(units) == 1 else ""

    def error(value: float) -> str:
        return f"{shown(value)} {unit}".rstrip()

    checked = f", {error(result.check_rmse)} checking" if result.check_rmse == result.check_rmse else ""
    print(
        f"{out}: {count} rules; RMSE {error(first.train)} at the start, {error(result.rmse)} training{checked} at "
        f"epoch {best.epoch} of {last} (stopped: {result.stopped})"
    )
