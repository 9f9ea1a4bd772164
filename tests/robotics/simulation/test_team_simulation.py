"""Teams in the simulation: what robots hear, what faults do to them, the same bits beside any neighbours, files."""

import json
import os
import subprocess
import sys
from dataclasses import dataclass, field, replace
from math import inf
from typing import Any, ClassVar

import numpy as np
import pytest

from robotics.commands.application import main
from robotics.laws.catalogue import make_controller
from robotics.laws.law import Command, Law
from robotics.simulation.loop import simulate
from robotics.simulation.run import CHANNELS, REFERENCE, TEAM_CHANNELS, load_run
from robotics.simulation.scenario.description import Member, Scenario
from robotics.simulation.scenario.reading import parse_scenario
from robotics.world.paths.path import Line, Quintic
from robotics.world.paths.trajectory import Timing
from robotics.world.radio.description import Radio
from robotics.world.radio.faults import Fault
from robotics.world.sensing.posture import Sensing

LAWS = ("virtual-structure", "virtual-structure-virtual", "cooperation", "graph-esm")
NOISY = Sensing(
    posture="pose",
    position_noise=0.01,
    relative_noise=0.02,
    heading_noise=0.01,
    filter_gain=0.3,
    wheel_error=0.01,
    axle_error=0.01,
    start_position=0.02,
    start_heading=0.02,
)
HARD = Radio(graph="ring", loss=0.1, burst_start=0.05, jitter=0.12, latency=0.02, range=30.0)


def member(i, spacing=1.0, **settings):
    y = spacing * i
    path = Quintic(start=(0.0, y), end=(3.0 + 0.5 * (i % 5), y + 0.5))
    return Member(start=(0.0, y, 0.0), path=path, timing=Timing(duration=20.0), **settings)


def team(robots=3, duration=6.0, **settings):
    members = tuple(member(i) for i in range(robots)) if isinstance(robots, int) else robots
    return Scenario(**{"name": "team", "kind": "team", "robots": members, "duration": duration} | settings)


@dataclass(frozen=True)
class Probe(Law[None]):
    """Drives with a command that never repeats; says the time, its number and the x that it measures."""

    patience: float = inf
    v: float = 0.2
    heard: list = field(default_factory=list)

    message: ClassVar[tuple[str, ...]] = ("time", "number", "x")

    @property
    def watchdog(self):
        return self.patience

    def init(self, setting, runs):
        return None

    def control(self, seen, memory, dt):
        self.heard.append(seen.heard)
        number = np.broadcast_to(np.arange(1.0, seen.x.shape[1] + 1), seen.x.shape)
        v = self.v + 0.01 * np.sin(seen.time) * number
        w = 0.01 * np.cos(seen.time) * number
        return Command(v, w, v, w, {"time": np.full_like(seen.x, seen.time), "number": number, "x": seen.x}), None


def same(a, b):
    return np.ascontiguousarray(a).tobytes() == np.ascontiguousarray(b).tobytes()


def at(run, *times):
    return [round(t / (run.time[1] - run.time[0])) for t in times]


# What is heard --------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    "radio", [Radio(), Radio(graph="star", hub=2, period=0.1, latency=0.03), HARD], ids=["perfect", "star", "hard"]
)
def test_a_law_hears_what_was_measured_then_and_not_what_is_true_now(radio):
    law = Probe()
    seeds = (3, 8)
    run = simulate(team(4, radio=radio, sensing=NOISY), law, seeds, message_ages=True)
    graph = radio.adjacency(4) > 0
    measured = run["x_measured"]
    truth = run["x"]
    for k, heard in enumerate(law.heard):
        assert heard.values.shape == (3, 2, 4, 4)
        np.testing.assert_array_equal(heard.hears, graph)
        known = np.isfinite(heard.age)
        assert not known[:, ~graph].any()
        assert np.isnan(heard.values[:, ~known]).all()
        for r, i, j in np.argwhere(known):
            then = round(float(run.time[k] - heard.age[r, i, j]) / 0.05)
            assert then < k  # all robots decide at the same time
            assert heard["time"][r, i, j] == pytest.approx(run.time[then], abs=1e-12)
            assert heard["number"][r, i, j] == j + 1
            assert heard["x"][r, i, j] == measured[r, j, then]
            assert heard["x"][r, i, j] != truth[r, j, then]
    ages = np.array([heard.age for heard in law.heard])
    np.testing.assert_array_equal(run.message_ages, ages.astype(np.float32))
    assert np.isfinite(ages[-1][:, graph]).all()


def test_two_hundred_robots_are_served_by_the_same_code():
    law = Probe()
    run = simulate(team(200, duration=0.5, radio=Radio(range=10.0)), law, message_ages=True)
    heard = law.heard[-1]
    gap = np.abs(np.arange(200)[:, None] - np.arange(200))
    near = (gap <= 10) & (gap > 0)  # 1 m from path to path, and all are driven alike
    sure = gap != 10
    np.testing.assert_array_equal(np.isfinite(heard.age[0])[sure], near[sure])
    assert (heard.values[1, 0][near & sure] == np.broadcast_to(np.arange(1, 201), (200, 200))[near & sure]).all()
    assert run.message_ages.shape == (11, 1, 200, 200)


def test_range_follows_the_true_places_as_the_robots_drive():
    """Kinematic, 0.2 m/s apart in y from 1 m on; beyond 1.507 m the last message stays."""
    away = tuple(
        Member(start=(0.0, y, turn), path=Line(start=(0.0, y), end=(0.0, 9 * y)), timing=Timing(duration=99.0))
        for y, turn in ((0.5, np.pi / 2), (-0.5, -np.pi / 2))
    )
    scenario = Scenario(
        name="away",
        kind="team",
        robots=away,
        duration=5.0,
        plant="kinematic",
        radio=Radio(range=1.507),
        sensing=Sensing(posture="pose", position_noise=0.5),
    )

    @dataclass(frozen=True)
    class Straight(Probe):
        def control(self, seen, memory, dt):
            command, memory = super().control(seen, memory, dt)
            return command._replace(first=np.full_like(seen.x, 0.1), second=np.zeros_like(seen.x)), memory

    run = simulate(scenario, Straight(), message_ages=True)
    gap = np.hypot(run["x"][0, 0] - run["x"][0, 1], run["y"][0, 0] - run["y"][0, 1])
    last = int(np.flatnonzero(gap <= 1.507).max())
    assert run.time[last] == pytest.approx(2.5, abs=0.051)
    expected = np.where(np.arange(101) <= last + 1, 0.05, (np.arange(101) - last) * 0.05)
    np.testing.assert_allclose(run.message_ages[1:, 0, 0, 1], expected[1:], rtol=1e-6)


def test_laws_that_say_nothing_hear_nothing():
    @dataclass(frozen=True)
    class Mute(Probe):
        message = ()

    law = Mute()
    run = simulate(team(radio=Radio(baud=1.0)), law, message_ages=True)  # nothing said fits into any radio
    assert all(heard.fields == () and np.isinf(heard.age).all() for heard in law.heard)
    assert np.isinf(run.message_ages).all()
    assert simulate(team(), law).message_ages is None


# Reproducible ---------------------------------------------------------------------------------------------------

FAULTY = (
    Fault(robot=1, kind="failure", start=0.5, start_until=3.0, duration=1.0),
    Fault(robot=2, kind="delay", start=1.0, start_until=4.0, duration=0.8),
    Fault(robot=3, kind="silence", start=1.0, duration=1.0, start_until=2.0),
    Fault(robot=3, other=1, kind="silence", start=3.0, duration=1.0),
    Fault(robot=2, kind="stall", start=3.5, duration=0.5),
)


@pytest.mark.parametrize("law", LAWS)
def test_a_seed_gives_the_same_bits_alone_and_among_others(law):
    scenario = team(4, radio=HARD, sensing=NOISY, faults=FAULTY, latency=0.03)
    controller = make_controller(law)
    seeds = (5, 0, 17, 3, 2**40)
    together = simulate(scenario, controller, seeds, message_ages=True)
    assert not together.diverged.any()
    for i, seed in enumerate(seeds):
        alone = simulate(scenario, controller, [seed], message_ages=True)
        assert same(together.samples[:, :, i], alone.samples[:, :, 0])
        assert same(together.team[:, :, i], alone.team[:, :, 0])
        assert same(together.message_ages[:, i], alone.message_ages[:, 0])
    backwards = simulate(scenario, controller, seeds[::-1], message_ages=True)
    assert same(backwards.samples[:, :, ::-1], together.samples)
    assert len({together.samples[:, :, i].tobytes() for i in range(5)}) == 5


def test_a_perfect_team_does_not_depend_on_its_seed():
    run = simulate(team(), make_controller("virtual-structure"), (1, 2))
    assert same(run["x"][0], run["x"][1])


def test_a_longer_run_begins_as_the_shorter_one():
    """Noise and radio draw in blocks of 256."""
    law = make_controller("virtual-structure")
    short, long = (simulate(team(radio=HARD, sensing=NOISY, duration=d), law, (4,)) for d in (12.5, 14.0))
    assert same(long.samples[: len(short.time)], short.samples)


# Faults ---------------------------------------------------------------------------------------------------------

WINDOW: dict[str, Any] = {"start": 2.0, "duration": 1.5}


def faulted(kind, law=None, **settings):
    """A run with robot 2 at fault from 2 to 3.5 s, the same run without, and the samples in between."""
    scenario = team(**settings)
    run = simulate(replace(scenario, faults=(Fault(robot=2, kind=kind, **WINDOW),)), law or Probe(), message_ages=True)
    free = simulate(scenario, law or Probe(), message_ages=True)
    first, after = at(run, 2.0, 3.5)
    return run, free, slice(first, after)


def test_a_failure_stops_the_wheels_and_then_lets_them_go_on():
    run, free, inside = faulted("failure")
    for name in ("command_1", "command_2"):
        assert (run[name][0, 1, inside] == 0).all()
        outside = np.delete(run[name][0, 1], np.r_[inside])
        np.testing.assert_array_equal(outside, np.delete(free[name][0, 1], np.r_[inside]))
        assert (outside[2:] != 0).all()
    halted = slice(inside.start + 20, inside.stop)  # a second later
    assert np.abs(run["v"][0, 1, halted]).max() < 1e-2
    assert np.ptp(run["x"][0, 1, halted]) < 2e-3
    assert run["v"][0, 1, -1] > 0.15
    for robot in (0, 2):
        assert same(run.samples[..., 0, robot], free.samples[..., 0, robot])
    assert (run["fault"][0, 1, inside] == 1).all()
    assert run["fault"].sum() == 30


def test_a_failure_of_a_torque_law_takes_its_torque():
    scenario = team(faults=(Fault(robot=2, kind="failure", start=2.0, duration=3.0),))
    run = simulate(scenario, make_controller("graph-esm:realisation=torque"))
    inside = slice(*at(run, 2.0, 5.0))
    assert (run["command_1"][0, 1, inside] == 0).all()
    assert abs(run["v"][0, 1, inside.stop - 1]) < 0.02
    assert run["v"][0, 0, inside].min() > 0.1


@pytest.mark.parametrize("kind", ["failure", "delay", "silence"])
def test_the_others_know_a_silent_robot_by_what_it_said_last(kind):
    run, _, inside = faulted(kind)
    k = np.arange(len(run.time))
    for i, j in ((0, 1), (2, 1), (1, 0), (1, 2)):
        age = run.message_ages[:, 0, i, j]
        # One period old; at 2.00 s nothing comes through: the last was said at 1.90 s. Said at 3.50, heard at 3.55 s.
        expected = np.where((k >= inside.start) & (k <= inside.stop), (k - inside.start + 2) * 0.05, 0.05)
        np.testing.assert_allclose(age[1:], expected[1:], rtol=1e-6)
    for i, j in ((0, 2), (2, 0)):
        np.testing.assert_allclose(run.message_ages[1:, 0, i, j], 0.05, rtol=1e-6)


@pytest.mark.parametrize("plant", ["dynamic", "kinematic"])
def test_a_delay_holds_the_last_command_to_the_bit(plant):
    run, free, inside = faulted("delay", plant=plant)
    for name in ("command_1", "command_2"):
        held = run[name][0, 1, inside]
        assert (held == free[name][0, 1, inside.start - 1]).all()
        assert (np.delete(run[name][0, 1], np.r_[inside]) == np.delete(free[name][0, 1], np.r_[inside])).all()
        assert len(set(free[name][0, 1, inside])) == 30
    if plant == "kinematic":  # and the robot does it, a sample later
        assert len(set(run["v"][0, 1, inside.start : inside.stop + 1])) == 1
    assert (run["fault"][0, 1] == np.where((run.time > 1.99) & (run.time < 3.49), 2, 0)).all()


def test_a_delay_from_the_start_holds_standstill():
    scenario = team(faults=(Fault(robot=1, kind="delay", start=0.0, duration=1.0),))
    run = simulate(scenario, Probe())
    assert (run["command_1"][0, 0, : at(run, 1.0)[0]] == 0).all()
    assert (run["command_1"][0, 0, at(run, 1.0)[0] :] > 0.1).all()


def test_a_stalled_robot_goes_on_talking():
    run, _, inside = faulted("stall")
    assert (run["command_1"][0, 1, inside] == 0).all()
    for i, j in ((0, 1), (1, 0), (2, 1)):
        np.testing.assert_allclose(run.message_ages[1:, 0, i, j], 0.05, rtol=1e-6)
    assert (run["fault"][0, 1, inside] == 4).all()


def test_a_silent_robot_drives_on():
    run, free, inside = faulted("silence")
    assert same(run.samples, free.samples)  # the probe does not listen
    assert (run["fault"][0, 1, inside] == 3).all()


def test_a_silent_link_changes_that_link_only():
    scenario = team(faults=(Fault(robot=3, other=1, kind="silence", **WINDOW),))
    run = simulate(scenario, Probe(), message_ages=True)
    longest = run.message_ages[1:, 0].max(axis=0)
    expected = np.full((3, 3), 0.05)
    expected[0, 2] = expected[2, 0] = 1.6
    np.fill_diagonal(expected, np.inf)
    np.testing.assert_allclose(longest, expected, rtol=1e-6)
    assert not run["fault"].any()


def test_a_failure_reaches_the_wheels_after_the_latency_of_the_commands():
    for latency in (0.0, 0.03, 0.1):
        run, _, inside = faulted("failure", plant="kinematic", latency=latency)
        still = 10 + np.flatnonzero(np.diff(run["x"][0, 1, 10:]) == 0)
        assert still.min() == inside.start + int(np.ceil(latency / 0.05 - 1e-9))
        assert len(still) == 30 - (latency % 0.05 > 1e-9)


@pytest.mark.parametrize(("watchdog", "period"), [(0.5, 0.05), (0.3, 0.05), (0.15, 0.05), (0.3, 0.1), (0.0, 0.05)])
def test_a_watchdog_stops_a_robot_that_gets_no_command(watchdog, period):
    """It holds the last command for that long, and no longer; with the next command it goes on."""
    settings = {"period": period, "radio": Radio(period=period)}
    run, free, inside = faulted("delay", Probe(patience=watchdog), **settings)
    command = run["command_1"][0, 1]
    last = command[inside.start - 1]
    holding = inside.start + round(watchdog / period)
    assert (command[inside.start : holding] == last).all()
    assert (command[holding : inside.stop] == 0).all()
    assert (command[inside.stop :] == free["command_1"][0, 1, inside.stop :]).all()
    for robot in (0, 2):
        assert same(run.samples[..., 0, robot], free.samples[..., 0, robot])


@pytest.mark.parametrize("others", [(), (Fault(robot=1, kind="failure", start=0.0, duration=6.0),)])
def test_a_watchdog_counts_anew_after_each_outage(others):
    faults = (
        Fault(robot=2, kind="delay", start=1.0, duration=0.4),
        Fault(robot=2, kind="delay", start=1.45, duration=0.4),
        *others,
    )
    run = simulate(team(faults=faults), Probe(patience=0.5))
    assert (run["command_1"][0, 1] > 0.1).all()


def test_random_faults_come_when_each_seed_draws_them():
    fault = Fault(robot=2, kind="failure", start=1.0, start_until=4.0, duration=1.0)
    run = simulate(team(faults=(fault,)), Probe(), range(30))
    begins = np.array([run.time[np.flatnonzero(row[1]).min()] for row in run["fault"]])
    assert (begins >= 1).all()
    assert (begins <= 4.05).all()
    assert np.ptp(begins) > 2
    assert len(set(begins)) > 10
    lasting = (run["fault"][:, 1] == 1).sum(axis=-1)
    assert set(lasting) <= {19, 20, 21}
    assert ((run["command_1"][:, 1] == 0) == (run["fault"][:, 1] == 1)).all()


# What a run keeps -----------------------------------------------------------------------------------------------


def lossy_run():
    """One robot is lost on the way."""
    astray = replace(member(1), start=(0.0, 1.0, 3.0))
    scenario = team(robots=(member(0), astray, member(2)), divergence=1.0, radio=HARD, faults=FAULTY)
    return simulate(scenario, Probe(v=0.3), (3, 2**60), name="probe", message_ages=True)


def test_a_lost_robot_has_no_samples_and_the_others_go_on():
    run = lossy_run()
    assert run.diverged[:, 1].all()
    k = run.stopped[0, 1]
    assert np.isfinite(run.team[: k + 1, 1:, 0, 1]).all()
    assert np.isnan(run.team[k + 1 :, :, 0, 1]).all()
    assert np.isfinite(run.team[:, 1:, 0, 0][: run.stopped[0, 0] if run.diverged[0, 0] else None]).all()


def test_save_and_load_lose_nothing(tmp_path):
    run = lossy_run()
    run.save(tmp_path / "run.npz")
    back = load_run(tmp_path / "run.npz")
    for name in ("time", "samples", "reference", "stopped", "team", "message_ages"):
        a, b = getattr(run, name), getattr(back, name)
        assert (a.dtype, a.shape) == (b.dtype, b.shape)
        assert same(a, b)
    assert (back.scenario, back.controller, back.level, back.seeds) == ("team", "probe", "velocity", (3, 2**60))
    plain = simulate(replace(team(), kind="tracking"), make_controller("lyapunov"))
    assert plain.team is None
    plain.save(tmp_path / "plain.npz")
    assert load_run(tmp_path / "plain.npz").team is None
    assert load_run(tmp_path / "plain.npz").message_ages is None


def test_frame_has_the_columns_of_a_team():
    run = lossy_run()
    frame = run.frame()
    expected = ["seed", "robot", "time", *CHANNELS, *TEAM_CHANNELS, *(f"{n}_reference" for n in REFERENCE)]
    assert list(frame.columns) == expected
    for i, seed in enumerate(run.seeds):
        for robot in range(3):
            part = frame[(frame.seed == seed) & (frame.robot == robot + 1)]
            for name in ("fault", "x_target", "progress", "x"):
                np.testing.assert_array_equal(part[name].to_numpy(), run[name][i, robot])


@pytest.mark.parametrize("law", LAWS)
def test_a_team_run_says_where_its_law_wanted_the_robots(law):
    run = simulate(team(), make_controller(law))
    progress = run["progress"][0]
    assert ((progress >= 0) & (progress <= 1)).all()
    assert progress[:, -1].min() > 0.1
    away = np.hypot(run["x_target"] - run["x"], run["y_target"] - run["y"])
    assert away.max() < 0.5
    assert np.isfinite(run["heading_target"]).all()
    assert not run["fault"].any()


# Without the compiler, and from the command line -------------------------------------------------------------------

TEAM = """
kind = "team"
duration = 1.0
controller = "virtual-structure"

[sensing]
posture = "pose"
relative_noise = 0.05
filter_gain = 0.3
wheel_error = 0.01

[radio]
graph = "star"
loss = 0.2
burst_start = 0.1
jitter = 0.1
range = 5.0

[[faults]]
robot = 2
kind = "delay"
start = 0.3
duration = 0.3
""" + "".join(
    f"""
[[robots]]
start = [0.0, {i}.0, 0.1]
path = {{ shape = "quintic", start = [0.0, {i}.0], end = [2.0, {i}.5] }}
timing = {{ duration = 8.0, ramp = 1.0 }}
"""
    for i in range(3)
)

PLAIN = """
import sys
from numba import config
from robotics.laws.catalogue import make_controller
from robotics.simulation.scenario.reading import load_scenario
from robotics.simulation.loop import simulate

assert config.DISABLE_JIT
for law in sys.argv[2:]:
    simulate(load_scenario(sys.argv[1]), make_controller(law), (1, 2), message_ages=True).save(f"{law}.npz")
"""


@pytest.mark.long
def test_without_the_compiler_the_numbers_are_the_same(tmp_path):
    (tmp_path / "team.toml").write_text(TEAM, encoding="utf-8")
    laws = ("virtual-structure", "graph-esm")
    done = subprocess.run(
        [sys.executable, "-W", "error", "-c", PLAIN, "team.toml", *laws],
        cwd=tmp_path,
        env=os.environ | {"NUMBA_DISABLE_JIT": "1"},
        capture_output=True,
        text=True,
        timeout=240,
    )
    assert done.returncode == 0, done.stderr
    for law in laws:
        plain = load_run(tmp_path / f"{law}.npz")
        ours = simulate(parse_scenario(TEAM, "team"), make_controller(law), (1, 2), message_ages=True)
        np.testing.assert_allclose(plain.samples, ours.samples, rtol=0, atol=1e-12)
        np.testing.assert_allclose(plain.team, ours.team, rtol=0, atol=1e-12)
        np.testing.assert_array_equal(plain.message_ages, ours.message_ages)


def test_the_command_runs_a_team_and_refuses_a_wrong_one(tmp_path, capsys):
    good, bad = tmp_path / "good.toml", tmp_path / "bad.toml"
    good.write_text(TEAM, encoding="utf-8")
    bad.write_text(TEAM.replace("robot = 2", "robot = 7"), encoding="utf-8")
    save = tmp_path / "run.npz"
    assert main(["run", str(good), "-c", "cooperation", "--seeds", "2", "--save", str(save), "--json"]) == 0
    assert json.loads(capsys.readouterr().out)["seeds"] == [0, 1]
    run = load_run(save)
    ours = simulate(parse_scenario(TEAM, "good"), make_controller("cooperation"), (0, 1))
    assert same(run.samples, ours.samples)
    assert same(run.team, ours.team)
    assert main(["run", str(bad), "-c", "cooperation"]) == 2
    said = capsys.readouterr().err
    line = 1 + TEAM.replace("robot = 2", "robot = 7").splitlines().index("robot = 7")
    assert f"bad.toml:{line}: robot must be a robot, 1 to 3; got 7" in said
    assert "Traceback" not in said
