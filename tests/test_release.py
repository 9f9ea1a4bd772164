"""What is said in two places about a release says the same."""

import re
import tomllib
from pathlib import Path

ROOT = Path(__file__).parent.parent


def test_the_citation_is_of_this_project_and_version():
    project = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]
    citation = (ROOT / "CITATION.cff").read_text(encoding="utf-8")
    cited = dict(re.findall(r"(?m)^([\w-]+): (.+)$", citation))
    for field in ("version", "license"):
        assert cited[field] == project[field]
    assert cited["title"].lower() == project["name"]
    assert {author["name"] for author in project["authors"]} == set(re.findall(r"(?m)^  - name: (.+)$", citation))
    assert cited["cff-version"] == "1.2.0"


def test_the_changelog_names_the_version_that_is_built():
    """The newest section with a date is of the version that is built; only what is not released stands above it."""
    project = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]
    sections = re.findall(r"(?m)^## (.+)$", (ROOT / "CHANGELOG.md").read_text(encoding="utf-8"))
    above = [section for section in sections if section == "Unreleased"]
    assert sections[: len(above)] == above
    assert re.fullmatch(rf"{re.escape(project['version'])} \(\d{{4}}-\d\d-\d\d\)", sections[len(above)])
    assert len(above) <= 1


def test_make_clean_removes_the_compiled_kernels_of_every_folder_with_code():
    folders = {file.relative_to(ROOT).parts[0] for file in ROOT.glob("*/**/*.py")} - {".venv", "build", "node_modules"}
    (recipe,) = re.findall(r"(?m)^\tfind (.+) -name __pycache__ ", (ROOT / "Makefile").read_text(encoding="utf-8"))
    assert folders <= set(recipe.split())
