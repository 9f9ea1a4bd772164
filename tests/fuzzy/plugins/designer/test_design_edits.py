"""Edits of a design: what each does, what it refuses, and that no sequence of messages breaks anything."""

import json
import warnings
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

import fuzzy
from fuzzy.membership import FUNCTIONS
from fuzzy.membershipfunction import MATLAB_NAMES
from fuzzy.plugins.designer.design import CHOICES, Design, design_of, file_text
from fuzzy.plugins.designer.edits import EDITS, EditError, apply, edited
from fuzzy.plugins.designer.sideeffects import broken
from fuzzy.plugins.designer.termedits import converted
from fuzzy.plugins.designer.views import design_data, surface_data, viewer_data
from fuzzy.system import Linear, Sugeno, Variable
from tests.fuzzy.plugins.designer.design_messages import JUNK, NEEDS, messages, system


def edit(design: Design, op: str, **fields) -> Design:
    return apply(design, {"edit": op, **fields})


def refused(design: Design, op: str, match: str, **fields) -> None:
    with pytest.raises(fuzzy.InputError, match=match):
        edit(design, op, **fields)


def test_an_edit_finds_its_place_by_a_name_that_was_just_given_up():
    """As by a quick hand: the page sends the next field's number before it hears of the renaming."""
    d = design_of(system())
    first = d.system.inputs[0]
    old, term = first.name, next(iter(first.terms))
    d = edit(d, "rename_variable", kind="input", variable=old, name="once")
    d = edit(d, "rename_variable", kind="input", variable=old, name="twice")
    d = edit(d, "unit", kind="input", variable=old, unit="km")
    d = edit(d, "rename_term", kind="input", variable=old, term=term, name="other")
    moved = [p + 0.01 for p in first.terms[term].parameters]
    d = edit(d, "term", kind="input", variable="twice", term=term, parameters=moved)
    found = d.system.inputs[0]
    assert (found.name, found.unit) == ("twice", "km")
    assert found.terms["other"].parameters == pytest.approx(moved)
    refused(d, "unit", "unknown output", kind="output", variable=old, unit="km")
    d = edit(d, "add_variable", kind="input", name=old)  # now it is another one's
    d = edit(d, "unit", kind="input", variable=old, unit="mm")
    assert [v.unit for v in d.system.inputs if v.name in (old, "twice")] == ["km", "mm"]


def name_of(design: Design, op: str, **fields) -> str:
    return edited(design, {"edit": op, **fields}).name


def sentences(design: Design) -> list[str]:
    return [line.text for line in design.lines]


def ordered(rules, inputs):
    """Rules with their clauses in the inputs' order, as a file keeps them."""
    place = {v.name: i for i, v in enumerate(inputs)}
    then = lambda rule: tuple(sorted(rule.then))  # noqa: E731
    return [replace(r, when=tuple(sorted(r.when, key=lambda c: place[c.variable])), then=then(r)) for r in rules]


def reads_back_equal(design: Design) -> None:
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", fuzzy.FisFileWarning)  # hedges
        back = fuzzy.parse_fis(file_text(design))
    assert replace(back, rules=()) == replace(design.written, rules=())
    assert ordered(back.rules, back.inputs) == ordered(design.written.rules, back.inputs)


# Terms --------------------------------------------------------------------------------------------------------


def spread_system(types=("trimf", "trimf", "trimf")):
    far = {"small": (-1, 0, 1), "medium": (1, 2, 2.5), "large": (3, 8, 9)}
    terms = {n: converted(fuzzy.Triangle(*far[n]), t, (0, 8)) for n, t in zip(far, types, strict=True)}
    out = {"slow": 0.3, "fast": 0.9, "middle": 0.8}
    rules = [f"if d is {a} then v is {b}" for a, b in (("small", "slow"), ("medium", "middle"), ("large", "fast"))]
    return Sugeno([Variable("d", (0, 8), terms)], [Variable("v", (0.0, 1.0), out)], rules)


def test_terms_are_spread_evenly_with_their_names_and_types():
    d = design_of(spread_system(("trimf", "gaussmf", "trimf")))
    three = edit(d, "spread_terms", variable="d", count=3).system["d"].terms
    assert list(three) == ["small", "medium", "large"]
    assert three["small"] == fuzzy.Triangle(-4, 0, 4)
    x = np.linspace(0, 8, 101)
    assert np.allclose(three["medium"](x), 0.5 ** ((x - 4) / 2) ** 2)  # 1 in the middle, 0.5 where it meets the others
    assert edit(d, "spread_terms", variable="d", count=3).lines == d.lines
    more = edit(d, "spread_terms", variable="d", count=5)
    assert list(more.system["d"].terms) == ["small", "mf4", "medium", "mf5", "large"]
    assert [float(t(np.array([2.0 * k]))[0]) for k, t in enumerate(more.system["d"].terms.values())] == [1] * 5
    triangles = edit(more, "term_types", variable="d", type="trimf").system["d"].terms.values()
    assert np.allclose(sum(t(x) for t in triangles), 1)
    assert more.lines == d.lines
    reads_back_equal(more)


def test_ramps_stay_at_the_ends_and_fewer_terms_take_their_clauses_along():
    d = design_of(spread_system(("linzmf", "trimf", "linsmf")))
    five = edit(d, "spread_terms", variable="d", count=5).system["d"].terms
    assert (five["small"], five["large"]) == (fuzzy.LinearZ(0, 2), fuzzy.LinearS(6, 8))
    x = np.linspace(0, 8, 101)
    assert np.allclose(sum(term(x) for term in five.values()), 1)
    message = {"edit": "spread_terms", "variable": "d", "count": 2}
    two = apply(d, message)
    assert list(two.system["d"].terms) == ["small", "large"]
    assert [str(line.rule) for line in two.lines] == ["if d is small then v is slow", "if d is large then v is fast"]
    assert broken(d, two, message) == "Terms of d removed; 1 rule removed."
    assert broken(d, apply(d, {**message, "count": 4}), {**message, "count": 4}) is None
    assert name_of(d, "spread_terms", variable="d", count=2) == "spread 2 terms of d, with 1 rule that had nothing else"
    inside = design_of(spread_system(("trimf", "linsmf", "trimf")))  # a ramp stands at an end only
    assert edit(inside, "spread_terms", variable="d", count=3).system["d"].terms["medium"] == fuzzy.Triangle(0, 4, 8)


def test_constants_are_spread_in_their_order_and_linear_consequents_are_not():
    d = edit(design_of(spread_system()), "spread_terms", variable="v", count=3)
    assert {name: float(t.value) for name, t in d.system["v"].terms.items()} == {"slow": 0, "fast": 1, "middle": 0.5}
    linear = edit(d, "term_types", variable="v", type="linear")
    assert all(isinstance(term, Linear) for term in linear.system["v"].terms.values())
    assert linear.system([[2.0]]) == pytest.approx(d.system([[2.0]]))
    refused(linear, "spread_terms", "linear consequents", variable="v", count=3)
    assert edit(linear, "term_types", variable="v", type="constant").system == d.system
    for count, match in ((1, "must be >= 2"), (201, "<= 200"), (2.5, "whole number"), (None, "whole number")):
        refused(d, "spread_terms", match, variable="d", count=count)
    refused(d, "term_types", "did you mean 'gaussmf'", variable="d", type="gausmf")
    refused(d, "term_types", "unknown consequent", variable="v", type="gaussmf")


def test_all_terms_change_their_type_as_one_by_one():
    d = design_of(spread_system())
    one_by_one = d
    for term in ("small", "medium", "large"):
        one_by_one = edit(one_by_one, "term_type", variable="d", term=term, type="gaussmf")
    assert edit(d, "term_types", variable="d", type="gaussmf") == one_by_one
    assert name_of(d, "term_types", variable="d", type="gaussmf") == "make all of d gaussmf"


def test_moved_vertices_stay_in_order():
    d = design_of(system())
    moved = edit(d, "term", variable="distance", term="near", parameters=[0, 0.25, 1])
    assert moved.system["distance"].terms["near"] == fuzzy.trimf(0, 0.25, 1)
    assert list(moved.system["distance"].terms) == ["near", "far"]
    assert d.system == system()  # the design itself is as it was
    # In the words that stand beside the fields
    refused(d, "term", "^the peak of near, 1.25, must not lie right of its right foot, 1$", variable="distance",
            term="near", parameters=[0, 1.25, 1])  # fmt: skip
    refused(d, "term", "^the left shoulder of far, 2.5, must not lie right of its right shoulder, 2$",
            variable="distance", term="far", parameters=[0.5, 2.5, 2, 2.75])  # fmt: skip
    refused(d, "term", "^the width σ of right must not be 0$", variable="bearing", term="right", parameters=[0, -2])
    refused(d, "rename_variable", "^the name must not be empty$", variable="bearing", name=" ")
    refused(d, "rename_term", "^the name must be a text of at most 100 characters, got 'aaa",
            variable="bearing", term="right", name="a" * 101)  # fmt: skip
    refused(
        d,
        "universe",
        "^the highest value must be a finite number, got 1e\\+300$",
        variable="bearing",
        low=0,
        high=1e300,
    )
    refused(d, "term", "3 parameters", variable="distance", term="near", parameters=[0, 1])
    refused(d, "term", "finite number", variable="distance", term="near", parameters=[0, 1, float("inf")])
    refused(d, "term", "did you mean 'near'", variable="distance", term="naer", parameters=[0, 1, 2])


def test_vertices_that_a_file_has_crossed_can_be_moved():
    crossed = fuzzy.trapmf(0, 1.5, 1, 2)
    d = design_of(replace(system(), inputs=[replace(system().inputs[0], terms={"near": crossed, "far": crossed}),
                                            system().inputs[1]]))  # fmt: skip
    moved = edit(d, "term", variable="distance", term="near", parameters=[0, 1.25, 1, 2])
    moved = edit(moved, "term", variable="distance", term="near", parameters=[0, 1, 1, 2])
    refused(
        moved,
        "term",
        "the left shoulder of near, 1.25, must not lie right of its right shoulder, 1",
        variable="distance",
        term="near",
        parameters=[0, 1.25, 1, 2],
    )


@pytest.mark.parametrize(
    ("before", "kind", "after"),
    [
        (fuzzy.trimf(0, 1, 2), "trapmf", (0, 1, 1, 2)),
        (fuzzy.trapmf(0, 1, 1.5, 2), "trimf", (0, 1.25, 2)),
        (fuzzy.trapmf(0, 1, 1.5, 2), "pimf", (0, 1, 1.5, 2)),
        (fuzzy.smf(0, 1), "linsmf", (0, 1)),
        (fuzzy.linzmf(1, 2), "zmf", (1, 2)),
        (fuzzy.linzmf(1, 2), "trapmf", (-4, -4, 1, 2)),  # open to the left: closed at the end of the universe
        (fuzzy.linsmf(1, 2), "trapmf", (1, 2, 4, 4)),
        (fuzzy.linsmf(1, 2), "trimf", (1, 4, 4)),
        (fuzzy.trimf(0, 1, 3), "linzmf", (1, 3)),
        (fuzzy.trimf(0, 1, 3), "linsmf", (0, 1)),
        (fuzzy.linsmf(1, 2), "sigmf", (4, 1.5)),
        (fuzzy.linzmf(1, 2), "sigmf", (-4, 1.5)),
        (fuzzy.gbellmf(1, 2, 0.5), "trapmf", (-1, 0, 1, 2)),
        (fuzzy.sigmf(2, 1), "linsmf", (0, 2)),
        (fuzzy.dsigmf(4, 0, 4, 2), "trapmf", (-0.5, 0.5, 1.5, 2.5)),
        (fuzzy.psigmf(4, 0, -4, 2), "dsigmf", (4, 0, 4, 2)),
    ],
)
def test_another_type_has_the_same_vertices(before, kind, after):
    assert converted(before, kind, (-4, 4)).parameters == pytest.approx(after, rel=1e-12)


BUMPS = ("trimf", "trapmf", "pimf", "gaussmf", "gauss2mf", "gbellmf", "dsigmf", "psigmf")


@pytest.mark.parametrize("kind", BUMPS)
@pytest.mark.parametrize("source", [fuzzy.trimf(0, 2, 4), fuzzy.gaussmf(0.75, 2), fuzzy.gbellmf(1, 3, 2)])
def test_a_bump_of_another_type_keeps_its_place_and_its_width(source, kind):
    """Independent of the formulas of conversion: half-degree points and maximum, by looking."""
    x = np.linspace(-4, 8, 24001)
    degrees = [f(x) for f in (source, converted(source, kind, (-4, 8)))]
    (l0, r0), (l1, r1) = ((x[y >= 0.5][0], x[y >= 0.5][-1]) for y in degrees)
    m0, m1 = (x[y >= y.max() - 1e-9].mean() for y in degrees)
    assert degrees[1].max() > 0.95
    if kind == "trimf" and source == fuzzy.gbellmf(1, 3, 2):
        assert r1 - l1 == pytest.approx(r0 - l0, rel=0.34)  # a plateau has no triangle of that support and width
    else:
        assert (l1, r1) == pytest.approx((l0, r0), abs=0.09)
    assert m1 == pytest.approx(m0, abs=0.01)


@pytest.mark.parametrize("source", ["linzmf", "zmf", "sigmf"])
@pytest.mark.parametrize("kind", sorted(set(MATLAB_NAMES) - {"linsmf", "smf", "gaussmf", "gbellmf", "trimf"}))
def test_a_shoulder_stays_one_within_the_universe(source, kind):
    before = fuzzy.membership_function(source, (-5.0, 0.5) if source == "sigmf" else (0.1, 0.9))
    after = converted(before, kind, (0, 2))
    x = np.linspace(0, 2, 401)
    assert np.abs(after(x) - before(x)).max() < 0.2  # at the joints, where curves and straight edges differ
    assert after([0.0])[0] > 0.9
    assert after([2.0])[0] < 0.1


@given(st.data())
@settings(max_examples=60)
def test_every_function_becomes_every_other(data):
    old, new = data.draw(st.sampled_from(FUNCTIONS)), data.draw(st.sampled_from(FUNCTIONS))
    count = len(old.roles)
    numbers = data.draw(
        st.lists(st.floats(-1e3, 1e3) | st.sampled_from([0.0, 1.0, -1.0]), min_size=count, max_size=count)
    )
    if old.roles == ("location",) * count:
        numbers.sort()
    try:
        function = old(*numbers)
    except fuzzy.MembershipError:
        return
    after = converted(function, new.matlab, (-2, 5))
    assert type(after) is new
    vertices = [p for p, role in zip(after.parameters, new.roles, strict=True) if role == "location"]
    assert new is old or vertices == sorted(vertices)
    assert type(converted(after, old.matlab, (-2, 5))) is old


def test_a_consequent_of_another_type_says_the_same_in_the_middle():
    d = design_of(system())
    constant = edit(d, "term_type", variable="v", term="fast", type="constant")
    assert constant.system["v"].terms["fast"].value == 0.75  # 0.25 · 1 + 0.5
    linear = edit(constant, "term_type", variable="v", term="fast", type="linear")
    assert linear.system["v"].terms["fast"] == Linear((0.0, 0.0), 0.75)
    refused(d, "term_type", "unknown consequent 'trimf'", variable="v", term="fast", type="trimf")
    refused(d, "term_type", "unknown membership function", variable="distance", term="near", type="linear")
    refused(d, "term", "2 slopes, one per input, and a constant", variable="v", term="fast", parameters=[1])


def test_a_new_term_stands_where_there_is_room():
    d = edit(design_of(system()), "remove_term", variable="distance", term="far")
    d = edit(d, "add_term", variable="distance")
    assert d.system["distance"].terms["mf2"].parameters[1] == pytest.approx(1.5)  # near ends at 1
    d = edit(d, "add_term", variable="v", name="reverse", type="linear")
    assert d.system["v"].terms["reverse"] == Linear((0.0, 0.0), 0.5)
    refused(d, "add_term", "already a term of 'v' named 'reverse'", variable="v", name="reverse")
    for kind in MATLAB_NAMES:
        d = edit(d, "add_term", variable="bearing", type=kind)
    assert [f.matlab for f in d.system["bearing"].terms.values()][2:] == list(MATLAB_NAMES)
    reads_back_equal(d)


def test_a_term_that_is_removed_leaves_the_rules():
    d = design_of(system())
    message = {"variable": "bearing", "term": "right"}
    assert name_of(d, "remove_term", **message) == "remove right, from 1 rule, with 1 rule that had nothing else"
    d = edit(d, "remove_term", **message)
    assert sentences(d) == [
        "if distance is near and bearing is left then v is slow and w is ccw",
        "if distance is far then v is fast with 0.5",
    ]
    assert [line.key for line in d.lines] == [0, 1]


def test_a_new_name_stands_in_the_rules_too():
    d = design_of(system())
    d = edit(d, "rename_term", variable="bearing", term="right", name="to starboard")
    d = edit(d, "rename_variable", variable="bearing", name="course")
    d = edit(d, "rename_variable", variable="w", name="turn")
    d = edit(d, "rename_term", variable="turn", term="cw", name="then")
    assert sentences(d) == [
        "if distance is near and course is left then v is slow and turn is ccw",
        "if distance is far or course is not very 'to starboard' then v is fast with 0.5",
        "if course is 'to starboard' then turn is 'then'",
    ]
    points = np.array([[0.3, -1.0], [1.5, 0.5]])
    assert np.array_equal(d.system(points), system()(points))
    refused(d, "rename_variable", "already a variable named 'v'", variable="course", name="v")
    refused(d, "rename_term", "must not be empty", variable="course", term="left", name="  ")
    refused(d, "rename_term", "control characters", variable="course", term="left", name="a\nb")
    assert edit(d, "rename_term", variable="course", term="left", name="left") == d


def test_kind_tells_an_input_from_an_output_of_the_same_name():
    same = Sugeno(
        [Variable("v", (0, 1), {"low": fuzzy.linzmf(0, 1)})], [Variable("v", (0, 1), {"low": 0.0})],
        ["if v is low then v is low"],
    )  # fmt: skip
    d = edit(design_of(same), "rename_term", variable="v", kind="output", term="low", name="idle")
    assert sentences(d) == ["if v is low then v is idle"]
    d = edit(d, "rename_variable", variable="v", name="speed")
    assert sentences(d) == ["if speed is low then v is idle"]


# Variables ----------------------------------------------------------------------------------------------------


def test_linear_consequents_follow_the_inputs():
    d = edit(design_of(system()), "add_variable", kind="input")
    assert [v.name for v in d.system.inputs] == ["distance", "bearing", "input3"]
    assert d.system["v"].terms["fast"] == Linear((0.25, 0.0, 0.0), 0.5)
    assert d.point == (1.0, 0.0, 0.5)
    d = edit(d, "remove_variable", variable="bearing")
    assert d.system["v"].terms["fast"] == Linear((0.25, 0.0), 0.5)
    assert d.point == (1.0, 0.5)
    assert sentences(d) == [
        "if distance is near then v is slow and w is ccw",
        "if distance is far then v is fast with 0.5",
    ]
    d = edit(d, "add_variable", kind="output", name="gripper")
    reads_back_equal(d)
    d = edit(edit(d, "remove_variable", variable="w"), "remove_variable", variable="v")
    assert sentences(d) == []
    refused(d, "remove_variable", "at least one output", variable="gripper")


def test_the_universe_moves_no_term_unless_it_is_stretched():
    d = design_of(system())
    wider = edit(d, "universe", variable="distance", low=-1, high=8)
    assert wider.system["distance"].universe == (-1, 8)
    assert wider.system["distance"].terms == d.system["distance"].terms
    assert edit(d, "universe", variable="distance", low=3, high=8).point == (3, 0)
    refused(d, "universe", "ascending", variable="distance", low=1, high=1)
    in_cm = edit(d, "universe", variable="distance", low=0, high=200, scale=True)
    points = np.random.default_rng(1).uniform([0, -3], [2, 3], (50, 2))
    assert in_cm.system(points * [100, 1]) == pytest.approx(d.system(points), abs=1e-12)
    assert in_cm.point == (100, 0)
    turned = edit(d, "universe", variable="w", low=-90, high=90, scale=True)
    assert turned.system(points)[:, 1] == pytest.approx(90 * d.system(points)[:, 1], abs=1e-9)
    shifted = edit(d, "universe", variable="bearing", low=0, high=6, scale=True)
    assert shifted.system(points + np.array([0, 3])) == pytest.approx(d.system(points), abs=1e-12)


def test_choices_are_the_systems():
    d = design_of(system())
    for name, values in CHOICES.items():
        for value in values:
            assert getattr(edit(d, "choice", name=name, value=value).system, name) == value
    refused(d, "choice", "unknown and_method 'mean'", name="and_method", value="mean")
    refused(d, "choice", "unknown choice", name="implication", value="min")


# Rules --------------------------------------------------------------------------------------------------------


def test_a_wrong_sentence_keeps_the_last_good_rule_and_says_where():
    d = design_of(system())
    text = "if distance is naer then v is slow"
    wrong = edit(d, "rule_text", key=0, text=text)
    line = wrong.lines[0]
    assert (line.text, line.rule) == (text, d.lines[0].rule)
    assert text[line.problem.start : line.problem.end] == "naer"
    assert wrong.in_force == d.in_force
    assert file_text(wrong) == file_text(d)
    # The word may become one: then the sentence counts.
    right = edit(wrong, "rename_term", variable="distance", term="near", name="naer")
    assert right.lines[0].problem is None
    assert str(right.system.rules[0]) == text
    # The table's edit replaces the sentence.
    assert edit(wrong, "rule_weight", key=0, weight=0.25).lines[0].text == d.lines[0].text + " with 0.25"
    off = edit(wrong, "rule_enabled", key=0, enabled=False)
    assert off.lines[0].text == text
    assert len(off.in_force.rules) == 2


def test_a_problem_counts_as_javascript_does():
    d = edit(design_of(system()), "rule_text", key=0, text="if distance is '\U0001f600' then v is fats")
    d = edit(d, "rename_term", variable="distance", term="near", name="\U0001f600")
    (problem,) = (r["problem"] for r in design_data(d)["rules"] if r["problem"])
    text = d.lines[0].text.encode("utf-16-le")
    assert text[2 * problem["start"] : 2 * problem["end"]].decode("utf-16-le") == "fats"


def test_powers_that_no_file_holds_are_refused():
    d = design_of(system())
    for power in ("^1.25", "^0.05", "^12"):
        wrong = edit(d, "rule_text", key=0, text=f"if distance is near{power} then v is slow")
        assert "0.1, 0.2" in wrong.lines[0].problem.message
    refused(d, "rule_clause", "0.1, 0.2", key=0, variable="distance", term="near", power=1.25)
    hedged = edit(d, "rule_clause", key=0, variable="distance", term="near", power=0.5, negated=True)
    assert sentences(hedged)[0].startswith("if distance is not somewhat near and")
    reads_back_equal(hedged)


def test_the_rule_table():
    d = design_of(system())
    d = edit(d, "copy_rule", key=0)
    d = edit(d, "move_rule", key=2, to=0)
    assert [line.key for line in d.lines] == [2, 0, 3, 1]
    d = edit(d, "remove_rule", key=3)
    d = edit(d, "add_rule", after=2)
    assert [line.key for line in d.lines] == [2, 4, 0, 1]  # 3 is not given again
    assert sentences(d)[1] == "if distance is near and bearing is right then v is slow and w is cw"
    d = edit(d, "add_rule", after=None, text="If (distance is far) then (w is cw) (0.5)")
    assert sentences(d)[-1] == "if distance is far then w is cw with 0.5"
    d = edit(d, "rule_clause", key=2, variable="distance", term="far")
    d = edit(d, "rule_connective", key=2, connective="or")
    d = edit(d, "rule_then", key=2, variable="v", term="fast")
    assert sentences(d)[0] == "if distance is far or bearing is right then v is fast and w is cw"
    d = edit(d, "rule_clause", key=2, variable="bearing", term=None)
    d = edit(d, "rule_then", key=2, variable="w", term=None)
    assert sentences(d)[0] == "if distance is far then v is fast"
    refused(d, "rule_clause", "its only one", key=2, variable="distance", term=None)
    refused(d, "rule_then", "its only one", key=2, variable="v", term=None)
    refused(d, "move_rule", "places 0 to 4", key=2, to=5)
    refused(d, "remove_rule", "no rule with the key 3", key=3)
    refused(d, "rule_weight", r"\[0, 1\]", key=2, weight=1.5)
    with pytest.raises(fuzzy.RuleError, match="did you mean 'far'"):
        edit(d, "add_rule", after=None, text="if distance is fra then w is cw")


def test_a_disabled_rule_has_no_weight_in_the_file_and_comes_back():
    d = edit(design_of(system()), "rule_enabled", key=2, enabled=False)
    text = file_text(d)
    assert text.splitlines()[-1] == "0 2, 0 2 (0) : 1"
    back = design_of(fuzzy.parse_fis(text))
    assert [line.enabled for line in back.lines] == [True, True, False]
    assert [line.rule.weight for line in back.lines] == [1, 0.5, 1]
    assert file_text(back) == text
    assert back.in_force.rules == d.in_force.rules == d.system.rules[:2]
    assert edit(back, "rule_enabled", key=2, enabled=True).in_force.rules == design_of(system()).system.rules


def test_all_combinations_are_added_once():
    d = design_of(system())
    assert name_of(d, "add_all_rules") == "add 3 rules"
    full = edit(d, "add_all_rules")
    assert sentences(full)[:3] == sentences(d)
    assert sentences(full)[3:] == [
        # one step from rule 1 (and none from rule 3, "if bearing is right": w is cw); v is left out there: slow
        "if distance is near and bearing is right then v is slow and w is cw",
        "if distance is far and bearing is left then v is slow and w is ccw",
        "if distance is far and bearing is right then v is slow and w is cw",
    ]
    refused(full, "add_all_rules", "every combination")
    empty = design_of(replace(system(), rules=()))
    assert sentences(edit(empty, "add_all_rules"))[-1].endswith("then v is slow and w is ccw")
    for _ in range(4):
        d = edit(d, "add_variable", kind="input")
    for _ in range(8):
        d = edit(d, "add_term", variable="input3")
    refused(d, "add_all_rules", "1188 combinations of terms, more than the limit of 1000")
    nothing = Sugeno([Variable("x", (0, 1))], [Variable("z", (0, 1))])
    refused(design_of(nothing), "add_all_rules", "no input has a term")
    refused(design_of(nothing), "add_rule", "no input has a term", after=None)


# Any message --------------------------------------------------------------------------------------------------


def test_every_edit_is_in_the_random_messages():
    assert set(NEEDS) == set(EDITS)


@given(st.lists(messages(), max_size=12))
@settings(max_examples=40, suppress_health_check=[HealthCheck.too_slow])
def test_no_sequence_of_messages_breaks_a_design(sequence):
    d, problems = design_of(system()), []
    for message in sequence:
        before = d
        try:
            d = apply(d, message)
        except fuzzy.InputError as error:
            problems.append(str(error))
            continue
        assert broken(before, d, message) != ""
        assert d.system.rules == tuple(line.rule for line in d.lines)
        assert len({line.key for line in d.lines}) == len(d.lines)
        assert all(line.problem or line.text == str(line.rule) for line in d.lines)
    assert all(problems)
    reads_back_equal(d)
    shown = [design_data(d), viewer_data(d), surface_data(d, points=3)]
    json.dumps(shown, allow_nan=False).encode()


@given(JUNK)
@settings(max_examples=60)
def test_what_is_no_message_is_refused(junk):
    for message in (junk, {"edit": junk}, {"look": "point", "point": [junk]}):
        with pytest.raises(EditError):
            apply(design_of(system()), message)
