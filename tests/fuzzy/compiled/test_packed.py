"""A system in one row of numbers gives, point by point, the bits of the compiled system."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

from fuzzy.compiled.packed import NO_RULE, OUTSIDE, PackedColumns, evaluate_packed, packed, packed_work
from fuzzy.compiled.sugeno import compile_sugeno
from fuzzy.membership import FUNCTIONS, LinearS, Trapezoid, Triangle
from fuzzy.rule import Clause, Rule
from fuzzy.system import Sugeno, Variable
from tests.fuzzy.random_systems import POSITIVE, systems, systems_with_points
from tests.randomcases import cases

LINES = (Triangle, Trapezoid)  # of which a rule leaves terms out
quiet = pytest.mark.filterwarnings("ignore::fuzzy.inference.InferenceWarning")


def by_point(fis: Sugeno, x: np.ndarray) -> np.ndarray:
    """The outputs (n, outputs) at the points (n, inputs)."""
    system, output = packed(fis), np.empty((len(x), len(fis.outputs)))
    work = np.full(packed_work(system), np.nan)
    for point, values in zip(x, output, strict=True):
        evaluate_packed(system, point, values, work)
    return output


@quiet
@settings(max_examples=cases(150))
@given(
    systems_with_points(shape=(5,))
    | systems_with_points(kinds=LINES, shape=(5,))
    | systems_with_points(kinds=POSITIVE, plain=True, shape=(5,))
)
def test_bits_are_those_of_the_compiled_system(drawn):
    fis, x = drawn
    np.testing.assert_array_equal(by_point(fis, x), compile_sugeno(fis)(x))


@quiet
@pytest.mark.parametrize("kinds", [FUNCTIONS, LINES, POSITIVE])
@settings(max_examples=cases(60))
@given(data=st.data())
def test_bits_are_the_same_for_extreme_numbers(kinds, data):
    fis = data.draw(systems(kinds=kinds, plain=kinds is POSITIVE))
    numbers = [0.3, 1e10, -1e155, 1e200, -1e300, np.inf, -np.inf, np.nan]
    x = data.draw(arrays(np.float64, (6, len(fis.inputs)), elements=st.sampled_from(numbers)))
    np.testing.assert_array_equal(by_point(fis, x), compile_sugeno(fis)(x))


@pytest.mark.parametrize("count", [52, 53])
def test_as_many_rules_as_bits_and_one_more(count):
    terms = {f"t{k}": Triangle(k - 1, k, k + 1) for k in range(count)}
    rules = [f"x is {'not ' * (k % 2)}t{k} => y = u{k}" for k in range(count)]
    fis = Sugeno(
        (Variable("x", (0, count - 1), terms),), (Variable("y", (0, 1), {f"u{k}": k for k in range(count)}),), rules
    )
    x = np.linspace(0, count - 1, 4 * count - 3)[:, None]
    np.testing.assert_array_equal(by_point(fis, x), compile_sugeno(fis)(x))
    assert (PackedColumns(packed(fis)).lined > 0) == (count == 52)


def test_sizes_stand_in_the_header_and_a_compiled_system_can_be_packed():
    x = Variable("x", (0, 1), {"low": Triangle(0, 0, 1), "high": LinearS(0, 1), "mid": Triangle(0, 0.5, 1)})
    fis = Sugeno((x,), (Variable("y", (0, 5), {"a": 1, "b": 5}),), ["x is low => y = a", "x is high => y = b"])
    system = packed(fis)
    header = PackedColumns(system)
    assert [header.inputs, header.outputs, header.terms, header.rules] == [1, 1, 3, 2]
    np.testing.assert_array_equal(packed(compile_sugeno(fis)), system)
    assert by_point(fis, np.array([[0.25]]))[0, 0] == pytest.approx(0.75 * 1 + 0.25 * 5)


def test_it_tells_of_a_point_outside_and_of_no_rule():
    x = Variable("x", (0, 10), {"left": Triangle(0, 1, 2), "right": Triangle(6, 7, 8)})
    outputs = [Variable("y", (-10, 30), {"ten": 10}), Variable("z", (0, 1), {"one": 1})]
    rules = [Rule((Clause("x", "left"),), (("y", "ten"),)), Rule((Clause("x", "right"),), (("y", "ten"), ("z", "one")))]
    system = packed(Sugeno((x,), outputs, rules))
    clipped = packed(Sugeno((x,), outputs, rules, out_of_range="clip"))
    work, output = np.empty(packed_work(system)), np.empty(2)
    cases = [(7.0, 0, [10, 1]), (1.0, NO_RULE, [10, 0.5]), (11.0, OUTSIDE + NO_RULE, [10, 0.5])]
    for point, told, expected in cases:
        assert evaluate_packed(system, np.array([point]), output, work) == told
        assert output.tolist() == expected
    assert evaluate_packed(clipped, np.array([11.0]), output, work) == NO_RULE
    assert evaluate_packed(system, np.array([np.nan]), output, work) == 0
    assert np.isnan(output).all()
