"""Team scenarios as files: what radio, faults and sensing say, and what is wrong with them by file, line and field."""

import re
from dataclasses import replace
from typing import Any

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from robotics.laws.catalogue import make_controller
from robotics.simulation.loop import simulate
from robotics.simulation.scenario.description import Member, Scenario, ScenarioError
from robotics.simulation.scenario.reading import load_scenario, parse_scenario, scenario_names
from robotics.world.paths.path import Line
from robotics.world.paths.trajectory import Timing
from robotics.world.radio.description import RADIO_PRESETS, Radio, RadioError
from robotics.world.radio.faults import Fault
from robotics.world.sensing.posture import Sensing
from tests.robotics.simulation.scenario.test_scenario import check_with_line

GOOD = """\
kind = "team"
title = "Three robots"
duration = 5.0
controller = "virtual-structure"

[sensing]
posture = "pose"
relative_noise = 0.1
noise_start = 1.0
noise_end = 2.0
filter_gain = 0.5
wheel_error = 0.01
axle_error = 0.02

[radio]
preset = "zigbee-9600"
graph = "star"
hub = 2
latency = 0.04
jitter = 0.01
loss = 0.1
burst_start = 0.01
burst_end = 0.3
burst_loss = 0.9
range = 20.0

[[faults]]
robot = 2
kind = "failure"
start = 1.0
duration = 2.0

[[faults]]
robot = 1
kind = "silence"
other = 3
start = 1.0
start_until = 3.0
duration = 0.5

[[robots]]
start = [0.0, 0.0, 0.0]
path = { shape = "line", start = [0.0, 0.0], end = [2.0, 0.0] }
timing = { duration = 20.0, ramp = 2.0 }

[[robots]]
start = [0.0, 1.0, 0.0]
path = { shape = "line", start = [0.0, 1.0], end = [3.0, 1.0] }
timing = { duration = 20.0, ramp = 2.0 }

[robots.sensing]
posture = "odometry"
wheel_error = 0.03

[[robots]]
start = [0.0, 2.0, 0.0]
path = { shape = "line", start = [0.0, 2.0], end = [4.0, 2.0] }
timing = { duration = 20.0, ramp = 2.0 }
sensing = { posture = "pose", position_noise = 0.02 }
"""


def line_of(fragment, text=GOOD, nth=0):
    found = [n for n, line in enumerate(text.splitlines(), start=1) if fragment in line]
    return found[nth]


def test_good_file_says_what_it_says():
    scenario = parse_scenario(GOOD, "three", "three.toml")
    assert (scenario.kind, scenario.controller) == ("team", "virtual-structure")
    assert scenario.sensing == Sensing(
        posture="pose",
        relative_noise=0.1,
        noise_start=1.0,
        noise_end=2.0,
        filter_gain=0.5,
        wheel_error=0.01,
        axle_error=0.02,
    )
    assert [m.sensing for m in scenario.robots] == [
        None,
        Sensing(wheel_error=0.03),
        Sensing(posture="pose", position_noise=0.02),
    ]
    assert scenario.radio == Radio(
        graph="star",
        hub=2,
        baud=9600.0,
        header_bytes=9,
        value_bytes=2,
        period=0.1,
        latency=0.04,
        jitter=0.01,
        loss=0.1,
        burst_start=0.01,
        burst_end=0.3,
        burst_loss=0.9,
        range=20.0,
    )
    assert scenario.faults == (
        Fault(robot=2, kind="failure", start=1.0, duration=2.0),
        Fault(robot=1, kind="silence", other=3, start=1.0, start_until=3.0, duration=0.5),
    )
    assert [m.timing for m in scenario.robots] == [Timing(duration=20.0, ramp=2.0)] * 3


def test_a_preset_is_what_it_says_and_gives_way_to_what_stands_beside_it():
    bare = GOOD[: GOOD.index('graph = "star"')] + GOOD[GOOD.index("[[faults]]") :]
    assert parse_scenario(bare, "bare").radio == Radio(**RADIO_PRESETS["zigbee-9600"])
    beside = parse_scenario(bare.replace("zigbee-9600", 'zigbee-9600"\nperiod = 0.2\ngraph = "ring'), "b").radio
    assert beside == Radio(**RADIO_PRESETS["zigbee-9600"] | {"period": 0.2, "graph": "ring"})
    without = bare.replace('[radio]\npreset = "zigbee-9600"\n', "")
    assert parse_scenario(without, "w").radio == Radio()
    assert parse_scenario(without, "w").radio.baud is None


def test_edges_are_pairs():
    text = GOOD.replace('"star"', '"edges"').replace("hub = 2", "edges = [[1, 2], [2, 3], [3, 1]]")
    assert parse_scenario(text, "e").radio.edges == ((1, 2), (2, 3), (3, 1))


@pytest.mark.parametrize("name", scenario_names("team"))
def test_packaged_teams_name_a_controller_that_runs(name):
    scenario = load_scenario(name)
    assert len(scenario.robots) >= 2
    assert len({member.timing.duration for member in scenario.robots}) == 1
    law = make_controller(scenario.controller)
    scenario.radio.check_bandwidth(len(scenario.robots), len(law.message))
    run = simulate(replace(scenario, duration=scenario.period * 3), law)
    assert not run.diverged.any()


# (what is replaced, by what, a fragment of the line that the message names, what it says)
RADIO = 'graph = "star"\nhub = 2'
BAD = {
    "unknown kind": (
        '"team"',
        '"teem"',
        "kind =",
        "kind must be one of 'tracking', 'formation', 'team', 'goal'; got 'teem'",
    ),
    "unknown radio key": ("jitter", "jiter", "jiter", "unknown key 'jiter'; did you mean 'jitter'?"),
    "radio is a number": ("[radio]", "radio = 3\n[sensed]", None, "unknown key 'radio'"),
    "unknown preset": (
        "zigbee-9600",
        "zigbee-960",
        "preset",
        "unknown radio preset 'zigbee-960'; did you mean 'zigbee-",
    ),
    "preset is a number": ('"zigbee-9600"', "9600", "preset", "unknown radio preset '9600'"),
    "preset is a list": ('"zigbee-9600"', '["zigbee-9600"]', "preset", "unknown radio preset"),
    "unknown graph": ('"star"', '"tree"', "graph", "graph must be one of 'star', 'ring', 'line', 'complete', 'edges'"),
    "hub beyond": ("hub = 2", "hub = 4", "hub", "hub: robots are 1 to 3, got 4"),
    "hub from zero": ("hub = 2", "hub = 0", "hub", "hub must be a whole number >= 1; got 0"),
    "hub is a fraction": ("hub = 2", "hub = 1.5", "hub", "hub must be a whole number >= 1; got 1.5"),
    "hub is true": ("hub = 2", "hub = true", "hub", "hub must be a whole number >= 1; got True"),
    "edges missing": (
        RADIO,
        'graph = "edges"',
        "[radio]",
        'edges = [[sender, receiver], ...] belong to graph = "edges"',
    ),
    "edges of a star": ("hub = 2", "edges = [[1, 2]]", "edges", 'belong to graph = "edges", and only to it'),
    "edges beyond": (RADIO, 'graph = "edges"\nedges = [[1, 2], [2, 5]]', "edges = [", "robots are 1 to 3, got 5"),
    "edges to itself": (
        RADIO,
        'graph = "edges"\nedges = [[2, 2]]',
        "edges = [",
        "robot 2 needs no radio to hear itself",
    ),
    "edges of three": (
        RADIO,
        'graph = "edges"\nedges = [[1, 2, 3]]',
        "edges = [",
        "a list of pairs [sender, receiver]",
    ),
    "edges of text": (RADIO, 'graph = "edges"\nedges = [["1", 2]]', "edges = [", "a list of pairs [sender, receiver]"),
    "edges a pair": (RADIO, 'graph = "edges"\nedges = [1, 2]', "edges = [", "a list of pairs [sender, receiver]"),
    "latency in ms": (
        "latency = 0.04",
        "latency = 40.0",
        "latency",
        "latency must be a finite number in s, >= 0 and <=",
    ),
    "negative jitter": ("jitter = 0.01", "jitter = -0.01", "jitter", "jitter must be a finite number in s, >= 0"),
    "loss in percent": (
        "loss = 0.1\n",
        "loss = 10.0\n",
        "loss = 10",
        "loss must be a finite number, >= 0 and <= 1; got 10",
    ),
    "burst start": ("burst_start = 0.01", "burst_start = 1.5", "burst_start", "burst_start must be a finite number"),
    "endless burst": ("burst_end = 0.3", "burst_end = 0.0", "burst_end", "burst_end must be a finite number, > 0"),
    "burst loss": ("burst_loss = 0.9", "burst_loss = -1", "burst_loss", "burst_loss must be a finite number"),
    "no range": ("range = 20.0", "range = 0.0", "range", "range must be a finite number in m, > 0; got 0.0"),
    "range is text": ("range = 20.0", 'range = "far"', "range", "range must be a finite number in m"),
    "baud": ("range = 20.0", "baud = 0", "baud", "baud must be a finite number in baud, > 0"),
    "header": ("range = 20.0", "header_bytes = -1", "header_bytes", "header_bytes must be a whole number >= 0; got -1"),
    "no bytes": ("range = 20.0", "value_bytes = 0", "value_bytes", "value_bytes must be a whole number >= 1; got 0"),
    "radio between periods": ("range = 20.0", "period = 0.12", "period", "must be a multiple of 0.05 s, got 0.12"),
    "radio in between": ("range = 20.0", "period = 0.025", "period", "must be a multiple of 0.05 s, got 0.025"),
    "radio at no time": ("range = 20.0", "period = 1e-12", "period", "must be a multiple of 0.05 s, got 1e-12"),
    "preset between periods": (
        'kind = "team"',
        'kind = "team"\nperiod = 0.04',
        "[radio]",
        "a multiple of 0.04 s, got 0.1",
    ),
    "messages too long": ("range = 20.0", "header_bytes = 30", "[radio]", "3 robots × (30 + 4 × 2) bytes = 114 bytes"),
    "period too short": ("range = 20.0", "period = 0.05", "period", "= 51 bytes every 0.05 s do not fit into the 48"),
    "unknown fault key": ("other = 3", "othr = 3", "othr", "unknown key 'othr'; did you mean 'other'?"),
    "faults are no list": ("[[faults]]\nrobot = 2", "[faults]\nrobot = 2", None, "this is not TOML"),
    "fault of nobody": ("robot = 2", "robot = 4", "robot = 4", "robot must be a robot, 1 to 3; got 4"),
    "fault of robot 0": ("robot = 2", "robot = 0", "robot = 0", "robot must be a whole number >= 1; got 0"),
    "fault of robot 1.5": ("robot = 2", "robot = 1.5", "robot = 1.5", "robot must be a whole number >= 1; got 1.5"),
    "far end of nobody": ("other = 3", "other = 9", "other", "other must be a robot, 1 to 3; got 9"),
    "link to itself": ("other = 3", "other = 1", "other", 'other names the far end of a link, for kind = "silence"'),
    "link of a failure": ('kind = "silence"', 'kind = "failure"', "other", "other names the far end of a link"),
    "unknown fault": ('"silence"', '"silent"', 'kind = "silent"', "kind must be one of 'failure', 'delay', 'silence'"),
    "fault without a kind": ('kind = "silence"\n', "", "[[faults]]", "fault lacks kind"),
    "fault for no time": (
        "duration = 0.5",
        "duration = 0.0",
        "duration = 0.0",
        "duration must be a finite number in s, > 0",
    ),
    "fault before": (
        "start = 1.0\nduration = 2.0",
        "start = -1.0\nduration = 2.0",
        "start = -1.0",
        "start must be a fin",
    ),
    "fault backwards": (
        "start_until = 3.0",
        "start_until = 0.5",
        "start_until",
        "start_until must be >= start, 1 s; got 0.5",
    ),
    "noise in percent": (
        "relative_noise = 0.1",
        "relative_noise = 10",
        "relative_noise",
        "relative_noise must be a finite",
    ),
    "noise ends first": (
        "noise_end = 2.0",
        "noise_end = 0.5",
        "noise_end",
        "noise_end must be > noise_start, 1 s; got 0.5",
    ),
    "noise start": (
        "noise_start = 1.0",
        "noise_start = -1.0",
        "noise_start",
        "noise_start must be a finite number in s, >=",
    ),
    "no gain": (
        "filter_gain = 0.5",
        "filter_gain = 0.0",
        "filter_gain",
        "filter_gain must be a finite number, > 0 and <= 1",
    ),
    "wheel in percent": (
        "wheel_error = 0.01",
        "wheel_error = 1.0",
        "wheel_error",
        "wheel_error must be a finite number, >=",
    ),
    "axle": ("axle_error = 0.02", "axle_error = nan", "axle_error", "axle_error must be a finite number"),
    "own wheel": ("wheel_error = 0.03", "wheel_error = 3", "wheel_error = 3", "wheel_error must be a finite number"),
    "own sensing key": ("wheel_error = 0.03", "weel_error = 0.03", "weel_error", "did you mean 'wheel_error'?"),
    "own noise on odometry": (
        "wheel_error = 0.03",
        "relative_noise = 0.1",
        "[robots.sensing]",
        'relative_noise belongs to posture = "pose"',
    ),
    "inline sensing": (
        "position_noise = 0.02",
        "position_noise = 20",
        "sensing = {",
        "position_noise must be a finite",
    ),
    "sensing of a robot is a number": (
        '{ posture = "pose", position_noise = 0.02 }',
        "3",
        "sensing = 3",
        "must be a table",
    ),
    "unequal durations": (
        "timing = { duration = 20.0, ramp = 2.0 }\n\n[robots.sensing]",
        "timing = { duration = 21.0, ramp = 2.0 }\n\n[robots.sensing]",
        "21.0",
        "a team arrives together: every timing has the same duration and ramp",
    ),
    "unequal ramps": (
        "timing = { duration = 20.0, ramp = 2.0 }\n\n[robots.sensing]",
        "timing = { duration = 20.0, ramp = 1.0 }\n\n[robots.sensing]",
        "ramp = 1.0",
        "every timing has the same duration and ramp",
    ),
    "a speed": ("{ duration = 20.0, ramp = 2.0 }", "{ speed = 0.2 }", "speed", "every timing has the same duration"),
    "long ramps": ("ramp = 2.0", "ramp = 11.0", "ramp = 11", "timing: two ramps of 11 s do not fit into 20 s"),
    "negative ramp": ("ramp = 2.0", "ramp = -1", "ramp = -1", "ramp must be a finite number in s, >= 0; got -1"),
    "unknown controller": (
        '"virtual-structure"',
        '"virtual-structur"',
        "controller",
        "did you mean 'virtual-structure'?",
    ),
    "unknown gain": ('"virtual-structure"', '"virtual-structure:kapa=1"', "controller", "did you mean 'kappa'?"),
    "controller is a number": ('"virtual-structure"', "3", "controller", "controller must be text in quotes; got 3"),
}


@pytest.mark.parametrize(("old", "new", "fragment", "message"), BAD.values(), ids=BAD)
def test_what_is_wrong_is_named_with_its_line(old, new, fragment, message):
    assert GOOD.count(old) >= 1
    text = GOOD.replace(old, new, 1)
    with pytest.raises(ScenarioError) as caught:
        parse_scenario(text, "bad", "bad.toml")
    assert message in str(caught.value)
    place = re.match(r"bad\.toml:(\d+): ", str(caught.value))
    if fragment is None:
        assert str(caught.value).startswith("bad.toml")
    else:
        assert place is not None
        assert int(place[1]) in [n for n, line in enumerate(text.splitlines(), start=1) if fragment in line]


def test_the_second_of_two_faults_is_named_by_its_own_line():
    text = GOOD.replace("start = 1.0\nstart_until", "start = -1.0\nstart_until")
    with pytest.raises(ScenarioError, match=rf"^bad\.toml:{line_of('start = -1.0', text)}: start must be"):
        parse_scenario(text, "bad", "bad.toml")
    inline = GOOD[: GOOD.index("[[faults]]")] + GOOD[GOOD.index("[[robots]]") :]
    inline = inline.replace("duration = 5.0", 'duration = 5.0\nfaults = [{ robot = 7, kind = "stall" }]', 1)
    with pytest.raises(
        ScenarioError, match=rf"^bad\.toml:{line_of('faults =', inline)}: robot must be a robot, 1 to 3"
    ):
        parse_scenario(inline, "bad", "bad.toml")
    for value, message in (("3", "faults must be tables [[faults]]; got 3"), ("[3]", "must be a table, got 3")):
        text = inline.replace('[{ robot = 7, kind = "stall" }]', value)
        with pytest.raises(ScenarioError, match=rf"^bad\.toml:{line_of('faults =', text)}: .*{re.escape(message)}"):
            parse_scenario(text, "bad", "bad.toml")


def team_file(robots, controller, radio='preset = "zigbee-9600"'):
    members = "".join(
        f"[[robots]]\nstart = [0.0, {i}.0, 0.0]\n"
        f'path = {{ shape = "line", start = [0.0, {i}.0], end = [2.0, {i}.0] }}\ntiming = {{ duration = 10.0 }}\n\n'
        for i in range(robots)
    )
    return f'kind = "team"\nduration = 2.0\ncontroller = "{controller}"\n\n[radio]\n{radio}\n\n{members}'


@pytest.mark.parametrize("controller", ["virtual-structure", "cooperation", "graph-esm"])
def test_twenty_robots_do_not_fit_into_the_zigbee_of_the_thesis(controller):
    """Each message has four values: 20 × (9 + 8) bytes against the 96 of 0.1 s at 9600 baud."""
    parse_scenario(team_file(5, controller), "five")
    text = team_file(20, controller)
    with pytest.raises(ScenarioError) as caught:
        parse_scenario(text, "twenty", "twenty.toml")
    assert str(caught.value).startswith(f"twenty.toml:{line_of('[radio]', text)}: 20 robots")
    assert "340 bytes every 0.1 s do not fit into the 96 that 9600 baud carry; period must be >= 0.36 s" in str(
        caught.value
    )
    slower = text.replace('preset = "zigbee-9600"', 'preset = "zigbee-9600"\nperiod = 0.4')
    assert parse_scenario(slower, "twenty").radio.period == 0.4
    short = slower.replace("period = 0.4", "period = 0.35")
    with pytest.raises(ScenarioError, match=rf"^t\.toml:{line_of('period = 0.35', short)}: 20 robots"):
        parse_scenario(short, "twenty", "t.toml")


def test_a_law_that_does_not_fit_is_refused_when_it_runs_too():
    """A file without a controller loads; the law asked for later is checked at the start of its run."""
    scenario = parse_scenario(team_file(20, "virtual-structure").replace('controller = "virtual-structure"\n', ""), "t")
    with pytest.raises(RadioError, match="20 robots"):
        simulate(scenario, make_controller("cooperation"))


def test_the_controller_of_a_file_must_suit_its_graph():
    text = team_file(3, "cooperation", 'graph = "edges"\nedges = [[1, 2]]')
    with pytest.raises(ScenarioError, match=r"^bad\.toml:3: .*not connected"):
        parse_scenario(text, "bad", "bad.toml")
    with pytest.raises(ScenarioError, match=r"^bad\.toml:3: .*nothing of the leader reaches robots 1, 2, 3"):
        parse_scenario(text.replace("cooperation", "virtual-structure:leader=0"), "bad", "bad.toml")


def test_a_team_needs_two_robots():
    with pytest.raises(ScenarioError, match=r"^bad\.toml:\d+: a team needs at least two robots"):
        parse_scenario(team_file(1, "cooperation"), "bad", "bad.toml")


LINE = Member(start=(0.0, 0.0, 0.0), path=Line(start=(0.0, 0.0), end=(2.0, 0.0)), timing=Timing(duration=10.0))


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"radio": Radio(graph="star", hub=3)}, "hub: robots are 1 to 2, got 3"),
        ({"radio": Radio(period=0.07)}, "radio: period must be a multiple of 0.05 s, got 0.07"),
        ({"faults": (Fault(robot=3, kind="stall"),)}, "robot must be a robot, 1 to 2; got 3"),
        ({"robots": (LINE,)}, "at least two robots"),
        ({"robots": (LINE, replace(LINE, timing=Timing(speed=0.2)))}, "every timing has the same duration"),
    ],
)
def test_teams_built_in_python_are_checked_alike(changes, message):
    good: dict[str, Any] = {"name": "t", "robots": (LINE, LINE), "kind": "team"}
    Scenario(**good)
    with pytest.raises(ValueError, match=re.escape(message)):
        Scenario(**good | changes)


KEYS = [
    "preset",
    "graph",
    "hub",
    "edges",
    "period",
    "latency",
    "loss",
    "range",
    "baud",
    "robot",
    "kind",
    "other",
    "radio",
]
KEYS += ["faults", "sensing", "ramp", "start", "start_until", "duration", "noise_end", "filter_gain", "value_bytes"]
VALUES = ["3", '"x"', "[1]", "[]", "{}", "true", "nan", "-1", "0", "1e308", "[[1,2],[3]]", "[[1,2]]", "[{}]", "1e-300"]


@given(st.integers(0, GOOD.count("\n")), st.sampled_from(KEYS), st.sampled_from(VALUES), st.booleans())
@settings(max_examples=150)
def test_whatever_stands_in_a_line_the_error_is_a_scenario_error(line, key, value, instead):
    check_with_line(GOOD.splitlines(), line, key, value, instead)
