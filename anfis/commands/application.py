"""The command line ``anfis``: train a Sugeno system on a table, predict with it, evaluate it.

Data goes to stdout, progress and messages to stderr. What a command needs is imported when it runs, so that
``--help`` is quick.
"""

import sys
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from fuzzy.errors import InputError
from fuzzy.shell.terminal import INTERRUPTED, application, print_json, run

if TYPE_CHECKING:
    import numpy as np

    from anfis.state import Epoch
    from fuzzy.system import Sugeno

app = application("Learn Sugeno fuzzy systems from data.")

Data = Annotated[Path, typer.Argument(metavar="DATA.csv", help="A table of numbers with a header line.")]
Fis = Annotated[Path, typer.Argument(metavar="NET.fis", help="A Sugeno system, a .fis file.")]
Json = Annotated[bool, typer.Option("--json", help="Print one JSON object instead of text.")]


class CommandError(InputError):
    """Options of the command line that do not go together, or columns that a table lacks."""


def main(arguments: Sequence[str] | None = None) -> int:
    """Run the command line and return the exit code: 0 fine, 2 an error, 130 Ctrl-C."""
    return run(app, (InputError,), "anfis", arguments)


def _version(wanted: bool) -> None:
    if wanted:
        from importlib.metadata import version

        python = ".".join(map(str, sys.version_info[:3]))
        print(f"fuzzyfleet {version('fuzzyfleet')} (torch {version('torch')}, Python {python})")
        raise typer.Exit


@app.callback()
def options(
    version: Annotated[
        bool, typer.Option("--version", callback=_version, is_eager=True, help="Print the versions and stop.")
    ] = False,
) -> None:
    """Learn Sugeno fuzzy systems from data.

    Example: anfis train data.csv --inputs x1,x2 --outputs y --rules 8 --epochs 60 -o net.fis
    """


@app.command()
def train(
    data: Data,
    out: Annotated[Path, typer.Option("--out", "-o", metavar="NET.fis", help="Where the trained system goes.")],
    inputs: Annotated[str | None, typer.Option(help="Columns, comma-separated. Default: all but the outputs.")] = None,
    outputs: Annotated[str | None, typer.Option(help="Columns, comma-separated. Default: the last one.")] = None,
    check: Annotated[Path | None, typer.Option(metavar="CHECK.csv", help="Checking data, same columns.")] = None,
    start: Annotated[Path | None, typer.Option(metavar="START.fis", help="Start from this system.")] = None,
    rules: Annotated[int | None, typer.Option(min=1, help="Start from that many clusters (search).")] = None,
    radius: Annotated[float | None, typer.Option(help="Start from clusters of this radius.")] = None,
    grid: Annotated[int | None, typer.Option(min=2, help="Start from that many terms an input.")] = None,
    mf: Annotated[
        str | None, typer.Option(metavar="NAME", help="--grid's membership function. [default: gbellmf]")
    ] = None,
    method: Annotated[str, typer.Option(help="hybrid, backprop, least-squares or second-order.")] = "hybrid",
    epochs: Annotated[int, typer.Option(min=0)] = 60,
    step: Annotated[float, typer.Option(help="hybrid: length of the first step, in ranges.")] = 0.01,
    patience: Annotated[int, typer.Option(min=0, help="Stop so many epochs after the best checking error.")] = 0,
    goal: Annotated[float, typer.Option(help="Stop at this training RMSE.")] = 0.0,
    ridge: Annotated[float, typer.Option(help="Of the least squares, relative.")] = 0.0,
    batch: Annotated[int, typer.Option(min=0, help="Samples at a time.")] = 0,
    keep_order: Annotated[bool, typer.Option("--keep-order", help="Memberships stay ordered and covering.")] = False,
    seed: Annotated[int, typer.Option(min=0, help="Of the order of mini-batches.")] = 0,
    checkpoint: Annotated[Path | None, typer.Option(metavar="FILE", help="Rewritten after every epoch.")] = None,
    resume: Annotated[Path | None, typer.Option(metavar="FILE", help="Go on from this checkpoint.")] = None,
    history: Annotated[Path | None, typer.Option(metavar="FILE.csv", help="The errors of every epoch.")] = None,
    plot: Annotated[Path | None, typer.Option(metavar="PICTURE", help="The error curve: .png, .pdf, .svg.")] = None,
    json: Json = False,
    quiet: Annotated[bool, typer.Option("--quiet", "-q", help="No progress bar.")] = False,
) -> None:
    """Learn a system from a table; the one of least checking (else training) error is written.

    Example: anfis train data.csv --outputs y --check check.csv --rules 8 -o net.fis --plot error.png
    """
    import anfis
    from fuzzy.files.fisfile import write_fis

    if plot is not None:
        from fuzzy.figures.drawing import check_picture

        check_picture(plot)
    if out.suffix != ".fis":
        raise CommandError(f"{out}: the file's name must end in .fis")
    if mf is not None and grid is None:
        raise CommandError("--mf says what --grid is made of: give --grid too")
    for path in (out, history, plot, checkpoint):
        # Before an hour of learning, not after.
        if path is not None and (path.is_dir() or not path.resolve().parent.is_dir()):
            raise CommandError(f"{path}: cannot be written: it is a folder, or its folder does not exist")
    settings = anfis.Options(
        method=method,  # type: ignore[arg-type]
        epochs=epochs,
        step=step,
        patience=patience,
        goal=goal,
        ridge=ridge,
        batch=batch,
        keep_order=keep_order,
        seed=seed,
    )
    names, values = _table(data)
    wanted = _names(outputs, names, data) if outputs is not None else [names[-1]]
    used = _names(inputs, names, data) if inputs is not None else [n for n in names if n not in wanted]
    both = [name for name in used if name in wanted]
    if both or not used:
        what = f"column {both[0]!r} is both an input and an output" if both else "every column is an output"
        raise CommandError(f"{data}: {what}; say --inputs and --outputs")
    x, y = _columns(names, values, used), _columns(names, values, wanted)
    held = None
    if check is not None:
        others, rows = _table(check)
        held = (
            _columns(others, rows, _names(",".join(used), others, check)),
            _columns(others, rows, _names(",".join(wanted), others, check)),
        )
    fis = _start(start, rules, radius, grid, mf, x, y, used, wanted)
    result = _train(fis, x, y, settings, held, checkpoint, resume, quiet)
    write_fis(result.system, out)
    if history is not None:
        from fuzzy.files.table import write_frame

        write_frame(result.table(), history)
    if plot is not None:
        from anfis.plot import plot_training
        from fuzzy.figures.drawing import save_figure

        save_figure(plot_training(result.history), plot)
    best = result.history[result.best]
    if json:
        print_json(
            {
                "file": str(out),
                "rules": len(fis.rules),
                "parameters": result.parameters,
                "start": result.history[0]._asdict(),
                "best": best._asdict(),
                "epochs": len(result.history) - 1,
                "stopped": result.stopped,
            }
        )
    else:
        checked = f", {best.check:.4g} checking" if held is not None else ""
        print(
            f"{out}: {len(fis.rules)} rules; RMSE {result.history[0].train:.4g} at the start, {best.train:.4g} training"
            f"{checked} at epoch {best.epoch} of {len(result.history) - 1} (stopped: {result.stopped})"
        )
    if result.stopped == "interrupted":
        print(f"anfis: interrupted; the best so far is in {out}", file=sys.stderr)
        raise typer.Exit(INTERRUPTED)


@app.command()
def predict(
    fis: Fis,
    data: Data,
    out: Annotated[
        Path | None, typer.Option("--out", "-o", metavar="OUT.csv", help="Default: standard output.")
    ] = None,
    json: Json = False,
) -> None:
    """The system's outputs for a table's inputs, found by their names.

    Example: anfis predict net.fis data.csv -o predicted.csv
    """
    from fuzzy.files.fisfile import read_fis
    from fuzzy.files.table import table_text, write_table

    system = read_fis(fis)
    names, values = _table(data)
    x = _columns(names, values, _names(",".join(v.name for v in system.inputs), names, data))
    found, headers = system(x), [v.name for v in system.outputs]
    if out is not None:
        write_table(out, headers, found)
    if json:
        outputs = {name: found[:, k] for k, name in enumerate(headers)}
        print_json({"samples": len(x), "outputs": outputs} | ({"file": str(out)} if out is not None else {}))
    elif out is None:
        print(table_text(headers, found), end="")


@app.command()
def evaluate(fis: Fis, data: Data, json: Json = False) -> None:
    """The system's errors on a table that holds its inputs and outputs, found by their names.

    Example: anfis evaluate net.fis check.csv --json
    """
    import numpy as np

    from fuzzy.files.fisfile import read_fis

    system = read_fis(fis)
    names, values = _table(data)
    wanted = [v.name for v in system.outputs]
    x = _columns(names, values, _names(",".join(v.name for v in system.inputs), names, data))
    y = _columns(names, values, _names(",".join(wanted), names, data))
    error = system(x) - y
    spread = ((y - y.mean(axis=0)) ** 2).sum(axis=0)
    rows = {
        name: {
            "rmse": float(np.sqrt(np.mean(error[:, k] ** 2))),
            "mae": float(np.mean(np.abs(error[:, k]))),
            "max": float(np.max(np.abs(error[:, k]))),
            "r2": float(1 - (error[:, k] ** 2).sum() / spread[k]) if spread[k] > 0 else float("nan"),
        }
        for k, name in enumerate(wanted)
    }
    if json:
        print_json({"samples": len(y), "outputs": rows})
        return
    for name, row in rows.items():
        print(f"{name}: RMSE {row['rmse']:.4g}, MAE {row['mae']:.4g}, largest {row['max']:.4g}, R² {row['r2']:.4f}")


def _table(path: Path) -> "tuple[tuple[str, ...], np.ndarray]":
    from fuzzy.files.table import read_table

    names, values = read_table(path)
    return names or tuple(f"column{k + 1}" for k in range(values.shape[1])), values


def _names(text: str, known: Sequence[str], file: Path) -> list[str]:
    from fuzzy.naming import expected

    names = [part.strip() for part in text.split(",") if part.strip()]
    if not names:
        raise CommandError("at least one column's name is needed")
    for name in names:
        if names.count(name) > 1:
            raise CommandError(f"column {name!r} is named twice")
        if name not in known:
            raise CommandError(f"{file}: {expected(name, known, 'column')}")
    return names


def _columns(names: Sequence[str], values: "np.ndarray", wanted: Sequence[str]) -> "np.ndarray":
    return values[:, [list(names).index(name) for name in wanted]]


def _start(
    start: Path | None,
    rules: int | None,
    radius: float | None,
    grid: int | None,
    mf: str | None,
    x: "np.ndarray",
    y: "np.ndarray",
    inputs: list[str],
    outputs: list[str],
) -> "Sugeno":
    """The system to start from: a file, clusters or a grid."""
    from fuzzy.files.fisfile import read_fis
    from fuzzy.fitting.identification import identify
    from fuzzy.fitting.search import search_clusters

    if sum(choice is not None for choice in (start, rules, radius, grid)) != 1:
        raise CommandError("say where to start: exactly one of --start, --rules, --radius and --grid")
    if start is not None:
        return read_fis(start)
    names: dict[str, Any] = {"input_names": inputs, "output_names": outputs}
    if grid is not None:
        return identify(x, y, "grid", mfs=grid, kind=mf or "gbellmf", **names)
    if radius is not None:
        return identify(x, y, "subtractive", radius=radius, **names)
    assert rules is not None
    best = search_clusters(x, y, rules, **names).by_rules
    if rules not in best:
        raise CommandError(f"no setting of the clustering gives {rules} rules; they give {', '.join(map(str, best))}")
    return identify(x, y, "subtractive", radius=best[rules].radius, options=best[rules].options, **names)


def _train(
    fis: "Sugeno",
    x: "np.ndarray",
    y: "np.ndarray",
    settings: Any,
    held: Any,
    checkpoint: Path | None,
    resume: Path | None,
    quiet: bool,
) -> Any:
    import anfis
    from fuzzy.shell.progress import progress_bar

    with progress_bar(quiet, width=44) as begin:
        done = 0
        advance = begin("training", settings.epochs + 1)

        def show(row: "Epoch") -> None:
            nonlocal done
            checked = f", checking {row.check:.4g}" if held is not None else ""
            while done <= row.epoch:  # resumed, the bar begins with the epochs that are not computed again
                advance(f"epoch {row.epoch}: training {row.train:.4g}{checked}")
                done += 1

        return anfis.train(fis, x, y, settings, check=held, callback=show, checkpoint=checkpoint, resume=resume)
