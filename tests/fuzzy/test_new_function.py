"""A new membership function is one class: a raised cosine, registered, is known wherever functions are named."""

import json
from collections.abc import Iterator
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any, ClassVar

import numpy as np
import pytest
import torch
from array_api_compat import array_namespace

import fuzzy
import robotics
from anfis.premises import premises
from fuzzy.compiled.sugeno import compile_sugeno
from fuzzy.files.fisfile import format_fis, parse_fis
from fuzzy.fitting.identification import identify
from fuzzy.insight.description import as_dict, describe
from fuzzy.membership import FUNCTIONS
from fuzzy.membershipfunction import MATLAB_NAMES, MembershipFunction, parameter, register
from fuzzy.plugins.ccode.numbertype import ExportError
from fuzzy.plugins.ccode.plan import planned
from fuzzy.plugins.designer.design import Design, design_of
from fuzzy.plugins.designer.edits import EditError, apply
from fuzzy.plugins.designer.termedits import converted
from fuzzy.plugins.designer.views import design_data, functions_data
from fuzzy.profile import Outline, Profile
from robotics.laws.tracking.fuzzy_tracking import RULE_BASES, FuzzyTracking


@dataclass(frozen=True)
class Cosine(MembershipFunction):
    """cosmf [l r]: (1 + cos(2π (x − m)/(r − l)))/2 between l and r, about their middle m; 0 elsewhere."""

    l: Any = field(metadata=parameter("location", "left foot"))  # noqa: E741
    r: Any = field(metadata=parameter("location", "right foot"))
    matlab: ClassVar[str] = "cosmf"
    title: ClassVar[str] = "raised cosine"
    vertices: ClassVar[tuple[int, ...]] = (0, 1)
    grid: ClassVar[Any] = staticmethod(lambda c, h, slope: (c - 2 * h, c + 2 * h))

    @classmethod
    def formula(cls, x: Any, *parameters: Any) -> Any:
        left, right = parameters
        xp = array_namespace(x)
        phase = xp.clip((x - (left + right) / 2) / (right - left), -0.5, 0.5)
        return (1 + xp.cos(2 * np.pi * phase)) / 2

    def profile(self, span: float) -> Profile:
        left, right = self.numbers
        quarter = (right - left) / 4
        return Profile.between(left + quarter, right - quarter, 2 * quarter, 2 * quarter)

    @classmethod
    def fitted(cls, outline: Outline) -> tuple[float, ...]:
        return outline.center - 2 * outline.half, outline.center + 2 * outline.half


@pytest.fixture(autouse=True)
def cosine() -> Iterator[None]:
    register(Cosine)
    yield
    del MATLAB_NAMES[Cosine.matlab]


def system() -> fuzzy.Sugeno:
    x = fuzzy.Variable("x", (0.0, 4.0), {"near": Cosine(-2.0, 2.0), "far": fuzzy.trimf(0.0, 4.0, 8.0)}, "m")
    y = fuzzy.Variable("y", (0.0, 10.0), {"slow": 1.0, "fast": 9.0})
    return fuzzy.Sugeno([x], [y], ["if x is near then y is slow", "if x is far then y is fast"], name="small")


def edit(design: Design, name: str, **content: Any) -> Design:
    return apply(design, {"edit": name, "variable": "x", **content})


def test_inference_knows_it_with_numpy_and_torch() -> None:
    assert Cosine(-2.0, 2.0)([-2, -1, 0, 1, 2, 3]) == pytest.approx([0, 0.5, 1, 0.5, 0, 0])
    assert fuzzy.infer(system(), [1.0]).output == pytest.approx([(0.5 * 1 + 0.25 * 9) / 0.75])
    x = torch.tensor([1.0], dtype=torch.float64, requires_grad=True)
    fuzzy.infer(system(), x).memberships[0][0].backward()
    assert x.grad is not None
    assert x.grad.item() == pytest.approx(-np.pi / 4)  # the slope of the cosine at degree 0.5


def test_parameters_are_checked_as_the_class_says() -> None:
    with pytest.raises(fuzzy.MembershipError, match=r"\(cosmf\): left foot and right foot must be in order, l <= r"):
        fuzzy.membership_function("cosmf", (2, 1))
    with pytest.raises(fuzzy.MembershipError, match="did you mean 'cosmf'"):
        fuzzy.membership_function("cosmg", (1, 2))
    with pytest.raises(fuzzy.MembershipError, match="trimf is the name of Triangle already"):
        register(type("Other", (Cosine,), {"matlab": "trimf"}))


def test_files_and_descriptions_know_it() -> None:
    text = format_fis(system())
    assert "'near':'cosmf',[-2 2]" in text
    assert parse_fis(text).inputs == system().inputs
    assert "near  cosmf [-2 2]" in describe(system())
    assert as_dict(system())["inputs"][0]["terms"][0] == {"name": "near", "type": "cosmf", "parameters": [-2, 2]}


@pytest.mark.parametrize("function", FUNCTIONS, ids=lambda function: function.matlab)
def test_every_function_becomes_it_and_it_becomes_every_function(function: type[MembershipFunction]) -> None:
    there = converted(Cosine(-2.0, 2.0), function.matlab, (-4.0, 4.0))
    assert isinstance(there, function)
    assert abs(there([1.0])[0] - 0.5) < 0.1 or there([-1.0])[0] == pytest.approx(0.5, abs=0.1)
    assert isinstance(converted(there, "cosmf", (-4.0, 4.0)), Cosine)


def test_the_designer_knows_it() -> None:
    design = edit(design_of(system()), "term_type", term="far", type="cosmf")
    assert design.system["x"].terms["far"] == Cosine(0.0, 8.0)
    design = edit(design, "add_term", type="cosmf")
    assert isinstance(design.system["x"].terms["mf3"], Cosine)
    design = edit(design, "term", term="near", parameters=[-1.0, 2.0])
    with pytest.raises(EditError, match="the left foot of near, 3, must not lie right of its right foot, 2"):
        edit(design, "term", term="near", parameters=[3.0, 2.0])
    stretched = edit(design, "universe", low=0.0, high=8.0, scale=True)
    assert stretched.system["x"].terms["near"] == Cosine(-2.0, 4.0)
    shown = json.loads(json.dumps([design_data(design), functions_data()], allow_nan=False))
    assert [term["type"] for term in shown[0]["inputs"][0]["terms"]] == ["cosmf", "cosmf", "cosmf"]
    assert shown[1]["cosmf"] == {
        "title": "raised cosine",
        "words": ["left foot", "right foot"],
        "roles": ["location", "location"],
        "vertices": [0, 1],
    }


def test_a_grid_of_it_is_identified_and_learnt() -> None:
    x = np.linspace(0.0, 4.0, 41)[:, None]
    fis = identify(x, np.sin(x[:, 0]), mfs=3, kind="cosmf")
    assert [term.parameters for term in fis.inputs[0].terms.values()] == [(-2, 2), (0, 4), (2, 6)]
    np.testing.assert_allclose(sum(fuzzy.infer(fis, x).memberships[0].T), 1.0)  # raised cosines add up to 1
    learnt = premises(fis, dtype=torch.float64, device="cpu")
    start = learnt.start()
    crossed = start[0].clone()
    crossed[0] = crossed[0].flip(-1)  # an optimiser that moves the left foot past the right one
    torch.testing.assert_close(learnt.valid((crossed,)), start)


def test_without_a_branch_the_compiled_kernel_refuses_it_or_reads_it_in_steps() -> None:
    with pytest.raises(fuzzy.FuzzySystemError, match="small: the compiled kernel has no branch for cosmf; fuzzy"):
        compile_sugeno(system())
    # A chord of a step h is off by h²/8 f'' at most: (4/4096)²/8 · (2π/4)²/2
    with pytest.warns(fuzzy.InferenceWarning, match=r"no branch for cosmf, and reads it in 4096 .* within 1\.5e-07"):
        compiled = compile_sugeno(system(), sample=True)
    x = np.random.default_rng(1).uniform(0.0, 4.0, (500, 1))
    exact = fuzzy.infer(system(), x).output
    np.testing.assert_allclose(compiled(x), exact, rtol=0, atol=8 * 2 * 1.5e-7)
    np.testing.assert_array_equal([compiled(point) for point in x], compiled(x))  # by points and by blocks
    assert np.isnan(compiled(np.array([np.nan])))


def test_a_positive_one_is_read_as_its_logarithm(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(Cosine, "log_formula", classmethod(lambda cls, x, l, r: -((x - (l + r) / 2) ** 2)))  # noqa: E741
    monkeypatch.setattr(Cosine, "formula", classmethod(lambda cls, x, *p: np.exp(cls.log_formula(x, *p))))
    x = fuzzy.Variable("x", (0.0, 99.0), {"near": Cosine(-2.0, 2.0), "far": Cosine(94.0, 96.0)})
    y = fuzzy.Variable("y", (0.0, 10.0), {"slow": 1.0, "fast": 9.0})
    both = fuzzy.Sugeno([x], [y], ["if x is near then y is slow", "if x is far then y is fast"])
    with pytest.warns(fuzzy.InferenceWarning, match="cosmf"):
        compiled = compile_sugeno(both, sample=True)
    points = np.linspace(0.0, 99.0, 1001)[:, None]  # in the middle both degrees underflow
    np.testing.assert_allclose(compiled(points), fuzzy.infer(both, points).output, rtol=0, atol=0.01)


@pytest.mark.filterwarnings("ignore::fuzzy.inference.InferenceWarning")
def test_it_drives_a_robot_and_c_says_where_its_formula_goes(tmp_path: Path) -> None:
    tracking = fuzzy.read_fis(RULE_BASES / "tracking.fis")
    alpha = tracking["alpha"]
    sets = {name: converted(f, "cosmf", alpha.universe) for name, f in alpha.terms.items()}
    inputs = [replace(v, terms=sets) if v is alpha else v for v in tracking.inputs]
    mine = replace(tracking, inputs=inputs, name="mine")
    file = tmp_path / "mine.fis"
    fuzzy.write_fis(mine, file)
    law = robotics.make_controller(str(file))
    scenario = robotics.load_scenario("lyapunov-sine")
    end = robotics.measure_all(robotics.simulate(scenario, law, (0,)), only=["final_error_m"])["final_error_m"]
    assert end < 0.1
    low, high = np.transpose([v.universe for v in inputs])
    seen = np.random.default_rng(2).uniform(low, high, (200, len(inputs)))
    assert isinstance(law, FuzzyTracking)
    np.testing.assert_allclose(law.tracking(seen), fuzzy.infer(mine, seen).output, rtol=0, atol=1e-4)
    with pytest.raises(
        ExportError, match=r"no formula in C of the membership function cosmf; it would stand in floating"
    ):
        planned(mine)
