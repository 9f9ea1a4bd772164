"""Machine code kept on disk: never that of an earlier version of anything it was made of."""

import ast
import os
import shutil
import subprocess
import sys
from pathlib import Path

import pytest
from numba import config

from fuzzy.compiled.jit import fingerprint, kernel

ROOT = Path(__file__).parents[3]
PACKAGES = ("fuzzy", "anfis", "robotics")

# One kernel in callers.py for each thing outside its file that its machine code is made of.
CALLERS = """
from fuzzy.compiled.jit import kernel
from toy import values
from toy.values import GAIN, TABLE, Pair, divided, middle, outer

@kernel
def by_body(x):
    return middle(x)

@kernel
def by_constant(x):
    return GAIN * x

@kernel
def by_array(x):
    return TABLE[1] * x

@kernel
def by_module(x):
    return values.OFFSET + x

@kernel
def by_names(x):
    return outer(first=x, second=1.0)

@kernel
def by_default(x):
    return divided(x)

@kernel
def by_field(pair):
    return pair.left

@kernel
def untouched(x):
    return x

kernels = [by_body, by_constant, by_array, by_module, by_names, by_default, by_field, untouched]
"""
VALUES = """
from typing import NamedTuple
import numpy as np
from fuzzy.compiled.jit import kernel

GAIN, OFFSET, TABLE = 2.0, 10.0, np.array([0.0, 3.0])

class Pair(NamedTuple):
    left: float
    right: float

@kernel
def inner(x):
    return x + 1.0

@kernel
def middle(x):
    return inner(x)

@kernel
def outer(first, second):
    return first - second

@kernel
def divided(x, by=2.0):
    return x / by
"""
CHANGES = (
    ("x + 1.0", "x + 5.0"),
    ("GAIN, OFFSET, TABLE = 2.0, 10.0, np.array([0.0, 3.0])", "GAIN, OFFSET, TABLE = 3.0, 20.0, np.array([0.0, 7.0])"),
    ("    left: float\n    right: float\n", "    right: float\n    left: float\n"),
    # Another order of the arguments, the same bytecode.
    ("def outer(first, second):\n    return first - second", "def outer(second, first):\n    return second - first"),
    ("by=2.0", "by=8.0"),
)
RUN = """
from toy.callers import Pair, kernels
print(*(k(Pair(left=4.0, right=9.0) if k.__name__ == "by_field" else 4.0) for k in kernels))
print(*(sum(k.stats.cache_hits.values()) for k in kernels))
"""

compiled = pytest.mark.skipif(config.DISABLE_JIT, reason="nothing is compiled (NUMBA_DISABLE_JIT)")  # type: ignore[attr-defined]


def changed(text, changes):
    for old, new in changes:
        assert text.count(old) == 1, old
        text = text.replace(old, new)
    return text


def python(code, folder, **environment):
    """The words that a new process prints, which imports from a folder first."""
    path = os.pathsep.join([str(folder), str(ROOT)])
    inherited = {name: value for name, value in os.environ.items() if name != "NUMBA_CACHE_DIR"}
    environment = inherited | {"PYTHONPATH": path, "PYTHONDONTWRITEBYTECODE": "1"} | environment
    command = [sys.executable, "-c", code]
    done = subprocess.run(command, cwd=folder, env=environment, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    return [[float(word) for word in line.split()] for line in done.stdout.splitlines()]


@pytest.fixture
def toy(tmp_path):
    (tmp_path / "toy").mkdir()
    (tmp_path / "toy" / "__init__.py").touch()
    (tmp_path / "toy" / "callers.py").write_text(CALLERS, encoding="utf-8")
    (tmp_path / "toy" / "values.py").write_text(VALUES, encoding="utf-8")
    return tmp_path


@pytest.mark.long
@compiled
def test_what_a_kernel_is_made_of_in_another_file_may_change(toy):
    before, fresh = python(RUN, toy)
    assert before == [5, 8, 12, 14, 3, 2, 4, 4]
    assert fresh == [0] * 8
    assert python(RUN, toy) == [before, [1] * 8]

    (toy / "toy" / "values.py").write_text(changed(VALUES, CHANGES), encoding="utf-8")
    after, hits = python(RUN, toy)
    assert after == [9, 12, 28, 24, -3, 0.5, 4, 4]
    assert hits == [0] * 7 + [1]


@pytest.mark.long
@compiled
def test_a_named_tuple_may_move_to_another_module(toy):
    """The files that name its former module are not read: it may be gone."""
    call = (
        "from toy.callers import by_field\nfrom toy.{} import Pair\n"
        "print(by_field(Pair(4.0, 9.0)), *by_field.stats.cache_hits.values())"
    )
    assert python(call.format("values"), toy) == [[4]]
    pair = VALUES[VALUES.index("class Pair") : VALUES.index("@kernel")]
    (toy / "toy" / "pairs.py").write_text(f"from typing import NamedTuple\n{pair}", encoding="utf-8")
    (toy / "toy" / "values.py").write_text(VALUES.replace(pair, "from toy.pairs import Pair\n"), encoding="utf-8")
    assert python(call.format("pairs"), toy) == [[4]]
    assert python(call.format("pairs"), toy) == [[4, 1]]


@pytest.mark.long
@compiled
def test_a_line_more_above_a_kernel_compiles_nothing_anew(toy):
    first, _ = python(RUN, toy)
    (toy / "toy" / "values.py").write_text("# Values.\n" + VALUES, encoding="utf-8")
    assert python(RUN, toy) == [first, [1] * 8]


@compiled
@pytest.mark.parametrize(
    "inside", [True, pytest.param(False, marks=pytest.mark.long)], ids=["__pycache__", "NUMBA_CACHE_DIR"]
)
def test_old_files_go(toy, inside):
    environment = {} if inside else {"NUMBA_CACHE_DIR": str(toy / "elsewhere")}
    python(RUN, toy, **environment)
    holder = toy / ("toy" if inside else "elsewhere")
    first = {file.name: file for file in holder.rglob("*.nb?")}
    assert sum(name.startswith("values.inner-") for name in first) == 1
    folder = first[min(first)].parent
    tag = f"py{sys.version_info[0]}{sys.version_info[1]}"
    former = [f"values.inner-9.{tag}.nbi", f"values.inner-9.{tag}.1.nbc", f"values.renamed-1.{tag}.1.nbc"]
    others = ["values.inner-9.py27.nbi", f"neighbour.inner-9.{tag}.nbi"]
    for name in former + others:
        (folder / name).touch()

    (toy / "toy" / "values.py").write_text(changed(VALUES, CHANGES[:1]), encoding="utf-8")
    python(RUN, toy, **environment)
    second = {file.name for file in holder.rglob("*.nb?")}
    assert set(others) <= second
    assert not set(former) & second
    remade = {name.partition("-")[0] for name in second - set(first) - set(others)}
    assert remade == {"values.inner", "values.middle", "callers.by_body"}
    assert len(second) == len(first) + len(others)


@pytest.mark.long
@compiled
def test_a_copy_of_the_package_sees_a_change_in_a_callee(tmp_path):
    for package in PACKAGES:
        shutil.copytree(ROOT / package, tmp_path / package, ignore=shutil.ignore_patterns("__pycache__"))
    shutil.copy(ROOT / "_fuzzyfleet.py", tmp_path)
    code = (
        "from robotics.world.paths.joined import join_paths\n"
        "from robotics.world.paths.path import Line, compile_path\n"
        "print(join_paths([compile_path(Line(start=(0.0, 0.0), end=(3.0, 0.0)))]).at([2.0]).x[0])"
    )
    assert python(code, tmp_path) == [[pytest.approx(2)]]
    callee = tmp_path / "robotics" / "world" / "paths" / "path.py"
    edit = ("    return x, y, heading, ", "    return x + 100, y, heading, ")
    callee.write_text(changed(callee.read_text(encoding="utf-8"), [edit]), encoding="utf-8")
    assert python(code, tmp_path) == [[pytest.approx(102)]]


@pytest.mark.parametrize("package", PACKAGES)
def test_kernels_are_compiled_by_this_decorator_only(package):
    names = set()
    texts = {file: file.read_text(encoding="utf-8") for file in (ROOT / package).rglob("*.py")}
    for file, text in texts.items():
        for node in ast.walk(ast.parse(text)) if "numba" in text else ():
            modules = [alias.name for alias in node.names] if isinstance(node, ast.Import) else []
            modules += [node.module or ""] if isinstance(node, ast.ImportFrom) else []
            if any(module.partition(".")[0] == "numba" for module in modules):
                names.add(file.relative_to(ROOT).as_posix())
    # columns.py teaches Numba what a struct of columns is; it compiles nothing
    assert names <= {f"fuzzy/compiled/{name}.py" for name in ("jit", "columns", "vectors")}


class Hidden:
    """Something whose content no fingerprint can hold."""


HIDDEN, MIXED = Hidden(), {"a": 1}


@compiled
@pytest.mark.parametrize("name", ["HIDDEN", "MIXED", "Hidden"])
def test_what_cannot_be_seen_is_refused(name):
    scope = dict(globals())
    exec(compile(f"def f(x):\n    return {name}", __file__, "exec"), scope)
    with pytest.raises(TypeError, match=r"\.f cannot be kept on disk: a change of .* would go unseen"):
        kernel(scope["f"])(1.0)


@compiled
def test_a_fingerprint_tells_callees_apart():
    def make(factor):
        return kernel(lambda x: factor * x)

    def pair(first, second):
        return kernel(lambda x: first(x) - second(x))

    two, three = make(2.0), make(3.0)
    prints = [fingerprint(f) for f in (two, three, pair(two, three), pair(three, two), pair(two, two))]
    assert len(set(prints)) == 5
    assert fingerprint(make(2.0)) == prints[0]
    assert fingerprint(pair(make(2.0), make(3.0))) == prints[2]
    assert fingerprint(kernel(two.py_func, nogil=True)) != prints[0]


@compiled
def test_a_function_that_calls_itself_has_a_fingerprint():
    @kernel
    def down(n):
        return 0 if n == 0 else down(n - 1) + 2

    assert down(5) == 10
    assert fingerprint(down) == fingerprint(down)


def test_a_callee_is_put_into_its_callers_only_where_it_says_so_itself(tmp_path, monkeypatch):
    """Numba hands ``forceinline`` on from the caller for which a function is compiled first."""
    monkeypatch.setattr(config, "CACHE_DIR", str(tmp_path))  # empty: what comes from the disk names no callees

    @kernel
    def called(x):
        return 2.0 * x

    @kernel(forceinline=True)
    def between(x):
        return called(x)

    @kernel
    def caller(x):
        return between(x)

    assert caller(3.0) == 6.0
    codes = [next(iter(of.overloads.values())).library.get_llvm_str() for of in (called, between)]
    assert ["alwaysinline" in code for code in codes] == [False, True]
