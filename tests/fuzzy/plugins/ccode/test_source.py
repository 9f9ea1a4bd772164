"""Systems in C against the inference: every function, hedge, method and number type."""

import re
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import Phase, given, settings
from hypothesis import strategies as st

from fuzzy import membership as mf
from fuzzy.files.fisfile import read_mamdani
from fuzzy.plugins.ccode.identifier import comment, identifier
from fuzzy.plugins.ccode.numbertype import ExportError
from fuzzy.plugins.ccode.proofpoints import answers_of, proof_points
from fuzzy.plugins.ccode.source import c_sources
from fuzzy.system import Constant, Linear, Sugeno, Variable
from tests.fuzzy.plugins.ccode.inc import CORPUS, PACKAGED, Library, needs_compiler, wanted
from tests.fuzzy.random_systems import systems

LIMIT = {"double": 4e-15, "float": 1e-6, "q16.16": 4e-4}  # of the span, or of what the rules propose and cancel


def lost(fis, x, strengths, number):
    """Where what fires is less than the type of numbers tells from nothing, (n, outputs)."""
    least = {"double": 1e-300, "float": 1e-17, "q16.16": 1e-5}[number]
    if cancels(fis) and number != "q16.16":  # differences are as fine as the type's numbers beside 1
        least = {"double": 1e-14, "float": 1e-5}[number]
    least = np.sqrt(least) if roots(fis) else least
    nothing = strengths == 0
    beside = x[:, None] + np.vstack([np.eye(x.shape[1]), -np.eye(x.shape[1])]) / 2**16
    with np.errstate(invalid="ignore"):
        fires_beside = wanted(fis, beside.reshape(-1, x.shape[1]))[2].reshape(len(x), -1, strengths.shape[1])
    # At the foot of a function the last digit decides
    return (strengths < least) & ~nothing | nothing & (fires_beside > 0).any(axis=1)


def differences(fis):
    return {(v.name, label) for v in fis.inputs for label, t in v.terms.items() if isinstance(t, mf.SigmoidDifference)}


def cancels(fis):
    return fis.structure.negated.any() or bool(differences(fis))


def roots(fis):
    """Whether a root is taken of a difference, whose last digit then counts much."""
    return any((c.variable, c.term) in differences(fis) and c.power < 1 for rule in fis.rules for c in rule.when)


def last_digits(fis, x, number):
    """How much the answers change with the last digits of the inputs where roots are taken, (n, outputs).

    The root of what is nearly nothing, at the foot of a function, makes much of a digit.
    """
    if not (fis.structure.power < 1).any():
        return np.zeros((len(x), len(fis.outputs)))
    kind = {"double": np.float64, "float": np.float32}
    step = 2.0**-16 if number == "q16.16" else 4 * np.spacing(np.abs(x).astype(kind[number])).astype(float)
    moved = [x + sign * step * axis for axis in np.eye(x.shape[1]) for sign in (-1, 1)]
    with np.errstate(invalid="ignore"):
        changes = [np.abs(wanted(fis, each)[0] - wanted(fis, x)[0]) for each in moved]
    return np.nan_to_num(np.max(changes, axis=0), posinf=0.0)


def check(library, k, x):
    fis, number = library.systems[k], library.number
    x, y, told = library.answers(k, x)
    expected, proposed, strengths = wanted(fis, x)
    if number == "q16.16":
        expected = np.clip(expected, -32768, 32768)
    free = lost(fis, x, strengths, number)
    finite = np.isfinite(x).all(axis=1)
    # Beyond all numbers, a rule that does not fire and proposes infinity is no answer to compare with
    free[~finite] |= ~np.isfinite(expected[~finite]) if number != "q16.16" else True
    if number != "q16.16":  # which has no not-a-number
        np.testing.assert_array_equal(np.isnan(y) & ~free, np.isnan(expected) & ~free)
        low, high = np.array([v.universe for v in fis.inputs]).T
        outside = ((x < low) | (x > high)).any(axis=1) & (fis.out_of_range != "clip")
        np.testing.assert_array_equal(told[finite] & 1, outside[finite].astype(int))
    span = np.array([max(v.universe[1] - v.universe[0], 1e-9) for v in fis.outputs])
    scale = np.maximum(span, np.ptp(np.nan_to_num(expected[finite]), axis=0))
    scale = np.maximum(scale, np.nan_to_num(proposed[finite]).max(axis=0))
    # Where only differences fire, their rounding is a larger share of what fires.
    fires = np.clip(strengths, 1e-30, 1) if cancels(fis) else 1.0
    limit = np.sqrt(LIMIT[number]) if roots(fis) else LIMIT[number]
    allowed = np.where(free | np.isnan(expected), np.inf, limit * scale / fires + last_digits(fis, x, number))
    with np.errstate(invalid="ignore"):
        error = np.nan_to_num(np.abs(y - expected))
        worst = np.unravel_index(np.argmax(error / allowed), error.shape)
    told_of = (x[worst[0]], y[worst], expected[worst], strengths[worst[0]], fis)
    assert (error <= allowed).all(), told_of


@needs_compiler
@pytest.mark.parametrize("number", LIMIT)
def test_files_of_strangers_and_packaged_rule_bases(number, tmp_path):
    library = Library([read_mamdani(file)[0] for file in (*CORPUS, *PACKAGED)], number, tmp_path)
    for k, fis in enumerate(library.systems):
        check(library, k, proof_points(fis, 300, 1))


@needs_compiler
def test_double_has_the_bits_of_the_compiled_inference_where_no_library_is_asked(tmp_path):
    files = [read_mamdani(file)[0] for file in (*CORPUS, *PACKAGED)]
    plain = [f for f in files if not any(t.log_formula for v in f.inputs for t in v.terms.values())]
    library = Library(plain, "double", tmp_path)
    for k, fis in enumerate(plain):
        x, y, _ = library.answers(k, proof_points(fis, 300, 2))
        np.testing.assert_array_equal(y, answers_of(fis, x), err_msg=fis.name)
    assert len(plain) > 8


@needs_compiler
@pytest.mark.parametrize("number", LIMIT)
@settings(max_examples=4, phases=(Phase.generate,))  # what fails says all there is to say
@given(some=st.lists(systems(), min_size=5, max_size=5), seed=st.integers(0, 99))
def test_random_systems(number, some, seed, tmp_path_factory):
    library = Library(some, number, tmp_path_factory.mktemp("c"))
    for k, fis in enumerate(some):
        check(library, k, proof_points(fis, 60, seed))


def grid(rules):
    """A system of many rules, every function, both connectives, hedges and weights."""
    rng = np.random.default_rng(3)
    functions = [
        *(mf.trimf(-1 + 0.3 * k, -0.7 + 0.3 * k, -0.4 + 0.3 * k) for k in range(4)),
        mf.gaussmf(0.2, 0.1), mf.gbellmf(0.3, 2, -0.4), mf.sigmf(5, 0.2), mf.smf(-0.5, 0.5), mf.zmf(-0.2, 0.8),
        mf.pimf(-1, -0.5, 0, 0.4), mf.dsigmf(6, -0.5, 6, 0.5), mf.psigmf(6, -0.5, -6, 0.5),
        mf.gauss2mf(0.1, -0.2, 0.2, 0.3), mf.linsmf(-1, 1), mf.linzmf(-1, 1), mf.trapmf(-1, -0.5, 0.5, 1),
    ]  # fmt: skip
    inputs = [Variable(n, (-1, 1), {f"t{k}": f for k, f in enumerate(functions)}) for n in ("a", "b", "c")]
    terms = {f"p{k}": Linear(rng.normal(size=3).tolist(), float(k)) if k % 2 else Constant(float(k)) for k in range(9)}
    hedges = ("", "very ", "somewhat ", "not ", "extremely ")
    sentences = [
        f"if a is {hedges[k % 5]}t{rng.integers(16)} {'or' if k % 3 == 0 else 'and'} b is t{rng.integers(16)} "
        f"then y is p{rng.integers(9)}" + (f" and z is p{rng.integers(9)}" * (k % 2)) + (" with 0.5" * (k % 4 == 0))
        for k in range(rules)
    ]
    return Sugeno(inputs, [Variable("y", (-9, 9), terms), Variable("z", (-9, 9), terms)], sentences)


@needs_compiler
@pytest.mark.parametrize("number", LIMIT)
def test_many_rules_are_tables_and_loops_with_the_same_answers(number, tmp_path):
    fis = grid(300)
    others = [replace(fis, and_method="min", or_method="max"), replace(fis, defuzzification="wtsum")]
    positive = replace(fis, rules=[f"if a is very t{4 + k % 2} and b is t6 then y is p{k % 9}" for k in range(60)])
    library = Library(
        [fis, *others, positive, replace(fis, out_of_range="clip", no_rule_fires="nan")], number, tmp_path
    )
    assert "rule_end" in library.sources[0].source
    for k, each in enumerate(library.systems if number != "q16.16" else library.systems[:4]):
        check(library, k, proof_points(each, 200, 2))


@needs_compiler
def test_not_a_number_stays_and_infinity_is_far_away(tmp_path):
    library = Library([read_mamdani(file)[0] for file in CORPUS], "double", tmp_path)
    for k, fis in enumerate(library.systems):
        x = np.tile([np.mean(v.universe) for v in fis.inputs], (4, 1))
        x[0, 0], x[1, -1], x[2, 0] = np.nan, np.inf, -np.inf
        _, y, _ = library.answers(k, x)
        expected = wanted(fis, x)[0]
        assert np.isnan(y[0]).all()
        np.testing.assert_allclose(y, expected, rtol=1e-12)


def test_fixed_point_has_no_floating_point_and_nothing_is_allocated():
    for number in LIMIT:
        for file in CORPUS:
            sources = c_sources(read_mamdani(file)[0], number=number)
            code = re.sub(r"/\*.*?\*/", "", sources.source, flags=re.DOTALL)
            assert "malloc" not in code
            if number == "q16.16":
                assert not re.search(r"\b(float|double|math\.h|\d+\.\d+)", code)
            for rule in read_mamdani(file)[0].rules:
                words = comment(str(rule)).split()
                assert words[0] == "if"
                assert " ".join(words) in re.sub(r"\s+(\* )?", " ", sources.source)


@given(st.lists(st.text(max_size=60), max_size=8))
def test_names_are_identifiers_and_differ(names):
    taken: list[str] = []
    for name in names:
        taken.append(identifier(name, taken))
        assert re.fullmatch(r"[A-Za-z][A-Za-z0-9_]*", taken[-1])
    assert len({*taken}) == len(taken)


@given(st.text())
def test_a_comment_does_not_end_early(text):
    assert "*/" not in comment(text)
    assert "\n" not in comment(text)


@needs_compiler
def test_names_that_c_has_already(tmp_path):
    terms = {"double": mf.trimf(0, 0, 1), "1": mf.trimf(0, 1, 1)}
    inputs = [Variable(name, (0, 1), terms) for name in ("int", "x", "w", "exp", "Ångström [Å]", "told")]
    rules = [
        "if int is double and x is '1' then y is a",
        "if w is '1' and exp is double and told is double then y is b",
    ]
    library = Library([Sugeno(inputs, [Variable("y", (0, 1), {"a": 0, "b": 1})], rules)], "double", tmp_path)
    check(library, 0, proof_points(library.systems[0], 50, 0))


def test_what_a_number_type_does_not_have_is_refused():
    wide = Sugeno(
        [Variable("pressure", (0, 101_325), {"low": mf.linzmf(0, 1e5)}, "Pa")],
        [Variable("y", (0, 1), {"a": 1})],
        ["if pressure is low then y is a"],
    )
    with pytest.raises(ExportError, match=r"pressure goes from 0 to 101325.*scale the variable"):
        c_sources(wide, number="q16.16")
    with pytest.raises(ExportError, match=r"did you mean.*double"):
        c_sources(wide, number="doubel")
    huge = Sugeno(wide.inputs, [Variable("y", (0, 1), {"a": 1e300})], wide.rules)
    with pytest.raises(ExportError, match="too large for a float"):
        c_sources(huge, number="float")
    c_sources(huge, number="double")
