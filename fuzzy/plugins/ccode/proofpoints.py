"""The points at which a system in C is compared with the system, and what the system answers there."""

import warnings
from collections.abc import Callable

import numpy as np

from fuzzy.compiled.sugeno import compile_sugeno
from fuzzy.inference import InferenceWarning
from fuzzy.system import Sugeno


def answers_of(fis: Sugeno, x: np.ndarray, answers: Callable[[np.ndarray], np.ndarray] | None = None) -> np.ndarray:
    """What a system, or ``answers``, says (..., outputs) at ``x`` (..., inputs), also far away and of no rule."""
    with warnings.catch_warnings(action="ignore", category=InferenceWarning), np.errstate(all="ignore"):
        return np.asarray((answers or compile_sugeno(fis))(x))


def proof_points(fis: Sugeno, count: int, seed: int, inside: bool = False) -> np.ndarray:
    """Points (count, inputs) in the universes of discourse and, unless ``inside``, beyond; a quarter at the kinks.

    Of those that may lie beyond, some 16 have an input that is infinite and 16 one that is not-a-number.
    """
    rng = np.random.default_rng(seed)
    low, high = np.array([v.universe for v in fis.inputs]).T
    span = np.where(high > low, high - low, 1.0)
    beyond = 0.0 if inside else 0.2
    x = rng.uniform(low - beyond * span, high + beyond * span, (count, len(low)))
    for i, variable in enumerate(fis.inputs):
        kinks = [
            float(number)
            for function in variable.terms.values()
            for role, number in zip(function.roles, function.numbers, strict=True)
            if role == "location" and np.isfinite(number)
        ]
        kinks = [*kinks, *variable.universe]
        rows = np.flatnonzero(rng.random(count) < 0.25)
        at = rng.choice(kinks, len(rows)) + span[i] * rng.choice([0.0, 0.0, 1e-15, -1e-15, 1e-6, -1e-6], len(rows))
        x[rows, i] = np.clip(at, low[i], high[i]) if inside else at
    if not inside and count >= 48:
        x[:: count // 16, rng.integers(len(low))] = np.inf
        x[1 :: count // 16, rng.integers(len(low))] = np.nan
    return x
