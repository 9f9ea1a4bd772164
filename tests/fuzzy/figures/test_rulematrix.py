"""The rule matrix: which rules have a cell, what stands in it, and when a set of pictures has one."""

from dataclasses import replace

import numpy as np
import pytest
from matplotlib.collections import QuadMesh

import fuzzy
from fuzzy.figures.figureset import pictures_of
from fuzzy.figures.rulematrix import matrix_inputs, plot_rule_matrix


def system(*rules: str) -> fuzzy.Sugeno:
    """Terms are written from the last place to the first."""
    terms = {"far": fuzzy.trimf(1, 2, 2), "near": fuzzy.trimf(0, 0, 1.5)}
    inputs = [fuzzy.Variable(name, (0, 2), terms) for name in ("d", "a", "b")]
    return fuzzy.Sugeno(inputs, [fuzzy.Variable("v", (0, 1), {"slow": 0.0, "fast": 1.0})], rules, name="small")


RULES = (
    "if d is near and a is near then v is slow",
    "if a is far and d is near then v is fast",
    "if d is far and a is far then v is fast",
    "if d is far and a is far then v is slow",
    "if d is far then v is fast",
)


def test_a_cell_has_what_the_rules_of_its_terms_say() -> None:
    fis = system(*RULES)
    assert matrix_inputs(fis) == (0, 1)
    (ax,) = plot_rule_matrix(fis).axes
    assert [label.get_text() for label in ax.get_yticklabels()] == ["near", "far"]  # by their places
    assert [label.get_text() for label in ax.get_xticklabels()] == ["near", "far"]
    assert (ax.get_ylabel(), ax.get_xlabel()) == ("d", "a")
    cells = {(text.get_position()[1] - 0.5, text.get_position()[0] - 0.5): text.get_text() for text in ax.texts}
    assert cells == {(0, 0): "slow", (0, 1): "fast", (1, 0): "", (1, 1): "fast, slow"}
    (mesh,) = ax.findobj(QuadMesh)
    assert np.ma.filled(mesh.get_array(), -1).ravel().tolist() == [0.0, 1.0, -1.0, 0.5]


def test_rules_of_other_forms_have_no_cell() -> None:
    others = system("if d is near or a is near then v is slow", "if d is not near and a is far then v is fast",
                    "if d is near and a is far and b is far then v is fast")  # fmt: skip
    assert matrix_inputs(others) is None
    with pytest.raises(fuzzy.FuzzySystemError, match="just two inputs"):
        plot_rule_matrix(others)


def test_a_set_has_a_matrix_where_most_rules_have_a_cell() -> None:
    fis = system(*RULES)
    (matrix,) = [picture for picture in pictures_of(fis, (1, 1, 1)) if picture.kind == "matrix"]
    assert matrix.caption == "Rule matrix: v by the terms of d and a. 1 of 5 rules have no cell."
    assert matrix.stem.endswith("-rule-matrix-v")
    fewer = replace(fis, rules=(*fis.rules, *[fis.rules[-1]] * 4))
    assert not [picture for picture in pictures_of(fewer, (1, 1, 1)) if picture.kind == "matrix"]
