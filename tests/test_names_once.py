"""One name for one thing: no public class, and no public constant of a module, stands for two things in the tree."""

import ast
from collections import defaultdict
from functools import cache
from pathlib import Path

import pytest

ROOT = Path(__file__).parent.parent
PACKAGES = ("fuzzy", "anfis", "robotics", "ros")


@cache
def parsed(text: str) -> list[ast.stmt]:
    """What a module has at its top, without what its functions and classes hold."""
    kinds = (ast.ClassDef, ast.Assign, ast.AnnAssign)
    top = [node for node in ast.parse(text).body if isinstance(node, kinds)]
    for node in top:
        if isinstance(node, ast.ClassDef):
            node.body = []
    return list(top)


def defined(body: list[ast.stmt], classes: bool) -> set[str]:
    """The public classes that a module defines at its top, or its public constants, in capitals; imports are none."""
    if classes:
        return {node.name for node in body if isinstance(node, ast.ClassDef) and node.name[0] != "_"}
    names = set()
    for node in body:
        if isinstance(node, ast.Assign) and ast.unparse(node.value).startswith("TypeVar("):
            continue  # it stands for any type
        targets = node.targets if isinstance(node, ast.Assign) else []
        targets = [node.target] if isinstance(node, ast.AnnAssign) else targets
        for target in targets:
            each = target.elts if isinstance(target, ast.Tuple) else [target]
            names |= {one.id for one in each if isinstance(one, ast.Name) and one.id.isupper() and one.id[0] != "_"}
    return names


def several(root: Path, classes: bool) -> dict[str, list[str]]:
    """The names that more than one module below ``root`` defines, with these modules."""
    found: dict[str, list[str]] = defaultdict(list)
    for package in PACKAGES:
        for file in sorted((root / package).rglob("*.py")):
            for name in defined(parsed(file.read_text(encoding="utf-8")), classes):
                found[name].append(str(file.relative_to(root)))
    return {name: files for name, files in sorted(found.items()) if len(files) > 1}


def test_a_class_has_a_name_of_its_own():
    assert several(ROOT, classes=True) == {}


def test_a_constant_has_a_name_of_its_own():
    assert several(ROOT, classes=False) == {}


@pytest.mark.parametrize("classes", [True, False])
def test_a_name_that_two_modules_define_is_found(tmp_path, classes):
    for name, text in {
        "fuzzy/one.py": "class Plan: ...\nclass Own: ...\nclass _Hidden: ...\nMOST, FEW = range(2)\n_LEAST = 1\n",
        "robotics/two.py": "from fuzzy.one import Own, FEW\nclass Plan: ...\nclass _Hidden: ...\nMOST: int = 9\n",
        "ros/three.py": "def f():\n    MOST = 1\n    class Own: ...\n",
    }.items():
        (tmp_path / name).parent.mkdir(exist_ok=True)
        (tmp_path / name).write_text(text, encoding="utf-8")
    assert several(tmp_path, classes) == {"Plan" if classes else "MOST": ["fuzzy/one.py", "robotics/two.py"]}
