"""Expressions of Python as expressions of C; what they need beforehand becomes lines above them."""

import ast
import inspect
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, Protocol

import numpy as np

from fuzzy.compiled.columns import Columns
from fuzzy.plugins.ccode.numbertype import ExportError
from robotics.plugins.ccode.pythonsource import said_of, spoken
from robotics.plugins.ccode.terms import Arithmetic, CTable, CTerm, KnownValue, Lane, Row


@dataclass(frozen=True)
class Array:
    """Several numbers in C under one name."""

    name: str
    size: int


@dataclass
class Function:
    """A function of C that has been written."""

    name: str
    text: str = ""
    result: Any = None  # None, a kind, or a Row of what is known and of places in what it leaves
    left: int = 0  # how many numbers it leaves in its last argument


class Translation(Protocol):
    """What the body of a function asks of :class:`robotics.plugins.ccode.translation.Translator`."""

    arithmetic: Arithmetic

    @property
    def real(self) -> str:
        """The type of real numbers."""

    def function(self, python: Any, arguments: Sequence[Any]) -> Function:
        """The function of C for these arguments."""

    def pointer(self, table: CTable | Lane) -> str:
        """What a function takes for a table."""

    def read(self, table: CTable | Lane, entry: int | str) -> Any:
        """An entry of a table, or a column of a lane."""

    def constant(self, name: str, value: float) -> CTerm:
        """A number with a name and a unit."""

    def call(self, body: Any, name: str, arguments: Sequence[Any]) -> Any:
        """A function that is not translated, or NotImplemented."""


class Expressions:
    """The names of one function, the lines so far, and what its expressions stand for."""

    def __init__(self, translator: "Translation", python: Any, tree: ast.FunctionDef) -> None:
        self.translator, self.arithmetic = translator, translator.arithmetic
        self.tree, self.python = tree, python
        outer = inspect.getclosurevars(python)
        self.outer: dict[str, Any] = {**python.__globals__, **outer.nonlocals}
        self.env: dict[str, Any] = {}
        self.open: dict[str, int] = {}  # names that wait for their type, and where they are declared
        self.lines: list[str] = []
        self.depth = 1
        self.temporary = 0

    def say(self, line: str) -> None:
        """Add a line."""
        self.lines.append("    " * self.depth + line)

    def refused(self, node: ast.AST) -> ExportError:
        """The error for what is not translated."""
        return ExportError(f"{self.tree.name}: {ast.unparse(node)!r} cannot be written in C")

    def array(self, name: str, value: Any) -> None:
        """Let a name stand for several numbers: for those that were left there, or for copies."""
        if isinstance(value, Array) and value.name == spoken(name):
            self.env[name] = value  # it was left there
            return
        parts = self.taken_apart(value)
        listed = ", ".join(self.arithmetic.real(part) for part in parts)
        self.say(f"{self.translator.real} {spoken(name)}[{len(parts)}] = {{{listed}}};")
        self.env[name] = Array(spoken(name), len(parts))

    def taken_apart(self, value: Any) -> list[Any]:
        """The numbers that an array or a row holds, each by itself."""
        if isinstance(value, Row):
            return list(value.parts)
        assert isinstance(value, Array), value
        return [CTerm(f"{value.name}[{k}]", "real") for k in range(value.size)]

    def value(self, node: ast.expr, wanted: str = "") -> Any:
        """What an expression stands for; ``wanted`` is the name that it is for."""
        match node:
            case ast.Constant():
                return KnownValue(node.value)
            case ast.Name():
                return self._name(node)
            case ast.Tuple():
                return Row(tuple(self.value(e) for e in node.elts))
            case ast.BinOp():
                return self.arithmetic.binary(node.op, self.value(node.left), self.value(node.right))
            case ast.UnaryOp(op=ast.USub()):
                return self.arithmetic.negative(self.value(node.operand))
            case ast.UnaryOp(op=ast.Not()):
                return self.arithmetic.inverse(self.value(node.operand))
            case ast.BoolOp():
                return self._joined(node)
            case ast.Compare(ops=[operator], comparators=[other]):
                return self.arithmetic.compared(operator, self.value(node.left), self.value(other))
            case ast.IfExp():
                condition = self.value(node.test)
                if isinstance(condition, KnownValue):
                    return self.value(node.body if condition.value else node.orelse)
                return self.arithmetic.choice(condition, self.value(node.body), self.value(node.orelse))
            case ast.Attribute():
                return self._attribute(node)
            case ast.Subscript():
                return self._entry(node)
            case ast.Call():
                return self._call(node, wanted)
        raise self.refused(node)

    def _joined(self, node: ast.BoolOp) -> Any:
        """Parts that are known are not looked beyond, as Python does."""
        either, parts = isinstance(node.op, ast.Or), []
        for each in node.values:
            part = self.value(each)
            parts.append(part)
            if isinstance(part, KnownValue) and bool(part.value) is either:
                break
        return self.arithmetic.joined(either, parts)

    def _name(self, node: ast.Name) -> Any:
        if node.id in self.open:
            raise self.refused(node)
        if node.id in self.env:
            return self.env[node.id]
        if node.id in self.outer:
            value = self.outer[node.id]
            if isinstance(value, float) and node.id.isupper():
                return self.translator.constant(f"{node.id} {said_of(self.python, node.id)}", value)
            return KnownValue(value)
        raise self.refused(node)

    def _attribute(self, node: ast.Attribute) -> Any:
        owner = self.value(node.value)
        if isinstance(owner, Lane):
            return self.translator.read(owner, node.attr)
        if isinstance(owner, CTable):
            return self.translator.read(CTable(f"{owner.name}.{node.attr}".removeprefix("known.")), -1)
        if isinstance(owner, KnownValue) and hasattr(owner.value, node.attr):
            return KnownValue(getattr(owner.value, node.attr))
        raise self.refused(node)

    def _entry(self, node: ast.Subscript) -> Any:
        table, index = self.value(node.value), node.slice
        if isinstance(index, ast.Slice):
            first = KnownValue(0) if index.lower is None else self.value(index.lower)
            if isinstance(table, CTable) and isinstance(first, KnownValue):
                return CTable(table.name, table.first + first.value)
            raise self.refused(node)
        if isinstance(index, ast.Tuple):
            index = index.elts[0] if isinstance(table, CTable) else index
        row = self.value(index)
        if isinstance(table, (Array, Row)) and isinstance(row, KnownValue):
            return self.taken_apart(table)[row.value]
        if isinstance(table, CTable) and isinstance(row, KnownValue):
            return self.translator.read(table, table.first + row.value)
        raise self.refused(node)

    def _call(self, node: ast.Call, wanted: str) -> Any:
        arguments = [self.value(a) for a in node.args]
        arguments = [Array(self._kept(a), len(a.parts)) if isinstance(a, Row) else a for a in arguments]
        if isinstance(node.func, ast.Name) and node.func.id in ("min", "max", "abs", "int"):
            return self.arithmetic.called(node.func.id, arguments)
        function = self.value(node.func)
        if not isinstance(function, KnownValue):
            raise self.refused(node)
        python = function.value
        if getattr(python, "__module__", "") == "math" or isinstance(python, np.ufunc):
            name = {"absolute": "abs"}.get(python.__name__, python.__name__)
            return self.arithmetic.called(name, arguments)
        if isinstance(python, type) and issubclass(python, Columns) and isinstance(arguments[0], CTable):
            return Lane(arguments[0].name, python, arguments[0].first)
        name = getattr(python, "__name__", "")
        own = self.translator.call(self, name, arguments)
        if own is not NotImplemented:
            return own
        return self.called(self.translator.function(python, arguments), arguments, wanted)

    def _kept(self, row: Row) -> str:
        self.temporary += 1
        name = f"part_{self.temporary}"
        self.array(name, row)
        return name

    def called(self, function: Function, arguments: Sequence[Any], wanted: str = "") -> Any:
        """A call of a function of C."""
        given: list[str] = []
        for a in arguments:
            if isinstance(a, (CTable, Lane)):
                pointer = self.translator.pointer(a)
                name = pointer.rpartition("*")[2]
                given += [name] if pointer and name not in given else []
            elif isinstance(a, Array):
                given.append(a.name)
            elif not isinstance(a, KnownValue):
                given.append(a.text)
        if not isinstance(function.result, Row):
            text = f"{function.name}({', '.join(given)})"
            return CTerm(text, function.result or "real")
        left = spoken(wanted) if wanted and wanted not in self.env and wanted not in self.open else ""
        if not left:
            self.temporary += 1
            left = f"{function.name}_{self.temporary}"
        self.say(f"{self.translator.real} {left}[{function.left}];")
        self.say(f"{function.name}({', '.join([*given, left])});")
        if all(isinstance(part, int) for part in function.result.parts):
            return Array(left, function.left)
        return _of_left(function.result, left)


def _of_left(part: Any, name: str) -> Any:
    """What a function has left under a name."""
    if isinstance(part, Row):
        return Row(tuple(_of_left(each, name) for each in part.parts))
    return part if isinstance(part, KnownValue) else CTerm(f"{name}[{part}]", "real")
