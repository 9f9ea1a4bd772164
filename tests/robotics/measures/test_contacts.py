"""Contacts between the samples: against shapely, Minkowski differences and closed forms; and runs that had some."""

from dataclasses import replace
from math import acos, cos, pi, sin, sqrt

import numpy as np
import pytest
import shapely
from hypothesis import given, settings
from hypothesis import strategies as st
from shapely import affinity

from robotics.laws.catalogue import make_controller
from robotics.measures.contacts import contacts, first_contact, judge, until_contact
from robotics.measures.registry import ALL_METRICS, measure_all
from robotics.simulation.channels import CHANNELS, RECORDS
from robotics.simulation.loop import drive, simulate
from robotics.simulation.run import About, Recorded, Run
from robotics.simulation.scenario.reading import load_scenario
from robotics.world.environment.collision import footprints, obstacle_clearance
from robotics.world.environment.swept import Watch, lower_bound, pose_between
from robotics.world.environment.world import Disc, Obstacle, Polygon, Wall, World, box, compile_world, regular, u_shape
from robotics.world.paths.path import Line
from robotics.world.paths.trajectory import Timing
from robotics.world.vehicle.plant import TruthColumns as Truth
from tests.robotics.world.vehicle.etsro import ETSRO

PERIOD = 0.05
LONG = replace(ETSRO, length=0.6, width=0.2)


def recorded(robots, poses, world=None, period=PERIOD, rates=None):
    """A run made by hand, of one seed.

    Args:
        robots: The robots.
        poses: (samples, robots, 3): x, y, heading.
        world: The obstacles.
        period: Between samples [s].
        rates: (samples, robots, 2): v, ω; by default 0, which fits no motion: robots go straight.
    """
    poses = np.asarray(poses, dtype=float)
    n, count = poses.shape[:2]
    samples = np.zeros((n, len(CHANNELS), 1, count))
    samples[:, :3, 0] = np.moveaxis(poses, -1, 1)
    if rates is not None:
        samples[:, 3:5, 0] = np.moveaxis(np.asarray(rates, dtype=float), -1, 1)
    time, obstacles = np.arange(n) * period, None
    if world is not None:
        placed = compile_world(world)
        obstacles = placed.rest
        if placed.motion is not None:
            seen = [placed.at(t) for t in time]
            obstacles = type(placed.rest)(*(np.concatenate(parts) for parts in zip(*seen, strict=True)))
    about = About("by-hand", "team", "nobody", "velocity", tuple(robots), ({},) * count)
    nodes = tuple(np.array([[0.0, 1.0], [0.0, 0.0]]) for _ in robots)
    record = {"samples": Recorded(samples, RECORDS["samples"].axes)}
    return Run(about, (0,), time, record, np.zeros((6, n, count)), nodes, np.full((1, count), -1), obstacles)


def rectangle(x, y, heading, robot):
    own = shapely.box(-robot.length / 2, -robot.width / 2, robot.length / 2, robot.width / 2)
    return affinity.translate(affinity.rotate(own, heading, (0, 0), use_radians=True), x, y)


def to_come_free(one, other):
    """The least distance by which a convex shape must be moved to come free of another: Minkowski's difference."""
    differences = np.array(one.exterior.coords)[:, None] - np.array(other.coords if hasattr(other, "coords") else 0)
    return shapely.MultiPoint(differences.reshape(-1, 2)).convex_hull.exterior.distance(shapely.Point(0, 0))


def gaps(robots, poses, world=None):
    """The signed clearances of all pairs at one time."""
    samples = np.zeros((5, 1, len(robots)))
    samples[:3, 0] = np.transpose(poses)
    return Watch.opened(robots, 0.0, samples, None if world is None else compile_world(world).at(0.0)).known.ends[0]


# Signed clearance --------------------------------------------------------------------------------------------------

near = st.floats(-0.7, 0.7)
angle = st.floats(-pi, pi)
size = st.floats(0.05, 0.8)


@settings(max_examples=60)
@given(near, near, angle, angle, size, size, size, size)
def test_two_robots(x, y, heading, other, length, width, length_2, width_2):
    robots = replace(ETSRO, length=length, width=width), replace(ETSRO, length=length_2, width=width_2)
    poses = ((0.1, -0.2, heading), (0.1 + x, -0.2 + y, other))
    one, two = (rectangle(*pose, robot) for pose, robot in zip(poses, robots, strict=True))
    (gap,) = gaps(robots, poses)
    if np.isnan(gap):  # circles apart: farther than anything of interest; but there is always a first look
        pytest.fail("not looked at")
    expected = one.distance(two) if not one.intersects(two) else -to_come_free(one, two.exterior)
    assert gap == pytest.approx(expected, abs=1e-9)


@settings(max_examples=60)
@given(near, near, angle, angle, st.sampled_from(["disc", "wall", "box", "regular", "star"]), st.integers(0, 10**6))
def test_a_robot_and_an_obstacle(x, y, heading, turn, form, seed):
    rng = np.random.default_rng(seed)
    robot = replace(ETSRO, length=float(rng.uniform(0.1, 0.8)), width=float(rng.uniform(0.1, 0.8)))
    body = rectangle(x, y, heading, robot)
    a, b = rng.uniform(0.05, 0.9, 2).tolist()
    obstacle: Obstacle
    if form == "disc":
        (gap,) = gaps([robot], [(x, y, heading)], World(obstacles=(Disc(radius=a),)))
        center = shapely.Point(0, 0)
        outside = body.distance(center) if not body.contains(center) else -body.exterior.distance(center)
        assert gap == pytest.approx(outside - a, abs=1e-9)
        return
    if form == "wall":
        ends = tuple((float(u), float(w)) for u, w in rng.uniform(-0.8, 0.8, (2, 2)))
        shape, obstacle = shapely.LineString(ends), Wall(points=ends)
    else:
        n = int(rng.integers(3, 9))
        angles, away = 2 * pi * np.arange(n) / n, rng.uniform(0.1, 0.8, n)
        corners = {
            "box": box(a, b),
            "regular": regular(n, a),
            "star": tuple((float(r * cos(q)), float(r * sin(q))) for r, q in zip(away, angles, strict=True)),
        }[form]
        obstacle = Polygon(corners=corners, heading=turn)
        shape = affinity.rotate(shapely.Polygon(corners), turn, (0, 0), use_radians=True)
    (gap,) = gaps([robot], [(x, y, heading)], World(obstacles=(obstacle,)))
    if not body.intersects(shape):
        assert gap == pytest.approx(body.distance(shape), abs=1e-9)
    elif form != "star" or shape.convex_hull.area < shape.area * (1 + 1e-9):
        assert gap == pytest.approx(-to_come_free(body, shape if form == "wall" else shape.exterior), abs=1e-9)
    else:  # a lower bound: moved by less in any direction, they still overlap
        assert gap <= 0
        for q in np.linspace(0, 2 * pi, 24, endpoint=False):
            moved = affinity.translate(body, -0.999 * gap * cos(q), -0.999 * gap * sin(q))
            assert moved.intersects(shape)


def test_deep_in_a_u_a_robot_across_its_bottom_is_measured_by_the_bottom():
    u = World(obstacles=(Polygon(corners=u_shape(2.0, 1.0, 0.05)),))  # its bottom is at x from 0.5 to 0.55
    # Each of its sides asks for 0.275 m; to come free of both it is 0.325 m.
    assert gaps([LONG], [(0.525, 0.0, 0.0)], u) == pytest.approx([-0.275])
    assert gaps([LONG], [(0.1, 0.0, 0.0)], u) == pytest.approx([0.1])


def test_touching_is_contact_at_a_sample():
    robots = [replace(ETSRO, length=1.0, width=0.5)] * 2  # sides that binary numbers hold
    (touch,) = contacts(recorded(robots, [[(0, 0, 0), (1.0, 0, 0)]] * 2))
    assert (touch.depth, touch.start, touch.end) == (0.0, 0.0, PERIOD)
    assert not contacts(recorded(robots, [[(0, 0, 0), (1.001, 0, 0)]] * 2))


# Between samples ---------------------------------------------------------------------------------------------------


def test_no_robot_gets_through_a_thin_wall_unseen():
    """1.1 m/s is 55 mm a period; a robot 20 mm long clears a box of 5 mm, and a wall, between two samples."""
    small, speed = replace(ETSRO, length=0.02, width=0.02), 1.1
    x = -0.2 + speed * PERIOD * np.arange(9) + 0.006
    poses, rates = [[(u, 0, 0)] for u in x], [[(speed, 0)]] * len(x)
    thin = World(obstacles=(Polygon(corners=box(0.005, 1.0)), Wall(points=((0.12, -1.0), (0.12, 1.0)))))
    for moving in (rates, None):
        run = recorded([small], poses, thin, rates=moving)
        at_samples = obstacle_clearance(
            run["x"][0].T, run["y"][0].T, run["heading"][0].T, footprints([small]), run.obstacles
        )
        assert (at_samples > 0).all()  # every sample is free
        first, second = contacts(run)
        assert (first.robot, first.other, first.obstacle, second.obstacle) == (0, None, 0, 1)
        for contact, near_side, far_side in ((first, -0.0025, 0.0025), (second, 0.12, 0.12)):
            assert contact.start == pytest.approx((near_side - 0.01 - x[0]) / speed, abs=1e-5)
            assert contact.end == pytest.approx((far_side + 0.01 - x[0]) / speed, abs=1e-5)
        assert first.depth == pytest.approx(0.0125, abs=2e-4)
        assert (first.x, first.y) == pytest.approx((-0.0025, 0.0), abs=2e-3)
        assert (second.x, second.y) == pytest.approx((0.12, 0.0), abs=1e-3)
        assert judge(run).counts.tolist() == [[2]]


def test_two_robots_that_swap_places_within_one_period_met():
    """Each sample shows them 0.8 m apart; they go through each other in the middle of the period."""
    robots = [LONG, ETSRO]
    run = recorded(robots, [[(0, 0, 0), (0.8, 0, 0)], [(0.8, 0, 0), (0, 0, 0)]])
    (contact,) = contacts(run)
    reach = (LONG.length + ETSRO.length) / 2
    assert (contact.robot, contact.other, contact.obstacle) == (0, 1, None)
    assert contact.start == pytest.approx(PERIOD * (0.8 - reach) / 1.6, abs=1e-5)
    assert contact.end == pytest.approx(PERIOD * (0.8 + reach) / 1.6, abs=1e-5)
    assert contact.depth == pytest.approx((LONG.width + ETSRO.width) / 2, abs=2e-4)  # moved aside
    assert first_contact(run) == pytest.approx([contact.start])


def test_a_disc_that_passes_a_corner_touches_it_only_if_it_comes_near_enough():
    """Past the corner (0.3, 0.1) at 45°, 1 m/s, in the middle of a period; its distance is a square root."""
    for beside, touches in ((0.0495, True), (0.0505, False)):
        u = np.array([1, -1]) / sqrt(2)
        passing = np.array([0.3, 0.1]) + (0.05 + beside) * np.array([1, 1]) / sqrt(2)
        start, end = passing - 0.525 * u, passing + 0.525 * u
        path = Line(start=(float(start[0]), float(start[1])), end=(float(end[0]), float(end[1])))
        disc = Disc(radius=0.1, path=path, timing=Timing(speed=1.0))
        run = recorded([LONG], [[(0, 0, 0)]] * 22, World(obstacles=(disc,)))
        assert judge(run).least[0, 0] == pytest.approx(beside - 0.05, abs=2e-5)
        found = contacts(run)
        assert len(found) == touches
        if touches:
            half = sqrt(0.1**2 - 0.0995**2)
            assert (found[0].start, found[0].end) == pytest.approx((0.525 - half, 0.525 + half), abs=2e-4)
            assert (found[0].x, found[0].y) == pytest.approx((0.3, 0.1), abs=0.02)


def test_a_turning_robot_strikes_with_its_corner_between_two_samples():
    """It turns by 2 rad/s·1 s; its corner sweeps over a wall that both samples, 1 s apart, leave free."""
    corner = float(np.hypot(LONG.length, LONG.width)) / 2
    wall = World(obstacles=(Wall(points=((-1.0, corner - 0.001), (1.0, corner - 0.001))),))
    first, last = pi / 2 - 1.3, pi / 2 + 1.3
    run = recorded([LONG], [[(0, 0, first)], [(0, 0, last)]], wall, 1.0, rates=[[(0, 2.6)], [(0, 2.6)]])
    front_left, front_right = np.arctan2(LONG.width, LONG.length), -np.arctan2(LONG.width, LONG.length)
    found = contacts(run)
    half = acos((corner - 0.001) / corner)
    expected = sorted((pi / 2 - mount - half - first) / 2.6 for mount in (front_left, front_right))
    assert [c.start for c in found] == pytest.approx(expected, abs=1e-4)
    assert judge(run).least[0, 0] == pytest.approx(-0.001, abs=1e-4)


def test_a_robot_on_a_circle_follows_its_arc_and_not_the_chord():
    """1 m/s on a circle of 0.2 m at 0.1 s: the arc bulges by 6 mm; headings kept within one turn do not spin it."""
    radius, step = 0.2, 0.1
    turned = 3.0 + 5.0 * step * np.arange(4)
    wrapped = (turned + pi) % (2 * pi) - pi
    poses = [[(radius * sin(h), -radius * cos(h), w)] for h, w in zip(turned, wrapped, strict=True)]
    tiny = replace(ETSRO, length=0.002, width=0.002)
    run = recorded([tiny], poses, World(obstacles=(Disc(radius=radius - 0.01),)), step, rates=[[(1.0, 5.0)]] * 4)
    assert judge(run).least[0, 0] == pytest.approx(0.01 - 0.001, abs=1e-4)
    at = pose_between(step, run.samples[0, :5, 0], run.samples[1, :5, 0], 0.5)[:, 0]
    assert np.hypot(*at[:2]) == pytest.approx(radius, abs=1e-4)
    assert at[2] == pytest.approx(turned[0] + 0.25, abs=1e-3)


@settings(max_examples=40)
@given(st.integers(0, 10**6))
def test_the_least_clearance_is_that_of_a_fine_grid(seed):
    """Random samples far apart: 4000 poses a period, in between none is nearer by more than they move."""
    rng = np.random.default_rng(seed)
    robots = [replace(ETSRO, length=float(a), width=float(b)) for a, b in rng.uniform(0.05, 0.6, (2, 2))]
    poses = np.concatenate([rng.uniform(-0.8, 0.8, (3, 2, 2)), rng.uniform(-3, 3, (3, 2, 1))], axis=-1)
    heading = poses[..., 2]
    chord = np.diff(poses, axis=0)[[0, 1, 1]]
    rates = np.stack([np.hypot(*np.moveaxis(chord[..., :2], -1, 0)), chord[..., 2]], axis=-1) / PERIOD
    rates[..., 0] *= np.cos(np.arctan2(chord[..., 1], chord[..., 0]) - heading)
    corners = tuple(
        (float(r * cos(q)), float(r * sin(q)))
        for r, q in zip(rng.uniform(0.1, 0.5, 5), 2 * pi * np.arange(5) / 5, strict=True)
    )
    world = World(obstacles=(Polygon(corners=corners), Wall(points=((0.5, -0.6), (0.5, 0.6)))))
    run = recorded(robots, poses, world, rates=rates)
    fine = np.concatenate(
        [
            [pose_between(PERIOD, run.samples[k, :5, 0], run.samples[k + 1, :5, 0], s).T for s in np.arange(400) / 400]
            for k in (0, 1)
        ]
    )
    dense = judge(recorded(robots, fine, world, PERIOD / 400)).least
    moved = np.abs(np.diff(fine, axis=0)).max() * 3
    least = judge(run).least
    assert (least <= dense + 2e-4).all()
    assert (least >= dense - moved).all()
    starts = [c.start for c in contacts(run)], [c.start for c in contacts(recorded(robots, fine, world, PERIOD / 400))]
    assert first_contact(run) == pytest.approx([min(starts[1], default=np.inf)], abs=1e-3)


@given(st.floats(0.001, 3), st.floats(-3, 3), st.floats(0.0, 2.0), st.floats(-2, 2), st.floats(-1, 1))
def test_no_distance_of_two_moving_points_is_below_its_bound(x, y, speed, bend, course):
    """A point on a parabola passes the origin: |r'| and |r''| are known, the distance at 200 shares is above."""
    u = np.linspace(0, 1, 201)
    px, py = x + speed * cos(course) * u + bend * u**2 / 2, y + speed * sin(course) * u
    gap = np.hypot(px, py)
    fastest = np.hypot(speed * cos(course) + bend * u, speed * sin(course)).max()
    assert lower_bound(gap[0], gap[-1], 1.0, fastest, abs(bend)) <= gap.min() + 1e-12


def test_a_robot_that_is_stopped_touches_nothing_any_more():
    poses = np.array([[(0.0, 0, 0), (0.1 * k, 0, 0)] for k in range(8)])
    poses[4:, 0] = np.nan
    robots = [replace(ETSRO, length=0.1, width=0.1)] * 2
    (contact,) = contacts(recorded(robots, poses))
    assert (contact.start, contact.end) == pytest.approx((0.0, PERIOD), abs=1e-6)
    poses[1:, 0] = np.nan
    (contact,) = contacts(recorded(robots, poses))
    assert (contact.start, contact.end) == (0.0, 0.0)


def test_a_robot_that_appears_is_judged_at_the_sample_with_which_it_does():
    """The other one drives past the place before; and a wall stands beside it."""
    poses = np.array([[(0.0, 0, 0), (-0.3 + 0.2 * k, 0, 0)] for k in range(8)])
    poses[:4, 0] = np.nan  # at sample 4 the other one is 0.5 m ahead
    robots = [replace(ETSRO, length=0.1, width=0.1)] * 2
    wall = World(obstacles=(Wall(points=((-1.0, -0.1), (1.0, -0.1))),))
    run = recorded(robots, poses, wall)
    assert not contacts(run)
    assert judge(run).least.tolist() == [[pytest.approx(0.05), pytest.approx(0.05)]]
    poses[:, 1, 0] -= 0.45
    (contact,) = contacts(recorded(robots, poses, wall))
    assert contact.start == pytest.approx(4 * PERIOD)
    assert contact.end == pytest.approx(4 * PERIOD + 0.05 / 0.2 * PERIOD, abs=1e-6)


# Runs --------------------------------------------------------------------------------------------------------------


@pytest.fixture(scope="module")
def blind():
    """A law that ignores obstacles and robots, where paths lead into both."""
    return simulate(load_scenario("obstacles-on-two-paths"), make_controller("cooperation"), range(3))


def test_the_watch_of_a_simulation_as_it_goes_on_says_what_its_run_says(blind):
    setting = load_scenario("obstacles-on-two-paths").setting
    watch, ended = None, list[np.ndarray]()
    for state in drive(setting, make_controller("cooperation"), range(3)):
        poses, here = state.truth[: Truth.w.row + 1], setting.world.at(state.time)
        if watch is None:
            watch = Watch.opened(setting.robots, state.time, poses, here)
            begin = watch
        else:
            watch, rows = watch.to(state.time, poses, here)
            ended.extend(rows)
    assert begin.time == 0.0
    assert np.isinf(begin.known.first).all()  # a state that stays as it was
    judged = judge(blind)
    np.testing.assert_array_equal(watch.known.first.min(axis=(0, 2)), judged.first)
    np.testing.assert_array_equal(watch.known.counts, judged.counts)
    np.testing.assert_array_equal(watch.known.least.min(axis=0), judged.least)
    assert sorted(map(tuple, [*ended, *watch.open_contacts()])) == sorted(map(tuple, judged.episodes))


def test_a_run_is_judged_alike_whichever_runs_are_beside_it(blind):
    alone, all_three = judge(blind.only(2)), judge(blind)
    np.testing.assert_array_equal(alone.least[0], all_three.least[2])
    np.testing.assert_array_equal(alone.counts[0], all_three.counts[2])
    assert len(contacts(blind, 2)) == len(alone.episodes) > 0
    np.testing.assert_array_equal(first_contact(blind), all_three.first)


def test_the_first_contacts_of_a_crowd_are_those_of_all():
    """Six robots that wander in half a metre, beside a disc that moves: the first 20 contacts, ends and depths too."""
    rng = np.random.default_rng(3)
    poses = rng.normal(size=(400, 6, 3)).cumsum(axis=0) * 0.02
    path = Line(start=(-1.0, 0.3), end=(3.0, 0.3))
    run = recorded([ETSRO] * 6, poses, World(obstacles=(Disc(radius=0.1, path=path, timing=Timing(speed=0.3)),)))
    everything = contacts(run)
    assert len(everything) > 40
    assert {contact.obstacle for contact in everything} == {None, 0}
    assert contacts(run, most=20) == everything[:20]
    assert contacts(run, most=10**6) == everything


def test_what_comes_after_a_contact_is_no_result(blind):
    """Measured by hand on the samples up to the first contact, and on the whole run for the contacts themselves."""
    values, judged = measure_all(blind), judge(blind)
    assert np.isfinite(judged.first).all()
    np.testing.assert_array_equal(values["contacts"], judged.counts)
    np.testing.assert_array_equal(values["min_clearance_m"], judged.least)
    assert (values["min_clearance_m"][:, 0] < -0.1).all()
    assert np.isinf(values["arrival_time_s"]).all()  # arrivals after it are none, of its other robots neither
    for place, first in enumerate(judged.first):
        before = blind.time <= first
        effort = blind["torque_variation"][place][:, before]
        seconds = (before.sum() - 1) * PERIOD
        np.testing.assert_allclose(values["torque_variation_nmps"][place], effort[:, -1] / seconds, rtol=1e-9)
        x, y = (blind[name][place][:, before] for name in "xy")
        closest = min(np.hypot(x[i] - x[j], y[i] - y[j]).min() for i, j in ((0, 1), (0, 2), (1, 2)))
        assert values["min_distance_m"][place].min() == pytest.approx(closest)


def test_a_run_without_contact_keeps_every_number_and_its_neighbour_changes_none(blind):
    free = simulate(load_scenario("two-meetings"), make_controller("right-of-way"), range(2))
    values, judged = measure_all(free), judge(free)
    assert np.isinf(judged.first).all()
    assert not values["contacts"].any()
    assert (values["min_clearance_m"] > 0).all()
    assert until_contact(free, judged.first) is free
    assert values["arrival_time_s"].tolist() == ALL_METRICS["arrival_time_s"].measure(free).tolist()
    one, all_three = measure_all(blind.only(1)), measure_all(blind)
    for name, found in one.items():
        np.testing.assert_array_equal(found[0], all_three[name][1], err_msg=name)


def test_one_robot_in_an_empty_world_has_nothing_to_touch():
    run = simulate(load_scenario("reference"), make_controller("lyapunov"))
    assert not {"contacts", "min_clearance_m"} & set(measure_all(run))
    assert not contacts(run)
    formation = simulate(load_scenario("formation-ahead"), make_controller("formation-teacher"))
    assert {"contacts", "min_clearance_m"} <= set(measure_all(formation))
