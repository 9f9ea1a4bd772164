"""The numbers behind a surface: an output on a grid over one or two inputs."""

import warnings
from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import Any, NamedTuple

import numpy as np

from fuzzy.detached import detached
from fuzzy.inference import InferenceWarning, infer
from fuzzy.insight.universe import place_of, point_of
from fuzzy.system import FuzzySystemError, Sugeno


class Surface(NamedTuple):
    """An output over two inputs, or over one; then ``y`` is None and the other arrays have one dimension.

    Attributes:
        x: (points, points): the first input, along the last axis, in its unit.
        y: (points, points): the second input, along the first axis; None over one input.
        z: (points, points): the output, in its unit.
        fired: (points, points) bool: does any rule fire there?
    """

    x: np.ndarray
    y: np.ndarray | None
    z: np.ndarray
    fired: np.ndarray


def surface(
    fis: Any,
    inputs: Sequence[str | int] | str | int | None = None,
    output: str | int = 0,
    fixed: Mapping[Any, float] | None = None,
    points: int | Sequence[int] = 61,
) -> Surface:
    """Evaluate an output on a grid over one or two inputs, each from end to end of its universe.

    Where no rule fires, ``z`` is what the system says there (not-a-number if it would raise an error) and ``fired`` is
    False. Inputs and outputs are named, or given by their place.

    Args:
        fis: The system, of type 1 or an interval type-2 one.
        inputs: The one or two inputs of the grid; by default the first two, or the only one.
        output: The output.
        fixed: The values of other inputs, in their units; the middle of the universe where none is given.
        points: The number of grid points along each input, or one number for each.

    Returns:
        The grid, the output on it, and where rules fire.

    Raises:
        FuzzySystemError: Inputs and outputs that do not exist, and an input in both ``inputs`` and ``fixed``.
    """
    fis = detached(fis)
    places = surface_axes(fis, inputs)
    j = place_of(output, fis.outputs, "output")
    point = point_of(fis, fixed)
    for which in fixed or {}:
        i = place_of(which, fis.inputs, "input")
        if i in places:
            raise FuzzySystemError(f"input {fis.inputs[i].name!r} cannot both be held and be an axis")
    counts = [points] * len(places) if isinstance(points, int) else list(points)
    if len(counts) != len(places) or any(count < 2 for count in counts):
        raise FuzzySystemError(f"points must be at least 2, one number or one an input, got {points!r}")
    grids, x = _grid(fis, places, counts, point)
    result = _inferred(fis, x)
    return Surface(grids[0], grids[1] if len(grids) > 1 else None, result.output[..., j], result.fired[..., j])


def surfaces(
    fis: Any, axes: Sequence[Sequence[int]], point: Sequence[float], points: int
) -> list[tuple[np.ndarray, np.ndarray]]:
    """Evaluate all outputs over several grids by one inference: for each, the values and whether a rule fires.

    Both are (points, points, outputs), the second input along the first axis, or (points, outputs) over one input.

    Args:
        fis: The system, which does not raise an error where no rule fires.
        axes: The one or two inputs of each grid, by number.
        point: The values (inputs,) of the inputs that are no axes.
        points: The number of points along each input.
    """
    fis = detached(fis)
    held = np.asarray(point, dtype=float)
    places = [_grid(fis, own, [points] * len(own), held)[1] for own in axes]
    result = _inferred(fis, np.concatenate([x.reshape(-1, len(fis.inputs)) for x in places]))
    ends = np.cumsum([x[..., 0].size for x in places])[:-1]
    found = zip(places, np.split(result.output, ends), np.split(result.fired, ends), strict=True)
    return [(z.reshape(*x.shape[:-1], -1), fired.reshape(*x.shape[:-1], -1)) for x, z, fired in found]


def _inferred(fis: Any, x: np.ndarray) -> Any:
    """The inference at ``x`` (..., inputs), without a word of where no rule fires: the result shows it."""
    if fis.upper.no_rule_fires == "error":
        fis = fis.mapped(lambda upper: replace(upper, no_rule_fires="nan"))
    with warnings.catch_warnings():
        warnings.filterwarnings("ignore", ".*no rule fires", InferenceWarning)
        return infer(fis, x) if isinstance(fis, Sugeno) else fis.infer(x)


def _grid(
    fis: Sugeno, places: Sequence[int], counts: Sequence[int], point: np.ndarray
) -> tuple[Sequence[np.ndarray], np.ndarray]:
    """The grids of the inputs at ``places``, and the points (..., inputs) on them, the other inputs as in ``point``."""
    axes = [np.linspace(*fis.inputs[i].universe, count) for i, count in zip(places, counts, strict=True)]
    grids = np.meshgrid(*axes)
    x = np.broadcast_to(point, (*grids[0].shape, len(point))).copy()
    for i, grid in zip(places, grids, strict=True):
        x[..., i] = grid
    return grids, x


def surface_axes(fis: Sugeno, inputs: Sequence[str | int] | str | int | None) -> list[int]:
    """Find the places of the one or two inputs that are the axes of a surface."""
    if inputs is None:
        inputs = range(min(2, len(fis.inputs)))
    elif isinstance(inputs, (str, int)):
        inputs = [inputs]
    places = [place_of(which, fis.inputs, "input") for which in inputs]
    if len(places) not in (1, 2) or len(set(places)) != len(places):
        raise FuzzySystemError(f"a surface has one or two different inputs for axes, got {', '.join(map(str, inputs))}")
    return places
