"""Subtractive clustering: samples in dense places become the centers of clusters   [Chiu 1994].

The rules are those of MATLAB's ``subclust``: ranges come from the data or are given, one radius holds for all
columns or each has its own, centers stand in the order of discovery, and all clusters share one vector of widths.
"""

import warnings
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np

from fuzzy.errors import InputError
from fuzzy.quantity import described

# In shares of the range: below, no sample is near another and the squares of distances lose all meaning.
LEAST_RADIUS, LARGEST_RADIUS = 1e-6, 1e6
_TILE = (64, 1024)  # distances computed at a time: half a mebibyte, which stays in the second cache
_LARGEST_OPTION = 1e6
_TIE = 1e-12  # densities that differ by less, relatively, are equal: no sum's rounding chooses a center


class DataWarning(UserWarning):
    """The warning of data that are usable but poor: a constant column, or parameters that no sample determines."""


class ClusteringError(InputError):
    """The error for data or options that clustering cannot use, with the row, the column or the option."""


@dataclass(frozen=True)
class ClusteringOptions:
    """The options that decide when a sample becomes a center. The defaults are MATLAB's."""

    squash: float = described("Squash factor: how far a center takes the density away, in radii.", 1.25)
    accept: float = described("Accept ratio: with more than this share of the first density all are centers.", 0.5)
    reject: float = described("Reject ratio: with no more the search ends; between the two, distance decides.", 0.15)

    def __post_init__(self) -> None:
        for name in ("squash", "accept", "reject"):
            value = getattr(self, name)
            if not (isinstance(value, (int, float)) and 0 <= value <= _LARGEST_OPTION):
                raise ClusteringError(f"{name} must be a number >= 0 and <= {_LARGEST_OPTION:g}, got {value!r}")
        if self.squash < LEAST_RADIUS:
            raise ClusteringError(f"squash must be >= {LEAST_RADIUS:g}, got {self.squash!r}")
        if self.reject > self.accept:
            raise ClusteringError(f"reject ({self.reject:g}) must not exceed accept ({self.accept:g})")


class Clusters(NamedTuple):
    """The clusters that were found."""

    centers: np.ndarray  # (clusters, columns) in the data's units, in the order of discovery
    sigma: np.ndarray  # (columns,) in the data's units: the width of a Gaussian round any of them
    rows: np.ndarray  # (clusters,) int: which samples the centers are


class Densities(NamedTuple):
    """The first density of every sample, which depends on the radius alone and serves many searches."""

    data: np.ndarray  # (samples, columns)
    scaled: np.ndarray  # (columns, samples) in radii: the data in [0, 1] over their ranges, divided by the radius
    sigma: np.ndarray  # (columns,) in the data's units
    density: np.ndarray  # (samples,)


def subtractive_clusters(
    data: Any,
    radius: float | Sequence[float] = 0.5,
    *,
    options: ClusteringOptions | None = None,
    ranges: Any = None,
    weights: Any = None,
) -> Clusters:
    """Find the centers of clusters in data by subtractive clustering [Chiu 1994; MATLAB subclust].

    The Gaussian of a cluster has the width radius · range / √8 in each column, which is that of the density exp(−4
    |Δ|²) with Δ in radii. Warns (DataWarning) of a constant column.

    Args:
        data: The samples (samples, columns).
        radius: The reach of a center as a share of each column's range; one, or one for each column.
        options: Squash factor, accept and reject ratio; by default MATLAB's 1.25, 0.5, 0.15.
        ranges: The ranges (2, columns), lowest above highest; by default those of the data.
        weights: How much each sample counts (samples,); by default alike.

    Returns:
        The centers (clusters, columns) in the data's units, in the order of discovery, and the Gaussians' widths.

    Raises:
        ClusteringError: Data and options that cannot be used.
    """
    return select_centers(densities(data, radius, ranges=ranges, weights=weights), options or ClusteringOptions())


def densities(
    data: Any,
    radius: float | Sequence[float] = 0.5,
    *,
    ranges: Any = None,
    weights: Any = None,
) -> Densities:
    """Compute P_i = Σ_j w_j exp(−4 |(u_i − u_j)/r|²) over the samples u scaled into [0, 1]   [Chiu 1994, (1)].

    The time grows with the square of the number of samples, the memory in proportion to it.

    Args:
        data: The samples (samples, columns), in any units.
        radius: The radius r as a share of the range: one for all columns, or one for each.
        ranges: The lowest and highest values (2, columns); samples outside are moved to the end. By default they are
            those of the data.
        weights: The weights w (samples,), at least 0; 1 by default.

    Raises ClusteringError; warns (DataWarning) of a constant column, which takes no part.
    """
    data = finite_table(data)
    samples, columns = data.shape
    try:
        radii = np.asarray(radius, dtype=float)
    except (TypeError, ValueError):
        radii = np.array(np.nan)
    if radii.shape not in ((), (columns,)) or not ((radii >= LEAST_RADIUS) & (radii <= LARGEST_RADIUS)).all():
        raise ClusteringError(
            f"radius must be >= {LEAST_RADIUS:g} and <= {LARGEST_RADIUS:g}, one number or one for each of {columns} "
            f"columns; got {radius!r}"
        )
    low, high = column_ranges(data) if ranges is None else _given_ranges(ranges, columns)
    share = None if weights is None else _given_weights(weights, samples)
    scaled = np.ascontiguousarray((np.clip((data - low) / (high - low), 0.0, 1.0) / radii).T)
    return Densities(data, scaled, radii * (high - low) / np.sqrt(8), _density(scaled, share))


def finite_table(values: Any, what: str = "the data", names: Sequence[str] | None = None) -> np.ndarray:
    """Read ``values`` as float64 (samples, columns).

    Raises ClusteringError, which names the place, for values that are not finite numbers.
    """
    try:
        table = np.asarray(values, dtype=float)
    except (TypeError, ValueError):
        raise ClusteringError(f"{what} must be numbers, as many in every row") from None
    if table.ndim != 2 or 0 in table.shape:
        raise ClusteringError(f"{what} must be (samples, columns), both at least 1; got shape {table.shape}")
    bad = np.argwhere(~np.isfinite(table))
    if len(bad):
        row, column = bad[0]
        name = f" ({names[column]})" if names is not None else ""
        raise ClusteringError(
            f"{what}: row {row + 1}, column {column + 1}{name} is {table[row, column]}; "
            "every value must be a finite number"
        )
    return table


def column_ranges(data: np.ndarray, names: Sequence[str] | None = None) -> tuple[np.ndarray, np.ndarray]:
    """Find the lowest and highest values (columns,) of the columns. A constant one is widened, with a DataWarning."""
    low, high = data.min(axis=0), data.max(axis=0)
    flat = np.flatnonzero(low == high).tolist()
    if flat:
        labels = [f"column {i + 1}" for i in range(len(low))] if names is None else names
        listed = ", ".join(f"{labels[i]} ({low[i]:g})" for i in flat)
        warnings.warn(f"constant, so nothing can be learnt from it: {listed}", DataWarning, stacklevel=3)
    return _apart(low, high)


def _apart(low: np.ndarray, high: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    margin = np.where(low == high, 1e-4 * (1 + np.abs(low)), 0.0)  # MATLAB's width of a constant column
    return low - margin, high + margin


def _given_ranges(ranges: Any, columns: int) -> tuple[np.ndarray, np.ndarray]:
    limits = np.asarray(ranges, dtype=float)
    if limits.shape != (2, columns) or not np.isfinite(limits).all() or (limits[0] > limits[1]).any():
        raise ClusteringError(f"ranges must be (2, {columns}): the lowest and the highest value of every column")
    return _apart(limits[0], limits[1])


def _given_weights(weights: Any, samples: int) -> np.ndarray:
    share = np.asarray(weights, dtype=float)
    if share.shape != (samples,) or not np.isfinite(share).all() or (share < 0).any() or not share.any():
        raise ClusteringError(f"weights must be ({samples},), finite, >= 0 and not all 0")
    return share


def _density(scaled: np.ndarray, share: np.ndarray | None) -> np.ndarray:
    """Σ_j w_j exp(−4 |a_i − a_j|²) (samples,) of ``scaled`` (columns, samples), tile by tile above the diagonal."""
    points = 2 * scaled
    samples = points.shape[1]
    weights = np.ones(samples) if share is None else share
    density = np.zeros(samples)
    height, width = _TILE
    total, step = np.empty(_TILE), np.empty(_TILE)
    for top in range(0, samples, height):
        rows = points[:, top : top + height, None]
        count = rows.shape[1]
        for left in range(top, samples, width):
            columns = points[:, None, left : left + width]
            near, part = (buffer[:count, : columns.shape[2]] for buffer in (total, step))
            near[:] = 0.0
            with np.errstate(over="ignore", under="ignore"):
                for a, b in zip(rows, columns, strict=True):
                    np.subtract(a, b, out=part)
                    np.multiply(part, part, out=part)
                    np.add(near, part, out=near)
                np.negative(near, out=near)
                np.exp(near, out=near)
                density[top : top + count] += near @ weights[left : left + width]
                # The same distances serve the columns' samples, except where the tile covers its own rows.
                below = max(left, top + count)
                density[below : left + width] += weights[top : top + count] @ near[:, below - left :]
    return density


def select_centers(found: Densities, options: ClusteringOptions, most: int | None = None) -> Clusters:
    """Select centers in order of density; each reduces the density round it   [Chiu 1994, (2)-(3)].

    Of samples with the same density the first is selected. The search ends after ``most`` centers.
    """
    scaled = found.scaled
    density = found.density.copy()
    rows: list[int] = []
    first = float(density.max())
    while most is None or len(rows) < most:
        top = float(density.max())
        share = top / first
        if rows and not share > options.reject:  # neither where densities are no numbers
            break
        k = int(np.argmax(density >= top * (1 - _TIE)))
        if rows and share <= options.accept:
            # The grey zone: far from every center makes up for a low density.
            nearest = np.sqrt(((scaled[:, rows] - scaled[:, k, None]) ** 2).sum(axis=0).min())
            if nearest + share < 1:
                density[k] = 0.0
                continue
        rows.append(k)
        distance = np.zeros_like(density)
        with np.errstate(over="ignore", under="ignore"):
            for column in scaled:
                distance += ((column - column[k]) * (2 / options.squash)) ** 2
            density -= density[k] * np.exp(-distance)
        np.maximum(density, 0.0, out=density)
    return Clusters(found.data[rows], found.sigma, np.array(rows))
