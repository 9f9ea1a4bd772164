"""The pages of errata: all are there, each once, in the overview too."""

import re
from pathlib import Path

EXPLANATION = Path(__file__).parent.parent / "docs" / "explanation"
NUMBERS = [*(f"a{k}" for k in range(1, 44)), *(f"b{k}" for k in range(1, 26))]


def test_every_erratum_is_told_once_and_listed():
    pages = sorted(EXPLANATION.glob("errata-*.md"))
    told = [n for page in pages for n in re.findall(r"^\(erratum-(\w+)\)=$", page.read_text(encoding="utf-8"), re.M)]
    assert told == NUMBERS
    overview = (EXPLANATION / "errata.md").read_text(encoding="utf-8")
    assert re.findall(r"^\| \[[AB]\d+\]\(#erratum-(\w+)\)", overview, re.M) == NUMBERS


def test_they_are_computed():
    """A cell is in each, but where a neighbour has it (A9, A10: A11; A22: A23) or a reference or caption is wrong."""
    bare = []
    for page in sorted(EXPLANATION.glob("errata-*.md")):
        parts = re.split(r"^\(erratum-(\w+)\)=$", page.read_text(encoding="utf-8"), flags=re.M)[1:]
        bare += [n for n, text in zip(parts[::2], parts[1::2], strict=True) if "```{code-cell}" not in text]
    assert bare == ["a9", "a10", "a13", "a22", "b24", "b25"]
