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
    team = lanes((0.0, 5.0, 0.0), (0.0, 5.0, 2.0))
    assert "stopped while it waits" not in found(team, "virtual-structure")
    behind = found("divergence = 4.0\n" + team, "virtual-structure")["stopped while it waits"]
    assert "may be 5.39 m behind, and at 4 m" in behind.sentence


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


def told(text: str) -> list[tuple[int, str]]:
    """The line of each fault that the reader finds, and the key that it is about."""
    read = survey_text(text, "t")
    return sorted((read.line(fault.at), str(fault.at[-1])) for fault in read.faults)


GOOD_ROBOT = """
[[robots]]
start = [0.0, 0.0, 0.0]
path = { shape = "line", start = [0.0, 0.0], end = [2.0, 0.0] }
timing = { speed = 0.2 }
"""


def test_a_file_whose_only_robot_cannot_be_read_has_its_other_faults_told_too():
    robot = GOOD_ROBOT.replace('"line"', '"lin"').replace("speed", "sped")
    text = (
        f'duration = "20 s"\nlatncy = 0.1\nmetrics = ["contact"]\n{robot}robot = "etsroo"\n[[obstacle]]\nradius = 1\n'
    )
    assert told(text) == [
        (1, "duration"),
        (2, "latncy"),
        (3, "0"),
        (7, "shape"),
        (8, "sped"),
        (9, "robot"),
        (10, "obstacle"),
    ]
    survey = survey_text(text, "t")
    assert survey.scenario is None
    wrong = inspect_survey(survey, "lyapunow").findings[-1]
    assert (wrong.kind, wrong.at) == ("controller", ("controller",))


@pytest.mark.parametrize("kind", ["tracking", "formation", "team", "goal"])
def test_without_robots_the_rest_is_read_whatever_its_kind(kind):
    text = f'kind = "{kind}"\nlatncy = 0.1\n[sensing]\nposture = "poze"\n'
    assert told(text) == [(1, "robots"), (2, "latncy"), (4, "posture")]


def test_what_only_follows_from_a_fault_is_not_told():
    virtual = "[virtual]\npath = { shape = 'line', start = [0.0, 0.0], end = [2.0, 0.0] }\ntiming = { sped = 0.1 }\n"
    robots = "[[robots]]\noffset = [0.0, 0.5]\n[[robots]]\noffset = [0.0, -0.5]\n"
    assert told(f'kind = "formation"\n{virtual}{robots}[radio]\nhub = 2\n') == [(4, "sped")]


RULES = """[System]
Name='two'
Type='sugeno'
Version=2.0
NumInputs=1
NumOutputs=2
NumRules=2
AndMethod='prod'
OrMethod='probor'
ImpMethod='prod'
AggMethod='sum'
DefuzzMethod='wtaver'

[Input1]
Name='range:front'
Range=[0 2]
NumMFs=2
MF1='near':'linzmf',[0.5 1]
MF2='far':'linsmf',[0.5 1]

[Output1]
Name='v'
Range=[0 3]
NumMFs=2
MF1='slow':'constant',[0.1]
MF2='fast':'constant',[2.5]

[Output2]
Name='w'
Range=[-1 1]
NumMFs=2
MF1='left':'constant',[1]
MF2='right':'constant',[-1]

[Rules]
1, 1 1 (1) : 1
2, 2 2 (1) : 1
"""


def test_a_rule_base_that_asks_for_more_than_the_wheels_give_is_told_with_how_often(tmp_path):
    file = tmp_path / "two.fis"
    file.write_text(RULES, encoding="utf-8")
    sensor = '[[sensors]]\nname = "front"\n'
    result = inspect_survey(survey_text(f"{GOOD_ROBOT}{sensor}", "t"), str(file))
    (note,) = [f for f in result.findings if f.kind == "asks for too much"]
    assert note.severity == "note"
    # The wheels end at r ω = 0.825 m/s: (0.825 - 0.1) / 2.4 of the way from near to far, at 0.651 m of 2 m
    share = 1 - (0.5 + 0.5 * (ROBOT.wheel_speed_limit - 0.1) / 2.4) / 2
    assert f"the rule base {file} can ask for v = 2.5 m/s; its wheels end at 0.825 m/s" in note.sentence
    assert f"in {100 * share:.2g} % of its universe" in note.sentence
    assert {d.output: d.span for d in result.asked} == {"v": (0.1, 2.5), "w": (-1.0, 1.0)}


def test_what_packaged_rules_ask_for_is_known_and_no_finding():
    result = inspect_survey(survey_text(GOOD_ROBOT.replace("0.2 }", "0.2, ramp = 1.0 }"), "t"), "fuzzy")
    assert [(d.rule_base, d.output) for d in result.asked] == [("tracking", "v"), ("tracking", "w")]
    assert "asks for too much" not in {f.kind for f in result.findings}
