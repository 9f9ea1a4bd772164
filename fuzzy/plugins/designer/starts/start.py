"""What a start is: a new rule base made of options, which are data, so that a page and a command line ask for them."""

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any, ClassVar

from fuzzy.errors import InputError, quoted
from fuzzy.naming import check_known
from fuzzy.system import Sugeno

Report = Callable[[float, str], None]  # how much of the work is done, from 0 to 1, and what was done last


class StartError(InputError):
    """A start that does not exist, or an option that it cannot use. The message says what is accepted."""


@dataclass(frozen=True)
class Choice:
    """An option that is one of some words."""

    name: str
    title: str
    values: Mapping[str, str]  # each with what a page calls it
    value: str
    kind: ClassVar[str] = "choice"

    def read(self, given: Any) -> str:
        """The word. Raises StartError."""
        check_known(given, self.values, self.name, StartError)
        return str(given)


@dataclass(frozen=True)
class NumberOption:
    """An option that is a number from ``low`` to ``high``, both included."""

    name: str
    title: str
    low: float
    high: float
    value: float
    whole: bool = True
    unit: str = ""
    kind: ClassVar[str] = "number"

    def read(self, given: Any) -> float:
        """The number; texts are read. Raises StartError."""
        wanted = f"{self.name} must be a {'whole ' if self.whole else ''}number >= {self.low:g} and <= {self.high:g}"
        try:
            number = math.nan if isinstance(given, bool) else float(given)
        except (TypeError, ValueError, OverflowError):
            number = math.nan
        if not self.low <= number <= self.high or (self.whole and number != int(number)):
            raise StartError(f"{wanted}, got {quoted(given)}")
        return int(number) if self.whole else number


@dataclass(frozen=True)
class File:
    """An option that is an existing file, which must be given."""

    name: str
    title: str
    ending: str = ".csv"
    kind: ClassVar[str] = "file"

    def read(self, given: Any) -> Path:
        """The path of the file. Raises StartError."""
        if not isinstance(given, (str, Path)) or not str(given) or "\0" in str(given):
            raise StartError(f"{self.name} must be the path of a {self.ending} file, got {quoted(given)}")
        path = Path(given)
        if not path.is_file():
            raise StartError(f"there is no file {quoted(path)}")
        return path


@dataclass(frozen=True)
class ColumnsOption:
    """An option that is some columns of a table, by titles, names or numbers with commas between; empty: the usual."""

    name: str
    title: str
    of: str  # the option with the file
    usual: str  # which columns these are
    kind: ClassVar[str] = "columns"

    def read(self, given: Any) -> str:
        """The columns as a text. Raises StartError."""
        if not isinstance(given, str) or len(given) > 5000:
            raise StartError(f"{self.name} must be names of columns with commas between them, got {quoted(given)}")
        return given.strip()


Option = Choice | NumberOption | File | ColumnsOption


@dataclass(frozen=True)
class Start:
    """What a new rule base can begin with.

    ``make`` takes the options by name, as their ``read`` gives them, and is a function that can be pickled. One that
    ``reports`` takes also ``report``, see Report, and calls it as it proceeds.
    """

    name: str  # of letters, digits, "-" and "/"
    group: str  # under which it is listed
    title: str
    sentence: str
    make: Callable[..., Sugeno] = field(repr=False)
    options: tuple[Option, ...] = ()
    example: Callable[[], Sugeno] | None = None  # what a picture of it shows; by default what the usual options make
    own_name: bool = False  # the system keeps its name, by which a law knows it; otherwise it is called as its file
    reports: bool = False

    def made(self, given: Mapping[str, Any], name: str, report: Report = lambda share, said: None) -> Sugeno:
        """Make the system.

        Args:
            given: Options by their names, numbers also as texts; the others are as usual.
            name: The name of the new file, without its ending.
            report: Called as the work proceeds, where it takes long.

        Raises StartError for options that do not exist or cannot be used, and what reading a file raises.
        """
        known = {option.name: option for option in self.options}
        for key in given:
            check_known(key, known, "option", StartError, where=self.name)
        values = {}
        for option in self.options:
            if option.name in given:
                values[option.name] = option.read(given[option.name])
            elif isinstance(option, File):
                raise StartError(f"{self.name} needs {option.name}=FILE{option.ending}, {option.title.lower()}")
            else:
                values[option.name] = "" if isinstance(option, ColumnsOption) else option.value
        more = {"report": report} if self.reports else {}
        fis = self.make(**values, **more)
        return fis if self.own_name else replace(fis, name=name)

    def described(self) -> dict[str, Any]:
        """The start in JSON's types, without what it makes."""
        options = [{"name": o.name, "title": o.title, "kind": o.kind, **vars(o)} for o in self.options]
        about = {"name": self.name, "group": self.group, "title": self.title, "sentence": self.sentence}
        return {**about, "options": options, "reports": self.reports}
