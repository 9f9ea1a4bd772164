"""Formations by offsets: circles in closed form, any path against T(ψ_0) l_i itself, and what cannot be driven."""

import numpy as np
import pytest

from robotics.laws.catalogue import make_controller
from robotics.measures.arrival import arrival_time, spread
from robotics.simulation.loop import simulate
from robotics.simulation.scenario.description import ScenarioError
from robotics.simulation.scenario.reading import load_scenario, parse_scenario
from robotics.world.paths.offset import Offset, compile_offset, offset_start
from robotics.world.paths.path import Circle, Line, PathError, Quintic, Sine, Waypoints, compile_path
from robotics.world.paths.trajectory import Timing, compile_trajectory, together
from tests.robotics.laws.rules.arrayform.neighbours import level_places, stretches

TIMING = Timing(duration=20.0, ramp=2.0)
CURVES = (
    Sine(amplitude=0.5, wavenumber=1.2, x_end=6.0),
    Quintic(start=(0.0, 0.0), end=(5.0, 2.0), start_slope=0.5),
    Waypoints(points=((0.0, 0.0), (2.0, 1.0), (4.0, 0.5), (6.0, 2.0))),
)


@pytest.mark.parametrize("direction", ["counter-clockwise", "clockwise"])
@pytest.mark.parametrize(("ahead", "left"), [(0.0, 0.4), (0.0, -0.7), (0.5, 0.3)])
def test_a_circle_gives_a_circle_of_another_radius_at_another_speed(direction, ahead, left):
    """Radius √((R − l_left)² + l_ahead²), and speeds as the radii; clockwise the left is outside."""
    circle = Circle(radius=2.0, direction=direction)
    side = 1.0 if direction == "counter-clockwise" else -1.0
    radius = np.hypot(2.0 - side * left, ahead)
    timing = Timing(duration=20.0)
    found = compile_offset(Offset(path=circle, offset=(ahead, left)), timing)
    assert found.ends[0] == 20.0
    assert found.paths[0].length == pytest.approx(2 * np.pi * radius, rel=1e-9)
    np.testing.assert_allclose(found.paths[0].table[3], side / radius, rtol=2e-5)
    times = np.linspace(0.0, 19.99, 57)
    reference, virtual = found.sampled(times), compile_trajectory((compile_path(circle),), (timing,)).sampled(times)
    np.testing.assert_allclose(reference.v / virtual.v, radius / 2.0, rtol=1e-9)
    np.testing.assert_allclose(reference.w, virtual.w, rtol=2e-5)
    np.testing.assert_allclose(np.hypot(reference.x, reference.y), radius, atol=1e-8)
    lead = np.arctan2(side * ahead / 2.0, 1 - side * left / 2.0)
    np.testing.assert_allclose(reference.heading - virtual.heading, lead, atol=1e-8)


@pytest.mark.parametrize("curve", CURVES)
@pytest.mark.parametrize("timing", [TIMING, Timing(x_rate=0.25, start=0.3)])
def test_the_reference_is_q_0_plus_t_l_at_every_time(curve, timing):
    """Thesis (3.3) as corrected, and speeds and turn rates by finite differences of it."""
    ahead, left = 0.3, -0.35
    trajectory = compile_offset(Offset(path=curve, offset=(ahead, left)), timing)
    virtual = compile_trajectory((compile_path(curve),), (timing,))
    times = np.linspace(0.01, virtual.ends[0] - 0.01, 301)

    def wanted(t):
        q = virtual.sampled(t)
        cos, sin = np.cos(q.heading), np.sin(q.heading)
        return np.stack([q.x + cos * ahead - sin * left, q.y + sin * ahead + cos * left])[..., 0]

    q = trajectory.sampled(times)
    np.testing.assert_allclose(np.stack([q.x, q.y])[..., 0], wanted(times), atol=2e-5)
    velocity = (wanted(times + 1e-3) - wanted(times - 1e-3)) / 2e-3
    np.testing.assert_allclose(q.v[:, 0], np.hypot(*velocity), atol=2e-3)
    heading = np.arctan2(velocity[1], velocity[0])
    assert np.abs(np.angle(np.exp(1j * (heading - q.heading[:, 0])))).max() < 6e-3
    turned = np.gradient(np.unwrap(q.heading[:, 0]), times)
    # Where a spline's third derivative jumps, so does the turn rate: there the difference is half the jump.
    assert np.quantile(np.abs(turned - q.w[:, 0])[2:-2], 0.98) < 0.01
    assert trajectory.ends == virtual.ends


def test_robots_that_are_level_have_the_same_progress():
    curve = CURVES[0]
    offsets = ((0.0, 0.6), (0.0, -0.6), (0.4, 0.0))
    parts = [compile_offset(Offset(path=curve, offset=place), TIMING) for place in offsets]
    team = together(parts)
    paths = team.joined
    assert np.ptp(paths.lengths) > 0.1
    for time in (0.0, 3.0, 9.7, 15.0, 20.0):
        s = team.at(time).s[None]
        share = paths.share(s)
        virtual = compile_trajectory((compile_path(curve),), (TIMING,)).at(time).s / compile_path(curve).length
        np.testing.assert_allclose(share, np.full((1, 3), virtual[0]), atol=1e-5)
        np.testing.assert_allclose(paths.place(share), s, atol=1e-9)
        np.testing.assert_allclose(level_places(paths, s), np.broadcast_to(s, (1, 3, 3)), atol=2e-4)
        step = 1e-3
        if 0 < time < 20:
            slope = (paths.place(share + step) - paths.place(share - step)) / (2 * step)
            np.testing.assert_allclose(stretches(paths, share), slope, rtol=1e-3)
    assert all(path.shares is not None for path in paths.paths)
    # Shares of the own lengths differ by far more: a law that equals them bends the formation.
    middle = team.at(9.7).s / paths.lengths
    assert np.ptp(middle) > 0.01


def test_ordinary_paths_have_the_shares_of_their_lengths_to_the_last_bit():
    paths = [compile_path(c) for c in (CURVES[0], Line(start=(0.0, 0.0), end=(3.0, 0.0)))]
    table = compile_trajectory(tuple(paths), (TIMING, TIMING)).joined
    s = np.array([[0.7, 0.3], [1.0, 2.0]])
    assert table.shares is None
    np.testing.assert_array_equal(table.share(s), s / table.lengths)
    np.testing.assert_array_equal(table.place(s), s * table.lengths)
    np.testing.assert_array_equal(level_places(table, s)[:, 0, 1], s[:, 0] / table.lengths[0] * table.lengths[1])


def test_an_offset_beyond_the_center_of_curvature_is_refused():
    circle = Circle(radius=1.0)
    with pytest.raises(PathError, match=r"offset: 1.2 m to the left reaches the center of curvature .* < 1 m"):
        compile_offset(Offset(path=circle, offset=(0.0, 1.2)), TIMING)
    compile_offset(Offset(path=circle, offset=(0.0, -1.2)), TIMING)  # outside there is room
    with pytest.raises(PathError, match=r"to the right .* cusp"):
        compile_offset(Offset(path=Circle(radius=1.0, direction="clockwise"), offset=(0.3, -1.0)), TIMING)
    bent = Sine(amplitude=0.5, lead_in=1.0, phase=np.pi / 2, x_end=3.0)  # the curvature jumps from 0 to 1/2
    with pytest.raises(PathError, match=r"0.4 m ahead gives the robot's path a corner of 0.197 rad"):
        compile_offset(Offset(path=bent, offset=(0.4, 0.0)), TIMING)
    compile_offset(Offset(path=bent, offset=(0.0, 0.4)), TIMING)  # beside it there is none
    with pytest.raises(PathError, match="two finite numbers"):
        Offset(path=circle, offset=(np.nan, 0.0))


# Scenario files ---------------------------------------------------------------------------------------------------

FILE = """kind = "team"
duration = 30.0
[virtual]
path = { shape = "circle", radius = 2.0 }
timing = { duration = 25.0 }
[[robots]]
offset = [0.0, 0.5]
[[robots]]
offset = [0.5, -0.5]
start = [2.0, 0.0, 1.0]
"""


def test_a_file_gives_each_robot_its_path_and_its_place():
    scenario = parse_scenario(FILE, "two")
    np.testing.assert_allclose(scenario.starts, [[1.5, 0.0, np.pi / 2], [2.0, 0.0, 1.0]], atol=1e-6)
    np.testing.assert_allclose(
        [p.length for p in scenario.trajectory.paths], 2 * np.pi * np.hypot([1.5, 2.5], [0, 0.5])
    )
    shape = scenario.robots[1].path
    assert isinstance(shape, Offset)
    assert offset_start(shape, scenario.robots[1].timing) == pytest.approx((2.5, 0.5, np.pi / 2 + np.arctan(0.2)))


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        ("[0.0, 0.5]", "[0.0, 2.5]", r"f\.toml:7: offset: 2.5 m to the left reaches the center of curvature"),
        ("[0.0, 0.5]", "[0.5]", r"f\.toml:7: offset must be 2 finite numbers \[ahead, left\] in m.*got \[0.5\]"),
        ("[0.0, 0.5]", '"left"', r"f\.toml:7: offset must be 2 finite numbers"),
        (
            "offset = [0.0, 0.5]",
            "offset = [0.0, 0.5]\ntiming = { speed = 1.0 }",
            r":8: give offset or timing, not",
        ),
        ("radius = 2.0", "radius = -2.0", r"f\.toml:4: radius must be a finite number in m, > 0"),
        ("duration = 25.0", "speed = 0.1, duration = 25.0", r"f\.toml:5: timing: give exactly one of"),
        ("timing = { duration = 25.0 }", "", r"f\.toml:3: the virtual robot needs a timing"),
        ("timing = {", "tming = {", r"f\.toml:5: .*tming.*timing"),
        (
            "offset = [0.5, -0.5]\nstart = [2.0, 0.0, 1.0]",
            "start = [2.0, 0.0, 1.0]",
            r":8: a robot needs a path",
        ),
    ],
)
def test_what_is_wrong_is_said_with_its_line(old, new, message):
    with pytest.raises(ScenarioError, match=message):
        parse_scenario(FILE.replace(old, new), "f", "f.toml")


def test_a_virtual_robot_alone_and_an_offset_alone_are_refused():
    alone = FILE[: FILE.index("[virtual]")] + FILE[FILE.index("[[robots]]") :]
    with pytest.raises(ScenarioError, match=r"f\.toml:4: an offset needs a table \[virtual\]"):
        parse_scenario(alone, "f", "f.toml")
    robot = '[[robots]]\nstart = [0.0, 0.0, 0.0]\npath = { shape = "line", start = [0.0, 0.0], end = [1.0, 0.0] }\n'
    own = FILE[: FILE.index("[[robots]]")] + (robot + "timing = { duration = 25.0 }\n") * 2
    with pytest.raises(ScenarioError, match=r"f\.toml:3: no robot has an offset"):
        parse_scenario(own, "f", "f.toml")


# Runs -------------------------------------------------------------------------------------------------------------


KEEPERS = ("virtual-structure", "virtual-structure-measured", "graph-esm", "cooperation", "fuzzy")


def offsets_of(scenario):
    shapes = [member.path for member in scenario.robots]
    assert all(isinstance(shape, Offset) for shape in shapes)
    return np.array([shape.offset for shape in shapes if isinstance(shape, Offset)])


def sides(run, offsets):
    """How far the distances between the robots are off those of the formation [m], the largest of all times."""
    places = np.stack([run["x"], run["y"]], axis=-1)
    gaps = np.linalg.norm(places[:, :, None] - places[:, None], axis=-1)
    wanted = np.linalg.norm(offsets[:, None] - offsets[None], axis=-1)
    return np.abs(gaps - wanted[:, :, None]).max()


@pytest.mark.parametrize(
    "law", ["virtual-structure", "virtual-structure-measured", "graph-esm", "cooperation", "fuzzy"]
)
def test_robots_keep_the_shape_of_the_triangle(law):
    """Five seeds with 3 mm of noise: the sides, 1, 1 and 0.9 m, are off by less than 2 cm at any time."""
    scenario = load_scenario("formation-triangle")
    offsets = offsets_of(scenario)
    run = simulate(scenario, make_controller(law), range(5))
    assert sides(run, offsets) < 0.02
    assert spread(arrival_time(run)).max() < 0.3


def test_a_law_that_equals_shares_of_lengths_would_bend_it(monkeypatch):
    scenario = load_scenario("formation-triangle")
    offsets = offsets_of(scenario)
    monkeypatch.setattr("robotics.world.paths.joined.PathTable.share", lambda self, s: s / self.lengths)
    monkeypatch.setattr("robotics.world.paths.joined.PathTable.place", lambda self, share: share * self.lengths)
    road = scenario.trajectory.road._replace(shares=np.empty((2, 0)))
    monkeypatch.setitem(vars(scenario.trajectory), "road", road)
    assert sides(simulate(scenario, make_controller("virtual-structure-measured"), [0]), offsets) > 0.05
