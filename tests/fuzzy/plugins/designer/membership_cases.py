"""Parameters to compare the membership functions of the page with Python's on."""

import numpy as np

from fuzzy.errors import InputError
from fuzzy.membership import FUNCTIONS, membership_function


def cases(rng: np.random.Generator) -> list[tuple[str, list[float]]]:
    """Parameters of every function: random ones, upright edges, crossed and turned ones."""
    out = []
    for function in FUNCTIONS:
        for _ in range(60):
            p = rng.uniform(-2, 2, len(function.roles))
            if function.ascending() and rng.random() < 0.8:
                p = np.sort(p)
            ties = rng.random(len(p)) < 0.2
            p[1:][ties[1:]] = p[:-1][ties[1:]]
            out.append((function.matlab, (np.round(p, 1) if rng.random() < 0.5 else p).tolist()))
        out.append((function.matlab, [1e-3, 40.0, 0.5, 0.5][: len(function.roles)]))
        out.append((function.matlab, [0.0, -3.0, 0.0, 200.0][: len(function.roles)]))
    legal = []
    for name, p in out:
        try:
            membership_function(name, p)
        except InputError:
            continue
        legal.append((name, p))
    return legal
