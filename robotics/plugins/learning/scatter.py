"""How far outputs scatter at equal inputs: the Gamma test   [Stefánsson, Končar & Jones 1997].

With y = f(x) + r, f smooth and r of variance Γ, half the mean squared difference between the outputs of a sample and
of its p-th nearest neighbour tends to Γ as the mean squared distance δ(p) of these neighbours tends to 0. A line over
δ(1), ..., δ(P) is extrapolated to δ = 0. No cells and no model of f are needed.

√Γ estimates the error that a smooth function of the inputs makes on fresh samples. It is no bound of a training error:
a flexible model tells samples apart that are all but equal, and then errs less on these.

A. Stefánsson, N. Končar, A. J. Jones, "A note on the Gamma test", Neural Computing & Applications 5 (1997), 131-133.
"""

from typing import Any, NamedTuple

import numpy as np
from scipy.spatial import cKDTree

from fuzzy.errors import InputError

NEIGHBOURS = 10  # P; the authors' usual choice
DRAWS = 20
SHARE = 0.25  # of the samples in each draw


class ScatterError(InputError):
    """Samples too few to have neighbours, or inputs and outputs of different lengths."""


class Scatter(NamedTuple):
    """√Γ of each output, in its unit: over the draws the mean, the least and the most; every field is (outputs,)."""

    rms: np.ndarray
    least: np.ndarray
    most: np.ndarray


def scatter(inputs: Any, outputs: Any, *, draws: int = DRAWS, share: float = SHARE, seed: int = 0) -> Scatter:
    """Estimate how far the outputs scatter at equal inputs, over ``draws`` random parts of the samples.

    Samples along a run follow each other evenly, and the neighbours of one do not come at random; a random part's do.
    A variance that comes out below 0, as it may where there is no scatter, counts as 0 in the limits and, if the mean
    over the draws is below 0, in the mean.

    Args:
        inputs: The inputs (samples,) or (samples, columns); distances are measured in shares of each column's range.
        outputs: The outputs (samples,) or (samples, columns), in any units.
        draws: The number of parts.
        share: The size of a part as a share of the samples, > 0 and <= 1.
        seed: The seed of the draws.

    Raises ScatterError where a part has no more than 10 samples.
    """
    x, y = (np.reshape(np.asarray(v, dtype=float), (len(v), -1)) for v in (inputs, outputs))
    count = round(share * len(x))
    if len(x) != len(y):
        raise ScatterError(f"each sample has inputs and outputs; got {len(x)} inputs and {len(y)} outputs")
    if count <= NEIGHBOURS:
        raise ScatterError(
            f"the scatter needs more than {NEIGHBOURS} samples in a part; {share:g} of {len(x)} are {count}"
        )
    rng = np.random.default_rng(seed)
    spans = np.ptp(x, axis=0)
    x = x / np.where(spans > 0, spans, 1.0)
    parts = [rng.permutation(len(x))[:count] for _ in range(draws)]
    found = np.array([_gamma(x[part], y[part]) for part in parts])
    return Scatter(*(np.sqrt(np.maximum(v, 0.0)) for v in (found.mean(axis=0), found.min(axis=0), found.max(axis=0))))


def _gamma(x: np.ndarray, y: np.ndarray) -> np.ndarray:
    """Γ (outputs,): the intercept of γ(p) over δ(p), p = 1, ..., P, by least squares."""
    distance, nearest = cKDTree(x).query(x, k=NEIGHBOURS + 1)
    delta = np.mean(distance[:, 1:] ** 2, axis=0)  # (P,); the nearest is the sample itself, or its equal
    gamma = np.mean((y[nearest[:, 1:]] - y[:, None]) ** 2, axis=0) / 2  # (P, outputs)
    line = np.stack([np.ones(NEIGHBOURS), delta], axis=1)
    intercept: np.ndarray = np.linalg.lstsq(line, gamma, rcond=None)[0][0]
    return intercept
