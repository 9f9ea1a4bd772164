"""The import directions of the house, and what an import may not bring along."""

import ast
import re
import subprocess
import sys
import tomllib
from importlib.util import find_spec
from pathlib import Path

import pytest

ROOT = Path(__file__).parent.parent
FLOORS = {"fuzzy": {"fuzzy"}, "anfis": {"fuzzy", "anfis"}, "robotics": {"fuzzy", "anfis", "robotics"}}
OURS = {"fuzzy", "anfis", "robotics", "datasets", "tests", "benchmarks"}


@pytest.mark.parametrize("package", FLOORS)
def test_imports_point_down_only(package):
    files = list((ROOT / package).rglob("*.py"))
    assert files
    for file in files:
        for node in ast.walk(ast.parse(file.read_text(encoding="utf-8"))):
            names = []
            if isinstance(node, ast.Import):
                names = [alias.name for alias in node.names]
            elif isinstance(node, ast.ImportFrom):
                assert node.level == 0, f"{file}: relative import"
                names = [node.module or ""]
            for name in names:
                top = name.partition(".")[0]
                assert top not in OURS or top in FLOORS[package], f"{file}:{node.lineno} imports {name}"


@pytest.mark.parametrize(
    ("statement", "heavy"),
    [
        ("import fuzzy", {"torch", "matplotlib", "pandas", "numba", "skfuzzy", "scipy"}),
        ("import fuzzy.commands.application", {"torch", "matplotlib", "pandas", "numba", "skfuzzy", "scipy"}),
        (
            "import robotics.commands.application",
            {"torch", "matplotlib", "pandas", "numba", "skfuzzy", "scipy", "cvxpy", "pyarrow", "distributed"},
        ),
        ("import robotics; robotics.simulate", {"torch", "matplotlib", "skfuzzy", "jinja2"}),
    ],
)
def test_an_import_stays_light(statement, heavy):
    code = f"{statement}; import sys; print(*sorted(set({heavy!r}) & set(sys.modules)))"
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True, timeout=60)
    assert done.stdout.strip() == ""


@pytest.mark.parametrize(
    "module", ["robotics.laws.teams.graph_sliding_mode", "robotics.laws.catalogue", "robotics.sensing.posture"]
)
def test_a_module_can_be_imported_first(module):
    subprocess.run([sys.executable, "-c", f"import {module}"], check=True, capture_output=True, timeout=60)


def test_public_names_exist():
    import fuzzy
    import robotics

    for package in (fuzzy, robotics):
        for name in package.__all__:
            assert getattr(package, name) is not None
            assert not isinstance(getattr(package, name), type(sys)), f"{package.__name__}.{name} is a module"


def test_every_benchmark_finds_what_it_measures():
    names = sorted(f"benchmarks.{file.stem}" for file in (ROOT / "benchmarks").glob("[a-z]*.py"))
    assert len(names) > 8
    statement = "\n".join(f"import {name}" for name in names)
    done = subprocess.run([sys.executable, "-c", statement], cwd=ROOT, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr


def test_what_scikit_fuzzy_imports_is_a_runtime_requirement_of_ours():
    """It declares nothing itself."""
    home = Path(find_spec("skfuzzy").origin).parent
    names = set()
    for file in home.rglob("*.py"):
        if "tests" not in file.relative_to(home).parts:
            for node in ast.walk(ast.parse(file.read_text(encoding="utf-8"))):
                modules = [alias.name for alias in node.names] if isinstance(node, ast.Import) else []
                modules += [node.module or ""] if isinstance(node, ast.ImportFrom) and node.level == 0 else []
                names |= {module.partition(".")[0] for module in modules}
    assert {"skfuzzy", "networkx", "packaging"} <= names
    project = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]
    declared = {re.split(r"[^\w-]", line)[0] for line in project["dependencies"]}
    assert "scikit-fuzzy" in declared
    assert names - set(sys.stdlib_module_names) - {"skfuzzy"} <= declared
