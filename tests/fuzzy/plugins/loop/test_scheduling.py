"""Gain scheduling: plants that an operating variable changes, and rules that are a PID at each of its values."""

import json
import shutil
from dataclasses import replace
from math import exp
from pathlib import Path
from typing import Any, cast

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.optimize import minimize

from fuzzy import (
    PID,
    FunctionPlant,
    LoopError,
    PlantError,
    ScheduledTransferFunction,
    Sugeno,
    TransferFunction,
    Variable,
    pid_over_points,
    read_fis,
    schedule_from_pids,
    step_response,
    tune_loop,
    write_fis,
)
from fuzzy.commands.application import main
from fuzzy.plugins.loop.controller import roles_of
from fuzzy.plugins.loop.controllercode import controller_code, prove_controller
from fuzzy.plugins.loop.keptloop import kept_settings, loop_of, transfer_of
from fuzzy.plugins.loop.nlsys import linear_controller, to_nlsys
from fuzzy.plugins.loop.plantfile import PLANT_EXAMPLES, plant_of_text, read_plant
from fuzzy.plugins.loop.response import Loop
from fuzzy.plugins.loop.scheduledplant import Course
from fuzzy.plugins.loop.scheduledrules import pids_of

MIXING = cast(ScheduledTransferFunction, PLANT_EXAMPLES["mixing"].whole)
FLOW = {"flow": "scheduling"}
POINTS = (0.5, 1.0, 2.0, 4.0)
needs_compiler = pytest.mark.skipif(shutil.which("cc") is None, reason="there is no C compiler")


def begun(*names: str) -> Sugeno:
    """A rule base of these variables, without rules."""
    inputs = [Variable(name, (-1.0, 1.0)) for name in names if name not in ("u", "du")]
    return Sugeno(inputs, [Variable(name, (-1.0, 1.0), {"z": 0.0}) for name in names if name in ("u", "du")], name="s")


def tank(x, u, t, flow):
    return [(u - x[0]) * flow / 2]


@given(
    st.lists(st.tuples(st.floats(0.1, 2.0), st.floats(0.02, 1.0), st.floats(0.0, 0.2)), min_size=2, max_size=5),
    st.floats(0.05, 3.0),
    st.data(),
)
@settings(max_examples=40, deadline=None)
def test_the_rules_are_the_pid_of_each_point_and_a_blend_between(gains, first, data):
    points = [first * 1.7**k for k in range(len(gains))]
    plant = ScheduledTransferFunction(points, [TransferFunction([1], [1, q]) for q in points], gains)
    rules = schedule_from_pids(begun("error", "flow", "error_sum", "error_rate", "u"), plant, Loop(), FLOW)
    e, v, total, rate = data.draw(st.tuples(*[st.floats(-50, 50)] * 4))
    told = [kp * e + ki * total + kd * rate for kp, ki, kd in gains]
    assert rules([[e, q, total, rate] for q in points])[:, 0] == pytest.approx(told, rel=1e-9, abs=1e-9)
    v = points[0] + abs(v) / 50 * (points[-1] - points[0])
    assert rules([e, v, total, rate])[0] == pytest.approx(np.interp(v, points, told), rel=1e-9, abs=1e-9)
    for beyond, end in ((points[0] - 5, told[0]), (points[-1] + 5, told[-1])):
        assert rules([e, beyond, total, rate])[0] == pytest.approx(end, rel=1e-9, abs=1e-9)


@pytest.mark.parametrize("limits", [(-np.inf, np.inf), (-0.3, 1.2)])
@pytest.mark.parametrize("names", [("error", "flow", "error_sum", "u"), ("flow", "error", "u", "du")])
def test_in_the_loop_it_is_the_pid_of_the_point(names, limits):
    """By the error's sum through the actuator's limits as well, by an integrated output where there are none."""
    rules = schedule_from_pids(begun(*names), MIXING, Loop(duration=40.0), FLOW)
    for value, pid in pids_of(MIXING, 0.08).items():
        loop = {"duration": 40.0, "disturbance": (20.0, 0.4), "operating": value, "limits": limits}
        found, wanted = step_response(rules, MIXING, roles=FLOW, **loop), step_response(pid, MIXING, **loop)
        gap = np.abs(found.output - wanted.output).max()
        assert gap < (1e-9 if "du" not in names or np.isinf(limits[0]) else 0.05)
        assert max(found.clipped) == 0 or not np.isinf(limits[0])
    # The cause taken away: the PID of another point is another loop.
    other = step_response(pids_of(MIXING, 0.08)[0.5], MIXING, duration=40.0, operating=4.0)
    assert (
        np.abs(other.output - step_response(rules, MIXING, roles=FLOW, duration=40.0, operating=4.0).output).max() > 0.1
    )


def test_without_the_schedule_no_pid_does_as_well():
    """Not the best of the points' PIDs, and not the PI that is optimal over all points at once."""
    rules = schedule_from_pids(begun("error", "flow", "u", "du"), MIXING, Loop(duration=60.0), FLOW)

    def costs(controller, **more):
        runs = [step_response(controller, MIXING, operating=v, duration=60.0, sample_time=0.12, **more) for v in POINTS]
        return np.array([done.figures.ise if done.figures.ise is not None else 1e3 for done in runs])

    scheduled = costs(rules, roles=FLOW)

    def cost(k):
        return float((costs(PID(exp(k[0]), exp(k[1]))) / scheduled).mean())

    best = minimize(cost, np.log([0.9, 0.3]), method="Nelder-Mead", options={"maxfev": 40})
    assert best.fun > 1.1
    one = pid_over_points(MIXING, Loop(duration=60.0))
    assert one in [replace(pid, rule=one.rule) for pid in pids_of(MIXING, 0.12).values()]
    alone = {v: step_response(one, MIXING, operating=v, duration=60.0).figures for v in (0.5, 4.0)}
    ours = {v: step_response(rules, MIXING, operating=v, duration=60.0, roles=FLOW).figures for v in (0.5, 4.0)}
    assert alone[0.5].overshoot > 40 > 5 > ours[0.5].overshoot
    assert alone[4.0].settling_time > 8 * ours[4.0].settling_time


def test_a_course_is_followed_and_a_step_of_it_is_felt():
    """A gain of the plant's input that steps, against the closed form; coefficients between points are linear."""
    plant = ScheduledTransferFunction((1, 3), [TransferFunction([1], [1, 1]), TransferFunction([3], [1, 1])])
    assert plant == plant_of_text("1: 1; 1 1 | 3: 3; 1 1")
    assert plant.at(2.0) == TransferFunction([2], [1, 1])
    assert (plant.at(0.0), plant.at(9.0)) == (plant.plants[0], plant.plants[1])
    assert plant_of_text(str(plant)) == plant
    steps = [(2.0, 1.0), (2.0, 3.0)]
    done = step_response(PID(0.0), plant, operating=steps, disturbance=(0.0, 1.0), duration=6.0, sample_time=0.01)
    t = done.time
    wanted = np.where(t <= 2, 1 - np.exp(-t), 3 - (3 - (1 - exp(-2.0))) * np.exp(-(t - 2)))
    assert np.allclose(done.output, wanted, atol=1e-9)
    assert set(done.operating) == {1.0, 3.0}
    ramp = step_response(PID(0.0), plant, operating="1,1 5,3", duration=6.0, sample_time=0.01).operating
    assert np.allclose(ramp, np.interp(t, [1, 5], [1, 3]))
    # With a dead time that changes, and held at a value, it is the transfer function of that value.
    still = step_response(PID(0.8, 0.3), MIXING, operating="0,1.5 60,1.5000001", duration=30.0)
    assert np.allclose(still.output, step_response(PID(0.8, 0.3), MIXING.at(1.5), duration=30.0).output, atol=1e-6)


def test_a_python_plant_takes_the_variable(tmp_path):
    """Without the pipe it is the same tank as the transfer functions, at points and along a course."""
    function = FunctionPlant(tank, operating=(0.5, 1, 4), gains=[(2, 1)] * 3)
    table = ScheduledTransferFunction((0.5, 4), [TransferFunction([q / 2], [1, q / 2]) for q in (0.5, 4)])
    for operating in (0.5, 2.0, "1,0.5 9,4"):
        plants: tuple[Any, ...] = (function, table)
        runs = [step_response(PID(2, 1), plant, operating=operating, duration=10.0) for plant in plants]
        assert np.allclose(runs[0].output, runs[1].output, atol=1e-2 if operating == "1,0.5 9,4" else 1e-6)
    path = tmp_path / "tank.py"
    points = "operating = [0.5, 4]\ngains = [[2, 1, 0], [3, 2, 0]]\n"
    path.write_text(points + "def plant(x, u, t, v):\n    return [(u - x[0]) * v / 2]\n", encoding="utf-8")
    plant = read_plant(path)
    assert pids_of(plant, 0.1) == {0.5: PID(2, 1, 0), 4.0: PID(3, 2, 0)}
    rules = schedule_from_pids(begun("error", "flow", "error_sum", "u"), plant, Loop(), FLOW)
    assert rules([0.1, 4.0, 0.2])[0] == pytest.approx(0.7)
    toml = tmp_path / "tank.toml"
    rows = ["at = 1", "denominator = [1, 1]", "at = 2", "denominator = [2, 1]\ndead_time = 0.1\ngains = [1, 2]"]
    text = "[[point]]\nnumerator = [1]\n{}\n{}\n" * 2
    toml.write_text(text.format(*rows), encoding="utf-8")
    assert read_plant(toml) == plant_of_text("1: 1; 1 1 | 2: 1; 2 1; 0.1; 1 2")


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("1: 1; 1 1 | 1: 1; 2 1", "finite and ascending"),
        ("1: 1; 1 1 | 2: 1; 1 1 1", "one degree"),
        ("1: 1; 1 1; 0; 1 2 3 4 | 2: 1; 1 1", "gains Kp, Ki, Kd"),
        ("x: 1; 1 1", "operating must be numbers"),
    ],
)
def test_points_that_make_no_plant_are_said(text, words):
    with pytest.raises(PlantError, match=words):
        plant_of_text(text)


def test_what_is_missing_is_said():
    rules = schedule_from_pids(begun("error", "flow", "u", "du"), MIXING, None, FLOW)
    with pytest.raises(LoopError, match="flow is the operating variable"):
        step_response(rules, TransferFunction([1], [1, 1]), roles=FLOW)
    with pytest.raises(PlantError, match="needs its operating variable"):
        step_response(PID(1.0), MIXING)
    with pytest.raises(PlantError, match="needs its operating variable"):
        step_response(PID(1.0), FunctionPlant(tank, operating=(1,)))
    for wrong in ("1,2,3", "5,1 1,2", "fast", "nan", ""):
        with pytest.raises(PlantError, match="TIME,VALUE"):
            Course.of(wrong)
    with pytest.raises(LoopError, match="for Ki an output du or the input error_sum"):
        schedule_from_pids(begun("error", "flow", "u"), MIXING, None, FLOW)
    with pytest.raises(LoopError, match="an input with the role scheduling, over two points"):
        schedule_from_pids(begun("error", "u", "du"), MIXING)
    with pytest.raises(LoopError, match="give the gains at each"):
        schedule_from_pids(begun("error", "flow", "u", "du"), FunctionPlant(tank, operating=(1, 2)), None, FLOW)


def test_a_tuning_is_of_all_points():
    """The cost of the start is the mean over points and course, each against its own PID."""
    loop = Loop(duration=30.0, operating=Course.of("5,0.5 20,4"))
    rules = schedule_from_pids(begun("error", "flow", "u", "du"), MIXING, loop, FLOW)
    found = tune_loop(rules, MIXING, loop, roles=FLOW, move=["factors"], spread=0.0, evaluations=1)
    alike = [step_response(pid, MIXING, operating=v, duration=30.0) for v, pid in pids_of(MIXING, 0.06).items()]
    parts = [1 + each.figures.overshoot / 10 + 0.2 for each in alike]
    moving = step_response(rules, MIXING, roles=FLOW, duration=30.0, operating=loop.operating).figures
    parts.append(1 + moving.overshoot / 10 + 0.2)
    assert found.evaluations.costs[0] == pytest.approx(np.mean(parts), rel=1e-6)
    assert found.before.ise == pytest.approx(moving.ise)
    tuned = tune_loop(rules, MIXING, loop, roles=FLOW, spread=0.0, evaluations=13)
    assert tuned.evaluations.costs.min() < tuned.evaluations.costs[0]


@needs_compiler
@pytest.mark.parametrize("names", [("error", "flow", "error_sum", "u"), ("flow", "error", "error_rate", "u", "du")])
@pytest.mark.parametrize("number", ["double", "float"])
def test_the_c_takes_the_variable(names, number):
    rules = schedule_from_pids(begun(*names), MIXING, None, FLOW)
    loop, roles = Loop(low=-0.5, high=1.5, rate_filter=0.1, operating=Course.of(1.0)), roles_of(rules, FLOW)
    files = controller_code(rules, loop, roles, number=number)
    assert (
        f"s_control(s_controller *c, {number} reference, {number} measured, {number} operating)"
        in files.texts["s_control.h"]
    )
    assert prove_controller(files, rules, loop, roles).holds
    # The cause taken away: a C that does not hear of the variable is another controller.
    source = files.texts["s_control.c"]
    deaf = source.replace("= operating *", "= 0 * operating *")
    assert deaf != source
    broken = files._replace(texts={**files.texts, "s_control.c": deaf})
    assert not prove_controller(broken, rules, loop, roles).holds


def test_python_control_takes_it_at_one_value():
    pytest.importorskip("control")
    rules = schedule_from_pids(begun("error", "flow", "u", "du"), MIXING, None, FLOW)
    with pytest.raises(LoopError, match="at one value"):
        to_nlsys(rules, 0.1, roles=FLOW)
    pid = pids_of(MIXING, 0.02)[2.0]
    linear = linear_controller(rules, 0.1, roles=FLOW, at=[0.0, 2.0])
    z = np.exp(0.3j)
    assert linear(z) == pytest.approx(pid.Kp + pid.Ki * 0.1 * z / (z - 1))


def test_the_example_is_made_of_its_pids_and_the_command_shows_points_and_course(tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    assert main(["example", "mixing"]) == 0
    fis = read_fis("mixing.fis")
    kept = kept_settings(fis.loop)
    assert schedule_from_pids(fis, transfer_of(kept), loop_of(kept), FLOW) == fis
    capsys.readouterr()
    assert main(["step", "mixing.fis", "--json"]) == 0
    told = json.loads(capsys.readouterr().out)
    assert [*told["points"]] == ["0.5", "1.0", "2.0", "4.0"]
    for there in told["points"].values():
        assert there["mixing"]["output"] == pytest.approx(there["PID of it"]["output"], abs=1e-9)
    assert set(told["responses"]) == {"mixing", "PID"}
    assert main(["step", "mixing.fis", "--operating", "10,0.5 30,4", "--from-pid", "-o", "again.fis"]) == 0
    text = capsys.readouterr().out
    assert "operating variable 0.5 at 10 s, 4 at 30 s" in text
    assert kept_settings(read_fis("again.fis").loop)["operating"] == "10.0,0.5 30.0,4.0"
    assert main(["step", "mixing.fis", "--operating", "1,x"]) == 2
    assert "TIME,VALUE" in capsys.readouterr().err
    # Rules of one's own that do not hear of the variable go as well
    write_fis(fis, "deaf.fis")
    assert Path("deaf.fis").is_file()
    assert main(["step", "deaf.fis", "--plant", "mixing", "--operating", "2", "--role", "flow=scheduling"]) == 0
