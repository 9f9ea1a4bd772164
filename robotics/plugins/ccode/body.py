"""The body of a function of Python as lines of C: assignments, branches, loops and what it returns."""

import ast
import re
import textwrap
from collections.abc import Sequence
from typing import Any

from fuzzy.plugins.ccode.numbertype import ExportError
from robotics.plugins.ccode.expressions import Array, Expressions, Translation
from robotics.plugins.ccode.pythonsource import spoken
from robotics.plugins.ccode.terms import CTable, CTerm, KnownValue, Lane, Row

_UNROLLED = 8  # turns of a loop that are written one by one


def _stored(nodes: Sequence[ast.AST]) -> list[str]:
    walked = (n for node in nodes for n in ast.walk(node))
    return [n.id for n in walked if isinstance(n, ast.Name) and isinstance(n.ctx, ast.Store)]


class CFunction(Expressions):
    """The body of one function: its statements, line by line."""

    def __init__(self, translator: Translation, python: Any, tree: ast.FunctionDef) -> None:
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
            parts = self.taken_apart(value)
            for one, part in zip(target.elts, parts, strict=True):
                self.assign(one, part)
        elif isinstance(target, ast.Name):
            self._named(target.id, value)
        else:
            place = self.value(target)
            if place is None:  # what a robot has no use for
                return
            if not isinstance(place, CTerm):
                raise self.refused(target)
            self.say(f"{place.text} = {self.arithmetic.real(value)};")

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
        elif isinstance(value, (KnownValue, CTable, Lane)):
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
        before = self.value(ast.copy_location(_loaded(statement.target), statement.target))
        value = self.value(statement.value)
        self.assign(statement.target, self.arithmetic.binary(statement.op, before, value))

    def _held(self, inside: Sequence[ast.stmt], whole: ast.stmt) -> None:
        """Declare, before a branch or a loop, the names that it changes and that are used outside of it."""
        within = {id(n) for n in ast.walk(whole)}
        used = {n.id for n in ast.walk(self.tree) if isinstance(n, ast.Name) and id(n) not in within}
        for name in dict.fromkeys(_stored(inside)):
            held = self.env.get(name)
            if isinstance(held, KnownValue):
                kind = "int" if type(held.value) is int else self.translator.real
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
        if not isinstance(call, ast.Call) or not isinstance(statement.target, ast.Name):
            raise self.refused(statement)
        bounds = [self.value(a) for a in call.args]
        first, last = (KnownValue(0), bounds[0]) if len(bounds) == 1 else bounds[:2]
        name = statement.target.id
        breaks = any(isinstance(n, (ast.Break, ast.Return)) for n in ast.walk(statement))
        known = isinstance(first, KnownValue) and isinstance(last, KnownValue)
        if known and last.value - first.value <= _UNROLLED and not breaks:
            for n in range(first.value, last.value):
                self.env[name] = KnownValue(n)
                self.run(statement.body)
            return
        self._held(statement.body, statement)
        counter = "turn_" if name == "_" else spoken(name)
        start, end = self.arithmetic.term(first).text, self.arithmetic.term(last).within(1)
        self.say(f"for (int {counter} = {start}; {counter} < {end}; {counter}++) {{")
        self.env[name] = CTerm(counter, "int")
        self._block(statement.body)
        self.say("}")

    def _while(self, statement: ast.While) -> None:
        self._held(statement.body, statement)
        self.say(f"while ({self.value(statement.test).text}) {{")
        self._block(statement.body)
        self.say("}")

    def _break(self, statement: ast.Break) -> None:
        self.say("break;")

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
            self.result = "real" if self.result == "real" or isinstance(value, KnownValue) else term.kind
            self.say(f"return {self.arithmetic.real(value) if self.result == 'real' else term.text};")
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


def _loaded(target: ast.expr) -> ast.expr:
    return ast.parse(ast.unparse(target), mode="eval").body


def _reads(value: Any, place: str) -> bool:
    return isinstance(value, CTerm) and re.search(rf"(?<![\w>.]){re.escape(place)}(?!\w)", value.text) is not None


def _idle(line: str, text: str) -> bool:
    """Whether a line declares what is not read, and does nothing else."""
    found = re.match(r"\s*(?:const )?(?:double|float|int) (\w+)(?: = .*)?;", line)
    if found is None or re.search(r"\bstate\b(?!->)", line):
        return False
    return len(re.findall(rf"(?<![\w>.]){found[1]}(?!\w)", text)) == 1


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
