"""Laws in C: the simulator's loop with the C in it drives the same runs."""

import ctypes
from dataclasses import replace

import numpy as np
import pytest

import fuzzy
import robotics
from fuzzy.plugins.ccode.compiler import CompilerError, find_compiler, run_program
from fuzzy.plugins.ccode.numbertype import ExportError
from robotics.commands.application import main
from robotics.laws.equation import SeenColumns
from robotics.laws.rules.own_rules import OwnRules
from robotics.plugins.ccode.guard import HandedOrder
from robotics.plugins.ccode.source import law_sources
from robotics.plugins.ccode.verification import CStep, verify_c_law
from robotics.plugins.ccode.writing import write_c_law
from robotics.simulation.safety.monitor import keep_one, note_order
from robotics.simulation.safety.opening import guard_on_board
from robotics.simulation.scenario.robots import load_robot
from robotics.world.environment.world import Disc
from robotics.world.radio.channel import AirColumns
from robotics.world.radio.description import Radio
from robotics.world.sensing.posture import Sensing
from robotics.world.vehicle.plant import TruthColumns

LAWS: tuple[str, ...] = (
    "fuzzy",
    "fuzzy-lateral",
    "fuzzy-literal",
    "lyapunov",
    "lyapunov:form=2.31",
    "lyapunov-thesis",
    "lqr",
    "pid",
)
LAWS += (
    "lqr:lead=0.1,smooth=0.3",
    "fuzzy:smooth=0.1",
    "esm:lead=0.05",
    "csm",
    "assm",
    "qssm",
    "esm",
    "esm:realisation=velocity",
    "qssm:discretisation=algebraic",
)
SCENARIOS = ("lyapunov-circle", "lyapunov-sine", "fuzzy-off-path", "reference", "table-2-1", "noisy-position")


@pytest.fixture(scope="module", autouse=True)
def _compiler():
    try:
        find_compiler()
    except CompilerError as error:
        pytest.skip(str(error))


@pytest.mark.parametrize("spec", ["fuzzy", "pid", "lyapunov:lead=auto,smooth=0.2", "lyapunov:estimator=kalman"])
def test_the_c_drives_the_same_run(tmp_path, spec):
    scenario = robotics.load_scenario("table-2-1")  # its posture is measured with noise
    proof = verify_c_law(write_c_law(spec, scenario, tmp_path), [scenario], seeds=[1, 2])
    assert proof.holds
    assert min(proof.drives[0].greatest, proof.drives[0].fine) <= 1e-9
    assert proof.drives[0].steps == 2 * 501


def test_what_c_cannot_know_it_is_handed(tmp_path):
    sides = {"right": fuzzy.Triangle(-3.0, -1.0, 1.0), "left": fuzzy.Triangle(-1.0, 1.0, 3.0)}
    inputs = [fuzzy.Variable("cross_track", (-1, 1), sides)]
    inputs += [fuzzy.Variable(name, (-5, 5), {}) for name in ("target_curvature:0.3", "lag")]
    bend = {side: fuzzy.Linear((-1.0, 0.2, 0.0), trim) for side, trim in (("right", 2.0), ("left", -2.0))}
    dv = fuzzy.Variable("dv", (-1, 1), {"catch up": fuzzy.Linear((0.0, 0.0, 0.5), 0.0)})
    rules = [f"if cross_track is {side} then bend is {side} and dv is catch up" for side in sides]
    by_path = fuzzy.Sugeno(inputs, [fuzzy.Variable("bend", (-10, 10), bend), dv], rules, name="by path")
    scenario = robotics.load_scenario("table-2-1")
    law = OwnRules(rule_base=by_path, lead="auto", smooth=0.1)
    files = write_c_law(law, scenario, tmp_path / "out", name="mine")
    assert files.sources.inputs[-3:] == ("cross_track", "target_curvature_0_3", "lag")
    proof = verify_c_law(files, [scenario], seeds=[1, 2])
    assert proof.holds
    assert "m, cross_track: the robot is so far to the left of its path" in files.sources.header


def test_odometry_whose_stamp_stays_the_same_grows_old(tmp_path):
    files = write_c_law("lyapunov", robotics.load_scenario("table-2-1"), tmp_path)
    program = tmp_path / "watched.c"
    stamps = "0, 0, 7, 8, 8, 8, 8, 8, 9, 0, 0, 0, 0"  # none yet; it comes, is repeated, comes; the count overflows
    program.write_text(
        '#include "lyapunov.h"\n#include <stdio.h>\nint main(void) {\n    lyapunov_watch watch = {0};\n'
        f"    const unsigned long stamps[13] = {{{stamps}}};\n"
        '    for (int k = 0; k < 13; k++) printf("%d", lyapunov_fresh(&watch, stamps[k], 3));\n    return 0;\n}\n',
        encoding="utf-8",
    )
    sources = [program, *(file for file in files.files if file.suffix == ".c")]
    assert run_program(find_compiler().compile(sources, tmp_path / "watched")) == "0011110011110"


def test_a_changed_gain_is_seen(tmp_path):
    scenario = robotics.load_scenario("lyapunov-sine")
    files = write_c_law("lyapunov", scenario, tmp_path)
    source = files.files[1]
    text = source.read_text(encoding="utf-8")
    assert "KY = 10.0;" in text
    source.write_text(text.replace("KY = 10.0;", "KY = 10.000001;"), encoding="utf-8")
    proof = verify_c_law(files, [scenario], seeds=[1])
    assert proof.holds is False
    assert 1e-9 < proof.greatest < 1e-3


def test_float_is_told(tmp_path):
    scenario = robotics.load_scenario("lyapunov-sine")
    proof = verify_c_law(write_c_law("esm:realisation=velocity", scenario, tmp_path, "float"), [scenario], seeds=[1])
    assert proof.holds is None
    assert 0 < proof.greatest < 0.01


@pytest.mark.parametrize("spec", ["nmpc", "mppi", "pursuit", "cooperation", "pdc", "obstacle-avoidance"])
def test_laws_that_cannot_be_written_are_refused(tmp_path, spec):
    scenario = robotics.load_scenario("table-2-1")
    if spec not in robotics.CATALOGUE:
        pytest.skip(f"there is no {spec}")
    with pytest.raises(ExportError, match=r"those that can be: fuzzy .*lyapunov, lqr, pid, csm"):
        write_c_law(spec, scenario, tmp_path / "out")
    assert not (tmp_path / "out").exists()


def test_another_robot_is_refused(tmp_path):
    scenario = robotics.load_scenario("table-2-1")
    robot = replace(scenario.setting.robots[0], wheel_radius=0.05)
    other = robotics.load_scenario("table-2-1")
    object.__setattr__(other, "setting", replace(other.setting, robots=(robot,)))
    with pytest.raises(ExportError, match="drives other robots"):
        verify_c_law(write_c_law("pid", scenario, tmp_path), [other])


def test_a_number_type_of_rule_bases_only_is_refused(tmp_path):
    with pytest.raises(ExportError, match=r"q16\.16"):
        write_c_law("pid", robotics.load_scenario("table-2-1"), tmp_path, "q16.16")


def test_the_command_says_what_cannot_be(tmp_path, capsys):
    assert main(["export", "c", "nmpc", "-o", str(tmp_path / "out")]) == 2
    assert "nmpc cannot be written in C" in capsys.readouterr().err


@pytest.mark.long
@pytest.mark.parametrize("spec", LAWS)
def test_every_law_on_every_scenario(tmp_path, spec):
    scenarios = [robotics.load_scenario(name) for name in SCENARIOS]
    proof = verify_c_law(write_c_law(spec, scenarios[0], tmp_path), scenarios, seeds=[1, 2, 3])
    assert proof.holds, [(d.scenario, d.greatest, d.fine) for d in proof.drives]


def with_a_disc_on_the_way(name, robot="etsro"):
    """A packaged scenario with a disc where its robot shall be after 8 s."""
    scenario, model = robotics.load_scenario(name), load_robot(robot)
    scenario = replace(scenario, robots=(replace(scenario.robots[0], robot=model.robot, model=model),))
    on = scenario.setting.references.at(8.0)
    return replace(scenario, duration=11.0, obstacles=(Disc(radius=0.2, position=(float(on.x[0]), float(on.y[0]))),))


@pytest.mark.parametrize(
    ("name", "robot", "law"),
    [
        ("reference", "etsro", "lyapunov"),  # sonars
        pytest.param("table-2-1", "etsro", "pid", marks=pytest.mark.long),  # a pose sensor beside odometry
        pytest.param("reference", "mir100", "fuzzy", marks=pytest.mark.long),  # beams all round
    ],
)
def test_the_monitor_of_passive_safety_in_c_stops_before_the_same_disc(tmp_path, name, robot, law):
    scenario = with_a_disc_on_the_way(name, robot)
    files = write_c_law(f"{law}:safe=yes", scenario, tmp_path)
    assert ("odo_x" in files.sources.inputs) == (name == "table-2-1")
    assert [" no sensor looks at " in told for told in files.sources.blind] == [True] * (robot == "etsro")
    guarded, free = (robotics.simulate(scenario, f"{law}:safe={safe}", [1]) for safe in ("yes", "no"))
    assert np.hypot(guarded["x"] - free["x"], guarded["y"] - free["y"]).max() > 0.3  # it acts
    assert verify_c_law(files, [scenario], seeds=[1]).holds


@pytest.mark.parametrize(
    ("name", "seconds"),
    [
        ("three-cross", 24),  # nothing but the others, whom it hears
        pytest.param("obstacles-on-two-paths", 18, marks=pytest.mark.long),
    ],
)
def test_the_monitors_of_a_team_in_c_hear_each_other_as_those_of_the_loop(tmp_path, name, seconds):
    scenario = replace(robotics.load_scenario(name), duration=float(seconds), sensing=Sensing(posture="odometry"))
    scenario = replace(scenario, radio=Radio(period=0.1, latency=0.05, jitter=0.1, loss=0.2))
    guarded, free = (robotics.simulate(scenario, f"lyapunov:safe={safe}", [1]) for safe in ("yes", "no"))
    assert np.hypot(guarded["x"] - free["x"], guarded["y"] - free["y"]).max() > 0.1  # they act
    proof = verify_c_law(write_c_law("lyapunov:safe=yes", scenario, tmp_path), [scenario], seeds=[1])
    assert proof.drives[0].greatest == 0.0


def test_of_a_law_that_cannot_be_written_the_monitor_is(tmp_path):
    scenario = replace(robotics.load_scenario("three-cross"), duration=24.0)
    files = write_c_law("fuzzy-team:safe=yes", scenario, tmp_path)
    assert [file.name for file in files.files] == ["fuzzy_team_monitor.h", "fuzzy_team_monitor.c"]
    assert "wish_v and wish_w are what a law of yours wants" in files.sources.blind[-1]
    guarded, free = (robotics.simulate(scenario, HandedOrder(safe=safe), [1]) for safe in ("yes", "no"))
    assert np.hypot(guarded["x"] - free["x"], guarded["y"] - free["y"]).max() > 0.1  # it acts
    assert verify_c_law(files, [scenario], seeds=[1]).drives[0].greatest == 0.0


@pytest.mark.long
def test_a_changed_number_of_the_monitor_in_c_is_seen(tmp_path):
    scenario = with_a_disc_on_the_way("reference")
    files = write_c_law("lyapunov:safe=yes", scenario, tmp_path)
    source = files.files[1]
    source.write_text(
        source.read_text(encoding="utf-8").replace("RAY_HALF = 0.36", "RAY_HALF = 0.05"), encoding="utf-8"
    )
    assert verify_c_law(files, [scenario], seeds=[1]).holds is False


@pytest.mark.parametrize(
    ("name", "me", "robots", "others"),
    [("reference", 0, 1, None), ("reference", 0, 1, 0.2), ("three-cross", 1, 3, None)],
)
def test_the_monitor_in_c_is_that_of_the_loop_period_by_period(tmp_path, name, me, robots, others):
    """Readings and messages at random, orders that the law wants, and periods in which the robot was let stand."""
    scenario, steps = replace(robotics.load_scenario(name), sensing=Sensing(posture="odometry")), {}
    scenario = replace(scenario, others_speed=others)
    for name, safe in (("guarded", "yes"), ("plain", "no")):
        files = write_c_law(f"lyapunov:safe={safe}", scenario, tmp_path, name=name)
        codes = [file for file in files.files if file.suffix == ".c"]
        flags = ("-O2", "-ffp-contract=off", "-shared", "-fPIC")
        steps[name] = CStep(files.sources, "double", find_compiler().compile(codes, tmp_path / f"{name}.so", *flags))
    stood = ctypes.CDLL(str(tmp_path / "guarded.so"))["guarded_stood"]
    stood.restype = None
    setting, law, rng = scenario.setting, robotics.make_controller("lyapunov:safe=yes"), np.random.default_rng(1)
    guard, period = guard_on_board(setting, law), setting.period
    states = {name: step.state(me) for name, step in steps.items()}
    truth, seen, order = (np.zeros((n, robots)) for n in (TruthColumns.size, SeenColumns.size, 2))
    here, acted, pose, air = TruthColumns(truth, me), 0, np.zeros(3), AirColumns(guard.air.heard)
    age, heard = np.full(robots, np.inf), np.full((robots, 7), np.nan)
    for k in range(400):
        if 100 <= k < 105:
            stood(ctypes.byref(states["guarded"]))
            note_order(guard, me, k, period, 0.0, 0.0)
            order[:] = 0.0
            continue
        v, w = order[:, me].tolist()
        pose = pose + period * np.array([v * np.cos(pose[2]), v * np.sin(pose[2]), w])
        here.odo_x, here.odo_y, here.odo_heading = pose
        seen[:5, me] = (*pose, v, w)
        ranges = rng.uniform(0.05, 3.0, 4)
        ranges[ranges > 2] = np.inf
        aim = (*(pose[:2] + rng.normal(0, 0.3, 2)), pose[2] + rng.normal(), 0.4, 0.0)
        age += period
        if robots > 1 and rng.random() < 0.3:  # another says where it is, how fast, and how fast it may turn
            sender, away, bearing = 2 * rng.integers(2), rng.uniform(0.5, 2.0), rng.uniform(-np.pi, np.pi)
            age[sender] = rng.choice([0.05, 0.15])
            place = pose[:2] + away * np.array([np.cos(bearing), np.sin(bearing)])
            bounds = rng.uniform(0, 0.5), rng.uniform(-0.2, 0), rng.uniform(0, 2), rng.uniform(0, 0.8)
            heard[sender] = (*place, bearing, *bounds)
        if robots > 1:
            air.age[me], air.values[:, me] = age, heard.T
        names = ["x", "y", "heading", "v", "w", "at_x", "at_y", "at_heading", "at_v", "at_w", "ranges[4]"]
        names += [f"age[{robots}]", f"heard[{robots}][7]"]
        numbers = dict(zip(names, (*pose, v, w, *aim, ranges, age, heard.ravel()), strict=True))
        said = {}
        for name, step in steps.items():
            rows = [numbers[field] for field in step.sources.inputs]
            asked, output = step.Input.from_buffer_copy(np.hstack(rows).tobytes()), step.Output()
            assert step.step(ctypes.byref(states[name]), ctypes.byref(asked), ctypes.byref(output)) == 1
            said[name] = output
        order[:, me] = said["plain"].v, said["plain"].w
        acted += keep_one(guard, me, k, period, robots, truth, seen, np.tile(ranges, (robots, 1)), order)
        assert order[:, me].tolist() == [said["guarded"].v, said["guarded"].w], k
        if robots > 1:
            assert guard.said[:, me].tolist() == list(said["guarded"].message), k
    assert 50 < acted < 390


def test_passive_safety_of_robots_that_differ_or_have_no_sensors_is_not_left_out_in_silence(tmp_path):
    team = robotics.load_scenario("three-cross")
    mir = load_robot("mir100")
    mixed = replace(team, robots=(*team.robots[:2], replace(team.robots[2], robot=mir.robot, model=mir)))
    with pytest.raises(ExportError, match=r"of robots that are alike, and those of .* differ.*accepted: robots of one"):
        write_c_law("lyapunov:safe=yes", mixed, tmp_path)
    write_c_law("lyapunov:safe=no", mixed, tmp_path)
    setting = replace(robotics.load_scenario("reference").setting, sensors=({},), safety="passive")
    with pytest.raises(ExportError, match="needs range sensors"):
        law_sources(robotics.make_controller("lyapunov"), setting, "lyapunov")
