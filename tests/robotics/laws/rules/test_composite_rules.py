"""A tree or a type-2 system drives: as the plain rule base to which it is equal, and by what it answers itself."""

import json
from dataclasses import replace
from typing import Any

import numpy as np
import pytest

import fuzzy
import robotics
from robotics.commands.application import main
from robotics.laws.law import ControllerError
from robotics.laws.rules.own_rules import CompositeRules, OwnRules
from robotics.laws.tracking.fuzzy_tracking import load_rule_base
from robotics.measures.explained import explain_decision
from robotics.plugins.ccode.source import check_written
from robotics.simulation.loop import simulate
from robotics.simulation.scenario.reading import load_scenario
from robotics.studies.tuning.space import LawSpace

PLAIN = load_rule_base("correcting")
CIRCLE = replace(load_scenario("lyapunov-circle"), duration=4.0)


def part(output):
    """The rules of one output."""
    rules = [rule for rule in PLAIN.rules if output in dict(rule.then)]
    outputs = [v for v in PLAIN.outputs if v.name == output]
    return replace(PLAIN, outputs=outputs, rules=[replace(r, then=((output, dict(r.then)[output]),)) for r in rules])


def test_what_is_equal_drives_alike(tmp_path):
    fuzzy.Tree({"along": part("dv"), "across": part("bend")}).write(tmp_path / "tree")
    fuzzy.write_fis(fuzzy.to_type2(PLAIN, 0.0, 1.0), tmp_path / "same.fis")
    wanted = simulate(CIRCLE, "fuzzy-correcting", [3])
    for whole in ("tree", "same.fis"):
        run = simulate(CIRCLE, f"fuzzy-correcting:rule_base={tmp_path / whole}", [3])
        for channel in ("x", "v_demand", "w_demand"):
            np.testing.assert_allclose(run[channel], wanted[channel], atol=1e-9, err_msg=whole)


def turning(inputs, outputs):
    """A system of the errors, or of what stands between."""
    terms = {"left": fuzzy.Trapezoid(-9, -9, -0.5, 0.5), "right": fuzzy.Trapezoid(-0.5, 0.5, 9, 9)}
    variables = [fuzzy.Variable(name, (-3, 3), terms) for name in inputs]
    made = [fuzzy.Variable(name, (-1, 1), {"less": low, "more": high}) for name, (low, high) in outputs.items()]
    rules = []
    for name in inputs:
        for term, then in (("left", "less"), ("right", "more")):
            rules.append(f"if {name} is {term} then " + ", ".join(f"{output} is {then}" for output in outputs))
    return fuzzy.Sugeno(variables, made, rules, out_of_range="clip")


def test_it_drives_as_it_answers_to_what_is_recorded():
    way = {"v": (0.1, 0.3), "w": (-0.4, 0.5)}
    tree = fuzzy.Tree(
        {"drive": turning(["tilt", "alpha"], way), "look": turning(["y_err", "heading_err"], {"tilt": (-0.9, 0.8)})}
    )
    type2 = fuzzy.to_type2(turning(["y_err", "alpha"], way), 0.3, 0.7)
    whole: Any
    for whole in (tree, type2):
        run = simulate(CIRCLE, OwnRules(rule_base=whole), [1])
        asked = np.asarray(run.inputs)[:, :, 0, 0]
        answer = whole(np.clip(asked, -3, 3))
        found = np.stack([run["v_demand"][0, 0], run["w_demand"][0, 0]], axis=-1)
        assert np.ptp(found[:, 1]) > 0.05
        kept = np.isfinite(asked).all(axis=1)
        np.testing.assert_allclose(found[kept], answer[kept], atol=1e-6)  # inputs are recorded with seven digits


def type2_law(fis):
    whole: Any = fuzzy.to_type2(fis)
    return OwnRules(rule_base=whole)


def test_what_takes_plain_rule_bases_only_says_so(tmp_path):
    law = type2_law(PLAIN)
    assert type(law) is CompositeRules
    with pytest.raises(fuzzy.errors.InputError, match="tree or of type-2"):
        check_written(law, "mine")
    assert not any("bend" in p.name for p in LawSpace(law, ["gains"]).parameters)
    with pytest.raises(ControllerError, match="not taken apart"):
        law.with_fuzzy_system("own", PLAIN)
    run = simulate(CIRCLE, law, [1])
    told = str(explain_decision(run, 1, 2.0))
    assert "if " not in told
    run.save(tmp_path / "run.npz")
    again = robotics.load_run(tmp_path / "run.npz")
    assert np.array_equal(again["x"], run["x"])
    assert again.about.rule_bases["own"].inputs == PLAIN.inputs
    with pytest.raises(ControllerError, match="a tree or a type-2 system that drives takes"):
        type2_law(turning(["front"], {"turn": (-1, 1)}))


def test_the_command_takes_a_folder(tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    fuzzy.Tree({"along": part("dv"), "across": part("bend")}).write("tree")
    for law in ("fuzzy-correcting:rule_base=tree", "fuzzy-correcting"):
        assert main(["run", "lyapunov-circle", "--controller", law, "--json"]) == 0
    tree, plain = (json.loads(line)["metrics"] for line in capsys.readouterr().out.splitlines())
    wanted = {k: v[0] for k, v in plain.items()}  # which rounding comes to, by the ticks of encoders
    assert {k: v[0] for k, v in tree.items()} == pytest.approx(wanted, rel=0.02, nan_ok=True)


@pytest.mark.parametrize("kind", ["tree", "type2"])
def test_it_is_tuned_through_the_loop(tmp_path, monkeypatch, capsys, kind):
    monkeypatch.chdir(tmp_path)
    if kind == "tree":
        fuzzy.Tree({"along": part("dv"), "across": part("bend")}).write("start")
    else:
        fuzzy.write_fis(fuzzy.to_type2(PLAIN, 0.1, 0.9), "start")
    law = "fuzzy-correcting:rule_base=start"
    asked = ["tune", law, "lyapunov-circle", "--seeds", "1", "--check-seeds", "0", "--json", "-o", "tuned"]
    assert main([*asked, "--evaluations", "12"]) == 0
    told = json.loads(capsys.readouterr().out)
    assert told["after"] < told["before"]
    about = json.loads((tmp_path / "tuned" / "result.json").read_text())
    moved = set(about["parameters"])
    assert any(name.startswith("across/") if kind == "tree" else name.endswith(".scale") for name in moved)
    # What was written drives as what was found, and costs what was said
    space = LawSpace(robotics.make_controller(law))
    best = space.made([about["parameters"].get(p.name, p.start) for p in space.parameters])
    runs = [simulate(CIRCLE, each, [1]) for each in (best, about["specification"].replace("own", "tuned/own"), law)]
    np.testing.assert_allclose(runs[1]["x"], runs[0]["x"], atol=1e-6)
    assert np.abs(runs[2]["x"] - runs[0]["x"]).max() > 1e-4
