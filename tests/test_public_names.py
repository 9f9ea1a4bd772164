"""Packages that can be explored: what dir(), help() and type checkers show is what there is, and says what it does."""

import importlib
import inspect
import pydoc
import re
import subprocess
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).parent.parent
PACKAGES = ("fuzzy", "anfis", "robotics")


@pytest.mark.parametrize("package", PACKAGES)
def test_the_stub_is_the_one_list_of_names(package):
    text = (ROOT / package / "__init__.pyi").read_text(encoding="utf-8")
    lines = [re.fullmatch(r"from ([\w.]+) import (\w+) as (\w+)", line) for line in text.splitlines()]
    assert all(line and line[2] == line[3] for line in lines), "a line is not of the form that lazy_names reads"
    homes = {line[2]: line[1] for line in lines if line}
    assert len(homes) == len(lines)
    module = importlib.import_module(package)
    assert sorted(homes) == module.__all__
    for name, home in homes.items():
        assert getattr(module, name) is getattr(importlib.import_module(home), name)
    submodules = {f.stem for f in (ROOT / package).glob("[a-z]*.py")}
    submodules |= {f.parent.name for f in (ROOT / package).glob("*/__init__.py")}
    assert dir(module) == sorted({*module.__all__, *submodules})
    for name in dir(module):
        assert inspect.ismodule(getattr(module, name)) == (name in submodules), name
    with pytest.raises(AttributeError, match=f"module '{package}' has no attribute 'nothing'"):
        _ = module.nothing
    meant = module.__all__[-1]
    with pytest.raises(AttributeError, match=f"has no attribute '{meant}x'; did you mean '{meant}'"):
        getattr(module, f"{meant}x")
    with pytest.raises(AttributeError, match=r"has no attribute '_repr_html_'$"):
        _ = module._repr_html_


@pytest.mark.parametrize("package", PACKAGES)
def test_help_shows_every_function_and_what_each_is_for(package):
    module = importlib.import_module(package)
    text = pydoc.plain(pydoc.render_doc(module))
    overview = re.findall(r"\w+", module.__doc__ or "")
    for name in module.__all__:
        if inspect.isfunction(getattr(module, name)):
            assert re.search(rf"^    {name}( = \w+)?\(", text, re.MULTILINE), name
            matlab = name.endswith("mf") and not name.startswith("plot")
            assert name in overview or matlab, name
        else:
            assert name in text


@pytest.mark.parametrize("package", PACKAGES)
def test_every_public_name_says_what_it_is(package):
    module = importlib.import_module(package)
    for name in module.__all__:
        thing = getattr(module, name)
        if not (inspect.isclass(thing) or inspect.isroutine(thing)):
            continue
        doc = inspect.getdoc(thing) or ""
        assert len(doc) > 20, name
        assert not doc.startswith(f"{name}("), f"{name} has the text that dataclass makes"
        names = [*inspect.signature(thing).parameters] if inspect.isfunction(thing) else []
        if len(names) >= 3 and "Args:" not in doc:
            silent = [argument for argument in names if not re.search(rf"\b{argument}\b", doc)]
            assert silent == [], f"{name} says nothing of {silent}"


def test_completion_knows_the_names_before_they_are_used():
    code = (
        "import robotics, rlcompleter, sys; found = rlcompleter.Completer({'robotics': robotics}).attr_matches; "
        "print(found('robotics.simul'), found('robotics.labo'), 'robotics.simulation.loop' in sys.modules)"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True, timeout=60)
    assert "'robotics.simulate('" in done.stdout
    assert "'robotics.simulation'" in done.stdout
    assert "[]" in done.stdout


def test_a_file_is_read_before_anything_else_is_imported():
    """The membership functions are known by their names although nothing has named them yet."""
    code = "import fuzzy, sys; print(fuzzy.read_fis(sys.argv[1]).name)"
    file = ROOT / "robotics" / "data" / "rulebases" / "tracking.fis"
    said = subprocess.run([sys.executable, "-c", code, str(file)], capture_output=True, text=True)
    assert said.stdout == "tracking\n", said.stderr


@pytest.mark.parametrize(
    ("file", "script", "said"),
    [
        (
            "fuzzy.py",
            "import robotics",
            "ImportError: {} stands in the way of the package fuzzy of fuzzyfleet: rename it",
        ),
        ("fuzzy.py", "import anfis", "ImportError: {} stands in the way of the package fuzzy of fuzzyfleet: rename it"),
        ("anfis.py", "import robotics", "UserWarning: {} stands in the way of the package anfis of fuzzyfleet: rename"),
        ("robotics.py", "import anfis", "UserWarning: {} stands in the way of the package robotics of fuzzyfleet"),
        ("other.py", "import anfis, robotics", ""),
    ],
)
def test_a_file_that_stands_in_the_way_of_a_package_is_named(file, script, said, tmp_path):
    (tmp_path / file).write_text("x = 1\n")
    done = subprocess.run([sys.executable, "-c", script], cwd=tmp_path, capture_output=True, text=True, check=False)
    assert said.format(tmp_path / file) in done.stderr
    assert bool(done.stderr) == bool(said)
    assert done.returncode == said.startswith("ImportError")
