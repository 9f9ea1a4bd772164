"""The FuzzyLite Language: Takagi-Sugeno systems of ``.fll`` files; :mod:`fuzzy.plugins.mamdani.flltext` writes them.

    fis = read_fll("car.fll")

What has no equal here is refused, with its line: other terms (Discrete, Spike, ...), the hedges "extremely" and
"seldom", which FuzzyLite defines otherwise, "and" and "or" in one rule, and answers that depend on the last one.
Source: the FuzzyLite Language of fuzzylite 6 (fuzzylite.com).
"""

import math
import os
import re
from dataclasses import dataclass, field
from typing import Any, Literal

from fuzzy import membership as mf
from fuzzy.errors import shortened
from fuzzy.files.fislines import LINE_END, FisFileError, file_bytes
from fuzzy.language import RuleError, parse_rule
from fuzzy.membershipfunction import MembershipError, MembershipFunction
from fuzzy.naming import expected
from fuzzy.rule import Rule
from fuzzy.system import Constant, FuzzySystemError, Linear, Sugeno, Variable

AND_METHODS = {"AlgebraicProduct": "prod", "Minimum": "min"}
OR_METHODS = {"AlgebraicSum": "probor", "Maximum": "max"}
DEFUZZIFIERS = {"WeightedAverage": "wtaver", "WeightedSum": "wtsum"}
_BLOCKS = ("Engine", "InputVariable", "OutputVariable", "RuleBlock")
_HEDGES = ("not", "very", "somewhat")
_OTHER_HEDGES = ("any", "extremely", "seldom")
_NAME = re.compile(r"[A-Za-z_]\w*", re.ASCII)


# FuzzyLite's terms: the membership function that is equal, and where in a term's line each of its parameters stands. (A
# ramp that falls is another one.)
TERMS: dict[str, tuple[type[MembershipFunction], tuple[int, ...]]] = {
    "Triangle": (mf.Triangle, (0, 1, 2)),
    "Trapezoid": (mf.Trapezoid, (0, 1, 2, 3)),
    "Rectangle": (mf.Trapezoid, (0, 0, 1, 1)),
    "Ramp": (mf.LinearS, (0, 1)),
    "Gaussian": (mf.Gaussian, (1, 0)),
    "GaussianProduct": (mf.TwoSidedGaussian, (1, 0, 3, 2)),
    "Bell": (mf.Bell, (1, 2, 0)),
    "Sigmoid": (mf.Sigmoid, (1, 0)),
    "SigmoidDifference": (mf.SigmoidDifference, (1, 0, 2, 3)),
    "SigmoidProduct": (mf.SigmoidProduct, (1, 0, 2, 3)),
    "SShape": (mf.SShape, (0, 1)),
    "ZShape": (mf.ZShape, (0, 1)),
    "PiShape": (mf.PiShape, (0, 1, 2, 3)),
}


def check_difference(left: float, rising: float, falling: float, right: float) -> None:
    """Raise MembershipError for a difference of two sigmoids, in FuzzyLite's order, that has another value here."""
    if not (rising == falling and (right - left) * rising >= 0):
        raise MembershipError("FuzzyLite takes the absolute difference, which here differs from ours")


def _function(kind: str, numbers: list[float]) -> MembershipFunction:
    """The membership function of a term of FuzzyLite's. Raises MembershipError."""
    function, order = TERMS[kind]
    if kind == "Ramp" and not numbers[0] < numbers[1]:
        function, order = mf.LinearZ, (1, 0)
    if kind == "SigmoidDifference":
        check_difference(*numbers)
    return function(*(numbers[k] for k in order))


class FllFileError(FisFileError):
    """The error for a text that is no Takagi-Sugeno system of FuzzyLite's, and for a system that it cannot hold."""


@dataclass
class _Block:
    """One block of a file: its heading and its lines."""

    kind: str
    name: str
    line: int
    entries: list[tuple[int, str, str]] = field(default_factory=list)  # line, key, value

    def all(self, key: str) -> list[tuple[int, str]]:
        return [(line, value) for line, name, value in self.entries if name == key]

    def one(self, key: str, default: str = "") -> tuple[int, str]:
        found = self.all(key)
        return found[-1] if found else (self.line, default)


def read_fll(path: str | os.PathLike[str]) -> Sugeno:
    """Read the Takagi-Sugeno system in a FuzzyLite file (UTF-8).

    The terms, "and" and "or" become those that are equal here. Where no rule fires the output is the file's default if
    that is not-a-number, or the middle of the range. Inputs whose range is locked are clipped.

    Args:
        path: The file.

    Returns:
        The system.

    Raises:
        FllFileError: What has no equal here, with the file and the line, and a Mamdani system.
    """
    name = os.fsdecode(path)
    try:
        text = file_bytes(name, FllFileError).decode("utf-8-sig")
    except UnicodeDecodeError:
        raise FllFileError(name, None, "is not in UTF-8") from None
    return parse_fll(text, name)


def parse_fll(text: str, name: str = "fll") -> Sugeno:
    """The system that a text in FuzzyLite's language describes, read as :func:`read_fll` reads a file.

    Args:
        text: The text.
        name: What messages call the file.

    Raises:
        FllFileError: As :func:`read_fll` does.
    """
    return _Reader(name).system(_blocks(text, name))


def _blocks(text: str, name: str) -> list[_Block]:
    blocks: list[_Block] = []
    for number, raw in enumerate(LINE_END.split(text), 1):
        line = raw.partition("#")[0].strip()
        if not line:
            continue
        key, colon, value = (part.strip() for part in line.partition(":"))
        if not colon:
            raise FllFileError(name, number, f"expected 'key: value', got {shortened(line)!r}")
        if key in _BLOCKS:
            blocks.append(_Block(key, value, number))
        elif not blocks:
            raise FllFileError(name, number, f"a file begins with 'Engine: name', got {shortened(line)!r}")
        else:
            blocks[-1].entries.append((number, key, value))
    if not blocks or blocks[0].kind != "Engine":
        raise FllFileError(name, None, "is no FuzzyLite file: it has no line 'Engine: name'")
    return blocks


class _Reader:
    def __init__(self, path: str) -> None:
        self.path = path

    def fail(self, line: int | None, reason: str) -> FllFileError:
        return FllFileError(self.path, line, reason)

    def system(self, blocks: list[_Block]) -> Sugeno:
        inputs = [self._input(b) for b in blocks if b.kind == "InputVariable"]
        outs = [b for b in blocks if b.kind == "OutputVariable"]
        outputs = [self._output(b, len(inputs)) for b in outs]
        if not inputs or not outputs:
            raise self.fail(None, "has no input or no output")
        rules, conjunction, disjunction = self._rules([b for b in blocks if b.kind == "RuleBlock"], inputs, outputs)
        locked = {self._truth(b, "lock-range") for b in blocks if b.kind == "InputVariable"}
        if len(locked) > 1:
            raise self.fail(None, "some inputs have a locked range and some have not; here all have it or none")
        defuzzifiers = {self._defuzzifier(b) for b in outs}
        defaults = {self._default(b, v) for b, v in zip(outs, outputs, strict=True)}
        for what, found in (("defuzzifiers", defuzzifiers), ("kinds of default values", defaults)):
            if len(found) > 1:
                raise self.fail(outs[-1].line, f"the outputs have different {what}; here all have the same")
        try:
            return Sugeno(
                inputs,
                outputs,
                rules,
                name=blocks[0].name or "fll",
                and_method=conjunction,
                or_method=disjunction,
                defuzzification=defuzzifiers.pop(),
                no_rule_fires=defaults.pop(),
                out_of_range="clip" if True in locked else "warn",
            )
        except FuzzySystemError as error:
            raise self.fail(None, str(error)) from None

    # Variables ------------------------------------------------------------------------------------------------

    def _truth(self, block: _Block, key: str, default: str = "false") -> bool:
        line, value = block.one(key, default)
        if value not in ("true", "false"):
            raise self.fail(line, f"{key} must be true or false, got {shortened(value)!r}")
        return value == "true"

    def _number(self, line: int, text: str) -> float:
        try:
            return float(text)
        except ValueError:
            raise self.fail(line, f"expected a number, got {shortened(text)!r}") from None

    def _range(self, block: _Block) -> tuple[float, float]:
        if not self._truth(block, "enabled", "true"):
            raise self.fail(block.line, f"{block.name} is disabled; a disabled variable has no equal here")
        line, text = block.one("range")
        ends = [self._number(line, part) for part in text.split()]
        if len(ends) != 2 or not all(map(math.isfinite, ends)):
            raise self.fail(line, f"{block.name}: the range must be 2 finite numbers, got {shortened(text)!r}")
        return ends[0], ends[1]

    def _terms(self, block: _Block) -> list[tuple[int, str, str, list[str]]]:
        found = []
        for line, text in block.all("term"):
            parts = text.split()
            if len(parts) < 2:
                raise self.fail(line, f"a term is 'name Kind parameters', got {shortened(text)!r}")
            found.append((line, parts[0], parts[1], parts[2:]))
        return found

    def _input(self, block: _Block) -> Variable:
        terms = {}
        for line, name, kind, texts in self._terms(block):
            if kind not in TERMS:
                known = expected(kind, TERMS, "term")
                raise self.fail(line, f"{block.name} is {name}: {known}; others have no equal here")
            count = max(TERMS[kind][1]) + 1
            numbers = [self._number(line, text) for text in texts]
            if len(numbers) == count + 1 and numbers.pop() != 1:
                raise self.fail(line, f"{block.name} is {name}: a height other than 1 has no equal here")
            if len(numbers) != count:
                raise self.fail(line, f"{block.name} is {name}: {kind} has {count} parameters, got {len(numbers)}")
            try:
                terms[name] = _function(kind, numbers)
            except MembershipError as error:
                raise self.fail(line, f"{block.name} is {name}: {error}") from None
        return self._variable(block, terms)

    def _output(self, block: _Block, inputs: int) -> Variable:
        line, aggregation = block.one("aggregation", "none")
        if aggregation not in ("none", "", "UnboundedSum"):
            got = shortened(aggregation)
            raise self.fail(line, f"{block.name}: aggregation must be none or UnboundedSum, got {got!r}")
        if self._truth(block, "lock-previous"):
            raise self.fail(block.line, f"{block.name}: lock-previous makes an answer depend on the last one")
        terms: dict[str, Any] = {}
        for line, name, kind, texts in self._terms(block):
            numbers = [self._number(line, text) for text in texts]
            if kind == "Constant" and len(numbers) == 1:
                terms[name] = Constant(numbers[0])
            elif kind == "Linear" and len(numbers) == inputs + 1:
                terms[name] = Linear(numbers[:-1], numbers[-1])
            elif kind in ("Constant", "Linear"):
                wanted = 1 if kind == "Constant" else inputs + 1
                raise self.fail(line, f"{block.name} is {name}: {kind} has {wanted} numbers here, got {len(numbers)}")
            else:
                raise self.fail(
                    line,
                    f"{block.name} is {name}: a Takagi-Sugeno output has the terms Constant and Linear, got "
                    f"{shortened(kind)!r}; a Mamdani system is read from a .fis file",
                )
        variable = self._variable(block, terms)
        low, high = variable.universe
        if self._truth(block, "lock-range") and not all(
            isinstance(term, Constant) and low <= term.value <= high for term in variable.terms.values()
        ):
            raise self.fail(block.line, f"{block.name}: a locked range that its terms may leave has no equal here")
        return variable

    def _variable(self, block: _Block, terms: dict[str, Any]) -> Variable:
        try:
            return Variable(block.name, self._range(block), terms)
        except FuzzySystemError as error:
            raise self.fail(block.line, str(error)) from None

    def _defuzzifier(self, block: _Block) -> Literal["wtaver", "wtsum"]:
        line, text = block.one("defuzzifier")
        name, _, kind = text.partition(" ")
        if name not in DEFUZZIFIERS or kind.strip() not in ("", "Automatic", "TakagiSugeno"):
            raise self.fail(
                line,
                f"{block.name}: the defuzzifier must be WeightedAverage or WeightedSum of TakagiSugeno, got "
                f"{shortened(text)!r}; a Mamdani system is read from a .fis file",
            )
        return "wtaver" if DEFUZZIFIERS[name] == "wtaver" else "wtsum"

    def _default(self, block: _Block, variable: Variable) -> Literal["nan", "midrange"]:
        line, text = block.one("default", "nan")
        value = self._number(line, text)
        if math.isnan(value):
            return "nan"
        if math.isclose(value, variable.midrange, rel_tol=1e-12, abs_tol=1e-300):
            return "midrange"
        raise self.fail(
            line,
            f"{block.name}: the default must be nan or the middle of the range, {variable.midrange:g}; got {text}",
        )

    # Rules --------------------------------------------------------------------------------------------------------

    def _rules(
        self, blocks: list[_Block], inputs: list[Variable], outputs: list[Variable]
    ) -> tuple[list[Rule], Literal["prod", "min"], Literal["probor", "max"]]:
        asked = {v.name: tuple(v.terms) for v in inputs}
        proposed = {v.name: tuple(v.terms) for v in outputs}
        rules: list[Rule] = []
        ands, ors = set[str](), set[str]()
        for block in blocks:
            if not self._truth(block, "enabled", "true"):
                continue
            ands.add(self._method(block, "conjunction", AND_METHODS))
            ors.add(self._method(block, "disjunction", OR_METHODS))
            line, activation = block.one("activation", "General")
            if activation not in ("General", ""):
                raise self.fail(line, f"activation must be General, got {shortened(activation)!r}")
            rules += [self._rule(line, text, asked, proposed) for line, text in block.all("rule")]
        if len(ands - {""}) > 1 or len(ors - {""}) > 1:
            raise self.fail(blocks[-1].line, "the rule blocks join by different operators; here all have the same")
        return rules, "min" if "min" in ands else "prod", "max" if "max" in ors else "probor"

    def _method(self, block: _Block, key: str, known: dict[str, str]) -> str:
        line, text = block.one(key, "none")
        if text in ("none", ""):
            return ""
        if text not in known:
            raise self.fail(line, expected(text, known, key))
        return known[text]

    def _rule(
        self, line: int, text: str, asked: dict[str, tuple[str, ...]], proposed: dict[str, tuple[str, ...]]
    ) -> Rule:
        words = text.split()
        names = {*asked, *proposed, *(t for terms in (*asked.values(), *proposed.values()) for t in terms)}
        for word in words:
            if word in _OTHER_HEDGES and word not in names:
                raise self.fail(line, f"the hedge {word!r} has no equal here; known: {', '.join(_HEDGES)}")
        quoted = [f"'{word}'" if word in names and not _NAME.fullmatch(word) else word for word in words]
        try:
            return parse_rule(" ".join(quoted), asked, proposed)
        except RuleError as error:
            raise self.fail(line, str(error).partition("\n")[0]) from None


# Writing ------------------------------------------------------------------------------------------------------
