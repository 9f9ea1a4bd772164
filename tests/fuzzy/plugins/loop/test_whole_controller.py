"""A loop that begins where a PID stands, is tuned, and is written in C."""

import json
import shutil
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from fuzzy import PID, LoopError, Scale, TransferFunction, read_fis, step_response, tune_loop, write_fis
from fuzzy.commands.application import main
from fuzzy.plugins.designer.starts.control import rule_table
from fuzzy.plugins.loop.controllercode import controller_code, prove_controller, write_controller
from fuzzy.plugins.loop.equivalent import scale_from_pid
from fuzzy.plugins.loop.response import Loop, clipping
from fuzzy.plugins.loop.tuning import plants_around
from fuzzy.tuning.parameter import TuningError

PLANT = TransferFunction([2], [3, 1], 0.8)
needs_compiler = pytest.mark.skipif(shutil.which("cc") is None, reason="there is no C compiler")
DISTURBED: dict[str, Any] = {"reference": 0.0, "disturbance": (1.0, 0.4), "duration": 12.0}


@given(
    kp=st.floats(0.2, 1.2),
    ti=st.floats(1.5, 8.0),
    td=st.floats(0.05, 0.3),
    kind=st.sampled_from(["pd", "pi", "pid"]),
    terms=st.sampled_from([5, 7]),
)
def test_the_rules_act_as_the_pid_does(kp, ti, td, kind, terms):
    """A disturbance is answered alike, to rounding, whatever the gains."""
    pid = {"pd": PID(kp, 0.0, kp * td), "pi": PID(kp, kp / ti), "pid": PID(kp, kp / ti, kp * td)}[kind]
    table = rule_table(kind, terms)
    loop = Loop(reference=0.0, disturbance=0.4, disturbance_time=1.0, duration=12.0)
    scale, deviation = scale_from_pid(table, pid, PLANT, loop)
    found, wanted = step_response(table, PLANT, scale=scale, **DISTURBED), step_response(pid, PLANT, **DISTURBED)
    assert deviation < 1e-9
    assert max(found.clipped) == 0
    assert np.allclose(found.output, wanted.output, rtol=0, atol=1e-9)
    # The cause taken away: with factors that are not the PID's the loop is another.
    other = step_response(
        table, PLANT, scale=Scale(Ke=scale.Ke, Kde=2 * scale.Kde, Ku=scale.Ku, Kdu=scale.Kdu), **DISTURBED
    )
    assert not np.allclose(other.output, wanted.output, rtol=0, atol=1e-6)


def test_a_step_of_the_reference_is_answered_by_a_pid_whose_proportional_part_sees_the_output_alone():
    pid, table = PID(0.9, 0.3), rule_table("pi", 5)
    scale, _ = scale_from_pid(table, pid, PLANT)
    found = step_response(table, PLANT, scale=scale)
    # The control of that PID, from what was measured: u = -Kp y + Ki times the sum of the error, as the loop sums it
    summed = np.cumsum(found.error) * found.loop.period
    wanted = pid.Kp * (found.error - found.error[0]) + pid.Ki * summed
    assert np.allclose(found.control, wanted, rtol=0, atol=1e-12)


def test_rules_that_are_nowhere_linear_come_near():
    scale, deviation = scale_from_pid(rule_table("pd", 3), PID(3.0, 0.0, 0.5), TransferFunction([1], [1, 1], 0.2))
    assert 1e-6 < deviation < 0.02
    assert scale.Ku > 0


@pytest.mark.parametrize(
    ("kind", "pid", "words"),
    [
        ("pd", PID(1.0, 0.5), "an integral gain, which needs an output du"),
        ("pi", PID(1.0, 0.0), "no integral gain"),
        ("pi", PID(1.0, 0.5, 0.2), "a derivative gain, which needs an output u"),
        ("pid", PID(0.5, 1.0, 1.0), "a larger Kp, or less Kd"),
        ("pi", PID(50.0, 200.0), "the PID's own loop cannot be taken as a start"),
    ],
)
def test_what_cannot_act_as_the_pid_is_said(kind, pid, words):
    with pytest.raises(LoopError, match=words.replace(",", ",?")):
        scale_from_pid(rule_table(kind, 5), pid, PLANT)


def test_the_share_of_clipped_samples_is_counted():
    done = step_response(rule_table("pi", 5), PLANT, scale=Scale(Ke=2.0, Kde=1.0, Kdu=0.3), limits=(-0.7, 0.7))
    outside = np.mean(np.abs(done.known) > 1 + 1e-9, axis=0)
    assert done.clipped == pytest.approx(tuple(outside))
    assert done.clipped[0] > 0.05
    assert done.limited == np.mean(np.abs(done.control) >= 0.7) > 0.01
    said = " ".join(clipping(rule_table("pi", 5), done))
    assert f"In {100 * outside[0]:.0f} % of the samples error lay outside its universe" in said
    assert "the actuator stood at a limit" in said


def test_a_tuned_loop_costs_less_and_the_same_seed_finds_the_same():
    table = rule_table("pi", 3)
    first, second = (tune_loop(table, PLANT, move=["factors"], evaluations=25, seed=4) for _ in range(2))
    costs = first.evaluations.costs
    assert costs.min() < 0.8 * costs[0]
    assert np.array_equal(costs, second.evaluations.costs)
    assert first.scale == second.scale != Scale()
    assert first.fis == table  # the factors alone moved
    assert tune_loop(table, PLANT, evaluations=1).fis == table


def test_robustness_is_of_other_plants():
    """Gain, dead time and speed: each plant has another step response, and the mean of their costs is the cost."""
    around = plants_around(PLANT, 0.25)
    steps = [step_response(PID(0.5, 0.1), plant, duration=20.0).output for plant in around]
    assert len(around) == 5
    assert all(not np.allclose(steps[0], other, atol=1e-3) for other in steps[1:])
    slow = TransferFunction([2], [3.75, 1], 0.8)
    assert np.allclose(steps[4], step_response(PID(0.5, 0.1), slow, duration=20.0).output)
    loud = TransferFunction([2.5], [3, 1], 0.8)
    assert np.allclose(steps[1], step_response(PID(0.5, 0.1), loud, duration=20.0).output)
    assert plants_around(PLANT, 0) == [PLANT]
    with pytest.raises(TuningError, match="spread"):
        tune_loop(rule_table("pi", 3), PLANT, spread=-1.0)
    with pytest.raises(TuningError, match="factors"):
        tune_loop(rule_table("pi", 3), PLANT, move=["factor"])


@needs_compiler
@pytest.mark.parametrize("kind", ["pd", "pi", "pid"])
@pytest.mark.parametrize("number", ["double", "float"])
def test_the_controller_in_c_is_the_same(kind, number):
    """Sample by sample, through clamping, limits and inputs outside their universes."""
    table = rule_table(kind, 5)
    loop = Loop(low=-1.5, high=1.0, rate_filter=0.05, scale=Scale(Ke=1.2, Kde=0.4, Ku=2.0, Kdu=1.5))
    proof = prove_controller(controller_code(table, loop, number=number), table, loop)
    assert proof.holds
    assert proof.samples == 20_000
    assert proof.limited > 0.1
    assert proof.greatest <= {"double": 1e-12, "float": 1e-4}[number] * proof.span


@needs_compiler
def test_a_proof_can_fail(tmp_path):
    """Another clamping, filter or factor than the simulation's is seen."""
    table, loop = rule_table("pid", 5), Loop(low=-1.0, high=1.0, rate_filter=0.05, scale=Scale(Kdu=1.5))
    files = controller_code(table, loop)
    source = f"{files.name}_control.c"
    for right, wrong in (
        ("total = c->total;\n            u", "u"),
        ("(error - c->error)", "(error + c->error)"),
        ("du > 0) {", "du < 0) {"),
    ):
        assert right in files.texts[source]
        broken = files._replace(texts={**files.texts, source: files.texts[source].replace(right, wrong)})
        if right.startswith("total"):  # no input asks for the sum here: what is left of it changes nothing
            assert prove_controller(broken, table, loop).holds
        else:
            assert not prove_controller(broken, table, loop).holds
    assert [path.name for path in write_controller(files, tmp_path / "new")] == [*files.texts]


def test_a_loop_without_limits_is_written_with_infinities():
    files = controller_code(rule_table("pi", 3), Loop(), name="tank")
    assert "#define TANK_PERIOD 0.02" in files.texts["tank_control.h"]
    assert "HUGE_VAL" in files.texts["tank_control.c"]
    assert "#include <math.h>" in files.texts["tank_control.c"]
    with pytest.raises(LoopError, match=r"double or float, got 'q16\.16'"):
        controller_code(rule_table("pi", 3), Loop(), number="q16.16")


@needs_compiler
def test_the_command_begins_tunes_writes_and_proves(tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    write_fis(rule_table("pi", 5), "pi.fis")
    loop = ["--plant", "2; 3 1; 0.8", "--limits", "-1,1"]
    assert main(["step", "pi.fis", *loop, "--from-pid", "--tune", "11", "-o", "tuned.fis", "--json"]) == 0
    told = json.loads(capsys.readouterr().out)
    assert told["tuned"]["cost"] <= told["tuned"]["before"]
    # What was written is the loop: it needs no option any more, and answers alike.
    assert main(["step", "tuned.fis", "--c", "out", "--json"]) == 0
    again = json.loads(capsys.readouterr().out)
    name = read_fis("tuned.fis").name
    assert again["responses"][name]["output"] == pytest.approx(told["responses"][f"{name}, tuned"]["output"])
    assert again["proof"]["holds"]
    assert sorted(path.name for path in Path("out").iterdir()) == sorted(
        f"fuzzy_pi_5x5{each}" for each in (".c", ".h", "_control.c", "_control.h")
    )
    assert main(["step", "pi.fis", *loop, "--from-pid", "--pid", "none"]) == 2
    assert "--from-pid needs a PID" in capsys.readouterr().err
    assert main(["step", "pi.fis", *loop, "--tune", "5", "--move", "factor"]) == 2
    assert "did you mean 'factors'" in capsys.readouterr().err
