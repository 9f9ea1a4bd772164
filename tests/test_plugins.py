"""Plug-ins: the core stands without each of them, and a stranger's is as good as ours."""

import ast
import json
import os
import re
import shutil
import subprocess
import sys
import tomllib
from importlib.metadata import requires
from pathlib import Path

import pytest

from tests.conftest import declare
from tests.test_imports import PLUGINS_OF, arrows

ROOT = Path(__file__).parent.parent
PACKAGES = ("fuzzy", "anfis", "robotics")
PLUGINS = [(package, plugin) for package, plugins in PLUGINS_OF.items() for plugin in plugins]
# Tests of the core that are run without a plug-in, few and quick ones, and all of them.
CORE_TESTS = {
    "fuzzy": ["tests/fuzzy/insight/test_explanation.py", "tests/fuzzy/test_shown.py"],
    "anfis": ["tests/anfis/test_consequents.py"],
    "robotics": ["tests/robotics/measures/statistics/test_shares.py", "tests/robotics/world/paths/test_level.py"],
}
ALL_CORE_TESTS = {package: [f"tests/{package}", f"--ignore=tests/{package}/plugins"] for package in CORE_TESTS}
LEFT = """
import contextlib, importlib, io, json, pkgutil, sys

package, plugin, users, *tests = sys.argv[1:]
users = users.split()
module = importlib.import_module(package)
for found in pkgutil.walk_packages(module.__path__, f"{package}."):
    if not found.name.startswith(f"{package}.plugins.") and not found.name.endswith("__main__"):
        importlib.import_module(found.name)
lost = {}
with open(module.__file__ + "i") as stub:
    for line in stub:
        _, home, _, name, *_ = line.split()
        if home.startswith(tuple(f"{package}.plugins.{user}." for user in users)):
            continue  # of a plug-in that uses the missing one
        try:
            assert getattr(module, name) is not None and name in module.__all__ and name in dir(module)
        except ImportError as error:
            assert name not in module.__all__ and name not in dir(module)
            lost[name] = str(error)
main = importlib.import_module(f"{package}.commands.application").main
with contextlib.redirect_stdout(io.StringIO()) as shown:
    assert main(["--help"]) == 0
print(json.dumps([lost, shown.getvalue()]), flush=True)
import pytest

sys.exit(pytest.main(tests))
"""
QUIET = ["-q", "-p", "no:cacheprovider", "-p", "no:xdist", "-o", "addopts=", "-m"]
QUIET += ["not long and not browser and not hypothesis"]  # random cases say nothing of what is missing


def users_of(package, plugin):
    """The plug-ins of the package that use this one, or one of those that do."""
    found = {plugin}
    while more := {name for name, used in PLUGINS_OF[package].items() if found & {*used}} - found:
        found |= more
    return sorted(found - {plugin})


def other_tests_of(package, plugin):
    """The files outside its own folder that test a plug-in, too: they import it, or name what it brings."""
    plugins = [plugin, *users_of(package, plugin)]
    folder, module = ROOT / package / "plugins" / plugin, f"{package}.plugins.{plugin}"
    laws = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]["entry-points"][
        "fuzzyfleet.laws"
    ]
    names = {name for name, value in laws.items() if value.startswith(f"{module}.")}
    names |= {file.stem for kind in ("scenarios", "studies") for file in folder.glob(f"data/{kind}/*.toml")}
    named = re.compile(rf"[\"'/](?:{'|'.join(sorted(names)) or '(?!)'})[\"':/,]")
    gone = tuple(f"{package}.plugins.{each}." for each in plugins)
    found = {arrow.source for arrow in arrows(ROOT, f"tests.{package}") if arrow.target.startswith(gone)}
    files = {f"{name.replace('.', '/')}.py" for name in found}
    for file in (ROOT / "tests" / package).rglob("test_*.py"):
        text = file.read_text(encoding="utf-8")
        if named.search(text) or any(f"{package}.plugins.{each}" in text for each in plugins):
            files.add(file.relative_to(ROOT).as_posix())
    return sorted(files)


def entry_points_without(*modules):
    """The entry points of pyproject.toml but for those that name what is in one of ``modules``."""
    gone = tuple(f"{module}{after}" for module in modules for after in ".:")
    project = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]
    return {
        group: {name: value for name, value in points.items() if not value.startswith(gone)}
        for group, points in project["entry-points"].items()
    }


def tree_without(package, plugins, folder):
    """Copy what is needed of this tree into ``folder`` without some plug-ins, their entry points and their tests."""
    gone = {f"{place}/{package}/plugins/{plugin}" for place in (ROOT, ROOT / "tests") for plugin in plugins}
    for name in (package, "tests"):  # with compiled files, which stay valid
        shutil.copytree(
            ROOT / name, folder / name, ignore=lambda at, names: [n for n in names if f"{at}/{n}" in gone or n == "ros"]
        )
    beside = {*PACKAGES, "_fuzzyfleet.py", "kernels", "datasets", "docs", "examples", "pyproject.toml", "README.md"}
    for name in beside - {package}:
        (folder / name).symlink_to(ROOT / name)
    left = entry_points_without(*(f"{package}.plugins.{name}" for name in plugins))
    declare(folder, "fuzzyfleet", left, requires("fuzzyfleet"))
    return folder


def run_in(tree, *words):
    """Run Python with the modules of ``tree``."""
    done = subprocess.run(
        [sys.executable, *words],
        cwd=tree,
        env=os.environ | {"PYTHONPATH": str(tree)},
        capture_output=True,
        text=True,
        check=False,
        timeout=1200,
    )
    assert done.returncode == 0, done.stdout[-3000:] + done.stderr[-3000:]
    return done.stdout


# Seconds each: one, and the others with the long tests.
DEAR = [pytest.param(*each, marks=() if each[1] == "mamdani" else pytest.mark.long) for each in PLUGINS]


@pytest.mark.parametrize(("package", "plugin"), DEAR)
def test_the_core_stands_without(package, plugin, tmp_path):
    tree = tree_without(package, [plugin], tmp_path)
    users = " ".join(users_of(package, plugin))
    said = run_in(tree, "-c", LEFT, package, plugin, users, *QUIET, "--noconftest", *CORE_TESTS[package])
    lost, shown = json.loads(said.partition("\n")[0])
    module = f"{package}.plugins.{plugin}"
    for name, sentence in lost.items():
        assert sentence == f"{package}.{name} needs the plug-in {module}, which is not installed"
    stub = (ROOT / package / "__init__.pyi").read_text(encoding="utf-8")
    assert len(lost) == stub.count(f"from {module}.")
    left = entry_points_without(module)["fuzzyfleet.commands"]
    commands = {name.rpartition(".")[2] for name in left if name.startswith(f"{package}.")}
    listed = {*re.findall(r"^  ([\w-]+) ", shown, re.M), *re.findall(r"[\w-]+", shown.rpartition("--help):")[2])}
    assert commands <= listed
    project = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]
    for name in set(project["entry-points"]["fuzzyfleet.commands"]) - set(left):
        assert name.rpartition(".")[2] not in listed


@pytest.mark.long  # a minute each
@pytest.mark.parametrize("package", PACKAGES)
def test_all_tests_of_the_core_pass_without_any(package, tmp_path):
    plugins = PLUGINS_OF[package]
    ignored = {f"--ignore={file}" for plugin in plugins for file in other_tests_of(package, plugin)}
    run_in(tree_without(package, plugins, tmp_path), "-m", "pytest", *QUIET, *ALL_CORE_TESTS[package], *sorted(ignored))


def test_the_sentences_of_the_core_know_nothing_of_the_thesis():
    """It is a study of the engine; where code and numbers come from is said in docstrings, comments and sources."""
    said = []
    for file in sorted(file for package in PACKAGES for file in (ROOT / package).rglob("*.py")):
        if "plugins" in file.relative_to(ROOT).parts:
            continue
        tree = ast.parse(file.read_text(encoding="utf-8"))
        bodies = [node.body for node in ast.walk(tree) if isinstance(node, (ast.Module, ast.ClassDef, ast.FunctionDef))]
        help_of_commands = file.parent.name == "commands"
        docs = {id(body[0].value) for body in bodies if body and isinstance(body[0], ast.Expr) and not help_of_commands}
        texts = [str(node.value) for node in ast.walk(tree) if isinstance(node, ast.Constant) and id(node) not in docs]
        said += [f"{file}: {text}" for text in texts if re.search("(?i)thesis.* | .*thesis", text)]
    for file in (file for package in PACKAGES for file in (ROOT / package).rglob("*.j2")):
        said += [str(file)] * ("thesis" in file.read_text(encoding="utf-8").lower())
    assert [line for line in said if "robotics/__init__.py" not in line] == []  # but for names of modules


# A stranger's ----------------------------------------------------------------------------------------------------

PACKAGE = '''
"""Chalk lines: a command, a panel of the designer and a law in one package."""

from dataclasses import dataclass
from pathlib import Path
from typing import Annotated

import numpy as np

from fuzzy.commands.shared import FisFile, read_system
from fuzzy.shell.options import Json, option
from fuzzy.shell.terminal import print_json
from robotics.laws.law import Command, ControllerError, Law
from robotics.quantity import check_quantities, quantity


def count(
    file: FisFile,
    least: Annotated[int, option("Count rules of at least so many clauses.", min=1)] = 1,
    json: Json = False,
) -> None:
    """Count the rules of a system.

    \\b
    Example:
      fuzzy count tracking
    """
    rules = [rule for rule in read_system(file).rules if len(rule.when) >= least]
    if json:
        print_json({"rules": len(rules)})
    else:
        print(f"{len(rules)} rules")


class Rules:
    """A tab that says how many rules there are."""

    title, order = "Chalk", 90

    def build(self, bench):
        def say():
            bench.notify(f"{len(bench.document.design.system.rules)} rules in chalk")

        bench.on_change(say)
        say()


@dataclass(frozen=True, kw_only=True)
class Chalk(Law[None]):
    """Drive at the reference's speed and turn towards it."""

    gain: float = quantity(2.0, "1/s", above=0)

    def __post_init__(self):
        check_quantities(self, ControllerError)

    def control(self, seen, memory, dt):
        reference = seen.reference
        bearing = np.arctan2(reference.y - seen.y, reference.x - seen.x) - seen.heading
        w = np.clip(self.gain * np.sin(bearing), -2.0, 2.0)
        v = np.broadcast_to(reference.v, seen.x.shape)
        return Command(v, w, v, w), None
'''
POINTS = {
    "fuzzyfleet.commands": {"fuzzy.look.count": "chalk:count", "robotics.look.count": "chalk:count"},
    "fuzzyfleet.designer": {"chalk": "chalk:Rules"},
    "fuzzyfleet.laws": {"chalk": "chalk:Chalk"},
}


@pytest.fixture
def chalk(site, monkeypatch):
    """The package, installed."""
    from robotics.laws import catalogue

    (site / "chalk.py").write_text(PACKAGE, encoding="utf-8")
    declare(site, "chalk-lines", POINTS)
    catalogue._installed.cache_clear()
    yield
    monkeypatch.undo()
    catalogue._installed.cache_clear()
    sys.modules.pop("chalk", None)


def test_a_package_of_sixty_lines_adds_a_command_a_panel_and_a_law(chalk, tmp_path, monkeypatch, capsys):
    from fuzzy.commands.application import main as fuzzy_main
    from robotics.commands.application import main as robotics_main

    assert len([line for line in PACKAGE.splitlines() if line.strip()]) <= 60
    for main in (fuzzy_main, robotics_main):
        assert main(["--help"]) == 0
        assert "  count " in capsys.readouterr().out
        assert main(["count", "tracking", "--json"]) == 0
        assert json.loads(capsys.readouterr().out) == {"rules": len(tracking().rules)}
        assert main(["count", "tracking", "--least", "0"]) == 2
    monkeypatch.chdir(tmp_path)
    assert robotics_main(["run", "fuzzy-on-path", "-c", "chalk:gain=1.5", "--json", "-q"]) == 0
    result = json.loads(capsys.readouterr().out)
    assert result["controller"] == "chalk:gain=1.5"
    assert 0 < result["metrics"]["rms_cross_track_m"][0] < 1.0
    assert said_by_the_panel(tmp_path, "Chalk") == [f"{len(tracking().rules) - n} rules in chalk" for n in (0, 1)]


def tracking():
    from robotics.laws.tracking.fuzzy_tracking import load_rule_base

    return load_rule_base("tracking")


def said_by_the_panel(folder, title):
    """What the panel of this title says of a system when it is built, and after an edit."""
    from fuzzy.files.fisfile import write_fis
    from fuzzy.plugins.designer.folder import open_folder
    from fuzzy.plugins.designer.modules import Modules
    from fuzzy.plugins.designer.open_documents import OpenDocuments
    from fuzzy.plugins.designer.panel import Workbench, find_panels
    from tests.browsers import run_apart

    (panel,) = [panel for panel in find_panels()[0] if panel.title == title]
    write_fis(tracking(), folder / "a.fis")
    said = []

    async def work():
        opened = OpenDocuments(open_folder(folder))
        document = opened.document("a.fis")
        bench = Workbench(document, opened.workers, Modules().url, lambda *what: said.append(what[0]))
        panel.build(bench)
        document.apply({"edit": "remove_rule", "key": document.design.lines[0].key})
        await bench.changed()
        opened.close()

    run_apart(work())
    return said
