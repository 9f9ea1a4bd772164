"""Communication graphs: who hears whom, the Laplacian of thesis (3.1), and what connectivity gives.

An adjacency matrix is (robots, robots) with a[i, j] = 1 where robot i hears robot j, and 0 on the diagonal.
"""

from collections.abc import Sequence

import numpy as np

GRAPHS = ("star", "ring", "line", "complete", "edges")


def adjacency(graph: str, robots: int, hub: int = 1, edges: Sequence[tuple[int, int]] = ()) -> np.ndarray:
    """The adjacency matrix (robots, robots) of a named graph.

    ``hub`` (from 1) is the center of a star. ``edges`` are pairs (sender, receiver), from 1, for the graph "edges";
    the others are undirected.
    """
    a = np.zeros((robots, robots))
    i = np.arange(robots)
    if graph == "complete":
        a[:] = 1.0
    elif graph == "star":
        a[hub - 1, :] = a[:, hub - 1] = 1.0
    elif graph in ("line", "ring"):
        a[i[:-1], i[1:]] = a[i[1:], i[:-1]] = 1.0
        if graph == "ring" and robots > 2:
            a[0, -1] = a[-1, 0] = 1.0
    else:
        for sender, receiver in edges:
            a[receiver - 1, sender - 1] = 1.0
    np.fill_diagonal(a, 0.0)
    return a


def weights(a: np.ndarray) -> np.ndarray:
    """The weights a_ij of the links (robots, robots): 1 each, or 2 / (how many a robot hears) where that is less.

    Two neighbours, as in the thesis's teams of three, count in full. With the sum of a robot's weights growing with
    the team, coupling over messages that are a period old would be unstable beyond some ten neighbours.
    """
    heard = a.sum(axis=1, keepdims=True)
    return np.asarray(a * np.minimum(1.0, 2 / np.maximum(heard, 1.0)))


def laplacian(a: np.ndarray) -> np.ndarray:
    """L = D − A   thesis (3.1); its rows sum to 0."""
    return np.asarray(np.diag(a.sum(axis=1)) - a)


def is_connected(a: np.ndarray) -> bool:
    """Does what every robot says reach every other, over others if need be? Strongly connected, if directed."""
    from scipy.sparse.csgraph import connected_components

    count, _ = connected_components(a, directed=True, connection="strong")
    return bool(count == 1)


def unreached(a: np.ndarray, informed: np.ndarray) -> list[int]:
    """The robots (from 1) that nothing known to the ``informed`` (robots,) ones, directly or over others, reaches."""
    known = np.asarray(informed, dtype=bool).copy()
    for _ in range(len(a)):
        known |= (a[:, known] > 0).any(axis=1)
    return [int(i) + 1 for i in np.flatnonzero(~known)]


def smallest_eigenvalue(a: np.ndarray, b: np.ndarray) -> float:
    """λ_min of L + B with B = diag(``b``): of its symmetric part, if the graph is directed."""
    h = laplacian(a) + np.diag(b)
    return float(np.linalg.eigvalsh((h + h.T) / 2)[0])
