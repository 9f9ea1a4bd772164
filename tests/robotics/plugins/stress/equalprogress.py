"""Points of paths at equal progress, for what random crossings and crossing lanes promise."""

import numpy as np


def samples(tables):
    """(robots, 101, 2): points at equal shares of the lengths."""
    places = [np.linspace(0, t.shape[1] - 1, 101) for t in tables]
    return np.array(
        [[np.interp(p, np.arange(t.shape[1]), t[k]) for k in (0, 1)] for t, p in zip(tables, places, strict=True)]
    ).swapaxes(1, 2)
