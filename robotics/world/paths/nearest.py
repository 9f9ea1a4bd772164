"""The nearest point of a path, and how far to its left it lies: compiled, for many points at a time.

The nodes of a path are kept in boxes of BOX nodes, and those in boxes of BOX boxes. A box that is farther away than the
nearest node so far holds no nearer one, so that of thousands of nodes some dozens are looked at. No node is missed, on
paths that cross themselves neither: the answer is that of looking at all of them.
"""

import numpy as np

from fuzzy.compiled.jit import kernel

BOX = 16  # nodes in a box, and boxes in a larger one
CLOSED = 1e-6  # m: a path whose ends are as near as that is closed


def signed_distances(nodes: np.ndarray, x: np.ndarray, y: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """How far points lie beside a path, > 0 on its left side, and beyond its end [m], each of the shape of ``x``.

    Beside is the distance of the nearest point, beyond 0; but past the end of a path that is not closed they are the
    parts across the last chord and along it. The distance is measured to the two chords that meet in the nearest node;
    of nodes equally near the first counts. What is not finite has none: it gets not-a-number.

    Args:
        nodes: The path's nodes (2, nodes) [m], at least two.
        x: Of the points (runs, samples) [m]; along a row they follow each other.
        y: Likewise.
    """
    beside, beyond = np.empty((2, *x.shape))
    closed = bool(np.hypot(*(nodes[:, 0] - nodes[:, -1])) < CLOSED)
    _search(*boxed(nodes), closed, x, y, beside, beyond)
    return beside, beyond


def boxed(nodes: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """A path's ``nodes`` (2, nodes) with their boxes and these boxes' boxes (4, boxes), for :func:`nearest_node`."""
    nodes = np.ascontiguousarray(nodes, dtype=float)
    small = _boxes(np.concatenate([nodes, nodes]))
    return nodes, small, _boxes(small)


@kernel
def _boxes(inner):  # type: ignore[no-untyped-def]
    """The least x and y and the greatest of each BOX columns of ``inner`` (4, n)."""
    number = inner.shape[1]
    found = np.empty((4, -(-number // BOX)))
    for b in range(found.shape[1]):
        found[0, b] = found[1, b] = np.inf
        found[2, b] = found[3, b] = -np.inf
        for n in range(b * BOX, min((b + 1) * BOX, number)):
            found[0, b] = min(found[0, b], inner[0, n])
            found[1, b] = min(found[1, b], inner[1, n])
            found[2, b] = max(found[2, b], inner[2, n])
            found[3, b] = max(found[3, b], inner[3, n])
    return found


@kernel
def _from_box(boxes, b, x, y):  # type: ignore[no-untyped-def]
    """The squared distance of a point from a box."""
    dx = max(boxes[0, b] - x, x - boxes[2, b], 0.0)
    dy = max(boxes[1, b] - y, y - boxes[3, b], 0.0)
    return dx * dx + dy * dy


@kernel
def nearest_node(nodes, small, large, x, y, guess, low, high):  # type: ignore[no-untyped-def]
    """The first of the nodes from ``low`` to ``high`` that are nearest to a point; the arrays are of :func:`boxed`.

    A good ``guess`` from low to high saves time, and changes nothing.
    """
    dx, dy = nodes[0, guess] - x, nodes[1, guess] - y
    best, least = guess, dx * dx + dy * dy
    for c in range(low // (BOX * BOX), high // (BOX * BOX) + 1):
        if _from_box(large, c, x, y) > least:
            continue
        for b in range(max(c * BOX, low // BOX), min((c + 1) * BOX, high // BOX + 1)):
            if _from_box(small, b, x, y) > least:
                continue
            for n in range(max(b * BOX, low), min((b + 1) * BOX, high + 1)):
                dx, dy = nodes[0, n] - x, nodes[1, n] - y
                squared = dx * dx + dy * dy
                if squared < least or (squared == least and n < best):
                    best, least = n, squared
    return best


@kernel(nogil=True)
def _search(nodes, small, large, closed, x, y, beside, beyond):  # type: ignore[no-untyped-def]
    last = nodes.shape[1] - 1
    for r in range(x.shape[0]):
        near = 0
        for k in range(x.shape[1]):
            here_x, here_y = x[r, k], y[r, k]
            if not (np.isfinite(here_x) and np.isfinite(here_y)):
                beside[r, k] = beyond[r, k] = np.nan
                continue
            near = nearest_node(nodes, small, large, here_x, here_y, near, 0, last)
            least, signed, past = np.inf, 0.0, 0.0
            for n in (max(near - 1, 0), min(near, last - 1)):
                chord_x, chord_y = nodes[0, n + 1] - nodes[0, n], nodes[1, n + 1] - nodes[1, n]
                dx, dy = here_x - nodes[0, n], here_y - nodes[1, n]
                squared = chord_x * chord_x + chord_y * chord_y
                if not squared > 0:
                    continue
                along = (dx * chord_x + dy * chord_y) / squared
                t = min(max(along, 0.0), 1.0)
                if along > 1 and n == last - 1 and not closed:
                    t, past = along, (along - 1) * np.sqrt(squared)
                distance = np.hypot(dx - t * chord_x, dy - t * chord_y)
                if distance < least:
                    least = distance
                    signed = -distance if chord_x * dy - chord_y * dx < 0 else distance
            beside[r, k], beyond[r, k] = signed, past
