"""The lines of a .fis file, sorted into sections, keys and rules; :mod:`fuzzy.files.fisfile` makes a system of them."""

import os
import re
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from fuzzy.errors import InputError, quoted, shortened
from fuzzy.naming import expected, file_beside

_SYSTEM_KEYS = (
    "Name",
    "Type",
    "Version",
    "NumInputs",
    "NumOutputs",
    "NumRules",
    "AndMethod",
    "OrMethod",
    "ImpMethod",
    "AggMethod",
    "DefuzzMethod",
)
# The last four are fuzzylite's; they and Version change nothing here, and are accepted so that the file can be read.
_VARIABLE_KEYS = ("Name", "Range", "NumMFs", "Enabled", "Default", "LockPrevious", "LockRange")
# This program's own, in comments: key, the attribute of the system that it sets, what that may be.
SYSTEM_NOTES = {
    "NoRuleFires": ("no_rule_fires", ("midrange", "nan", "error")),
    "OutOfRange": ("out_of_range", ("warn", "ignore", "clip", "error")),
}
LOOP_NOTE = "Loop"  # in [System]: Sugeno.loop
HEDGES_NOTE = "Hedges"  # in [System] of what this program writes: fractions in rules are meant, and need no warning
REDUCTION_NOTE = "TypeReduction"  # in [System] of an interval type-2 system
LOWER_NOTE = "Lower"  # in an input of one: the scale and the two lags of each term
_SYSTEM_NOTES = (*SYSTEM_NOTES, LOOP_NOTE, HEDGES_NOTE, REDUCTION_NOTE)
_VARIABLE_NOTES = ("Unit", LOWER_NOTE)

LINE_END = re.compile(r"\r\n|\r|\n")  # not splitlines(), which would also split names at rarer characters
_MOST_WARNINGS = 20  # of one file; what follows is counted
_COMMENT = re.compile(r"%|#|//")
_NOTE = re.compile(r"%!\s*(\w+)\s*=\s*(.*)")
_HEADER = re.compile(r"\[\s*(\w+)\s*\]")
_ENTRY = re.compile(r"(\w+)\s*=\s*(.*)")


class FisFileError(InputError):
    """The error for a text that is no Sugeno system, and for a system that the format cannot hold.

    ``path`` names the file. ``line`` (from 1) is the place, or None if no single line is at fault.
    """

    def __init__(self, path: str, line: int | None, reason: str) -> None:
        super().__init__(path, line, reason)  # all of them, so that the error can be pickled
        self.path, self.line, self.reason = path, line, reason

    def __str__(self) -> str:
        return f"{self.path}: {self.reason}" if self.line is None else f"{self.path}:{self.line}: {self.reason}"


def file_bytes(name: str | os.PathLike[str], fault: type[FisFileError] = FisFileError) -> bytes:
    """The bytes of a file. Raises ``fault`` where it cannot be read."""
    try:
        return Path(name).read_bytes()
    except (OSError, ValueError) as error:
        reason = f"cannot be read: {getattr(error, 'strerror', None) or error}{file_beside(name)}"
        raise fault(os.fsdecode(name), None, reason) from None


class FisFileWarning(UserWarning):
    """The warning of a passage that the author of a file may have meant differently from how it is read here."""


@dataclass(frozen=True)
class SectionLine:
    """One line of a section."""

    line: int
    text: str  # the whole line
    value: str  # what follows "="


@dataclass
class FileSection:
    """A section of the file, with its lines sorted by what they say."""

    title: str
    line: int
    entries: dict[str, SectionLine] = field(default_factory=dict)  # by key, as this program spells it
    terms: dict[int, SectionLine] = field(default_factory=dict)  # by the number in "MF1"
    rules: list[SectionLine] = field(default_factory=list)


class FisLines:
    """Sorts the lines of one text into sections and collects warnings."""

    def __init__(self, path: str) -> None:
        self.path = path
        self._warned: list[str] = []
        self._unsaid = 0  # warnings beyond the first ones

    def error(self, at: SectionLine | FileSection, reason: str) -> FisFileError:
        """Make an error that quotes the line ``at``."""
        text = at.text if isinstance(at, SectionLine) else at.title
        return FisFileError(self.path, at.line, f"{reason}\n  {shortened(text)}")

    def warn(self, at: SectionLine, message: str) -> None:
        """Keep a warning that quotes the line ``at``."""
        if len(self._warned) < _MOST_WARNINGS:
            self._warned.append(f"{self.path}:{at.line}: {message}; the line: {shortened(at.text)}")
        else:
            self._unsaid += 1

    @property
    def warnings(self) -> list[str]:
        """The first warnings, and how many more there are."""
        more = [f"{self.path}: {self._unsaid} more warnings of this kind are not shown"] if self._unsaid else []
        return self._warned + more

    def sections(self, text: str) -> dict[str, FileSection]:
        """Sort the lines into sections, by title: "System", "Input1", "Output1", "Rules"."""
        sections: dict[str, FileSection] = {}
        current: FileSection | None = None
        for number, raw in enumerate(LINE_END.split(text), start=1):
            line = raw.strip()
            note = _NOTE.fullmatch(line)
            header = _HEADER.fullmatch(line)
            if header:
                title = self._title(header[1], SectionLine(number, line, ""))
                if title in sections:
                    first = sections[title].line
                    raise self.error(SectionLine(number, line, ""), f"a second [{title}]; the first is in line {first}")
                current = sections[title] = FileSection(f"[{title}]", number)
            elif note and current is not None:
                self._note(current, note[1], SectionLine(number, line, note[2]))
            elif not line or _COMMENT.match(line):
                continue
            elif current is None:
                raise self.error(SectionLine(number, line, ""), "expected a section, '[System]', before anything else")
            elif current.title == "[Rules]":
                current.rules.append(SectionLine(number, line, line))
            else:
                self._entry(current, SectionLine(number, line, ""))
        return sections

    def _title(self, word: str, at: SectionLine) -> str:
        titles = {"system": "System", "rules": "Rules"}
        if word.casefold() in titles:
            return titles[word.casefold()]
        numbered = re.fullmatch(r"(input|output)0*([1-9]\d{0,8})", word, re.IGNORECASE | re.ASCII)
        if numbered:
            return numbered[1].capitalize() + numbered[2]
        raise self.error(at, expected(word, ("System", "Input1", "Output1", "Rules"), "section"))

    def _note(self, section: FileSection, word: str, at: SectionLine) -> None:
        known = _SYSTEM_NOTES if section.title == "[System]" else _VARIABLE_NOTES
        if section.title == "[Rules]" or word not in known:
            self.warn(at, f"a note that {section.title} does not know is skipped: {quoted(word)}")
        elif word in section.entries:
            raise self.error(at, f"a second {shortened(word)}; the first is in line {section.entries[word].line}")
        else:
            section.entries[word] = at

    def _entry(self, section: FileSection, at: SectionLine) -> None:
        pair = _ENTRY.fullmatch(at.text)
        if pair is None:
            raise self.error(at, "expected 'key=value', a [section] or a comment that begins with '%'")
        word, entry = pair[1], SectionLine(at.line, at.text, pair[2])
        term = re.fullmatch(r"mf0*([1-9]\d{0,8})", word, re.IGNORECASE | re.ASCII)
        place: Any
        if term and section.title != "[System]":
            group: dict[Any, SectionLine] = section.terms
            place = int(term[1])
        else:
            keys = _SYSTEM_KEYS if section.title == "[System]" else _VARIABLE_KEYS
            same = {key.casefold(): key for key in keys}
            if word.casefold() not in same:
                known = keys if section.title == "[System]" else (*keys, "MF1, MF2, ...")
                raise self.error(at, expected(word, known, "key"))
            group, place = section.entries, same[word.casefold()]
        if place in group:
            raise self.error(at, f"a second {shortened(word)}; the first is in line {group[place].line}")
        group[place] = entry
