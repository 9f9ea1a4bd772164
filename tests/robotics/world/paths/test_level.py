"""Level places on closed paths, on paths by offsets, and beyond the beginning of a reference."""

from math import pi

import numpy as np
import pytest

from fuzzy.compiled.jit import kernel
from robotics.laws.rules.perception import on_leader, stretched
from robotics.simulation.scenario.reading import parse_scenario
from robotics.world.paths.path import Circle, Eight, Line, compile_path
from robotics.world.paths.references import later
from robotics.world.paths.trajectory import Timing, compile_trajectory
from tests.robotics.laws.rules.arrayform.neighbours import Level


def references(shapes, timings):
    return compile_trajectory(tuple(compile_path(s) for s in shapes), tuple(timings))


@kernel
def _all_level(road, s, begin):
    out = np.empty((2, *s.shape))
    for n in range(s.shape[0]):
        for i in range(s.shape[1]):
            out[0, n, i] = on_leader(road, 0, i, s[n, i], begin)
            out[1, n, i] = stretched(road, 0, i, s[n, i], begin)
    return out


def compiled(references, s):
    """The places on the leader's path that are level with robots at ``s``, and the stretches, of equations."""
    return _all_level(references.road, s, np.array(Level.of(references).begin))


def test_on_concentric_circles_angles_are_level():
    circles = references([Circle(radius=1.0), Circle(radius=1.5)], [Timing(duration=10.0)] * 2)
    level = Level.of(circles)
    s = np.array([[1.0, 0.75], [0.0, 3 * pi]])
    assert level.stretch(s) == pytest.approx(np.array([[1.0, 1.5]] * 2), rel=1e-9)
    assert level.on_leader(s) == pytest.approx(np.array([[1.0, 0.5], [0.0, 2 * pi]]), abs=1e-9)
    assert level.place(level.share(s)) == pytest.approx(s, abs=1e-9)
    assert compiled(circles, s)[0] == pytest.approx(np.array([[1.0, 0.5], [0.0, 2 * pi]]), abs=1e-9)
    assert compiled(circles, s)[1] == pytest.approx(np.array([[1.0, 1.5]] * 2), rel=1e-9)


def test_what_lies_before_a_reference_is_behind():
    lines = references(
        [Line(start=(-3.0, 0.0), end=(6.0, 0.0)), Line(start=(0.0, 1.0), end=(6.0, 1.0))],
        [Timing(speed=0.1, start=3.0), Timing(speed=0.1)],
    )
    level = Level.of(lines)
    s = np.array([[1.0, 2.0]])  # x = -2 and x = 2
    assert level.on_leader(s) == pytest.approx(np.array([[1.0, 5.0]]))
    assert compiled(lines, s)[0] == pytest.approx(np.array([[1.0, 5.0]]))
    assert level.share(s)[0] == pytest.approx([-2 / 6, 2 / 6])
    assert Level.of(later(lines, 10.0)).on_leader(s) == pytest.approx(level.on_leader(s))  # nobody moves


def test_by_offsets_robots_are_level_when_the_virtual_one_is_there():
    radius, ahead, left = 2.0, -0.6, 0.5
    wedge = parse_scenario(
        f"""
        kind = "formation"
        duration = 1.0
        [virtual]
        path = {{ shape = "circle", radius = {radius} }}
        timing = {{ speed = 0.2 }}
        [[robots]]
        offset = [0.0, 0.0]
        [[robots]]
        offset = [{ahead}, {left}]
        """,
        "wedge",
    ).setting.references
    level = Level.of(wedge)
    own = np.hypot(radius - left, ahead)  # the radius of the circle on which a point fixed beside the robot moves
    s = np.array([[0.7, 0.7 * own / radius]])
    assert level.on_leader(s) == pytest.approx(np.array([[0.7, 0.7]]), abs=1e-5)
    assert level.stretch(s) == pytest.approx(np.array([[1.0, own / radius]]), abs=1e-5)
    assert compiled(wedge, s)[0] == pytest.approx(np.array([[0.7, 0.7]]), abs=1e-5)
    assert compiled(wedge, s)[1] == pytest.approx(np.array([[1.0, own / radius]]), abs=1e-5)


def test_an_eight_is_bernoullis():
    a, angle, center = 3.0, 0.4, (1.0, -2.0)
    path = compile_path(Eight(width=2 * a, angle=angle, center=center, turns=2.0))
    assert path.length == pytest.approx(2 * 2 * 2.622057554292119 * a, rel=1e-9)  # 2 ϖ a a turn, ϖ the lemniscate's
    s = np.linspace(0.0, path.length, 997)
    point = path.at(s)
    turned = ((point.x - center[0]) + 1j * (point.y - center[1])) * np.exp(-1j * angle)
    x, y = turned.real, turned.imag
    assert (x**2 + y**2) ** 2 == pytest.approx(a**2 * (x**2 - y**2), abs=1e-5)
    assert np.abs(point.curvature) == pytest.approx(3 * np.hypot(x, y) / a**2, abs=1e-4)
    assert (np.sign(point.curvature) == np.sign(x))[np.abs(x) > 0.1].all()  # to the left round the right half
    assert point.heading[0] == pytest.approx(angle - pi / 4)
