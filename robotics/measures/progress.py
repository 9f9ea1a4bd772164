"""Progress: where robots truly are on their paths."""

import numpy as np

from fuzzy.compiled.jit import kernel
from robotics.measures.once import CachedPerRun
from robotics.simulation.run import Run
from robotics.world.paths.nearest import boxed, nearest_node

_SEARCH_REACH = 0.5  # m: how far from the last place on the path the next is looked for
_START = 0.25  # of the path: where the first place is looked for


@CachedPerRun
def true_progress(run: Run) -> np.ndarray:
    """The share of its path that each robot truly has behind it, 0 to 1, (runs, robots, samples).

    It is that of the path's nearest point, which is searched for within half a metre of the one before, so that
    crossing or closed paths are followed along their branch. It is not-a-number once a robot is stopped.

    Args:
        run: The run.
    """
    result = np.empty(run["x"].shape)
    for i, nodes in enumerate(run.paths):
        length = float(np.hypot(*np.diff(nodes, axis=1)).sum())
        spacing = length / (nodes.shape[1] - 1)
        window = max(2, int(_SEARCH_REACH / spacing))
        first = max(2, int(_START * nodes.shape[1]))
        _follow(*boxed(nodes), run["x"][:, i], run["y"][:, i], window, first, result[:, i])
    return result


@kernel(nogil=True)
def _follow(nodes, small, large, x, y, window, first, out):  # type: ignore[no-untyped-def]
    last = nodes.shape[1] - 1
    for r in range(x.shape[0]):
        best, low, high = 0, 0, min(first, last)
        for k in range(x.shape[1]):
            if not (np.isfinite(x[r, k]) and np.isfinite(y[r, k])):
                out[r, k] = np.nan
                continue
            best = nearest_node(nodes, small, large, x[r, k], y[r, k], best, low, high)
            place = 0.0
            nearest = np.inf
            for n in (best - 1, best):  # the two chords that meet in the node
                if n < 0 or n >= last:
                    continue
                cx = nodes[0, n + 1] - nodes[0, n]
                cy = nodes[1, n + 1] - nodes[1, n]
                dx = x[r, k] - nodes[0, n]
                dy = y[r, k] - nodes[1, n]
                t = min(max((dx * cx + dy * cy) / (cx * cx + cy * cy), 0.0), 1.0)
                d = (dx - t * cx) ** 2 + (dy - t * cy) ** 2
                if d < nearest:
                    nearest = d
                    place = n + t
            out[r, k] = place / last
            low = max(best - window, 0)
            high = min(best + window, last)


def progress_gap(run: Run) -> np.ndarray:
    """The foremost robot's true progress minus the rearmost's (runs, samples), shares of the paths.

    Args:
        run: The run.
    """
    progress = true_progress(run)
    return np.asarray(progress.max(axis=1) - progress.min(axis=1))
