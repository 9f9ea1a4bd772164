"""The equation of a law, and all that it calls, from Python to C: what is known beforehand is worked out here."""

import ast
import re
import textwrap
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from typing import Any

from robotics.plugins.ccode.body import CFunction
from robotics.plugins.ccode.expressions import Array, Function
from robotics.plugins.ccode.pythonsource import parsed, spoken
from robotics.plugins.ccode.terms import Arithmetic, CTable, CTerm, KnownValue, Lane

_INPUT = "const {0}_input *input"
_POINTERS = {"seen": _INPUT, "robot": _INPUT, "aim": _INPUT, "memory": "{0}_state *state"}
_POINTERS |= {"command": "{0}_output *output", "work": "{1} *work"}

Reads = Callable[[Any, Any], Any]
Calls = Callable[[Any, str, Sequence[Any]], Any]


@dataclass
class Translator:
    """Functions of Python as functions of C."""

    prefix: str
    arithmetic: Arithmetic
    read: Reads  # an entry of a table, or a column of a lane
    call: Calls  # functions that are not translated; NotImplemented: this one is
    constant: Callable[[str, float], CTerm]  # a number with a name: "NAME unit"
    done: dict[Any, Function] = field(default_factory=dict)

    @property
    def real(self) -> str:
        """The type of real numbers."""
        return self.arithmetic.number.name

    def function(self, python: Any, arguments: Sequence[Any]) -> Function:
        """The function for these arguments: known ones are worked into it."""
        python = getattr(python, "py_func", python)
        still = tuple(
            repr(a) if isinstance(a, (KnownValue, CTable, Lane)) else getattr(a, "size", "") for a in arguments
        )
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
            if isinstance(value, (KnownValue, CTable, Lane)):
                body.env[argument.arg] = value
                if not isinstance(value, KnownValue) and (pointer := self.pointer(value)) and pointer not in parameters:
                    parameters.append(pointer)
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
        for name in (parameter.rpartition(" ")[2].partition("[")[0].strip("*") for parameter in parameters):
            if not re.search(rf"(?<![\w>.]){name}(?!\w)", text):
                lines.insert(0, f"    (void){name};")
        if body.left:
            parameters.append(f"{self.real} left[{body.left}]")
        head = f"static {kind} {found.name}({', '.join(parameters) or 'void'}) {{"
        if len(head) > 116:
            head = textwrap.fill(head.replace("const ", "const\0"), 112, subsequent_indent="    ").replace("\0", " ")
        doc = re.sub(r":\w+:`~?([^`]*)`|``", r"\1", (ast.get_docstring(tree) or "").split("\n\n")[0])
        said = [textwrap.fill(f"/* {' '.join(doc.split())} */", 116, subsequent_indent=" * ")] if doc else []
        return "\n".join([*said, head, *lines, "}", ""])

    def pointer(self, table: CTable | Lane) -> str:
        """What a function takes for a table, if it is one of C."""
        return _POINTERS.get(table.name, "").format(self.prefix, self.real)
