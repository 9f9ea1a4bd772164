"""Communication graphs: who hears whom, the Laplacian of thesis (3.1), and connectivity.

An adjacency matrix is (robots, robots) with a[i, j] = 1 where robot i hears robot j, and 0 on the diagonal.
"""

from collections.abc import Sequence

import numpy as np

GRAPHS = ("star", "ring", "line", "complete", "edges")


def adjacency(graph: str, robots: int, hub: int = 1, edges: Sequence[tuple[int, int]] = ()) -> np.ndarray:
    """The adjacency matrix (robots, robots) of a named graph: row i has a 1 where robot i hears robot j.

    Args:
        graph: "star", "ring", "line", "complete" or "edges"; all but "edges" are undirected.
        robots: The number of robots.
        hub: The center of a star, from 1.
        edges: Pairs (sender, receiver), from 1, for the graph "edges".
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
    """The weights a_ij of the links (robots, robots): 1 each, or 2 / n where a robot hears n > 2 others.

    Two neighbours, as in the thesis's teams of three, thus count in full. If the sum of a robot's weights grew with the
    team, coupling over messages that are a period old would be unstable beyond some ten neighbours.
    """
    return np.asarray(a * np.minimum(1.0, 2 / np.maximum(a.sum(axis=1, keepdims=True), 1.0)))


def laplacian(a: np.ndarray) -> np.ndarray:
    """L = D − A (robots, robots)   thesis (3.1); its rows sum to 0.

    Args:
        a: The adjacency matrix (robots, robots).
    """
    return np.asarray(np.diag(a.sum(axis=1)) - a)


def is_connected(a: np.ndarray) -> bool:
    """Whether the message of every robot reaches every other, over others if need be: a strongly connected graph."""
    from scipy.sparse.csgraph import connected_components

    count, _ = connected_components(a, directed=True, connection="strong")
    return bool(count == 1)


def unreached(a: np.ndarray, informed: np.ndarray) -> list[int]:
    """The robots (from 1) that no message of the ``informed`` (robots,) bool reaches, directly or over others."""
    known = np.asarray(informed, dtype=bool).copy()
    for _ in range(len(a)):
        known |= (a[:, known] > 0).any(axis=1)
    return [int(i) + 1 for i in np.flatnonzero(~known)]


def smallest_eigenvalue(a: np.ndarray, b: np.ndarray) -> float:
    """λ_min of L + B with B = diag(``b``), b (robots,); for a directed graph that of its symmetric part."""
    h = laplacian(a) + np.diag(b)
    return float(np.linalg.eigvalsh((h + h.T) / 2)[0])
