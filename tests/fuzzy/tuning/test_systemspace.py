"""What may move of a system: terms stay ordered and covering, symmetry stays, and files of strangers can be tuned."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from fuzzy.files.fisfile import FisFileError, format_fis, parse_fis, read_fis
from fuzzy.membership import Gaussian, Sigmoid
from fuzzy.system import Constant, Linear, Sugeno, Variable
from fuzzy.tuning.mirror import mirror_of
from fuzzy.tuning.parameter import TuningError, values_at
from fuzzy.tuning.systemspace import MOVABLE, SystemSpace
from tests.fuzzy.random_systems import systems

ROOT = Path(__file__).parents[3]
TRACKING = read_fis(ROOT / "robotics/data/rulebases/tracking.fis")
BOUNDED = ("trimf", "trapmf", "pimf", "zmf", "smf", "linsmf", "linzmf")


def _sugeno_files():
    for file in [*(ROOT / "tests/data/fis-corpus").glob("*.fis"), *(ROOT / "robotics/data/rulebases").rglob("*.fis")]:
        try:
            fis = read_fis(file)
        except FisFileError:
            continue
        yield pytest.param(fis, id=file.name)


def drawn(space, rng):
    """Values of a random point of the space."""
    unit = [rng.integers(len(p.choices)) if p.choices else rng.random() for p in space.parameters]
    return values_at(space.parameters, np.array(unit, dtype=float)[None])[0]


FILES = list(_sugeno_files())


@pytest.mark.parametrize("fis", FILES)
def test_the_start_is_the_system_itself(fis):
    space = SystemSpace(fis, MOVABLE)
    assert space.made([p.start for p in space.parameters]) == fis


@pytest.mark.parametrize("fis", FILES)
def test_terms_stay_in_order_and_cover_what_they_covered(fis):
    space, rng = SystemSpace(fis, ("memberships",)), np.random.default_rng(1)
    for _ in range(5):
        made = space.made(drawn(space, rng))
        for before, after in zip(fis.inputs, made.inputs, strict=True):
            assert after.universe == before.universe
            assert orders(before) == orders(after)
            x = np.linspace(before.universe[0], before.universe[1], 401)
            reached = greatest(after, x) > 0
            # Where terms of bounded support covered all of it they still do, but for points on a foot
            if (greatest(before, x) > 1e-6).all() and {t.matlab for t in before.terms.values()} <= set(BOUNDED):
                assert reached.mean() > 0.98


def orders(variable):
    """For every two terms which of their places come before which; equal ones are together."""
    places = [
        (n, name)
        for name, t in variable.terms.items()
        for n, r in zip(t.numbers, t.roles, strict=True)
        if r == "location"
    ]
    numbers = sorted({n for n, _ in places})
    return [[numbers.index(n), name] for n, name in places]


def greatest(variable, x):
    return np.max([term(x) for term in variable.terms.values()], axis=0) if variable.terms else np.ones_like(x)


@pytest.mark.filterwarnings("ignore::fuzzy.files.fisfile.FisFileWarning")  # of what MATLAB reads otherwise
@settings(max_examples=40)
@given(systems(), st.integers(0, 2**32))
def test_every_point_of_the_space_makes_a_system_that_a_file_can_hold(fis, seed):
    space = SystemSpace(fis, MOVABLE)
    made = space.made(drawn(space, np.random.default_rng(seed)))
    assert 1 <= len(made.rules) <= len(fis.rules)
    assert parse_fis(format_fis(made)).inputs == made.inputs


def test_gaussians_of_a_stretched_universe_are_wider():
    x = Variable("x", (0, 10), {"a": Gaussian(1.0, 2.0), "b": Gaussian(1.0, 5.0)})
    space = SystemSpace(Sugeno([x], [Variable("y", (0, 1), {"z": 0.0})], ["if x is a then y is z"]), ("memberships",))
    names = [p.name for p in space.parameters]
    assert names == ["x.gap 0 to 2", "x.gap 2 to 5", "x.a.width", "x.b.width"]
    made = space.made([4.0, 1.0, 1.0, 1.5])
    a, b = made.inputs[0].terms.values()
    # 0 to 2 becomes 8/16 of the universe, 2 to 5 becomes 3/16
    assert a.numbers[1] == pytest.approx(5.0)
    assert b.numbers[1] == pytest.approx(5.0 + 30 / 16)
    assert a.numbers[0] == pytest.approx((2.5 + 10 / 16) / 2)
    assert b.numbers[0] == pytest.approx(1.5 * 10 / 16)


def test_a_level_line_stays_level():
    x = Variable("x", (-3, 4), {"all": Sigmoid(0.0, 0.0), "right": Sigmoid(1e-320, 1.0)})
    fis = Sugeno([x], [Variable("y", (0, 1), {"z": 0.0})], ["if x is all then y is z"])
    space = SystemSpace(fis, ("memberships",))
    made = space.made([2.0] * 2 + [1.2] * (len(space.parameters) - 2))
    assert made.inputs[0].terms["all"].numbers[0] == 0
    assert np.isfinite(made.inputs[0].terms["right"].numbers).all()


def test_a_rule_base_that_steers_keeps_its_symmetry():
    mirror = mirror_of(TRACKING)
    assert mirror.inputs == (1, -1, 1, -1)
    assert mirror.outputs == (1, -1)
    space, rng = SystemSpace(TRACKING, ("memberships", "consequents", "weights", "choices")), np.random.default_rng(0)
    x = rng.uniform([0, -3, -0.1, -3], [1.2, 3, 0.1, 3], (200, 4))
    for _ in range(5):
        made = space.made(drawn(space, rng))
        here, there = made(x), made(x * mirror.inputs)
        assert np.allclose(here * mirror.outputs, there, rtol=0, atol=1e-12)


def test_without_its_symmetry_there_is_more_to_tune():
    both, one = SystemSpace(TRACKING, symmetric=False), SystemSpace(TRACKING)
    assert len(both.parameters) > len(one.parameters)
    assert both.mirror is None
    assert {"w.Negative+Positive"} <= {p.name for p in one.parameters}
    assert {"w.Negative", "w.Positive", "w.Zero"} <= {p.name for p in both.parameters}


def test_a_system_without_symmetry_has_none():
    changed = [*TRACKING.rules]
    changed[6] = replace(changed[6], weight=0.5)
    assert mirror_of(replace(TRACKING, rules=changed)).inputs == (1, 1, 1, -1)  # only whether it faces its path


def test_planes_move_slope_by_slope():
    x, z = (
        Variable(n, (-1, 1), {"all": read_fis(ROOT / "robotics/data/rulebases/eta.fis").inputs[0].terms[t]})
        for n, t in zip("xz", list(read_fis(ROOT / "robotics/data/rulebases/eta.fis").inputs[0].terms)[:2], strict=True)
    )
    y = Variable("y", (-1, 1), {"p": Linear((2.0, 0.0), 1.0), "q": Constant(0.5)})
    fis = Sugeno([x, z], [y], ["if x is all then y is p", "if z is all then y is q"])
    space = SystemSpace(fis, ("consequents",))
    assert [p.name for p in space.parameters] == ["y.p.x", "y.p", "y.q"]
    made = space.made([3.0, -1.0, 0.25])
    assert made.outputs[0].terms["p"] == Linear((3.0, 0.0), -1.0)
    assert made.outputs[0].terms["q"] == Constant(0.25)


def test_rules_can_be_left_out_but_not_all():
    space = SystemSpace(TRACKING, ("rules",))
    made = space.made([1.0] * len(space.parameters))
    assert len(made.rules) == 1
    names = {p.name: k for k, p in enumerate(space.parameters)}
    values = [0.0] * len(names)
    values[names["rule 7+9"]] = 1.0
    assert [r for r in TRACKING.rules if r not in space.made(values).rules] == [TRACKING.rules[6], TRACKING.rules[8]]


def test_a_choice_takes_the_mirrored_term_on_the_other_side():
    space = SystemSpace(TRACKING, ("choices",))
    parameter = next(p for p in space.parameters if p.name == "rule 7+9.w")
    values = [p.start for p in space.parameters]
    values[space.parameters.index(parameter)] = parameter.choices.index("Big negative")
    made = space.made(values)
    assert dict(made.rules[6].then)["w"] == "Big negative"
    assert dict(made.rules[8].then)["w"] == "Big positive"


def test_an_unknown_part_is_refused():
    with pytest.raises(TuningError, match="did you mean 'weights'"):
        SystemSpace(TRACKING, ("weight",))
