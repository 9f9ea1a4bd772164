"""The ends of type-reduced sets against every choice of bounds, and against the published iterations."""

from itertools import product

import numpy as np
import pytest
from hypothesis import example, given
from hypothesis import strategies as st

import fuzzy
from fuzzy.plugins.type2.system import reduced
from tests.fuzzy.plugins.type2.drawn import bounds, drawn


def by_every_choice(z: np.ndarray, least: np.ndarray, most: np.ndarray) -> tuple[float, float]:
    """The definition: the extremes of the weighted average over all 2^n choices of a bound for each rule."""
    choice = np.array(list(product((False, True), repeat=len(z))))
    weights = np.where(choice, most, least)
    total = weights.sum(axis=1)
    averages = (weights * z).sum(axis=1)[total > 0] / total[total > 0]
    return averages.min(), averages.max()


@pytest.mark.parametrize("count", [60, pytest.param(500, marks=pytest.mark.long)])
def test_systems_equal_the_extremes_over_every_choice_of_bounds(count):
    rng = np.random.default_rng(40)
    fired = 0
    for _ in range(count):
        fis = drawn(rng)
        x = rng.uniform(0, 10, 2)
        least, most, z = bounds(fis, x)
        if most.max() == 0:
            continue
        fired += 1
        found = fuzzy.infer_type2(fis, x)
        assert found.lower == pytest.approx(least, rel=1e-12, abs=1e-15)
        assert found.upper == pytest.approx(most, rel=1e-12, abs=1e-15)
        # Of the same strengths: one that is a small difference (degree - lag) has fewer true digits
        low, high = by_every_choice(z, found.lower, found.upper)
        assert float(found.low[0]) == pytest.approx(low, rel=1e-12, abs=1e-12)
        assert float(found.high[0]) == pytest.approx(high, rel=1e-12, abs=1e-12)
        assert float(found.output[0]) == pytest.approx((low + high) / 2, rel=1e-12, abs=1e-12)
    assert fired > 0.7 * count


def ends_by(step, z: np.ndarray, least: np.ndarray, most: np.ndarray) -> tuple[float, float]:
    """Both ends by a ``step`` for the left one, of proposals in order: the right one is that of -z."""
    order = np.argsort(z)
    left = step(z[order], least[order], most[order])
    return left, -step(-z[order[::-1]], least[order[::-1]], most[order[::-1]])


def karnik_mendel(z, least, most, k=None):
    """The switch point by alternation [Wu & Mendel 2009, table I]; EKM begins at n / 2.4."""
    weights = (least + most) / 2 if k is None else np.r_[most[:k], least[k:]]
    y = np.average(z, weights=weights)
    while True:
        k = int(np.searchsorted(z, y, side="right"))
        new = np.average(z, weights=np.r_[most[:k], least[k:]])
        if new >= y:
            return min(new, y)
        y = new


def enhanced(z, least, most):
    return karnik_mendel(z, least, most, max(round(len(z) / 2.4), 1))


def iasc(z, least, most):
    """From the lower weights on, one after the other raised, until the average grows [Duran et al. 2008]."""
    a, b = (least * z).sum(), least.sum()
    y = a / b
    for each, low, high in zip(z, least, most, strict=True):
        a, b = a + each * (high - low), b + high - low
        if a / b > y:
            return y
        y = a / b
    return y


def eiasc(z, least, most):
    """The same, until the next proposal is beyond the average [Wu & Nie 2011]."""
    a, b = (least * z).sum(), least.sum()
    y = z[-1]
    for k, (each, low, high) in enumerate(zip(z, least, most, strict=True)):
        a, b = a + each * (high - low), b + high - low
        y = a / b
        if k + 1 < len(z) and y <= z[k + 1]:
            return y
    return y


@pytest.mark.parametrize("step", [karnik_mendel, enhanced, iasc, eiasc])
def test_the_four_ways_of_matlab_find_the_ends_that_are_computed(step):
    rng = np.random.default_rng(7)
    for _ in range(100):
        count = rng.integers(1, 12)
        z = rng.uniform(-3, 3, count)
        least, most = np.sort(rng.uniform(0.01, 1, (2, count)), axis=0)
        low, high = reduced(z, least, most, "karnikmendel")
        assert (float(low), float(high)) == pytest.approx(ends_by(step, z, least, most), rel=1e-12, abs=1e-12)


WEIGHTS = st.floats(0, 1) | st.just(0.0)
RULES = st.lists(st.tuples(st.floats(-100, 100), WEIGHTS, WEIGHTS), min_size=1, max_size=9)


@given(RULES)
@example([(0.0, 0.0, 1.0), (-1.5, 0.0, 5e-324)])  # a product with the least number has no digits
@example([(0.0, 1.0, 0.0), (1.5, 0.0, 5e-324)])
def test_the_ends_hold_every_average_and_lie_among_the_proposals(rules):
    z, one, other = np.array(rules).T
    least, most = np.minimum(one, other), np.maximum(one, other)
    if most.max() < 1e-9:
        return
    low, high = (float(end) for end in reduced(z, least, most, "eiasc"))
    middle = float(reduced(z, least, most, "nietan")[0])
    assert low <= middle <= high
    slack = 1e-12 * np.abs(z).max()
    assert z[most > 0].min() - slack <= low
    assert high <= z[most > 0].max() + slack
    assert middle == pytest.approx(((least + most) * z).sum() / (least + most).sum(), rel=1e-9, abs=1e-9)
