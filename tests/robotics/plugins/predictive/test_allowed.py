"""The best allowed command against every point of a fine grid, and against the conditions of optimality."""

import numpy as np
import pytest

from fuzzy.compiled.jit import kernel
from robotics.plugins.predictive.allowed import best_change, bound

HALF = 0.1
NORMALS = np.array([[1, 0], [0, 1], [1, HALF], [1, -HALF]])
TOPS = np.array([0.7, 5.0, 0.825, 0.825])
RATES = np.array([np.inf, 6.0, 0.2, 0.2])


@kernel
def _best(tops, rates, here, before, hessian, gradient):
    low, high = np.empty(4), np.empty(4)
    bound(low, high, tops, rates, HALF, here[0], here[1], before[0], before[1])
    found = best_change(low, high, HALF, hessian[0, 0], hessian[0, 1], hessian[1, 1], gradient[0], gradient[1])
    return low, high, found


def test_the_best_change_is_the_least_value_in_the_polygon():
    """It is allowed, and no allowed point of many is better; what it says it is at, it is at."""
    rng = np.random.default_rng(3)
    sides = np.zeros(3, int)
    for _ in range(400):
        before = rng.uniform([-0.6, -2.0], [0.6, 2.0])
        root = rng.normal(size=(2, 2)) * [[1.0, 0.2]]
        hessian, gradient = root @ root.T + 1e-3 * np.eye(2), rng.normal(size=2) * 10 ** rng.uniform(-2, 1)
        low, high, (v, w, first, second) = _best(TOPS, RATES, before, before, hessian, gradient)
        change = np.array([v, w])
        along = NORMALS @ change
        assert (along >= low - 1e-9).all()
        assert (along <= high + 1e-9).all()
        for side in (first, second):
            if side >= 0:
                assert along[side // 2] == pytest.approx((high if side % 2 else low)[side // 2], abs=1e-9)
        tried = rng.uniform([-0.3, -3.0], [0.3, 3.0], (4000, 2))
        off = tried @ NORMALS.T
        tried = tried[((off >= low) & (off <= high)).all(axis=1)]

        def value(at, h=hessian, g=gradient):
            return 0.5 * np.einsum("...i,ij,...j", at, h, at) + at @ g

        assert value(change) <= value(tried).min() + 1e-12
        # By small moves along the edges and inward, too, nothing is gained.
        for turn in np.linspace(0, 2 * np.pi, 24, endpoint=False):
            near = change + 1e-5 * np.array([np.cos(turn), np.sin(turn) / HALF])
            if ((NORMALS @ near >= low) & (NORMALS @ near <= high)).all():
                assert value(near) >= value(change) - 1e-12
        sides[(first >= 0) + (second >= 0)] += 1
    assert (sides > 30).all()  # inside, on edges and at corners


def test_bounds_are_the_narrower_of_limit_and_change():
    low, high, _ = _best(TOPS, RATES, np.array([0.1, 1.0]), np.array([0.0, 0.0]), np.eye(2), np.zeros(2))
    np.testing.assert_allclose(high + NORMALS @ [0.1, 1.0], [0.7, 5.0, 0.2, 0.2])
    np.testing.assert_allclose(low + NORMALS @ [0.1, 1.0], [-0.7, -5.0, -0.2, -0.2])
