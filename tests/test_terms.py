"""One term for one thing: what CONTRIBUTING.md says is not said stands in no page, help text, message or docstring."""

import ast
import re
from collections.abc import Iterator
from pathlib import Path

import pytest

ROOT = Path(__file__).parent.parent
PAGES = [ROOT / "README.md", ROOT / "CONTRIBUTING.md", *sorted((ROOT / "docs").rglob("*.md"))]
# Quotations of the thesis, and pages that say what things are called elsewhere
ELSEWHERE = re.compile(r"errata|thesis|from-|matlab|ros|nav2|_build|made/")
_ROW = re.compile(r"^\| (\w[^|]+) \| ([^|]+) \| ([^|]+) \|$", re.MULTILINE)
_CODE = re.compile(
    r"^(```+).*?^\1|`[^`]*`|\]\([^)]*\)|\"[^\"\n]*\"|\$[^$\n]*\$|^---\n.*?^---\n", re.MULTILINE | re.DOTALL
)


def terms() -> dict[str, str]:
    """What is not said, with what is said instead."""
    text = (ROOT / "CONTRIBUTING.md").read_text(encoding="utf-8").partition("## One term for one thing")[2]
    rows = [row for row in _ROW.findall(text.partition("\n## ")[0]) if row[0] != "we say"]
    return {word: said for said, _, words in rows for word in words.split(", ")}


TERMS = terms()
AVOIDED = re.compile(rf"\b({'|'.join(f'[{w[0].upper()}{w[0]}]{re.escape(w[1:])}' for w in TERMS)})s?\b")


def prose(page: Path) -> str:
    text = page.read_text(encoding="utf-8")
    if page.name == "CONTRIBUTING.md":
        text = text.partition("## One term for one thing")[0]
    return _CODE.sub("", text)


def sentences(file: Path) -> Iterator[str]:
    """The texts of a Python file that have more than one word."""
    for node in ast.walk(ast.parse(file.read_text(encoding="utf-8"))):
        if isinstance(node, ast.Constant) and isinstance(node.value, str) and " " in node.value:
            yield re.sub(r"`[^`]*`|\"[^\"\n]*\"|[\w.]+(?:[._/]\w+)+", "", node.value)


def test_the_list_is_read():
    assert len(TERMS) >= 12
    assert AVOIDED.search("The lateral errors are small.")
    assert not AVOIDED.search("the cross-track error")


@pytest.mark.parametrize("page", [page for page in PAGES if not ELSEWHERE.search(str(page.relative_to(ROOT)))], ids=str)
def test_pages_say_one_term_for_one_thing(page):
    assert AVOIDED.findall(prose(page)) == []


@pytest.mark.parametrize("package", ["fuzzy", "anfis", "robotics"])
def test_programs_say_one_term_for_one_thing(package):
    files = [
        file for file in sorted((ROOT / package).rglob("*.py")) if not ELSEWHERE.search(str(file.relative_to(ROOT)))
    ]
    found = {
        str(file.relative_to(ROOT)): words for file in files if (words := AVOIDED.findall(" ".join(sentences(file))))
    }
    assert found == {}
