"""The arrays of a saved run: which there are, and what shapes and types of them belong together."""

from collections.abc import Mapping

import numpy as np

from fuzzy.errors import InputError, quoted
from fuzzy.files.arrays import Header
from robotics.laws.modes import MODES
from robotics.simulation.channels import CHANNELS, RECORDS, TEAM_CHANNELS
from robotics.world.radio.faults import FAULTS

LONGEST_STEP = 1.0 + 1e-9  # s between samples: the longest period of a scenario
FASTEST = 1e6  # m, rad, m/s, rad/s: no robot is farther or faster; contacts are looked for along all of its way
_DRIVEN = ("x", "y", "heading", "v", "w")
_OBSTACLES = {"circles": ("bodies", 3), "bodies": ("bodies", 4), "segments": ("segments", 4), "counts": ()}
_KINDS = {"f": "floating point", "iu": "whole numbers", "i": "whole numbers", "b": "truth values", "U": "a text"}
Axis = int | str  # the length of an axis, or the name of one that may have any, the same wherever it is named
# What every run has beside RECORDS: kinds of numbers, and axes
_ALWAYS: dict[str, tuple[str, tuple[Axis, ...]]] = {
    "about": ("U", ()),
    "time": ("f", ("sample",)),
    "seeds": ("iu", ("run",)),
    "stopped": ("i", ("run", "robot")),
    "reference": ("f", (6, "sample", "robot")),
}


class LayoutError(InputError):
    """Arrays that are not those of one run. The message names the array and what was expected, not the file."""


def check_headers(found: Mapping[str, Header]) -> None:
    """Raise LayoutError unless the arrays have the types and shapes of one run, before they are read."""
    lengths: dict[str, int] = {}
    for name, (kinds, wanted) in _ALWAYS.items():
        _check(name, found, kinds, wanted, lengths)
    if lengths["sample"] < 2 or not lengths["run"] or not lengths["robot"]:
        raise LayoutError("it has fewer than two samples, no seed or no robot")
    lengths["sender"] = lengths["robot"]
    for name, record in RECORDS.items():
        if name in found or name == "samples":
            channels = {"channel": len(record.units)} if record.units else {}
            axes = tuple(channels.get(axis, axis) for axis in record.axes)
            _check(name, found, np.dtype(record.dtype).kind, axes, lengths)
    for robot in range(lengths["robot"]):
        _check(f"path_{robot}", found, "f", (2, f"path_{robot}"), lengths)
    if "obstacles_circles" in found:
        _check_obstacles(found, lengths)


def check_values(arrays: Mapping[str, np.ndarray]) -> None:
    """Raise LayoutError for values by which others are found, or drawn, and that cannot be."""
    time, stopped = arrays["time"], arrays["stopped"]
    steps = np.diff(time)
    if not (np.isfinite(time).all() and (steps > 0).all() and (steps <= LONGEST_STEP).all()):
        raise LayoutError(f"'time' does not grow from sample to sample, by {LONGEST_STEP:g} s at most")
    driven = np.abs(arrays["samples"][:, [list(CHANNELS).index(name) for name in _DRIVEN]])
    if (driven > FASTEST).any():  # not-a-number is a robot that was stopped
        raise LayoutError(f"'samples' holds places or speeds beyond {FASTEST:g} m, rad, m/s or rad/s")
    if len(set(arrays["seeds"].tolist())) < len(arrays["seeds"]) or (arrays["seeds"] < 0).any():
        raise LayoutError("'seeds' are not different whole numbers from 0 on")
    _check_range("stopped", stopped, -1, len(time) - 1)
    for name in (name for name in arrays if name.startswith("path_") or name == "reference"):
        if arrays[name].size == 0 or not (np.abs(arrays[name]) <= FASTEST).all():
            raise LayoutError(f"{name!r} holds what is no number up to {FASTEST:g}")
    if "modes" in arrays:
        _check_range("modes", arrays["modes"], 0, len(MODES) - 1)
    if "team" in arrays:
        faults = arrays["team"][:, list(TEAM_CHANNELS).index("fault")]
        if not (np.isin(faults, [0, *FAULTS.values()]) | np.isnan(faults)).all():  # not-a-number as above
            raise LayoutError("'team' holds faults of a kind that there is not")
    if "obstacles_circles" in arrays:
        bodies = arrays["obstacles_bodies"]
        _check_range("obstacles_counts", arrays["obstacles_counts"], 0, bodies.shape[1])
        _check_range("obstacles_bodies", bodies[..., :2], 0, arrays["obstacles_segments"].shape[1])
        _check_range("obstacles_bodies", bodies[..., :2].sum(axis=-1), 0, arrays["obstacles_segments"].shape[1])
        _check_range("obstacles_bodies", bodies[..., 2], 0, 1)
        _check_range("obstacles_bodies", bodies[..., 3], 0, max(bodies.shape[1] - 1, 0))
        for name in ("obstacles_circles", "obstacles_segments"):
            if not (np.abs(arrays[name]) <= FASTEST).all():
                raise LayoutError(f"{name!r} holds what is no number up to {FASTEST:g}")


def _check_obstacles(found: Mapping[str, Header], lengths: dict[str, int]) -> None:
    for name, axes in _OBSTACLES.items():
        kinds = "f" if name in ("circles", "segments") else "iu"
        _check(f"obstacles_{name}", found, kinds, ("places", *axes), lengths)
    if lengths["places"] not in (1, lengths["sample"]):
        raise LayoutError("the obstacles are not at as many places as there are samples")


def _check(
    name: str, arrays: Mapping[str, Header], kinds: str, axes: tuple[Axis, ...], lengths: dict[str, int]
) -> None:
    """See that an array is there with a kind of numbers and its axes; those named first here get their lengths."""
    if name not in arrays:
        raise LayoutError(f"the array {name!r} is missing")
    dtype, shape = arrays[name].dtype, arrays[name].shape
    if dtype.kind not in kinds:
        raise LayoutError(f"{quoted(name)} must be {_KINDS[kinds]}, and holds {dtype}")
    if len(shape) != len(axes):
        raise LayoutError(f"{quoted(name)} has {len(shape)} axes, not {len(axes)}")
    for axis, length in zip(axes, shape, strict=True):
        if isinstance(axis, str):
            lengths.setdefault(axis, length)
    wanted = tuple(lengths[axis] if isinstance(axis, str) else axis for axis in axes)
    if shape != wanted:
        raise LayoutError(f"{quoted(name)} has the shape {shape}, where the others ask for {wanted}")


def _check_range(name: str, values: np.ndarray, least: int, most: int) -> None:
    if values.size and (values.min() < least or values.max() > most):
        raise LayoutError(f"{quoted(name)} must lie between {least} and {most}")
