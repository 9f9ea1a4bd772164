"""What a judgement before a run finds, against geometry that is computed by hand."""

from dataclasses import replace

import numpy as np
import pytest

from robotics.simulation.scenario.robots import load_robot
from robotics.simulation.scenario.survey import survey_text
from robotics.studies.inspection import ScenarioFinding, acceleration, inspect_survey

ROBOT = load_robot("etsro").robot
LANE = """
[[robots]]
start = [0.0, {y}, 0.0]
path = {{ shape = "line", start = [0.0, {y}], end = [{to}, {end}] }}
timing = {{ duration = 40.0, ramp = 2.0 }}
"""


def found(text: str, controller: str = "") -> dict[str, ScenarioFinding]:
    return {f.kind: f for f in inspect_survey(survey_text(text, "t"), controller).findings}


def lanes(*ends: tuple[float, float, float]) -> str:
    return 'kind = "team"\nduration = 50.0\n' + "".join(LANE.format(y=y, to=to, end=end) for y, to, end in ends)


def test_lanes_beside_each_other_are_clean():
    assert found(lanes((0.0, 5.0, 0.0), (1.5, 5.0, 1.5)), "virtual-structure") == {}


def test_an_infeasible_speed_is_told_with_its_place_and_demand():
    text = lanes((0.0, 60.0, 0.0)).replace('"team"', '"tracking"')
    result = inspect_survey(survey_text(text, "t"), "fuzzy")
    first = result.findings[0]
    assert (first.severity, first.kind, first.at) == ("error", "infeasible", ("robots", 0, "timing"))
    wheels = next(d for d in result.demands if d.limit == "wheels")
    assert wheels.need == pytest.approx(60.0 / 38.0)  # between two ramps of 2 s
    assert wheels.reserve == pytest.approx(1 - 60 / 38 / ROBOT.wheel_speed_limit)


def test_a_path_through_a_wall_is_told_where_the_robot_touches_it():
    wall = '\n[[obstacles]]\nshape = "wall"\npoints = [[2.0, -1.0], [2.0, 1.0]]\n'
    text = lanes((0.0, 5.0, 0.0)).replace('"team"', '"tracking"') + wall
    hit = found(text, "lyapunov")["path through an obstacle"]
    assert hit.severity == "error"
    assert (hit.x, hit.y) == pytest.approx((2.0 - ROBOT.length / 2, 0.0), abs=1e-3)


def test_a_wall_beside_a_path_is_told_if_it_leaves_less_than_the_least_room():
    robot = ROBOT
    for room, told in ((0.03, True), (0.08, False)):
        y = robot.width / 2 + room
        wall = f'\n[[obstacles]]\nshape = "wall"\npoints = [[2.0, {y}], [3.0, {y}]]\n'
        kinds = found(lanes((0.0, 5.0, 0.0)).replace('"team"', '"tracking"') + wall, "lyapunov")
        assert ("little room" in kinds) == told
        assert "path through an obstacle" not in kinds


def test_robots_that_stand_in_each_other_or_in_an_obstacle_are_told():
    kinds = found(lanes((0.0, 5.0, 0.0), (0.1, 5.0, 0.15)), "virtual-structure")
    assert kinds["starts too near"].severity == kinds["goals too near"].severity == "error"
    box = '\n[[obstacles]]\nshape = "disc"\nradius = 0.2\nposition = [0.2, 0.0]\n'
    kinds = found(lanes((0.0, 5.0, 0.0)).replace('"team"', '"tracking"') + box, "fuzzy")
    assert kinds["start in an obstacle"].at == ("robots", 0, "start")


def test_crossing_references_are_a_warning_unless_the_law_keeps_robots_apart():
    crossing = lanes((0.0, 5.0, 2.0), (2.0, 5.0, 0.0))
    met = found(crossing, "virtual-structure")["references meet"]
    assert met.severity == "warning"
    assert met.x == pytest.approx(2.5, abs=0.5)  # where they cross, less half their sizes
    assert found(crossing, "right-of-way")["references meet"].severity == "note"


def test_a_radio_that_reaches_too_short_or_is_too_slow_is_told():
    two = lanes((0.0, 5.0, 0.0), (1.5, 5.0, 4.5))
    far = found(two + "\n[radio]\nrange = 3.0\n", "virtual-structure")["radio out of reach"]
    assert "4.50 m apart" in far.sentence
    assert found(two + "\n[radio]\nbaud = 100\n", "virtual-structure")["radio too slow"].at == ("radio", "period")


def test_a_start_far_off_turned_away_or_beyond_the_divergence_is_told():
    text = lanes((0.0, 5.0, 0.0)).replace('"team"', '"tracking"')
    assert found(text, "fuzzy") == {}
    assert found(text.replace("start = [0.0, 0.0, 0.0]", "start = [0.0, 0.0, 3.0]"), "fuzzy")["start off the path"]
    away = found("divergence = 2.0\n" + text.replace("start = [0.0, 0.0, 0.0]", "start = [0.0, 2.5, 0.0]"), "fuzzy")
    assert away["start beyond divergence"].severity == "error"


def test_a_sudden_start_is_told_with_the_way_that_is_lost():
    text = lanes((0.0, 5.0, 0.0)).replace('"team"', '"tracking"').replace("duration = 40.0, ramp = 2.0", "speed = 0.75")
    robot = ROBOT
    sudden = found(text, "fuzzy")["sudden start"]
    assert f"{0.75**2 / (2 * acceleration(robot)):.2g} m behind" in sudden.sentence
    slow = replace(ROBOT, v_rate_max=0.5)
    assert acceleration(slow) == 0.5


def test_a_law_that_lacks_sensors_or_sees_nothing_is_told():
    bare = '\n[[sensors]]\nname = "rear"\n'
    assert found(lanes((0.0, 5.0, 0.0), (1.5, 5.0, 1.5)) + bare, "obstacles")["sensors missing"].at == ("sensors",)
    assert found(lanes((0.0, 5.0, 0.0), (1.5, 5.0, 1.5)), "no-such-law")["controller"].severity == "error"
    assert np.isfinite(acceleration(ROBOT))
