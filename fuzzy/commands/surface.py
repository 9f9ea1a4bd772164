"""The command ``fuzzy surface``: an output over one or two inputs."""

from typing import TYPE_CHECKING, Annotated, Literal

from fuzzy.commands.shared import At, FisFile, Picture, picture_path, read_system, values_of
from fuzzy.shell.options import Json, option
from fuzzy.shell.terminal import print_json

if TYPE_CHECKING:
    from fuzzy.system import Sugeno

SurfaceKind = Literal["contour", "3d", "both"]  # the ways in which ``fuzzy surface`` draws


def surface(
    file: FisFile,
    output_file: Picture = None,
    inputs: Annotated[str | None, option("One or two inputs for the axes; the first two by default.", "A,B")] = None,
    output: Annotated[str | None, option("The output; the first by default.", "NAME")] = None,
    at: At = None,
    kind: Annotated[SurfaceKind, option("How to draw it.")] = "contour",
    points: Annotated[int, option("Grid points along each axis.", min=2, max=2000)] = 61,
    json: Json = False,
) -> None:
    """Draw an output over one or two inputs; where no rule fires it is hatched.

    With --json the grid, the output and where a rule fires are printed, and a picture is written only with -o.

    \b
    Example:
      fuzzy example tipper
      fuzzy surface tipper.fis --inputs service,food -o tip.pdf
      fuzzy surface tracking --output w
    """
    fis = read_system(file)
    axes = _axes(fis, inputs)
    fixed = values_of(fis, at or [])
    which: str | int = 0 if output is None else output
    if json:
        from fuzzy.insight.surfacegrid import surface as surface_data

        data = surface_data(fis, axes, which, fixed, points)
    path = None
    if output_file is not None or not json:
        path = picture_path(output_file, file, "surface")
        from fuzzy.figures.plot import plot_surface, save_figure

        save_figure(plot_surface(fis, axes, which, fixed, points, kind=kind), path)
    if json:
        y = {} if data.y is None else {"y": data.y[:, 0]}
        x = data.x if data.y is None else data.x[0]
        file_name = {} if path is None else {"file": str(path)}
        print_json({"x": x, **y, "z": data.z, "fired": data.fired, **file_name})
    else:
        print(path)


def _axes(fis: "Sugeno", inputs: str | None) -> list[str | int] | None:
    if inputs is None:
        return None
    # A name that holds a comma is taken whole.
    return [inputs] if inputs in [v.name for v in fis.inputs] else [name.strip() for name in inputs.split(",")]
