"""The commands ``fuzzy identify`` and ``fuzzy search``: a system from a table of samples."""

import re
import sys
from enum import StrEnum
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, NamedTuple, NoReturn

import typer

from fuzzy.shell.terminal import FAILED, print_json

if TYPE_CHECKING:
    import numpy as np

    from fuzzy.fitting.search import SearchResult, Trial

Table = Annotated[
    Path, typer.Argument(metavar="DATA.csv", help="Samples, a row each, with or without a header.", show_default=False)
]
Inputs = Annotated[
    str | None,
    typer.Option(metavar="A,B", help="Columns by name or number from 1; by default all that are no outputs."),
]
Outputs = Annotated[
    str | None, typer.Option(metavar="Y", help="Columns by name or number from 1; by default the last.")
]
Plot = Annotated[
    Path | None, typer.Option(metavar="PICTURE", help="Draw the search: error against rules, .png, .pdf or .svg.")
]
Order = Annotated[int, typer.Option(min=0, max=1, help="Consequents: 1 linear, 0 constant.")]
Ridge = Annotated[float, typer.Option(min=0, help="Weight of the squared consequents beside the mean error.")]
Json = Annotated[bool, typer.Option("--json", help="Print one JSON object instead of text.")]


class Method(StrEnum):
    """How the antecedents are found."""

    grid = "grid"
    subtractive = "subtractive"
    fcm = "fcm"


class _Samples(NamedTuple):
    x: "np.ndarray"  # (samples, inputs)
    y: "np.ndarray"  # (samples, outputs)
    names: dict[str, list[str]]  # the names and units, as identify and search_clusters take them


def identify(
    file: Table,
    inputs: Inputs = None,
    outputs: Outputs = None,
    method: Annotated[Method, typer.Option(help="How the antecedents are found.")] = Method.subtractive,
    output_file: Annotated[
        Path | None,
        typer.Option("-o", "--output-file", metavar="OUT.fis", help="By default DATA's name with .fis, here."),
    ] = None,
    rules: Annotated[
        int | None, typer.Option(min=1, metavar="N", help="Search the settings for N rules (subtractive).")
    ] = None,
    radius: Annotated[
        float | None, typer.Option(help="Radius of a cluster, a share of the range (subtractive). [default: 0.5]")
    ] = None,
    squash: Annotated[float | None, typer.Option(help="Squash factor (subtractive). [default: 1.25]")] = None,
    accept: Annotated[float | None, typer.Option(help="Accept ratio (subtractive). [default: 0.5]")] = None,
    reject: Annotated[float | None, typer.Option(help="Reject ratio (subtractive). [default: 0.15]")] = None,
    mfs: Annotated[
        str | None, typer.Option(metavar="N[,N...]", help="Terms an input, or of each (grid). [default: 2]")
    ] = None,
    kind: Annotated[
        str | None, typer.Option(metavar="NAME", help="Membership functions, MATLAB's name (grid). [default: gbellmf]")
    ] = None,
    clusters: Annotated[
        int | None, typer.Option(min=1, help="Number of clusters (fcm). [default: as subtractive finds]")
    ] = None,
    seed: Annotated[int | None, typer.Option(min=0, help="Seed of the random start (fcm). [default: 0]")] = None,
    order: Order = 1,
    ridge: Ridge = 0.0,
    fit: Annotated[bool, typer.Option("--fit/--no-fit", help="Fit the consequents, or leave them 0.")] = True,
    plot: Plot = None,
    json: Json = False,
) -> None:
    """Make a system from samples: antecedents by a grid or by clusters, consequents by least squares.

    With --rules the settings of subtractive clustering are searched for the best system with that number of rules,
    as `fuzzy search` does. A header "speed [m/s]" names the column speed.

    Example: fuzzy identify samples.csv --inputs x,y --outputs v --method subtractive --radius 0.5 -o net.fis
    """
    import numpy as np

    from fuzzy.files.fisfile import write_fis
    from fuzzy.fitting.clustering import Options
    from fuzzy.fitting.identification import identify as identified

    cluster = {"squash": squash, "accept": accept, "reject": reject}
    settings: dict[str, Any] = {"radius": radius, "mfs": mfs, "kind": kind, "clusters": clusters, "seed": seed}
    _only(method, Method.grid, {"mfs": mfs, "kind": kind})
    _only(method, Method.fcm, {"clusters": clusters, "seed": seed})
    _only(method, Method.subtractive, {"radius": radius, **cluster, "rules": rules, "plot": plot})
    if rules is not None and any(value is not None for value in (radius, *cluster.values())):
        _usage("--rules searches radius, squash, accept and reject: leave them out")
    if plot is not None and rules is None:
        _usage("--plot draws the search: it goes with --rules")
    if rules is not None and not fit:
        _usage("--rules compares fitted systems: leave --no-fit out")
    _check_picture(plot)
    target = Path(f"{file.stem}.fis") if output_file is None else output_file
    samples = _samples(file, inputs, outputs)
    if mfs is not None:
        counts = [_whole(text) for text in mfs.split(",")]
        settings["mfs"] = counts[0] if len(counts) == 1 else counts
    if any(value is not None for value in cluster.values()):
        settings["options"] = Options(**{name: value for name, value in cluster.items() if value is not None})
    found = None
    if rules is not None:
        found = _searched(samples, rules, order, ridge)
        settings.update(radius=found.best.radius, options=found.best.options)
        _draw(found, plot)
    fis = identified(
        samples.x,
        samples.y,
        method.value,
        name=target.stem,
        order=order,  # type: ignore[arg-type]
        fit=fit,
        ridge=ridge,
        **samples.names,
        **{name: value for name, value in settings.items() if value is not None},
    )
    write_fis(fis, target)
    rmse = np.sqrt(np.mean((fis(samples.x) - samples.y) ** 2, axis=0))
    if json:
        errors = {v.name: float(error) for v, error in zip(fis.outputs, rmse, strict=True)}
        setting = {} if found is None else {"setting": _setting(found.best)}
        print_json({"file": str(target), "rules": len(fis.rules), "rmse": errors, **setting})
        return
    if found is not None:
        print(", ".join(f"{name} {value:g}" for name, value in _setting(found.best).items()))
    errors_text = ", ".join(
        f"{v.name} {error:.4g} {v.unit}".rstrip() for v, error in zip(fis.outputs, rmse, strict=True)
    )
    print(f"{target}: {len(fis.rules)} rules, RMSE of the samples: {errors_text}")


def search(
    file: Table,
    inputs: Inputs = None,
    outputs: Outputs = None,
    rules: Annotated[int, typer.Option(min=1, metavar="N", help="The number of rules that is wanted.")] = 8,
    radii: Annotated[str | None, typer.Option(metavar="R,R", help="Radii to try. [default: 0.3,0.5,0.7,0.9]")] = None,
    order: Order = 1,
    ridge: Ridge = 0.0,
    plot: Plot = None,
    json: Json = False,
) -> None:
    """Try every setting of subtractive clustering: the best error for each number of rules.

    The exit code is 1 if no setting gives the wanted number. `fuzzy identify --rules N` writes the best system.

    Example: fuzzy search samples.csv --inputs x,y --outputs v --rules 8 --plot error.png
    """
    _check_picture(plot)
    samples = _samples(file, inputs, outputs)
    result = _searched(samples, rules, order, ridge, radii)
    if result.by_rules:
        _draw(result, plot)
    missing = rules not in result.by_rules
    if json:
        rows = [{"rules": t.rules, "error": t.error, "rmse": t.rmse, **_setting(t)} for t in result.by_rules.values()]
        print_json({"settings": len(result.trials), "wanted": rules, "found": not missing, "best": rows})
    else:
        print(f"{len(result.trials)} settings, {result.fitted} different systems; error: {_error_name(result)}")
        print("  rules  error      radius  squash  accept  reject")
        for trial in result.by_rules.values():
            radius, *rest = _setting(trial).values()
            numbers = "".join(f"{value:8g}" for value in rest)
            mark = "  <- wanted" if trial.rules == rules else ""
            print(f"  {trial.rules:5d}  {trial.error:.3e}{radius:8g}{numbers}{mark}")
    if missing:
        print(f"no setting gives {rules} rules; try other --radii", file=sys.stderr)
        raise typer.Exit(FAILED)


def _setting(trial: "Trial") -> dict[str, float]:
    options = trial.options
    return {
        "radius": trial.radius,
        "squash": options.squash,
        "accept": options.accept,
        "reject": options.reject,
    }


def _error_name(result: "SearchResult") -> str:
    if len(result.outputs) > 1:
        return "RMSE / range over all outputs"
    name, unit = result.outputs[0]
    return f"RMSE of {name} [{unit}]" if unit else f"RMSE of {name}"


def _searched(samples: _Samples, rules: int, order: int, ridge: float, radii: str | None = None) -> "SearchResult":
    from fuzzy.fitting.search import RADII, search_clusters

    def progress(done: int, total: int) -> None:
        print(f"\rsetting {done} of {total}", end="\r\033[K" if done == total else "", file=sys.stderr, flush=True)

    return search_clusters(
        samples.x,
        samples.y,
        rules,
        radii=RADII if radii is None else [_number(text) for text in radii.split(",")],
        order=order,  # type: ignore[arg-type]
        ridge=ridge,
        progress=progress if sys.stderr.isatty() else None,
        **samples.names,  # type: ignore[arg-type]
    )


def _samples(file: Path, inputs: str | None, outputs: str | None) -> _Samples:
    """The chosen columns of the table; a header "name [unit]" is taken apart."""
    from fuzzy.files.table import DataError, read_table

    header, table = read_table(file)
    columns = table.shape[1]
    if columns < 2:
        raise DataError(f"{file}: one column; inputs and outputs need at least two")
    parts = [re.fullmatch(r"(.*\S)\s*\[([^\[\]]*)\]", text) for text in header or ()]
    names = [part[1] if part else text for part, text in zip(parts, header or (), strict=True)]
    units = [part[2] if part else "" for part in parts]
    known: dict[str, int] = {str(i + 1): i for i in range(columns)}
    known |= {text: i for labels in (header or (), names) for i, text in enumerate(labels)}
    to = [columns - 1] if outputs is None else _places(outputs, known)
    if outputs is None and inputs is not None and columns - 1 in _places(inputs, known):
        _usage("the last column is among the inputs: say which are the --outputs")
    of = [i for i in range(columns) if i not in to] if inputs is None else _places(inputs, known)
    both = [i for i in of if i in to]
    if both:
        _usage(f"column {both[0] + 1} is both an input and an output")
    if not of:
        _usage("every column is an output: no inputs are left")
    named: dict[str, list[str]] = {}
    if header is not None:
        named = {
            "input_names": [names[i] for i in of],
            "output_names": [names[i] for i in to],
            "input_units": [units[i] for i in of],
            "output_units": [units[i] for i in to],
        }
    return _Samples(table[:, of], table[:, to], named)


def _places(texts: str, known: dict[str, int]) -> list[int]:
    from fuzzy.naming import expected

    places: list[int] = []
    # A name that holds a comma is taken whole.
    for text in [texts] if texts in known else [part.strip() for part in texts.split(",")]:
        if text not in known:
            # Each column by the last of its names: the bare one, or the number in a table without a header.
            _usage(expected(text, {place: name for name, place in known.items()}.values(), "column"))
        if known[text] in places:
            _usage(f"column {text!r} is named twice")
        places.append(known[text])
    return places


def _only(method: Method, where: Method, values: dict[str, Any]) -> None:
    given = [f"--{name}" for name, value in values.items() if value is not None]
    if given and method is not where:
        _usage(f"{', '.join(given)} goes with --method {where.value}, not {method.value}")


def _check_picture(plot: Path | None) -> None:
    if plot is not None:
        from fuzzy.figures.drawing import check_picture

        check_picture(plot)


def _draw(result: "SearchResult", plot: Path | None) -> None:
    if plot is not None:
        from fuzzy.figures.drawing import save_figure
        from fuzzy.figures.search import plot_rules_error

        save_figure(plot_rules_error(result), plot)


def _whole(text: str) -> int:
    try:
        return int(text)
    except ValueError:
        _usage(f"expected a whole number, got {text!r}")


def _number(text: str) -> float:
    try:
        return float(text)
    except ValueError:
        _usage(f"expected a number, got {text!r}")


def _usage(message: str) -> NoReturn:
    raise typer.BadParameter(message)
