"""The equation of a law, and all that it calls, from Python to C: what is known beforehand is worked out here.

Expressions of Python become expressions of C, and what they need beforehand lines above them; the body of a function
becomes assignments, branches, loops and what it returns.
"""

import ast
import inspect
import io
import re
import textwrap
import tokenize
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np

from fuzzy.compiled.columns import Columns
from fuzzy.plugins.ccode.numbertype import ExportError
from robotics.plugins.ccode.terms import Arithmetic, CArray, CRecord, CTable, CTerm, KnownValue, Lane, Row

_SPOKEN = {"cos": "cosine", "sin": "sine", "free": "is_free", "input": "asked_", "output": "said_", "state": "state_"}
WRITTEN_OUT = 8  # turns of a loop that are written one by one
_INPUT, _STATE, _OUTPUT = "const {0}_input *input", "{0}_state *state", "{0}_output *output"
_POINTERS: dict[str, tuple[str, ...]] = dict.fromkeys(("seen", "robot", "aim", "truth", "readings", "heard"), (_INPUT,))
_POINTERS |= dict.fromkeys(("memory", "smoothed", "promises"), (_STATE,)) | {"guard": (_STATE, _INPUT, _OUTPUT)}
_POINTERS |= dict.fromkeys(("order", "command", "said"), (_OUTPUT,)) | {"work": ("{1} *work",)}

_PARTS = (CTable, Lane, CArray, CRecord)

Reads = Callable[[Any, Any], Any]
Calls = Callable[[Any, str, Sequence[Any]], Any]


# What is read of functions of Python beside their values: their trees, and the remarks behind their lines -----------


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


# Expressions --------------------------------------------------------------------------------------------------------


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
    pointers: tuple[str, ...] = ()  # the structs that it takes


class Expressions:
    """The names of one function, the lines so far, and what its expressions stand for."""

    def __init__(self, translator: "Translator", python: Any, tree: ast.FunctionDef) -> None:
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
            case ast.Compare():
                terms = [self.value(part) for part in (node.left, *node.comparators)]
                pairs = zip(node.ops, terms, terms[1:], strict=False)
                return self.arithmetic.joined(False, [self.arithmetic.compared(op, a, b) for op, a, b in pairs])
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
                return self.translator.constant(f"{node.id.lstrip('_')} {said_of(self.python, node.id)}", value)
            return KnownValue(value)
        raise self.refused(node)

    def _attribute(self, node: ast.Attribute) -> Any:
        owner = self.value(node.value)
        if isinstance(owner, Lane):
            return self.translator.read(owner, node.attr)
        if isinstance(owner, CTable):
            return self.translator.read(CTable(f"{owner.name}.{node.attr}".removeprefix("known.")), -1)
        if isinstance(owner, CArray) and node.attr == "shape":
            return KnownValue(owner.shape)
        of = owner.of if isinstance(owner, CRecord) else owner.value if isinstance(owner, KnownValue) else None
        if hasattr(of, node.attr):
            found = getattr(of, node.attr)
            return found if isinstance(found, _PARTS) else KnownValue(found)
        raise self.refused(node)

    def _entry(self, node: ast.Subscript) -> Any:
        table, index = self.value(node.value), node.slice
        if isinstance(index, ast.Slice):
            first = KnownValue(0) if index.lower is None else self.value(index.lower)
            if isinstance(table, CTable) and isinstance(first, KnownValue):
                return CTable(table.name, table.first + first.value)
            raise self.refused(node)
        if isinstance(table, KnownValue) and isinstance(table.value, tuple):
            kind = "int" if all(isinstance(v, int) for v in table.value) else "real"
            name = node.value.id if isinstance(node.value, ast.Name) else ""
            table = CArray(name, kind, (len(table.value),), values=np.array(table.value))
        if isinstance(table, CArray):
            places = [self.value(place) for place in (index.elts if isinstance(index, ast.Tuple) else [index])]
            if table.values is not None and not all(isinstance(place, KnownValue) for place in places):
                self.translator.listed[table.text] = table
            return table.entry(places)
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
        if isinstance(node.func, ast.Name) and node.func.id == "len":
            (of,) = arguments
            return KnownValue(of.shape[0] if isinstance(of, CArray) else len(of.value))
        if isinstance(node.func, ast.Name) and node.func.id in ("min", "max", "abs", "int", "round"):
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
        if isinstance(python, type) and issubclass(python, Columns) and isinstance(arguments[0], CArray):
            array, *places = arguments
            (at,) = (self.arithmetic.term(p).text for n, p in zip(array.shape[1:], places, strict=True) if n)
            return Lane(array.name, python, at=at)
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
            if isinstance(a, _PARTS):
                names = [pointer.rpartition("*")[2] for pointer in self.translator.pointers(a)]
                given += [name for name in names if name in function.pointers and name not in given]
                given += [a.at] if isinstance(a, Lane) and a.at else []
            elif isinstance(a, Array):
                given.append(a.name)
            elif not isinstance(a, KnownValue):
                given.append(a.text)
        if not isinstance(function.result, Row):
            return CTerm(f"{function.name}({', '.join(given)})", function.result or "real")
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


def _stored(nodes: Sequence[ast.AST]) -> list[str]:
    walked = (n for node in nodes for n in ast.walk(node))
    return [n.id for n in walked if isinstance(n, ast.Name) and isinstance(n.ctx, ast.Store)]


class CFunction(Expressions):
    """The body of one function: its statements, line by line."""

    def __init__(self, translator: "Translator", python: Any, tree: ast.FunctionDef) -> None:
        super().__init__(translator, python, tree)
        self.assigned = _stored(tree.body)
        self.twice = {name for name in self.assigned if self.assigned.count(name) > 1}
        self.result: Any = None
        self.left = 0
        self.ended = False

    def finished(self) -> list[str]:
        """The lines, without variables that nobody reads, and none too long."""
        lines = self.lines
        while True:
            text = "\n".join(lines)
            kept = [line for line in lines if not _idle(line, text)]
            if len(kept) == len(lines):
                return [part for line in lines for part in _folded(line)]
            lines = kept

    def run(self, statements: Sequence[ast.stmt]) -> None:
        """Write statements one after the other."""
        for statement in statements:
            if self.ended:
                return
            handler = getattr(self, f"_{type(statement).__name__.lower()}", None)
            if handler is None:
                raise self.refused(statement)
            before = len(self.lines)
            handler(statement)
            remark = getattr(statement, "remark", "")
            if remark and len(self.lines) > before:
                self.lines[-1] += f" /* {remark} */"

    # Statements ----------------------------------------------------------------------------------------------

    def _expr(self, statement: ast.Expr) -> None:
        if isinstance(statement.value, ast.Constant):
            return
        value = self.value(statement.value)
        if isinstance(value, CTerm):
            self.say(f"{value.text};")

    def _pass(self, statement: ast.Pass) -> None:
        pass

    def _assign(self, statement: ast.Assign) -> None:
        match statement:
            case ast.Assign(targets=[ast.Tuple(elts=targets)], value=ast.Tuple(elts=values)):
                self._all_at_once(targets, [self.value(v) for v in values])
            case _:
                first = statement.targets[0]
                value = self.value(statement.value, first.id if isinstance(first, ast.Name) else "")
                for target in statement.targets:
                    self.assign(target, value)

    def _all_at_once(self, targets: Sequence[ast.expr], values: Sequence[Any]) -> None:
        """Assign several, of which none reads what an earlier one changes."""
        changed: list[str] = []
        for target, value in zip(targets, values, strict=True):
            place = self._place(target)
            if any(_reads(value, before) for before in changed):
                raise ExportError(f"{self.tree.name}: an assignment of several in turn cannot be written in C")
            changed += [place] if place else []
        for target, value in zip(targets, values, strict=True):
            self.assign(target, value)

    def _place(self, target: ast.expr) -> str:
        found = self.env.get(target.id) if isinstance(target, ast.Name) else self.value(target)
        return found.text if isinstance(found, CTerm) else ""

    def assign(self, target: ast.expr, value: Any) -> None:
        """Let a name, a tuple of names or an entry of a table be a value."""
        if isinstance(target, ast.Tuple):
            for one, part in zip(target.elts, self.taken_apart(value), strict=True):
                self.assign(one, part)
        elif isinstance(target, ast.Name):
            self._named(target.id, value)
        else:
            place = self.value(target)
            if place is None:  # what a robot has no use for
                return
            if not isinstance(place, CTerm):
                raise self.refused(target)
            self.say(f"{place.text} = {self._as(place.kind, value)};")

    def _named(self, name: str, value: Any) -> None:
        if name == "_":
            return
        if name in self.open:
            self._settle(name, value)
            return
        held = self.env.get(name)
        if isinstance(held, CTerm) and held.text == spoken(name):
            self.say(f"{held.text} = {self._as(held.kind, value)};")
        elif isinstance(held, Array) and held.name == spoken(name):
            self._copied(held, value)
        elif isinstance(value, (KnownValue, *_PARTS)):
            self.env[name] = value
        elif isinstance(value, (Row, Array)):
            self.array(name, value)
        else:
            kind = "int" if value.kind == "int" else self.translator.real
            constant = "" if name in self.twice else "const "
            self.say(f"{constant}{kind} {spoken(name)} = {value.text};")
            self.env[name] = CTerm(spoken(name), value.kind)

    def _copied(self, held: Array, value: Any) -> None:
        if isinstance(value, Array):
            self.say(f"for (int n = 0; n < {held.size}; n++) {held.name}[n] = {value.name}[n];")
            return
        for k, part in enumerate(self.taken_apart(value)):
            self.say(f"{held.name}[{k}] = {self.arithmetic.real(part)};")

    def _as(self, kind: str, value: Any) -> str:
        if kind == "real":
            return self.arithmetic.real(value)
        term = self.arithmetic.term(value)
        if term.kind != "int":
            raise ExportError(f"{self.tree.name}: a whole number becomes a real one")
        return term.text

    def _settle(self, name: str, value: Any) -> None:
        """Declare a name where it waits for its type."""
        line, term = self.open.pop(name), self.arithmetic.term(value)
        kind = "int" if term.kind == "int" and not isinstance(value, KnownValue) else self.translator.real
        self.lines[line] = self.lines[line].replace("?", kind)
        self.env[name] = CTerm(spoken(name), "int" if kind == "int" else "real")
        self.say(f"{spoken(name)} = {self._as(self.env[name].kind, value)};")

    def _augassign(self, statement: ast.AugAssign) -> None:
        before = self.value(ast.parse(ast.unparse(statement.target), mode="eval").body)
        value = self.value(statement.value)
        self.assign(statement.target, self.arithmetic.binary(statement.op, before, value))

    def _held(self, inside: Sequence[ast.stmt], whole: ast.stmt) -> None:
        """Declare, before a branch or a loop, the names that it changes and that are used outside of it."""
        within = {id(n) for n in ast.walk(whole)}
        used = {n.id for n in ast.walk(self.tree) if isinstance(n, ast.Name) and id(n) not in within}
        for name in dict.fromkeys(_stored(inside)):
            held = self.env.get(name)
            if isinstance(held, KnownValue):
                kind = "int" if isinstance(held.value, int) else self.translator.real
                self.say(f"{kind} {spoken(name)} = {self._as('int' if kind == 'int' else 'real', held)};")
                self.env[name] = CTerm(spoken(name), "int" if kind == "int" else "real")
            elif isinstance(held, CTerm) and held.text != spoken(name):
                self.say(f"{self.translator.real} {spoken(name)} = {held.text};")
                self.env[name] = CTerm(spoken(name), "real")
            elif held is None and name in used and name != "_" and name not in self.open:
                self.open[name] = len(self.lines)
                self.say(f"? {spoken(name)};")

    def _if(self, statement: ast.If) -> None:
        condition = self.value(statement.test)
        if isinstance(condition, KnownValue):
            self.run(statement.body if condition.value else statement.orelse)
            return
        self._held([*statement.body, *statement.orelse], statement)
        self.say(f"if ({condition.text}) {{")
        ends = [self._block(statement.body)]
        if statement.orelse:
            self.say("} else {")
            ends.append(self._block(statement.orelse))
        self.say("}")
        self.ended = len(ends) == 2 and all(ends)

    def _block(self, statements: Sequence[ast.stmt]) -> bool:
        before = dict(self.env)
        waiting = set(self.open)
        self.depth += 1
        self.run(statements)
        self.depth -= 1
        ended, self.ended = self.ended, False
        settled = {name: self.env[name] for name in waiting - set(self.open)}
        self.env = {**before, **settled}
        return ended

    def _for(self, statement: ast.For) -> None:
        call = statement.iter
        if isinstance(call, ast.Tuple):
            self._each(statement, call.elts)
            return
        if not isinstance(call, ast.Call) or not isinstance(statement.target, ast.Name):
            raise self.refused(statement)
        bounds = [self.value(a) for a in call.args]
        first, last = (KnownValue(0), bounds[0]) if len(bounds) == 1 else bounds[:2]
        step = f" += {self.arithmetic.term(bounds[2]).text}" if len(bounds) == 3 else "++"
        name = statement.target.id
        breaks = any(isinstance(n, (ast.Break, ast.Continue, ast.Return)) for n in ast.walk(statement))
        known = isinstance(first, KnownValue) and isinstance(last, KnownValue)
        if known and last.value - first.value <= WRITTEN_OUT and not breaks and len(bounds) < 3:
            for n in range(first.value, last.value):
                self.env[name] = KnownValue(n)
                self.run(statement.body)
            return
        self._held(statement.body, statement)
        counter = "turn_" if name == "_" else spoken(name)
        start, end = self.arithmetic.term(first).text, self.arithmetic.term(last).within(1)
        if not re.fullmatch(r"[\w>.-]+", end):  # once, not in every turn
            start, end = f"{start}, {counter}_end = {end}", f"{counter}_end"
        self.say(f"for (int {counter} = {start}; {counter} < {end}; {counter}{step}) {{")
        self.env[name] = CTerm(counter, "int")
        begin = len(self.lines)
        self._block(statement.body)
        self.say("}")
        *body, last, _ = self.lines[begin - 1 :]
        if last.strip() == "continue;" and all(_declares(line) for line in body[1:]):  # it does nothing in any turn
            del self.lines[begin - 1 :]

    def _each(self, statement: ast.For, values: Sequence[ast.expr]) -> None:
        """Write a loop over some values, turn by turn."""
        self._held(statement.body, statement)
        for value in values:
            self.say("{")
            before = dict(self.env)
            self.assign(statement.target, self.value(value))
            self._block(statement.body)
            self.env = before
            self.say("}")

    def _while(self, statement: ast.While) -> None:
        self._held(statement.body, statement)
        self.say(f"while ({self.value(statement.test).text}) {{")
        self._block(statement.body)
        self.say("}")

    def _break(self, statement: ast.Break) -> None:
        self.say("break;")

    def _continue(self, statement: ast.Continue) -> None:
        self.say("continue;")
        self.ended = True

    def _return(self, statement: ast.Return) -> None:
        value = self.value(statement.value) if statement.value is not None else None
        if isinstance(value, Array):
            value = Row(tuple(self.taken_apart(value)))
        if isinstance(value, Row):
            several = sum(isinstance(n, ast.Return) for n in ast.walk(self.tree)) > 1
            self.left = 0
            self.result = self._left(value, several)
            if several and self.depth > 1:
                self.say("return;")
        elif value is not None:
            term = self.arithmetic.term(value)
            number = isinstance(value, KnownValue) and not isinstance(value.value, bool)
            self.result = "real" if self.result == "real" or number else term.kind
            self.say(f"return {self.arithmetic.real(value) if self.result == 'real' else term.text};")
        else:
            self.say("return;")
        self.ended = True

    def _left(self, value: Any, all_of_it: bool) -> Any:
        """Leave numbers for who called; return what of them is known, and the places of the others."""
        if isinstance(value, Row):
            return Row(tuple(self._left(part, all_of_it) for part in value.parts))
        if isinstance(value, Array):
            return self._left(Row(tuple(self.taken_apart(value))), all_of_it)
        if isinstance(value, KnownValue) and not all_of_it:
            return value
        self.say(f"left[{self.left}] = {self.arithmetic.real(value)};")
        self.left += 1
        return self.left - 1


def _reads(value: Any, place: str) -> bool:
    return isinstance(value, CTerm) and re.search(rf"(?<![\w>.]){re.escape(place)}(?!\w)", value.text) is not None


def _declares(line: str) -> str:
    """What a line declares, if it does nothing else."""
    found = re.match(r"\s*(?:const )?(?:double|float|int) (\w+)(?: = .*)?;", line)
    return "" if found is None or re.search(r"\bstate\b(?!->)", line) else found[1]


def _idle(line: str, text: str) -> bool:
    """Whether a line declares what is not read, and does nothing else."""
    if not (name := _declares(line)):
        return False
    return len(re.findall(rf"(?<![\w>.]){name}(?!\w)", text)) == 1


def _folded(line: str) -> list[str]:
    if len(line) <= 116:
        return [line]
    indent = len(line) - len(line.lstrip())
    body, _, remark = line.strip().partition(" /* ")
    folded = textwrap.wrap(
        body, 116, initial_indent=" " * indent, subsequent_indent=" " * (indent + 4), break_on_hyphens=False,
        break_long_words=False,
    )  # fmt: skip
    return [f"{' ' * indent}/* {remark}", *folded] if remark else folded


@dataclass
class Translator:
    """Functions of Python as functions of C."""

    prefix: str
    arithmetic: Arithmetic
    read: Reads  # an entry of a table, or a column of a lane
    call: Calls  # functions that are not translated; NotImplemented: this one is
    constant: Callable[[str, float], CTerm]  # a number with a name: "NAME unit"
    done: dict[Any, Function] = field(default_factory=dict)
    listed: dict[str, CArray] = field(default_factory=dict)  # known numbers that the robot looks up

    @property
    def real(self) -> str:
        """The type of real numbers."""
        return self.arithmetic.number.name

    def function(self, python: Any, arguments: Sequence[Any]) -> Function:
        """The function for these arguments: known ones are worked into it."""
        python = getattr(python, "py_func", python)
        plain_lanes = [replace(a, at="?") if isinstance(a, Lane) and a.at else a for a in arguments]
        still = tuple(repr(a) if isinstance(a, (KnownValue, *_PARTS)) else getattr(a, "size", "") for a in plain_lanes)
        key = (python, still)
        if key not in self.done:
            taken = {f.name for f in self.done.values()}
            plain = python.__name__.strip("_")
            name = next(n for n in [plain, *(f"{plain}_{k}" for k in range(2, 99))] if n not in taken)
            found = Function(name)
            text = self._written(python, arguments, found)
            self.done[key] = found
            found.text = text
        return self.done[key]

    def _written(self, python: Any, arguments: Sequence[Any], found: Function) -> str:
        tree = parsed(python)
        body = CFunction(self, python, tree)
        parameters = []
        for argument, value in zip(tree.args.args, arguments, strict=True):
            name = spoken(argument.arg)
            if isinstance(value, (KnownValue, *_PARTS)):
                one = isinstance(value, Lane) and value.at != ""
                body.env[argument.arg] = replace(value, at=name) if isinstance(value, Lane) and one else value
                pointers = () if isinstance(value, KnownValue) else self.pointers(value)
                parameters += [pointer for pointer in pointers if pointer not in parameters]
                parameters += [f"const int {name}"] if one else []
            elif isinstance(value, Array):
                body.env[argument.arg] = Array(name, value.size)
                parameters.append(f"const {self.real} {name}[{value.size}]")
            else:
                kind = "int" if value.kind == "int" else self.real
                body.env[argument.arg] = CTerm(name, value.kind)
                changed = argument.arg in body.assigned
                parameters.append(f"{'' if changed else 'const '}{kind} {name}")
        body.run(tree.body)
        lines = body.finished()
        found.result, found.left = body.result, body.left
        kind = "void" if not isinstance(body.result, str) else "int" if body.result == "int" else self.real
        text = "\n".join(lines)
        for parameter in tuple(parameters):
            _, pointer, name = parameter.partition("[")[0].rpartition("*")
            name = name.rpartition(" ")[2]
            if re.search(rf"(?<![\w>.]){name}(?!\w)", text):
                found.pointers += (name,) if pointer else ()
            elif pointer:
                parameters.remove(parameter)
            else:
                lines.insert(0, f"    (void){name};")
        if body.left:
            parameters.append(f"{self.real} left[{body.left}]")
        head = f"static {kind} {found.name}({', '.join(parameters) or 'void'}) {{"
        if len(head) > 116:
            head = textwrap.fill(head.replace("const ", "const\0"), 112, subsequent_indent="    ").replace("\0", " ")
        doc = re.sub(r":\w+:`~?([^`]*)`|``", r"\1", (ast.get_docstring(tree) or "").split("\n\n")[0])
        said = [textwrap.fill(f"/* {' '.join(doc.split())} */", 116, subsequent_indent=" * ")] if doc else []
        return "\n".join([*said, head, *lines, "}", ""])

    def pointers(self, table: CTable | Lane | CArray | CRecord) -> list[str]:
        """What a function takes for a table, if it is one of C, and it reads it."""
        name = table.table if isinstance(table, CArray) else table.name
        return [pointer.format(self.prefix, self.real) for pointer in _POINTERS.get(name, ())]
