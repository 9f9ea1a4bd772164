"""MATLAB's .fis files: Sugeno systems are read and written without loss.

    fis = read_fis("tip.fis")
    write_fis(fis, "copy.fis")

A number is written with all the digits it needs and is read exactly. The format has no place for units, nor for what
to do where no rule fires or an input leaves its range; these are written in comments, which MATLAB and Octave skip:
``%! Unit='m'``. The order of the clauses within a rule is not kept: it becomes the order of the inputs.

ImpMethod and AggMethod are kept as they are and have no effect: a Sugeno system multiplies and sums, as in MATLAB.

    fis, changes = read_mamdani("old.fis")

A Mamdani system is read as the Sugeno system that comes near it, and only by that function: it answers otherwise.
"""

import math
import os
import re
import warnings
from collections.abc import Collection, Iterator, Mapping, Sequence
from functools import partial
from typing import Any, NamedTuple

from fuzzy.errors import quoted, shortened
from fuzzy.files.atomic import write_whole
from fuzzy.files.fislines import (
    HEDGES_NOTE,
    LINE_END,
    LOOP_NOTE,
    LOWER_NOTE,
    REDUCTION_NOTE,
    SYSTEM_NOTES,
    FileSection,
    FisLines,
    SectionLine,
    file_bytes,
)
from fuzzy.files.fislines import FisFileError as FisFileError
from fuzzy.files.fislines import FisFileWarning as FisFileWarning
from fuzzy.files.mamdani import DEFUZZIFICATIONS, MamdaniParts, as_constants, renounced
from fuzzy.membership import membership_function
from fuzzy.membershipfunction import MATLAB_NAMES, MembershipError, as_number
from fuzzy.naming import expected
from fuzzy.rule import Clause, Rule
from fuzzy.system import Constant, FuzzySystemError, Linear, Sugeno, Terms, Variable
from fuzzy.words import counted

# What one file may hold; far more than anybody reads, so that no file keeps the reader busy for minutes.
_MOST_VARIABLES = 1_000  # inputs or outputs
_MOST_TERMS = 10_000  # of a variable
_MOST_RULES = 100_000  # rules
_LISTED = 1000  # characters of the list of terms that a message shows
_DEFUZZIFICATIONS = ("wtaver", "wtsum")
_TYPE_2 = (
    "this is an interval type-2 system; only type-1 systems are read here. fuzzy.read_type2 in Python reads it, and "
    "`fuzzy evaluate`, `fuzzy plot` and `fuzzy design` take it"
)
_MATLABS_TYPE_2 = (
    "this is MATLAB's own text of a type-2 system, whose format is not documented and not read. In MATLAB, write "
    "convertToType1(fis); `fuzzy type2`, or fuzzy.to_type2 in Python, adds the lags and scales"
)
_CONSEQUENTS = ("constant", "linear")
# Names may hold quotes, colons and brackets: the name begins at the first quote and ends at the last "':'type',[".
_TERM = re.compile(r"'(?P<name>.*)'\s*:\s*'(?P<type>[^']*)'\s*,\s*\[(?P<parameters>[^\[\]]*)\]")
_RULE = re.compile(r"(?P<inputs>[^,]*),(?P<outputs>[^()]*)\((?P<weight>[^()]*)\)\s*:\s*(?P<connective>\S+)")
_INDEX = re.compile(r"(?P<sign>[+-]?)(?P<place>\d{1,9})(?:\.(?P<hedge>\d*))?", re.ASCII)
_NUMBER = re.compile(r"[+-]?(?:\d+\.?\d*|\.\d+)(?:e[+-]?\d+)?", re.IGNORECASE | re.ASCII)


class MamdaniError(FisFileError):
    """The error for a file that describes a Mamdani system where a Sugeno system is wanted."""


class Type2Error(FisFileError):
    """The error for a file that describes an interval type-2 system where a type-1 system is wanted."""


class MamdaniSystem(NamedTuple):
    """A Mamdani file as a Sugeno system.

    Attributes:
        system: The Sugeno system.
        changes: What became another thing, a sentence each.
    """

    system: Sugeno
    changes: tuple[str, ...]


class FaultyRule(NamedTuple):
    """A line of the section [Rules] that is no rule."""

    place: int  # among the section's lines, from 0
    line: int  # of the file, from 1
    text: str
    reason: str


class FisText(NamedTuple):
    """What the bytes of a .fis file hold."""

    system: Sugeno
    changes: tuple[str, ...]  # of a Mamdani system, what became another thing, a sentence each
    warnings: tuple[str, ...]
    faults: tuple[FaultyRule, ...] = ()  # where such lines are left out
    reduction: SectionLine | None = None  # of a type-2 system
    lower: tuple[SectionLine | None, ...] = ()  # likewise, by input


def read_fis(path: str | os.PathLike[str]) -> Sugeno:
    """Read the Sugeno system in a .fis file, in UTF-8 or in the Windows encoding of old MATLAB files (MATLAB's
    ``readfis``).

    Warns (FisFileWarning) of names that occur twice (the later one becomes "name_2"), of hedges that MATLAB does not
    know, of zeros behind a term's parameters, of disabled variables, and of a file that is not in UTF-8.

    Args:
        path: The file.

    Returns:
        The system.

    Raises:
        FisFileError: A text that is no Sugeno system of MATLAB's, with the file and the line, or one of more than 1,000
            inputs or outputs, 10,000 terms of a variable or 100,000 rules.
        MamdaniError: A Mamdani system, which :func:`read_mamdani` reads.
        Type2Error: An interval type-2 system, which ``fuzzy.read_type2`` reads.
    """
    name = os.fsdecode(path)
    return warned(parse_bytes(file_bytes(name), name)).system


def read_mamdani(path: str | os.PathLike[str]) -> MamdaniSystem:
    """Read the Mamdani system in a .fis file as a Sugeno system, as MATLAB's ``convertToSugeno`` makes one.

    Inputs, rules, weights and the methods of "and" and "or" stay. Each set of an output becomes a constant at its
    centroid over the output's range, "not set" one at the centroid of 1 - set; the output is their weighted average.
    Between the constants its values differ from the Mamdani system's, whose sets have widths and overlap. A Sugeno
    system is read as it is, without changes. Warns as :func:`read_fis` does.

    Args:
        path: The file.

    Returns:
        The system, and what was changed.

    Raises:
        FisFileError: As of :func:`read_fis`.
    """
    name = os.fsdecode(path)
    read = warned(parse_bytes(file_bytes(name), name, mamdani=True))
    return MamdaniSystem(read.system, read.changes)


def warned(read: FisText) -> FisText:
    """The same, with its warnings given, as of the caller's caller."""
    for message in read.warnings:
        warnings.warn(message, FisFileWarning, stacklevel=3)
    return read


def parse_bytes(data: bytes, name: str, mamdani: bool = False, lenient: bool = False, type2: bool = False) -> FisText:
    """Read the bytes of a .fis file, in UTF-8 or in the Windows encoding of old MATLAB files.

    Raises FisFileError as :func:`read_fis` does.

    Args:
        data: The bytes.
        name: What messages call the file.
        mamdani: Whether a Mamdani system is read as a Sugeno system, see :func:`read_mamdani`.
        lenient: Whether rules of a Sugeno system that cannot be read are left out, and told as ``faults``.
        type2: Whether an interval type-2 system is read, as its upper system, with the lines of the others.
    """
    return parse_original(data, name, mamdani, lenient, type2)[0]


def parse_original(
    data: bytes, name: str, mamdani: bool = True, lenient: bool = False, type2: bool = False
) -> tuple[FisText, MamdaniParts | None]:
    """What :func:`parse_bytes` reads of the same arguments, and a Mamdani system as the file describes it."""
    text, messages = decoded(data, name)
    reader = _Reader(name, mamdani, lenient, type2)
    read = reader.read(text)
    return read._replace(warnings=(*messages, *read.warnings)), reader.original


def decoded(data: bytes, name: str) -> tuple[str, list[str]]:
    """The text of a .fis file called ``name``, and what to say of its encoding. Raises FisFileError for binary data."""
    if b"\0" in data:
        raise FisFileError(name, None, "is no .fis file: it holds binary data")
    try:
        return data.decode("utf-8-sig"), []
    except UnicodeDecodeError as error:
        line = len(LINE_END.split(data[: error.start].decode("latin-1")))
        encoding = "latin-1" if set(data) & {0x81, 0x8D, 0x8F, 0x90, 0x9D} else "cp1252"
        return data.decode(encoding), [f"{name}:{line}: this is not UTF-8; read as {encoding}, check the names"]


def parse_rule_line(text: str, fis: Sugeno) -> Rule:
    """The rule that a line of the section [Rules] states of the terms of ``fis``. Raises FisFileError."""
    when, then = ({v.name: tuple(v.terms) for v in variables} for variables in (fis.inputs, fis.outputs))
    return _Reader("")._rule(SectionLine(1, text.strip(), ""), when, then, False)


def parse_fis(text: str, name: str = "<text>") -> Sugeno:
    """The Sugeno system that a text describes, read as :func:`read_fis` reads a file.

    Args:
        text: The text of a .fis file.
        name: What messages call the file.

    Raises:
        FisFileError: As :func:`read_fis` does.
        MamdaniError: As :func:`read_fis` does.
    """
    return warned(_Reader(name).read(text.removeprefix("\ufeff"))).system


class _Reader(FisLines):
    """Makes a system of one text.

    ``mamdani``: is a Mamdani system read as a Sugeno system? Then ``changes`` says what became another thing.
    ``lenient``: are wrong rules of a Sugeno system left out? Then ``faults`` has them.
    ``type2``: is the upper system of an interval type-2 system read?
    """

    hedged = False  # does the file say that fractions in its rules are hedges?

    def __init__(self, path: str, mamdani: bool = False, lenient: bool = False, type2: bool = False) -> None:
        super().__init__(path)
        self.mamdani, self.lenient, self.type2 = mamdani, lenient, type2
        self.reduction: SectionLine | None = None
        self.lower: tuple[SectionLine | None, ...] = ()
        self.faults: list[FaultyRule] = []
        self.changes: list[str] = []
        self.original: MamdaniParts | None = None
        self.complements: dict[str, dict[str, str]] = {}  # by output: negated sets, and what their terms are called
        self.padded: list[SectionLine] = []  # terms with zeros behind their parameters

    def read(self, text: str) -> FisText:
        system = self._system(text)
        if self.padded:
            terms = counted(len(self.padded), "term")
            self.warn(self.padded[0], f"zeros behind the parameters, as in MATLAB's old files, are left out of {terms}")
        told = tuple(self.changes), tuple(self.warnings), tuple(self.faults)
        return FisText(system, *told, self.reduction, self.lower)

    def _system(self, text: str) -> Sugeno:
        sections = self.sections(text)
        if "System" not in sections:
            what = "is empty" if not text.strip() else "is no .fis file: it has no section [System]"
            raise FisFileError(self.path, None, what)
        system = sections["System"]
        mamdani = self._is_mamdani(system)
        inputs = self._variables(sections, "Input", self._count(system, "NumInputs", _MOST_VARIABLES), None)
        count = self._count(system, "NumOutputs", _MOST_VARIABLES)
        outputs = self._variables(sections, "Output", count, None if mamdani else len(inputs))
        self.lower = tuple(sections[f"Input{n}"].entries.get(LOWER_NOTE) for n in range(1, len(inputs) + 1))
        self.reduction = system.entries.get(REDUCTION_NOTE)
        if self.reduction and not self.type2:
            raise Type2Error(self.path, self.reduction.line, f"{_TYPE_2}\n  {shortened(self.reduction.text)}")
        lines = sections["Rules"].rules if "Rules" in sections else []
        count = self._count(system, "NumRules", _MOST_RULES)
        if count != len(lines):
            raise self.error(system.entries["NumRules"], f"NumRules is {count}, but the file has {len(lines)} rules")
        settings: dict[str, Any] = {
            "name": self._string(system, "Name"),
            "and_method": self._choice(system, "AndMethod", ("prod", "min")),
            "or_method": self._choice(system, "OrMethod", ("probor", "max")),
            "defuzzification": self._choice(system, "DefuzzMethod", DEFUZZIFICATIONS if mamdani else _DEFUZZIFICATIONS),
        }
        for attribute, key in (("implication", "ImpMethod"), ("aggregation", "AggMethod")):
            if key in system.entries:
                settings[attribute] = self._string(system, key)
        if LOOP_NOTE in system.entries:
            settings["loop"] = self._string(system, LOOP_NOTE)
        for key, (attribute, accepted) in SYSTEM_NOTES.items():
            if key in system.entries:
                settings[attribute] = self._choice(system, key, accepted)
        self.hedged = HEDGES_NOTE in system.entries and bool(self._choice(system, HEDGES_NOTE, ("octave",)))
        when, then = ({v.name: tuple(v.terms) for v in variables} for variables in (inputs, outputs))
        lenient = self.lenient and not mamdani and any(when.values()) and any(then.values())
        rules = []
        for place, line in enumerate(lines):
            try:
                rules.append(self._rule(line, when, then, mamdani))
            except FisFileError as error:
                if not lenient:
                    raise
                reason = error.reason.partition("\n")[0]  # without the line, which is quoted there
                self.faults.append(FaultyRule(place, line.line, line.text, reason))
        if mamdani:
            self.original = MamdaniParts(tuple(inputs), tuple(outputs), tuple(rules), dict(settings), self.complements)
            settings, changes = renounced(settings)
            converted = [as_constants(variable, self.complements.get(variable.name, {})) for variable in outputs]
            outputs = [variable for variable, _ in converted]
            self.changes = [change for _, said in converted for change in said] + changes
        try:
            return Sugeno(inputs, outputs, rules, **settings)
        except FuzzySystemError as error:
            raise self.error(system, shortened(str(error), _LISTED)) from None

    def _is_mamdani(self, system: FileSection) -> bool:
        """Is it a Mamdani system that is read as a Sugeno system?"""
        kind, at = self._string(system, "Type"), self._get(system, "Type")
        if kind.casefold() == "mamdani" and not self.mamdani:
            reason = (
                "this is a Mamdani system; only Sugeno systems are read here. `fuzzy convert OLD.fis NEW.fis`, or "
                "fuzzy.read_mamdani in Python, makes one of it\n  " + shortened(at.text)
            )
            raise MamdaniError(self.path, at.line, reason)
        if "type2" in kind.casefold().replace("-", ""):
            raise Type2Error(self.path, at.line, f"{_MATLABS_TYPE_2}\n  {shortened(at.text)}")
        if kind.casefold() not in ("sugeno", "mamdani"):
            raise self.error(at, expected(kind, ("sugeno", "mamdani"), "type of system"))
        return kind.casefold() == "mamdani"

    def _get(self, section: FileSection, key: str) -> SectionLine:
        if key not in section.entries:
            raise self.error(section, f"{section.title} has no {key}")
        return section.entries[key]

    def _string(self, section: FileSection, key: str) -> str:
        entry = self._get(section, key)
        value = entry.value
        if not (len(value) >= 2 and value[0] == value[-1] == "'"):
            raise self.error(entry, f"{key} must stand in single quotes, got {quoted(value)}")
        return value[1:-1]

    def _choice(self, section: FileSection, key: str, accepted: Collection[str]) -> str:
        value = self._string(section, key)
        if value.casefold() not in accepted:
            raise self.error(section.entries[key], expected(value, accepted, key))
        return value.casefold()

    def _count(self, section: FileSection, key: str, most: int) -> int:
        entry = self._get(section, key)
        if not re.fullmatch(r"\d{1,9}", entry.value, re.ASCII):
            raise self.error(entry, f"{key} must be a number of things, 0, 1, 2, ..., got {quoted(entry.value)}")
        if int(entry.value) > most:
            raise self.error(entry, f"{key} is {entry.value}, but at most {most} are read")
        return int(entry.value)

    def _numbers(self, text: str, at: SectionLine, what: str) -> list[float]:
        words = text.replace(",", " ").split()
        for word in words:
            if not _NUMBER.fullmatch(word) or not math.isfinite(float(word)):
                raise self.error(at, f"{what}: expected a finite number, got {quoted(word)}")
        return [float(word) for word in words]

    def _unique(self, name: str, taken: dict[str, int], at: SectionLine, what: str) -> str:
        """``name``, or with a number where it is ``taken``, which maps the names so far to their last numbers."""
        if name not in taken:
            taken[name] = 1
            return name
        number = taken[name] + 1  # where counting ended: many of one name are no reason to count again for each
        while f"{name}_{number}" in taken:
            number += 1
        taken[name], taken[f"{name}_{number}"] = number, 1
        self.warn(at, f"a second {what} named {quoted(name)} is read as {quoted(f'{name}_{number}')}")
        return f"{name}_{number}"

    def _variables(self, sections: dict[str, FileSection], kind: str, count: int, inputs: int | None) -> list[Variable]:
        counter = sections["System"].entries[f"Num{kind}s"]
        if count == 0:
            raise self.error(counter, f"a Sugeno system needs at least one {kind.casefold()}")
        present = {int(title[len(kind) :]): s for title, s in sections.items() if title.startswith(kind)}
        for number, section in present.items():
            if number > count:
                raise self.error(section, f"Num{kind}s is {count}, but the file has [{kind}{number}]")
        variables: list[Variable] = []
        taken: dict[str, int] = {}
        for number in range(1, count + 1):
            if number not in present:
                raise self.error(counter, f"Num{kind}s is {count}, but the file has no [{kind}{number}]")
            variables.append(self._variable(present[number], taken, kind.casefold(), inputs))
        return variables

    def _variable(self, section: FileSection, taken: dict[str, int], kind: str, inputs: int | None) -> Variable:
        name = self._unique(self._string(section, "Name"), taken, section.entries["Name"], kind)
        at = self._get(section, "Range")
        bounds = re.fullmatch(r"\[([^\[\]]*)\]", at.value)
        universe = self._numbers(bounds[1], at, "Range") if bounds else []
        if len(universe) != 2:
            raise self.error(at, f"Range must be two numbers, [lowest highest], got {quoted(at.value)}")
        count = self._count(section, "NumMFs", _MOST_TERMS)
        for number, entry in section.terms.items():
            if number > count:
                raise self.error(entry, f"NumMFs is {count}, but {section.title} has MF{number}")
        terms: dict[str, Any] = {}
        labels: dict[str, int] = {}
        for number in range(1, count + 1):
            if number not in section.terms:
                raise self.error(section.entries["NumMFs"], f"NumMFs is {count}, but there is no MF{number}")
            label, term = self._term(section.terms[number], inputs)
            terms[self._unique(label, labels, section.terms[number], f"term of {quoted(name)}")] = term
        enabled = section.entries.get("Enabled")
        if enabled and enabled.value in ("0", "false"):
            self.warn(enabled, f"Enabled is fuzzylite's and is ignored: {quoted(name)} takes part")
        unit = self._string(section, "Unit") if "Unit" in section.entries else ""
        try:
            return Variable(name, (universe[0], universe[1]), Terms(terms), unit)
        except FuzzySystemError as error:
            raise self.error(at, shortened(str(error), _LISTED)) from None

    def _term(self, at: SectionLine, inputs: int | None) -> tuple[str, Any]:
        """Name and function of one term; ``inputs`` is how many the system has, None for the term of an input."""
        accepted = tuple(MATLAB_NAMES) if inputs is None else _CONSEQUENTS
        line = _TERM.fullmatch(at.value)
        if line is None:
            form = "'name':'trimf',[a b c]" if inputs is None else "'name':'constant',[c]"
            raise self.error(at, f"expected MF1={form}, of the types {', '.join(accepted)}; got {quoted(at.value)}")
        name, kind = line["name"], line["type"].casefold()
        if kind not in accepted:
            what = "membership function" if inputs is None else "Sugeno consequent"
            raise self.error(at, f"{shortened(name)}: " + expected(line["type"], accepted, what))
        parameters = self._numbers(line["parameters"], at, f"{shortened(name)}: {kind}")
        wanted = len(MATLAB_NAMES[kind].words) if inputs is None else 1 if kind == "constant" else inputs + 1
        if len(parameters) > wanted and not any(parameters[wanted:]):
            parameters = parameters[:wanted]
            self.padded.append(at)
        if inputs is None:
            try:
                return name, membership_function(kind, parameters)
            except MembershipError as error:
                raise self.error(at, f"{shortened(name)}: {error}") from None
        if len(parameters) != wanted:
            form = "[c]" if kind == "constant" else "[p1 ... pn p0], one an input and the constant"
            count = f"{wanted} parameter{'s' if wanted > 1 else ''}"
            raise self.error(at, f"{shortened(name)}: {kind} takes {count} {form}, got {len(parameters)}")
        return name, Constant(parameters[0]) if kind == "constant" else Linear(parameters[:-1], parameters[-1])

    def _rule(
        self, at: SectionLine, inputs: Mapping[str, Sequence[str]], outputs: Mapping[str, Sequence[str]], mamdani: bool
    ) -> Rule:
        """One rule; ``inputs`` and ``outputs`` map each variable to its terms."""
        line = _RULE.fullmatch(at.text)
        if line is None:
            raise self.error(at, "expected a rule, 'terms of the inputs, terms of the outputs (weight) : 1 or 2'")
        when = [
            Clause(variable, term, negated, power)
            for variable, term, negated, power in self._indices(line["inputs"], inputs, at, "input")
        ]
        then = []
        for variable, term, negated, power in self._indices(line["outputs"], outputs, at, "output"):
            if power != 1 or (negated and not mamdani):
                wrong = "a consequent takes no hedge" if mamdani else "a Sugeno consequent takes no 'not' and no hedge"
                raise self.error(at, f"{wrong}: {quoted(line['outputs'].strip())}")
            then.append((variable, self._complement(variable, term, outputs[variable]) if negated else term))
        if not when or not then:
            raise self.error(at, f"a rule needs an {'input' if not when else 'output'} that is not 0")
        weight = self._numbers(line["weight"], at, "weight")
        if len(weight) != 1 or not 0 <= weight[0] <= 1:
            raise self.error(at, f"the weight must be a number in [0, 1], got {quoted(line['weight'])}")
        if line["connective"] not in ("1", "2"):
            raise self.error(at, f"expected 1 (and) or 2 (or) after ':', got {quoted(line['connective'])}")
        return Rule(tuple(when), tuple(then), "and" if line["connective"] == "1" else "or", weight[0])

    def _complement(self, output: str, term: str, taken: Collection[str]) -> str:
        """The name of the term for a Mamdani consequent "not ``term``"."""
        known = self.complements.setdefault(output, {})
        if term not in known:
            name = f"not {term}"
            while name in taken or name in known.values():
                name = f"{name} (complement)"
            known[term] = name
        return known[term]

    def _indices(
        self, text: str, variables: Mapping[str, Sequence[str]], at: SectionLine, kind: str
    ) -> Iterator[tuple[str, str, bool, float]]:
        """Variable, term, negation and power for each index of a rule that is not 0."""
        words = text.split()
        if len(words) != len(variables):
            raise self.error(at, f"expected {len(variables)} {kind} terms, one for each {kind}, got {len(words)}")
        for word, (variable, terms) in zip(words, variables.items(), strict=True):
            index = _INDEX.fullmatch(word)
            if index is None:
                raise self.error(at, f"expected the number of a term of {quoted(variable)}, got {quoted(word)}")
            place = int(index["place"])
            # MATLAB has no hedges. Octave's: the fraction .20 is the power 2 (very), .05 is 0.5 (somewhat).
            power = round(100 * float(f"0.{index['hedge']}")) / 10 if index["hedge"] else 0.0
            if power == 0 and (index["hedge"] or "").strip("0"):
                raise self.error(at, f"the hedge of {shortened(word)} is below .01, the power 0.1")
            if place == 0 and power == 0:
                continue
            if not 1 <= place <= len(terms):
                names = ", ".join(f"{n} {name!r}" for n, name in enumerate(terms, start=1)) or "none"
                has = shortened(names, _LISTED)
                raise self.error(at, f"{quoted(variable)} has no term number {shortened(word)}; it has {has}")
            if power and kind == "input" and not self.hedged:
                clause = Clause(variable, terms[place - 1], index["sign"] == "-", power)
                self.warn(at, f"{word} is read as Octave's hedge, {quoted(clause)}")
            yield variable, terms[place - 1], index["sign"] == "-", power or 1.0


# Writing ------------------------------------------------------------------------------------------------------


def write_system(fis: Any, path: str | os.PathLike[str], comment: str = "") -> None:
    """Write a system of any kind as it writes itself, a tree into a folder, or else as :func:`write_fis` does."""
    getattr(fis, "write", partial(write_fis, fis))(path, comment)


def write_fis(fis: Any, path: str | os.PathLike[str], comment: str = "") -> None:
    """Write a system as a .fis file in UTF-8 (MATLAB's ``writeFIS``). An older file stays until the new one is whole.

    Warns (FisFileWarning) of hedges, which MATLAB cannot read: see :func:`fuzzy.without_hedges`.

    Args:
        fis: The system, of type 1 or an interval type-2 one, whose lower functions stand in comments.
        path: The file.
        comment: Lines that stand at the top of the file; the first one is its title.

    Raises:
        FisFileError: The format cannot hold the system (see :func:`format_fis`) or the file cannot be written.
    """
    write_quietly(fis, path, comment)
    if lacks := beyond_matlab(fis.upper):
        warnings.warn(f"{os.fsdecode(path)}: {lacks}", FisFileWarning, stacklevel=2)


def write_quietly(fis: Any, path: str | os.PathLike[str], comment: str = "") -> None:
    """Write a system as :func:`write_fis` does, without its warning; raises as it does."""
    name = os.fsdecode(path)
    write_fis_text(_format(fis, name), name, comment)


def write_fis_text(text: str, name: str, comment: str) -> None:
    """Write the text of a .fis file, under a comment, into the file called ``name``. Raises FisFileError."""
    try:
        write_whole(name, "".join(f"% {line}\n" for line in comment.splitlines()) + text)
    except UnicodeEncodeError as error:
        raise FisFileError(name, None, f"a name holds no valid text: {error.object[error.start]!r}") from None
    except OSError as error:
        raise FisFileError(name, None, f"cannot be written: {error.strerror or error}") from None


def beyond_matlab(fis: Sugeno) -> str:
    """What MATLAB cannot read in a file of a system, and the way out, as a sentence; empty where there is nothing."""
    hedged = [clause for rule in fis.rules for clause in rule.when if clause.power != 1]
    if not hedged:
        return ""
    return (
        f"MATLAB cannot read the hedges in it, {counted(len(hedged), 'clause')} such as {quoted(hedged[0])}; "
        "`fuzzy convert --without-hedges`, or fuzzy.without_hedges in Python, makes membership functions of them where "
        "these are exact"
    )


def format_fis(fis: Any) -> str:
    """The text of a .fis file, as :func:`write_fis` writes it. Parameters that are torch tensors are written as
    numbers.

    Args:
        fis: The system.

    Raises:
        FisFileError: A name that holds a line break, a number that is not finite, and a hedge whose power is not a
            multiple of 0.1 below 10.
    """
    return _format(fis, fis.name)


def _format(whole: Any, path: str) -> str:
    fis: Sugeno = whole.upper
    lower = {} if whole is fis else whole.lower

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

    def index(clause: Clause, rule: Rule) -> str:
        tenths = round(10 * clause.power) if clause.power < 10 else 0
        if not 1 <= tenths <= 99 or tenths / 10 != clause.power:
            reason = f"the format has no room for the power {clause.power!r} in {rule}: only 0.1, 0.2, ... 9.9"
            raise FisFileError(path, None, reason)
        hedge = "" if tenths == 10 else f".{tenths:02d}"
        return f"{'-' if clause.negated else ''}{places[clause.variable][clause.term]}{hedge}"

    lines = ["[System]", f"Name={quoted(fis.name, 'the name')}", "Type='sugeno'", "Version=2.0"]
    if lower:
        lines.insert(1, f"%! {REDUCTION_NOTE}='{whole.reduction}'")
    lines += [f"NumInputs={len(fis.inputs)}", f"NumOutputs={len(fis.outputs)}", f"NumRules={len(fis.rules)}"]
    lines += [f"AndMethod='{fis.and_method}'", f"OrMethod='{fis.or_method}'"]
    lines += [f"ImpMethod={quoted(fis.implication, 'implication')}"]
    lines += [f"AggMethod={quoted(fis.aggregation, 'aggregation')}", f"DefuzzMethod='{fis.defuzzification}'"]
    if any(clause.power != 1 for rule in fis.rules for clause in rule.when):
        lines.append(f"%! {HEDGES_NOTE}='octave'")
    for key, (attribute, choices) in SYSTEM_NOTES.items():
        if getattr(fis, attribute) != choices[0]:  # the first is the default
            lines.append(f"%! {key}='{getattr(fis, attribute)}'")
    if fis.loop:
        lines.append(f"%! {LOOP_NOTE}={quoted(fis.loop, 'the loop')}")
    numbered = [(f"Input{i}", v, lower.get(v.name)) for i, v in enumerate(fis.inputs, start=1)]
    numbered += [(f"Output{j}", v, None) for j, v in enumerate(fis.outputs, start=1)]
    for title, variable, below in numbered:
        low, high = (number(end, variable.name) for end in variable.universe)
        lines += ["", f"[{title}]"]
        if below is not None:
            rows = (" ".join(number(v, variable.name) for v in (each.scale, *each.lag)) for each in below.values())
            lines.append(f"%! {LOWER_NOTE}=[{'; '.join(rows)}]")
        lines.append(f"Name={quoted(variable.name, 'a name')}")
        if variable.unit:
            lines.append(f"%! Unit={quoted(variable.unit, 'a unit')}")
        lines += [f"Range=[{low} {high}]", f"NumMFs={len(variable.terms)}"]
        for place, (label, term) in enumerate(variable.terms.items(), start=1):
            parameters = " ".join(number(p, f"{variable.name} is {label}") for p in term.parameters)
            lines.append(f"MF{place}={quoted(label, 'a name')}:'{term.matlab}',[{parameters}]")
    places = {v.name: {label: n for n, label in enumerate(v.terms, start=1)} for v in fis.inputs}
    proposed = {v.name: {label: n for n, label in enumerate(v.terms, start=1)} for v in fis.outputs}
    lines += ["", "[Rules]"]
    for rule in fis.rules:
        assert isinstance(rule, Rule)
        clauses, consequents = {c.variable: index(c, rule) for c in rule.when}, dict(rule.then)
        when = " ".join(clauses.get(name, "0") for name in places)
        then = " ".join(str(known[consequents[o]]) if o in consequents else "0" for o, known in proposed.items())
        connective = 1 if rule.connective == "and" else 2
        lines.append(f"{when}, {then} ({number(rule.weight, str(rule))}) : {connective}")
    return "\n".join(lines) + "\n"
