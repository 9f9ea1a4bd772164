"""The command ``fuzzy plot``: memberships, the rule viewer, the structure."""

from enum import StrEnum
from typing import Annotated

import typer

from fuzzy.commands.shared import At, FisFile, Json, Picture, picture_path, read_system, usage, values_of
from fuzzy.shell.terminal import print_json


class PlotKind(StrEnum):
    """The pictures that ``fuzzy plot`` draws."""

    memberships = "memberships"
    rules = "rules"
    structure = "structure"


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

    \b
    Example:
      fuzzy example tipper
      fuzzy plot tipper.fis --kind rules --at service=3 -o a.pdf
      fuzzy plot tracking
    """
    fis = read_system(file)
    path = picture_path(output_file, file, kind.value)
    if variable is not None and kind is not PlotKind.memberships:
        usage(f"--variable goes with --kind memberships, not {kind.value}")
    if (at or only_fired) and kind is not PlotKind.rules:
        usage(f"--at and --only-fired go with --kind rules, not {kind.value}")
    from fuzzy.figures.plot import plot_memberships, plot_rules, plot_structure, save_figure
    from fuzzy.insight.universe import point_of

    if kind is PlotKind.memberships:
        figure = plot_memberships(fis, variable)
    elif kind is PlotKind.rules:
        figure = plot_rules(fis, point_of(fis, values_of(fis, at or [])), only_fired)
    else:
        figure = plot_structure(fis)
    save_figure(figure, path)
    print_json({"file": str(path)}) if json else print(path)
