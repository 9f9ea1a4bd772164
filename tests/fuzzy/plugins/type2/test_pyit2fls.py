"""Interval type-2 systems against PyIT2FLS 0.9, whose answers stand in a file and are made anew where it is there.

Its EIASC ends where the average is within 1e-9 of a proposal, which in one of 180 answers is 1.6e-9 beside the end; the
definition, every choice of bounds, agrees with the answer here.
"""

import json
import warnings
from pathlib import Path

import numpy as np
import pytest

import fuzzy
from tests.fuzzy.plugins.type2.drawn import drawn
from tests.fuzzy.plugins.type2.test_reduction import by_every_choice

ANSWERS = Path(__file__).with_name("pyit2fls.json")  # a number for each of 60 systems, at 3 points each


def problems() -> list[tuple[fuzzy.Type2Sugeno, np.ndarray]]:
    """Systems, and points at which rules fire."""
    rng = np.random.default_rng(90)
    found: list[tuple[fuzzy.Type2Sugeno, np.ndarray]] = []
    while len(found) < 60:
        fis = drawn(rng)
        x = rng.uniform(0, 10, (300, 2))
        with warnings.catch_warnings(action="ignore"):
            x = x[(fuzzy.infer_type2(fis, x).lower > 0).any(axis=-1)]
        if len(x) > 2:
            found.append((fis, x[:3]))
    return found


def theirs(fis: fuzzy.Type2Sugeno, x: np.ndarray) -> list[float]:
    """PyIT2FLS's answers, of the same system in its own words."""
    import pyit2fls as it2

    system = it2.IT2TSK(it2.product_t_norm, it2.max_s_norm)
    sets = {}
    for variable in fis.inputs:
        system.add_input_variable(variable.name)
        for name, f in variable.terms.items():
            lower = fis.lower[variable.name][name]
            if isinstance(f, fuzzy.Gaussian):
                kind, upper = it2.gaussian_mf, [f.c, f.sigma, 1.0]
                below = [f.c, f.sigma, lower.scale]
            else:
                kind, upper = it2.tri_mf, [f.a, f.b, f.c, 1.0]
                left, right = lower.lag
                below = [f.a + left * (f.b - f.a), f.b, f.c - right * (f.c - f.b), lower.scale]
            sets[variable.name, name] = it2.IT2FS(np.linspace(0, 10, 11), kind, upper, kind, below, check_set=False)
    system.add_output_variable("z")
    for rule in fis.rules:
        consequent = fis.outputs[0].terms[rule.then[0][1]]
        weights = {"const": consequent.constant, "x": consequent.slopes[0], "y": consequent.slopes[1]}
        system.add_rule([(c.variable, sets[c.variable, c.term]) for c in rule.when], [("z", weights)])
    return [float(system.evaluate({"x": a, "y": b})["z"]) for a, b in x.tolist()]


def test_answers_are_those_of_pyit2fls():
    known, apart = json.loads(ANSWERS.read_text()), 0
    for (fis, x), expected in zip(problems(), known, strict=True):
        found = fis(x)[:, 0]
        assert found == pytest.approx(expected, rel=1e-8)
        for k in np.flatnonzero(~np.isclose(found, expected, rtol=1e-12, atol=1e-12)):
            bounds = fuzzy.infer_type2(fis, x[k])
            ends = by_every_choice(bounds.rule_outputs[:, 0], bounds.lower, bounds.upper)
            assert found[k] == pytest.approx(np.mean(ends), rel=1e-13)
            apart += 1
        assert fuzzy.compile_type2(fis)(x)[:, 0] == pytest.approx(expected, rel=1e-8)
    assert apart == 1


def test_the_file_holds_what_pyit2fls_says():
    pytest.importorskip("pyit2fls")
    known = json.loads(ANSWERS.read_text())
    for (fis, x), expected in list(zip(problems(), known, strict=True))[:10]:
        assert theirs(fis, x) == pytest.approx(expected, rel=1e-12)
