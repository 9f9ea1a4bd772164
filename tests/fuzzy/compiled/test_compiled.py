"""The compiled inference gives the numbers, warnings and errors of :func:`fuzzy.inference.infer`."""

import os
import pickle
import subprocess
import sys
from dataclasses import FrozenInstanceError, replace

import numpy as np
import pytest
import torch
from hypothesis import given, settings
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays
from numba import njit

from fuzzy.compiled.degrees import exp_nonpositive, log1p_unit
from fuzzy.compiled.kernel import FEW_POINTS, LANES
from fuzzy.compiled.packed import (
    PackedColumns,
    evaluate_packed,
    packed_work,
)
from fuzzy.compiled.sugeno import BLOCK, MANY, CompiledSugeno, compile_sugeno
from fuzzy.compiled.tables import NUMBERS
from fuzzy.inference import InferenceWarning, forgiving, infer
from fuzzy.membership import FUNCTIONS, Gaussian, LinearS, LinearZ, Triangle
from fuzzy.rule import Clause, Rule
from fuzzy.system import Constant, FuzzySystemError, Linear, Sugeno, Variable
from tests.fuzzy.random_systems import PARAMETERS, POSITIVE, conditioning, systems, systems_with_points
from tests.randomcases import cases

quiet = pytest.mark.filterwarnings("ignore::fuzzy.inference.InferenceWarning")
law = settings(max_examples=cases(150))


@njit
def exponential(values: np.ndarray) -> np.ndarray:
    result = np.empty(len(values))
    for k in range(len(values)):
        result[k] = exp_nonpositive(values[k])
    return result


def test_exponential_is_numpys_within_one_unit_in_the_last_place():
    rng = np.random.default_rng(0)
    values = np.concatenate(
        [
            -np.linspace(0, 760, 200_001),  # down to the subnormal numbers and to 0
            -rng.uniform(0, 1, 50_000),
            -(10.0 ** rng.uniform(-320, 3, 50_000)),
            -np.log(2) / 2 * np.arange(2200),  # where the reduction changes its integer
            [0.0, -0.0, -5e-324, -745.13, -745.14, -746.0, -1e300, -np.inf],
        ]
    )
    expected = np.exp(values)
    assert (np.abs(exponential(values) - expected) <= np.spacing(expected)).all()
    assert exponential(np.array([0.0, -np.inf, -800.0])).tolist() == [1, 0, 0]
    assert np.isnan(exponential(np.array([np.nan, -1.0]))).tolist() == [True, False]


@pytest.mark.parametrize("count", [1, 2, 7, 8, 9, 31, 33])
def test_exponential_of_a_number_does_not_depend_on_its_place(count):
    values = -np.random.default_rng(1).uniform(0, 700, 33)
    np.testing.assert_array_equal(exponential(values)[:count], exponential(values[:count]))


@given(st.floats(0, 1))
def test_logarithm_of_one_plus_a_unit_number(u):
    np.testing.assert_allclose(log1p_unit(u), np.log1p(u), rtol=5e-16, atol=5e-324)


def assert_same(fis: Sugeno, got: np.ndarray, x: np.ndarray) -> None:
    """``got`` is infer's output, up to the rounding of exponentials and, with it, of sums."""
    expected = infer(fis, x)
    assert got.shape == expected.output.shape
    kinds = [type(f) for v in fis.inputs for f in v.terms.values()]
    negated = any(c.negated for rule in fis.rules for c in rule.when)
    steady = all(kind in POSITIVE for kind in kinds) and not negated and fis.and_method == "prod"
    slack = np.ones(got.shape) if steady else conditioning(fis, expected.firing) * np.ones(got.shape)
    slack = slack * magnified(fis, expected.memberships)[..., None]
    sure = np.isfinite(slack)
    scale = 50 * np.where(sure, np.maximum(slack, 1), 1)  # consequents reach some 6 · (4.5 · 3 + 1)
    np.testing.assert_array_equal(np.isnan(got)[sure], np.isnan(expected.output)[sure])
    difference = np.abs(got - expected.output)[sure & ~np.isnan(got)]
    assert (difference <= 1e-14 * scale[sure & ~np.isnan(got)]).all(), difference.max()


def magnified(fis: Sugeno, memberships: tuple[np.ndarray, ...]) -> np.ndarray:
    """By how much hedges magnify a rounding error in a degree: the root of a small one has fewer true digits."""
    worst = np.ones(memberships[0].shape[:-1])
    names = [v.name for v in fis.inputs]
    for clause in (c for rule in fis.rules for c in rule.when if c.power < 1):
        place = names.index(clause.variable)
        degree = memberships[place][..., list(fis.inputs[place].terms).index(clause.term)]
        degree = 1 - degree if clause.negated else degree
        worst = np.maximum(worst, np.clip(degree, 1e-16, 1) ** (clause.power - 1))
    return worst


@quiet
@law
@given(systems_with_points())
def test_compiled_equals_infer(drawn):
    fis, x = drawn
    assert_same(fis, compile_sugeno(fis)(x), x)
    rows = x.reshape(-1, x.shape[-1])
    assert_same(forgiving(fis), compile_sugeno(fis).quietly(rows), rows)


@quiet
@law
@given(systems_with_points(kinds=POSITIVE, plain=True))
def test_compiled_equals_infer_where_strengths_are_logarithms(drawn):
    fis, x = drawn
    compiled = compile_sugeno(fis)
    assert PackedColumns(compiled.system).logs
    assert_same(fis, compiled(x), x)


# Up to where products overflow: 1.7e308 times a slope is not compared.
EXTREMES = [0.3, 1e10, -1e10, 1e153, 1e154, -1e155, 1e200, -1e300, np.inf, -np.inf, np.nan]


def largest_products(variable, x):
    """The largest sum of |slope x| (points,) of an output's linear consequents; 0 without one."""
    slopes = [np.abs(term.slopes) for term in variable.terms.values() if isinstance(term, Linear)]
    sums = [np.where(slope > 0, slope * np.abs(x), 0).sum(axis=-1) for slope in slopes]
    return np.max([np.zeros(len(x)), *sums], axis=0)


@quiet
@pytest.mark.filterwarnings("ignore::RuntimeWarning")
@pytest.mark.parametrize("kinds", [FUNCTIONS, POSITIVE])
@settings(max_examples=cases(100))
@given(st.data())
def test_extreme_numbers_give_the_same_with_numpy_torch_and_compiled(kinds, data):
    """A NaN degree was "no rule fires" for one and unknown for the other; so were strengths below e^(-1e294)."""
    fis = data.draw(systems(kinds=kinds, plain=kinds is POSITIVE))
    fis = replace(fis, no_rule_fires="midrange")  # else NaN would be the answer to both
    x = data.draw(arrays(np.float64, (6, len(fis.inputs)), elements=st.sampled_from(EXTREMES)))
    expected = infer(fis, x)
    sure = np.isfinite(conditioning(fis, expected.firing) + 0 * expected.output) | ~np.isfinite(expected.output)
    sure |= (expected.firing == 0).all(axis=-1)[:, None]
    # Where the products of slopes cancel, what is left is their rounding, which depends on the order of the sums.
    size = np.stack([largest_products(variable, x) for variable in fis.outputs], axis=-1)
    sure &= ~(np.isfinite(size) & (np.abs(expected.output) < 1e-9 * size))
    others = {"compiled": compile_sugeno(fis)(x), "torch": infer(fis, torch.tensor(x)).output.numpy()}
    for name, got in others.items():
        np.testing.assert_allclose(got[sure], expected.output[sure], rtol=1e-6, atol=1e-6, err_msg=name)


@quiet
@pytest.mark.parametrize("kind", FUNCTIONS, ids=lambda kind: kind.__name__)
@settings(max_examples=cases(50))
@given(data=st.data())
def test_every_function_on_its_own(kind, data):
    function = kind(*data.draw(PARAMETERS[kind]))
    x = np.array([[-3.5], *([p] for p in function.parameters), *np.linspace(-3, 4.5, 61)[:, None]])
    # As a weighted sum of the constant 1, the output is the degree; with a second input, not from logarithms.
    term = Variable("x", (-4, 5), {"t": function})
    y = Variable("y", (0, 1), {"one": 1.0})
    rules = (Rule((Clause("x", "t"),), (("y", "one"),)),)
    fis = Sugeno((term,), (y,), rules, defuzzification="wtsum", no_rule_fires="nan")
    fired = infer(replace(fis, out_of_range="ignore"), x).fired
    for other in ({}, {"z": LinearS(0, 1)}):
        variable = Variable("x", (-4, 5), {"t": function, **other})
        got = compile_sugeno(replace(fis, inputs=(variable,), out_of_range="ignore"))(x)
        np.testing.assert_allclose(got[fired], function(x)[fired], rtol=1e-13, atol=1e-15)


def example(rules: int = 8, inputs: int = 3, **choices) -> Sugeno:
    rng = np.random.default_rng(7)
    variables = [
        Variable(f"x{i}", (-1, 1), {f"t{r}": Gaussian(*rng.uniform(0.3, 0.8, 2)) for r in range(rules)})
        for i in range(inputs)
    ]
    y = Variable("y", (-9, 9), {f"t{r}": Linear(tuple(rng.normal(size=inputs)), rng.normal()) for r in range(rules)})
    sentences = [Rule(tuple(Clause(v.name, f"t{r}") for v in variables), (("y", f"t{r}"),)) for r in range(rules)]
    return Sugeno(variables, (y,), sentences, **choices)


@pytest.mark.parametrize(
    "rows", [0, 1, int(FEW_POINTS) - 1, int(FEW_POINTS), LANES - 1, LANES, LANES + 1, 2 * LANES + 9]
)
@pytest.mark.parametrize("choices", [{}, {"and_method": "min"}])
def test_a_point_has_the_same_bits_in_every_batch(rows, choices):
    fis = example(**choices)
    compiled = compile_sugeno(fis)
    x = np.random.default_rng(rows).uniform(-1, 1, (rows, 3))
    batch = compiled(x)
    assert batch.shape == (rows, 1)
    np.testing.assert_array_equal(batch, np.array([compiled(point) for point in x]).reshape(rows, 1))
    np.testing.assert_array_equal(batch[::-1], compiled(x[::-1]))
    np.testing.assert_allclose(batch, infer(fis, x).output, rtol=1e-12, atol=1e-13)


def test_the_bits_of_very_many_points_do_not_depend_on_the_processors(monkeypatch):
    compiled = compile_sugeno(example())
    x = np.random.default_rng(0).uniform(-1, 1, (MANY + 77, 3))
    x[BLOCK + 5, 1] = np.nan
    results = []
    for count in (1, 2, 5):
        monkeypatch.setattr("fuzzy.compiled.threads.processors", lambda count=count: count)
        results.append(compiled(x))
    np.testing.assert_array_equal(results[0], np.concatenate([compiled(x[:BLOCK]), compiled(x[BLOCK:])]))
    for other in results[1:]:
        np.testing.assert_array_equal(other, results[0])


def test_a_warning_comes_from_any_block_of_very_many_points():
    x = np.full((MANY + 9, 2), [7.0, 0.5])
    x[BLOCK + 3, 0] = 11.0
    with pytest.warns(InferenceWarning) as caught:
        compile_sugeno(GAP)(x)
    assert len(caught) == 2
    assert "input a outside [0 10]" in str(caught[0].message)
    assert "no rule fires for output y, z" in str(caught[1].message)


@pytest.mark.parametrize("kind", [list, tuple, np.array, torch.tensor])
def test_one_point_of_any_kind_is_an_array_of_its_own(kind):
    compiled = compile_sugeno(example())
    first, second = compiled(kind([0.125, 0.25, 0.5])), compiled(kind([0.125, 0.25, 0.75]))
    np.testing.assert_array_equal(np.array([first, second]), compiled([[0.125, 0.25, 0.5], [0.125, 0.25, 0.75]]))
    assert first.flags.owndata
    assert first.shape == (1,)


@pytest.mark.parametrize("wrong", [[[0.1], [0.2], [0.3]], [np.zeros(3)] * 3 + [[1.0]], ["a", 0.2, 0.3], [0.1, 0.2, 1j]])
def test_a_list_that_is_no_point_is_what_numpy_makes_of_it(wrong):
    compiled = compile_sugeno(example())
    with pytest.raises((FuzzySystemError, TypeError, ValueError)) as by_infer:
        infer(compiled.fis, np.asarray(wrong, dtype=np.float64))
    with pytest.raises(by_infer.type) as by_compiled:
        compiled(wrong)
    assert str(by_compiled.value) == str(by_infer.value)


def test_a_column_of_one_input_is_no_point():
    x = Variable("x", (0, 1), {"low": LinearZ(0, 1), "high": LinearS(0, 1)})
    fis = Sugeno((x,), (Variable("y", (0, 5), {"a": 1, "b": 5}),), ["x is low => y = a", "x is high => y = b"])
    compiled = compile_sugeno(fis)
    assert compiled([[0.25]]).tolist() == [[2.0]]
    assert compiled([0.25]).tolist() == [2.0]
    assert compiled([[0.25], [0.75]]).tolist() == [[2.0], [4.0]]


@quiet
@law
@given(systems_with_points(shape=(11,)))
def test_a_point_has_the_same_bits_for_other_compiled_functions(drawn):
    fis, x = drawn
    compiled = compile_sugeno(fis)
    output, work = np.empty((len(x), len(fis.outputs))), np.empty(packed_work(compiled.system))
    for point, values in zip(x, output, strict=True):
        evaluate_packed(compiled.system, point, values, work)
    np.testing.assert_array_equal(output, compiled(x))


@njit
def total_by_point(system, x):
    work, output, total = np.empty(packed_work(system)), np.empty(1), 0.0
    for k in range(len(x)):
        evaluate_packed(system, x[k], output, work)
        total += output[0]
    return total


def test_the_point_function_serves_other_compiled_functions():
    fis = example()
    x = np.random.default_rng(0).uniform(-1, 1, (100, 3))
    assert total_by_point(compile_sugeno(fis).system, x) == pytest.approx(infer(fis, x).output.sum(), rel=1e-12)


@given(arrays(np.float64, (5, 3), elements=st.floats(-1, 1) | st.just(np.nan)))
def test_not_a_number_stays_in_its_point(x):
    fis = example()
    output = compile_sugeno(fis)(x)
    np.testing.assert_array_equal(np.isnan(output[:, 0]), np.isnan(x).any(axis=-1))
    np.testing.assert_allclose(output, infer(fis, x).output, rtol=1e-12, atol=1e-13)


def test_thirty_dimensions_do_not_underflow():
    centers = np.array([[9.01] * 30, [-9.0] * 30])
    inputs = [
        Variable(f"x{i}", (-9, 9), {"a": Gaussian(1, a), "b": Gaussian(1, b)}) for i, (a, b) in enumerate(centers.T)
    ]
    y = Variable("y", (0, 9), {"a": 2.0, "b": 5.0})
    rules = [Rule(tuple(Clause(v.name, t) for v in inputs), (("y", t),)) for t in "ab"]
    weight = 1 / (1 + np.exp(15 * (9.01**2 - 9.0**2)))
    fis = Sugeno(inputs, (y,), rules)
    assert compile_sugeno(fis)(np.zeros(30))[0] == pytest.approx(2 * weight + 5 * (1 - weight), rel=1e-11)
    only_a = replace(fis, rules=(rules[0], replace(rules[1], weight=0.0)))
    assert compile_sugeno(only_a)(np.full(30, -9.0)).tolist() == [2]


def test_a_rule_without_weight_near_the_point_does_not_drown_the_others():
    # Its strength is e^0 to e^1000 times the other's: beyond every number if it were asked for.
    terms = {"here": Gaussian(1, 0), "there": Gaussian(1, -100)}
    y = Variable("y", (0, 9), {"a": 2.0, "b": 5.0})
    rules = (Rule((Clause("x", "here"),), (("y", "a"),), weight=0.0), Rule((Clause("x", "there"),), (("y", "b"),)))
    fis = Sugeno((Variable("x", (-100, 100), terms),), (y,), rules)
    x = np.linspace(-50, -40, 4001)[:, None]
    assert (compile_sugeno(fis)(x) == 5).all()
    assert (infer(fis, x).output == 5).all()


GAP = Sugeno(
    (Variable("a", (0, 10), {"left": Triangle(0, 1, 2), "right": Triangle(6, 7, 8)}), Variable("b", (0, 1))),
    (Variable("y", (-10, 30), {"none": 0, "ten": 10}), Variable("z", (0, 1), {"one": 1})),
    (
        Rule((Clause("a", "left"),), (("y", "none"),)),
        Rule((Clause("a", "right"),), (("y", "ten"), ("z", "one"))),
    ),
    name="gap",
)


def messages(call, x) -> list[str]:
    with pytest.warns(InferenceWarning) as caught:
        call(x)
    assert {w.filename for w in caught} == {__file__}
    return [str(w.message) for w in caught]


@pytest.mark.parametrize(
    "x", [[[4.0, 0.5], [5.0, 0.5], [7.0, 0.5]], [[1.0, 0.5]], [[7.0, 2.0]], [[-1.0, 0.2], [7.0, -0.1]], [11.0, 2.0]]
)
@pytest.mark.parametrize("choice", ["midrange", "nan"])
def test_warnings_are_those_of_infer(x, choice):
    fis = replace(GAP, no_rule_fires=choice)
    compiled = compile_sugeno(fis)
    assert messages(compiled, x) == messages(lambda x: infer(fis, x), x)
    ignoring = compile_sugeno(replace(fis, out_of_range="ignore"))
    quietly = pytest.warns(InferenceWarning) if np.ravel(x)[0] != 7 else pytest.MonkeyPatch.context()
    with quietly:
        got = ignoring(x)
    with pytest.warns(InferenceWarning):
        np.testing.assert_array_equal(got, infer(fis, x).output)


def test_errors_are_those_of_infer():
    for fis, x in [
        (replace(GAP, no_rule_fires="error"), [4.0, 0.5]),
        (replace(GAP, out_of_range="error"), [[7.0, 0.5], [-1.0, 2.0]]),
        (GAP, [1.0]),
        (GAP, 1.0),
    ]:
        with pytest.raises(FuzzySystemError) as by_infer:
            infer(fis, x)
        with pytest.raises(FuzzySystemError) as by_compiled:
            compile_sugeno(fis)(x)
        assert str(by_compiled.value) == str(by_infer.value)


def test_clipping():
    fis = Sugeno(
        (Variable("a", (0, 10), {"low": LinearZ(0, 10), "high": LinearS(0, 10)}),),
        (Variable("y", (0, 1), {"line": Linear((2,), 1), "zero": 0}),),
        (Rule((Clause("a", "low"),), (("y", "line"),)), Rule((Clause("a", "high"),), (("y", "zero"),))),
        out_of_range="clip",
    )
    compiled = compile_sugeno(fis)
    assert compiled([[-4.0], [0.0], [5.0], [12.0]])[:, 0].tolist() == [1, 1, 5.5, 0]
    output = np.empty(1)
    evaluate_packed(compiled.system, np.array([-4.0]), output, np.empty(packed_work(compiled.system)))
    assert output.tolist() == [1]


@pytest.mark.parametrize("shape", [(), (5,), (2, 3, 4), (2, 0)])
def test_leading_shapes_and_kinds_of_arrays(shape):
    fis = example()
    compiled = compile_sugeno(fis)
    x = np.random.default_rng(0).uniform(-1, 1, (*shape, 3))
    expected = compiled(x)
    assert expected.shape == (*shape, 1)
    assert expected.dtype == np.float64
    frozen = x.copy()
    frozen.flags.writeable = False
    strided = np.repeat(x, 2, axis=-1)[..., ::2]
    for same in (frozen, strided, np.asfortranarray(x), x.astype(">f8"), torch.tensor(x)):
        np.testing.assert_array_equal(compiled(same), expected)
    if shape:
        np.testing.assert_array_equal(compiled(x.tolist()) if x.size else expected, expected)
    assert compiled(np.zeros(3, dtype=np.float32)).dtype == np.float64


def test_parameters_in_training_are_read_once():
    def trainable(value):
        return torch.tensor(value, dtype=torch.float64, requires_grad=True)

    slopes = torch.tensor([2.0, -1.0], dtype=torch.float64, requires_grad=True)
    inputs = [
        Variable(name, (-2, 2), {"t": Gaussian(trainable(0.7), trainable(c))}) for name, c in (("a", 0.5), ("b", -0.25))
    ]
    y = Variable("y", (0, 1), {"line": Linear(slopes, trainable(0.5)), "one": Constant(trainable(1.0))})
    rules = (Rule((Clause("a", "t"),), (("y", "line"),)), Rule((Clause("b", "t"),), (("y", "one"),)))
    fis = Sugeno(inputs, (y,), rules)
    x = np.array([[0.1, 0.3], [1.0, -1.0]])
    expected = infer(fis, torch.tensor(x)).output.detach().numpy()
    np.testing.assert_allclose(compile_sugeno(fis)(x), expected, rtol=1e-13)


def test_compiled_systems_are_values():
    compiled = compile_sugeno(example())
    x = [0.1, 0.2, 0.3]
    assert pickle.loads(pickle.dumps(compiled))(x) == compiled(x)
    with pytest.raises(FrozenInstanceError):
        compiled.system = None  # type: ignore[misc]


WITHOUT_NUMBA = """
import sys, pickle, warnings
from numba import config
assert config.DISABLE_JIT
systems = pickle.load(sys.stdin.buffer)
warnings.simplefilter("ignore", category=UserWarning)
warnings.simplefilter("error", category=RuntimeWarning)
pickle.dump([compiled(x) for compiled, x in systems], sys.stdout.buffer)
"""


def interpreted(systems: list[tuple[CompiledSugeno, np.ndarray]]) -> list[np.ndarray]:
    """The outputs of each system at its points in a process where Python runs the kernel, not machine code."""
    environment = {**os.environ, "NUMBA_DISABLE_JIT": "1"}
    run = subprocess.run(
        [sys.executable, "-c", WITHOUT_NUMBA], input=pickle.dumps(systems), capture_output=True, env=environment
    )
    assert run.returncode == 0, run.stderr.decode()
    return pickle.loads(run.stdout)


@quiet
def test_without_numba_the_same_code_gives_the_same_numbers():
    systems = []

    @settings(max_examples=cases(60), database=None, derandomize=True)
    @given(systems_with_points(shape=(4,)))
    def collect(drawn):
        systems.append(drawn)

    collect()
    systems += [(example(), np.random.default_rng(0).uniform(-1, 1, (5, 3)))]
    systems += [(GAP, np.array([[4.0, 0.5], [np.nan, 0.5], [7.0, 2.0]]))]
    pairs = [(compile_sugeno(fis), x) for fis, x in systems]
    for (compiled, x), plain in zip(pairs, interpreted(pairs), strict=True):
        np.testing.assert_allclose(plain, compiled(x), rtol=1e-14)


def test_an_unknown_number_gives_not_a_number_and_never_another_function():
    # A sum of logarithms, a product, a minimum (which would lose a not-a-number), and points where no rule fires.
    systems = [example(), replace(GAP, out_of_range="ignore"), replace(GAP, and_method="min", out_of_range="ignore")]
    systems += [replace(fis, rules=[replace(rule, connective="or") for rule in fis.rules]) for fis in systems]
    pairs = []
    for fis in systems:
        compiled = compile_sugeno(fis)
        for number in (-1, len(NUMBERS), 99):
            for unknown in (slice(None), slice(1)):  # every term, and only those of the first input
                system = compiled.system.copy()
                header = PackedColumns(system)
                first = int(header.segment_kind)
                system[first : first + int(header.segments)][unknown] = number
                wrong = replace(compiled, system=system)
                pairs.append((wrong, np.random.default_rng(0).uniform(0, 1, (3, len(fis.inputs)))))
    assert len({PackedColumns(compiled.system).logs for compiled, _ in pairs}) == 2
    for (compiled, x), plain in zip(pairs, interpreted(pairs), strict=True):
        assert np.isnan(compiled(x)).all()
        assert np.isnan(plain).all()


def test_the_kernel_has_a_branch_for_every_function_of_matlab():
    assert set(NUMBERS) == set(FUNCTIONS)
    assert sorted(NUMBERS.values()) == list(range(len(FUNCTIONS)))


def test_importing_the_package_does_not_import_numba():
    code = "import sys, fuzzy, fuzzy.system, fuzzy.inference; sys.exit('numba' in sys.modules)"
    assert subprocess.run([sys.executable, "-c", code]).returncode == 0
