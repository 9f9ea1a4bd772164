"""The figures of a design as files, drawn in a worker process, one picture a task."""

from collections.abc import Awaitable, Callable, Mapping, Sequence
from dataclasses import replace
from functools import partial
from types import MappingProxyType
from typing import Any

from fuzzy.errors import InputError
from fuzzy.naming import expected
from fuzzy.plugins.type2.system import Type2Sugeno
from fuzzy.system import Sugeno

DESIGN_FIGURES = ("memberships", "rules", "structure", "surface")
ALL_FIGURES = "all"  # of them, as a set
_FORMATS = ("svg", "pdf", "png")


def check_figure(kind: object, ending: object) -> tuple[str, str]:
    """The kind of figure, or "all", and its format, if both are known. Raises InputError for others."""
    if kind not in (*DESIGN_FIGURES, ALL_FIGURES):
        raise InputError(expected(str(kind)[:40], (*DESIGN_FIGURES, ALL_FIGURES), "figure"))
    if ending not in _FORMATS:
        raise InputError(expected(str(ending)[:40], _FORMATS, "format"))
    return str(kind), str(ending)


def figure_bytes(
    fis: Sugeno | Type2Sugeno, kind: str, ending: str, point: Sequence[float], inputs: Sequence[int], output: int
) -> bytes:
    """Draw a picture of a system as the bytes of a file.

    Args:
        fis: The system.
        kind: The picture, one of :data:`DESIGN_FIGURES`.
        ending: The format, "svg", "pdf" or "png".
        point: The point (inputs,) at which rules are shown and a surface holds its other inputs.
        inputs: The inputs of the surface's axes, by number.
        output: The surface's output, by number.

    Raises FuzzySystemError where there is nothing to draw, InputError for another kind or format.
    """
    from fuzzy.figures.figureset import SetPicture, picture_bytes
    from fuzzy.plugins.type2.figures import plot_footprint

    kind, ending = check_figure(kind, ending)
    if kind == ALL_FIGURES:
        raise InputError(expected(kind, DESIGN_FIGURES, "figure"))
    picture = SetPicture(kind, kind, "", None, tuple(inputs), output)
    if not isinstance(fis, Sugeno):
        if kind not in ("memberships", "surface"):
            raise InputError(f"of a type-2 system the memberships and the surface are drawn, not the {kind}")
        picture = replace(picture, draw=partial(plot_footprint, fis) if kind == "memberships" else None)
    return picture_bytes(fis, picture, point, ending)  # type: ignore[arg-type]


async def all_figures(
    background: Callable[..., Awaitable[Any]],
    fis: Sugeno,
    ending: str,
    point: Sequence[float],
    announce: Callable[[int, int], bool],
    chosen: Mapping[str, Any] = MappingProxyType({}),
) -> bytes | None:
    """Draw all pictures of a system, see :func:`fuzzy.figures.figureset.write_figures`: the bytes of a zip.

    Args:
        background: Runs a function in a worker.
        fis: The system.
        ending: The format, "svg", "pdf" or "png".
        point: The point (inputs,) of the rule viewer and the surfaces.
        announce: Called with the number of pictures that are drawn, and that of all; false ends it: no zip.
        chosen: What the panels know beside it, see :func:`fuzzy.figures.figureset.pictures_of`.
    """
    from fuzzy.figures import figureset

    pictures = await background(figureset.pictures_of, fis, point, chosen)
    files, drawn = figureset.files_of(pictures), list[bytes]()
    for picture in files:
        if not announce(len(drawn), len(files)):
            return None
        drawn.append(await background(figureset.picture_bytes, fis, picture, point, ending))
    data: bytes = await background(figureset.packed_pictures, fis, pictures, point, ending, drawn)
    return data
