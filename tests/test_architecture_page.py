"""The page docs/architecture.md: its numbers are measured; `python -m tests.test_architecture_page` writes them."""

import ast
import re
from functools import cache
from pathlib import Path

from tests.test_imports import APART, FLOORS, ROOT, arrows, room_of, statements

PAGE = ROOT / "docs" / "architecture.md"
BEGIN, END = "<!-- measured -->\n", "<!-- end of measured -->"


def code_lines(file: Path) -> int:
    """The lines of a file without blanks, comments and docstrings."""
    text, docs, strings = file.read_text(encoding="utf-8"), set[int](), set[int]()
    rows, tree = text.split("\n"), ast.parse(text)
    for node, _ in ((tree, False), *statements(tree)):
        if isinstance(node, (ast.Module, ast.ClassDef, ast.FunctionDef)):
            if ast.get_docstring(node) is not None:
                docs.update(range(node.body[0].lineno, (node.body[0].end_lineno or 0) + 1))
        elif isinstance(node, ast.stmt) and any('"""' in row for row in rows[node.lineno - 1 : node.end_lineno]):
            for part in ast.walk(node):
                if isinstance(part, (ast.Constant, ast.JoinedStr)):
                    strings.update(range(part.lineno, (part.end_lineno or 0) + 1))  # in which everything counts
    lines = {k for k, line in enumerate(rows, 1) if line.strip() and not line.lstrip().startswith("#")}
    return len((lines | strings) - docs)


@cache
def loops_over_periods() -> list[str]:
    """The functions of the simulation that call the step `sense` within a loop, or by a method of their own."""
    found = []
    for file in sorted((ROOT / "robotics").rglob("*.py")):
        text = file.read_text(encoding="utf-8")
        for function in ast.walk(ast.parse(text)) if "sense" in text and "move" in text else ():
            if isinstance(function, ast.FunctionDef):
                loops = [n for n in ast.walk(function) if isinstance(n, (ast.For, ast.While))]
                called = [n.func for loop in loops for n in ast.walk(loop) if isinstance(n, ast.Call)]
                names = {getattr(f, "id", getattr(f, "attr", "")) for f in called}
                if "sense" in names and "move" in names:
                    found.append(f"{file.relative_to(ROOT).as_posix()}: {function.name}")
    return found


def measured() -> str:
    """The sentences of the page that are made of the tree."""
    pairs = set()
    for arrow in arrows(ROOT, "robotics"):
        if arrow.target.startswith("robotics."):
            rooms = [room_of(name, "robotics") for name in (arrow.source, arrow.target)]
            if rooms[0] not in ("__init__", "__main__", rooms[1]):
                pairs.add(tuple(rooms))
    found = {room for pair in pairs for room in pair}
    lines = {name: sum(map(code_lines, (ROOT / name).rglob("*.py"))) for name in ("fuzzy", "anfis", "robotics", "ros")}
    said = ", ".join(f"`{name}/` {round(number, -2):,}" for name, number in lines.items())
    apart = sum(code_lines(f) for name in FLOORS for f in (ROOT / name / APART).rglob("*.py")) + lines["ros"]
    loops = "; ".join(f"`{where}`" for where in loops_over_periods())
    return (
        f"`robotics/` has {len(found)} rooms and {len(pairs)} arrows between them, none runs up, no circle. Lines of "
        f"code to the nearest hundred,\nwithout blanks, comments and docstrings: {said}; of all\n"
        f"{round(sum(lines.values()) - apart, -2):,} are no plug-in, which `ros/` is, too.\n"
        f"The loop over periods, compiled and for laws of arrays: {loops}.\n"
    )


def test_the_numbers_of_the_page_are_those_of_the_tree():
    text = PAGE.read_text(encoding="utf-8")
    said = text[text.index(BEGIN) + len(BEGIN) : text.index(END)]
    assert said == measured(), "python -m tests.test_architecture_page writes them anew"


def test_there_are_two_loops_over_periods():
    assert len(loops_over_periods()) == 2


def test_the_files_that_the_page_names_are_there():
    text = PAGE.read_text(encoding="utf-8")
    for path in set(re.findall(r"`((?:fuzzy|anfis|robotics|ros|tests)/[\w./-]+\.(?:py|toml|js))`", text)):
        assert (ROOT / path).is_file(), path


if __name__ == "__main__":
    text = PAGE.read_text(encoding="utf-8")
    begin, end = text.index(BEGIN) + len(BEGIN), text.index(END)
    PAGE.write_text(text[:begin] + measured() + text[end:], encoding="utf-8")
