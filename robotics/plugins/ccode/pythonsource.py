"""What is read of functions of Python beside their values: their trees, and the remarks behind their lines."""

import ast
import inspect
import io
import re
import textwrap
import tokenize
from typing import Any

_SPOKEN = {"cos": "cosine", "sin": "sine", "free": "is_free", "input": "asked_", "output": "said_", "state": "state_"}


def parsed(python: Any) -> ast.FunctionDef:
    """The tree of a function."""
    text = textwrap.dedent(inspect.getsource(python))
    tree = ast.parse(text).body[0]
    assert isinstance(tree, ast.FunctionDef)
    remarks = _remarks(text)
    for node in ast.walk(tree):
        if isinstance(node, (ast.Assign, ast.AugAssign, ast.Return)) and node.end_lineno in remarks:
            node.remark = remarks[node.end_lineno]  # type: ignore[union-attr]
    return tree


def _remarks(text: str) -> dict[int, str]:
    """The remarks behind the lines of Python, without those for tools."""
    found = {}
    for token in tokenize.generate_tokens(io.StringIO(text).readline):
        if token.type == tokenize.COMMENT and not re.match(r"#\s*(type|fmt|noqa)\b", token.string):
            found[token.start[0]] = token.string.lstrip("# ")
    return found


def said_of(python: Any, name: str) -> str:
    """What stands behind a number of a module: its unit and meaning."""
    text = inspect.getsource(inspect.getmodule(python))  # type: ignore[arg-type]
    found = re.search(rf"^{name} = [^#\n]*# (.*)$", text, re.MULTILINE)
    return found[1] if found else ""


def spoken(name: str) -> str:
    """The name of a variable in C."""
    return _SPOKEN.get(name, name.lstrip("_"))
