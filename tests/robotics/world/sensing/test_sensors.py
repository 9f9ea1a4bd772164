"""Posture sensors: the variances and drifts that follow from the scenario by closed form."""

from dataclasses import dataclass, field, replace
from math import pi

import numpy as np
import pytest

from robotics.laws.law import Command, Law
from robotics.simulation.loop import simulate
from robotics.simulation.run import CHANNELS
from robotics.simulation.scenario.description import Member, Scenario
from robotics.world.paths.path import Circle, Line
from robotics.world.paths.trajectory import Timing
from robotics.world.sensing.posture import Sensing, SensingError, wheel_errors
from tests.robotics.world.vehicle.etsro import ETSRO

FINE = replace(ETSRO, counts_per_turn=1e9)  # encoders without steps, so that closed forms hold
LINE = Member(start=(2.0, -3.0, 0.0), path=Line(start=(2.0, -3.0), end=(9.0, -3.0)), timing=Timing(speed=0.3))


@dataclass(frozen=True)
class Scripted(Law[None]):
    """Commands v and ω, whatever the robots see, and keeps what they saw."""

    v: float = 0.0
    w: float = 0.0
    seen: list = field(default_factory=list)

    def init(self, setting, runs):
        return None

    def control(self, seen, memory, dt):
        self.seen.append(seen)
        v, w = np.full_like(seen.x, self.v), np.full_like(seen.x, self.w)
        return Command(v, w, v, w), None


def scene(*members, duration=10.0, sensing=None, **settings):
    robots = tuple(replace(member, robot=FINE) for member in members)
    return Scenario(
        name="s", robots=robots, duration=duration, divergence=1e9, sensing=sensing or Sensing(), **settings
    )


def pose(**settings):
    return Sensing(posture="pose", **settings)


def noise_of(run, name="x"):
    return run[f"{name}_measured"] - run[name]


# Noise ----------------------------------------------------------------------------------------------------------


def test_relative_noise_is_a_share_of_each_coordinate():
    """At rest at (2, −3): standard deviations of 10 % of 2 m and of 3 m, none of the heading, all independent."""
    run = simulate(scene(LINE, sensing=pose(relative_noise=0.1)), Scripted(), range(50))
    x, y = noise_of(run, "x") / 0.2, noise_of(run, "y") / 0.3
    n = x.size
    for unit in (x, y):
        assert abs(unit.mean()) < 4 / np.sqrt(n)
        assert unit.std() == pytest.approx(1, abs=4 / np.sqrt(2 * n))
        assert (unit**4).mean() == pytest.approx(3, abs=4 * np.sqrt(96 / n))  # Gaussian
        assert abs((unit[..., 1:] * unit[..., :-1]).mean()) < 4 / np.sqrt(n)  # white
    assert abs((x * y).mean()) < 4 / np.sqrt(n)
    assert (noise_of(run, "heading") == 0).all()


def test_relative_noise_grows_with_the_coordinate():
    """Thesis 4.5: x (1 + 0.1 n). Driving along x the noise over x is white, and at y = 0 there is none in y."""
    start = replace(LINE, start=(0.5, 0.0, 0.0))
    run = simulate(scene(start, duration=20.0, sensing=pose(relative_noise=0.1)), Scripted(v=0.3), range(100))
    share = noise_of(run) / run["x"]
    for part in np.array_split(share, 8, axis=-1):
        assert part.std() == pytest.approx(0.1, rel=4.5 / np.sqrt(2 * part.size))
    assert run["x"].max() > 5
    assert np.abs(noise_of(run, "y")).max() < 1e-6


def test_relative_and_absolute_noise_add_up():
    both = pose(relative_noise=0.1, position_noise=0.3, heading_noise=0.05)
    run = simulate(scene(LINE, sensing=both), Scripted(), range(50))
    n = noise_of(run).size
    for name, sigma in (("x", np.hypot(0.2, 0.3)), ("y", np.hypot(0.3, 0.3)), ("heading", 0.05)):
        assert noise_of(run, name).std() == pytest.approx(sigma, rel=4 / np.sqrt(2 * n))


def test_one_kind_of_noise_does_not_shift_the_other():
    quiet = simulate(scene(LINE, sensing=pose(position_noise=0.1)), Scripted(), (3,))
    shares = simulate(scene(LINE, sensing=pose(relative_noise=0.1)), Scripted(), (3,))
    both = simulate(scene(LINE, sensing=pose(relative_noise=0.1, position_noise=0.1)), Scripted(), (3,))
    for name in ("x", "y"):
        sum_of = noise_of(quiet, name) + noise_of(shares, name)
        np.testing.assert_allclose(noise_of(both, name), sum_of, rtol=0, atol=1e-14)


@pytest.mark.parametrize("kind", [{"relative_noise": 0.1}, {"position_noise": 0.1}])
@pytest.mark.parametrize("period", [0.05, 0.03, 0.07])
def test_noise_acts_within_its_window_only_and_does_not_depend_on_it(kind, period):
    whole = simulate(scene(LINE, sensing=pose(**kind), duration=4.2, period=period), Scripted(), (1,))
    window = pose(noise_start=round(30 * period, 2), noise_end=round(50 * period, 2), **kind)
    part = simulate(scene(LINE, sensing=window, duration=4.2, period=period), Scripted(), (1,))
    inside = np.zeros(len(part.time), dtype=bool)
    inside[30:50] = True
    assert (noise_of(part)[..., ~inside] == 0).all()
    np.testing.assert_array_equal(noise_of(part)[..., inside], noise_of(whole)[..., inside])
    assert (noise_of(whole) != 0).all()


def test_a_window_ends_for_one_robot_and_not_for_the_other():
    short, long = (replace(LINE, sensing=pose(position_noise=0.1, noise_end=end)) for end in (1.0, 2.0))
    run = simulate(scene(short, long, duration=3.0), Scripted(), (1,))
    active = noise_of(run)[0] != 0
    np.testing.assert_array_equal(active, [run.time < 1 - 1e-9, run.time < 2 - 1e-9])


def test_each_robot_senses_in_its_own_way():
    noisy = replace(LINE, sensing=pose(position_noise=0.1))
    drifting = replace(LINE, sensing=Sensing(wheel_error=0.05))
    run = simulate(scene(noisy, drifting, LINE, sensing=pose()), Scripted(v=0.3), range(20))
    assert noise_of(run)[:, 0].std() == pytest.approx(0.1, rel=0.1)
    assert (noise_of(run)[:, 2] == 0).all()
    drift = np.hypot(noise_of(run, "x"), noise_of(run, "y"))[:, 1]
    assert (drift[:, 0] == 0).all()
    assert drift[:, -1].mean() > 0.05
    # The noise of a robot does not depend on what its neighbours measure with
    other = simulate(scene(noisy, LINE, noisy, sensing=pose()), Scripted(v=0.3), range(20))
    np.testing.assert_array_equal(noise_of(run)[:, 0], noise_of(other)[:, 0])


def test_each_robot_starts_off_by_its_own_spread():
    off = replace(LINE, sensing=pose(start_position=0.05, start_heading=0.1))
    run = simulate(scene(off, LINE, duration=0.05), Scripted(), range(2000))
    for name, at, sigma in (("x", 2.0, 0.05), ("y", -3.0, 0.05), ("heading", 0.0, 0.1)):
        gap = run[name][:, :, 0] - at
        assert gap[:, 0].std() == pytest.approx(sigma, rel=0.07)
        assert (gap[:, 1] == 0).all()


# Filter ---------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("gain", [0.03, 0.3, 0.9])
def test_the_filter_at_rest_has_its_closed_form_variance_and_memory(gain):
    """e' = (1 − g) e + g n: the variance g/(2 − g) σ² in the steady state, with the correlation 1 − g."""
    sensing = pose(position_noise=0.2, heading_noise=0.1, filter_gain=gain)
    run = simulate(scene(LINE, sensing=sensing, duration=40.0), Scripted(), range(60))
    settled = slice(int(8 / gain) if gain > 0.1 else 300, None)
    for name, sigma in (("x", 0.2), ("y", 0.2), ("heading", 0.1)):
        e = noise_of(run, name)[..., settled]
        expected = sigma * np.sqrt(gain / (2 - gain))
        independent = e.size * gain / (2 - gain)
        assert e.std() == pytest.approx(expected, rel=4.5 / np.sqrt(2 * independent))
        correlation = (e[..., 1:] * e[..., :-1]).mean() / (e**2).mean()
        assert correlation == pytest.approx(1 - gain, abs=4.5 / np.sqrt(independent))


def test_the_filter_takes_the_recursion_that_it_says():
    """By hand from the raw measurements (gain 1) of the same seed: m' = (1 − g) (m + odometry) + g raw."""
    raw = simulate(scene(LINE, sensing=pose(position_noise=0.1), duration=5.0), Scripted(v=0.3), (2,))
    smooth = simulate(
        scene(LINE, sensing=pose(position_noise=0.1, filter_gain=0.2), duration=5.0), Scripted(v=0.3), (2,)
    )
    m = raw["x_measured"][0, 0, 0]
    for k in range(1, len(raw.time)):
        step = raw["x"][0, 0, k] - raw["x"][0, 0, k - 1]  # fine encoders tell it exactly on a straight line
        m = 0.8 * (m + step) + 0.2 * raw["x_measured"][0, 0, k]
        assert smooth["x_measured"][0, 0, k] == pytest.approx(m, abs=1e-6)


def test_the_filter_follows_a_moving_robot_without_lag():
    """The prediction carries it along: without noise a curve is followed to the error of the arcs."""
    sensing = pose(filter_gain=0.05)
    run = simulate(scene(LINE, sensing=sensing, duration=10.0), Scripted(v=0.4, w=1.0))
    gap = np.hypot(noise_of(run, "x"), noise_of(run, "y"))
    assert gap.max() < 2e-3
    assert np.abs(np.diff(run["x"])).max() > 0.01


def test_a_filter_forgets_a_wrong_start_geometrically():
    """Noise that ends at 0.1 s leaves an error that shrinks by 1 − g a period."""
    sensing = pose(position_noise=0.5, noise_end=0.05, filter_gain=0.1)
    run = simulate(scene(LINE, sensing=sensing, duration=3.0), Scripted(), (1,))
    e = noise_of(run)[0, 0]
    assert abs(e[0]) > 0.01
    np.testing.assert_allclose(e, e[0] * 0.9 ** np.arange(len(e)), rtol=0, atol=1e-9)


def test_a_filter_on_one_robot_leaves_the_others_as_they_are():
    filtered = replace(LINE, sensing=pose(position_noise=0.1, filter_gain=0.1))
    run = simulate(scene(LINE, filtered, sensing=pose()), Scripted(v=0.3, w=0.7), (1,))
    for name in ("x", "y", "heading"):
        assert (noise_of(run, name)[:, 0] == 0).all()


# Odometry -------------------------------------------------------------------------------------------------------


def test_encoders_that_are_exact_make_odometry_exact():
    run = simulate(scene(LINE, duration=20.0), Scripted(v=0.3, w=0.8))
    for name in ("x", "y", "heading"):
        assert np.abs(noise_of(run, name)).max() < 1e-5


def errors_of(scenario, seeds):
    """The drawn wheel and axle shares (3, runs, robots)."""
    return wheel_errors([m.sensing or scenario.sensing for m in scenario.robots], seeds).reshape(
        3, len(seeds), len(scenario.robots)
    )


def test_wheel_and_axle_errors_have_the_spread_that_they_are_given():
    sensing = Sensing(wheel_error=0.01, axle_error=0.05)
    right, left, axle = errors_of(scene(LINE, LINE, sensing=sensing), range(1000))
    for share, sigma in ((right, 0.01), (left, 0.01), (axle, 0.05)):
        assert share.std() == pytest.approx(sigma, rel=4 / np.sqrt(2 * share.size))
        assert abs(share.mean() - 1) < 4 * sigma / np.sqrt(share.size)
    for a, b in ((right, left), (right, axle), (left, axle)):
        assert abs(np.corrcoef(a.ravel(), b.ravel())[0, 1]) < 4 / np.sqrt(right.size)
    assert abs(np.corrcoef(right[:, 0], right[:, 1])[0, 1]) < 4 / np.sqrt(1000)
    assert wheel_errors([scene(LINE).sensing], range(3)) is None


def test_a_mismatch_of_the_radii_turns_odometry_evenly():
    """On a straight line with believed radii r (1 + ε): heading error (ε_r − ε_l) s / 2L, s the distance driven."""
    scenario = scene(LINE, sensing=Sensing(wheel_error=0.01), duration=20.0)
    run = simulate(scenario, Scripted(v=0.3), range(30))
    right, left, _ = errors_of(scenario, range(30))
    distance = run["x"] - 2.0
    assert np.abs(run["y"] + 3.0).max() < 1e-6  # the truth is straight
    expected = (right - left)[..., None] * distance / (2 * FINE.half_axle)
    np.testing.assert_allclose(noise_of(run, "heading"), expected, rtol=0, atol=1e-6)
    # The place follows: an arc of the believed length that turns by that angle
    length, angle = (right + left)[..., None] / 2 * distance, expected
    arc = length * np.sinc(angle / (2 * pi))
    np.testing.assert_allclose(run["x_measured"], 2.0 + arc * np.cos(angle / 2), rtol=0, atol=1e-6)
    np.testing.assert_allclose(run["y_measured"], -3.0 + arc * np.sin(angle / 2), rtol=0, atol=1e-6)
    assert np.abs(expected[..., -1]).max() > 0.5


def test_a_mismatch_of_the_axle_scales_the_turns_and_not_the_distance():
    scenario = scene(LINE, sensing=Sensing(axle_error=0.05), duration=10.0)
    straight = simulate(scenario, Scripted(v=0.3), range(5))
    assert max(np.abs(noise_of(straight, name)).max() for name in ("x", "y", "heading")) < 1e-5
    turning = simulate(scenario, Scripted(w=1.0), range(5))
    axle = errors_of(scenario, range(5))[2][..., None]
    np.testing.assert_allclose(turning["heading_measured"], turning["heading"] / axle, rtol=0, atol=1e-5)


def test_the_speeds_that_a_robot_measures_have_the_same_mismatch():
    scenario = scene(LINE, sensing=Sensing(wheel_error=0.02, axle_error=0.02), duration=5.0)
    law = Scripted(v=0.3)
    run = simulate(scenario, law, range(10))
    right, left, axle = errors_of(scenario, range(10))
    driven = np.diff(run["x"][:, 0]) / 0.05
    v, w = (np.array([getattr(seen, name)[:, 0] for seen in law.seen[1:]]).T for name in ("v", "w"))
    np.testing.assert_allclose(v, (right + left) / 2 * driven, rtol=0, atol=1e-6)
    np.testing.assert_allclose(w, (right - left) / (2 * FINE.half_axle * axle) * driven, rtol=0, atol=1e-5)


def test_a_pose_sensor_with_a_filter_bounds_the_drift():
    """Odometry alone turns away without end; the same wheels under a filter stay near the truth."""
    drift = simulate(scene(LINE, sensing=Sensing(wheel_error=0.02), duration=30.0), Scripted(v=0.3), range(20))
    joined = pose(wheel_error=0.02, filter_gain=0.1)
    held = simulate(scene(LINE, sensing=joined, duration=30.0), Scripted(v=0.3), range(20))
    assert np.abs(noise_of(drift, "heading")[..., -1]).max() > 0.5
    right, left, axle = errors_of(scene(LINE, sensing=joined), range(20))
    # e' = (1 − g) (e + d): in the steady state d (1 − g)/g, d being the error of one period's turn
    step = (right - left) / (2 * FINE.half_axle * axle) * 0.3 * 0.05
    np.testing.assert_allclose(noise_of(held, "heading")[..., -1], step * 0.9 / 0.1, rtol=1e-3, atol=1e-6)


# What a controller may see --------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    "sensing",
    [
        Sensing(start_position=0.1, start_heading=0.1, wheel_error=0.02),
        pose(position_noise=0.1, heading_noise=0.1),
        pose(relative_noise=0.1, heading_noise=0.1, filter_gain=0.5),
    ],
    ids=["odometry", "noise", "filter"],
)
def test_nothing_that_a_law_sees_is_the_truth(sensing):
    member = replace(LINE, path=Circle(center=(1.0, -3.0)), start=(2.0, -3.0, pi / 2))
    law = Scripted(v=0.3, w=0.3)
    run = simulate(scene(member, sensing=sensing, duration=2.0), law, (1, 2))
    for name in ("x", "y", "heading"):
        seen = np.stack([getattr(observed, name) for observed in law.seen], axis=-1)
        assert (seen != run[name]).mean() > 0.99
    for k, observed in enumerate(law.seen):
        flat = [a for f in observed if isinstance(f, np.ndarray) for a in f.ravel()]
        truth = {*run["x"][:, 0, k], *run["y"][:, 0, k]} - {2.0, -3.0}
        assert not truth & set(flat)


@pytest.mark.parametrize("sensing", [Sensing(), pose()], ids=["odometry", "pose"])
def test_a_law_that_writes_into_what_it_sees_moves_no_robot(sensing):
    @dataclass(frozen=True)
    class Scribbling(Scripted):
        def control(self, seen, memory, dt):
            command = super().control(seen, memory, dt)
            for array in (seen.x, seen.y, seen.heading, seen.v, seen.w):
                array += 1.0
            return command

    honest = simulate(scene(LINE, sensing=sensing, duration=1.0), Scripted(v=0.3, w=0.2))
    scribbled = simulate(scene(LINE, sensing=sensing, duration=1.0), Scribbling(v=0.3, w=0.2))
    for name in ("x", "y", "heading", "v", "w"):
        np.testing.assert_array_equal(scribbled[name], honest[name])
        if f"{name}_measured" in CHANNELS:  # nor what the run keeps
            np.testing.assert_array_equal(scribbled[f"{name}_measured"], honest[f"{name}_measured"])


@pytest.mark.parametrize(
    ("settings", "message"),
    [
        ({"relative_noise": 0.1}, 'relative_noise belongs to posture = "pose"'),
        ({"filter_gain": 0.5}, 'filter_gain belongs to posture = "pose"'),
        ({"noise_start": 1.0}, 'noise_start belongs to posture = "pose"'),
        ({"noise_end": 1.0}, 'noise_end belongs to posture = "pose"'),
        ({"posture": "pose", "noise_start": 3.0, "noise_end": 2.0}, "noise_end must be > noise_start, 3 s; got 2"),
        ({"posture": "pose", "noise_start": 3.0, "noise_end": 3.0}, "noise_end must be > noise_start"),
        ({"posture": "pose", "filter_gain": 0.0}, "filter_gain must be a finite number, > 0 and <= 1; got 0.0"),
        ({"wheel_error": 0.3}, "wheel_error must be a finite number, >= 0 and <= 0.2; got 0.3"),
        ({"posture": "pose", "relative_noise": -0.1}, "relative_noise must be"),
    ],
)
def test_sensing_that_cannot_be_is_refused(settings, message):
    with pytest.raises(SensingError) as caught:
        Sensing(**settings)
    assert message in str(caught.value)
