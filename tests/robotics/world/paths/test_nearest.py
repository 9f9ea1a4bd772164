"""The nearest point of a path, beside a k-d tree and beside looking at all nodes."""

import numpy as np
import pytest
from scipy.spatial import cKDTree

from robotics.world.paths.nearest import signed_distances

TURN = np.linspace(0, 2 * np.pi, 777)
PATHS = {
    "figure of eight, crossing itself": np.stack([np.sin(TURN), np.sin(2 * TURN)]),
    "rose, crossing itself often": np.stack([np.cos(4 * TURN) * np.cos(TURN), np.cos(4 * TURN) * np.sin(TURN)]),
    "circle, ending where it begins": np.stack([np.cos(TURN), np.sin(TURN)]),
    "line of two nodes": np.array([[0.0, 1.0], [0.0, 0.5]]),
    "random walk": np.random.default_rng(5).normal(size=(2, 1000)).cumsum(axis=1) / 20,
}


def by_tree(nodes, points):
    """The definition in numpy: the two chords that meet in the node that a k-d tree finds."""
    _, nearest = cKDTree(nodes.T).query(points)
    last, closed = nodes.shape[1] - 1, np.allclose(nodes[:, 0], nodes[:, -1], rtol=0, atol=1e-9)
    best, signed = np.full(len(points), np.inf), np.zeros(len(points))
    for start in (nearest - 1, nearest):
        k = np.clip(start, 0, nodes.shape[1] - 2)
        chord, offset = (nodes[:, k + 1] - nodes[:, k]).T, points - nodes[:, k].T
        along = (offset * chord).sum(-1) / (chord**2).sum(-1)
        t = np.where((along > 1) & (k == last - 1) & (not closed), along, np.clip(along, 0.0, 1.0))
        distance = np.hypot(*(offset - t[:, None] * chord).T)
        side = np.where(chord[:, 0] * offset[:, 1] - chord[:, 1] * offset[:, 0] < 0, -1.0, 1.0)
        closer = distance < best
        best, signed = np.where(closer, distance, best), np.where(closer, side * distance, signed)
    return signed


@pytest.mark.parametrize("name", PATHS)
def test_distances_are_those_of_a_k_d_tree(name):
    nodes, rng = PATHS[name], np.random.default_rng(0)
    # a walk along the path, as robots drive, and points anywhere
    along = nodes[:, np.linspace(0, nodes.shape[1] - 1, 1000).astype(int)] + rng.normal(scale=0.05, size=(2, 1000))
    points = np.concatenate([along.T, rng.uniform(-4, 4, (2000, 2))])
    first, second = cKDTree(nodes.T).query(points, k=2)[0].T
    tied = np.isclose(first, second, rtol=0, atol=1e-12)  # either node is right
    found = signed_distances(nodes, points[:, 0].reshape(3, -1), points[:, 1].reshape(3, -1))[0].ravel()
    np.testing.assert_allclose(found[~tied], by_tree(nodes, points)[~tied], rtol=0, atol=1e-12)
    assert (~tied).sum() > 2900


def test_a_point_does_not_depend_on_those_before_it_to_the_last_bit():
    points = np.random.default_rng(1).normal(size=(2, 1, 400))
    nodes = PATHS["rose, crossing itself often"]
    together = signed_distances(nodes, *points)[0]
    backwards = signed_distances(nodes, *points[:, :, ::-1])[0][:, ::-1]
    alone = signed_distances(nodes, *points.transpose(0, 2, 1))[0].T
    assert together.tobytes() == backwards.tobytes() == alone.tobytes()


def test_what_is_nowhere_has_no_distance():
    x = np.array([[np.nan, 0.0, np.inf, 2.0]])
    found = signed_distances(np.array([[0.0, 1.0], [0.0, 0.0]]), x, np.ones((1, 4)))
    np.testing.assert_allclose(found[0], [[np.nan, 1.0, np.nan, 1.0]])
    np.testing.assert_allclose(found[1], [[np.nan, 0.0, np.nan, 1.0]])


def test_past_the_end_only_what_lies_across_counts_but_a_closed_path_has_no_end():
    line = np.array([[0.0, 1.0, 2.0], [0.0, 0.0, 0.0]])
    x, y = np.array([[-1.0, 1.5, 2.5, 2.5]]), np.array([[0.0, 0.3, -0.003, 0.0]])
    beside, beyond = signed_distances(line, x, y)
    np.testing.assert_allclose(beside, [[1.0, 0.3, -0.003, 0.0]], atol=1e-15)  # before the start it is the way to it
    np.testing.assert_allclose(beyond, [[0.0, 0.0, 0.5, 0.5]])
    beside, beyond = signed_distances(PATHS["circle, ending where it begins"], np.array([[1.0]]), np.array([[0.05]]))
    assert abs(beside[0, 0]) < 0.0013
    assert beyond[0, 0] == 0.0
