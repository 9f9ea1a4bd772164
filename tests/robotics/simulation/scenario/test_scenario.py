"""Scenario files: every packaged one loads; everything wrong with a file is said with its line and what is accepted."""

from dataclasses import FrozenInstanceError, replace
from math import pi

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from fuzzy.errors import InputError
from robotics.simulation.scenario.description import Member, Scenario, ScenarioError
from robotics.simulation.scenario.reading import load_scenario, parse_scenario, scenario_names
from robotics.world.paths.path import Circle, Line, Quintic, Sine, Waypoints
from robotics.world.paths.trajectory import Timing
from robotics.world.sensing.posture import Sensing
from tests.robotics.world.vehicle.etsro import ETSRO

GOOD = """\
title = "Two robots"
duration = 5.0
latency = 0.03

[sensing]
posture = "pose"
position_noise = 0.003
[robot]
model = "etsro"
wheel_radius = 0.04
kp = 0.7

[[robots]]
start = [0.0, 0.0, 0.0]
path = { shape = "line", start = [0.0, 0.0], end = [2.0, 0.0] }
timing = { speed = 0.3 }

[[robots]]
start = [0.0, 1.0, 0.5]
timing = { duration = 30.0 }

[robots.path]
shape = "circle"
radius = 1.0

[robots.robot]
wheel_radius = 0.045
"""


def line_of(text, fragment):
    return 1 + next(i for i, line in enumerate(text.splitlines()) if fragment in line)


def test_good_file_says_what_it_says():
    scenario = parse_scenario(GOOD, "two", "two.toml")
    assert (scenario.name, scenario.title, scenario.duration, scenario.latency) == ("two", "Two robots", 5.0, 0.03)
    assert (scenario.period, scenario.plant, scenario.divergence) == (0.05, "dynamic", 10.0)
    assert scenario.sensing == Sensing(posture="pose", position_noise=0.003)
    first, second = scenario.robots
    assert first.path == Line(start=(0.0, 0.0), end=(2.0, 0.0))
    assert second.path == Circle(radius=1.0)
    assert (first.timing, second.timing) == (Timing(speed=0.3), Timing(duration=30.0))
    assert second.start == (0.0, 1.0, 0.5)
    assert (scenario.ticks, len(scenario.times), scenario.times[-1]) == (100, 101, pytest.approx(5.0))
    assert len(scenario.trajectory.paths) == 2
    with pytest.raises(FrozenInstanceError):
        scenario.duration = 6.0  # type: ignore[misc]


def test_own_robot_parameters_override_the_common_ones():
    first, second = parse_scenario(GOOD, "two").robots
    assert first.robot == replace(ETSRO, wheel_radius=0.04, kp=0.7)
    assert second.robot == replace(ETSRO, wheel_radius=0.045, kp=0.7)
    bare = GOOD[: GOOD.index("[robot]")] + GOOD[GOOD.index("[[robots]]") : GOOD.index("[robots.robot]")]
    assert [member.robot for member in parse_scenario(bare, "bare").robots] == [ETSRO, ETSRO]


@pytest.mark.parametrize("name", scenario_names())
def test_packaged_scenarios_load_and_say_where_they_come_from(name):
    scenario = load_scenario(name)
    assert scenario.name == name
    assert scenario.title
    assert "thesis" in scenario.source or scenario.kind == "goal"
    assert "choice" in scenario.source or "assumed" in scenario.source
    assert scenario.trajectory.ends.max() > 0 or scenario.kind == "goal"


def test_the_thesis_scenarios_are_there():
    assert {"reference", "table-2-1", "lyapunov-sine", "lyapunov-circle", "fuzzy-on-path", "fuzzy-off-path"} <= set(
        scenario_names()
    )
    reference = load_scenario("reference")
    assert reference.robots[0].start == (0.0, 1.0, 0.0)
    assert (reference.latency, reference.period, reference.duration) == (0.03, 0.05, 25.0)
    start = reference.trajectory.at(0.0)
    assert (start.x[0], start.y[0], start.heading[0]) == pytest.approx((0, 1, 0), abs=1e-9)  # tangentially


def test_every_shape_can_be_written_in_a_file():
    shapes = {
        'shape = "sine", amplitude = 0.5, phase = 1.0, x_end = 3': Sine(amplitude=0.5, phase=1.0, x_end=3.0),
        'shape = "circle", direction = "clockwise", center = [1, 2]': Circle(center=(1.0, 2.0), direction="clockwise"),
        'shape = "quintic", start = [0, 0], end = [3, 1], end_tangent = [3, 1.5]': Quintic(
            start=(0.0, 0.0), end=(3.0, 1.0), end_tangent=(3.0, 1.5)
        ),
        'shape = "waypoints", points = [[0, 0], [1, 0.5], [3, 0]]': Waypoints(
            points=((0.0, 0.0), (1.0, 0.5), (3.0, 0.0))
        ),
    }
    for text, shape in shapes.items():
        swapped = GOOD.replace('shape = "line", start = [0.0, 0.0], end = [2.0, 0.0]', text).replace("0.3 }", "0.1 }")
        assert parse_scenario(swapped, "shape").robots[0].path == shape


# (what is replaced, by what, the line that the message names, what it says)
BAD = {
    "unknown key": ("latency", "latencie = 0.1\nlatency", 3, "unknown key 'latencie'; did you mean 'latency'?"),
    "unknown table": ("[sensing]", "[sense]", 5, "unknown key 'sense'; did you mean 'sensors'?"),
    "unknown sensing key": ("position_noise", "positon_noise", 7, "did you mean 'position_noise'?"),
    "unknown robot key": ("kp", "kq", 11, "unknown key 'kq'; did you mean 'kp'?"),
    "unknown member key": ("timing = { duration", "timming = { duration", 20, "did you mean 'timing'?"),
    "unknown path key": ("radius = 1.0", "radios = 1.0", 24, "did you mean 'radius'?"),
    "unknown inline path key": ("end = [2", "stop = [2", 15, "unknown key 'stop'"),
    "unknown timing key": ("speed", "velocity", 16, "unknown key 'velocity'"),
    "name is the file's": ("title", 'name = "x"\ntitle', 1, "unknown key 'name'"),
    "computed field": ("title", "trajectory = 1\ntitle", 1, "unknown key 'trajectory'"),
    "text for a number": ("5.0", '"5 s"', 2, "duration must be a finite number in s, > 0 and <= 86400; got '5 s'"),
    "number for text": ('"Two robots"', "2", 1, "title must be text in quotes; got 2"),
    "bool for a number": ("5.0", "true", 2, "duration must be a finite number in s"),
    "date for a number": ("5.0", "2020-01-01", 2, "duration must be a finite number"),
    "degrees for radians": ("1.0, 0.5]", "1.0, 90.0]", 19, "in radians, between -2π and 2π; got 90.0 (degrees?)"),
    "millimetres for metres": ("0.003", "30", 7, "position_noise must be a finite number in m, >= 0 and <= 10; got 30"),
    "radius in mm": ("0.045", "45.0", 27, "wheel_radius must be a finite number in m, > 0 and <= 1; got 45.0"),
    "negative duration": ("5.0", "-5.0", 2, "duration must be a finite number in s, > 0"),
    "zero duration": ("5.0", "0.0", 2, "duration must be"),
    "shorter than a period": ("5.0", "0.02", 2, "duration must be at least a period, 0.05 s; got 0.02"),
    "negative latency": ("0.03", "-0.03", 3, "latency must be"),
    "latency in ms": ("0.03", "30.0", 3, "latency must be a finite number in s, >= 0 and <= 2; got 30.0"),
    "NaN": ("5.0", "nan", 2, "duration must be a finite number in s, > 0 and <= 86400; got nan"),
    "infinite": ("0.7", "inf", 11, "kp must be a finite number in V s/rad, >= 0; got inf"),
    "NaN in a point": ("[2.0, 0.0]", "[nan, 0.0]", 15, "end must be 2 finite numbers [x, y] in m; got [nan, 0.0]"),
    "beyond float": ("5.0", "1" + "0" * 400, 2, "duration must be a finite number"),
    "beyond float in a point": ("[2.0, 0.0]", "[1" + "0" * 400 + ", 0.0]", 15, "end must be 2 finite numbers"),
    "too long a path": ("[2.0, 0.0]", "[1e14, -1e14]", 15, "its length is 1.41421e+14 m; a path needs a length > 0"),
    "no place of this world": (
        "[2.0, 0.0]",
        "[1e308, 0.0]",
        15,
        "end must be 2 finite numbers [x, y] in m; got [1e+308",
    ),
    "endless path": ("[2.0, 0.0]", "[1e9, 0.0]", 15, "a path needs a length > 0 and <= 10000 m"),
    "period between steps": ("latency", "period = 0.025\nlatency", 3, "period must be a multiple of 0.01 s, got 0.025"),
    "latency between steps": ("0.03", "0.035", 3, "latency must be a multiple of 0.01 s, got 0.035"),
    "unknown posture": ('"pose"', '"gps"', 6, "posture must be one of 'odometry', 'pose'; got 'gps'"),
    "list for a choice": ('"pose"', '["pose"]', 6, "posture must be one of"),
    "unknown plant": ("latency", 'plant = "ideal"\nlatency', 3, "plant must be one of 'dynamic', 'kinematic'"),
    "noise on odometry": ('"pose"', '"odometry"', 5, 'position_noise belongs to posture = "pose"'),
    "sensing is a number": ("[sensing]", "sensing = 3\n[sensed]", 5, "sensing must be a table, got 3"),
    "unknown shape": ('"line"', '"lime"', 15, "unknown path shape 'lime'; did you mean 'line'? Known: sine, circle"),
    "shape is a list": ('"line"', '["line"]', 15, "unknown path shape"),
    "shape is a table": ('"line"', "{ line = 1 }", 15, "unknown path shape"),
    "shape missing": ('shape = "line", ', "", 15, "path lacks shape, one of sine, circle, eight, line, quintic"),
    "path missing": ('path = { shape = "line", start = [0.0, 0.0], end = [2.0, 0.0] }', "", 13, "a robot needs a path"),
    "path is a list": (
        '{ shape = "line", start = [0.0, 0.0], end = [2.0, 0.0] }',
        "[1]",
        15,
        "path must be a table, got [1]",
    ),
    "timing missing": ("timing = { speed = 0.3 }", "", 13, "member lacks timing"),
    "timing is a number": ("{ speed = 0.3 }", "0.3", 16, "timing must be a table, got 0.3"),
    "two timings": ("speed = 0.3", "speed = 0.3, duration = 3.0", 16, "give exactly one of speed, duration and x_rate"),
    "no timing": ("speed = 0.3", "", 16, "got none"),
    "start missing": ("start = [0.0, 0.0, 0.0]\n", "", 13, "member lacks start"),
    "two numbers for a pose": ("[0.0, 1.0, 0.5]", "[0.0, 1.0]", 19, "start must be 3 finite numbers [x, y, heading]"),
    "four numbers for a pose": ("[0.0, 1.0, 0.5]", "[0.0, 1.0, 0.5, 0]", 19, "start must be 3 finite numbers"),
    "one number for a pose": ("[0.0, 1.0, 0.5]", "1.0", 19, "start must be 3 finite numbers"),
    "text in a pose": ("[0.0, 1.0, 0.5]", '[0.0, "1", 0.5]', 19, "start must be 3 finite numbers"),
    "three numbers for a point": ("[2.0, 0.0]", "[2.0, 0.0, 1.0]", 15, "end must be 2 finite numbers [x, y] in m"),
    "end missing": (", end = [2.0, 0.0]", "", 15, "line lacks end"),
    "zero length": ("[2.0, 0.0]", "[0.0, 0.0]", 15, "its length is 0"),
    "points of the wrong type": (
        'shape = "circle"\nradius = 1.0',
        'shape = "waypoints"\npoints = 3',
        24,
        "a list of points",
    ),
    "a point too few numbers": (
        'shape = "circle"\nradius = 1.0',
        'shape = "waypoints"\npoints = [[1], [2]]',
        24,
        "points must be",
    ),
    "a cusp": (
        'shape = "circle"\nradius = 1.0',
        'shape = "waypoints"\npoints = [[0, 0], [2, 0], [0.5, 0]]',
        22,
        "stands still or turns on the spot near (2, 0) m",
    ),
    "negative radius": ("radius = 1.0", "radius = -1.0", 24, "radius must be a finite number in m, > 0; got -1.0"),
    "direction": (
        "radius = 1.0",
        'direction = "left"',
        24,
        "direction must be one of 'counter-clockwise', 'clockwise'",
    ),
    "start beyond the end": (
        "speed = 0.3",
        "speed = 0.3, start = 2.0",
        16,
        "start 2 m lies at or beyond the path's end",
    ),
    "x_rate on a circle": ("duration = 30.0", "x_rate = 0.1", 20, "x_rate needs a path on which x always grows"),
    "too fast": ("speed = 0.3", "speed = 0.9", 16, "robot 1: the reference is infeasible: at t = 0.0"),
    "broken TOML": ("0.03", "0.03.1", 3, "this is not TOML"),
    "unclosed string": ('"Two robots"', '"Two robots', 1, "this is not TOML"),
    "unclosed table": ("end = [2.0, 0.0] }", "end = [2.0, 0.0]", 15, "this is not TOML"),
    "duplicate key": ("latency = 0.03", "duration = 6.0", 3, "this is not TOML"),
    "duplicate table": ("[robot]", "[sensing]", 8, "this is not TOML"),
}


@pytest.mark.parametrize(("old", "new", "line", "message"), BAD.values(), ids=BAD)
def test_what_is_wrong_is_named_with_its_line(old, new, line, message):
    assert GOOD.count(old) >= 1
    text = GOOD.replace(old, new, 1)
    with pytest.raises(ScenarioError) as caught:
        parse_scenario(text, "bad", "bad.toml")
    assert str(caught.value).startswith(f"bad.toml:{line}: ")
    assert message in str(caught.value)
    assert len(str(caught.value)) < 7000


@pytest.mark.parametrize(
    ("text", "line", "message"),
    [
        ("", 1, "at least one [[robots]] table is needed"),
        ("duration = 3.0\nrobots = []", 2, "at least one [[robots]] table is needed"),
        ('duration = 3.0\nrobots = "x"', 2, "at least one [[robots]] table is needed"),
        ("duration = 3.0\nrobots = 3", 2, "at least one [[robots]]"),
        ("duration = 3.0\n[robots]\nstart = [0.0, 0.0, 0.0]", 2, "at least one [[robots]]"),
        ("duration = 3.0\nrobots = [3]", 2, "must be a table, got 3"),
        ("duration = 3.0\n\n[[robots]]", 3, "a robot needs a path"),
        (
            "robot = 3\n" + GOOD[GOOD.index("[[robots]]") :],
            1,
            'robot must be a name such as "etsro", the path of a .toml file, or a',
        ),
        (GOOD.replace("[robots.robot]\nwheel_radius = 0.045", 'robot = "small"'), 26, "unknown key 'robot'"),
        (
            GOOD.replace("[0.0, 1.0, 0.5]", "[0.0, 1.0, 0.5]\nrobot = 3").partition("[robots.robot]")[0],
            20,
            "robot must be a name",
        ),
    ],
)
def test_files_without_usable_robots(text, line, message):
    with pytest.raises(ScenarioError) as caught:
        parse_scenario(text, "bad", "bad.toml")
    assert str(caught.value).startswith(f"bad.toml:{line}: ")
    assert message in str(caught.value)


def test_a_whole_number_that_cannot_be_printed_is_refused_with_its_line():
    with pytest.raises(ScenarioError, match=r"^bad\.toml:2: a whole number of more than 3,000 digits$"):
        parse_scenario(f"title = 'x'\nduration = 0x1{'0' * 4000}\n", "bad", "bad.toml")
    with pytest.raises(ScenarioError, match=r"^bad\.toml:4: a whole number of more than 3,000 digits$"):
        parse_scenario(f"[[robots]]\nmass = 1.0\n[[robots]]\nplace = [0x1{'0' * 4000}]\n", "bad", "bad.toml")


@pytest.mark.parametrize("value", ["9" * 5000, "[" * 5000], ids=["number", "nesting"])
def test_what_the_parser_of_toml_chokes_on_is_refused(value):
    with pytest.raises(ScenarioError, match=r"^bad\.toml: this is not TOML"):
        parse_scenario(GOOD.replace("5.0", value, 1), "bad", "bad.toml")


def test_infeasible_reference_is_named_with_its_place_and_excess():
    """Thesis: 175 rpm on 4.5 cm wheels is 0.825 m/s; a 0.5 m circle at 0.6 m/s asks 0.6 + 0.1 · 1.2 = 0.72 m/s."""
    member = Member(start=(0.5, 0.0, pi / 2), path=Circle(radius=0.5), timing=Timing(speed=0.6))
    Scenario(name="fast", robots=(member,))
    with pytest.raises(
        ScenarioError, match=r"robot 1.*\|v\| \+ L \|ω\| = 0.84 m/s exceeds r ω_wheel = 0.8247 by 0.0153"
    ):
        Scenario(name="faster", robots=(replace(member, timing=Timing(speed=0.7)),))
    with pytest.raises(ScenarioError, match=r"robot 2: .*\|ω\| = 6 rad/s exceeds w_max = 5.74 by 0.26 \(4.5 %\)"):
        Scenario(name="turn", robots=(member, replace(member, path=Circle(radius=0.02), timing=Timing(speed=0.12))))
    with pytest.raises(ScenarioError, match=r"\|v\| = 0.5 m/s exceeds v_max = 0.4 by 0.1 \(25.0 %\)"):
        Scenario(name="v", robots=(replace(member, timing=Timing(speed=0.5), robot=replace(ETSRO, v_max=0.4)),))
    # [D]: x = 0.6 t, y = sin x is infeasible; 0.6 (√(1 + cos² x) + 0.1 sin x / (1 + cos² x)) peaks near x = 0.07
    match = r"at t = 0.12 s, \(0.072, 0.072\) m, abscissa 0.102 m, .* = 0.8496 m/s exceeds .*; slow the timing down"
    with pytest.raises(ScenarioError, match=match):
        Scenario(name="sine", robots=(Member(start=(0.0, 0.0, 0.0), path=Sine(), timing=Timing(x_rate=0.6)),))


def test_a_corner_shorter_than_a_period_is_not_overlooked():
    """The curvature peaks within 3 mm at (1, 0); at 0.3 m/s the reference is past it in 10 ms."""
    corner = Waypoints(points=((0.0, 0.0), (1.0, 0.0), (0.0, 0.25)))
    found = 0
    for offset in np.linspace(0.0, 0.014, 8):
        with pytest.raises(ScenarioError, match="infeasible"):
            Scenario(
                name="corner",
                robots=(Member(start=(0, 0, 0), path=corner, timing=Timing(speed=0.3, start=float(offset))),),
            )
        found += 1
    assert found == 8


@pytest.mark.parametrize(
    ("make", "message"),
    [
        (lambda: Scenario(name="none", robots=()), "at least one robot"),
        (lambda: Sensing(position_noise=0.1), 'belongs to posture = "pose"'),
        (lambda: Sensing(posture="pose", position_noise=-0.1), "position_noise must be"),
        (lambda: Sensing(posture="pose", heading_noise=10.0), "heading_noise must be a finite number in rad"),
        (
            lambda: Member(start=(0.0, float("nan"), 0.0), path=Circle(), timing=Timing(speed=0.1)),
            "start must be finite",
        ),
        (lambda: Member(start=(0.0, 0.0, 1000.0), path=Circle(), timing=Timing(speed=0.1)), "in radians"),
    ],
)
def test_scenarios_built_in_python_are_checked_alike(make, message):
    with pytest.raises(InputError) as caught:
        make()
    assert message in str(caught.value)


def test_files_that_cannot_be_read(tmp_path):
    binary, folder = tmp_path / "binary.toml", tmp_path / "folder.toml"
    binary.write_bytes(bytes(range(256)))
    folder.mkdir()
    for path, message in (
        (binary, "it is not UTF-8 text"),
        (folder, "cannot be read: Is a directory"),
        (tmp_path / "none.toml", "cannot be read: No such file or directory"),
        (tmp_path / "foldr.toml", f"No such file or directory; did you mean '{folder}'?"),
        (str(tmp_path / "a\0b.toml"), "cannot be read"),
        (str(tmp_path / ("x" * 300 + ".toml")), "cannot be read"),
        (tmp_path / "scenario.txt", "; or the path of a .toml file"),
        ("referense", "unknown scenario 'referense'; did you mean 'reference'?"),
        ("", "unknown scenario ''"),
    ):
        with pytest.raises(ScenarioError) as caught:
            load_scenario(path)
        assert message in str(caught.value)
        assert caught.value.__cause__ is None


def test_a_file_is_named_after_itself_and_its_errors_name_it(tmp_path):
    path = tmp_path / "mine.toml"
    path.write_text(GOOD, encoding="utf-8")
    assert load_scenario(path).name == load_scenario(str(path)).name == "mine"
    path.write_text(GOOD.replace("radius = 1.0", "radius = 0"), encoding="utf-8")
    with pytest.raises(ScenarioError, match=rf"mine\.toml:{line_of(GOOD, 'radius = 1.0')}: radius must be"):
        load_scenario(path)


VALUES = [
    "3",
    '"x"',
    "[1]",
    "[]",
    "{}",
    "true",
    "nan",
    "-1",
    "0",
    "1e308",
    "[[1,2],[3]]",
    "07:32:00",
    "[{}]",
    "9" * 400,
]
KEYS = ["robots", "robot", "sensing", "path", "timing", "start", "shape", "points", "speed", "title", "period", "x y"]


@given(st.integers(0, 27), st.sampled_from(KEYS), st.sampled_from(VALUES), st.booleans())
@settings(max_examples=150)
def test_whatever_stands_in_a_line_the_error_is_a_scenario_error(line, key, value, instead):
    check_with_line(GOOD.splitlines(), line, key, value, instead)


def check_with_line(lines, line, key, value, instead):
    """The scenario with another line can be read, or the error says where it is wrong."""
    if instead and line < len(lines) and "=" in lines[line]:
        lines[line] = lines[line].split("=")[0] + "= " + value
    else:
        lines.insert(line, f"{key} = {value}")
    try:
        parse_scenario("\n".join(lines), "any")
    except ScenarioError as error:  # any other kind would be a traceback to the user
        said = str(error)
    else:
        return
    assert said.startswith("<text>:")
