"""Trees and type-2 systems at one point in compiled code: the bits of the whole, which has its own tests."""

import numpy as np
import pytest

import fuzzy
from fuzzy.compiled.composite import evaluate_composite
from fuzzy.compiled.jit import kernel
from fuzzy.compiled.packed import NO_RULE, OUTSIDE, packed_work
from tests.fuzzy.plugins.trees.randomtrees import random_tree
from tests.fuzzy.plugins.type2.drawn import drawn

silent_places = pytest.mark.filterwarnings("ignore::fuzzy.inference.InferenceWarning")


@kernel
def at(row, x, output, work):
    return evaluate_composite(row, x, output, work)


def answers(row, x, outputs):
    """What the row answers at each of ``x`` (points, inputs), and what it tells."""
    work, y = np.full(packed_work(row), np.nan), np.empty((len(x), outputs))
    return y, [at(row, point, value, work) for point, value in zip(x, y, strict=True)]


@silent_places
def test_points_are_answered_as_by_what_is_compiled():
    for seed in range(12):
        rng = np.random.default_rng(seed)
        for compiled, outputs, inputs in (
            (fuzzy.compile_tree(tree := random_tree(seed)), len(tree.outputs), len(tree.inputs)),
            (fuzzy.compile_type2(drawn(rng)), 1, 2),
        ):
            x = rng.uniform(-1.5, 1.5, (20, inputs))
            found, _ = answers(compiled.row, x, outputs)
            assert np.array_equal(found, compiled(x), equal_nan=True), seed


def test_it_tells_what_is_outside_and_where_no_rule_fires():
    a = fuzzy.Variable("a", (0, 1), {"one": fuzzy.Triangle(0.4, 0.5, 0.6)})
    fis = fuzzy.Sugeno([a], [fuzzy.Variable("b", (0, 1), {"c": 0.5})], ["if a is one then b is c"])
    last = fuzzy.Sugeno(
        [fuzzy.Variable("b", (0, 1), {"d": fuzzy.LinearS(0, 1)})],
        [fuzzy.Variable("e", (0, 1), {"f": 0.25})],
        ["if b is d then e is f"],
    )
    x = np.array([[0.5], [0.1], [1.1], [-0.1]])
    told = [0, NO_RULE, NO_RULE + OUTSIDE, NO_RULE + OUTSIDE]
    for compiled in (fuzzy.compile_type2(fuzzy.to_type2(fis)), fuzzy.compile_tree(fuzzy.Tree({"x": fis, "y": last}))):
        assert answers(compiled.row, x, 1)[1] == told
    clipped = fuzzy.Sugeno(fis.inputs, fis.outputs, fis.rules, out_of_range="clip")
    assert answers(fuzzy.compile_type2(fuzzy.to_type2(clipped)).row, x, 1)[1] == [0, *[NO_RULE] * 3]
