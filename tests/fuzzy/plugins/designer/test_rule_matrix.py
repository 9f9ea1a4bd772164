"""The rule matrix's edit, edits of several rules at once, and what edits are said to have done to other rules."""

from dataclasses import replace
from itertools import product

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import fuzzy
from fuzzy.language import parse_rule
from fuzzy.plugins.designer.design import Design, design_of
from fuzzy.plugins.designer.edits import apply, edited
from fuzzy.plugins.designer.matrixedits import fill_rules
from fuzzy.plugins.designer.message import Message
from fuzzy.plugins.designer.sideeffects import broken
from fuzzy.plugins.designer.views import design_data
from tests.fuzzy.plugins.designer.design_messages import system


def edit(design: Design, op: str, **fields) -> Design:
    return apply(design, {"edit": op, **fields})


def fill(design: Design, *cells, variable: str = "v") -> Design:
    return edit(design, "fill_rules", variable=variable, cells=list(cells))


def sentences(design: Design) -> list[str]:
    assert design.system.rules == tuple(line.rule for line in design.lines)
    return [line.text for line in design.lines]


def refused(design: Design, op: str, match: str, **fields) -> None:
    with pytest.raises(fuzzy.InputError, match=match):
        edit(design, op, **fields)


# The matrix -----------------------------------------------------------------------------------------------------


def grid(sizes: tuple[int, int], consequents: int, rules=()) -> fuzzy.Sugeno:
    """Inputs x and y, and an output z of so many consequents, 0.5 apart from -1."""
    inputs = []
    for name, size in zip("xy", sizes, strict=True):
        feet = np.linspace(0.0, 2.0, size)
        terms = {f"{name}{i}": fuzzy.Gaussian(0.4, float(foot)) for i, foot in enumerate(feet)}
        inputs.append(fuzzy.Variable(name, (0.0, 2.0), terms))
    output = fuzzy.Variable("z", (-1.0, 3.0), {f"c{k}": -1.0 + 0.5 * k for k in range(consequents)})
    return fuzzy.Sugeno(inputs, [output], rules, name="grid", no_rule_fires="nan")


@st.composite
def tables(draw: st.DrawFn):
    """Sizes, and for each cell ("any" included) a consequent's number or None."""
    sizes = draw(st.tuples(st.integers(1, 4), st.integers(1, 4)))
    cells = [cell for cell in product([None, *range(sizes[0])], [None, *range(sizes[1])]) if cell != (None, None)]
    old, new = (draw(st.fixed_dictionaries({c: st.none() | st.integers(0, 4) for c in cells})) for _ in range(2))
    return sizes, old, new


def message_of(cells: dict) -> list:
    named = lambda cell: {n: f"{n}{i}" for n, i in zip("xy", cell, strict=True) if i is not None}  # noqa: E731
    return [[named(cell), None if k is None else f"c{k}"] for cell, k in cells.items()]


@given(tables(), st.lists(st.tuples(st.floats(0, 2), st.floats(0, 2)), min_size=1, max_size=4))
@settings(max_examples=40)
def test_a_filled_matrix_is_read_back_and_infers_as_it_says(table, points):
    sizes, old, new = table
    d = fill(fill(design_of(grid(sizes, 5)), *message_of(old), variable="z"), *message_of(new), variable="z")
    # What the page reads back: the consequent by the terms that a rule asks for.
    read = {
        tuple({c["variable"]: c["term"] for c in rule["when"]}.get(name) for name in "xy"): rule["then"]
        for rule in design_data(d)["rules"]
    }
    wanted = {cell: k for cell, k in new.items() if k is not None}
    names = lambda cell: tuple(None if i is None else f"{n}{i}" for n, i in zip("xy", cell, strict=True))  # noqa: E731
    assert read == {names(cell): [{"variable": "z", "term": f"c{k}"}] for cell, k in wanted.items()}
    assert len(d.lines) == len(wanted)
    inputs, outputs = ({v.name: tuple(v.terms) for v in group} for group in (d.system.inputs, d.system.outputs))
    assert [parse_rule(text, inputs, outputs) for text in sentences(d)] == list(d.system.rules)
    for point in points if wanted else ():  # the weighted average, straight from the table
        degrees = [
            [1.0, *np.exp(-0.5 * ((x - np.linspace(0.0, 2.0, n)) / 0.4) ** 2)]
            for x, n in zip(point, sizes, strict=True)
        ]
        firing = {
            cell: np.prod([degree[0 if i is None else i + 1] for degree, i in zip(degrees, cell, strict=True)])
            for cell in wanted
        }
        mean = sum(f * (-1.0 + 0.5 * wanted[c]) for c, f in firing.items()) / sum(firing.values())
        np.testing.assert_allclose(d.in_force(np.array(point))[..., 0], mean, rtol=1e-9, atol=1e-12)


def test_a_cell_is_the_rule_with_exactly_its_terms():
    d = design_of(system())
    near_left, far = {"distance": "near", "bearing": "left"}, {"distance": "far"}
    filled = fill(d, [near_left, "fast"], [far, "slow"], [{"bearing": "right"}, "slow"])
    assert sentences(filled) == [
        "if distance is near and bearing is left then v is fast and w is ccw",
        "if distance is far or bearing is not very right then v is fast with 0.5",
        "if bearing is right then v is slow and w is cw",  # the rule for w takes it on
        "if distance is far then v is slow",
    ]
    assert [line.key for line in filled.lines] == [0, 1, 2, 3]
    assert edited(d, {"edit": "fill_rules", "variable": "v", "cells": [[far, "slow"]]}).name == "fill 1 cell of v"
    # Cleared: the output goes, and a rule with its last one; the rule with "or" is no cell's.
    cleared = fill(filled, [near_left, None], [far, None], [{"distance": "far", "bearing": "right"}, None])
    assert sentences(cleared) == [
        "if distance is near and bearing is left then w is ccw",
        "if distance is far or bearing is not very right then v is fast with 0.5",
        "if bearing is right then v is slow and w is cw",
    ]
    # Weight and switch stay; the last pair of a cell counts; the same again is no edit.
    weighed = edit(edit(d, "rule_weight", key=0, weight=0.25), "rule_enabled", key=0, enabled=False)
    again = fill(weighed, [near_left, "slow"], [near_left, "fast"])
    assert (again.lines[0].rule.weight, again.lines[0].enabled) == (0.25, False)
    assert again.lines[0].rule.then == (("v", "fast"), ("w", "ccw"))
    assert fill(again, [near_left, "fast"]) == again


def test_of_several_rules_of_a_cell_one_keeps_it():
    rules = [
        "if x is x0 then z is c0",
        "if x is x0 then z is c1 with 0.5",
        "if x is not x0 then z is c2",
        "if x is x0 then z is c3",
    ]
    d = edit(design_of(grid((2, 2), 5, rules)), "rule_enabled", key=0, enabled=False)
    message = {"edit": "fill_rules", "variable": "z", "cells": [[{"x": "x0"}, "c4"]]}
    filled = apply(d, message)
    assert sentences(filled) == ["if x is x0 then z is c4 with 0.5", "if x is not x0 then z is c2"]
    assert broken(d, filled, message) == "2 rules removed."
    assert sentences(fill(d, [{"x": "x0"}, None], variable="z")) == ["if x is not x0 then z is c2"]


def test_what_is_no_cell_is_refused():
    d = design_of(system())
    for cells, told in (
        ([], "no cell is chosen"),
        (None, "'cells' of the edit 'fill_rules'|needs 'cells'|must be"),
        ([[{}, "slow"]], "at least one clause"),
        ([[{"distance": "fra"}, "slow"]], "did you mean 'far'"),
        ([[{"v": "slow"}, "slow"]], "input"),
        ([[{"distance": "far"}, "fats"]], "did you mean 'fast'"),
        ([[{"distance": "far"}]], "is a pair"),
        ([["far", "slow"]], "is a pair"),
        ([[{"distance": ["far"]}, "slow"]], "must be a text"),
        ([[{"distance": "far"}, 3]], "must be a text"),
    ):
        refused(d, "fill_rules", told, variable="v", cells=cells)
    refused(d, "fill_rules", "output", variable="distance", cells=[[{"distance": "far"}, "slow"]])
    terms = {f"t{i}": fuzzy.Triangle(i - 1, i, i + 1) for i in range(40)}
    wide = replace(grid((1, 1), 2), inputs=[fuzzy.Variable(n, (0.0, 39.0), terms) for n in "xy"], rules=())
    cells = [[{"x": a, "y": b}, "c0"] for a in terms for b in terms]
    refused(design_of(wide), "fill_rules", "limit of 1000 rules", variable="z", cells=cells)
    full, _ = fill_rules(design_of(wide), Message({"variable": "z", "cells": cells[:225]}, "fill_rules"))
    assert len(full.lines) == 225  # 15 x 15


# Several rules --------------------------------------------------------------------------------------------------


def test_several_rules_are_one_edit():
    d = edit(design_of(system()), "add_all_rules")
    keys = [line.key for line in d.lines]
    assert keys == [0, 1, 2, 3, 4, 5]
    assert [line.key for line in edit(d, "remove_rule", keys=[1, 4, 1]).lines] == [0, 2, 3, 5]
    assert [line.key for line in edit(d, "move_rule", keys=[4, 0], to=2).lines] == [1, 2, 0, 4, 3, 5]
    assert [line.key for line in edit(d, "move_rule", keys=[4, 0], to=4).lines] == [1, 2, 3, 5, 0, 4]
    weighed = edit(d, "rule_weight", keys=[0, 2], weight=0.5)
    assert [line.rule.weight for line in weighed.lines] == [0.5, 0.5, 0.5, 1, 1, 1]
    assert sentences(weighed)[2].endswith("with 0.5")
    off = edit(d, "rule_enabled", keys=keys, enabled=False)
    assert not any(line.enabled for line in off.lines)
    then = edit(d, "rule_then", keys=[0, 2], variable="v", term="fast")
    assert [dict(line.rule.then)["v"] for line in (then.lines[0], then.lines[2])] == ["fast", "fast"]
    assert "w" not in dict(edit(d, "rule_then", keys=[0, 3], variable="w", term=None).lines[3].rule.then)
    name = lambda op, **fields: edited(d, {"edit": op, **fields}).name  # noqa: E731
    assert name("remove_rule", keys=[0, 3]) == "remove 2 rules"
    assert name("remove_rule", keys=[3]) == "remove rule 4"
    assert name("rule_weight", keys=keys, weight=0) == "weight of 6 rules"
    refused(d, "remove_rule", "no rule is selected", keys=[])
    refused(d, "remove_rule", "key 9", keys=[0, 9])
    refused(d, "remove_rule", "whole number", keys=[0, "x"])
    refused(d, "move_rule", "places 0 to 4", keys=[0, 1], to=5)
    refused(d, "rule_then", "rule 3 needs at least one consequent", keys=[0, 2], variable="w", term=None)


# What an edit did besides ---------------------------------------------------------------------------------------


def told(design: Design, op: str, **fields) -> str | None:
    message = {"edit": op, **fields}
    return broken(design, apply(design, message), message)


def test_a_removal_says_what_it_did_to_the_rules():
    d = design_of(system())
    assert told(d, "remove_term", variable="distance", term="far") == "far of distance removed; 1 rule changed."
    assert told(d, "remove_variable", variable="w") == "w removed; 1 rule removed and 1 rule changed."
    assert told(d, "remove_rule", key=1) == "Rule 2 removed."
    assert told(d, "remove_rule", keys=[0, 1]) == "2 rules removed."
    spare = edit(d, "add_term", variable="v", name="spare")
    assert told(spare, "remove_term", variable="v", term="spare") == "spare of v removed; no rule changed."
    assert told(d, "add_term", variable="v") is None
    assert told(d, "rule_then", key=0, variable="v", term="fast") is None
    assert told(d, "add_all_rules") == "3 rules added."


def test_an_input_that_goes_leaves_rules_that_contradict_each_other():
    """Nine rules for two inputs of three terms: without y three ask for each term of x."""
    rules = [f"if x is x{i} and y is y{j} then z is c{j if i else 0}" for i, j in product(range(3), repeat=2)]
    d = design_of(grid((3, 3), 3, rules))
    sentence = told(d, "remove_variable", variable="y")
    assert sentence == "y removed; 9 rules changed. Now 6 rules contradict each other and 3 rules repeat each other."
    # Those that disagreed before are not counted as news.
    off = edit(d, "rule_enabled", keys=[3, 4, 5, 6, 7, 8], enabled=False)
    assert told(off, "remove_variable", variable="y") == "y removed; 9 rules changed. Now 3 rules repeat each other."


def test_linear_consequents_that_follow_an_input_are_told():
    d = design_of(system())  # fast is 0.25 distance + 0.5
    sentence = told(d, "remove_variable", variable="distance")
    assert sentence == "distance removed; 2 rules changed. 1 linear consequent lost a slope with it."
    assert told(d, "remove_variable", variable="bearing") == "bearing removed; 1 rule removed and 2 rules changed."
    stretched = told(d, "universe", variable="distance", low=0, high=4, scale=True)
    assert stretched == "1 linear consequent changed with the range."


def test_a_range_that_leaves_consequents_or_terms_behind_is_told():
    d = design_of(grid((3, 3), 9, ["if x is x0 then z is c0", "if y is y1 then z is c8", "if x is x2 then z is c8"]))
    change = {"variable": "z", "low": -0.75, "high": 2.6}
    assert told(d, "universe", **change) == "c0 and c8 of z lie outside its new range now, in 3 rules."
    assert told(edit(d, "universe", **change), "universe", variable="z", low=-0.75, high=2.5) is None  # nothing more
    assert told(d, "universe", **change, scale=True) is None  # the consequents go with it
    many = told(d, "universe", variable="z", low=0.9, high=1.1)
    assert many == "c0, c1, c2 and 5 more of z lie outside its new range now, in 3 rules."
    near = design_of(system())
    assert told(near, "universe", variable="distance", low=1, high=2) == (
        "near of distance is 0 in all of its new range, in 1 rule."
    )


def test_a_sentence_that_can_be_read_now_is_told():
    d = edit(design_of(system()), "rule_text", key=2, text="if bearing is back then w is cw")
    assert d.lines[2].problem
    assert told(d, "add_term", variable="bearing", name="back") == (
        "The sentence of rule 3 can be read now, and is in force."
    )
