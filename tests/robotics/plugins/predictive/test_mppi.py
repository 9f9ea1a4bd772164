"""MPPI: its plan against one by numpy and scipy, what it may depend on, and its runs."""

from dataclasses import replace
from math import pi

import numpy as np
import pytest
from scipy.signal import savgol_coeffs

from robotics.laws.catalogue import make_controller
from robotics.laws.law import Observation
from robotics.measures.tracking import METRICS, tracking_error
from robotics.plugins.predictive.mppi import STRIDE, PathIntegral, perturbations
from robotics.simulation.loop import simulate
from robotics.simulation.scenario.reading import load_scenario, parse_scenario
from tests.robotics.laws.tracking.courses import from_random_starts

SETTING = load_scenario("lyapunov-circle").setting  # of one robot
QUICK = PathIntegral(samples=250)


class Oracle:
    """The same by arrays: all samples at once, arcs by their chords, the filter's coefficients by scipy."""

    def __init__(self, law):
        self.law, self.past = law, np.zeros((2, 4))
        self.added = np.zeros((2, law.steps))
        bank = perturbations(law.seed, law.samples, law.steps)
        rows = bank.transpose(2, 1, 0, 3).reshape(2, law.steps, -1)[:, :, : law.samples // 2]
        self.noise = np.concatenate([rows, -rows], axis=2)  # (2, steps, samples)

    def plan(self, time, pose, speeds, period=0.05):
        """The smoothed plan (2, steps) at a time, and with it the command."""
        law, robot = self.law, SETTING.robots[0]
        times = time + law.step * np.arange(law.steps + 1)
        at = [SETTING.references.at(t) for t in times]
        x_d, y_d, heading_d, v_d, w_d = (np.array([a[k][0] for a in at]) for k in range(5))
        meanwhile = np.array([(v_d[1:] + v_d[:-1]) / 2, (w_d[1:] + w_d[:-1]) / 2]) * (law.feed_forward == "full")
        places = np.minimum(np.arange(law.steps) + period / law.step, law.steps - 1)
        added = np.array([np.interp(places, np.arange(law.steps), row) for row in self.added])
        plan = meanwhile + added
        bounds = np.array([robot.v_max, min(robot.w_max, 1 / law.step)])[:, None, None]
        std = np.array([law.v_std, law.w_std])[:, None, None]
        noise = np.roll(self.noise, -(round(time / period) * STRIDE), axis=1)
        tried = np.clip(plan[:, :, None] + std * noise, -bounds, bounds)
        cost = law.gamma * (added[:, :, None] * (tried - plan[:, :, None]) / std**2).sum(axis=(0, 1))
        x, y, heading = (np.full(law.samples, value) for value in pose)
        v, w = speeds
        follows = 1 - np.exp(-law.step / law.lag) if law.lag else 1.0
        for t in range(law.steps):
            v, w = v + follows * (tried[0, t] - v), w + follows * (tried[1, t] - w)
            chord, middle = v * law.step * np.sinc(w * law.step / 2 / pi), heading + w * law.step / 2
            x, y, heading = x + chord * np.cos(middle), y + chord * np.sin(middle), heading + w * law.step
            dx, dy, turn = x_d[t + 1] - x, y_d[t + 1] - y, heading_d[t + 1]
            cost += ((np.cos(turn) * dx + np.sin(turn) * dy) / law.x_scale) ** 2
            cost += ((np.cos(turn) * dy - np.sin(turn) * dx) / law.y_scale) ** 2
            cost += 4 * np.sin((heading - turn) / 2) ** 2 / law.heading_scale**2
        weight = np.exp((cost.min() - cost) / law.temperature)
        added = tried @ weight / weight.sum() - meanwhile
        if law.smoothing != "none":
            padded = np.concatenate([self.past, added, np.repeat(added[:, -1:], 4, axis=1)], axis=1)
            added = np.array([np.convolve(row, savgol_coeffs(9, 2), "valid") for row in padded])
        self.added = added
        self.past = np.concatenate([self.past[:, 1:], added[:, law.sent : law.sent + 1]], axis=1)
        return np.clip(meanwhile[:, law.sent] + added[:, law.sent], -bounds[:, 0, 0], bounds[:, 0, 0])


@pytest.mark.parametrize(
    "law",
    [
        PathIntegral(samples=250),  # 125 pairs: the last block of samples is not full
        PathIntegral(samples=64, lag=0.1, sent=0, seed=4),
        PathIntegral(samples=100, steps=20, step=0.08, smoothing="none", temperature=5.0, gamma=0.2),
        PathIntegral(samples=96, steps=11, feed_forward="none", sent=2, w_std=6.0, v_std=1.0, temperature=30.0),
    ],
    ids=["default", "lag", "longer-steps", "without-feed-forward-at-the-bounds"],
)
def test_commands_are_those_of_the_printed_formulas(law):
    oracle, memory, one = Oracle(law), law.init(SETTING, 1), np.ones((1, 1))
    rng = np.random.default_rng(5)
    for k in range(60, 66):
        time = 0.05 * k
        at = SETTING.references.at(time)
        pose = np.array([at.x[0], at.y[0], at.heading[0]]) + rng.normal(0, 0.05, 3)
        speeds = rng.uniform(0, 0.4), rng.uniform(-1, 1)
        x, y, heading, v, w = (one * value for value in (*pose, *speeds))
        seen = Observation(time, x, y, heading, v, w, at, SETTING.references)
        command, memory = law.control(seen, memory, 0.05)
        found = command.first[0, 0], command.second[0, 0]
        np.testing.assert_allclose(found, oracle.plan(time, pose, speeds), rtol=0, atol=1e-10)


def test_the_noise_is_a_seeds_and_its_pairs_have_no_mean():
    bank = perturbations(3, 1000, 56)
    np.testing.assert_array_equal(bank, perturbations.__wrapped__(3, 1000, 56))
    assert abs(bank.std() - 1) < 0.01
    assert not np.array_equal(bank, perturbations(4, 1000, 56))
    # On a straight path, where nothing tells left from right, every sample has its mirror image but for v's sign
    line = parse_scenario(LINE, "line")
    one, zero, at = np.ones((1, 1)), np.zeros((1, 1)), line.setting.references.at(3.0)
    only = replace(QUICK, v_std=1e-9)
    seen = Observation(3.0, one * at.x, zero, zero, 0.3 * one, zero, at, line.setting.references)
    command, _ = only.control(seen, only.init(line.setting, 1), 0.05)
    assert command.second[0, 0] == pytest.approx(0.0, abs=1e-7)


def test_a_run_does_not_depend_on_its_neighbours_and_differs_by_the_seed_of_the_noise():
    scenario = replace(load_scenario("lyapunov-sine"), duration=2.0)
    law = replace(QUICK, samples=64)
    together = simulate(scenario, law, range(4))
    alone = simulate(scenario, law, (2,))
    assert together.only(2).samples.tobytes() == alone.samples.tobytes()
    other = simulate(scenario, replace(law, seed=1), (2,))
    assert np.abs(other["w_demand"] - alone["w_demand"]).max() > 1e-3


@pytest.mark.parametrize(
    ("scenario", "within"), [("lyapunov-sine", 3.5), ("lyapunov-circle", 2.5), ("fuzzy-off-path", 4.0)]
)
def test_it_tracks_with_noise_from_off_the_path(scenario, within):
    """With half of its samples, which costs half a millimetre."""
    run = simulate(replace(load_scenario(scenario), latency=0.03), replace(QUICK, samples=500), range(3))
    assert METRICS["settling_time_s"].measure(run).max() < within
    assert METRICS["rms_cross_track_under_way_m"].measure(run).max() < 0.004
    assert METRICS["w_variation_radps2"].measure(run).max() < 1.0
    e = tracking_error(run)
    assert np.hypot(e.x, e.y)[..., -1].max() < 0.015


LINE = """
duration = 12.0
[sensing]
posture = "pose"
position_noise = 0.003
heading_noise = 0.003
[[robots]]
start = [0.0, 0.0, 0.0]
path = { shape = "line", start = [0.0, 0.0], end = [2.4, 0.0] }
timing = { speed = 0.3 }
"""


def test_at_the_end_it_rests():
    run = simulate(parse_scenario(LINE, "line"), QUICK, range(4))
    assert np.abs(run["v"][..., -20:]).max() < 0.05
    assert np.abs(run["x"][..., -1] - 2.4).max() < 0.02
    assert np.abs(run["y"][..., -1]).max() < 0.01


def test_random_starts_converge():
    scenario = from_random_starts("lyapunov-sine", (-1.5, -1.5, -pi), (1.5, 1.5, pi), 25, duration=12.0)
    run = simulate(scenario, QUICK)
    assert METRICS["settling_time_s"].measure(run).max() < 9.0


def test_it_says_what_it_knows():
    assert make_controller("mppi").knows == ("reference", "reference velocity", "preview")
    assert make_controller("mppi:lag=0.1").knows[3:] == ("wheel speeds", "wheel lag")
