import pytest

from fuzzy.insight.coverage import spread_points
from fuzzy.insight.diagnosis import Finding, check
from fuzzy.membership import Gaussian, Trapezoid, Triangle
from fuzzy.system import Linear, Sugeno, Variable

X = Variable("x", (0, 10), {"low": Trapezoid(-1, -1, 2, 8), "high": Trapezoid(2, 8, 11, 11)}, "m")
Y = Variable("y", (-1, 1), {"neg": Trapezoid(-3, -2, -0.5, 0.5), "pos": Trapezoid(-0.5, 0.5, 2, 3)})
Z = Variable("z", (0, 1), {"a": 0.0, "b": 1.0})
GRID = [f"if x is {s} and y is {t} then z is {'a' if s == 'low' else 'b'}" for s in X.terms for t in Y.terms]


def found(fis: Sugeno, kind: str, **options) -> list[Finding]:
    return [finding for finding in check(fis, **options) if finding.kind == kind]


def test_a_complete_system_is_clean() -> None:
    assert check(Sugeno([X, Y], [Z], GRID)) == []


def test_a_place_without_rules_has_its_share_and_a_box() -> None:
    # Without the last rule nothing fires where only x is high and y is pos: x > 8, y > 0.5, a 20 % by 25 % corner.
    (finding,) = found(Sugeno([X, Y], [Z], GRID[:3]), "no rule fires")
    assert finding.severity == "warning"
    assert "no rule for z fires in about 5 % of the input space" in finding.sentence
    assert "where x is 8 to 10 m and y is 0.5 to 1" in finding.sentence


def test_the_search_is_repeatable_and_follows_the_seed() -> None:
    fis = Sugeno([X, Y], [Z], GRID[:3])
    assert check(fis) == check(fis)
    assert (spread_points(fis, 10, 0) != spread_points(fis, 10, 1)).any()
    points = spread_points(fis, 1000)
    assert ((points > [2.5, 0]).all(axis=1)).mean() == pytest.approx(0.375, abs=0.01)


def test_each_output_is_looked_at() -> None:
    other = Variable("other", (0, 1), {"c": 0.5})
    fis = Sugeno([X, Y], [Z, other], [*GRID, "if x is low and y is neg then other is c"])
    (finding,) = found(fis, "no rule fires")
    assert finding.where == ("other",)
    # x >= 8 (20 %) or y >= 0.5 (25 %)
    assert "about 40 %" in finding.sentence


def test_a_gap_between_terms_is_exact() -> None:
    gappy = Variable("x", (0, 10), {"low": Triangle(-1, 0, 3), "high": Triangle(6.5, 10, 12)})
    fis = Sugeno([gappy], [Z], ["if x is low then z is a", "if x is high then z is b"])
    (finding,) = found(fis, "gap between terms")
    assert (finding.severity, finding.sentence) == ("warning", "no term of x applies from 3 to 6.5")
    (finding,) = found(fis, "no rule fires")
    assert "about 35 %" in finding.sentence
    assert "where x is 3 to 6.5" in finding.sentence


def test_terms_that_only_touch_leave_a_point() -> None:
    touching = Variable("x", (0, 4), {"low": Triangle(-1, 1, 2), "high": Triangle(2, 3, 5)}, "m")
    fis = Sugeno([touching], [Z], ["if x is low then z is a", "if x is high then z is b"])
    (finding,) = found(fis, "gap between terms")
    assert finding.sentence == "no term of x applies at 2 m"
    assert finding.severity == "warning"


def test_a_gap_that_another_rule_covers_is_a_note() -> None:
    gappy = Variable("x", (0, 10), {"low": Triangle(-1, 0, 3), "high": Triangle(6, 10, 12)})
    rules = [
        "if x is low then z is a",
        "if x is high then z is b",
        "if y is neg then z is a",
        "if y is pos then z is b",
    ]
    (finding,) = found(Sugeno([gappy, Y], [Z], rules), "gap between terms")
    assert finding.severity == "note"


def test_gaussians_leave_no_gap_however_narrow() -> None:
    narrow = Variable("x", (0, 100), {"low": Gaussian(0.1, 0), "high": Gaussian(0.1, 100)})
    fis = Sugeno([narrow], [Z], ["if x is low then z is a", "if x is high then z is b"])
    assert not found(fis, "gap between terms")
    assert not found(fis, "no rule fires")


def test_no_rules_and_an_output_without_rules_are_errors() -> None:
    assert [str(f) for f in check(Sugeno([X], [Z]))] == ["error: the system has no rules"]
    other = Variable("other", (0, 1), {"c": 0.5})
    findings = check(Sugeno([X, Y], [Z, other], GRID))
    assert (findings[0].severity, findings[0].sentence) == ("error", "no rule proposes a value for other")


def test_unused_inputs_and_terms() -> None:
    fis = Sugeno([X, Y], [Z], ["if x is low then z is a", "if x is not low then z is a"])
    assert [f.sentence for f in found(fis, "unused input")] == ["no rule asks for the input y"]
    assert [(f.severity, f.sentence) for f in found(fis, "unused term")] == [
        ("warning", "no rule uses high of x"),
        ("note", "no rule uses b of z"),
    ]


@pytest.mark.parametrize(
    ("extra", "kind", "words"),
    [
        ("if y is neg and x is low then z is a", "duplicate rules", "rules 1 and 5 are the same"),
        ("if x is low and y is neg then z is a with 0.5", "duplicate rules", "differ only in their weights, 1 and 0.5"),
        (
            "if x is low and y is neg then z is b",
            "contradictory rules",
            "make z both a and b: if x is low and y is neg",
        ),
    ],
)
def test_rules_with_the_same_antecedent(extra: str, kind: str, words: str) -> None:
    (finding,) = check(Sugeno([X, Y], [Z], [*GRID, extra]))
    assert (finding.severity, finding.kind, finding.where) == ("warning", kind, (1, 5))
    assert words in finding.sentence


def test_many_equal_rules_are_one_finding() -> None:
    (finding,) = check(Sugeno([X, Y], [Z], [*GRID, GRID[0], GRID[0]]))
    assert finding.where == (1, 5, 6)
    assert finding.sentence == "rules 1, 5 and 6 are the same: if x is low and y is neg then z is a"


def test_nothing_fires_anywhere() -> None:
    (finding,) = found(Sugeno([X, Y], [Z], ["if x is low then z is a with 0"]), "no rule fires")
    assert finding.sentence == "no rule for z fires anywhere"


@pytest.mark.parametrize(
    "extra",
    [
        "if x is low or y is neg then z is b",
        "if x is low and y is not neg then z is b",
        "if x is very low and y is neg then z is b",
        "if x is low then z is b",
    ],
)
def test_another_antecedent_is_no_contradiction(extra: str) -> None:
    assert check(Sugeno([X, Y], [Z], [*GRID, extra])) == []


def test_two_outputs_of_one_antecedent_could_be_one_rule() -> None:
    other = Variable("other", (0, 1), {"c": 0.5})
    rules = [*GRID, *(rule.partition(" then ")[0] + " then other is c" for rule in GRID)]
    findings = check(Sugeno([X, Y], [Z, other], rules))
    assert [f.severity for f in findings] == ["note"] * 4
    assert "rules 1 and 5 have the same antecedent and could be one" in findings[0].sentence


def test_rules_that_do_nothing() -> None:
    far = Variable("x", (0, 10), {**X.terms, "beyond": Triangle(20, 30, 40)}, "m")
    rules = [*GRID, "if x is beyond and y is pos then z is a", "if y is neg then z is b with 0"]
    findings = check(Sugeno([far, Y], [Z], rules))
    assert [(f.severity, f.kind) for f in findings] == [
        ("warning", "rule never fires"),
        ("warning", "weight 0"),
        ("warning", "term out of range"),
    ]
    assert findings[0].sentence.startswith("rule 5 can never fire, because never x is beyond")
    assert findings[1].sentence.startswith("rule 6 has the weight 0")
    assert findings[2].sentence == "beyond of x is 0 in all of its range [0 10]"


def test_terms_that_are_nearly_the_same_or_overlap() -> None:
    terms = {"a": Gaussian(2, 3), "b": Gaussian(2.01, 3), "c": Gaussian(2, 4), "d": Gaussian(2, 9)}
    fis = Sugeno([Variable("x", (0, 10), terms)], [Z], [f"if x is {t} then z is a" for t in terms])
    (same,) = found(fis, "nearly identical terms")
    assert (same.severity, same.where) == ("warning", ("x", "a", "b"))
    assert {f.where[1:] for f in found(fis, "strong overlap")} == {("a", "c"), ("b", "c")}
    (total,) = found(fis, "degrees do not sum to 1")
    assert total.severity == "note"


def test_consequents_outside_the_range() -> None:
    z = Variable("z", (0, 1), {"a": 0.0, "b": 2.0, "plane": Linear([0.2, 0.0], 0.0), "flat": Linear([0.05, 0.5], 0.5)})
    rules = [*GRID, "if x is very low then z is plane", "if x is very high then z is flat"]
    warning, note = found(Sugeno([X, Y], [z], rules), "consequent out of range")
    assert (warning.severity, warning.sentence) == ("warning", "b (2) of z leaves its range [0 1]")
    assert note.severity == "note"
    assert "plane (0 to 2) and flat (0 to 1.5) of z leave its range" in note.sentence


def test_errors_come_before_warnings_and_notes() -> None:
    order = [f.severity for f in check(Sugeno([X, Y], [Z, Variable("w", (0, 1), {"u": 3.0})], GRID[:3]))]
    assert order == sorted(order, key=["error", "warning", "note"].index)
    assert order[0] == "error"


def test_at_least_one_point() -> None:
    with pytest.raises(ValueError, match="at least 1, got 0"):
        check(Sugeno([X, Y], [Z], GRID), points=0)
