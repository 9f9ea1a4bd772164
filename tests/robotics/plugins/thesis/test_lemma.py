"""Lemma 4.1 against closed forms, and against scipy's search for errors that break a bound."""

import math

import numpy as np
import pytest
from scipy.optimize import minimize

from robotics.laws.tracking.lyapunov import Lyapunov
from robotics.plugins.certificates.certificate import error_rates
from robotics.plugins.thesis.lemma import judge_lemma


def value(e, ky):
    return (e[0] ** 2 + e[1] ** 2) / 2 + (1 - math.cos(e[2])) / ky  # (4.8)


def judged(**gains):
    return {c.name: c for c in judge_lemma(Lyapunov(catch_up=0.0, **gains))}


@pytest.mark.parametrize("ky", [0.2, 0.8, 1.0, 10.0])
def test_condition_1_with_the_corrected_constants_only(ky):
    found = judged(ky=ky)
    low, high = found["1 lower"], found["1 upper"]
    assert low.corrected == pytest.approx(min(0.5, 0.405284734569351 / ky))
    assert high.corrected == pytest.approx(max(0.5, 1 / (2 * ky)))
    assert low.corrected_holds
    assert high.corrected_holds
    assert low.worst == pytest.approx(low.corrected)  # sharp: it is met at x = y = 0, ψ = ±π/2
    assert high.worst == pytest.approx(high.corrected, rel=1e-3)  # met only as ψ goes to 0
    assert low.holds == (ky <= 4 / math.pi**2 * 2)  # the printed one is false at K_y = 1
    assert high.holds
    for condition in (low, high):
        assert value(condition.at, ky) / np.square(condition.at).sum() == pytest.approx(condition.worst)
    # No error of the region breaks the corrected bounds: a search that knows no grid.
    rng = np.random.default_rng(1)
    bounds = [(-1, 1), (-1, 1), (-math.pi / 2, math.pi / 2)]
    for sign, limit in ((1, low.corrected), (-1, high.corrected)):
        for start in rng.uniform(-1, 1, (5, 3)):
            best = minimize(lambda e, s=sign: s * value(e, ky) / np.square(e).sum(), start, bounds=bounds).fun
            assert best >= sign * limit - 1e-9


def test_condition_2_holds():
    for ky, sharp in ((0.5, 2.0), (1.0, 1.0), (10.0, 1.0)):
        condition = judged(ky=ky)["2"]
        assert condition.holds
        assert condition.corrected_holds
        assert condition.printed == pytest.approx(math.sqrt(2 + 1 / ky**2))
        assert condition.corrected == sharp
        assert condition.worst == pytest.approx(sharp, rel=1e-2)


def test_condition_3_has_no_constant():
    """V' at (0, y, 0) is 0 while the error is not: by the law itself, not by (4.9)."""
    law = Lyapunov(ky=1.0, kpsi=1.0, catch_up=0.0)
    condition = {c.name: c for c in judge_lemma(law)}["3"]
    assert condition.worst == 0.0
    assert condition.corrected is None
    assert not condition.holds
    assert not condition.corrected_holds
    x, y, psi = condition.at
    assert (x, psi) == (0.0, 0.0)
    assert y != 0.0
    rates = error_rates(law, np.array([condition.at]), np.array([0.1]), np.array([0.05]))[0]
    assert rates @ [x, y, math.sin(psi)] == pytest.approx(0.0, abs=1e-15)


def test_condition_4_has_no_constant_for_g_is_not_0_where_the_error_is():
    coarse, fine = ({c.name: c for c in judge_lemma(points=n)}["4"] for n in (11, 101))
    assert not coarse.holds
    assert not fine.holds
    assert coarse.corrected is None
    assert fine.worst == pytest.approx(10 * coarse.worst)  # without a bound: the finer the grid, the larger
    smallest = np.linalg.norm(fine.at)
    assert fine.worst * smallest == pytest.approx(math.hypot(7.0, 3.0))
    product = {c.name: c for c in judge_lemma(points=41)}["4Λ"]
    assert not product.holds  # printed max{7, 3}
    assert product.printed == 7.0
    assert product.corrected == pytest.approx(math.sqrt(58.0))
    assert product.corrected_holds
    assert product.worst == pytest.approx(math.sqrt(58.0), rel=0.01)


def test_a_grid_without_0_is_refused():
    with pytest.raises(ValueError, match="points must be odd"):
        judge_lemma(points=10)
