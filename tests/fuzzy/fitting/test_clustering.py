"""Subtractive clustering against reference results and a direct transcription of Chiu's formulas."""

import re
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

import fuzzy.fitting.clustering
from fuzzy.fitting.clustering import (
    ClusteringError,
    ClusteringOptions,
    Clusters,
    DataWarning,
    densities,
    select_centers,
    subtractive_clusters,
)

DATA = Path(__file__).parents[2] / "data" / "clustering"
REFERENCES = sorted(DATA.glob("*.out.csv"))


def direct(data, radius, squash, accept, reject) -> tuple[list[int], np.ndarray]:
    """Chiu's method, sample by sample, in the words of his paper."""
    low, high = data.min(axis=0), data.max(axis=0)
    u = (data - low) / (high - low)
    samples = len(u)
    degrees = [sum(np.exp(-4 * np.sum((u[i] - u[j]) ** 2) / radius**2) for j in range(samples)) for i in range(samples)]
    p = np.array(degrees)
    first = p.max()
    rows: list[int] = []
    while True:
        k = int(np.argmax(p >= p.max() * (1 - 1e-12)))  # two lone neighbours are equally dense, whatever the rounding
        ratio = p[k] / first
        if rows:
            distance = min(np.sqrt(np.sum((u[k] - u[c]) ** 2)) / radius for c in rows)
            if ratio <= reject:
                return rows, radius * (high - low) / np.sqrt(8)
            if ratio <= accept and distance + ratio < 1:
                p[k] = 0
                continue
        rows.append(k)
        p = np.maximum(0, p - p[k] * np.exp(-4 * np.sum((u - u[k]) ** 2, axis=1) / (squash * radius) ** 2))


def setting(path: Path) -> tuple[float, ClusteringOptions]:
    first = path.read_text().splitlines()[0]
    numbers = re.search(r"=\((.*)\)", first)
    assert numbers is not None
    radius, *ratios = map(float, numbers[1].split(","))
    return radius, ClusteringOptions(*ratios)


def test_there_are_nine_references() -> None:
    assert len(REFERENCES) == 9
    assert {setting(path)[1].reject for path in REFERENCES} == {0.15, 0.3}


@pytest.mark.parametrize("path", REFERENCES, ids=lambda path: path.name[9:-8])
def test_equals_two_other_implementations(path) -> None:
    name = path.name.split("_")[1]
    data = np.loadtxt(DATA / f"subclust_{name}.csv", delimiter=",")
    expected = np.loadtxt(path, delimiter=",")
    radius, options = setting(path)
    found = subtractive_clusters(data, radius, options=options)
    scale = np.abs(data).max(axis=0)
    assert found.centers.shape == expected[:-1].shape
    assert np.abs((found.centers - expected[:-1]) / scale).max() < 1e-14
    assert np.abs((found.sigma - expected[-1]) / scale).max() < 1e-14
    assert (data[found.rows] == found.centers).all()


@settings(max_examples=60)
@given(
    seed=st.integers(0, 2**32 - 1),
    samples=st.integers(2, 40),
    columns=st.integers(1, 3),
    radius=st.floats(0.25, 1.2),
    squash=st.floats(0.1, 2),
    ratios=st.tuples(st.floats(0.05, 0.95), st.floats(0.05, 0.95)),
)
def test_equals_the_paper(seed, samples, columns, radius, squash, ratios) -> None:
    reject, accept = sorted(ratios)
    data = np.random.default_rng(seed).normal(size=(samples, columns)) * [1e-3, 1, 1e6][:columns]
    rows, sigma = direct(data, radius, squash, accept, reject)
    found = subtractive_clusters(data, radius, options=ClusteringOptions(squash, accept, reject))
    assert found.rows.tolist() == rows
    assert found.sigma == pytest.approx(sigma, rel=1e-13)


@pytest.mark.parametrize("tile", [(1, 1), (3, 7), (7, 3), (16, 16), (64, 1024)])
@pytest.mark.parametrize("weighted", [False, True])
def test_density_does_not_depend_on_the_tiles(tile, weighted, monkeypatch) -> None:
    rng = np.random.default_rng(1)
    data, weights = rng.random((50, 3)), rng.random(50)
    weights[3] = 0
    monkeypatch.setattr(fuzzy.fitting.clustering, "_TILE", tile)
    found = densities(data, [0.3, 0.5, 0.7], weights=weights if weighted else None)
    unit = (data - data.min(axis=0)) / np.ptp(data, axis=0) / [0.3, 0.5, 0.7]
    near = np.exp(-4 * ((unit[:, None] - unit[None]) ** 2).sum(axis=-1))
    assert found.density == pytest.approx(near @ (weights if weighted else np.ones(50)), rel=1e-13)


def test_a_sample_of_weight_two_counts_twice() -> None:
    data = np.random.default_rng(2).random((30, 2))
    ranges = np.array([[0.0, 0.0], [1.0, 1.0]])
    weights = np.ones(30)
    weights[7] = 2
    once = densities(data, 0.4, weights=weights, ranges=ranges).density
    twice = densities(np.vstack([data, data[7]]), 0.4, ranges=ranges).density
    assert once == pytest.approx(twice[:30], rel=1e-13)


def test_ranges_scale_and_clip() -> None:
    data = np.array([[0.0], [1.0], [9.0]])
    found = subtractive_clusters(data, 0.5, ranges=[[0], [4]])
    assert found.sigma == pytest.approx([0.5 * 4 / np.sqrt(8)])
    density = densities(data, 0.5, ranges=[[0], [4]]).density
    assert density == pytest.approx(
        [1 + np.exp(-1) + np.exp(-16), 1 + np.exp(-1) + np.exp(-9), 1 + np.exp(-16) + np.exp(-9)]
    )


@settings(max_examples=30)
@given(
    data=arrays(float, (12, 2), elements=st.integers(-5, 5).map(float)),
    scale=st.sampled_from([2.0**-20, 8.0]),
    shift=st.integers(-3, 3),
)
def test_units_do_not_matter(data, scale, shift) -> None:
    data[0], data[1] = -5, 5
    ours, theirs = subtractive_clusters(data), subtractive_clusters(data * scale + shift * scale)
    assert ours.rows.tolist() == theirs.rows.tolist()
    assert theirs.sigma == pytest.approx(ours.sigma * scale, rel=1e-12)


def test_of_equally_dense_samples_the_first_is_taken() -> None:
    # Corners of a square, each twice: rounding differs between them, the density does not.
    corners = np.array([[0.1, 0.2], [0.7, 0.2], [0.1, 0.9], [0.7, 0.9]])
    found = subtractive_clusters(np.vstack([corners, corners]), 0.3)
    assert found.rows.tolist() == [0, 1, 2, 3]


def test_the_first_center_stands_whatever_the_ratios() -> None:
    data = np.random.default_rng(3).random((20, 2))
    found = subtractive_clusters(data, 0.5, options=ClusteringOptions(1.25, 2.0, 1.5))
    assert found.rows.tolist() == [int(np.argmax(densities(data, 0.5).density))]


def test_the_search_ends_at_most() -> None:
    data = np.random.default_rng(4).random((100, 2))
    found = densities(data, 0.2)
    everything = select_centers(found, ClusteringOptions())
    some = select_centers(found, ClusteringOptions(), most=3)
    assert len(everything.rows) > 3
    assert some.rows.tolist() == everything.rows[:3].tolist()


def test_a_constant_column_warns_and_takes_no_part() -> None:
    data = np.random.default_rng(5).random((40, 2))
    with pytest.warns(DataWarning, match=re.escape("column 3 (7)")):
        with_constant = subtractive_clusters(np.column_stack([data, np.full(40, 7.0)]))
    assert with_constant.rows.tolist() == subtractive_clusters(data).rows.tolist()
    assert with_constant.sigma[2] == pytest.approx(0.5 * 2 * 1e-4 * 8 / np.sqrt(8))


def test_one_sample_is_one_cluster() -> None:
    with pytest.warns(DataWarning, match="column 1"):
        found = subtractive_clusters([[3.0]])
    assert isinstance(found, Clusters)
    assert found.centers.tolist() == [[3.0]]


def test_extreme_radii() -> None:
    data = np.random.default_rng(6).random((50, 2))
    assert len(subtractive_clusters(data, 1e6).rows) == 1
    assert len(subtractive_clusters(data, 1e-6).rows) == 50
    assert len(subtractive_clusters(data, 1e-6, options=ClusteringOptions(1e-6)).rows) == 50


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ({"data": [1.0, 2.0]}, "must be (samples, columns)"),
        ({"data": np.zeros((0, 2))}, "at least 1"),
        ({"data": [["a", "b"]]}, "must be numbers"),
        ({"data": [[1.0, 2.0], [3.0]]}, "as many in every row"),
        ({"data": [[1.0, 2.0], [3.0, np.nan]]}, "row 2, column 2 is nan"),
        ({"data": [[np.inf, 2.0], [3.0, np.nan]]}, "row 1, column 1 is inf"),
        ({"radius": 1e-308}, "radius must be >= 1e-06"),
        ({"radius": 0.0}, "radius must be >= 1e-06 and <= 1e+06"),
        ({"radius": [0.5]}, "one for each of 2 columns"),
        ({"radius": [0.5, 0.5, 0.5]}, "one for each of 2 columns"),
        ({"radius": [0.5, np.nan]}, "radius must be >= 1e-06 and <= 1e+06"),
        ({"radius": "wide"}, "got 'wide'"),
        ({"ranges": [0, 1]}, "ranges must be (2, 2)"),
        ({"ranges": [[0, 1], [1, 0]]}, "lowest and the highest"),
        ({"weights": [1.0]}, "weights must be (3,)"),
        ({"weights": [0.0, 0.0, 0.0]}, "not all 0"),
        ({"weights": [1.0, -1.0, 0.0]}, ">= 0"),
    ],
)
def test_refusals_say_what_is_wrong(arguments, message) -> None:
    call = {"data": [[0.0, 0.0], [1.0, 1.0], [0.5, 0.2]], **arguments}
    with pytest.raises(ClusteringError, match=re.escape(message)):
        subtractive_clusters(**call)


@pytest.mark.parametrize(
    ("ratios", "message"),
    [
        ((0.0, 0.5, 0.15), "squash must be >= 1e-06"),
        ((-1.0, 0.5, 0.15), "squash must be a number >= 0 and <= 1e+06"),
        ((1.25, float("nan"), 0.15), "accept must be a number >= 0"),
        ((1.25, 0.5, 0.6), "reject (0.6) must not exceed accept (0.5)"),
        ((1.25, "a", 0.1), "got 'a'"),
    ],
)
def test_options_refuse(ratios, message) -> None:
    with pytest.raises(ClusteringError, match=re.escape(message)):
        ClusteringOptions(*ratios)
