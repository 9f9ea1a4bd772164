"""How near a Sugeno system comes to a Mamdani system, on a grid over the inputs; and consequents that come nearer.

old = read_mamdani_original("old.fis")
new, changes = old.as_sugeno()
fitted = fit_to_mamdani(old, new, "planes")
print(mamdani_difference(old, new), mamdani_difference(old, fitted))
"""

import math
import os
import warnings
from collections.abc import Callable
from dataclasses import replace
from typing import Any, Literal, NamedTuple, get_args

import numpy as np

from fuzzy.errors import InputError
from fuzzy.files.fisfile import FisFileError, parse_original, warned
from fuzzy.files.fislines import file_bytes
from fuzzy.files.mamdani import MamdaniParts
from fuzzy.fitting.consequents import least_squares
from fuzzy.inference import InferenceWarning
from fuzzy.naming import check_known
from fuzzy.plugins.mamdani.system import Mamdani
from fuzzy.system import Constant, FuzzySystemError, Linear, Sugeno, Terms, Variable

Consequents = Literal["constants", "planes"]
_GRID = 4096  # points at which systems are compared, about
_MOST_INPUTS = 6  # of a grid; more inputs are sampled
_RIDGE = 1e-9  # without a unit: holds planes where the grid does not determine them
_SEED = 20


class Difference(NamedTuple):
    """How far an output of a system is from that of another, as a share of the output's range.

    Attributes:
        output: The name of the output.
        greatest: The largest difference, a share of the range.
        mean: The mean of the differences, likewise.
        root_mean_square: Their root mean square, likewise.
        points: At how many points both were evaluated.
    """

    output: str
    greatest: float
    mean: float
    root_mean_square: float
    points: int

    def __str__(self) -> str:
        return f"{self.output}: {self.greatest:.2%} of the range at most, {self.mean:.2%} in the mean"


def read_mamdani_original(path: str | os.PathLike[str]) -> Mamdani:
    """Read the Mamdani system in a .fis file as it is; warns as :func:`fuzzy.read_fis` does.

    Args:
        path: The file.

    Returns:
        The system, with its sets.

    Raises:
        FisFileError: As of :func:`fuzzy.read_fis`, and a Sugeno system, which that reads.
    """
    name = os.fsdecode(path)
    read, parts = parse_original(file_bytes(name), name)
    if parts is None:
        raise FisFileError(name, None, "holds a Sugeno system; fuzzy.read_fis reads it")
    warned(read)
    try:
        return mamdani_of(parts)
    except FuzzySystemError as error:
        raise FisFileError(name, None, str(error)) from None


def mamdani_of(parts: MamdaniParts) -> Mamdani:
    """The system of a file's parts. Raises FuzzySystemError for methods of implication or aggregation not known."""
    known = ("name", "and_method", "or_method", "implication", "aggregation", "defuzzification")
    settings = {key: value for key, value in parts.settings.items() if key in known}
    return Mamdani(parts.inputs, parts.outputs, parts.rules, complements=parts.complements, **settings)


def input_grid(inputs: tuple[Variable, ...] | Any, points: int = _GRID, offset: bool = False) -> np.ndarray:
    """About ``points`` places (points, inputs) over the universes of ``inputs``, the same at each call.

    A grid with the ends of each universe; with ``offset`` the middles of its cells, which it does not hold. Of more
    than six inputs, places drawn evenly.
    """
    low, high = (np.array([v.universe[end] for v in inputs]) for end in (0, 1))
    count = len(low)
    if count > _MOST_INPUTS:
        drawn = np.random.default_rng(_SEED + offset).random((points, count))
        return np.asarray(low + drawn * (high - low))
    each = max(2, math.floor(points ** (1 / count) + 1e-9))
    shares = (np.arange(each - 1) + 0.5) / (each - 1) if offset else np.linspace(0, 1, each)
    grid = np.stack(np.meshgrid(*[shares] * count, indexing="ij"), axis=-1).reshape(-1, count)
    return np.asarray(low + grid * (high - low))


def mamdani_difference(original: Mamdani, fis: Sugeno, points: int = _GRID) -> tuple[Difference, ...]:
    """How far ``fis`` is from ``original``, an output each, on a grid of places over the inputs.

    Where no rule fires both give the middle of the range.

    Args:
        original: The Mamdani system.
        fis: The Sugeno system.
        points: About how many places the grid has in all.

    Raises:
        FuzzySystemError: Systems of other inputs or outputs.
    """
    _check_alike(original, fis)
    return differences(fis, lambda x: original.evaluate(x)[0], input_grid(fis.inputs, points))


def differences(fis: Sugeno, reference: Callable[[np.ndarray], np.ndarray], x: np.ndarray) -> tuple[Difference, ...]:
    """How far ``fis`` is from ``reference``, a function of places (points, inputs), at ``x``, an output each."""
    found = []
    wanted, given = np.asarray(reference(x)), _quiet(fis, x)
    for j, output in enumerate(fis.outputs):
        span = output.span
        both = np.isfinite(wanted[:, j]) & np.isfinite(given[:, j])
        gap = np.abs(given[both, j] - wanted[both, j]) / (span if span > 0 else 1.0)
        if not len(gap):
            raise FuzzySystemError(f"{output.name}: the two systems have no place where both give a number")
        mean, rms = float(gap.mean()), float(np.sqrt(np.mean(gap**2)))
        found.append(Difference(output.name, float(gap.max()), mean, rms, len(gap)))
    return tuple(found)


def fit_to_mamdani(
    original: Mamdani, fis: Sugeno, consequents: Consequents = "constants", points: int = _GRID
) -> Sugeno:
    """``fis`` with the consequents that come nearest to ``original`` in the mean square over a grid of
    about ``points`` places.

    The places of the grid are not those at which :func:`mamdani_difference` measures, and only those count at which
    a rule fires. Each term stays one consequent, shared by its rules as before; with ``"planes"`` it becomes linear in
    the inputs. The greatest difference may grow where the mean square shrinks: measure both.

    Args:
        original: The Mamdani system.
        fis: A Sugeno system of the same inputs and outputs, such as :func:`fuzzy.read_mamdani` makes.
        consequents: "constants", or "planes", linear in the inputs.
        points: About how many places the grid has in all.

    Returns:
        The system with the new consequents; the terms of its inputs and its rules stay.

    Raises:
        FuzzySystemError: Other ``consequents``, and systems that do not fit together.
    """
    _check_alike(original, fis)
    check_known(consequents, get_args(Consequents), "consequents", FuzzySystemError)
    if not fis.rules:
        raise FuzzySystemError(f"{fis.name} has no rules, so there are no consequents to fit")
    x = input_grid(fis.inputs, points, offset=True)
    y, fired = original.evaluate(x)
    known = fired.all(axis=1)
    if not known.any():
        raise FuzzySystemError(f"{fis.name}: no rule of the Mamdani system fires anywhere on the grid")
    begin = _with_planes(fis) if consequents == "planes" else fis
    try:
        return least_squares(begin, x[known], y[known], _RIDGE).fis
    except InputError as error:
        raise FuzzySystemError(str(error)) from None


def _with_planes(fis: Sugeno) -> Sugeno:
    outputs = []
    for output in fis.outputs:
        terms = {
            label: Linear((0.0,) * len(fis.inputs), term.value) if isinstance(term, Constant) else term
            for label, term in output.terms.items()
        }
        outputs.append(replace(output, terms=Terms(terms)))
    return replace(fis, outputs=tuple(outputs))


def _check_alike(original: Mamdani, fis: Sugeno) -> None:
    for what in ("inputs", "outputs"):
        names = [[v.name for v in getattr(system, what)] for system in (original, fis)]
        if names[0] != names[1]:
            raise FuzzySystemError(
                f"the {what} of the two systems differ: {', '.join(names[0])} and {', '.join(names[1])}"
            )


def _quiet(fis: Sugeno, x: np.ndarray) -> np.ndarray:
    with warnings.catch_warnings(action="ignore", category=InferenceWarning):
        return np.asarray(fis(x))
