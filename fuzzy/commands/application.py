"""The command line ``fuzzy``: look at a rule base, check it, draw it, evaluate it, identify one from data.

Data goes to stdout, messages to stderr. What a command needs is imported when it runs, so that ``--help`` is quick.
"""

import sys
from collections.abc import Sequence
from enum import StrEnum
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, NoReturn

import typer

from fuzzy.commands import design as designcommand
from fuzzy.commands import fitting as datacommand
from fuzzy.errors import InputError
from fuzzy.shell.terminal import FAILED, application, plain, print_json, run

if TYPE_CHECKING:
    import numpy as np

    from fuzzy.system import Sugeno

app = application("Look at, check, draw, evaluate and identify Sugeno fuzzy systems in MATLAB's .fis files.")

FisFile = Annotated[Path, typer.Argument(metavar="FILE", help="A Sugeno system, a .fis file.", show_default=False)]
Json = Annotated[bool, typer.Option("--json", help="Print one JSON object instead of text.")]
Picture = Annotated[
    Path | None,
    typer.Option("-o", "--output-file", metavar="PICTURE", help="The picture to write: .png, .pdf or .svg."),
]
At = Annotated[
    list[str] | None,
    typer.Option("--at", metavar="INPUT=VALUE", help="An input's value; repeat it. The others are at midrange."),
]


class PlotKind(StrEnum):
    """The pictures that ``fuzzy plot`` draws."""

    memberships = "memberships"
    rules = "rules"
    structure = "structure"


class SurfaceKind(StrEnum):
    """The ways in which ``fuzzy surface`` draws."""

    contour = "contour"
    solid = "3d"
    both = "both"


def main(arguments: Sequence[str] | None = None) -> int:
    """Run the command line and return the exit code: 0 fine, 1 a check found something, 2 an error, 130 Ctrl-C."""
    return run(app, (InputError,), "fuzzy", arguments)


def _version(wanted: bool) -> None:
    if wanted:
        from importlib.metadata import version

        import numpy

        python = ".".join(map(str, sys.version_info[:3]))
        print(f"fuzzyfleet {version('fuzzyfleet')} (numpy {numpy.__version__}, Python {python})")
        raise typer.Exit


@app.callback()
def _options(
    version: Annotated[
        bool, typer.Option("--version", callback=_version, is_eager=True, help="Print the versions and stop.")
    ] = False,
) -> None:
    pass


@app.command()
def show(file: FisFile, json: Json = False) -> None:
    """Show the system: its choices, variables, terms and rules.

    Example: fuzzy show tipper.fis
    """
    from fuzzy.insight.description import as_dict, describe

    fis = _read(file)
    print_json(as_dict(fis)) if json else print(describe(fis))


@app.command()
def rules(file: FisFile, json: Json = False) -> None:
    """Print the rules as sentences, one on each line.

    Example: fuzzy rules tipper.fis
    """
    sentences = [str(rule) for rule in _read(file).rules]
    if json:
        print_json({"rules": sentences})
    else:
        print("".join(sentence + "\n" for sentence in sentences), end="")


@app.command()
def plot(
    file: FisFile,
    output_file: Picture = None,
    kind: Annotated[PlotKind, typer.Option(help="What to draw.")] = PlotKind.memberships,
    variable: Annotated[
        str | None, typer.Option(metavar="NAME", help="Only this variable's terms (memberships).")
    ] = None,
    at: At = None,
    only_fired: Annotated[bool, typer.Option("--only-fired", help="Only rules that fire (rules).")] = False,
    json: Json = False,
) -> None:
    """Draw the membership functions, the rule viewer at a point, or the structure.

    Without -o the picture is FILE's name with the kind, a .png in this folder.

    Example: fuzzy plot tipper.fis --kind rules --at service=3 -o a.pdf
    """
    fis = _read(file)
    path = _picture(output_file, file, kind.value)
    if variable is not None and kind is not PlotKind.memberships:
        _usage(f"--variable goes with --kind memberships, not {kind.value}")
    if (at or only_fired) and kind is not PlotKind.rules:
        _usage(f"--at and --only-fired go with --kind rules, not {kind.value}")
    from fuzzy.figures.plot import plot_memberships, plot_rules, plot_structure, save_figure
    from fuzzy.insight.universe import point_of

    if kind is PlotKind.memberships:
        figure = plot_memberships(fis, variable)
    elif kind is PlotKind.rules:
        figure = plot_rules(fis, point_of(fis, _values(fis, at or [])), only_fired)
    else:
        figure = plot_structure(fis)
    save_figure(figure, path)
    print_json({"file": str(path)}) if json else print(path)


@app.command()
def surface(
    file: FisFile,
    output_file: Picture = None,
    inputs: Annotated[
        str | None, typer.Option(metavar="A,B", help="One or two inputs for the axes; the first two by default.")
    ] = None,
    output: Annotated[str | None, typer.Option(metavar="NAME", help="The output; the first by default.")] = None,
    at: At = None,
    kind: Annotated[SurfaceKind, typer.Option(help="How to draw it.")] = SurfaceKind.contour,
    points: Annotated[int, typer.Option(min=2, max=2000, help="Grid points along each axis.")] = 61,
    json: Json = False,
) -> None:
    """Draw an output over one or two inputs; where no rule fires it is hatched.

    With --json the grid, the output and where a rule fires are printed, and a picture is written only with -o.

    Example: fuzzy surface tipper.fis --inputs service,food -o tip.pdf
    """
    fis = _read(file)
    axes = _axes(fis, inputs)
    fixed = _values(fis, at or [])
    which: str | int = 0 if output is None else output
    if json:
        from fuzzy.insight.surfacegrid import surface as surface_data

        data = surface_data(fis, axes, which, fixed, points)
    path = None
    if output_file is not None or not json:
        path = _picture(output_file, file, "surface")
        from fuzzy.figures.plot import plot_surface, save_figure

        save_figure(plot_surface(fis, axes, which, fixed, points, kind=kind.value), path)
    if json:
        y = {} if data.y is None else {"y": data.y[:, 0]}
        x = data.x if data.y is None else data.x[0]
        file_name = {} if path is None else {"file": str(path)}
        print_json({"x": x, **y, "z": data.z, "fired": data.fired, **file_name})
    else:
        print(path)


@app.command()
def explain(
    file: FisFile,
    values: Annotated[list[str], typer.Argument(metavar="INPUT=VALUE...", help="Every input's value.")],
    json: Json = False,
) -> None:
    """Explain why the system answers what it answers at one point.

    Example: fuzzy explain tipper.fis service=3 food=8
    """
    from fuzzy.insight.explanation import explain as explain_point

    fis = _read(file)
    given = _values(fis, values)
    missing = [v.name for v in fis.inputs if v.name not in given]
    if missing:
        _usage(f"no value for {', '.join(missing)}; write {' '.join(f'{name}=...' for name in missing)}")
    explanation = explain_point(fis, [given[v.name] for v in fis.inputs])
    print_json(explanation.as_dict()) if json else print(explanation)


@app.command()
def check(
    file: FisFile,
    points: Annotated[int, typer.Option(min=1, help="Points at which to look for places without a rule.")] = 4096,
    seed: Annotated[int, typer.Option(min=0, help="Shifts the points.")] = 0,
    json: Json = False,
) -> None:
    """Look for defects: places where no rule fires, unused terms, contradictory rules and so on.

    The exit code is 1 if there are errors or warnings; notes do not count.

    Example: fuzzy check tipper.fis
    """
    from fuzzy.insight.diagnosis import check as check_system

    findings = check_system(_read(file), points, seed)
    failed = any(finding.severity != "note" for finding in findings)
    if json:
        fields = ("severity", "kind", "sentence", "where")
        listed = [{name: getattr(finding, name) for name in fields} for finding in findings]
        print_json({"ok": not failed, "findings": listed})
    else:
        for finding in findings:
            print(finding)
        if not findings:
            print("nothing found")
    if failed:
        raise typer.Exit(FAILED)


@app.command()
def evaluate(
    file: FisFile,
    inputs: Annotated[Path, typer.Argument(metavar="INPUTS.csv", help="A column for each input.", show_default=False)],
    output_file: Annotated[
        Path | None, typer.Option("-o", "--output-file", metavar="OUTPUTS.csv", help="Instead of stdout.")
    ] = None,
    json: Json = False,
) -> None:
    """Evaluate the system at every row of a table.

    A header that names the inputs says which column is which, in any order; otherwise the columns are the inputs
    in their order. The outputs get a header if the inputs have one.

    Example: fuzzy evaluate tipper.fis meals.csv -o tips.csv
    """
    from fuzzy.files.table import read_table, table_text, write_table

    fis = _read(file)
    names, table = read_table(inputs)
    outputs = _evaluated(fis, _columns(fis, inputs, names, table))
    header = None if names is None else [v.name for v in fis.outputs]
    if output_file is not None:
        write_table(output_file, header, outputs)
    if json:
        values = {v.name: plain(outputs[:, j]) for j, v in enumerate(fis.outputs)}
        print_json({"rows": len(outputs), "outputs": values})
    elif output_file is None:
        sys.stdout.write(table_text(header, outputs))


@app.command()
def convert(
    file: FisFile,
    target: Annotated[Path, typer.Argument(metavar="OUT", help="A .fis, .txt or .json file.", show_default=False)],
) -> None:
    """Write the system in another form, which OUT's suffix chooses.

    .fis is a normalised MATLAB file, .txt the rules as sentences, .json a description of everything.

    Example: fuzzy convert tipper.fis tipper.json
    """
    writers = {".fis": "a MATLAB file", ".txt": "the rules as sentences", ".json": "a description"}
    suffix = target.suffix.lower()
    if suffix not in writers:
        known = ", ".join(f"{ending} ({what})" for ending, what in writers.items())
        _usage(f"cannot tell the form from {str(target)!r}; end it in {known}")
    fis = _read(file)
    if suffix == ".fis":
        from fuzzy.files.fisfile import write_fis

        write_fis(fis, target)
        return
    from fuzzy.files.atomic import replacing

    if suffix == ".txt":
        text = "".join(f"{rule}\n" for rule in fis.rules)
    else:
        from json import dumps

        from fuzzy.insight.description import as_dict

        text = dumps(as_dict(fis), ensure_ascii=False, indent=2) + "\n"
    with replacing(target) as path:
        path.write_text(text, encoding="utf-8")


app.command()(datacommand.identify)
app.command()(datacommand.search)
app.command()(designcommand.design)


def _read(path: Path) -> "Sugeno":
    from fuzzy.files.fisfile import read_fis

    return read_fis(path)


def _usage(message: str) -> NoReturn:
    raise typer.BadParameter(message)


def _values(fis: "Sugeno", texts: Sequence[str]) -> dict[str, float]:
    """INPUT=VALUE texts by the input's name."""
    from fuzzy.naming import expected

    values: dict[str, float] = {}
    for text in texts:
        # From the right: a name may hold an equals sign, a number cannot.
        name, sign, number = text.rpartition("=")
        if not sign:
            _usage(f"expected INPUT=VALUE, got {text!r}")
        if name not in [v.name for v in fis.inputs]:
            _usage(expected(name, [v.name for v in fis.inputs], "input"))
        if name in values:
            _usage(f"two values for the input {name!r}")
        try:
            values[name] = float(number)
        except ValueError:
            _usage(f"the value of {name!r} must be a number, got {number!r}")
        if values[name] - values[name] != 0:
            _usage(f"the value of {name!r} must be finite, got {number!r}")
    return values


def _axes(fis: "Sugeno", inputs: str | None) -> list[str | int] | None:
    if inputs is None:
        return None
    # A name that holds a comma is taken whole.
    return [inputs] if inputs in [v.name for v in fis.inputs] else [name.strip() for name in inputs.split(",")]


def _picture(path: Path | None, file: Path, kind: str) -> Path:
    """The picture to write, refused before anything is drawn if its suffix is unknown."""
    from fuzzy.figures.drawing import check_picture

    path = Path(f"{file.stem}-{kind}.png") if path is None else path
    check_picture(path)
    return path


def _columns(fis: "Sugeno", path: Path, names: Sequence[str] | None, table: "np.ndarray") -> "np.ndarray":
    """The table's columns (rows, inputs) in the order of the inputs."""
    from fuzzy.files.table import DataError

    inputs = [v.name for v in fis.inputs]
    if names is not None and all(name in names for name in inputs):
        ignored = [name for name in names if name not in inputs]
        if ignored:
            print(f"ignored: {', '.join(ignored)}", file=sys.stderr)
        return table[:, [list(names).index(name) for name in inputs]]
    known = [name for name in inputs if names is not None and name in names]
    if known:
        missing = ", ".join(name for name in inputs if name not in known)
        raise DataError(f"{path}: the header names {', '.join(known)}, but not {missing}")
    if table.shape[1] != len(inputs):
        raise DataError(
            f"{path}: {table.shape[1]} columns, but {fis.name} has {len(inputs)} inputs: {', '.join(inputs)}"
        )
    if names is not None:
        print(f"the header names no input: the columns are taken to be {', '.join(inputs)}", file=sys.stderr)
    return table


def _evaluated(fis: "Sugeno", x: "np.ndarray") -> "np.ndarray":
    """The outputs (rows, outputs), in portions that keep the memory small."""
    import numpy as np

    portion = 50_000
    return np.concatenate([fis(x[start : start + portion]) for start in range(0, len(x), portion)])
