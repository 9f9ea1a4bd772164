"""Plans that keep out of discs: what they pay against numpy, how it changes, and what robots drive into without."""

from dataclasses import replace
from functools import cache

import numpy as np
import pytest

from benchmarks.predictiveproblems import PERIOD, random_problems
from benchmarks.predictivesolving import plans_of, solve_rows
from fuzzy.compiled.jit import kernel
from robotics.laws.catalogue import as_law
from robotics.laws.equation import RobotColumns, gain_columns
from robotics.laws.law import ControllerError
from robotics.plugins.predictive.discs import DISCS, AroundColumns, keep
from robotics.plugins.predictive.ilqr import SolverColumns
from robotics.plugins.predictive.mppi import PathIntegral, SampledWork, _simulate
from robotics.plugins.stress.crossings import crossing_ensemble
from robotics.plugins.stress.disturbance import Disturbance
from robotics.plugins.stress.obstaclecourse import obstacle_ensemble
from robotics.plugins.stress.outcome import StressOutcome
from robotics.plugins.stress.tally import run_ensemble
from robotics.simulation.scenario.robots import load_robot

ETSRO = load_robot("etsro").robot
WEIGHT = 2500.0


def depths(discs, times, x, y):
    """How deep places (..., times) are in discs (..., times, discs) [m]."""
    at, speed, radius = np.array(discs)[:, :2], np.array(discs)[:, 2:4], np.array(discs)[:, 4]
    middle = at + np.asarray(times)[:, None, None] * speed
    away = np.hypot(x[..., None] - middle[..., 0], y[..., None] - middle[..., 1])
    return np.maximum(radius - away, 0.0)


def problems_with_discs(count, seed):
    """Two discs, one of which moves, beside the middle of each way."""
    rng, found = np.random.default_rng(seed), []
    for problem in random_problems(count, seed, ETSRO):
        middle = problem.to[len(problem.to) // 2, :2]
        discs = [(*(middle + rng.uniform(-0.15, 0.15, 2)), *v, 0.15) for v in ((0.0, 0.0), rng.uniform(-0.2, 0.2, 2))]
        found.append(replace(problem, discs=discs, disc_weight=WEIGHT))
    return found


def test_the_cost_of_a_plan_is_that_without_discs_and_half_the_weight_of_each_depth_squared():
    problems, paid = problems_with_discs(40, 3), 0
    with_discs = plans_of(problems, iterations=0)
    without = plans_of([replace(p, discs=()) for p in problems], iterations=0)
    for problem, states, cost, less in zip(problems, with_discs.states, with_discs.cost, without.cost, strict=True):
        times = PERIOD * np.arange(1, len(states))
        deep = depths(problem.discs, times, states[1:, 0], states[1:, 1])
        assert cost - less == pytest.approx(0.5 * WEIGHT * (deep**2).sum(), rel=1e-9, abs=1e-9 * less)
        paid += deep.any()
    assert paid >= 10


def test_the_best_plan_is_less_deep_and_its_cost_to_go_knows_how_it_changes():
    """By finite differences of the least cost, as without discs."""
    problems, ratios = problems_with_discs(40, 3), []
    blind, best = plans_of([replace(p, discs=()) for p in problems]), plans_of(problems)
    times = PERIOD * np.arange(1, best.states.shape[1])
    for problem, before, after, commands in zip(problems, blind.states, best.states, best.commands, strict=True):
        was, now = ((depths(problem.discs, times, s[1:, 0], s[1:, 1]) ** 2).sum() for s in (before, after))
        if not (was > 1e-3 and now > 1e-6):
            continue
        row = replace(problem, guess=commands).row[None]
        solve_rows(row, len(problem.to), 100, 1e-13)
        gradient = SolverColumns(row[0]).gradient
        step = 1e-6
        for n in range(2):
            states = [problem.state + sign * step * np.eye(5)[n] for sign in (-1, 1)]
            low, high = plans_of([replace(problem, guess=commands, state=s) for s in states], tolerance=1e-13).cost
            assert (high - low) / (2 * step) == pytest.approx(gradient[n], rel=0.01, abs=0.01 * abs(gradient).max())
        ratios.append(now / was)
    assert len(ratios) >= 5
    assert np.median(ratios) < 0.5


@kernel
def sampled(gains, steps, plan, ahead, led, noise, work):
    _simulate(steps, 0, 1.0, Gain(gains, 0), 1.0, plan, ahead, led, noise, SampledWork(work))


Gain = gain_columns(PathIntegral)


def test_a_sample_pays_for_each_step_in_a_disc():
    steps, step, speed, block = 12, 0.1, 0.4, 16
    discs = [(0.3, 0.05, 0.0, 0.0, 0.2), (0.8, -0.3, -0.3, 0.2, 0.25)]
    gain = Gain.zeros(1)
    gain.step, gain.v_max, gain.w_max, gain.follows, gain.w_std = step, 1.0, 3.0, 1.0, 0.5
    noise = np.random.default_rng(1).standard_normal((steps, 2, block))
    plan = np.concatenate([np.full(steps, speed), np.zeros(steps)])
    work = SampledWork(np.zeros(SampledWork.size))
    work.cos[:] = 1.0
    work.around.count, work.around.weight = 2, 7.0
    work.around.discs[:10] = np.ravel(discs)
    sampled(gain.array, steps, plan, np.zeros(4 * steps), plan.copy(), noise.ravel(), work.array)
    w = np.clip(0.5 * noise[:, 1], -3, 3)
    heading = np.cumsum(step * w, axis=0)
    chord, middle = speed * step * np.sinc(w * step / 2 / np.pi), heading - step * w / 2
    x, y = np.cumsum(chord * np.cos(middle), axis=0), np.cumsum(chord * np.sin(middle), axis=0)
    deep = depths(discs, step * np.arange(1, steps + 1), x.T, y.T)  # (samples, steps, discs)
    share = 1 - (1 - deep / np.array([0.2, 0.25])) ** 2
    np.testing.assert_allclose(work.cost, 7.0 * share.sum(axis=(1, 2)), rtol=1e-9)
    assert work.cost.max() > 1.1 * work.cost.min()


@kernel
def kept(around, robot, discs):
    for k in range(len(discs)):
        keep(AroundColumns(around), RobotColumns(robot), discs[k, 0], discs[k, 1], 0.0, 0.0, discs[k, 2])


def test_the_nearest_discs_are_kept():
    rng = np.random.default_rng(4)
    robot, discs = np.zeros(RobotColumns.size), rng.uniform([-2, -2, 0.05], [2, 2, 0.3], (40, 3))
    around = AroundColumns(np.zeros(AroundColumns.size))
    kept(around.array, robot, discs)
    nearest = np.argsort(np.hypot(discs[:, 0], discs[:, 1]) - discs[:, 2])[:DISCS]
    rows = around.discs.reshape(-1, 5)
    assert {tuple(row) for row in rows[:, [0, 1, 4]]} == {tuple(row) for row in discs[nearest]}


@cache
def driven(law, kind):
    seeds = range(12)
    if kind == "obstacles":
        ensemble = obstacle_ensemble(seeds, "A", 1)
    else:
        ensemble = crossing_ensemble(3, seeds, disturbance=Disturbance(latency=0.1, loss=float(kind == "deaf")))
    return run_ensemble(StressOutcome, ensemble, as_law(law), seeds)


def contacts(*about):
    return driven(*about).caused.any(axis=1).sum()


@pytest.mark.long
def test_it_is_the_discs_that_keep_robots_apart_that_hear_each_other():
    assert contacts("nmpc-discs", "crossing") == 0
    assert driven("nmpc-discs", "crossing").arrived.all()
    assert contacts("nmpc-discs:disc_scale=10", "crossing") >= 6
    assert contacts("nmpc-discs", "deaf") >= 6


@pytest.mark.long
@pytest.mark.parametrize(
    ("law", "without"),
    [("nmpc-discs:clears=0.001", "disc_scale=10"), ("mppi-ranges", "disc=1e-6")],
    ids=["nmpc", "mppi"],
)
def test_it_is_the_discs_that_keep_them_from_what_they_see(law, without):
    assert contacts(law, "obstacles") == 0
    assert contacts(f"{law},{without}" if ":" in law else f"{law}:{without}", "obstacles") >= 2


def test_numbers_out_of_range_are_said():
    with pytest.raises(ControllerError, match="disc_scale must be"):
        as_law("nmpc-discs:disc_scale=0")
    with pytest.raises(ControllerError, match="samples must be"):
        as_law("mppi-ranges:samples=1")
