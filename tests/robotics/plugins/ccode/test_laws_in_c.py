"""Laws in C: the simulator's loop with the C in it drives the same runs."""

from dataclasses import replace

import pytest

import fuzzy
import robotics
from fuzzy.plugins.ccode.compiler import CompilerError, find_compiler, run_program
from fuzzy.plugins.ccode.numbertype import ExportError
from robotics.commands.application import main
from robotics.laws.rules.own_rules import OwnRules
from robotics.plugins.ccode.verification import verify_c_law
from robotics.plugins.ccode.writing import write_c_law

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


def test_the_monitor_of_passive_safety_is_not_left_out_in_silence(tmp_path):
    scenario = robotics.load_scenario("table-2-1")
    for one, law in ((scenario, "lyapunov:safe=yes"), (replace(scenario, safety="passive"), "lyapunov")):
        with pytest.raises(ExportError, match="in the simulator only; safe=no behind the law"):
            write_c_law(law, one, tmp_path)
        write_c_law("lyapunov:safe=no", one, tmp_path)


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
