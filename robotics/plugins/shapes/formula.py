"""Formulas of one parameter in a file, such as "6*sin(2*u)": their value and first two derivatives, but for rounding.

A formula is read as Python reads an expression, and of that only numbers, ``u``, ``pi``, ``e``, + − * / **, signs,
brackets and the functions below are taken: nothing of it is run. Derivatives are carried along with the value, term by
term (forward automatic differentiation).
"""

import ast
import math
from collections.abc import Callable, Mapping
from typing import NamedTuple

import numpy as np

from fuzzy.errors import InputError
from fuzzy.naming import expected
from fuzzy.words import listed

_LONGEST = 1000  # characters
_Function = Callable[[np.ndarray], np.ndarray]
_CONSTANTS = {"pi": math.pi, "e": math.e}
# Each with its first two derivatives
FORMULA_FUNCTIONS: Mapping[str, tuple[_Function, _Function, _Function]] = {
    "sin": (np.sin, np.cos, lambda f: -np.sin(f)),
    "cos": (np.cos, lambda f: -np.sin(f), lambda f: -np.cos(f)),
    "tan": (np.tan, lambda f: 1 + np.tan(f) ** 2, lambda f: 2 * np.tan(f) * (1 + np.tan(f) ** 2)),
    "exp": (np.exp, np.exp, np.exp),
    "log": (np.log, lambda f: 1 / f, lambda f: -1 / f**2),
    "sqrt": (np.sqrt, lambda f: 0.5 / np.sqrt(f), lambda f: -0.25 * f**-1.5),
    "tanh": (np.tanh, lambda f: 1 - np.tanh(f) ** 2, lambda f: -2 * np.tanh(f) * (1 - np.tanh(f) ** 2)),
    "atan": (np.arctan, lambda f: 1 / (1 + f**2), lambda f: -2 * f / (1 + f**2) ** 2),
}


class FormulaError(InputError):
    """A formula that cannot be read. The message marks what is wrong."""


class Jet(NamedTuple):
    """A value, and its first and second derivative by ``u``."""

    value: np.ndarray
    first: np.ndarray
    second: np.ndarray


def evaluate(formula: str, u: np.ndarray) -> Jet:
    """A formula and its derivatives at ``u`` (...), each (...). Raises FormulaError."""
    if len(formula) > _LONGEST:
        raise FormulaError(f"a formula may be {_LONGEST} characters long; this one is {len(formula)}")
    u = np.asarray(u, dtype=float)
    try:
        tree = ast.parse(formula.strip(), mode="eval").body
        with np.errstate(all="ignore"):  # what is not finite is said by who asks for it
            return _Reader(formula, Jet(u, np.ones_like(u), np.zeros_like(u))).read(tree)
    except (SyntaxError, ValueError, MemoryError, RecursionError) as error:
        if isinstance(error, FormulaError):
            raise
        raise FormulaError(f"{formula!r} is no formula, such as 6*sin(2*u)") from None


class _Reader:
    def __init__(self, formula: str, u: Jet) -> None:
        self.formula, self.u = formula, u

    def read(self, node: ast.expr) -> Jet:
        """The value of a part of the formula."""
        match node:
            case ast.Constant(value=int() | float() as number) if not isinstance(number, bool):
                return self._constant(float(number))
            case ast.Name(id="u"):
                return self.u
            case ast.Name(id=name) if name in _CONSTANTS:
                return self._constant(_CONSTANTS[name])
            case ast.Name(id=name):
                raise self._fault(expected(name, ["u", *_CONSTANTS], "name"))
            case ast.UnaryOp(op=ast.UAdd(), operand=part):
                return self.read(part)
            case ast.UnaryOp(op=ast.USub(), operand=part):
                return Jet(*(-row for row in self.read(part)))
            case ast.BinOp(left=left, op=ast.Pow(), right=right):
                return self._power(self.read(left), self.read(right))
            case ast.BinOp(left=left, op=op, right=right) if type(op) in _OPERATIONS:
                return _OPERATIONS[type(op)](self.read(left), self.read(right))
            case ast.Call(func=ast.Name(id=name), args=[part], keywords=[]) if name in FORMULA_FUNCTIONS:
                return _chained(FORMULA_FUNCTIONS[name], self.read(part))
            case ast.Call(func=ast.Name(id=name)):
                raise self._fault(expected(name, list(FORMULA_FUNCTIONS), "function of one number"))
        said = ast.get_source_segment(self.formula.strip(), node) or self.formula
        raise self._fault(f"{said!r} is none of numbers, u, + - * / ** and {listed(list(FORMULA_FUNCTIONS))}")

    def _constant(self, number: float) -> Jet:
        zero = np.zeros_like(self.u.value)
        return Jet(zero + number, zero, zero)

    def _power(self, base: Jet, exponent: Jet) -> Jet:
        if np.any(exponent.first != 0):
            raise self._fault("an exponent must be a number; write exp(a*u) for e to the power of a*u")
        n = exponent.value
        slope, bend = _scaled_power(n, n - 1), _scaled_power(n * (n - 1), n - 2)
        return _chained((lambda f: f**n, slope, bend), base)

    def _fault(self, what: str) -> FormulaError:
        return FormulaError(f"{self.formula!r}: {what}")


def _scaled_power(scale: np.ndarray, power: np.ndarray) -> _Function:
    """c f^n, which is 0 for c = 0, also where f is."""
    return lambda f: np.where(scale == 0, 0.0, scale * f**power)


def _chained(of: tuple[_Function, _Function, _Function], f: Jet) -> Jet:
    h, first, second = (part(f.value) for part in of)
    return Jet(h, first * f.first, second * f.first**2 + first * f.second)


def _product(a: Jet, b: Jet) -> Jet:
    second = a.second * b.value + 2 * a.first * b.first + a.value * b.second
    return Jet(a.value * b.value, a.first * b.value + a.value * b.first, second)


_RECIPROCAL = (lambda f: 1 / f, lambda f: -1 / f**2, lambda f: 2 / f**3)
_OPERATIONS: Mapping[type[ast.operator], Callable[[Jet, Jet], Jet]] = {
    ast.Add: lambda a, b: Jet(*(x + y for x, y in zip(a, b, strict=True))),
    ast.Sub: lambda a, b: Jet(*(x - y for x, y in zip(a, b, strict=True))),
    ast.Mult: _product,
    ast.Div: lambda a, b: _product(a, _chained(_RECIPROCAL, b)),
}
