"""The ridge of a least squares as more samples, for numpy's arrays and torch's alike."""

import numpy as np

from anfis.point import Array, numbers
from fuzzy.membershipfunction import like


def ridge_rows(
    columns: Array, equations: tuple[Array, Array], weight: float, middle: Array, half: Array, normalise: bool
) -> tuple[Array, Array]:
    """The ridge λ of :mod:`fuzzy.fitting.consequents` as more samples: rows (parameters, parameters) and their targets.

    Appended to a design matrix and its targets they add λ N |θ|² to the sum of squares: θ = T values − m are the
    consequents for inputs scaled to [−1, 1], T changes the scale, m is the outputs' mean at the constants. ``weight``
    is λ N, with the N samples where a rule fires; ``equations`` are theirs, Σ aᵀa and Σ aᵀy; ``columns`` (parameters,)
    are which of the terms × (inputs + 1) columns are free; ``middle`` and ``half`` (inputs,) are those of the samples'
    range, in the scale of the values.
    """
    gram, moment = equations
    scale = np.diag(np.append(numbers(half), 1.0))
    scale[-1, :-1] = numbers(middle)
    term, place = np.divmod(numbers(columns).astype(int), len(scale))
    change = like(gram, np.where(term[:, None] == term, scale[np.ix_(place, place)], 0.0))
    constants = like(gram, (place == len(scale) - 1).astype(float))
    # Weights that sum to 1 where a rule fires, and to 0 elsewhere: the sum of the constants' columns is who fires.
    fires = max(float(constants @ gram @ constants), 1.0)
    means = (constants @ moment) / fires * normalise
    return weight**0.5 * change, weight**0.5 * constants[:, None] * means
