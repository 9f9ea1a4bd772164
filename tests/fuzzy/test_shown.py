"""Numbers and quotations as people read them."""

import pytest

from fuzzy.errors import quoted
from fuzzy.shown import shown, typeset


@pytest.mark.parametrize(
    ("value", "span", "text"),
    [
        (-8.882e-16, 20.0, "0"),
        (-8.882e-16, 0.0, "-8.882e-16"),
        (-0.0, 0.0, "0"),
        (12345.6, 1e5, "12350"),
        (3e9, 0.0, "3e+09"),
        (float("-inf"), 1.0, "-∞"),
        (float("nan"), 1.0, "not a number"),
        (1e-4, float("inf"), "0.0001"),
    ],
)
def test_shown(value: float, span: float, text: str) -> None:
    assert shown(value, span) == text


@pytest.mark.parametrize(
    ("text", "set_"),
    [
        ("-0.5 in [-1 1]", "−0.5 in [−1 1]"),
        ("a well-kept min-max", "a well-kept min-max"),
        ("chapter-4-test", "chapter-4-test"),
        ("2 distance - 0.5 bearing", "2 distance − 0.5 bearing"),
        ("1e-07", "1e−07"),
        ("5-95 %", "5-95 %"),
    ],
)
def test_only_signs_of_numbers_are_typeset(text: str, set_: str) -> None:
    assert typeset(text) == set_


def test_long_quotations_are_cut() -> None:
    assert quoted("x" * 120) == repr("x" * 120)
    assert len(quoted("x" * 2_000_000)) < 200
    assert "2000000 characters" in quoted("x" * 2_000_000)
