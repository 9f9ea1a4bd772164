"""The command ``fuzzy plot``: memberships, the rule viewer, the structure, or all pictures as a set."""

import sys
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Literal

from fuzzy.commands.shared import (
    At,
    FisOrTree,
    Picture,
    picture_path,
    read_either,
    read_tree,
    stem_of,
    usage,
    values_of,
)
from fuzzy.shell.options import Json, Quiet, option
from fuzzy.shell.terminal import print_json

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from fuzzy.system import Sugeno

PictureFormat = Literal["pdf", "svg", "png"]  # the formats of the pictures of a set
PlotKind = Literal["memberships", "rules", "structure"]  # the pictures that ``fuzzy plot`` draws


def plot(
    file: FisOrTree,
    output_file: Picture = None,
    kind: Annotated[PlotKind, option("What to draw; of a tree its systems and their wires.")] = "memberships",
    variable: Annotated[str | None, option("Only this variable's terms (memberships).", "NAME")] = None,
    at: At = None,
    only_fired: Annotated[bool, option("Only rules that fire (rules).")] = False,
    everything: Annotated[
        bool, option("All pictures, every surface too, in a .zip or a folder (-o).", "--all")
    ] = False,
    data: Annotated[Path | None, option("With --all, rows to compare the system with.", "--data", "DATA.csv")] = None,
    picture_format: Annotated[
        PictureFormat | None, option("The format of --all. [default: pdf]", "--format", show_default=False)
    ] = None,
    json: Json = False,
    quiet: Quiet = False,
) -> None:
    """Draw the membership functions, the rule viewer at a point, or the structure; or all pictures for a paper.

    Without -o the picture is FILE's name with the kind, a .png in this folder. --all draws the terms of each
    variable, the rule viewer at the point, the structure, the rule matrix, and each output over each pair of inputs (60
    at most). It also draws the step response of a loop's controller and its figures beside a PID, the path of a robot's
    rule base in a scenario that suits it, and the fit to --data. README.txt says which file shows what.

    \b
    Example:
      fuzzy example tipper
      fuzzy plot tipper.fis --kind rules --at service=3 -o a.pdf
      fuzzy plot tipper.fis --all -o figures.zip
      fuzzy plot tracking
    """
    import fuzzy

    if tree := read_tree(file):
        if everything or only_fired or at or data is not None or variable is not None or kind != "memberships":
            usage("of a tree its systems and their wires are drawn; of one of its .fis files everything")
        _save(picture_path(output_file, file, "tree"), fuzzy.plot_tree(tree), json)
        return
    fis = read_either(file)
    if not isinstance(fis, fuzzy.Sugeno):
        if everything or only_fired or at or data is not None or kind != "memberships":
            usage("of an interval type-2 system the memberships are drawn, with their footprint of uncertainty")
        _save(picture_path(output_file, file, kind), fuzzy.plot_footprint(fis, variable), json)
        return
    if everything:
        if variable is not None or only_fired or kind != "memberships":
            usage("--all draws everything; it goes with --at, --format, --data and -o only")
        _plot_all(fis, output_file, file, at, data, picture_format or "pdf", json, quiet)
        return
    if data is not None:
        usage("--data goes with --all")
    if picture_format is not None:
        usage("--format goes with --all; a single picture's format is the ending of -o")
    path = picture_path(output_file, file, kind)
    if variable is not None and kind != "memberships":
        usage(f"--variable goes with --kind memberships, not {kind}")
    if (at or only_fired) and kind != "rules":
        usage(f"--at and --only-fired go with --kind rules, not {kind}")
    from fuzzy.insight.universe import point_of

    if kind == "memberships":
        figure = fuzzy.plot_memberships(fis, variable)
    elif kind == "rules":
        figure = fuzzy.plot_rules(fis, point_of(fis, values_of(fis, at or [])), only_fired)
    else:
        figure = fuzzy.plot_structure(fis)
    _save(path, figure, json)


def _save(path: Path, figure: "Figure", json: bool) -> None:
    from fuzzy.figures.drawing import save_figure

    save_figure(figure, path)
    print_json({"file": str(path)}) if json else print(path)


def _plot_all(
    fis: "Sugeno",
    path: Path | None,
    file: Path,
    at: list[str] | None,
    data: Path | None,
    ending: PictureFormat,
    json: bool,
    quiet: bool,
) -> None:
    from fuzzy.commands.samples import system_samples
    from fuzzy.figures.figureset import write_figures
    from fuzzy.shell.progress import Mover, progress_bar

    rows = None if data is None else system_samples(fis, data)[:2]
    path = path or Path(f"{stem_of(file)}-figures.zip")
    with progress_bar(quiet or json or not sys.stderr.isatty()) as begin:
        bars: list[Mover] = []

        def advance(done: int, total: int) -> None:
            if not bars:
                bars.append(Mover(begin("pictures", total)))
            bars[0](done)

        chosen = {"data": rows, "file": stem_of(file)}
        names = write_figures(fis, path, values_of(fis, at or []), ending, advance, chosen)
    print_json({"file": str(path), "files": names}) if json else print(path)
