"""Every rule base finds its place, and one that has none is told what is wrong with its variables."""

from dataclasses import replace

import pytest

from fuzzy.membership import Triangle
from fuzzy.system import Constant, Sugeno, Variable
from robotics.laws.catalogue import make_controller, presets
from robotics.laws.formation.leader_follower import load_networks
from robotics.laws.tracking.fuzzy_tracking import load_rule_base, rule_base_files
from robotics.plugins.designer.uses import TryoutError, uses_of
from robotics.simulation.scenario.reading import load_scenario


def made(inputs: str, outputs: str, name: str = "mine") -> Sugeno:
    """A system with these variables."""
    rule = f"if {inputs.split()[0]} is any then " + " and ".join(f"{output} is some" for output in outputs.split())
    return Sugeno(
        [Variable(name, (0, 1), {"any": Triangle(-1, 0, 2)}) for name in inputs.split()],
        [Variable(name, (0, 1), {"some": Constant(0.5)}) for name in outputs.split()],
        [rule],
        name=name,
    )


PACKAGED = {
    "tracking": ("fuzzy", "tracking", "fuzzy-off-path"),
    "tracking-literal": ("fuzzy", "tracking", "fuzzy-off-path"),
    "fuzzy-tuned": ("fuzzy", "tracking", "fuzzy-off-path"),
    "tracking-cooperation-tuned": ("fuzzy", "tracking", "fuzzy-off-path"),
    "correcting": ("fuzzy-correcting", "own", "fuzzy-off-path"),
    "fuzzy-correcting-tuned": ("fuzzy-correcting", "own", "fuzzy-off-path"),
    "fuzzy-correcting-estimator-tuned": ("fuzzy-correcting", "own", "fuzzy-off-path"),
    "cooperation": ("fuzzy-team", "cooperation", "wait-for-one"),
    "crash": ("fuzzy-team", "crash", "three-cross"),
    "obstacles": ("fuzzy-team", "obstacles", "obstacles-on-two-paths"),
    "supervisor": ("fuzzy-team", "supervisor", "obstacles-on-two-paths"),
    "eta": ("crash-yielding", "eta", "three-cross"),
    "theta": ("obstacles", "theta", "obstacles-on-two-paths"),
    "lateral": ("fuzzy-lateral", "lateral", "fuzzy-off-path"),
    "park": ("fuzzy-park", "tracking", "parking"),
    "wall-follower": ("fuzzy", "own", "obstacles-on-two-paths"),
}


def test_every_packaged_rule_base_has_a_place() -> None:
    assert {*PACKAGED} == {name for name in rule_base_files() if "/" not in name}  # and the formations' networks
    for name, place in PACKAGED.items():
        fis = load_rule_base(name)
        for known in (fis, replace(fis, name="mine")):  # by its variables, whatever it is called
            first = uses_of(known)[0]
            assert (first.law, first.task, first.scenarios[0]) == place
    for network in load_networks("formation"):
        assert [use.law for use in uses_of(network)] == ["formation"]


OTHERS = ("tracking-literal", "fuzzy-tuned", "tracking-cooperation-tuned")  # of the same variables as tracking


@pytest.mark.parametrize("name", [name for name in PACKAGED if name not in OTHERS])
def test_every_use_is_one(name: str) -> None:
    """The law takes the system, and drives the scenarios that are suggested, which exist; so does its rival."""
    fis = load_rule_base(name)
    for use in uses_of(fis):
        law = make_controller(use.law).with_fuzzy_system(use.task, fis)
        for scenario in use.scenarios:
            setting = load_scenario(scenario).setting
            assert setting.kind in use.kinds
            law.init(setting, 1)
        assert use.rival in presets()


@pytest.mark.parametrize(
    ("inputs", "outputs", "name", "first"),
    [
        ("gap bearing", "turn speed", "mine", "fuzzy-team/crash/three-cross"),
        ("front left", "turn speed", "mine", "fuzzy-team/obstacles/obstacles-on-two-paths"),
        ("v", "turn speed", "my_obstacles", "fuzzy-team/obstacles/obstacles-on-two-paths"),
        ("v", "turn speed", "my-crash", "fuzzy-team/crash/three-cross"),
        ("cross_track path_bearing", "w", "mine", "fuzzy/own/fuzzy-off-path"),
        ("distance", "v", "mine", "fuzzy/own/fuzzy-off-path"),
        ("distance alpha", "w v", "mine", "fuzzy/own/fuzzy-off-path"),
        ("distance alpha", "fast round", "mine", "fuzzy/tracking/fuzzy-off-path"),
        ("robot2_ahead robot2_left", "v w", "mine", "fuzzy/own/three-cross"),
        ("front", "speed_factor", "mine", "fuzzy/own/obstacles-on-two-paths"),
        ("lag", "rate", "mine", "fuzzy-team/cooperation/wait-for-one"),
        ("front", "crash obstacles", "mine", "fuzzy-team/supervisor/obstacles-on-two-paths"),
    ],
)
def test_the_variables_decide_and_then_the_name(inputs: str, outputs: str, name: str, first: str) -> None:
    use = uses_of(made(inputs, outputs, name))[0]
    assert f"{use.law}/{use.task}/{use.scenarios[0]}" == first


def test_the_name_of_the_file_counts() -> None:
    assert uses_of(made("x", "y"), "eta")[0].task == "eta"
    assert uses_of(made("v", "turn speed"), "crash-2")[0].task == "crash"


@pytest.mark.parametrize(
    ("inputs", "outputs", "says"),
    [
        ("gapp bearing", "turn speed", "no robot knows the input 'gapp' (did you mean 'gap'?). A law takes"),
        ("gap", "turn sped", "no law takes the output 'sped' (did you mean 'speed'"),
        ("x1 x2", "y", "no robot knows the input 'x1'; no robot knows the input 'x2'; no law takes the output 'y'"),
        ("gap", "speed tracking", "no law takes all of its outputs together: speed and tracking"),
    ],
)
def test_what_has_no_place_is_told_why(inputs: str, outputs: str, says: str) -> None:
    with pytest.raises(TryoutError) as caught:
        uses_of(made(inputs, outputs))
    message = str(caught.value)
    assert message.startswith("mine cannot drive a robot: ")
    assert says in message
    assert "docs/reference/quantities.md" in message
    assert "v, w, dv, dw, bend, turn, speed, speed_factor, rate and keep" in message
