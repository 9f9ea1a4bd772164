"""Which rules decided: what a run keeps of its rule bases, firing strengths, spans, and `robotics explain`."""

import json
import re
from dataclasses import replace
from itertools import pairwise

import numpy as np
import pytest

from fuzzy.inference import infer
from fuzzy.insight.explanation import explain, firing_strengths
from fuzzy.membership import Triangle
from fuzzy.system import FuzzySystemError, Sugeno, Variable
from robotics.commands.application import main
from robotics.laws.catalogue import make_controller
from robotics.laws.law import Command, ControllerError, Law
from robotics.laws.modes import AVOID
from robotics.laws.tracking.fuzzy_tracking import FuzzyTracking, load_rule_base
from robotics.measures.decisions import NONE, UNKNOWN, DecisionError, decisions, rule_spans, strongest
from robotics.measures.explained import explain_decision, explain_spans, situation
from robotics.simulation.loop import simulate
from robotics.simulation.run import load_run
from robotics.simulation.scenario.reading import load_scenario
from robotics.simulation.spans import ReplayError
from robotics.world.environment.world import Disc, World, compile_world


@pytest.fixture(scope="module")
def team():
    """Three robots that begin off their paths, two seeds, 6 s."""
    scenario = replace(load_scenario("start-off-paths"), duration=6.0)
    return simulate(scenario, make_controller("cooperation"), (0, 5), name="cooperation")


@pytest.fixture(scope="module")
def curve():
    """One robot under two rule bases."""
    scenario = replace(load_scenario("table-2-1"), duration=3.0)
    return simulate(scenario, make_controller("fuzzy-lateral"), (3, 4), name="fuzzy-lateral")


# What a run keeps ---------------------------------------------------------------------------------------------------


def test_the_rule_bases_give_the_commands_from_the_inputs_kept(team):
    """Of a law that hands its rule base's answer on, single precision is all that lies between."""
    (asked,) = decisions(team, 1)
    assert (asked.task, asked.inputs.shape) == ("tracking", (121, 3, 4))
    assert team.inputs.dtype == np.float32
    answer = infer(asked.system, asked.inputs.astype(float)).output
    np.testing.assert_allclose(answer[..., 0], team["command_1"][1].T, atol=2e-6)
    np.testing.assert_allclose(answer[..., 1], team["command_2"][1].T, atol=2e-5)


def test_two_rule_bases_stand_one_behind_the_other(curve):
    tracking, lateral = decisions(curve, 0)
    assert (tracking.task, lateral.task) == ("tracking", "lateral")
    assert [v.name for v in lateral.system.inputs] == ["y_err"]
    assert tracking.inputs.shape == (61, 1, 4)
    assert lateral.inputs.shape == (61, 1, 1)
    # The lateral error is that of the target 0.4 s ahead, in the path's frame: about that of the robot now.
    ahead = 8
    x, y, heading = (curve.target(name)[0, ahead:] for name in ("x", "y", "heading"))
    seen_x, seen_y = (curve[f"{name}_measured"][0, 0, :-ahead] for name in "xy")
    error = np.cos(heading) * (y - seen_y) - np.sin(heading) * (x - seen_x)
    np.testing.assert_allclose(lateral.inputs[:-ahead, 0, 0], error, atol=1e-6)


def test_save_and_load_keep_the_inputs_and_the_rule_bases(curve, tmp_path):
    curve.save(tmp_path / "run.npz")
    back = load_run(tmp_path / "run.npz")
    assert back.about == curve.about
    assert list(back.about.rule_bases) == ["tracking", "lateral"]
    assert back.about.rule_bases["tracking"] == load_rule_base("tracking")
    np.testing.assert_array_equal(back.inputs, curve.inputs)
    assert back.inputs.dtype == np.float32
    np.testing.assert_array_equal(back.only(4).inputs, curve.inputs[:, :, 1:])
    with np.load(tmp_path / "run.npz") as file:
        about = json.loads(str(file["about"]))
    assert about["rule_bases"]["lateral"].startswith("[System]\n")  # text, as in a .fis file
    assert str(explain_decision(back, 1, 2.0, 4)) == str(explain_decision(curve, 1, 2.0, 4))


def test_the_inputs_of_a_stopped_robot_are_not_numbers():
    """A divergence of 5 cm is soon exceeded by a robot that begins 1 m beside its path."""
    scenario = replace(load_scenario("fuzzy-off-path"), duration=1.0, divergence=0.05)
    run = simulate(scenario, make_controller("fuzzy"), name="fuzzy")
    after = int(run.stopped[0, 0]) + 1
    assert np.isfinite(run.inputs[:after]).all()
    assert np.isnan(run.inputs[after:]).all()
    explained = explain_decision(run, 1, 0.9)
    assert not explained.rule_bases
    assert "Robot 1 stands; at 0.00 s its command was not finite, or it was lost." in str(explained)
    sentence = explain_spans(run, 1)[-1][1]
    assert sentence == "0.05-1.00 s: an input of tracking was not a number"


def test_a_law_without_rule_bases_keeps_none_though_one_below_it_says_its_inputs():
    run = simulate(replace(load_scenario("trap-u"), duration=0.5), make_controller("obstacles"))
    assert run.inputs is None
    assert run.about.rule_bases == {}


class Forgetful(Law[None]):
    """A law of arrays that has two rule bases, of five inputs, and tells the inputs of one."""

    @property
    def fuzzy_systems(self):
        """Both."""
        law = FuzzyTracking(lateral="path")
        return law.fuzzy_systems

    def init(self, setting, runs):
        """Remember nothing."""

    def control(self, seen, memory, dt):
        rest = np.zeros_like(seen.x)
        return Command(rest, rest, rest, rest, inputs=np.zeros((4, *seen.x.shape))), None


def test_a_law_whose_inputs_do_not_fit_its_rule_bases_is_refused():
    with pytest.raises(ControllerError, match=r"rule bases tracking, lateral have 5 inputs in all, .* carry 4"):
        simulate(replace(load_scenario("table-2-1"), duration=0.1), Forgetful())


class Silent(Forgetful):
    """A law that has another one below it, and does not say that it has its rule bases."""

    fuzzy_systems = {}  # noqa: RUF012


def test_a_law_whose_inputs_are_of_no_rule_base_is_refused():
    with pytest.raises(ControllerError, match=r"fuzzy_systems names no rule bases, .* carry 4"):
        simulate(replace(load_scenario("table-2-1"), duration=0.1), Silent())


# Firing strengths ---------------------------------------------------------------------------------------------------


def test_firing_strengths_are_those_of_explain(team):
    (asked,) = decisions(team, 0)
    firing = asked.firing()
    assert firing.shape == (121, 3, 16)
    for k, robot in ((0, 0), (40, 1), (80, 2), (120, 0)):
        rows = explain(asked.system, asked.inputs[k, robot]).rows
        np.testing.assert_allclose(firing[k, robot], [row.firing for row in rows], rtol=1e-12)


def test_firing_strengths_neither_warn_nor_refuse(recwarn):
    strict = Sugeno(
        [Variable("d", (0, 1), {"near": Triangle(0, 0, 0.5)})],
        [Variable("v", (0, 1), {"slow": 0.2})],
        ["if d is near then v is slow"],
        out_of_range="error",
        no_rule_fires="error",
    )
    firing = firing_strengths(strict, [[0.25], [0.75], [7.0], [np.inf], [np.nan]])
    np.testing.assert_array_equal(firing, [[0.5], [0.0], [0.0], [0.0], [np.nan]])
    assert not recwarn.list
    with pytest.raises(FuzzySystemError, match="must hold 1 values"):
        firing_strengths(strict, [[0.25, 0.5]])


def test_the_strongest_rules_come_first_and_the_first_of_equals():
    firing = np.array([[0.2, 0.9, 0.9, 0.0], [0.0, 0.0, 0.3, 0.0], [0.0, 0.0, 0.0, 0.0], [np.nan] * 4])
    number, strength = strongest(firing, 3)
    np.testing.assert_array_equal(number, [[2, 3, 1], [3, NONE, NONE], [NONE] * 3, [UNKNOWN] * 3])
    np.testing.assert_array_equal(strength, [[0.9, 0.9, 0.2], [0.3, 0, 0], [0, 0, 0], [0, 0, 0]])
    number, strength = strongest(np.array([[0.4, 0.6]]), 3)
    np.testing.assert_array_equal(number, [[2, 1, NONE]])
    np.testing.assert_array_equal(strength, [[0.6, 0.4, 0.0]])


def test_spans_name_the_strongest_rule_of_every_sample(team):
    (asked,) = decisions(team, 0)
    best = asked.firing()[:, 0].argmax(axis=-1) + 1
    spans = rule_spans(team, 0, 0, 1.02, 4.3)
    assert (spans[0].start, spans[-1].end) == (1.02, 4.3)
    assert [a.end for a in spans[:-1]] == [b.start for b in spans[1:]]
    assert all(a.rule != b.rule for a, b in pairwise(spans))
    assert len(spans) > 1
    for span in spans:
        inside = (team.time > span.start - 0.05 + 1e-9) & (team.time < span.end - 1e-9)
        assert set(best[inside]) == {span.rule}
        strengths = asked.firing()[inside, 0].max(axis=-1)
        assert (span.least, span.most) == (strengths.min(), strengths.max())


# In words -----------------------------------------------------------------------------------------------------------


def test_a_situation_is_told_with_true_gaps(team):
    """Robot 1's standard rectangle is 0.23 m long; a disc of 0.112 m lies 0.5 m before its middle."""
    samples = team.samples.copy()
    samples[10, :5, 0] = np.array([[1, -2, np.pi, 0.25, 0.5], [3, -2, 0, 0, 0], [1, 4, np.pi / 2, -0.1, 0]]).T
    modes = np.zeros((len(team.time), 2, 3), dtype=np.int8)
    modes[10, 0, 0] = AVOID
    world = compile_world(World(obstacles=(Disc(position=(0.5, -2.0), radius=0.112),))).rest
    run = replace(team.with_recorded(samples=samples, modes=modes), obstacles=world)
    first = situation(run, 0, 10, 0)
    assert first.nearest_robot == 2
    assert first.robot_gap == pytest.approx(2 - 0.23)
    assert first.obstacle_gap == pytest.approx(0.5 - 0.112 - 0.23 / 2)
    assert str(first) == (
        "Robot 1 is avoiding: it is at x = 1.00 m, y = -2.00 m, heads 3.14 rad and drives at 0.25 m/s, turning left "
        "at 0.50 rad/s; the gap to the nearest robot, robot 2, is 1.77 m and to the nearest obstacle is 0.27 m."
    )
    assert "stands still" in str(situation(run, 0, 10, 1))
    assert "drives backwards at 0.10 m/s, straight on" in str(situation(run, 0, 10, 2))


def test_every_rule_base_is_explained_at_the_sample_before(curve):
    explained = explain_decision(curve, 1, 1.52, 4)
    assert explained.situation.time == pytest.approx(1.5)
    for asked in decisions(curve, 1):
        assert explained.rule_bases[asked.task] == explain(asked.system, asked.inputs[30, 0])
    text = str(explained)
    assert text.startswith("At 1.50 s of fuzzy-lateral on table-2-1, seed 4:\n\nRobot 1 is at x = ")
    assert text.index("Rule base tracking:") < text.index("Rule base lateral:") < text.index("In the end the law asks")
    v, w = curve["v_demand"][1, 0, 30], curve["w_demand"][1, 0, 30]
    assert f"v = {v:.4g} m/s and w = {w:.4g} rad/s" in text


# The command --------------------------------------------------------------------------------------------------------


def test_the_command_says_what_the_run_knows(tmp_path, capsys):
    file = str(tmp_path / "run.npz")
    assert main(["run", "fuzzy-off-path", "-c", "fuzzy", "--seeds", "2", "--save", file, "-q"]) == 0
    capsys.readouterr()
    run = load_run(file)
    assert main(["explain", file, "--time", "4", "--seed", "1"]) == 0
    assert capsys.readouterr().out == f"{explain_decision(run, 1, 4.0, 1)}\n"
    assert main(["explain", file, "--time", "4", "--json"]) == 0
    said = json.loads(capsys.readouterr().out)
    assert (said["seed"], said["robot"], said["time"]) == (0, 1, 4.0)
    assert said["rule_bases"]["tracking"]["inputs"]["distance"] == float(run.inputs[80, 0, 0, 0])
    assert main(["explain", file, "--from", "2", "--to", "6"]) == 0
    lines = capsys.readouterr().out.splitlines()
    assert lines[0].startswith("2.00-")
    assert all(re.fullmatch(r"\d\.\d\d-\d\.\d\d s: rule \d+ of tracking \(fires .+\): if .+", line) for line in lines)
    assert main(["explain", file, "--from", "2", "--json"]) == 0
    spans = json.loads(capsys.readouterr().out)
    assert spans[-1]["end"] == run.time[-1]
    assert spans[0]["sentence"].startswith("2.00-")


def test_what_cannot_be_explained_gets_a_sentence(team, tmp_path):
    for wrong, error, words in (
        ({"robot": 4}, DecisionError, "there is no robot 4 in this run; it has the robots 1 to 3"),
        ({"time": 7.0}, DecisionError, "the run lasts from 0 to 6 s; there is nothing at 7 s"),
        ({"seed": 2}, ReplayError, "seed 2 is not among those of the run: 0, 5"),
    ):
        with pytest.raises(error, match=re.escape(words)):
            explain_decision(team, **({"robot": 1, "time": 1.0} | wrong))
    older = replace(team, about=replace(team.about, rule_bases=None)).with_recorded(inputs=None)
    older.save(tmp_path / "older.npz")
    for run, words in (
        (load_run(tmp_path / "older.npz"), "from an older version, which did not keep"),
        (replace(older, about=replace(team.about, rule_bases={})), "has no rule bases that could be explained"),
        (replace(older, about=team.about), "did not say what its rule bases were asked"),
    ):
        with pytest.raises(DecisionError, match=words):
            explain_decision(run, 1, 1.0)


@pytest.mark.parametrize("options", [[], ["--time", "1", "--to", "2"]])
def test_the_command_wants_a_time_or_a_span(options, capsys):
    assert main(["explain", "none.npz", *options]) == 2
    assert capsys.readouterr().err == "robotics: give either --time, or --from and --to\n"
