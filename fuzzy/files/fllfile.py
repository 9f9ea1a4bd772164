"""The FuzzyLite Language: Takagi-Sugeno systems of ``.fll`` files, read and written.

    fis = read_fll("car.fll")
    write_fll(fis, "copy.fll")

What has no equal here is refused, with its line: other terms (Discrete, Spike, ...), the hedges "extremely" and
"seldom", which FuzzyLite defines otherwise, "and" and "or" in one rule, and answers that depend on the last one.
Source: the FuzzyLite Language of fuzzylite 6 (fuzzylite.com).
"""

import math
import os
import re
import unicodedata
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field, replace
from itertools import pairwise
from pathlib import Path
from typing import Any, Literal

from fuzzy import membership as mf
from fuzzy.errors import shortened
from fuzzy.files.atomic import replacing
from fuzzy.files.fislines import LINE_END, FisFileError
from fuzzy.language import RuleError, parse_rule
from fuzzy.membershipfunction import MembershipError, MembershipFunction, as_number
from fuzzy.naming import expected
from fuzzy.rule import KEYWORDS, Rule, hedge_words
from fuzzy.system import Constant, FuzzySystemError, Linear, Sugeno, Variable

_AND = {"AlgebraicProduct": "prod", "Minimum": "min"}
_OR = {"AlgebraicSum": "probor", "Maximum": "max"}
_DEFUZZIFIERS = {"WeightedAverage": "wtaver", "WeightedSum": "wtsum"}
_BLOCKS = ("Engine", "InputVariable", "OutputVariable", "RuleBlock")
_HEDGES = ("not", "very", "somewhat")
_OTHER_HEDGES = ("any", "extremely", "seldom")
_NAME = re.compile(r"[A-Za-z_]\w*", re.ASCII)


def _gaussian(p: Sequence[float]) -> MembershipFunction:
    return mf.Gaussian(p[1], p[0])


def _ramp(p: Sequence[float]) -> MembershipFunction:
    return mf.LinearS(p[0], p[1]) if p[0] < p[1] else mf.LinearZ(p[1], p[0])


def _difference(p: Sequence[float]) -> MembershipFunction:
    left, rising, falling, right = p
    if not (rising == falling and (right - left) * rising >= 0):
        raise MembershipError("FuzzyLite takes the absolute difference, which here differs from ours")
    return mf.SigmoidDifference(rising, left, falling, right)


# FuzzyLite's terms: the number of parameters, and the membership function that is equal
_TERMS: dict[str, tuple[int, Callable[[Sequence[float]], MembershipFunction]]] = {
    "Triangle": (3, lambda p: mf.Triangle(*p)),
    "Trapezoid": (4, lambda p: mf.Trapezoid(*p)),
    "Rectangle": (2, lambda p: mf.Trapezoid(p[0], p[0], p[1], p[1])),
    "Ramp": (2, _ramp),
    "Gaussian": (2, _gaussian),
    "GaussianProduct": (4, lambda p: mf.TwoSidedGaussian(p[1], p[0], p[3], p[2])),
    "Bell": (3, lambda p: mf.Bell(p[1], p[2], p[0])),
    "Sigmoid": (2, lambda p: mf.Sigmoid(p[1], p[0])),
    "SigmoidDifference": (4, _difference),
    "SigmoidProduct": (4, lambda p: mf.SigmoidProduct(p[1], p[0], p[2], p[3])),
    "SShape": (2, lambda p: mf.SShape(*p)),
    "ZShape": (2, lambda p: mf.ZShape(*p)),
    "PiShape": (4, lambda p: mf.PiShape(*p)),
}


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

    Raises FllFileError, with the file and the line, for what has no equal here, and for a Mamdani system.
    """
    name = os.fsdecode(path)
    try:
        text = Path(name).read_bytes().decode("utf-8-sig")
    except UnicodeDecodeError:
        raise FllFileError(name, None, "is not in UTF-8") from None
    except (OSError, ValueError) as error:
        raise FllFileError(name, None, f"cannot be read: {getattr(error, 'strerror', None) or error}") from None
    return parse_fll(text, name)


def parse_fll(text: str, name: str = "fll") -> Sugeno:
    """The system that a text in FuzzyLite's language describes; as :func:`read_fll`, ``name`` stands in messages."""
    return _Reader(name).system(_blocks(text, name))


def write_fll(fis: Sugeno, path: str | os.PathLike[str]) -> None:
    """Write a system as a FuzzyLite file, whole or not at all. Raises FllFileError as :func:`format_fll`, OSError."""
    text = format_fll(fis)
    with replacing(os.fsdecode(path)) as target:
        target.write_text(text, encoding="utf-8")


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
            if kind not in _TERMS:
                known = expected(kind, _TERMS, "term")
                raise self.fail(line, f"{block.name} is {name}: {known}; others have no equal here")
            count, make = _TERMS[kind]
            numbers = [self._number(line, text) for text in texts]
            if len(numbers) == count + 1 and numbers.pop() != 1:
                raise self.fail(line, f"{block.name} is {name}: a height other than 1 has no equal here")
            if len(numbers) != count:
                raise self.fail(line, f"{block.name} is {name}: {kind} has {count} parameters, got {len(numbers)}")
            try:
                terms[name] = make(numbers)
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
        if name not in _DEFUZZIFIERS or kind.strip() not in ("", "Automatic", "TakagiSugeno"):
            raise self.fail(
                line,
                f"{block.name}: the defuzzifier must be WeightedAverage or WeightedSum of TakagiSugeno, got "
                f"{shortened(text)!r}; a Mamdani system is read from a .fis file",
            )
        return "wtaver" if _DEFUZZIFIERS[name] == "wtaver" else "wtsum"

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
        methods: set[tuple[str, str]] = set()
        for block in blocks:
            if not self._truth(block, "enabled", "true"):
                continue
            methods.add((self._method(block, "conjunction", _AND), self._method(block, "disjunction", _OR)))
            line, activation = block.one("activation", "General")
            if activation not in ("General", ""):
                raise self.fail(line, f"activation must be General, got {shortened(activation)!r}")
            rules += [self._rule(line, text, asked, proposed) for line, text in block.all("rule")]
        ands = {conjunction for conjunction, _ in methods if conjunction} or {"prod"}
        ors = {disjunction for _, disjunction in methods if disjunction} or {"probor"}
        if len(ands) > 1 or len(ors) > 1:
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


def format_fll(fis: Sugeno) -> str:
    """A system as a text in FuzzyLite's language; numbers keep all their digits.

    Names become letters, digits and _, as FuzzyLite's are: "Very close" is Very_close. Units are left out. Raises
    FllFileError for a hedge that FuzzyLite does not have, and for functions whose vertices cross.
    """
    fis = _named_plainly(fis)
    rows = [f"Engine: {fis.name}"]
    for variable in fis.inputs:
        rows += ["InputVariable: " + variable.name, "  enabled: true", f"  range: {_numbers(variable.universe)}"]
        rows.append(f"  lock-range: {str(fis.out_of_range == 'clip').lower()}")
        rows += [f"  term: {name} {_written(fis, variable, name, term)}" for name, term in variable.terms.items()]
    kind = "WeightedSum" if fis.defuzzification == "wtsum" else "WeightedAverage"
    for variable in fis.outputs:
        default = variable.midrange if fis.no_rule_fires == "midrange" else math.nan
        rows += ["OutputVariable: " + variable.name, "  enabled: true", f"  range: {_numbers(variable.universe)}"]
        rows += ["  lock-range: false", "  aggregation: none", f"  defuzzifier: {kind} TakagiSugeno"]
        rows += [f"  default: {_numbers([default])}", "  lock-previous: false"]
        for name, term in variable.terms.items():
            what = "Constant" if isinstance(term, Constant) else "Linear"
            rows.append(f"  term: {name} {what} {_numbers([as_number(p) for p in term.parameters])}")
    rows += ["RuleBlock: rules", "  enabled: true"]
    rows.append(f"  conjunction: {_named(_AND, fis.and_method)}")
    rows.append(f"  disjunction: {_named(_OR, fis.or_method)}")
    rows += ["  implication: AlgebraicProduct", "  activation: General"]
    rows += [f"  rule: {_rule_text(fis, k, rule)}" for k, rule in enumerate(fis.rules)]
    return "\n".join(rows) + "\n"


def _named_plainly(fis: Sugeno) -> Sugeno:
    """The system with names that FuzzyLite can hold, all different."""
    taken: list[str] = []
    names: dict[str, str] = {}
    terms: dict[tuple[str, str], str] = {}
    for variable in (*fis.inputs, *fis.outputs):
        names.setdefault(variable.name, _plain(variable.name, taken))
        taken.append(names[variable.name])
        inside: list[str] = []
        for term in variable.terms:
            terms[variable.name, term] = _plain(term, inside)
            inside.append(terms[variable.name, term])

    def renamed(variable: Variable) -> Variable:
        own = {terms[variable.name, name]: term for name, term in variable.terms.items()}
        return replace(variable, name=names[variable.name], terms=own)

    rules = [
        replace(
            rule,
            when=tuple(replace(c, variable=names[c.variable], term=terms[c.variable, c.term]) for c in rule.when),
            then=tuple((names[output], terms[output, term]) for output, term in rule.then),
        )
        for rule in fis.rules
    ]
    inputs, outputs = ([renamed(v) for v in variables] for variables in (fis.inputs, fis.outputs))
    return replace(fis, inputs=inputs, outputs=outputs, rules=rules, name=re.sub(r"[\r\n#]", " ", fis.name))


def _plain(name: str, taken: Sequence[str]) -> str:
    spelt = unicodedata.normalize("NFKD", name).encode("ascii", "ignore").decode()
    plain = first = re.sub(r"\W+", "_", spelt, flags=re.ASCII).strip("_") or "unnamed"
    if first[0].isdigit() or first.casefold() in KEYWORDS:
        plain = first = f"{'t_' if first[0].isdigit() else ''}{first}{'_' if first.casefold() in KEYWORDS else ''}"
    number = 2
    while plain in taken:
        plain, number = f"{first}_{number}", number + 1
    return plain


def _named(known: dict[str, str], method: str) -> str:
    return next(name for name, ours in known.items() if ours == method)


def _numbers(values: Sequence[float]) -> str:
    return " ".join("nan" if math.isnan(v) else repr(float(v)) for v in values)


def _written(fis: Sugeno, variable: Variable, label: str, function: MembershipFunction) -> str:
    p = list(function.numbers)
    name = type(function).__name__
    crossed = {"SShape": p[:2], "ZShape": p[:2], "Trapezoid": p, "PiShape": p}.get(name, [])
    if any(b < a for a, b in pairwise(crossed)) or (
        name in ("SShape", "ZShape", "PiShape") and (p[0] == p[1] or p[-2] == p[-1])
    ):
        raise FllFileError(fis.name, None, f"{variable.name} is {label}: FuzzyLite has no {name} whose vertices cross")
    orders: dict[str, tuple[str, list[float]]] = {
        "LinearS": ("Ramp", p),
        "LinearZ": ("Ramp", p[::-1]),
        "TwoSidedGaussian": ("GaussianProduct", [p[1], p[0], p[3], p[2]] if len(p) == 4 else p),
    }
    if name in ("LinearS", "LinearZ") and p[0] == p[1]:
        raise FllFileError(fis.name, None, f"{variable.name} is {label}: FuzzyLite has no ramp without width")
    if name == "Gaussian":
        return f"Gaussian {_numbers([p[1], p[0]])}"
    if name == "Bell":
        return f"Bell {_numbers([p[2], p[0], p[1]])}"
    if name == "Sigmoid":
        return f"Sigmoid {_numbers([p[1], p[0]])}"
    if name in ("SigmoidDifference", "SigmoidProduct"):
        if name == "SigmoidDifference":
            try:
                _difference([p[1], p[0], p[2], p[3]])
            except MembershipError as error:
                raise FllFileError(fis.name, None, f"{variable.name} is {label}: {error}") from None
        return f"{name} {_numbers([p[1], p[0], p[2], p[3]])}"
    kind, values = orders.get(name, (name, p))
    return f"{kind} {_numbers(values)}"


def _rule_text(fis: Sugeno, k: int, rule: Rule) -> str:
    clauses = []
    for clause in rule.when:
        hedges = hedge_words(clause.power)
        if hedges is None or "extremely" in hedges:
            raise FllFileError(
                fis.name,
                None,
                f"rule {k + 1}: FuzzyLite has no hedge for the power {clause.power:g}",
            )
        words = ["not"] * clause.negated + hedges.split()
        clauses.append(" ".join([clause.variable, "is", *words, clause.term]))
    then = " and ".join(f"{output} is {term}" for output, term in rule.then)
    weight = "" if rule.weight == 1 else f" with {rule.weight!r}"
    return f"if {f' {rule.connective} '.join(clauses)} then {then}{weight}"
