"""How far outputs scatter at equal inputs: against known noise, and against many more samples of the literal set."""

import numpy as np
import pytest

from robotics.plugins.learning.formationdata import FormationRecipe, formation_data
from robotics.plugins.learning.scatter import ScatterError, scatter


def test_known_noise_is_found():
    rng = np.random.default_rng(1)
    x = rng.uniform(-1, [1, 2, 3], (3000, 3))
    f = np.stack([np.sin(2 * x[:, 0]) + x[:, 1] * x[:, 2], x[:, 0], np.cos(x[:, 1])], axis=1)
    noise = np.array([0.3, 0.1, 0.0])
    found = scatter(x, f + noise * rng.standard_normal(f.shape))
    np.testing.assert_allclose(found.rms[:2], noise[:2], rtol=0.15)
    assert (found.least[:2] < noise[:2]).all()
    assert (noise[:2] < found.most[:2]).all()
    assert found.least[2] == 0.0  # a smooth function without noise: 0 is within the range
    assert found.rms[2] < 0.05 * np.std(f[:, 2])


def test_units_columns_without_extent_and_the_seed():
    rng = np.random.default_rng(2)
    x, y = rng.random(800), rng.standard_normal((800, 1))
    once = scatter(x, y)
    for a, b in zip(once, scatter(np.stack([1e6 * x, np.full(800, 7.0)], axis=1), 1e-3 * y), strict=True):
        np.testing.assert_allclose(b, 1e-3 * a)
    np.testing.assert_array_equal(once.rms, scatter(x, y).rms)
    assert once.rms[0] != scatter(x, y, seed=1).rms[0]
    assert once.rms[0] == pytest.approx(1.0, rel=0.15)


def test_the_literal_set_scatters_and_the_well_posed_set_does_not():
    table = formation_data(FormationRecipe())
    found = scatter(table.values[:, :3], table.values[:, 3:])
    # 10 times as many samples of the same formations, about their mean over 5 mm of x_l: what equal inputs give
    many = formation_data(FormationRecipe(samples=4000)).values
    _, cell, count = np.unique(np.floor(many[:, 0] / 0.005), return_inverse=True, return_counts=True)
    mean = np.stack([np.bincount(cell, z) / count for z in many[:, 3:].T], axis=1)
    at_equal = np.sqrt(np.mean((many[:, 3:] - mean[cell]) ** 2, axis=0))
    assert (found.least <= at_equal + 1e-12).all()
    assert (at_equal <= found.most + 1e-12).all()
    np.testing.assert_allclose(found.rms, at_equal, rtol=0.2, atol=1e-12)
    # Table 5.1's errors are below the scatter, v_f's apart, which is constant
    assert (found.least[[0, 1, 3]] > [7.997e-3, 2.011e-3, 2.757e-3]).all()
    posed = formation_data(FormationRecipe(kind="well-posed"))
    assert (scatter(posed.values[:, :3], posed.values[:, 3:]).least == 0).all()


def test_too_few_samples_and_samples_of_different_lengths_are_refused():
    with pytest.raises(ScatterError, match=r"more than 10 samples in a part; 0\.25 of 40 are 10"):
        scatter(np.zeros(40), np.zeros(40))
    with pytest.raises(ScatterError, match="40 inputs and 41 outputs"):
        scatter(np.zeros(40), np.zeros(41))
