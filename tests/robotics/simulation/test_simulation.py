"""The simulation: reproducible to the last bit, independent of its neighbours, symmetric, and it stops what is lost."""

from collections.abc import Callable
from dataclasses import dataclass, replace
from math import cos, hypot, nan, pi, sin
from typing import Any

import numpy as np
import pandas as pd
import pytest

from robotics.laws.catalogue import make_controller
from robotics.laws.law import Command, Law
from robotics.measures.tracking import measure
from robotics.simulation.loop import SimulationError, simulate
from robotics.simulation.run import CHANNELS, REFERENCE, RunError, load_run
from robotics.simulation.scenario.description import Member, Scenario
from robotics.simulation.scenario.reading import load_scenario
from robotics.world.paths.path import Circle, Line, Quintic, Sine, Waypoints
from robotics.world.paths.trajectory import Timing
from robotics.world.sensing.posture import Sensing
from tests.robotics.world.vehicle.etsro import ETSRO

EVERY = ("fuzzy", "fuzzy-literal", "lyapunov", "csm", "assm", "qssm", "esm", "esm:realisation=velocity")
POSE = Sensing(posture="pose", position_noise=0.003, heading_noise=0.003)
LINE = Member(start=(0.0, 0.0, 0.0), path=Line(start=(0.0, 0.0), end=(5.0, 0.0)), timing=Timing(speed=0.3))
ROUND = Member(start=(0.2, 0.0, 1.5), path=Circle(), timing=Timing(speed=0.2), robot=replace(ETSRO, wheel_radius=0.04))
CURVE = Member(start=(-0.3, -1.2, 0.2), path=Quintic(start=(0.0, -1.0), end=(5.0, 1.0)), timing=Timing(duration=20.0))
SHORT = Scenario(name="short", robots=(CURVE,), duration=3.0, sensing=POSE)


@dataclass(frozen=True)
class Scripted(Law[None]):
    """Commands v(t), ω(t) or torques, whatever the robots see."""

    first: Callable[[float], Any]
    second: Callable[[float], Any]
    kind: str = "velocity"

    @property
    def level(self):
        return self.kind

    def init(self, setting, runs):
        return None

    def control(self, seen, memory, dt):
        a = np.full_like(seen.x, self.first(seen.time))
        b = np.full_like(seen.x, self.second(seen.time))
        return Command(a, b, a, b), None


def same(a, b):
    return a.tobytes() == b.tobytes()


# Randomness -----------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("name", EVERY)
def test_a_seed_gives_the_same_bits_alone_and_among_others(name):
    law = make_controller(name)
    scenario = replace(SHORT, sensing=replace(POSE, start_position=0.01, start_heading=0.01))
    seeds = (5, 0, 17, 3, 2**40)
    together = simulate(scenario, law, seeds)
    assert same(together.samples, simulate(scenario, law, seeds).samples)
    for i, seed in enumerate(seeds):
        alone = simulate(scenario, law, [seed])
        assert same(np.ascontiguousarray(together.samples[:, :, i]), np.ascontiguousarray(alone.samples[:, :, 0]))
    backwards = simulate(scenario, law, seeds[::-1])
    assert same(np.ascontiguousarray(backwards.samples[:, :, ::-1]), together.samples)


def test_a_seed_gives_the_same_bits_among_a_hundred():
    law = make_controller("fuzzy")
    crowd = simulate(SHORT, law, range(100))
    for seed in (0, 15, 16, 99):
        alone = simulate(SHORT, law, [seed])
        assert same(np.ascontiguousarray(crowd.samples[:, :, seed]), np.ascontiguousarray(alone.samples[:, :, 0]))


def test_different_seeds_differ_and_equal_seeds_do_not():
    run = simulate(SHORT, make_controller("lyapunov"), (1, 2, 1))
    assert (run["x_measured"][0] != run["x_measured"][1]).mean() > 0.99
    assert same(run["x"][0], run["x"][2])


def test_without_anything_random_every_seed_is_the_same_run():
    quiet = replace(SHORT, sensing=Sensing())
    run = simulate(quiet, make_controller("esm"), (1, 2))
    assert same(run["x"][0], run["x"][1])


def test_noise_has_the_standard_deviations_of_the_scenario_and_is_white():
    sensing = Sensing(posture="pose", position_noise=0.02, heading_noise=0.05)
    scenario = Scenario(name="noise", robots=(LINE, ROUND), duration=15.0, sensing=sensing)
    run = simulate(scenario, Scripted(lambda t: 0.2, lambda t: 0.3), range(40))
    noises = {name: run[f"{name}_measured"] - run[name] for name in ("x", "y", "heading")}
    samples = noises["x"].size
    for name, noise in noises.items():
        sigma = 0.05 if name == "heading" else 0.02
        assert abs(noise.mean()) < 4 * sigma / np.sqrt(samples)
        assert noise.std() == pytest.approx(sigma, rel=4 / np.sqrt(2 * samples))
        # White: neighbouring periods, robots and seeds are uncorrelated; Gaussian: the fourth moment
        for a, b in ((noise[..., 1:], noise[..., :-1]), (noise[:, :1], noise[:, 1:]), (noise[1:], noise[:-1])):
            assert abs((a * b).mean()) < 4 * sigma**2 / np.sqrt(a.size)
        assert (noise**4).mean() / sigma**4 == pytest.approx(3, rel=0.1)
    assert abs((noises["x"] * noises["y"]).mean()) < 4 * 0.02**2 / np.sqrt(samples)


def test_noise_is_drawn_alike_however_long_the_run():
    """Noise comes in blocks of 256 periods: a longer run begins as the shorter one did."""
    law = make_controller("lyapunov")
    short, long = (simulate(replace(SHORT, duration=d), law, [4]) for d in (12.0, 14.0))
    assert same(np.ascontiguousarray(long.samples[: len(short.time)]), short.samples)


def test_pose_without_noise_is_the_truth_and_odometry_is_nearly():
    law = Scripted(lambda t: 0.3 * sin(t), lambda t: cos(t))
    exact = simulate(replace(SHORT, sensing=Sensing(posture="pose")), law)
    counted = simulate(replace(SHORT, sensing=Sensing()), law)
    for name in ("x", "y", "heading"):
        assert same(exact[f"{name}_measured"], exact[name])
        gap = np.abs(counted[f"{name}_measured"] - counted[name]).max()
        assert 0 < gap < 1e-3
        assert same(exact[name], counted[name])  # sensing is no part of the plant


def test_start_spread_moves_the_truth_not_the_belief():
    sensing = Sensing(start_position=0.05, start_heading=0.1)
    run = simulate(replace(SHORT, sensing=sensing, duration=0.05), make_controller("lyapunov"), range(2000))
    for i, (name, sigma) in enumerate((("x", 0.05), ("y", 0.05), ("heading", 0.1))):
        offset = run[name][:, 0, 0] - CURVE.start[i]
        assert abs(offset.mean()) < 4 * sigma / np.sqrt(2000)
        assert offset.std() == pytest.approx(sigma, rel=0.07)
        assert (run[f"{name}_measured"][:, 0, 0] == CURVE.start[i]).all()


@pytest.mark.parametrize(
    ("seeds", "message"),
    [
        ([], "at least one seed"),
        ([-1], "whole number >= 0, got -1"),
        ([1.5], "got 1.5"),
        (["1"], "got '1'"),
        ([True], "got True"),
        ([0, None], "got None"),
    ],
)
def test_bad_seeds_are_refused(seeds, message):
    with pytest.raises(SimulationError) as caught:
        simulate(SHORT, make_controller("lyapunov"), seeds)
    assert message in str(caught.value)


def test_numpy_seeds_are_seeds():
    run = simulate(SHORT, make_controller("lyapunov"), np.arange(2))  # type: ignore[arg-type]
    assert run.seeds == (0, 1)
    assert all(type(seed) is int for seed in run.seeds)


# Robots side by side --------------------------------------------------------------------------------------------


@pytest.mark.parametrize("name", EVERY)
def test_robots_of_one_scenario_run_as_if_alone(name):
    law = make_controller(name)
    together = simulate(Scenario(name="three", robots=(LINE, ROUND, CURVE), duration=4.0, latency=0.03), law)
    for i, member in enumerate((LINE, ROUND, CURVE)):
        alone = simulate(Scenario(name="one", robots=(member,), duration=4.0, latency=0.03), law)
        ours, other = together.samples[:, :, :, i], alone.samples[:, :, :, 0]
        assert same(np.ascontiguousarray(ours), np.ascontiguousarray(other))
        assert same(np.ascontiguousarray(together.reference[..., i]), np.ascontiguousarray(alone.reference[..., 0]))


# Symmetry -------------------------------------------------------------------------------------------------------


def moved(point, angle, shift):
    x, y = point
    return (cos(angle) * x - sin(angle) * y + shift[0], sin(angle) * x + cos(angle) * y + shift[1])


POINTS = ((0.0, 0.0), (1.0, 0.3), (2.0, -0.2), (3.0, 0.5))


def scene(transform, turn, mirror=1.0):
    start = (-0.3, 0.2, 0.4)
    member = Member(
        start=(*transform(start[:2]), mirror * start[2] + turn),
        path=Waypoints(points=tuple(transform(p) for p in POINTS)),
        timing=Timing(speed=0.25),
    )
    # Friction and motors are symmetric, flooring encoders are not: a wheel that turns back counts one earlier.
    member = replace(member, robot=replace(ETSRO, counts_per_turn=1e12))
    return Scenario(name="scene", robots=(member,), duration=8.0, latency=0.03)


@pytest.mark.parametrize("name", ["fuzzy", "lyapunov", "assm", "qssm", "esm"])
def test_moving_and_turning_the_scene_moves_and_turns_the_result(name):
    law, angle, shift = make_controller(name), 2.2, (3.0, -7.0)
    plain = simulate(scene(lambda p: p, 0.0), law)
    turned = simulate(scene(lambda p: moved(p, angle, shift), angle), law)
    x, y = moved((plain["x"], plain["y"]), angle, shift)
    np.testing.assert_allclose(turned["x"], x, rtol=0, atol=1e-6)
    np.testing.assert_allclose(turned["y"], y, rtol=0, atol=1e-6)
    np.testing.assert_allclose(turned["heading"], plain["heading"] + angle, rtol=0, atol=1e-5)
    np.testing.assert_allclose(turned["command_1"], plain["command_1"], rtol=0, atol=1e-5)


@pytest.mark.parametrize("name", ["fuzzy", "lyapunov", "assm", "qssm", "esm"])
def test_the_mirrored_scene_gives_the_mirrored_result(name):
    law = make_controller(name)
    plain = simulate(scene(lambda p: p, 0.0), law)
    mirrored = simulate(scene(lambda p: (p[0], -p[1]), 0.0, mirror=-1.0), law)
    np.testing.assert_allclose(mirrored["x"], plain["x"], rtol=0, atol=1e-6)
    np.testing.assert_allclose(mirrored["y"], -plain["y"], rtol=0, atol=1e-6)
    np.testing.assert_allclose(mirrored["heading"], -plain["heading"], rtol=0, atol=1e-5)
    assert np.abs(plain["y"]).max() > 0.3


# Time -----------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("late", [0.0, 0.01, 0.03, 0.05, 0.08, 0.1, 0.13, 0.27])
@pytest.mark.parametrize("period", [0.01, 0.05, 0.1])
def test_a_command_takes_effect_exactly_the_latency_later(late, period):
    """Kinematic: from a step of v at t = 0.2 s on, x = v (t − 0.2 − latency)."""
    scenario = Scenario(
        name="late", robots=(LINE,), duration=1.0, latency=late, period=period, plant="kinematic", sensing=Sensing()
    )
    run = simulate(scenario, Scripted(lambda t: 0.4 * (t > 0.2 - 1e-9), lambda t: 0.0))
    np.testing.assert_allclose(run["x"][0, 0], 0.4 * np.maximum(run.time - 0.2 - late, 0), rtol=0, atol=1e-12)


def test_kinematic_mode_drives_the_commanded_circle():
    scenario = Scenario(name="circle", robots=(LINE,), duration=4.0, plant="kinematic", divergence=100.0)
    run = simulate(scenario, Scripted(lambda t: 0.5, lambda t: pi / 2))
    np.testing.assert_allclose(run["x"][0, 0], 1 / pi * np.sin(pi / 2 * run.time), rtol=0, atol=1e-12)
    np.testing.assert_allclose(run["y"][0, 0], 1 / pi * (1 - np.cos(pi / 2 * run.time)), rtol=0, atol=1e-12)
    assert (run["effort"] == 0).all()


def test_kinematic_and_dynamic_plant_agree_where_commands_are_gentle():
    gentle = Scripted(lambda t: 0.2 * (1 - cos(0.3 * t)), lambda t: 0.3 * sin(0.3 * t))
    dynamic = simulate(Scenario(name="d", robots=(LINE,), duration=10.0), gentle)
    kinematic = simulate(Scenario(name="k", robots=(LINE,), duration=10.0, plant="kinematic"), gentle)
    gap = np.hypot(dynamic["x"] - kinematic["x"], dynamic["y"] - kinematic["y"])
    assert 1e-4 < gap.max() < 0.03
    assert np.abs(dynamic["v"] - kinematic["v"]).max() < 0.02


def test_measured_velocities_are_those_of_the_encoders():
    seen = []

    @dataclass(frozen=True)
    class Watching(Scripted):
        def control(self, observed, memory, dt):
            seen.append((observed.time, float(observed.v[0, 0]), float(observed.w[0, 0])))
            return super().control(observed, memory, dt)

    run = simulate(Scenario(name="w", robots=(LINE,), duration=3.0), Watching(lambda t: 0.3, lambda t: 1.0))
    time, v, w = np.array(seen).T
    np.testing.assert_allclose(time, run.time, rtol=0, atol=1e-12)
    assert (v[0], w[0]) == (0, 0)
    robot = ETSRO
    count = 2 * pi / robot.counts_per_turn / 0.05  # rad/s at 50 ms: 0.94 mm/s [B]
    assert count * robot.wheel_radius == pytest.approx(0.94e-3, abs=5e-6)
    travelled = np.hypot(np.diff(run["x"][0, 0]), np.diff(run["y"][0, 0])) / 0.05
    np.testing.assert_allclose(v[1:], travelled, rtol=0, atol=robot.wheel_radius * count + 1e-4)
    turned = np.diff(run["heading"][0, 0]) / 0.05
    np.testing.assert_allclose(w[1:], turned, rtol=0, atol=robot.wheel_radius * count / robot.half_axle)


def test_record_holds_what_the_controller_saw_and_said():
    law = Scripted(lambda t: 0.1 + t, lambda t: -t)
    run = simulate(replace(SHORT, duration=0.5), law, (0, 1))
    assert (run["command_1"] == 0.1 + run.time).all()
    assert (run["v_demand"] == 0.1 + run.time).all()
    assert (run["command_2"] == -run.time).all()
    assert (run["w_demand"] == -run.time).all()
    for name, value in REFERENCE.items():
        expected = getattr(SHORT.trajectory.sampled(run.time), name).T
        assert (run.target(name) == expected).all(), value
    assert (np.diff(run["effort"]) >= 0).all()
    assert (run.scenario, run.controller, run.level) == ("short", "Scripted", "velocity")
    assert simulate(SHORT, law, name="mine").controller == "mine"


def test_progress_is_told_every_period():
    told = []
    run = simulate(SHORT, make_controller("lyapunov"), progress=lambda: told.append(1))
    assert len(told) == len(run.time) == SHORT.ticks + 1


# Divergence -----------------------------------------------------------------------------------------------------


def test_a_lost_robot_is_stopped_named_and_leaves_the_others_alone():
    astray = replace(LINE, start=(0.0, 0.0, pi))  # literal signs: positive feedback
    scenario = Scenario(
        name="lost", robots=(CURVE, astray), duration=25.0, divergence=3.0, sensing=Sensing(posture="pose")
    )
    law = make_controller("lyapunov:signs=literal")
    run = simulate(scenario, law, (7, 8), name="literal")
    assert run.diverged[:, 1].all()
    k = run.stopped[0, 1]
    assert 0 < k < scenario.ticks
    before = np.hypot(run["x"] - run.target("x"), run["y"] - run.target("y"))
    assert before[0, 1, k] >= 3.0
    assert before[0, 1, :k].max() < 3.0
    assert np.isfinite(run.samples[: k + 1, :, 0, 1]).all()  # history is kept
    assert np.isnan(run.samples[k + 1 :, :, 0, 1]).all()
    assert f"controller 'literal' diverged on 'lost': robot 2, seed 7, stopped at t = {run.time[k]:.2f} s" in (
        run.divergences()
    )
    assert len(run.divergences()) == run.diverged.sum()
    # The other robot runs as if alone
    alone = simulate(replace(scenario, robots=(CURVE,)), law, (7,))
    assert same(np.ascontiguousarray(alone.samples[..., 0, 0]), np.ascontiguousarray(run.samples[..., 0, 0]))
    assert np.isinf(measure(run)["settling_time_s"][0, 1])
    assert measure(run)["final_error_m"][0, 1] == pytest.approx(before[0, 1, k])


@dataclass(frozen=True)
class Failing(Scripted):
    """Commands ``value`` to one robot of one run from 1 s on."""

    value: float = nan

    def control(self, seen, memory, dt):
        command, memory = super().control(seen, memory, dt)
        if seen.time >= 1 - 1e-9:
            command.second[0, 1] = self.value
        return command, memory


@pytest.mark.parametrize("value", [nan, np.inf, -np.inf])
@pytest.mark.parametrize("late", [0.0, 0.08])
def test_a_command_that_is_not_finite_stops_its_robot_only(value, late):
    scenario = Scenario(name="nan", robots=(LINE, ROUND), duration=3.0, sensing=POSE, latency=late)
    failing = simulate(scenario, Failing(lambda t: 0.1, lambda t: 0.1, value=value), (0, 1))
    good = simulate(scenario, Scripted(lambda t: 0.1, lambda t: 0.1), (0, 1))
    assert failing.stopped.tolist() == [[-1, 20], [-1, -1]]
    for run, robot in ((0, 0), (1, 0), (1, 1)):
        a, b = failing.samples[:, :, run, robot], good.samples[:, :, run, robot]
        assert same(np.ascontiguousarray(a), np.ascontiguousarray(b))
    assert np.isfinite(failing.samples[:20, :, 0, 1]).all()
    assert np.isfinite(failing.samples[20, :8, 0, 1]).all()
    assert np.isnan(failing.samples[21:, :, 0, 1]).all()
    assert all(np.isfinite(v).any() or name.endswith("settling_time_s") for name, v in measure(failing).items())


def test_a_robot_lost_at_once_still_gives_a_run():
    far = replace(LINE, start=(0.0, 50.0, 0.0))
    run = simulate(Scenario(name="far", robots=(far, LINE), duration=1.0), make_controller("fuzzy"))
    assert run.stopped.tolist() == [[0, -1]]
    assert all(values.shape == (1, 2) for values in measure(run).values())
    assert measure(run)["final_error_m"][0, 0] == pytest.approx(50.0)


# Files and tables -----------------------------------------------------------------------------------------------


def lossy_run():
    astray = replace(LINE, start=(0.0, 0.0, pi))
    scenario = Scenario(name="größer", robots=(CURVE, astray), duration=12.0, divergence=2.0, sensing=POSE)
    return simulate(scenario, make_controller("lyapunov:signs=literal"), (3, 2**60), name="literal:α")


def test_save_and_load_lose_nothing(tmp_path):
    run = lossy_run()
    assert run.diverged.any()
    run.save(tmp_path / "run.npz")
    back = load_run(tmp_path / "run.npz")
    for name in ("time", "samples", "reference", "stopped"):
        a, b = getattr(run, name), getattr(back, name)
        assert (a.dtype, a.shape) == (b.dtype, b.shape)
        assert same(np.ascontiguousarray(a), np.ascontiguousarray(b))
    assert all(
        same(np.ascontiguousarray(a), np.ascontiguousarray(b)) for a, b in zip(run.paths, back.paths, strict=True)
    )
    assert (back.scenario, back.controller, back.level, back.seeds) == (
        run.scenario, run.controller, run.level, run.seeds,
    )  # fmt: skip
    assert back.divergences() == run.divergences()
    assert [p.name for p in tmp_path.iterdir()] == ["run.npz"]


def test_files_that_hold_no_run_are_refused(tmp_path):
    text, other, cut = tmp_path / "text.npz", tmp_path / "other.npz", tmp_path / "cut.npz"
    text.write_text("not a run")
    np.savez(other, x=np.zeros(3))
    lossy_run().save(cut)
    cut.write_bytes(cut.read_bytes()[:2000])
    single = tmp_path / "single.npy"
    np.save(single, np.zeros(3))
    for path in (text, other, cut, single):
        with pytest.raises(RunError, match=f"{path.name}: this (is not a run saved by|saved run is damaged)"):
            load_run(path)
    for path in (tmp_path / "none.npz", tmp_path):
        with pytest.raises(RunError, match="cannot be read"):
            load_run(path)
    with pytest.raises(RunError, match="cannot be written"):
        lossy_run().save(tmp_path / "no" / "folder" / "run.npz")


def test_frame_has_a_row_a_seed_robot_and_sample():
    run = lossy_run()
    frame = run.frame()
    assert isinstance(frame, pd.DataFrame)
    assert list(frame.columns) == ["seed", "robot", "time", *CHANNELS, *(f"{n}_reference" for n in REFERENCE)]
    n = len(run.time)
    assert len(frame) == 2 * 2 * n
    for i, seed in enumerate(run.seeds):
        for robot in (0, 1):
            part = frame[(frame.seed == seed) & (frame.robot == robot + 1)]
            assert len(part) == n
            assert (part.time.to_numpy() == run.time).all()
            np.testing.assert_array_equal(part.y.to_numpy(), run["y"][i, robot])
            np.testing.assert_array_equal(part.effort.to_numpy(), run["effort"][i, robot])
            np.testing.assert_array_equal(part.heading_reference.to_numpy(), run.target("heading")[robot])


def test_the_final_posture_of_a_straight_run_is_where_it_should_be():
    """An end-to-end check by hand: at constant 0.3 m/s along y = 0 a robot ends at 0.3 t, a little late at most."""
    for name in ("lyapunov", "esm", "fuzzy"):
        run = simulate(Scenario(name="line", robots=(LINE,), duration=10.0), make_controller(name))
        assert hypot(run["x"][0, 0, -1] - 3.0, run["y"][0, 0, -1]) < 0.02
        assert run["heading"][0, 0, -1] == pytest.approx(0, abs=0.01)


def test_a_packaged_scenario_runs_with_every_controller():
    scenario = replace(load_scenario("table-2-1"), duration=2.0)
    for name in EVERY:
        run = simulate(scenario, make_controller(name), (0, 1))
        assert not run.diverged.any()
        assert np.isfinite(run.samples).all()
        assert run.samples.shape == (41, len(CHANNELS), 2, 1)


def test_sine_member_is_used():
    """x_rate timing and Sine inside a scenario: the reference of the run is the closed form."""
    member = Member(start=(0.0, 0.0, pi / 4), path=Sine(x_end=3.0), timing=Timing(x_rate=0.3))
    run = simulate(Scenario(name="sine", robots=(member,), duration=5.0), make_controller("lyapunov"))
    np.testing.assert_allclose(run.target("y")[0], np.sin(0.3 * run.time), rtol=0, atol=1e-6)


def test_a_specification_drives_as_its_law_does_and_names_the_run():
    scenario = load_scenario("fuzzy-on-path")
    said, made = simulate(scenario, "lyapunov:ky=3"), simulate(scenario, make_controller("lyapunov:ky=3"))
    np.testing.assert_array_equal(said.samples, made.samples)
    assert said.about.controller == "lyapunov:ky=3"
    assert simulate(scenario, "lyapunov:ky=3", name="mine").about.controller == "mine"
