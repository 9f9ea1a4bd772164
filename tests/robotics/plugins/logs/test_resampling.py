"""Drives on a grid of times, against closed forms."""

import numpy as np
import pytest

from robotics.plugins.logs.drive import Commands, Drive, PlannedPath, Track
from robotics.plugins.logs.drivedata import pieces
from robotics.plugins.logs.typestore import LogError

RADIUS, RATE = 0.5, 0.8  # m, rad/s: a circle, driven three times round


def on_circle(time):
    """x, y, heading, v, w on the circle, the heading as it grows."""
    turned = RATE * time
    still = np.ones_like(time)
    return RADIUS * np.sin(turned), RADIUS * (1 - np.cos(turned)), turned, RADIUS * RATE * still, RATE * still


def drive(seen, given, v, w=None, reference=None, plans=()):
    posture = on_circle(seen)
    track = Track(seen, posture[0], posture[1], np.unwrap((posture[2] + np.pi) % (2 * np.pi) - np.pi), *posture[3:])
    commands = Commands(given, v, np.zeros_like(v) if w is None else w)
    return Drive("bag", "", track, commands, reference, plans, {"odometry": "/odom", "commands": "/cmd_vel"}, {})


def jittered(end, rate, seed, jitter=0.3):
    rng = np.random.default_rng(seed)
    return np.sort((np.arange(0.0, end, 1 / rate)) + jitter / rate * rng.uniform(0, 1, int(np.ceil(end * rate))))


def test_odometry_at_30_hz_and_commands_at_20_hz_with_jitter_make_a_grid_of_50_ms():
    seen, given = jittered(20.0, 30.0, 1), jittered(20.0, 20.0, 2)
    order = np.arange(1.0, len(given) + 1)
    (piece,) = pieces(drive(seen, given, order))
    np.testing.assert_allclose(np.diff(piece.time), 0.05, atol=1e-12)
    at = piece.start + piece.time
    x, y, heading, v, w = on_circle(at)
    sagitta = RADIUS * (1 - np.cos(RATE * np.diff(seen).max() / 2))  # a chord is no farther from its arc
    assert sagitta < 2e-4
    np.testing.assert_allclose(np.hypot(piece.x - x, piece.y - y), 0.0, atol=sagitta)
    np.testing.assert_allclose(piece.heading, heading, atol=1e-9)  # three turns, without a jump
    assert piece.heading[-1] > 4 * np.pi
    np.testing.assert_allclose(piece.v, v, atol=1e-12)
    np.testing.assert_allclose(piece.w, w, atol=1e-12)
    last = [given[given <= t + 1e-6].size for t in at]  # the number of the command that was given last
    np.testing.assert_array_equal(piece.v_commanded, last)


def test_samples_on_the_grid_are_taken_as_they_are():
    time = np.arange(60) * 0.05  # whose multiples are not quite those of the grid
    (piece,) = pieces(drive(time, time, np.arange(1.0, 61.0)))
    np.testing.assert_array_equal(piece.v_commanded, np.arange(1.0, 61.0))
    np.testing.assert_allclose(piece.x, on_circle(time)[0], atol=1e-15)


def test_a_command_holds_until_the_next_and_not_longer_than_the_gap():
    seen = np.arange(0.0, 4.0, 0.02)
    given, v = np.array([0.5, 0.9, 3.0]), np.array([1.0, 2.0, 3.0])
    one, two = pieces(drive(seen, given, v))
    times = [p.start + p.time for p in (one, two)]
    assert times[0][0] == pytest.approx(0.5)
    assert times[0][-1] == pytest.approx(1.4)  # 0.5 s after the last of them
    assert set(one.v_commanded[times[0] < 0.9 - 1e-9]) == {1.0}
    assert set(one.v_commanded[times[0] > 0.9 - 1e-9]) == {2.0}
    assert times[1][0] == pytest.approx(3.0)
    assert times[1][-1] == pytest.approx(3.5)


def test_a_gap_in_the_odometry_cuts_the_drive():
    seen = np.concatenate([np.arange(0.0, 2.0, 0.03), np.arange(2.8, 5.0, 0.03)])
    given = np.arange(0.0, 5.0, 0.05)
    parts = pieces(drive(seen, given, np.ones_like(given)))
    assert len(parts) == 2
    edges = [(p.start + p.time[0], p.start + p.time[-1]) for p in parts]
    assert edges[0][1] <= 1.98 + 1e-9
    assert edges[1][0] >= 2.8 - 1e-9
    assert len(pieces(drive(seen, given, np.ones_like(given)), gap=0.9)) == 1


def test_the_delay_pairs_a_posture_with_a_later_command():
    time = np.arange(100) * 0.05
    (piece,) = pieces(drive(time, time, np.arange(1.0, 101.0)), delay=0.1)
    np.testing.assert_array_equal(piece.v_commanded[:5], [3.0, 4.0, 5.0, 6.0, 7.0])
    assert piece.x[0] == pytest.approx(0.0)


def test_what_stands_still_before_and_after_is_left_out():
    time = np.arange(100) * 0.05
    v = np.where((time > 1.0) & (time < 3.0), 0.4, 0.0)
    (piece,) = pieces(drive(time, time, v))
    assert (piece.v_commanded == 0.4).all()
    (whole,) = pieces(drive(time, time, v), whole=True)
    assert len(whole.time) >= 100
    with pytest.raises(LogError, match="/cmd_vel commands nothing but to stand still"):
        pieces(drive(time, time, 0 * v))


def test_another_path_begins_another_piece():
    time = np.arange(100) * 0.05
    plans = (PlannedPath(0.0, np.zeros((2, 2))), PlannedPath(2.0, np.ones((2, 2))))
    one, two = pieces(drive(time, time, np.ones(100), plans=plans))
    assert (one.plan, two.plan) == plans
    assert two.start + two.time[0] == pytest.approx(2.0)


def test_velocities_that_the_odometry_does_not_tell_are_those_of_its_postures():
    time = np.arange(100) * 0.02
    made = drive(time, time, np.ones(100))
    none = np.full(100, np.nan)
    silent = Drive(made.log, "", made.odometry._replace(v=none, w=none), made.commands, None, (), made.topics, {})
    (piece,) = pieces(silent)
    np.testing.assert_allclose(piece.v[1:-1], RADIUS * RATE, rtol=1e-4)
    np.testing.assert_allclose(piece.w, RATE, rtol=1e-9)


@pytest.mark.parametrize(
    ("options", "said"),
    [
        ({"period": 0.0}, "period must be a number of seconds from 0.001 to 60, got 0"),
        ({"period": 0.2, "gap": 0.1}, "gap must be a number of seconds from 0.2 to 60, got 0.1"),
        ({"delay": -1.0}, "delay must be a number of seconds from 0 to 60, got -1"),
        ({"period": float("nan")}, "period must be a number"),
    ],
)
def test_numbers_that_cannot_be_are_refused(options, said):
    time = np.arange(100) * 0.05
    with pytest.raises(LogError, match=said):
        pieces(drive(time, time, np.ones(100)), **options)


def test_topics_that_do_not_overlap_are_refused():
    time = np.arange(100) * 0.05
    with pytest.raises(LogError, match=r"/odom \(from 0.000 to 4.950 s\) and /cmd_vel \(from 50.000 to 54.950 s\) do"):
        pieces(drive(time, time + 50.0, np.ones(100)))
