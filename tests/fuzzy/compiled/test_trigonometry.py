"""The sine and cosine that vectorise, beside those of the mathematics library."""

import math

import numpy as np
import pytest

from fuzzy.compiled.jit import kernel
from fuzzy.compiled.trigonometry import sincos


@kernel
def many(angles, sines, cosines):
    for i in range(len(angles)):
        sines[i], cosines[i] = sincos(angles[i])


def both(angles):
    sines, cosines = np.empty_like(angles), np.empty_like(angles)
    many(angles, sines, cosines)
    return sines, cosines


@pytest.mark.parametrize("reach", [1e-8, 1.0, 10.0, 1e3, 1e6])
def test_sine_and_cosine_are_those_of_the_library_within_2_ulp(reach):
    rng = np.random.default_rng(0)
    angles = np.concatenate([rng.uniform(-reach, reach, 20_000), np.arange(-100, 101) * (np.pi / 4) * reach / 100])
    sines, cosines = both(angles)
    for found, function in ((sines, math.sin), (cosines, math.cos)):
        true = np.array([function(angle) for angle in angles])
        assert (np.abs(found - true) <= 2 * np.spacing(np.abs(true))).all()


def test_in_a_vector_it_is_the_same_to_the_last_bit_as_alone():
    angles = np.random.default_rng(1).uniform(-50, 50, 37)
    together = both(angles)
    alone = [both(angles[i : i + 1]) for i in range(len(angles))]
    assert all(np.concatenate([a[k] for a in alone]).tobytes() == together[k].tobytes() for k in (0, 1))


def test_what_is_no_angle_gives_nan_and_zero_is_exact():
    assert np.isnan(both(np.array([np.nan, np.inf, -np.inf]))).all()
    assert [x.tolist() for x in both(np.zeros(1))] == [[0.0], [1.0]]
