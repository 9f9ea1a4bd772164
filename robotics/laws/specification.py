"""How a controller is named: ``name:gain=value,...``, with a name of the catalogue, or a file of the user's own.

A file is ``path/mylaw.py:MyLaw``, a law in a Python file, or ``path/mine.fis``, a rule base for the law ``fuzzy``.
"""

import re
from collections.abc import Iterable, Iterator
from pathlib import Path
from typing import NamedTuple, Self

_DRIVE = re.compile(r"[A-Za-z]:[\\/]")  # with which a path of Windows begins
_FILE = re.compile(r"(?P<file>.*?\.(?:py|fis))(?::(?P<rest>.*))?", re.DOTALL)
_GAIN = re.compile(r"[\w.]+\s*=")


class Specification(NamedTuple):
    """The parts of a controller's specification."""

    file: str  # the path of a .py or .fis file; "": the name is one of the catalogue
    name: str  # in the catalogue, or in the Python file; "": the file's only law
    gains: str  # "gain=value,gain=value"

    @classmethod
    def of(cls, text: str) -> Self:
        """The parts of a specification, none of which is checked.

        >>> Specification.of("csm:k=0.3")
        Specification(file='', name='csm', gains='k=0.3')
        >>> Specification.of("laws/mylaw.py:MyLaw:gain=2")
        Specification(file='laws/mylaw.py', name='MyLaw', gains='gain=2')
        >>> Specification.of("mine.fis:look_ahead=0.5")
        Specification(file='mine.fis', name='', gains='look_ahead=0.5')
        """
        text = text.strip()
        start = 2 if _DRIVE.match(text) else 0
        head = text[:start] + text[start:].partition(":")[0]
        found = _FILE.fullmatch(text[start:]) if Path(head).suffix in (".py", ".fis") else None
        if found is None:
            name, _, gains = text.partition(":")
            return cls("", name.strip(), gains.strip())
        file, rest = text[:start] + found["file"], (found["rest"] or "").strip()
        if file.endswith(".fis") or _GAIN.match(rest):
            return cls(file, "", rest)
        name, _, gains = rest.partition(":")
        return cls(file, name.strip(), gains.strip())

    @property
    def law(self) -> str:
        """The specification without gains: ``csm``, ``laws/mylaw.py:MyLaw``, ``mine.fis``."""
        return ":".join(filter(None, (self.file, self.name)))

    @property
    def short(self) -> str:
        """A short name: that in the catalogue or in the Python file, or the file's without its folders."""
        return self.name or re.split(r"[\\/]", self.file)[-1]

    def __str__(self) -> str:
        return ":".join(filter(None, (self.law, self.gains)))

    def with_gains(self, gains: Iterable[str]) -> Self:
        """The same law with more gains, such as "k=0.3", behind those that it has."""
        return self._replace(gains=",".join(filter(None, (self.gains, *gains))))

    def located(self, folder: str | Path) -> Self:
        """The same law, its files taken from ``folder`` where they are there; else from the current folder, as before.

        Files are that of the law, and those that gains name: values that end in .fis or .json or have a slash in them.
        """
        gains = []
        for part in self.gains.split(",") if self.gains else []:
            gain, equals, value = part.partition("=")
            names_file = value.strip().endswith((".fis", ".json")) or "/" in value
            gains.append(f"{gain}{equals}{_in(folder, value.strip())}" if names_file else part)
        return self._replace(file=_in(folder, self.file) if self.file else "", gains=",".join(gains))


def assignments(text: str) -> Iterator[tuple[str, str, str]]:
    """The parts of "gain=value,gain=value": the name, "=" or nothing, and the value."""
    for item in filter(None, (part.strip() for part in text.split(","))):
        name, equals, value = (part.strip() for part in item.partition("="))
        yield name, equals, value


def _in(folder: str | Path, file: str) -> str:
    """The path of a file as seen from ``folder`` if it is there."""
    inside = Path(folder) / file
    return str(inside) if inside.exists() else file


def starts_gain(text: str) -> bool:
    """Whether a part of a comma-separated list of specifications is one more gain of the one before: "k=0.3"."""
    return _GAIN.match(text.strip()) is not None
