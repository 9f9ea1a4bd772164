"""Communication graphs against networkx, closed-form eigenvalues and thesis 4.5."""

from math import cos, pi, sqrt

import networkx as nx
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from robotics.world.radio.graph import GRAPHS, adjacency, is_connected, laplacian, smallest_eigenvalue, unreached


@st.composite
def digraphs(draw):
    """Adjacency matrices of 1 to 8 robots, from empty to complete."""
    n = draw(st.integers(1, 8))
    density = draw(st.floats(0, 1))
    a = (np.random.default_rng(draw(st.integers(0, 2**32))).random((n, n)) < density).astype(float)
    np.fill_diagonal(a, 0.0)
    return a


def hearing(a):
    """The directed graph of who hears whom: an edge from the sender to the receiver."""
    return nx.from_numpy_array(a.T, create_using=nx.DiGraph)


@pytest.mark.parametrize("n", [1, 2, 3, 4, 7, 50])
def test_named_graphs_are_those_of_networkx(n):
    nodes = range(n)
    theirs = {
        "complete": nx.complete_graph(n),
        "line": nx.path_graph(n),
        "ring": nx.cycle_graph(n) if n > 2 else nx.path_graph(n),
        "star": nx.star_graph(n - 1),
    }
    for name, graph in theirs.items():
        expected = nx.to_numpy_array(graph, nodelist=nodes)
        np.testing.assert_array_equal(adjacency(name, n), expected, err_msg=name)
    assert set(GRAPHS) == {*theirs, "edges"}


@pytest.mark.parametrize("hub", [1, 2, 5])
def test_the_hub_of_a_star_is_counted_from_one(hub):
    a = adjacency("star", 5, hub)
    assert a.sum(axis=0).tolist() == a.sum(axis=1).tolist() == [4.0 if i == hub else 1.0 for i in range(1, 6)]
    assert not a.diagonal().any()


def test_edges_go_from_the_sender_to_the_receiver():
    a = adjacency("edges", 3, edges=[(1, 2), (3, 1)])
    assert a.tolist() == [[0, 0, 1], [1, 0, 0], [0, 0, 0]]  # robot 2 hears robot 1, and robot 1 robot 3


@given(digraphs())
@settings(max_examples=60)
def test_the_rows_of_a_laplacian_sum_to_nothing_and_its_diagonal_is_the_in_degree(a):
    m = laplacian(a)
    np.testing.assert_array_equal(m.sum(axis=1), 0.0)
    np.testing.assert_array_equal(np.diag(m), [degree for _, degree in hearing(a).in_degree()])
    np.testing.assert_array_equal(m - np.diag(np.diag(m)), -a)
    both = np.maximum(a, a.T)
    theirs = nx.laplacian_matrix(nx.from_numpy_array(both)).toarray()
    np.testing.assert_array_equal(laplacian(both), theirs)


@pytest.mark.parametrize("n", [3, 4, 5, 8, 20])
def test_eigenvalues_have_their_closed_forms(n):
    k = np.arange(n)
    closed = {
        "complete": [0.0] + [float(n)] * (n - 1),
        "star": [0.0] + [1.0] * (n - 2) + [float(n)],
        "ring": 2 - 2 * np.cos(2 * pi * k / n),
        "line": 2 - 2 * np.cos(pi * k / n),
    }
    for name, values in closed.items():
        found = np.linalg.eigvalsh(laplacian(adjacency(name, n)))
        np.testing.assert_allclose(found, np.sort(values), rtol=0, atol=1e-12 * n, err_msg=name)


def test_the_star_of_thesis_4_5():
    """Three robots, the first the hub: L + B has the eigenvalues 1, 2, 4 if all hear the leader, else 2 ± √3 and 1."""
    a = adjacency("star", 3)
    assert smallest_eigenvalue(a, np.ones(3)) == pytest.approx(1.0, abs=1e-12)
    assert smallest_eigenvalue(a, np.array([1.0, 0.0, 0.0])) == pytest.approx(2 - sqrt(3), abs=1e-12)
    for b, values in (([1, 1, 1], (1, 2, 4)), ([1, 0, 0], (2 - sqrt(3), 1, 2 + sqrt(3)))):
        found = np.linalg.eigvalsh(laplacian(a) + np.diag(b))
        np.testing.assert_allclose(found, values, rtol=0, atol=1e-12)


def test_the_smallest_eigenvalue_of_a_line_led_at_one_end():
    """Fixed at one end, free at the other: 2 − 2 cos(π / (2n + 1))."""
    for n in (1, 2, 3, 10, 40):
        b = np.zeros(n)
        b[0] = 1.0
        expected = 2 - 2 * cos(pi / (2 * n + 1))
        assert smallest_eigenvalue(adjacency("line", n), b) == pytest.approx(expected, abs=1e-12)


@given(digraphs(), st.integers(0, 2**32))
@settings(max_examples=60)
def test_the_smallest_eigenvalue_bounds_every_quadratic_form_and_is_reached(a, seed):
    rng = np.random.default_rng(seed)
    b = rng.integers(0, 2, len(a)) * 1.0
    m = laplacian(a) + np.diag(b)
    smallest = smallest_eigenvalue(a, b)
    x = rng.standard_normal((len(a), 200))
    ratios = np.einsum("ik,ij,jk->k", x, m, x) / (x**2).sum(axis=0)
    assert (ratios >= smallest - 1e-12).all()
    eigenvector = np.linalg.eigh((m + m.T) / 2)[1][:, 0]
    assert eigenvector @ m @ eigenvector == pytest.approx(smallest, abs=1e-12)


@given(digraphs())
@settings(max_examples=150)
def test_connected_means_strongly_connected(a):
    assert is_connected(a) == nx.is_strongly_connected(hearing(a))


def test_every_named_graph_is_connected_and_one_way_rows_are_not():
    for name in ("complete", "star", "line", "ring"):
        for n in (1, 2, 3, 10):
            assert is_connected(adjacency(name, n))
    assert not is_connected(adjacency("edges", 3, edges=[(1, 2), (2, 3)]))
    assert is_connected(adjacency("edges", 3, edges=[(1, 2), (2, 3), (3, 1)]))


@given(digraphs(), st.integers(0, 255))
@settings(max_examples=150)
def test_unreached_are_those_that_no_informed_robot_leads_to(a, mask):
    informed = np.array([mask >> i & 1 for i in range(len(a))], dtype=bool)
    graph = hearing(a)
    reached = {int(i) for i in np.flatnonzero(informed)}
    reached |= {j for i in list(reached) for j in nx.descendants(graph, i)}
    assert unreached(a, informed) == [i + 1 for i in range(len(a)) if i not in reached]


@given(digraphs(), st.integers(0, 255))
@settings(max_examples=80)
def test_an_undirected_team_with_everybody_reached_has_a_positive_smallest_eigenvalue(a, mask):
    both = np.maximum(a, a.T)
    b = np.array([float(mask >> i & 1) for i in range(len(a))])
    assert (smallest_eigenvalue(both, b) > 1e-9) == (not unreached(both, b > 0))
