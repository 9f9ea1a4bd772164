"""The certificate of a sampled loop: enclosures against samples, a second checker, and starts by the plant."""

import copy
import json
import math
from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.signal import lfilter

from fuzzy.compiled.intervals import ranges
from fuzzy.compiled.packed import packed
from fuzzy.inference import infer_quietly
from fuzzy.membership import FUNCTIONS
from fuzzy.system import Constant, Linear, Sugeno, Variable
from robotics.commands.application import main
from robotics.laws.tracking.fuzzy_tracking import load_rule_base
from robotics.plugins.certificates.badge import badge
from robotics.plugins.certificates.certificate import CertificateError
from robotics.plugins.certificates.certificatefile import _rules, contents, write_certificate
from robotics.plugins.certificates.checker import Boxes, RefutedError, infer
from robotics.plugins.certificates.checkfile import check
from robotics.plugins.certificates.loopcolumns import LevelColumns
from robotics.plugins.certificates.loopmodel import LoopModel, closed_loop
from robotics.plugins.certificates.regions import QUICK_EFFORT, Failure, SearchEffort, certify_loop, where
from robotics.plugins.certificates.starts import asked, follow, simulate_starts, wheels_in_region
from robotics.plugins.certificates.wheels import differences, measure_wheels
from robotics.simulation.scenario.robots import load_robot
from tests.robotics.world.vehicle.etsro import ETSRO

PARAMETERS: dict[str, list[float]] = {
    "trimf": [-1, 0.2, 1], "trapmf": [-1, -0.2, 0.3, 1], "linsmf": [-1, 1], "linzmf": [-0.5, 1], "gaussmf": [0.5, 0.1],
    "gauss2mf": [0.4, -0.3, 0.5, 0.4], "gbellmf": [0.6, 2, 0.1], "sigmf": [3, 0.1], "dsigmf": [5, -0.5, 4, 0.6],
    "psigmf": [5, -0.5, -4, 0.6], "smf": [-0.7, 0.8], "zmf": [-0.7, 0.8], "pimf": [-1, -0.3, 0.2, 0.9],
}  # fmt: skip
NARROW = LoopModel(speed_low=0.3, speed_high=0.32, curvature=0.2)
SMALL = SearchEffort(seconds=60.0, sizes=(0.05,), rounds=3, points=300, trials=15, boxes=100_000, shell=0.6)


@st.composite
def systems(draw):
    """A system of two inputs with terms of any kind, hedges, "not", weights, "or" and consequents of both orders."""
    kinds: dict[str, Any] = {f.matlab: f for f in FUNCTIONS}
    assert set(kinds) == set(PARAMETERS)
    names = draw(st.lists(st.sampled_from(sorted(kinds)), min_size=4, max_size=4))
    terms = [kinds[n](*PARAMETERS[n]) for n in names]
    inputs = [
        Variable("a", (-2, 2), {"p": terms[0], "q": terms[1]}),
        Variable("b", (-2, 2), {"p": terms[2], "q": terms[3]}),
    ]
    number = st.floats(-3, 3)
    output = Variable(
        "o",
        (-9, 9),
        {
            "u": Constant(draw(number)),
            "v": Linear((draw(number), draw(number)), draw(number)),
            "w": Constant(1.0),
        },
    )
    hedge = st.sampled_from(["", "not ", "very ", "somewhat ", "not very "])
    join, term = st.sampled_from(["and", "or"]), st.sampled_from("pq")
    rules = [
        f"if a is {draw(hedge)}{draw(term)} {draw(join)} b is {draw(hedge)}{draw(term)} "
        f"then o is {then} ({draw(st.floats(0.1, 1)):.3f})"
        for then in "uvwu"
    ]
    return Sugeno(
        inputs, [output], rules, name="any", and_method=draw(st.sampled_from(["prod", "min"])),
        or_method=draw(st.sampled_from(["probor", "max"])), out_of_range=draw(st.sampled_from(["clip", "ignore"])),
    )  # fmt: skip


@settings(max_examples=150, deadline=None)
@given(systems(), st.integers(0, 2**32 - 1))
def test_both_interval_extensions_enclose_every_sample(fis, seed):
    rng = np.random.default_rng(seed)
    middle, half = rng.uniform(-1.8, 1.8, (20, 2)), 10.0 ** rng.uniform(-4, 0.3, (20, 1))
    boxes, out = np.stack([middle - half, middle + half], axis=1), np.empty((20, 2, 1))
    ranges(packed(fis), boxes, out)
    points = rng.uniform(boxes[:, None, 0], boxes[:, None, 1], (20, 60, 2))
    said = infer_quietly(fis, points).output[..., 0]
    assert (said >= out[:, None, 0, 0]).all()
    assert (said <= out[:, None, 1, 0]).all()
    second, hole = infer(_rules(fis, ["a", "b"]), [Boxes(*boxes[:, :, i].T) for i in range(2)])
    assert ((said >= second["o"].low[:, None]) | hole[:, None]).all()
    assert ((said <= second["o"].high[:, None]) | hole[:, None]).all()


@pytest.fixture(scope="module")
def certificate():
    found, failure = certify_loop(closed_loop("fuzzy-correcting:smooth=0", ETSRO, NARROW), SMALL)
    assert found is not None, failure
    return found


def test_the_file_is_checked_without_the_search_and_by_the_command(certificate, tmp_path, capsys):
    write_certificate(certificate, tmp_path / "loop.json")
    assert check((tmp_path / "loop.json").read_bytes())["V"]["outer"] == LevelColumns(certificate.form).outer
    assert main(["certify", "--verify", str(tmp_path / "loop.json"), "--json"]) == 0
    assert json.loads(capsys.readouterr().out)["holds"] is True
    (tmp_path / "loop.json").write_text("[]")
    assert main(["certify", "--verify", str(tmp_path / "loop.json")]) != 0
    assert main(["certify", "--verify", str(tmp_path / "none.json")]) != 0
    assert "there is no such file" in capsys.readouterr().err


def stronger(data, rng):
    """A claim that says more than was proven, one way or another."""
    k, v, how = data["loop"], data["V"], int(rng.integers(10))
    if how == 0:
        v["outer"] *= rng.uniform(6, 20)  # the search tries one size: a region 4.3 times as large holds, too
    elif how == 1:
        k["v_error"] = rng.uniform(0.1, 0.3)
    elif how == 2:
        v["fall"] *= rng.uniform(0.5, 0.95)
        v["share"] = min(v["share"], v["fall"] ** 20)
    elif how == 3:
        v["share"] = rng.uniform(0.99, 1.2)
    elif how == 4 and data["rules"]:
        for rule in data["rules"]["rules"][3:]:
            rule["then"][1] = [-n for n in rule["then"][1]]
    elif how == 5:
        k["w_error"] = rng.uniform(0.3, 2)
    elif how == 6:
        k["speed_low"] *= rng.uniform(0.02, 0.15)
    elif how == 7:
        k["position_noise"] = rng.uniform(0.05, 0.3)
    elif how == 8:
        k["w_weight"] = [0.0, 0.0, 1.0, *[0.0] * 5]
        k["last"] = [0.0, 5.0, 20.0, *[0.0] * 5]
    else:
        v["m"] *= rng.choice([-1, 5])


@pytest.mark.parametrize(
    "count", [5, pytest.param(60, marks=pytest.mark.long), pytest.param(500, marks=pytest.mark.scale)]
)
def test_a_certificate_that_says_more_is_refuted(certificate, count):
    rng, data = np.random.default_rng(3), contents(certificate)
    for _ in range(count):
        changed = copy.deepcopy(data)
        stronger(changed, rng)
        with pytest.raises(RefutedError):
            check(changed)


def test_a_broken_file_is_refuted_and_nothing_else_is_raised(certificate):
    rng, text = np.random.default_rng(4), json.dumps(contents(certificate))
    for name in contents(certificate):
        changed = contents(certificate)
        del changed[name]
        if name != "law":
            with pytest.raises(RefutedError):
                check(changed)
    wrong: tuple[Any, ...] = (None, "x", [], {}, float("nan"), -1.0)
    needed = sorted({*contents(certificate)["loop"]} - {"kx", "ky", "kpsi"})
    for bad in wrong:
        changed = json.loads(text)
        changed["loop"][rng.choice(needed)] = bad
        with pytest.raises(RefutedError):
            check(changed)


@pytest.mark.parametrize("count", [2000, pytest.param(20_000, marks=pytest.mark.long)])
def test_no_start_of_the_plant_leaves_the_region(certificate, count):
    seen = simulate_starts(certificate, ETSRO, count, duration=4.0)
    assert seen.greatest.max() <= 1 + 1e-9  # of which half begin at 1
    assert seen.last.max() <= certificate.ultimate / certificate.region
    assert wheels_in_region(certificate, ETSRO) == ""


def test_a_start_outside_the_region_may_stay_outside(certificate):
    # That the test above can fail: a law whose signs are wrong leaves
    loop = certificate.loop
    bend = loop.rules.outputs[1]
    terms = {n: Linear([-s for s in t.slopes], -t.constant) for n, t in bend.terms.items()}
    wrong = replace(loop.rules, outputs=[loop.rules.outputs[0], replace(bend, terms=terms)])
    broken = replace(certificate, loop=replace(loop, rules=wrong))
    assert simulate_starts(broken, ETSRO, 100, duration=2.0).greatest.max() > 1.5


@pytest.mark.parametrize("name", ["etsro", "pioneer-3dx", "turtlebot3-burger"])
def test_the_wheels_do_in_the_loop_what_was_measured_of_them(name):
    # Measured in other drives: oscillations of the command that decay; here the law itself drives
    robot = load_robot(name).robot
    speeds = (0.05, 0.12) if name == "turtlebot3-burger" else (0.1, 0.4)
    loop = closed_loop("fuzzy-correcting:smooth=0", robot, LoopModel(speed_low=speeds[0], speed_high=speeds[1]))
    rng = np.random.default_rng(5)
    start = rng.uniform(-1, 1, (400, 3)) * [0.05, 0.08, 0.3]
    steady, reversing, beyond = differences(robot, loop.wheels, follow(loop, robot, start, 4.0, rng)[1])
    assert (steady <= loop.wheels.error).all()
    assert (reversing <= loop.wheels.error + loop.wheels.reversal).all()
    assert (beyond <= loop.wheels.ripple).all()
    weak = replace(loop.wheels, weights=np.roll(loop.wheels.weights, 1, axis=0))
    assert (differences(robot, weak, follow(loop, robot, start, 4.0, rng)[1])[0] > loop.wheels.error).any()


def test_the_weights_of_the_wheels_tell_of_the_latency():
    late = measure_wheels(ETSRO, (0.2, 0.4), 1.0, 0.05, latency=0.05)
    np.testing.assert_allclose(late.weights.sum(axis=0), 1)
    assert (np.abs(late.weights[0]) < 0.05).all()  # a command does nothing in its own period


@pytest.mark.parametrize("law", ["fuzzy", "csm"])
def test_what_is_not_certified_says_why(law):
    with pytest.raises(CertificateError, match="certif"):
        closed_loop(law, ETSRO)


@pytest.fixture(scope="module")
def behind_low_pass():
    found, failure = certify_loop(closed_loop("fuzzy-correcting:smooth=0.05", ETSRO, NARROW), SMALL)
    assert found is not None, failure
    return found


def test_no_start_leaves_the_region_of_a_law_behind_a_low_pass(behind_low_pass):
    seen = simulate_starts(behind_low_pass, ETSRO, 500, duration=4.0)
    assert seen.greatest.max() <= 1 + 1e-9
    assert seen.last.max() <= behind_low_pass.ultimate / behind_low_pass.region
    assert wheels_in_region(behind_low_pass, ETSRO) == ""


def test_a_slower_low_pass_in_the_file_is_refuted(behind_low_pass):
    data = contents(behind_low_pass)
    data["loop"]["smooth"] = 0.3
    with pytest.raises(RefutedError, match="fresh is not of this smooth"):
        check(copy.deepcopy(data))
    data["loop"]["fresh"] = -math.expm1(-NARROW.period / 0.3)
    with pytest.raises(RefutedError, match="share is above"):
        check({**data, "loop": data["loop"] | {"forgotten": 900.0}})
    # As little as this is remembered makes what is older count as anything
    with pytest.raises(RefutedError, match="not seen to fall"):
        check(data)


@pytest.mark.long
def test_the_second_checker_accepts_a_law_behind_a_low_pass(behind_low_pass):
    assert check(contents(behind_low_pass))["loop"]["smooth"] == 0.05


def test_a_low_pass_that_is_too_slow_for_the_gains_is_not_certified(behind_low_pass):
    # τ s³ + s² + k_ψ s + v k_y = 0 is stable for τ < k_ψ/(v k_y), about 1.7 s here
    loop = closed_loop("fuzzy-correcting:smooth=3", ETSRO, NARROW)
    grown = simulate_starts(replace(behind_low_pass, loop=loop), ETSRO, 10, duration=8.0)
    assert grown.last.max() > 1
    found, failure = certify_loop(loop, QUICK_EFFORT)
    assert found is None
    assert failure is not None
    assert failure.growth > 0


def test_simulated_starts_have_the_low_pass_of_the_law():
    model = LoopModel(speed_low=0.3, speed_high=0.3, curvature=0.0)
    loop = closed_loop("fuzzy-correcting", ETSRO, model)
    start = np.array([[0.03, 0.05, 0.2], [-0.02, -0.03, 0.1]])
    errors, drives = follow(loop, ETSRO, start, 1.0, np.random.default_rng(0))
    wanted = np.array([asked(loop, z, np.full(2, 0.3), np.zeros(2)) for z in errors])
    fresh = -math.expm1(-model.period / 0.2)
    first = drives.commands[0]
    expected = first + lfilter([fresh], [1, fresh - 1], wanted - first, axis=0)
    np.testing.assert_allclose(drives.commands[-len(errors) :], expected, atol=1e-12)


@pytest.mark.parametrize(
    ("law", "robot", "changed"),
    [
        ("lyapunov", "etsro", {}),
        ("fuzzy-correcting:smooth=0", "pioneer-3dx", {}),
        ("fuzzy-correcting:smooth=0", "etsro", {"latency": 0.05}),
        ("fuzzy-correcting:smooth=0", "etsro", {"position_noise": 0.001, "heading_noise": 0.003}),
    ],
)
def test_other_laws_robots_latency_and_noise_hold_in_simulation(law, robot, changed):
    machine = load_robot(robot).robot
    found, failure = certify_loop(closed_loop(law, machine, replace(NARROW, **changed)), SMALL)
    assert found is not None, failure
    seen = simulate_starts(found, machine, 500, duration=3.0)
    assert seen.greatest.max() <= 1 + 1e-9
    assert seen.last.max() <= found.ultimate / found.region


def broken(how, rng):
    """The packaged rule base, broken on purpose."""
    fis = load_rule_base("correcting")
    dv, bend = fis.outputs
    factor = {"signs": -rng.uniform(0.1, 2), "nothing": 0.0, "gains": rng.uniform(8, 40)}.get(how, 1.0)
    terms = {n: Linear([factor * s for s in t.slopes], factor * t.constant) for n, t in bend.terms.items()}
    fis = replace(fis, outputs=[dv, replace(bend, terms=terms)])
    return replace(fis, rules=[r for k, r in enumerate(fis.rules) if k not in (4, 7)]) if how == "hole" else fis


@pytest.mark.parametrize(
    "count", [1, pytest.param(8, marks=pytest.mark.long), pytest.param(50, marks=pytest.mark.scale)]
)
@pytest.mark.parametrize("how", ["signs", "nothing", "gains", "hole"])
def test_rule_bases_broken_on_purpose_are_not_certified(how, count):
    rng = np.random.default_rng(6)
    for _ in range(count):
        told = badge(broken(how, rng), ETSRO, NARROW)
        assert told.found is None
        assert told.why


def test_what_is_certified_of_other_gains_and_fewer_rules_holds_in_simulation():
    rng, fis = np.random.default_rng(8), load_rule_base("correcting")
    certified = 0
    for _ in range(6):
        dv, bend = fis.outputs
        factor = rng.uniform(0.5, 2, len(bend.terms))
        terms = {
            n: Linear([f * s for s in t.slopes], f * t.constant)
            for f, (n, t) in zip(factor, bend.terms.items(), strict=True)
        }
        rules = [r for k, r in enumerate(fis.rules) if k != rng.integers(3, 20)]
        other = replace(fis, outputs=[dv, replace(bend, terms=terms)], rules=rules)
        found, _ = certify_loop(closed_loop(other, ETSRO, NARROW), QUICK_EFFORT)
        if found is not None:
            certified += 1
            assert simulate_starts(found, ETSRO, 300, duration=3.0).greatest.max() <= 1 + 1e-9
    assert certified > 0


@pytest.mark.parametrize(("growth", "says"), [(0.01, "may grow by 1 %"), (-0.0006, "is only sure to fall by 0.06 %")])
def test_where_a_proof_ends_is_told_in_words(growth, says):
    assert where(Failure(np.zeros((5, 2)), growth, "no")).endswith(f"where it {says} in a period")
