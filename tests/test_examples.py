"""The gallery: every script has a page that says what it is. `make docs` runs them, and looks at their pictures."""

import ast
import re
import tomllib
from pathlib import Path

ROOT = Path(__file__).parent.parent
SCRIPTS = sorted((ROOT / "examples").glob("*/plot_*.py"))
IN_WORDS = tomllib.loads((ROOT / "examples" / "alt.toml").read_text(encoding="utf-8"))


def test_the_gallery_names_the_packages_that_only_some_examples_need():
    told = (ROOT / "examples" / "README.rst").read_text(encoding="utf-8")
    extras = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]["optional-dependencies"]
    needy = {script.name for script in SCRIPTS if "robotics.certify(" in script.read_text(encoding="utf-8")}
    assert needy == {*re.findall(r"plot_\w+\.py", told)}
    assert f"pip install '{extras['certify'][0]}'" in told


def test_tuning_needs_no_extra():
    project = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]
    assert "cmaes>=0.13" in project["dependencies"]
    assert all("cmaes" not in package for packages in project["optional-dependencies"].values() for package in packages)


def test_there_is_one_of_everything_and_each_has_a_title_of_its_own():
    titles = [
        str(ast.get_docstring(ast.parse(script.read_text(encoding="utf-8")))).split("\n")[0] for script in SCRIPTS
    ]
    assert len({*titles}) == len(titles)
    assert 25 <= len(SCRIPTS) <= 30
    assert {*IN_WORDS} == {script.stem for script in SCRIPTS}
    words = [text for texts in IN_WORDS.values() for text in texts]
    assert len({*words}) == len(words)
    assert all(text.endswith(".") and len(text) > 30 for text in words)
    for script in SCRIPTS:
        text = script.read_text(encoding="utf-8")
        assert re.match(r'"""\n(.+)\n=+\n\n[A-Z0-9].+', text), f"{script.name}: a title, its line, and a sentence"
        parts = re.findall(r"^(?:from|import) ((?:fuzzy|anfis|robotics)\.[\w.]+)", text, re.MULTILINE)
        assert not parts, f"{script.name} uses {parts}, which a user's program need not know"
        assert not re.search("#[0-9A-Fa-f]{6}", text), f"{script.name} has a colour of its own"
