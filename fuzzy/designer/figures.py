"""The figures of a design as files, drawn in a worker process."""

from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path
from tempfile import TemporaryDirectory

from fuzzy.errors import InputError
from fuzzy.naming import expected
from fuzzy.system import Sugeno

FIGURES = ("memberships", "rules", "structure", "surface")
FORMATS = ("svg", "pdf", "png")


def check_figure(kind: object, ending: object) -> tuple[str, str]:
    """The kind of figure and its format, if both are known. Raises InputError for others."""
    if kind not in FIGURES:
        raise InputError(expected(str(kind)[:40], FIGURES, "figure"))
    if ending not in FORMATS:
        raise InputError(expected(str(ending)[:40], FORMATS, "format"))
    return str(kind), str(ending)


def figure_bytes(
    fis: Sugeno, kind: str, ending: str, point: Sequence[float], inputs: Sequence[int], output: int
) -> bytes:
    """Draw a picture of a system as the bytes of a file.

    Args:
        fis: The system.
        kind: The picture, one of :data:`FIGURES`.
        ending: The format, one of :data:`FORMATS`.
        point: The point (inputs,) at which rules are shown and a surface holds its other inputs.
        inputs: The inputs of the surface's axes, by number.
        output: The surface's output, by number.

    Raises FuzzySystemError where there is nothing to draw.
    """
    from fuzzy.figures.plot import plot_memberships, plot_rules, plot_structure, plot_surface, save_figure

    kind, ending = check_figure(kind, ending)
    if fis.out_of_range in ("warn", "error"):
        fis = replace(fis, out_of_range="ignore")
    if fis.no_rule_fires == "error":
        fis = replace(fis, no_rule_fires="nan")
    if kind == "memberships":
        figure = plot_memberships(fis)
    elif kind == "rules":
        figure = plot_rules(fis, point)
    elif kind == "structure":
        figure = plot_structure(fis)
    else:
        held = {v.name: value for i, (v, value) in enumerate(zip(fis.inputs, point, strict=True)) if i not in inputs}
        figure = plot_surface(fis, list(inputs), output, held)
    with TemporaryDirectory() as folder:
        path = Path(folder) / f"figure.{ending}"
        save_figure(figure, path)
        return path.read_bytes()
