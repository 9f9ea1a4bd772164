"""All pictures of a system for a paper: a zip or a folder with a file for each, and a README.txt with captions.

Beside what is drawn of the system alone, plug-ins draw what it does: entry points of the group "fuzzyfleet.pictures"
name functions that take the system and what is chosen for it, see :func:`pictures_of`. The designer draws the same
pictures one by one in a worker: :func:`pictures_of`, :func:`picture_bytes`, :func:`packed_pictures`.
"""

import io
import re
import zipfile
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from itertools import combinations
from pathlib import Path
from tempfile import TemporaryDirectory
from types import MappingProxyType
from typing import Any

import numpy as np
from matplotlib.figure import Figure

from fuzzy.entrypoints import entry_points
from fuzzy.errors import InputError
from fuzzy.figures.drawing import FORMATS, save_figure
from fuzzy.figures.memberships import plot_memberships
from fuzzy.figures.plot import plot_surface
from fuzzy.figures.rulematrix import matrix_inputs, matrix_rules, plot_rule_matrix
from fuzzy.figures.ruleviewer import plot_rules
from fuzzy.figures.structure import plot_structure
from fuzzy.files.atomic import check_folder, check_target, write_whole
from fuzzy.inference import forgiving
from fuzzy.insight.universe import point_of
from fuzzy.naming import expected
from fuzzy.shown import shown
from fuzzy.system import FuzzySystemError, Sugeno, Variable

MOST_SURFACES = 60  # that are drawn: three outputs over each pair of seven inputs would be 63
PICTURE_ENTRY_POINTS = "fuzzyfleet.pictures"
MOST_TERMS = 15  # of an input, in a rule matrix that can be read
MOST_ROWS = 60  # rules that the structure shows, and the rule viewer unless it leaves out those that do not fire
_EPOCH = (1980, 1, 1, 0, 0, 0)  # the time of all files in a zip: the same system gives the same bytes
_UNSAFE = re.compile(r"[^\w.-]+")


@dataclass(frozen=True)
class SetPicture:
    """A picture of the set, before it is drawn."""

    kind: str  # "memberships", "rules", "structure", "matrix", "surface", or what ``draw`` draws
    stem: str  # of its file, without the ending; empty: there is none, and the caption says why
    caption: str
    variable: int | None = None  # of memberships: among the inputs followed by the outputs; None: all
    inputs: tuple[int, ...] = ()  # of a surface's axes
    output: int = 0  # of a surface or a matrix
    draw: Callable[[], Figure] | None = None  # a plug-in's, which can be pickled


def write_figures(
    fis: Sugeno,
    path: str | Path,
    at: Mapping[Any, float] | None = None,
    ending: str = "pdf",
    advance: Callable[[int, int], None] = lambda done, total: None,
    chosen: Mapping[str, Any] = MappingProxyType({}),
) -> list[str]:
    """Draw all pictures of a system: memberships, consequents, rules at a point, structure, rule matrix, every surface.

    Plug-ins add what the system does: the step response of a loop beside a PID, a robot's path, its fit to data.

    Each input and each output has its terms, each output a surface over every pair of inputs (a curve over a single
    input), of which at most :data:`MOST_SURFACES` are drawn. README.txt lists which file shows what, and what is left
    out. The same system gives the same bytes.

    Args:
        fis: The system.
        path: A file that ends in .zip, or a folder, which is made; other files in it stay.
        at: The point of the rule viewer, at which surfaces hold their other inputs, by name or place; the middle of
            the universe where no value is given.
        ending: The format, "pdf", "svg" or "png".
        advance: Called with the number of pictures that are drawn, and that of all.
        chosen: What is known beside the system, see :func:`pictures_of`.

    Returns:
        The names of the files, README.txt first.

    Raises:
        FuzzySystemError: Another format, an input that does not exist, or the name of a single picture.
        TargetError: The place is not one to write a set to.
        OSError: Nothing can be written.
    """
    path = Path(path)
    point = tuple(float(value) for value in point_of(fis, at))
    pictures = pictures_of(fis, point, chosen)
    drawn = files_of(pictures)
    if ending not in FORMATS:
        raise FuzzySystemError(expected(str(ending)[:40], FORMATS, "format"))
    if path.suffix[1:].lower() in FORMATS:
        raise FuzzySystemError(f"all pictures go into a .zip file or a folder, not into {str(path)!r}")
    zipped = path.suffix.lower() == ".zip"
    check_target(path) if zipped else check_folder(path)

    def files() -> Iterator[tuple[str, bytes]]:
        yield "README.txt", readme(fis, pictures, point, ending).encode()
        for done, picture in enumerate(drawn, 1):
            yield f"{picture.stem}.{ending}", picture_bytes(fis, picture, point, ending)
            advance(done, len(drawn))

    if zipped:
        write_whole(path, packed(files()))
    else:
        path.mkdir(parents=True, exist_ok=True)
        for name, content in files():
            write_whole(path / name, content)
    return ["README.txt", *(f"{picture.stem}.{ending}" for picture in drawn)]


def pictures_of(
    fis: Sugeno, point: Sequence[float], chosen: Mapping[str, Any] = MappingProxyType({})
) -> list[SetPicture]:
    """The pictures of a system, in the order of their files; then what is left out, with an empty stem.

    Args:
        fis: The system.
        point: The point (inputs,), each in the unit of its variable.
        chosen: What plug-ins may know: "data", the inputs (samples, inputs) and outputs (samples, outputs) of rows;
            "file", the name of the system's file; "trial", how a robot is driven.
    """
    found = [
        SetPicture(
            "memberships", f"{'terms' if k < len(fis.inputs) else 'consequents'}-{_slug(v.name)}", _terms(fis, k), k
        )
        for k, v in enumerate((*fis.inputs, *fis.outputs))
    ]
    if fis.rules:
        found.append(SetPicture("rules", "rules-at-the-point", _viewer(fis, point)))
    if 0 < len(fis.rules) <= MOST_ROWS:
        found.append(SetPicture("structure", "structure", f"Structure of {fis.name} as a network of six layers."))
    axes = matrix_inputs(fis)
    if axes is not None and _is_matrix(fis, axes):
        found += [
            SetPicture("matrix", f"rule-matrix-{_slug(v.name)}", _matrix(fis, axes, j), inputs=axes, output=j)
            for j, v in enumerate(fis.outputs)
        ]
    found += [
        SetPicture("surface", _surface_stem(fis, axes, j), _surface(fis, point, axes, j), inputs=axes, output=j)
        for axes, j in _surfaces(fis)[:MOST_SURFACES]
    ]
    left: list[SetPicture] = []
    for plugin in sorted(entry_points(group=PICTURE_ENTRY_POINTS), key=lambda each: each.name):
        try:
            found += plugin.load()(fis, chosen)
        except InputError as error:
            left.append(SetPicture("left out", "", f"Left out: the picture {plugin.name!r}: {error}"))
    digits = max(2, len(str(len(found))))
    return [replace(picture, stem=f"{k:0{digits}d}-{picture.stem}") for k, picture in enumerate(found, 1)] + left


def files_of(pictures: Sequence[SetPicture]) -> list[SetPicture]:
    """Those of the pictures that are drawn, each into a file."""
    return [picture for picture in pictures if picture.stem]


def picture_bytes(fis: Sugeno, picture: SetPicture, point: Sequence[float], ending: str) -> bytes:
    """Draw a picture as the bytes of a file.

    Args:
        fis: The system.
        picture: One of :func:`pictures_of`, or another one of these kinds.
        point: The point (inputs,) at which rules are shown and a surface holds its other inputs.
        ending: The format, one of png, pdf, svg.

    Raises FuzzySystemError where there is nothing to draw.
    """
    figure = _drawn(forgiving(fis), picture, point)
    with TemporaryDirectory() as folder:
        path = Path(folder) / f"figure.{ending}"
        save_figure(figure, path)
        return path.read_bytes()


def packed_pictures(
    fis: Sugeno, pictures: Sequence[SetPicture], point: Sequence[float], ending: str, drawn: Sequence[bytes]
) -> bytes:
    """The zip of pictures that are drawn already, in their order, with its README.txt."""
    names = [f"{picture.stem}.{ending}" for picture in files_of(pictures)]
    text = readme(fis, pictures, point, ending).encode()
    return packed([("README.txt", text), *zip(names, drawn, strict=True)])


def packed(files: Iterable[tuple[str, bytes]]) -> bytes:
    """A zip with these files, names and contents; the same files give the same bytes."""
    data = io.BytesIO()
    with zipfile.ZipFile(data, "w", zipfile.ZIP_DEFLATED) as archive:
        for name, content in files:
            about = zipfile.ZipInfo(name, _EPOCH)
            about.compress_type = zipfile.ZIP_DEFLATED
            about.external_attr = 0o644 << 16
            archive.writestr(about, content)
    return data.getvalue()


def readme(fis: Sugeno, pictures: Sequence[SetPicture], point: Sequence[float], ending: str) -> str:
    """The text of README.txt: the point, each file with its caption, what is left out, and the rules."""
    where = ", ".join(_values(fis.inputs, point)) or "no inputs"
    lines = [f"Pictures of {fis.name}", "", f"The point: {where}.", ""]
    for picture in files_of(pictures):
        lines += [f"{picture.stem}.{ending}", f"    {picture.caption}"]
    left = _left_out(fis) + [picture.caption for picture in pictures if not picture.stem]
    lines += ["", *left] if left else []
    if fis.rules:
        lines += ["", "Rules", *(f"{number:4d}. {rule}" for number, rule in enumerate(fis.rules, 1))]
    return "\n".join([*lines, ""])


def _left_out(fis: Sugeno) -> list[str]:
    said = []
    surfaces = len(_surfaces(fis))
    if surfaces > MOST_SURFACES:
        said.append(
            f"Left out: {surfaces - MOST_SURFACES} of {surfaces} surfaces, because at most {MOST_SURFACES} are drawn; "
            "fuzzy surface draws any of them."
        )
    if len(fis.rules) > MOST_ROWS:
        said.append(
            f"Left out: the structure, because at most {MOST_ROWS} rules can be read in it; fuzzy plot draws it."
        )
    return said


def _surfaces(fis: Sugeno) -> list[tuple[tuple[int, ...], int]]:
    """The axes and outputs of all surfaces: each pair of inputs, or the only input, for each output."""
    count = len(fis.inputs)
    axes: list[tuple[int, ...]] = [(0,)] if count == 1 else list(combinations(range(count), 2))
    return [(pair, j) for j in range(len(fis.outputs)) for pair in axes]


def _is_matrix(fis: Sugeno, axes: tuple[int, int]) -> bool:
    """Whether most rules have a cell, and it can be read."""
    rules = sum(map(len, matrix_rules(fis, axes).values()))
    return 2 * rules > len(fis.rules) and max(len(fis.inputs[i].terms) for i in axes) <= MOST_TERMS


def _drawn(fis: Sugeno, picture: SetPicture, point: Sequence[float]) -> Figure:
    if picture.draw is not None:
        return picture.draw()
    if picture.kind == "memberships":
        return plot_memberships(fis, picture.variable)
    if picture.kind == "rules":
        return plot_rules(fis, np.asarray(point), only_fired=len(fis.rules) > MOST_ROWS)
    if picture.kind == "structure":
        return plot_structure(fis)
    if picture.kind == "matrix":
        return plot_rule_matrix(fis, picture.inputs[:2] or None, picture.output)  # type: ignore[arg-type]
    held = {i: value for i, value in enumerate(point) if i not in picture.inputs}
    return plot_surface(fis, list(picture.inputs), picture.output, held)


# Words ------------------------------------------------------------------------------------------------------------


def _terms(fis: Sugeno, k: int) -> str:
    variable = (*fis.inputs, *fis.outputs)[k]
    names = ", ".join(variable.terms)
    low, high = (_quantity(end, variable) for end in variable.universe)
    if k < len(fis.inputs):
        return f"Membership functions of the input {variable.label} from {low} to {high}: {names}."
    return f"Consequents of the output {variable.label}, whose range is {low} to {high}: {names}."


def _viewer(fis: Sugeno, point: Sequence[float]) -> str:
    which = "The rules that fire" if len(fis.rules) > MOST_ROWS else "Every rule"
    outputs = " and ".join(v.label for v in fis.outputs)
    return f"{which} at {', '.join(_values(fis.inputs, point))}: degrees, firing strengths, and {outputs}."


def _matrix(fis: Sugeno, axes: tuple[int, int], j: int) -> str:
    over, rules = " and ".join(fis.inputs[i].label for i in axes), sum(map(len, matrix_rules(fis, axes).values()))
    rest = f" {len(fis.rules) - rules} of {len(fis.rules)} rules have no cell." if rules < len(fis.rules) else ""
    return f"Rule matrix: {fis.outputs[j].label} by the terms of {over}.{rest}"


def _surface(fis: Sugeno, point: Sequence[float], axes: Sequence[int], j: int) -> str:
    over = " and ".join(fis.inputs[i].label for i in axes)
    rest = [i for i in range(len(fis.inputs)) if i not in axes]
    held = ", ".join(_values([fis.inputs[i] for i in rest], [point[i] for i in rest]))
    return f"Control surface: {fis.outputs[j].label} over {over}{f', at {held}' if held else ''}."


def _surface_stem(fis: Sugeno, axes: Sequence[int], j: int) -> str:
    over = "-".join(_slug(fis.inputs[i].name) for i in axes)
    return f"surface-{_slug(fis.outputs[j].name)}-over-{over}"


def _values(variables: Sequence[Variable], values: Sequence[float]) -> list[str]:
    return [f"{v.name} = {_quantity(value, v)}" for v, value in zip(variables, values, strict=True)]


def _quantity(value: float, variable: Variable) -> str:
    return f"{shown(value)} {variable.unit}".rstrip()


def _slug(name: str) -> str:
    return _UNSAFE.sub("-", name).strip("-.")[:40] or "variable"
