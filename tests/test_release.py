"""What is said in two places about a release says the same."""

import re
import subprocess
import sys
import tomllib
from pathlib import Path

import pytest
import yaml

import release.__main__ as release

ROOT = Path(__file__).parent.parent
FILLED_IN = ("recipe/recipe.yaml", ".github/ISSUE_TEMPLATE/config.yml")


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


def tree(folder):
    """What a release is made of, with nothing that is to be mended."""
    for file in ("pyproject.toml", "CITATION.cff", "CHANGELOG.md", "SECURITY.md", "CODE_OF_CONDUCT.md", *FILLED_IN):
        text = (ROOT / file).read_text(encoding="utf-8").replace("fuzzyfleet.invalid", "example.org")
        (folder / file).parent.mkdir(parents=True, exist_ok=True)
        (folder / file).write_text(text.replace("## Unreleased\n", ""), encoding="utf-8")
    changelog = folder / "CHANGELOG.md"
    text = changelog.read_text(encoding="utf-8")
    changelog.write_text(text[text.index(f"## {release.project(ROOT)['version']} ") :], encoding="utf-8")
    return folder


def test_a_tree_that_is_ready_has_no_faults(tmp_path):
    assert release.faults(tree(tmp_path)) == []


@pytest.mark.parametrize(
    ("file", "now", "then", "said"),
    [
        (
            "pyproject.toml",
            "https://example.org/issues",
            "https://x.invalid",
            "Issues is a placeholder, https://x.invalid",
        ),
        ("SECURITY.md", "example.org", "x.invalid", "SECURITY.md: has a placeholder"),
        ("CODE_OF_CONDUCT.md", "example.org", "x.invalid", "CODE_OF_CONDUCT.md: has a placeholder"),
        ("recipe/recipe.yaml", "example.org", "x.invalid", "recipe/recipe.yaml: has a placeholder"),
        ("recipe/recipe.yaml", 'version: "', 'version: "9.', "recipe/recipe.yaml: the version is 9."),
        ("CITATION.cff", "\nversion: ", "\nversion: 9.", "CITATION.cff: the version is 9."),
        ("CHANGELOG.md", "## ", "## Unreleased\n\n## ", "CHANGELOG.md: begins with Unreleased"),
    ],
)
def test_what_is_not_ready_is_refused(file, now, then, said, tmp_path):
    place = tree(tmp_path) / file
    text = place.read_text(encoding="utf-8")
    assert now in text
    place.write_text(text.replace(now, then, 1), encoding="utf-8")
    (fault,) = release.faults(tmp_path)
    assert said in fault


def test_this_tree_is_refused_as_long_as_its_addresses_are_placeholders():
    asked = [sys.executable, "-m", "release", "check"]
    done = subprocess.run(asked, cwd=ROOT, capture_output=True, text=True, check=False)
    urls = release.project(ROOT)["urls"]
    if any(".invalid" in url for url in urls.values()):
        assert done.returncode == 1
        assert "pyproject.toml: Homepage is a placeholder" in done.stdout
    assert subprocess.run([*asked, "--rehearsal"], cwd=ROOT, capture_output=True, check=False).returncode == 0


def test_notes_are_the_section_of_the_version():
    text = "# Changelog\n\n## 1.1 (2030-01-01)\n\nNew.\n\n### Added\n\n- a\n\n## 1.10 (2029-01-01)\n\nOld.\n"
    assert release.notes(text, "1.1") == "# Fuzzyfleet 1.1 (2030-01-01)\n\nNew.\n\n### Added\n\n- a\n"
    assert release.notes(text, "1.10").endswith("\n\nOld.\n")
    with pytest.raises(ValueError, match="no section 2"):
        release.notes(text, "2")


def test_every_requirement_has_a_lower_bound_and_no_upper_one():
    asked = release.project(ROOT)["dependencies"]
    assert len(release.oldest(asked)) == len(asked)
    assert "numpy==2.0" in release.oldest(asked)
    for line in ("numpy", "numpy>=2,<3", "numpy==2"):
        with pytest.raises(ValueError, match="an upper bound needs a reason and a test"):
            release.oldest([line])


def test_every_version_in_the_changelog_begins_with_a_paragraph():
    text = (ROOT / "CHANGELOG.md").read_text(encoding="utf-8")
    for section in re.split(r"(?m)^## ", text)[1:]:
        title, _, rest = section.partition("\n")
        assert re.match(r"\n[A-Z][^\n]{60,}", rest), f"{title} has no paragraph that says what it is"


def test_the_recipe_asks_for_what_the_wheel_asks_for():
    recipe = yaml.safe_load((ROOT / "recipe" / "recipe.yaml").read_text(encoding="utf-8"))
    project = release.project(ROOT)
    conda = {"matplotlib": "matplotlib-base", "torch": "pytorch"}  # the same packages there
    asked = {re.sub(r"^[\w-]+", lambda name: conda.get(name[0], name[0]), line) for line in project["dependencies"]}
    ours = {line.replace(" ", "") for line in recipe["requirements"]["run"]}
    assert ours == asked | {"python>=${{python_min}}"}
    assert project["requires-python"] == f">={recipe['context']['python_min']}"
    commands = [f"{name} = {place}" for name, place in project["scripts"].items()]
    assert recipe["build"]["python"]["entry_points"] == commands
    assert (recipe["about"]["summary"], recipe["about"]["license"]) == (project["description"], project["license"])
    (built_by,) = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["build-system"]["requires"]
    assert built_by in {line.replace(" ", "") for line in recipe["requirements"]["host"]}


def test_the_recipe_is_one():
    """By the program that conda-forge builds with: unknown keys and fields of a wrong kind are refused."""
    rattler = pytest.importorskip("rattler_build", reason="needs the extra release")
    recipe = ROOT / "recipe" / "recipe.yaml"
    (variant,) = rattler.Stage0Recipe.from_file(recipe).render()
    assert variant.recipe.package.name == "fuzzyfleet"
    with pytest.raises(Exception, match="unknown field 'no_arch'"):
        rattler.Stage0Recipe.from_yaml(recipe.read_text(encoding="utf-8").replace("noarch:", "no_arch:"))
