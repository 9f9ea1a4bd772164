"""MATLAB's .fis files: Sugeno systems are read and written without loss.

    fis = read_fis("tip.fis")
    write_fis(fis, "copy.fis")

A number is written with all the digits it needs and is read exactly. The format has no place for units, nor for what
to do where no rule fires or an input leaves its range; these are written in comments, which MATLAB and Octave skip:
``%! Unit='m'``. The order of the clauses within a rule is not kept: it becomes the order of the inputs.

ImpMethod and AggMethod are kept as they are and have no effect: a Sugeno system multiplies and sums, as in MATLAB.
"""

import math
import os
import re
import warnings
from collections.abc import Collection, Iterator, Sequence
from pathlib import Path
from typing import Any

from fuzzy.files.atomic import replacing
from fuzzy.files.fislines import LINE_END, SYSTEM_NOTES, Entry, FisFileError, FisFileWarning, FisLines, Section
from fuzzy.membership import membership_function
from fuzzy.membershipfunction import MATLAB_NAMES, MembershipError, as_number
from fuzzy.naming import expected
from fuzzy.rule import Clause, Rule
from fuzzy.system import Constant, FuzzySystemError, Linear, Sugeno, Terms, Variable

__all__ = ["FisFileError", "FisFileWarning", "format_fis", "parse_fis", "read_fis", "write_fis"]

_CONSEQUENTS = ("constant", "linear")
# Names may hold quotes, colons and brackets: the name begins at the first quote and ends at the last "':'type',[".
_TERM = re.compile(r"'(?P<name>.*)'\s*:\s*'(?P<type>[^']*)'\s*,\s*\[(?P<parameters>[^\[\]]*)\]")
_RULE = re.compile(r"(?P<inputs>[^,]*),(?P<outputs>[^()]*)\((?P<weight>[^()]*)\)\s*:\s*(?P<connective>\S+)")
_INDEX = re.compile(r"(?P<sign>[+-]?)(?P<place>\d{1,9})(?:\.(?P<hedge>\d*))?", re.ASCII)
_NUMBER = re.compile(r"[+-]?(?:\d+\.?\d*|\.\d+)(?:e[+-]?\d+)?", re.IGNORECASE | re.ASCII)


def read_fis(path: str | os.PathLike[str]) -> Sugeno:
    """Read the Sugeno system in a .fis file, in UTF-8 or in the Windows encoding of old MATLAB files.

    Raises FisFileError, with the file and the line, for a text that is no Sugeno system of MATLAB's. Warns
    (FisFileWarning) of names that occur twice (the later one becomes "name_2"), of hedges that MATLAB does not know,
    of disabled variables, and of a file that is not in UTF-8.
    """
    name = os.fsdecode(path)
    try:
        data = Path(name).read_bytes()
    except (OSError, ValueError) as error:
        raise FisFileError(name, None, f"cannot be read: {getattr(error, 'strerror', None) or error}") from None
    if b"\0" in data:
        raise FisFileError(name, None, "is no .fis file: it holds binary data")
    messages = []
    try:
        text = data.decode("utf-8-sig")
    except UnicodeDecodeError as error:
        line = len(LINE_END.split(data[: error.start].decode("latin-1")))
        encoding = "latin-1" if set(data) & {0x81, 0x8D, 0x8F, 0x90, 0x9D} else "cp1252"
        text = data.decode(encoding)
        messages.append(f"{name}:{line}: this is not UTF-8; read as {encoding}, check the names")
    reader = _Reader(name)
    fis = reader.system(text)
    for message in messages + reader.warnings:
        warnings.warn(message, FisFileWarning, stacklevel=2)
    return fis


def parse_fis(text: str, name: str = "<text>") -> Sugeno:
    """Read the Sugeno system that ``text`` describes, as :func:`read_fis` does. Messages call the file ``name``."""
    reader = _Reader(name)
    fis = reader.system(text.removeprefix("\ufeff"))
    for message in reader.warnings:
        warnings.warn(message, FisFileWarning, stacklevel=2)
    return fis


class _Reader(FisLines):
    """Makes a system of one text."""

    def system(self, text: str) -> Sugeno:
        sections = self.sections(text)
        if "System" not in sections:
            what = "is empty" if not text.strip() else "is no .fis file: it has no section [System]"
            raise FisFileError(self.path, None, what)
        system = sections["System"]
        self._check_type(system)
        inputs = self._variables(sections, "Input", self._count(system, "NumInputs"), None)
        outputs = self._variables(sections, "Output", self._count(system, "NumOutputs"), len(inputs))
        lines = sections["Rules"].rules if "Rules" in sections else []
        count = self._count(system, "NumRules")
        if count != len(lines):
            raise self.error(system.entries["NumRules"], f"NumRules is {count}, but the file has {len(lines)} rules")
        settings: dict[str, Any] = {
            "name": self._string(system, "Name"),
            "and_method": self._choice(system, "AndMethod", ("prod", "min")),
            "or_method": self._choice(system, "OrMethod", ("probor", "max")),
            "defuzzification": self._choice(system, "DefuzzMethod", ("wtaver", "wtsum")),
        }
        for attribute, key in (("implication", "ImpMethod"), ("aggregation", "AggMethod")):
            if key in system.entries:
                settings[attribute] = self._string(system, key)
        for key, (attribute, accepted) in SYSTEM_NOTES.items():
            if key in system.entries:
                settings[attribute] = self._choice(system, key, accepted)
        rules = [self._rule(line, inputs, outputs) for line in lines]
        try:
            return Sugeno(inputs, outputs, rules, **settings)
        except FuzzySystemError as error:
            raise self.error(system, str(error)) from None

    def _check_type(self, system: Section) -> None:
        kind = self._string(system, "Type")
        if kind.casefold() == "mamdani":
            reason = "this is a Mamdani system; only Sugeno systems are read (MATLAB's convertToSugeno makes one of it)"
            raise self.error(system.entries["Type"], reason)
        if kind.casefold() != "sugeno":
            raise self.error(system.entries["Type"], expected(kind, ("sugeno",), "type of system"))

    def _get(self, section: Section, key: str) -> Entry:
        if key not in section.entries:
            raise self.error(section, f"{section.title} has no {key}")
        return section.entries[key]

    def _string(self, section: Section, key: str) -> str:
        entry = self._get(section, key)
        value = entry.value
        if not (len(value) >= 2 and value[0] == value[-1] == "'"):
            raise self.error(entry, f"{key} must stand in single quotes, got {value!r}")
        return value[1:-1]

    def _choice(self, section: Section, key: str, accepted: Collection[str]) -> str:
        value = self._string(section, key)
        if value.casefold() not in accepted:
            raise self.error(section.entries[key], expected(value, accepted, key))
        return value.casefold()

    def _count(self, section: Section, key: str) -> int:
        entry = self._get(section, key)
        if not re.fullmatch(r"\d{1,9}", entry.value, re.ASCII):
            raise self.error(entry, f"{key} must be a number of things, 0, 1, 2, ..., got {entry.value!r}")
        return int(entry.value)

    def _numbers(self, text: str, at: Entry, what: str) -> list[float]:
        words = text.replace(",", " ").split()
        for word in words:
            if not _NUMBER.fullmatch(word) or not math.isfinite(float(word)):
                raise self.error(at, f"{what}: expected a finite number, got {word!r}")
        return [float(word) for word in words]

    def _unique(self, name: str, taken: Collection[str], at: Entry, what: str) -> str:
        if name not in taken:
            return name
        number = 2
        while f"{name}_{number}" in taken:
            number += 1
        self.warn(at, f"a second {what} named {name!r} is read as {f'{name}_{number}'!r}")
        return f"{name}_{number}"

    def _variables(self, sections: dict[str, Section], kind: str, count: int, inputs: int | None) -> list[Variable]:
        counter = sections["System"].entries[f"Num{kind}s"]
        if count == 0:
            raise self.error(counter, f"a Sugeno system needs at least one {kind.casefold()}")
        present = {int(title[len(kind) :]): s for title, s in sections.items() if title.startswith(kind)}
        for number, section in present.items():
            if number > count:
                raise self.error(section, f"Num{kind}s is {count}, but the file has [{kind}{number}]")
        variables: list[Variable] = []
        for number in range(1, count + 1):
            if number not in present:
                raise self.error(counter, f"Num{kind}s is {count}, but the file has no [{kind}{number}]")
            taken = [v.name for v in variables]
            variables.append(self._variable(present[number], taken, kind.casefold(), inputs))
        return variables

    def _variable(self, section: Section, taken: Sequence[str], kind: str, inputs: int | None) -> Variable:
        name = self._unique(self._string(section, "Name"), taken, section.entries["Name"], kind)
        at = self._get(section, "Range")
        bounds = re.fullmatch(r"\[([^\[\]]*)\]", at.value)
        universe = self._numbers(bounds[1], at, "Range") if bounds else []
        if len(universe) != 2:
            raise self.error(at, f"Range must be two numbers, [lowest highest], got {at.value!r}")
        count = self._count(section, "NumMFs")
        for number, entry in section.terms.items():
            if number > count:
                raise self.error(entry, f"NumMFs is {count}, but {section.title} has MF{number}")
        terms: dict[str, Any] = {}
        for number in range(1, count + 1):
            if number not in section.terms:
                raise self.error(section.entries["NumMFs"], f"NumMFs is {count}, but there is no MF{number}")
            label, term = self._term(section.terms[number], inputs)
            terms[self._unique(label, terms, section.terms[number], f"term of {name!r}")] = term
        enabled = section.entries.get("Enabled")
        if enabled and enabled.value in ("0", "false"):
            self.warn(enabled, f"Enabled is fuzzylite's and is ignored: {name!r} takes part")
        unit = self._string(section, "Unit") if "Unit" in section.entries else ""
        try:
            return Variable(name, (universe[0], universe[1]), Terms(terms), unit)
        except FuzzySystemError as error:
            raise self.error(at, str(error)) from None

    def _term(self, at: Entry, inputs: int | None) -> tuple[str, Any]:
        """Name and function of one term; ``inputs`` is how many the system has, None for the term of an input."""
        accepted = tuple(MATLAB_NAMES) if inputs is None else _CONSEQUENTS
        line = _TERM.fullmatch(at.value)
        if line is None:
            form = "'name':'trimf',[a b c]" if inputs is None else "'name':'constant',[c]"
            raise self.error(at, f"expected MF1={form}, of the types {', '.join(accepted)}; got {at.value!r}")
        name, kind = line["name"], line["type"].casefold()
        if kind not in accepted:
            what = "membership function" if inputs is None else "Sugeno consequent"
            raise self.error(at, f"{name}: " + expected(line["type"], accepted, what))
        parameters = self._numbers(line["parameters"], at, f"{name}: {kind}")
        if inputs is None:
            try:
                return name, membership_function(kind, parameters)
            except MembershipError as error:
                raise self.error(at, f"{name}: {error}") from None
        wanted = 1 if kind == "constant" else inputs + 1
        if len(parameters) != wanted:
            form = "[c]" if kind == "constant" else "[p1 ... pn p0], one an input and the constant"
            count = f"{wanted} parameter{'s' if wanted > 1 else ''}"
            raise self.error(at, f"{name}: {kind} takes {count} {form}, got {len(parameters)}")
        return name, Constant(parameters[0]) if kind == "constant" else Linear(parameters[:-1], parameters[-1])

    def _rule(self, at: Entry, inputs: Sequence[Variable], outputs: Sequence[Variable]) -> Rule:
        line = _RULE.fullmatch(at.text)
        if line is None:
            raise self.error(at, "expected a rule, 'terms of the inputs, terms of the outputs (weight) : 1 or 2'")
        when = [
            Clause(variable.name, term, negated, power)
            for variable, term, negated, power in self._indices(line["inputs"], inputs, at, "input")
        ]
        then = []
        for variable, term, negated, power in self._indices(line["outputs"], outputs, at, "output"):
            if negated or power != 1:
                raise self.error(at, f"a Sugeno consequent takes no 'not' and no hedge: {line['outputs'].strip()!r}")
            then.append((variable.name, term))
        if not when or not then:
            raise self.error(at, f"a rule needs an {'input' if not when else 'output'} that is not 0")
        weight = self._numbers(line["weight"], at, "weight")
        if len(weight) != 1 or not 0 <= weight[0] <= 1:
            raise self.error(at, f"the weight must be a number in [0, 1], got {line['weight']!r}")
        if line["connective"] not in ("1", "2"):
            raise self.error(at, f"expected 1 (and) or 2 (or) after ':', got {line['connective']!r}")
        return Rule(tuple(when), tuple(then), "and" if line["connective"] == "1" else "or", weight[0])

    def _indices(
        self, text: str, variables: Sequence[Variable], at: Entry, kind: str
    ) -> Iterator[tuple[Variable, str, bool, float]]:
        """Variable, term, negation and power for each index of a rule that is not 0."""
        words = text.split()
        if len(words) != len(variables):
            raise self.error(at, f"expected {len(variables)} {kind} terms, one for each {kind}, got {len(words)}")
        for word, variable in zip(words, variables, strict=True):
            index = _INDEX.fullmatch(word)
            if index is None:
                raise self.error(at, f"expected the number of a term of {variable.name!r}, got {word!r}")
            place = int(index["place"])
            # MATLAB has no hedges. Octave's: the fraction .20 is the power 2 (very), .05 is 0.5 (somewhat).
            power = round(100 * float(f"0.{index['hedge']}")) / 10 if index["hedge"] else 0.0
            if power == 0 and (index["hedge"] or "").strip("0"):
                raise self.error(at, f"the hedge of {word} is below .01, the power 0.1")
            if place == 0 and power == 0:
                continue
            if not 1 <= place <= len(variable.terms):
                names = ", ".join(f"{n} {name!r}" for n, name in enumerate(variable.terms, start=1)) or "none"
                raise self.error(at, f"{variable.name!r} has no term number {word}; it has {names}")
            if power and kind == "input":
                self.warn(at, f"{word} is read as Octave's hedge: {variable.name!r} to the power {power}")
            yield variable, list(variable.terms)[place - 1], index["sign"] == "-", power or 1.0


# Writing ------------------------------------------------------------------------------------------------------


def write_fis(fis: Sugeno, path: str | os.PathLike[str], comment: str = "") -> None:
    """Write ``fis`` as the .fis file ``path`` in UTF-8. An older file stays until the new one is whole.

    The lines of ``comment``, if there are any, stand at the top of the file; the first one is its title.

    Raises FisFileError if the format cannot hold the system (see :func:`format_fis`) or the file cannot be written.
    """
    name = os.fsdecode(path)
    text = "".join(f"% {line}\n" for line in comment.splitlines()) + _format(fis, name)
    try:
        with replacing(name) as part:
            part.write_text(text, encoding="utf-8", newline="\n")
    except UnicodeEncodeError as error:
        raise FisFileError(name, None, f"a name holds no valid text: {error.object[error.start]!r}") from None
    except OSError as error:
        raise FisFileError(name, None, f"cannot be written: {error.strerror or error}") from None


def format_fis(fis: Sugeno) -> str:
    """Format ``fis`` as the text of a .fis file. Parameters that are torch tensors are written as numbers.

    Raises FisFileError for a name that holds a line break, a number that is not finite, and a hedge whose power is not
    a multiple of 0.1 below 10.
    """
    return _format(fis, fis.name)


def _format(fis: Sugeno, path: str) -> str:
    def quoted(text: str, what: str) -> str:
        if any(c in text for c in "\n\r\0"):
            raise FisFileError(path, None, f"the format has no room for a line end in {what}: {text!r}")
        return f"'{text}'"

    def number(value: Any, what: str) -> str:
        try:
            value = as_number(value)
        except MembershipError as error:
            raise FisFileError(path, None, f"{what}: {error}") from None
        if not math.isfinite(value):
            raise FisFileError(path, None, f"{what}: a parameter must be finite, got {value}")
        return repr(value).removesuffix(".0")

    def index(rule: Rule, variable: Variable) -> str:
        for clause in rule.when:
            if clause.variable == variable.name:
                place = list(variable.terms).index(clause.term) + 1
                tenths = round(10 * clause.power) if clause.power < 10 else 0
                if not 1 <= tenths <= 99 or tenths / 10 != clause.power:
                    raise FisFileError(
                        path,
                        None,
                        f"the format has no room for the power {clause.power!r} in {rule}: only 0.1, 0.2, ... 9.9",
                    )
                hedge = "" if tenths == 10 else f".{tenths:02d}"
                return f"{'-' if clause.negated else ''}{place}{hedge}"
        return "0"

    lines = ["[System]", f"Name={quoted(fis.name, 'the name')}", "Type='sugeno'", "Version=2.0"]
    lines += [f"NumInputs={len(fis.inputs)}", f"NumOutputs={len(fis.outputs)}", f"NumRules={len(fis.rules)}"]
    lines += [f"AndMethod='{fis.and_method}'", f"OrMethod='{fis.or_method}'"]
    lines += [f"ImpMethod={quoted(fis.implication, 'implication')}"]
    lines += [f"AggMethod={quoted(fis.aggregation, 'aggregation')}", f"DefuzzMethod='{fis.defuzzification}'"]
    for key, (attribute, choices) in SYSTEM_NOTES.items():
        if getattr(fis, attribute) != choices[0]:  # the first is the default
            lines.append(f"%! {key}='{getattr(fis, attribute)}'")
    numbered = [(f"Input{i}", v) for i, v in enumerate(fis.inputs, start=1)]
    numbered += [(f"Output{j}", v) for j, v in enumerate(fis.outputs, start=1)]
    for title, variable in numbered:
        low, high = (number(end, variable.name) for end in variable.universe)
        lines += ["", f"[{title}]", f"Name={quoted(variable.name, 'a name')}"]
        if variable.unit:
            lines.append(f"%! Unit={quoted(variable.unit, 'a unit')}")
        lines += [f"Range=[{low} {high}]", f"NumMFs={len(variable.terms)}"]
        for place, (label, term) in enumerate(variable.terms.items(), start=1):
            kind = type(term).__name__.casefold() if isinstance(term, (Constant, Linear)) else term.matlab
            parameters = " ".join(number(p, f"{variable.name} is {label}") for p in term.parameters)
            lines.append(f"MF{place}={quoted(label, 'a name')}:'{kind}',[{parameters}]")
    lines += ["", "[Rules]"]
    for rule in fis.rules:
        assert isinstance(rule, Rule)
        consequents = dict(rule.then)
        when = " ".join(index(rule, v) for v in fis.inputs)
        then = " ".join(
            str(list(v.terms).index(consequents[v.name]) + 1) if v.name in consequents else "0" for v in fis.outputs
        )
        connective = 1 if rule.connective == "and" else 2
        lines.append(f"{when}, {then} ({number(rule.weight, str(rule))}) : {connective}")
    return "\n".join(lines) + "\n"
