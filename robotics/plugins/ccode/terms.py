"""Terms of C: what a translated expression is, known beforehand or computed by the robot."""

import ast
import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from operator import add, eq, floordiv, ge, gt, le, lt, mod, mul, ne, sub, truediv
from typing import Any

from fuzzy.compiled.columns import Columns
from fuzzy.plugins.ccode.numbertype import Floating

# How tightly a text of C binds, the tightest first
ATOM = 0
UNARY = 1
PRODUCT = 2
SUM = 3
COMPARED = 4
AND = 5
OR = 6
CHOICE = 7
_BINDS = {ast.Mult: PRODUCT, ast.Div: PRODUCT, ast.Mod: PRODUCT, ast.Add: SUM, ast.Sub: SUM, ast.FloorDiv: PRODUCT}
_SIGNS = {ast.Mult: "*", ast.Div: "/", ast.Add: "+", ast.Sub: "-", ast.FloorDiv: "/"}
COMPARISONS = {ast.Lt: "<", ast.LtE: "<=", ast.Gt: ">", ast.GtE: ">=", ast.Eq: "==", ast.NotEq: "!="}


@dataclass(frozen=True)
class CTerm:
    """An expression of C, computed by the robot."""

    text: str
    kind: str  # "real", or "int" for whole numbers and truth
    binds: int = ATOM

    def within(self, binds: int) -> str:
        """The text, in brackets where an operator that binds as tightly as ``binds`` stands beside it."""
        return f"({self.text})" if self.binds > binds else self.text


@dataclass(frozen=True)
class KnownValue:
    """What is known when the code is written: a number, or a thing that only stands for others, such as a table."""

    value: Any


@dataclass(frozen=True)
class Row:
    """Several terms: a tuple."""

    parts: tuple[Any, ...]


@dataclass(frozen=True)
class CTable:
    """A table that a law reads or writes, and what has been said of where; ``name`` says which."""

    name: str
    first: int = 0


@dataclass(frozen=True)
class Lane:
    """One lane of a class of columns, as the arguments of an equation are; ``name`` says which of them."""

    name: str
    of: type[Columns]
    first: int = 0  # its first row
    path: tuple[str, ...] = ()  # the names that lead to it, where it is within another
    at: str = ""  # which one, where the robot finds that out


@dataclass(frozen=True)
class CRecord:
    """Named things, of which the robot keeps some: ``of`` has them as attributes, ``name`` says which record it is."""

    name: str
    of: Any = field(repr=False, compare=False)


@dataclass(frozen=True)
class CArray:
    """Numbers of C under one name, which the robot finds by their places.

    Of the axis of lanes, whose length is 0, C has nothing: it is one robot.
    """

    text: str
    kind: str  # "real" or "int"
    shape: tuple[int, ...]
    table: str = ""  # what it is a part of; nothing: its numbers are known
    values: Any = field(default=None, repr=False, compare=False)  # an array of the known numbers

    @property
    def name(self) -> str:
        """What it is called, of whatever it is a part."""
        return self.text.rpartition(">")[2]

    def entry(self, places: Sequence[Any]) -> Any:
        """The entry, or the part, at ``places`` of the first axes."""
        text, values = self.text, self.values
        for size, place in zip(self.shape, places, strict=False):
            known = place.value if isinstance(place, KnownValue) else None if size else 0
            values = values[known] if values is not None and known is not None else None
            text += f"[{place.text if known is None else known}]" if size else ""
        if len(places) < len(self.shape):
            return CArray(text, self.kind, self.shape[len(places) :], self.table, values)
        return CTerm(text, self.kind) if values is None else KnownValue(values.item())


class Arithmetic:
    """Operators and functions on terms, in one type of numbers."""

    def __init__(self, number: Floating) -> None:
        self.number = number
        self.needed: set[str] = set()  # pieces of C

    def real(self, value: Any, binds: int = CHOICE) -> str:
        """A value as a text of the type of real numbers."""
        if isinstance(value, KnownValue):
            text = self.number.constant(float(value.value))
            return f"({text})" if text.startswith("-") and binds < SUM else text
        assert isinstance(value, CTerm), value
        if value.kind == "int":
            return f"({self.number.name}){value.within(UNARY)}"
        return value.within(binds)

    def term(self, value: Any) -> CTerm:
        """A value as a term."""
        if isinstance(value, KnownValue):
            if isinstance(value.value, int):
                return CTerm(str(int(value.value)), "int")
            return CTerm(self.real(value), "real", UNARY if value.value < 0 else ATOM)
        assert isinstance(value, CTerm), value
        return value

    def binary(self, operator: ast.operator, a: Any, b: Any) -> Any:
        """a + b, a − b, a b, a / b, a², the remainder."""
        kind = type(operator)
        if kind is ast.Pow and isinstance(b, KnownValue) and b.value == 2:
            return self.binary(ast.Mult(), a, a)
        if isinstance(a, KnownValue) and isinstance(b, KnownValue):
            return KnownValue(_FOLD[kind](a.value, b.value))
        if (simple := _simplified(kind, a, b)) is not None:
            return simple
        if kind is ast.Mod and self.term(a).kind == self.term(b).kind == "int":
            self.needed.add("rest_of")
            return CTerm(f"rest_of({self.term(a).text}, {self.term(b).text})", "int")
        if kind is ast.Mod:
            self.needed.add("modulo")
            return CTerm(f"modulo({self.real(a)}, {self.real(b)})", "real")
        whole = self.term(a).kind == self.term(b).kind == "int" and kind is not ast.Div
        binds, sign = _BINDS[kind], _SIGNS[kind]
        if whole:
            return CTerm(f"{self.term(a).within(binds)} {sign} {self.term(b).within(binds - 1)}", "int", binds)
        # A right side would be taken apart without brackets: C, as Python, adds from left to right
        compound = isinstance(b, CTerm) and b.binds == binds
        right = binds - 1 if kind in (ast.Sub, ast.Div) or compound else binds
        return CTerm(f"{self.real(a, binds)} {sign} {self.real(b, right)}", "real", binds)

    def negative(self, a: Any) -> Any:
        """−a."""
        if isinstance(a, KnownValue):
            return KnownValue(-a.value)
        return CTerm(f"-{self.term(a).within(ATOM)}", self.term(a).kind, UNARY)

    def compared(self, operator: ast.cmpop, a: Any, b: Any) -> Any:
        """Whether a < b, and the like."""
        if isinstance(a, KnownValue) and isinstance(b, KnownValue):
            return KnownValue(_COMPARE[type(operator)](a.value, b.value))
        sign = COMPARISONS[type(operator)]
        if self.term(a).kind == self.term(b).kind == "int":
            return CTerm(f"{self.term(a).within(SUM)} {sign} {self.term(b).within(SUM)}", "int", COMPARED)
        return CTerm(f"{self.real(a, SUM)} {sign} {self.real(b, SUM)}", "int", COMPARED)

    def inverse(self, a: Any) -> Any:
        """Not a."""
        if isinstance(a, KnownValue):
            return KnownValue(not a.value)
        return CTerm(f"!{self.term(a).within(ATOM)}", "int", UNARY)

    def joined(self, either: bool, parts: Sequence[Any]) -> Any:
        """All of them, or either."""
        left = [part for part in parts if not (isinstance(part, KnownValue) and bool(part.value) is not either)]
        if any(isinstance(part, KnownValue) for part in left):
            return KnownValue(either)
        if not left:
            return KnownValue(not either)
        if len(left) == 1:
            return left[0]
        sign, binds = (" || ", OR) if either else (" && ", AND)
        return CTerm(sign.join(part.within(COMPARED) for part in left), "int", binds)

    def choice(self, condition: Any, yes: Any, no: Any) -> Any:
        """One or the other."""
        if isinstance(condition, KnownValue):
            return yes if condition.value else no
        if isinstance(yes, Row):
            return Row(tuple(self.choice(condition, a, b) for a, b in zip(yes.parts, no.parts, strict=True)))
        kinds = {self.term(yes).kind, self.term(no).kind}
        if kinds == {"int"}:
            first, second = self.term(yes).within(OR), self.term(no).within(CHOICE)
            return CTerm(f"{condition.within(COMPARED)} ? {first} : {second}", "int", CHOICE)
        return CTerm(f"{condition.within(COMPARED)} ? {self.real(yes, OR)} : {self.real(no)}", "real", CHOICE)

    def called(self, name: str, arguments: Sequence[Any]) -> Any:
        """A function of math.h, or one that Python has and C writes in another way."""
        if (bound := {"min": math.inf, "max": -math.inf}.get(name)) is not None:
            finite = [a for a in arguments if not (isinstance(a, KnownValue) and a.value == bound)]
            if len(finite) == 1:
                return finite[0]
            if len(arguments) > 2:
                return self.called(name, [self.called(name, arguments[:2]), *arguments[2:]])
        if name == "int":
            (a,) = arguments
            if isinstance(a, KnownValue):
                return KnownValue(int(a.value))
            return a if a.kind == "int" else CTerm(f"(int){a.within(ATOM)}", "int", UNARY)
        if name in ("min", "max") and all(self.term(a).kind == "int" for a in arguments):
            a, b = (self.term(value) for value in arguments)
            sign = "<" if name == "min" else ">"
            return CTerm(f"{b.within(SUM)} {sign} {a.within(SUM)} ? {b.text} : {a.text}", "int", CHOICE)
        if all(isinstance(a, KnownValue) for a in arguments):
            values = [a.value for a in arguments]
            return KnownValue(_CALL[name](*values) if name in _CALL else getattr(math, name)(*values))
        if name in ("isnan", "isfinite"):
            return CTerm(f"{name}({self.real(arguments[0])})", "int")
        if name in ("floor", "ceil", "round"):  # whole numbers, as of Python
            return CTerm(f"(int){name}{self.number.suffix}({self.real(arguments[0])})", "int", UNARY)
        if name in ("min", "max"):
            call = f"{name}_of"
            self.needed.add(call)
        else:
            call = {"abs": "fabs"}.get(name, name) + self.number.suffix
        return CTerm(f"{call}({', '.join(self.real(a) for a in arguments)})", "real")


def _simplified(kind: type, a: Any, b: Any) -> Any:
    if isinstance(a, KnownValue) and a.value == 1 and kind is ast.Mult:
        return b if b.kind == "real" else None
    if isinstance(b, KnownValue) and b.value == 1 and kind in (ast.Mult, ast.Div):
        return a if a.kind == "real" else None
    if isinstance(b, KnownValue) and b.value == 0 and kind in (ast.Add, ast.Sub):
        return a
    if isinstance(a, KnownValue) and a.value == 0 and kind is ast.Add:
        return b
    return None


_FOLD: dict[type, Callable[[Any, Any], Any]]
_FOLD = {ast.Add: add, ast.Sub: sub, ast.Mult: mul, ast.Div: truediv, ast.FloorDiv: floordiv, ast.Mod: mod}
_COMPARE: dict[type, Callable[[Any, Any], Any]]
_COMPARE = {ast.Lt: lt, ast.LtE: le, ast.Gt: gt, ast.GtE: ge, ast.Eq: eq, ast.NotEq: ne}
_CALL: dict[str, Any] = {"min": min, "max": max, "abs": abs, "round": round}
PIECES = {
    "rest_of": (
        "/* The remainder of a division of whole numbers, never negative. */\n"
        "static int rest_of(int a, int b) {\n"
        "    const int rest = a % b;\n"
        "    return rest < 0 ? rest + b : rest;\n"
        "}\n"
    ),
    "min_of": "static REAL min_of(REAL a, REAL b) {\n    return b < a ? b : a;\n}\n",
    "max_of": "static REAL max_of(REAL a, REAL b) {\n    return b > a ? b : a;\n}\n",
    "modulo": (
        "/* The remainder of a division, with the sign of the divisor. */\n"
        "static REAL modulo(REAL a, REAL b) {\n"
        "    const REAL rest = fmod(a, b);\n"
        "    return rest != 0.0 && (b < 0.0) != (rest < 0.0) ? rest + b : rest;\n"
        "}\n"
    ),
}


def piece(name: str, number: Floating) -> str:
    """The text of a piece of C, in a type of numbers."""
    text = number.typed(PIECES[name])
    return text.replace("fmod(", "fmodf(") if number.suffix else text
