"""Systems without hedges answer the same, and what is not exact is refused."""

import numpy as np
import pytest

import fuzzy

X = np.linspace(-12, 12, 401)[:, None]


def system(function, *clauses):
    x = fuzzy.Variable("x", (-12, 12), {"a": function, "very_a": fuzzy.trimf(0, 1, 2)})
    rules = [f"if x is {clause} then y is z" for clause in clauses]
    return fuzzy.Sugeno([x], [fuzzy.Variable("y", (0, 1), {"z": 1.0})], rules, defuzzification="wtsum")


@pytest.mark.parametrize(
    ("function", "hedges"),
    [
        (fuzzy.gaussmf(2, 1), ("very", "somewhat", "not extremely", "a^1.3")),
        (fuzzy.gauss2mf(2, -1, -3, 4), ("very", "not somewhat")),
        (fuzzy.sigmf(-1.5, 2), ("very", "not very")),
    ],
)
def test_a_system_without_hedges_answers_the_same(function, hedges):
    fis = system(function, "a", *(hedge if "^" in hedge else f"{hedge} a" for hedge in hedges))
    plain = fuzzy.without_hedges(fis)
    assert all(clause.power == 1 for rule in plain.rules for clause in rule.when)
    np.testing.assert_allclose(plain(X), fis(X), rtol=1e-13)
    assert fuzzy.parse_fis(fuzzy.format_fis(plain)) == plain


def test_a_term_is_made_once_and_takes_no_name_that_is_taken():
    plain = fuzzy.without_hedges(system(fuzzy.gaussmf(2, 1), "very a", "not very a", "a^0.7"))
    assert list(plain.inputs[0].terms) == ["a", "very_a", "very_a_2", "a_0.7"]
    assert fuzzy.without_hedges(plain) == plain


def test_what_no_function_is_exactly_is_named():
    with pytest.raises(fuzzy.FuzzySystemError, match=r"that of 'x is very a' \(gbellmf\) and 'x is a\^1.3' \(gbel"):
        fuzzy.without_hedges(system(fuzzy.gbellmf(2, 1, 0), "very a", "a^1.3", "not a", "very a"))
    with pytest.raises(fuzzy.FuzzySystemError, match=r"'x is extremely a' \(sigmf\)"):
        fuzzy.without_hedges(system(fuzzy.sigmf(2, 1), "extremely a"))
