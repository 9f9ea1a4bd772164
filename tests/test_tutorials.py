"""The tutorials and other pages that are notebooks: their cells, which `make docs` runs, use public names."""

import ast
import importlib
from pathlib import Path

import pytest

from tests.snippets import cells

DOCS = Path(__file__).parent.parent / "docs"
PAGES = sorted(
    page
    for page in DOCS.rglob("*.md")
    if not {"_build", "gallery", "made"} & set(page.relative_to(DOCS).parts)
    and page.read_text(encoding="utf-8").startswith("---\nfile_format: mystnb\n")
)
PACKAGES = ("anfis", "fuzzy", "robotics")
# How many assert statements of a tutorial hold its text to what its cells found. Take one away with its sentence only.
CLAIMS = {"steering": 6, "formation": 9, "fair-comparison": 8, "losing-a-robot": 14, "closed-loop-tuning": 4, "ros": 1}


def named(page):
    return page.relative_to(DOCS).as_posix()


@pytest.mark.parametrize("page", PAGES, ids=named)
def test_cells_use_public_names(page):
    found = cells(page)
    assert len(found) == page.read_text(encoding="utf-8").count("```{code-cell}") > 0
    for cell in found:
        for node in ast.walk(ast.parse(cell)):
            if isinstance(node, ast.Attribute) and isinstance(node.value, ast.Name) and node.value.id in PACKAGES:
                assert node.attr in importlib.import_module(node.value.id).__all__, f"{node.value.id}.{node.attr}"
            if isinstance(node, ast.ImportFrom):
                assert node.module is not None
                assert node.module.partition(".")[0] not in PACKAGES, f"from {node.module}"


@pytest.mark.parametrize("name", CLAIMS)
def test_what_the_text_claims_is_asserted(name):
    asserts = [
        node
        for cell in cells(DOCS / "tutorials" / f"{name}.md")
        for node in ast.walk(ast.parse(cell))
        if isinstance(node, ast.Assert)
    ]
    assert len(asserts) >= CLAIMS[name]
    assert not [ast.unparse(node) for node in asserts if not any(isinstance(n, ast.Name) for n in ast.walk(node))]


def test_every_tutorial_is_a_notebook_in_the_list():
    index = (DOCS / "tutorials" / "index.md").read_text(encoding="utf-8")
    listed = index.rpartition("```{toctree}\n:hidden:\n")[2].split("```")[0].split()
    pages = {page.stem for page in (DOCS / "tutorials").glob("*.md")} - {"index"}
    assert pages == {page.stem for page in PAGES if page.parent.name == "tutorials"} == {*listed}
    for name in listed:
        assert f"]({name}.md)" in index
        assert "## Exercises" in (DOCS / "tutorials" / f"{name}.md").read_text(encoding="utf-8")
