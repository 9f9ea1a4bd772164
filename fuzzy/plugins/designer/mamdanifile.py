"""The Sugeno forms of a Mamdani system in a file, and how far the outputs of each are off."""

from pathlib import Path
from typing import TYPE_CHECKING, NamedTuple

from fuzzy.errors import InputError
from fuzzy.files.fisfile import parse_original
from fuzzy.naming import check_known
from fuzzy.system import FuzzySystemError, Sugeno

if TYPE_CHECKING:
    from fuzzy.plugins.mamdani.system import Mamdani

FORM_FITS = ("", "constants", "planes")


class FormDifference(NamedTuple):
    """How far one output is off, on a grid over the inputs."""

    output: str
    unit: str
    span: float  # of its range, in the unit
    greatest: float  # a share of the span
    root_mean_square: float  # likewise
    points: int  # of the grid


class SugenoForm(NamedTuple):
    """What the sets of a Mamdani system become, and how far the outputs are off then."""

    fit: str  # constants at the sets' centroids (empty), or fitted "constants" or "planes"
    offs: tuple[FormDifference, ...]


def sugeno_forms(path: Path, name: str) -> list[SugenoForm]:
    """The forms of the Mamdani system in a file, measured as `fuzzy convert` measures them. Raises InputError."""
    from fuzzy.plugins.mamdani.likeness import mamdani_difference

    original, constants = _read(path, name)
    forms = []
    for fit in FORM_FITS:
        try:
            fis = _fitted(original, constants, fit)
        except InputError:
            continue  # what cannot be fitted is not offered
        found = mamdani_difference(original, fis)
        offs = [
            FormDifference(each.output, v.unit, v.span or 1.0, each.greatest, each.root_mean_square, each.points)
            for each, v in zip(found, fis.outputs, strict=True)
        ]
        forms.append(SugenoForm(fit, tuple(offs)))
    return forms


def nearest(path: Path, name: str, fit: str) -> Sugeno:
    """The form ``fit`` of the Mamdani system in a file called ``name``. Raises InputError."""
    return _fitted(*_read(path, name), check_known(fit, FORM_FITS, "fit", FuzzySystemError))


def _read(path: Path, name: str) -> tuple["Mamdani", Sugeno]:
    from fuzzy.plugins.mamdani.likeness import mamdani_of

    read, parts = parse_original(path.read_bytes(), name)
    if parts is None:
        raise FuzzySystemError(f"{name} holds no Mamdani system")
    return mamdani_of(parts), read.system


def _fitted(original: "Mamdani", constants: Sugeno, fit: str) -> Sugeno:
    from fuzzy.plugins.mamdani.likeness import fit_to_mamdani

    return fit_to_mamdani(original, constants, "planes" if fit == "planes" else "constants") if fit else constants
