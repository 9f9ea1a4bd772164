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


def test_most_of_them_are_computed():
    """A cell follows each, or those beside it, but where a name or a caption is all there is to it."""
    bare = []
    for page in EXPLANATION.glob("errata-*.md"):
        parts = re.split(r"^\(erratum-(\w+)\)=$", page.read_text(encoding="utf-8"), flags=re.M)[1:]
        bare += [n for n, text in zip(parts[::2], parts[1::2], strict=True) if "```{code-cell}" not in text]
    assert len(bare) <= 30, sorted(bare)
