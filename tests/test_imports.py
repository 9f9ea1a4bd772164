"""The directions of imports: packages on floors, rooms on a stair; and what an import may not bring along."""

import ast
import re
import subprocess
import sys
import tomllib
from collections.abc import Iterator
from functools import cache
from importlib.util import find_spec
from pathlib import Path
from typing import NamedTuple

import pytest

ROOT = Path(__file__).parent.parent
OURS = ("fuzzy", "anfis", "robotics", "datasets", "tests", "benchmarks")
FLOORS = {"fuzzy": ("fuzzy",), "anfis": ("fuzzy", "anfis"), "robotics": ("fuzzy", "anfis", "robotics")}
# The rooms of a package, folders and modules, on their stair: each imports from itself and from those before it only.
STAIRS = {
    "fuzzy": """
        renamed lazynames notebookfigures errors entrypoints extras quantity naming words shown sketch
        esmodule profile
        membershipfunction membership rule language system inference detached files compiled insight fitting
        tuning shell figures commands plugins.ccode plugins.mamdani plugins.type2 plugins.designer plugins.trees
        plugins.tuning plugins.front plugins.loop
    """,
    "anfis": """
        data point premises parameters consequents network type2network compiled state methods checkpoint accuracy
        training folds intervals pruning plot commands plugins.designer plugins.regressor
    """,
    "robotics": """
        tables world laws simulation measures studies show commands plugins.encounters plugins.reactive
        plugins.predictive plugins.arena plugins.stress plugins.tuning plugins.datasheets
        plugins.learning plugins.ccode plugins.certificates plugins.designer plugins.logs plugins.reinforcement
        plugins.thesis plugins.ablation plugins.shapes plugins.tasks plugins.identify plugins.films
        plugins.mujoco plugins.teampolicy
    """,
    "robotics.world": "random_streams vehicle paths radio environment sensing",
    "robotics.laws": """
        knowledge setting modes specification law equation universe foreign tracking formation teams avoidance
        rules presets catalogue
    """,
    "robotics.simulation": """
        scenario safety lanes steps physics channels observer opening layout run spans mode_changes recorder loop
    """,
    "robotics.measures": """
        statistics once standing outside clearance decisions progress tracking goals evidence explained arrival contacts
        formations own leading teams avoidance registry quantities
    """,
    "robotics.studies": """
        executors pieces versions chunks population together comparison forewarnings ruledemands inspection design axes
        keptcomparison tuning
    """,
    "robotics.show": "figures playback report",
}
CIRCLE = ("fuzzy.system", "fuzzy.inference")  # a system can be called: fis(x) infers, by one lazy line
# Rooms whose functions may import what they need: commands answer --help quickly, the designer is an optional extra.
LAZY_ROOMS = ("commands", "designer", "plugins")
APART = "plugins"  # a folder whose rooms stand on the stair one by one
# The plug-ins of a plug-in: panels are made with the interface of the designer, and found by it.
PLUGINS_OF: dict[str, dict[str, tuple[str, ...]]] = {
    "fuzzy": {
        "ccode": (),
        "designer": ("mamdani", "type2"),
        "front": (),
        "loop": ("ccode", "designer"),
        "mamdani": (),
        "trees": ("ccode", "designer"),
        "tuning": ("trees", "type2"),
        "type2": ("ccode",),
    },
    "anfis": {"designer": (), "regressor": ()},
    "robotics": {
        "ablation": ("stress",),
        "arena": (),
        "ccode": (),
        "certificates": (),
        "datasheets": (),
        "designer": ("learning", "tuning"),
        "encounters": (),
        "films": (),
        "identify": ("logs",),
        "learning": ("stress",),
        "shapes": (),
        "logs": ("learning",),
        "mujoco": ("films",),
        "predictive": ("reactive",),
        "reactive": (),
        "reinforcement": ("arena",),
        "stress": (),
        "tasks": ("arena", "stress"),
        "teampolicy": ("reactive", "reinforcement", "stress", "tasks"),
        "thesis": ("certificates", "encounters", "learning", "stress"),
        "tuning": (),
    },
}


class Arrow(NamedTuple):
    """One import: of ``target``, a module, by ``source``."""

    source: str
    target: str
    line: int
    lazy: bool  # inside a function


def arrows(root: Path, package: str) -> list[Arrow]:
    """Every import of our modules in ``package`` (a dotted name below ``root``), also those for type checkers."""
    files = sorted(f for end in ("py", "pyi") for f in (root / package.replace(".", "/")).rglob(f"*.{end}"))
    return [arrow for file in files for arrow in _arrows_in(root, file, file.read_text(encoding="utf-8"))]


def statements(node: ast.AST, inside: bool = False) -> Iterator[tuple[ast.AST, bool]]:
    """The statements below a node, and whether each is inside a function; expressions are not looked at."""
    for child in ast.iter_child_nodes(node):
        if isinstance(child, (ast.stmt, ast.ExceptHandler, ast.match_case)):
            yield child, inside
            yield from statements(child, inside or isinstance(child, ast.FunctionDef))


@cache
def _arrows_in(root: Path, file: Path, text: str) -> list[Arrow]:
    """The imports of one file; the same file is asked for by several tests."""
    found: list[Arrow] = []
    source = ".".join(file.relative_to(root).with_suffix("").parts)
    for node, lazy in statements(ast.parse(text)):
        if not isinstance(node, (ast.Import, ast.ImportFrom)):
            continue
        names = [alias.name for alias in node.names]
        if isinstance(node, ast.ImportFrom):
            assert node.level == 0, f"{file}: relative import"
            module = node.module or ""
            whole = [f"{module}.{alias.name}" for alias in node.names]
            names = [n if (root / n.replace(".", "/")).with_suffix(".py").is_file() else module for n in whole]
        found += [Arrow(source, n, node.lineno, lazy) for n in names if n.partition(".")[0] in OURS]
    return found


def room_of(module: str, package: str) -> str:
    """The room of ``package`` in which a module of it stands."""
    first, _, rest = module.removeprefix(f"{package}.").partition(".")
    return f"{first}.{rest.partition('.')[0]}" if first == APART and rest != "__init__" else first


def arrows_up(root: Path, package: str, stair: list[str]) -> list[str]:
    """The imports in ``package`` that run up its ``stair``, and rooms that are not on it, in words."""
    place, wrong = {room: k for k, room in enumerate(stair)}, []
    for arrow in arrows(root, package):
        if not arrow.target.startswith(f"{package}."):
            continue
        rooms = [room_of(name, package) for name in (arrow.source, arrow.target)]
        if rooms[0] in ("__init__", "__main__"):
            continue
        unlisted = [room for room in rooms if room not in place]
        if unlisted:
            wrong.append(f"{package}.{unlisted[0]} is not on the stair")
        elif place[rooms[1]] > place[rooms[0]] and (arrow.source, arrow.target) != CIRCLE:
            wrong.append(f"{arrow.source}:{arrow.line} imports {arrow.target}, which stands after it on the stair")
    return sorted(set(wrong))


def circles(root: Path, packages: tuple[str, ...]) -> list[set[str]]:
    """The groups of modules that import each other, directly or over others."""
    graph: dict[str, set[str]] = {}
    for package in packages:
        for arrow in arrows(root, package):
            graph.setdefault(arrow.source.removesuffix(".__init__"), set()).add(arrow.target)
    reach = {name: {name} for name in graph}
    changed = True
    while changed:
        changed = False
        for known in reach.values():
            more = set().union(*(reach.get(t, {t}) for n in list(known) for t in graph.get(n, ()))) - known
            if more:
                known |= more
                changed = True
    found = []
    for name in graph:
        ring = {other for other in reach[name] if other != name and name in reach.get(other, ())} | {name}
        if len(ring) > 1 and ring not in found:
            found.append(ring)
    return found


@pytest.mark.parametrize("package", FLOORS)
def test_packages_import_down_only(package):
    found = arrows(ROOT, package)
    assert found
    for arrow in found:
        assert arrow.target.partition(".")[0] in FLOORS[package], f"{arrow.source}:{arrow.line} imports {arrow.target}"


@pytest.mark.parametrize("package", STAIRS)
def test_no_import_runs_up_the_stair(package):
    assert arrows_up(ROOT, package, STAIRS[package].split()) == []


def test_every_room_stands_on_the_stair():
    for package, stair in STAIRS.items():
        folder = ROOT / package.replace(".", "/")
        modules = {f.stem for f in folder.glob("*.py")} | {f.parent.name for f in folder.glob("*/__init__.py")}
        apart = {f"{APART}.{f.parent.name}" for f in folder.glob(f"{APART}/*/__init__.py")}
        assert (modules | apart) - {"__init__", "__main__", APART} == set(stair.split())


def test_only_the_system_and_its_inference_make_a_circle():
    assert circles(ROOT, tuple(FLOORS)) == [set(CIRCLE)]


def test_no_lazy_import_hides_an_arrow():
    hidden = [
        f"{arrow.source}:{arrow.line} imports {arrow.target} inside a function"
        for package in FLOORS
        for arrow in arrows(ROOT, package)
        if arrow.lazy
        and not {*LAZY_ROOMS} & {*arrow.source.split(".")[1:-1]}
        and (arrow.source, arrow.target) != CIRCLE
    ]
    assert hidden == []


def test_the_core_imports_no_plugin():
    """Names of the package that live in a plug-in come by the lazy stub, the one place that may say where they are."""
    wrong = [
        f"{arrow.source}:{arrow.line} imports {arrow.target}"
        for package in PLUGINS_OF
        for arrow in arrows(ROOT, package)
        if arrow.target.split(".")[1:2] == [APART] and not arrow.source.startswith(f"{package}.plugins.")
    ]
    stubs = [f"{package}.__init__:" for package in PLUGINS_OF]
    assert [line for line in wrong if not line.startswith(tuple(stubs))] == []


def test_plugins_import_only_those_that_they_are_for():
    for package, plugins in PLUGINS_OF.items():
        assert set(plugins) == {file.parent.name for file in (ROOT / package / "plugins").glob("*/__init__.py")}
        for name, allowed in plugins.items():
            for arrow in arrows(ROOT, f"{package}.plugins.{name}"):
                if arrow.target.startswith(f"{package}.plugins."):
                    assert arrow.target.split(".")[2] in (name, *allowed), f"{arrow.source} imports {arrow.target}"


def test_what_is_wrong_with_a_tree_is_seen(tmp_path):
    for name, text in {
        "fuzzy/low/__init__.py": "",
        "fuzzy/low/one.py": "def f():\n    from fuzzy.high.two import x\n",
        "fuzzy/high/__init__.py": "",
        "fuzzy/high/two.py": "from fuzzy.low import one\nfrom fuzzy.attic import y\n",
        "fuzzy/attic.py": "y = 1\n",
    }.items():
        (tmp_path / name).parent.mkdir(parents=True, exist_ok=True)
        (tmp_path / name).write_text(text, encoding="utf-8")
    assert arrows_up(tmp_path, "fuzzy", ["low", "high"]) == [
        "fuzzy.attic is not on the stair",
        "fuzzy.low.one:2 imports fuzzy.high.two, which stands after it on the stair",
    ]
    assert circles(tmp_path, ("fuzzy",)) == [{"fuzzy.low.one", "fuzzy.high.two"}]
    assert [a.lazy for a in arrows(tmp_path, "fuzzy") if a.source == "fuzzy.low.one"] == [True]


@pytest.mark.parametrize(
    ("statement", "heavy"),
    [
        ("import fuzzy, anfis, robotics", {"numpy", "torch", "matplotlib", "pandas", "numba", "skfuzzy", "scipy"}),
        ("import fuzzy.commands.application", {"torch", "matplotlib", "pandas", "numba", "skfuzzy", "scipy"}),
        (
            "import robotics.commands.application",
            {"torch", "matplotlib", "pandas", "numba", "skfuzzy", "scipy", "cvxpy", "pyarrow", "distributed"},
        ),
        ("import fuzzy, fuzzy.commands.application, robotics.commands.application", {"fuzzy.plugins"}),
        ("import robotics; robotics.simulate", {"torch", "matplotlib", "skfuzzy", "jinja2"}),
    ],
)
def test_an_import_stays_light(statement, heavy):
    code = f"{statement}; import sys; print(*sorted(set({heavy!r}) & set(sys.modules)))"
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True, timeout=60)
    assert done.stdout.strip() == ""


@pytest.mark.parametrize("program", FLOORS)
def test_help_waits_for_no_large_package(program):
    heavy = {
        *(
            "numpy",
            "torch",
            "matplotlib",
            "pandas",
            "pyarrow",
            "numba",
            "skfuzzy",
            "scipy",
            "networkx",
            "jinja2",
            "rich",
        ),
        *("gymnasium", "cvxpy", "distributed", "control", "nicegui", "sklearn", "rosbags"),
    }
    code = (
        f"from {program}.commands.application import main; import sys; main(['--help'])\n"
        f"print('brought', *{heavy!r} & {{*sys.modules}})"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True, timeout=60)
    assert done.stdout.endswith("\nbrought\n")


@pytest.mark.parametrize(
    "module", ["robotics.laws.teams.graph_sliding_mode", "robotics.laws.catalogue", "robotics.world.sensing.posture"]
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


@pytest.mark.long
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
