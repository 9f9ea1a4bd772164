"""Scenarios, robots and laws in the folder that the designer serves, the text that is edited, and a panel's files.

Nothing outside the folder is read or written. Files are read in another process, and read anew once they change.
"""

import ast
import asyncio
import hashlib
import itertools
import re
import tomllib
from collections.abc import Awaitable, Callable, Coroutine, Iterator
from dataclasses import dataclass, fields, replace
from pathlib import Path
from typing import Any, NamedTuple

from fuzzy.errors import InputError
from fuzzy.plugins.designer.folder import LARGEST_FILE, Folder, check_size
from fuzzy.plugins.designer.latest import Postponed
from fuzzy.plugins.designer.saving import OverwriteError, save_text
from fuzzy.plugins.designer.session import PanelSession
from fuzzy.plugins.designer.workers import WorkError
from robotics.plugins.designer.uses import TryoutError
from robotics.world.vehicle.robot import Robot

TEXT_KINDS = ("scenario", "robot")
_ROBOTS = re.compile(rb"^\s*(\[\[\s*robots\s*\]\]|robots\s*=)", re.MULTILINE)  # what every scenario has
_LOOK = 1.0  # s between two looks at the files
_TYPICAL = 3  # of a robot's numbers are enough to take a file for a robot's


class FolderText(NamedTuple):
    """The text of a file of the folder."""

    name: str
    text: str
    digest: str | None  # of the file's bytes; None: it is not in the folder


def scenario_files(folder: Folder) -> list[str]:
    """The names of the .toml files of the folder that describe robots on their paths, faulty ones too."""
    return [name for name in folder.files(".toml") if file_offer(folder, name).scenario]


class FileOffer(NamedTuple):
    """What one file of the folder offers; a file of 2 MB or more, or one that cannot be read, offers nothing."""

    scenario: bool = False  # it describes robots on their paths, perhaps with faults
    robot: bool = False  # it holds the numbers of one robot
    laws: tuple[str, ...] = ()  # the names of its laws; Python files are read, and not run
    drives: bool = False  # it holds a rule base that can drive a robot


def file_offer(folder: Folder, name: str) -> FileOffer:
    """What the .toml, .py or .fis file ``name`` of the folder offers."""
    if name.endswith(".fis"):
        from robotics.plugins.designer.driving import drives

        try:
            return FileOffer(drives=drives(folder.read(name)))
        except (InputError, OSError):
            return FileOffer()
    data = _bytes(folder.path / name)
    if name.endswith(".py"):
        return FileOffer(laws=tuple(_laws(data)))
    return FileOffer(_ROBOTS.search(data) is not None, _is_robot(data))


def files_of(folder: Folder) -> dict[str, list[str]]:
    """The names of the files of the folder that may offer something, by how they end."""
    return {ending: folder.files(ending) for ending in (".toml", ".py", ".fis")}


class FolderOffers:
    """What the folder offers to try and to compare with, looked at in another process, each state of a file once.

    ``read(name, function, *args)`` runs a function in that process; it raises InputError where it takes too long.
    """

    def __init__(self, folder: Folder, read: Callable[..., Awaitable[Any]]) -> None:
        self._folder, self._read = folder, read
        self._names: dict[str, list[str]] = {".toml": [], ".py": [], ".fis": []}
        self._known: dict[str, tuple[Any, FileOffer]] = {}  # by name: the state of the file, and what it offered

    async def look(self) -> str:
        """Look at what is new or changed; give a sentence on a file that could not be looked at, or nothing."""
        said = ""
        try:
            self._names = await self._read("the folder", files_of, self._folder)
            for name in itertools.chain(*self._names.values()):
                state = changed_at(self._folder, name)
                if self._known.get(name, (None,))[0] == state:
                    continue
                try:
                    offer = await self._read(name, file_offer, self._folder, name)
                except InputError as error:
                    said, offer = str(error), FileOffer()
                self._known[name] = state, offer
        except (InputError, WorkError) as error:
            said = str(error)
        return said

    def found(self, own: Path) -> dict[str, list[str]]:
        """The names of scenarios, of robots, and of what to compare with: rule bases but ``own``, "file.py:Law"."""
        known = {n: self._known.get(n, (None, FileOffer()))[1] for names in self._names.values() for n in names}
        bases = [name for name, offer in known.items() if offer.drives and self._folder.path / name != own]
        return {
            "scenarios": [name for name, offer in known.items() if offer.scenario],
            "robots": [name for name, offer in known.items() if offer.robot],
            "laws": bases + [f"{name}:{law}" for name, offer in known.items() for law in offer.laws],
        }


def _bytes(path: Path) -> bytes:
    try:
        return path.read_bytes() if path.stat().st_size <= LARGEST_FILE else b""
    except OSError:
        return b""


def _is_robot(data: bytes) -> bool:
    if _ROBOTS.search(data) is not None:
        return False
    try:
        table = tomllib.loads(data.decode("utf-8"))
    except (ValueError, RecursionError):  # being edited elsewhere: its lines still tell
        keys = {key.decode("ascii") for key in re.findall(rb"^([a-z_]+)\s*=", data, re.MULTILINE)}
    else:
        keys = set(table)
    return len(keys & {f.name for f in fields(Robot)}) >= _TYPICAL


def _laws(data: bytes) -> Iterator[str]:
    """The classes of a Python text that derive from one whose name ends in Law, and its presets."""
    try:
        tree = ast.parse(data)
    except (SyntaxError, ValueError, RecursionError, MemoryError):
        return
    laws: set[str] = set()
    for node in tree.body:
        match node:
            case ast.ClassDef(name=name) if not name.startswith("_"):
                bases = [_last_name(base.value if isinstance(base, ast.Subscript) else base) for base in node.bases]
                if any(base.endswith("Law") or base in laws for base in bases):
                    laws.add(name)
                    yield name
            case ast.Assign(value=ast.Call(func=func)) if _last_name(func) == "Preset":
                yield from (target.id for target in node.targets if isinstance(target, ast.Name))


def _last_name(node: ast.expr) -> str:
    return node.attr if isinstance(node, ast.Attribute) else node.id if isinstance(node, ast.Name) else ""


def law_path(folder: Folder, name: str) -> str:
    """The specification of a law in a Python file of the folder, "file.py:Law", with the file's whole path.

    Raises FolderError for a file that is not in the folder, and TryoutError for a law that it does not hold.
    """
    file, _, law = name.rpartition(":")
    path = folder.inside(file, ".py")
    if law not in _laws(_bytes(path)):
        raise TryoutError(f"there is no law {law!r} in {file}")
    return f"{path}:{law}"


def read_text_file(folder: Folder, name: str) -> FolderText:
    """A scenario or robot file of the folder. Raises FolderError or TryoutError."""
    path = folder.inside(name, ".toml")
    if not path.is_file():
        raise TryoutError(f"there is no file {name!r} in the opened folder")
    check_size(path, name)
    try:
        data = path.read_bytes()
    except OSError as error:
        raise TryoutError(f"{name}: cannot be read: {error.strerror or error}") from None
    return FolderText(name, checked_text(name, data), hashlib.sha256(data).hexdigest())


def checked_text(name: str, data: bytes) -> str:
    """The text in the bytes of a scenario or robot file. Raises TryoutError."""
    if len(data) > LARGEST_FILE:
        raise TryoutError(f"{name} is larger than {LARGEST_FILE / 1e6:g} MB")
    try:
        return data.decode("utf-8-sig").replace("\r\n", "\n")
    except UnicodeDecodeError:
        raise TryoutError(f"{name}: cannot be read: it is not UTF-8 text") from None


def write_text_file(folder: Folder, file: FolderText, name: str, overwrite: bool = False) -> FolderText:
    """Write the text of ``file`` as the file ``name`` of the folder, whole or not at all.

    Raises FolderError, or OverwriteError where that would replace what was not read here, unless ``overwrite``.
    """
    path = folder.inside(name, ".toml")
    known = file.digest if name == file.name else None
    return FolderText(name, file.text, save_text(path, file.text, known, known is not None, overwrite))


def changed_at(folder: Folder, name: str) -> tuple[int, int] | None:
    """When the file was changed last [ns], and its size [bytes]; None where there is none."""
    try:
        state = (folder.path / name).stat()
    except OSError:
        return None
    return state.st_mtime_ns, state.st_size


# A text under edit ------------------------------------------------------------------------------------------------


@dataclass(frozen=True)
class TextDesk:
    """One text under edit; a desk never changes, each step gives the next one."""

    what: str  # "scenario" or "robot"
    file: FolderText  # as it was read or saved last; without a digest it comes with the package or from elsewhere
    text: str  # as it is edited
    copy: int  # counts the texts that came from here, which the page then shows anew
    problem: tuple[int | None, str] | None = None  # the line, if it is known, and what is wrong there
    asks: str = ""  # why saving needs a word more: it would overwrite something

    @property
    def saved(self) -> bool:
        """Whether the file in the folder holds the text."""
        return self.file.digest is not None and self.text == self.file.text

    @property
    def edited(self) -> bool:
        """Whether the text is another than the one that was opened."""
        return self.text != self.file.text

    def written(self, text: Any) -> "TextDesk":
        """With another text. Raises TryoutError for one that is too long, or none."""
        if not isinstance(text, str):
            raise TryoutError("a file is edited as text")
        return replace(self, text=checked_text(self.file.name, text.encode("utf-8", "replace")), asks="")

    def judged(self, fault: dict[str, Any]) -> "TextDesk":
        """With what :func:`robotics.plugins.designer.tryout.checked` says of the text."""
        return replace(self, problem=(fault["line"], fault["message"]) if fault else None)

    def reverted(self) -> "TextDesk":
        """With the text as it was opened or saved."""
        return replace(self, text=self.file.text, copy=self.copy + 1, asks="")

    def reread(self, file: FolderText) -> "TextDesk":
        """After the file has changed on disk: an edited text stays, and saving will ask."""
        if self.edited:
            asks = f"{file.name} was changed on disk by another program; saving overwrites that"
            return replace(self, asks=asks)
        return replace(self, file=file, text=file.text, copy=self.copy + 1)

    def saved_as(self, folder: Folder, name: str, overwrite: bool) -> "TextDesk":
        """After writing the text to the file ``name``; where it would overwrite what was not read, it asks instead.

        Raises FolderError or DocumentError where it cannot be written.
        """
        try:
            file = write_text_file(folder, self.file._replace(text=self.text), name, overwrite)
        except OverwriteError as error:
            return replace(self, asks=str(error))
        return replace(self, file=file, asks="")

    def shown(self) -> dict[str, Any]:
        """What the page shows; the text is the one that was opened, which the page itself edits."""
        line, message = self.problem or (None, "")
        return {
            "what": self.what,
            "name": self.file.name,
            "own": self.file.digest is not None,
            "text": self.file.text,
            "copy": self.copy,
            "saved": self.saved,
            "edited": self.edited,
            "line": line,
            "message": message,
            "asks": self.asks,
        }


# The files of a panel -----------------------------------------------------------------------------------------------


class FolderSession(PanelSession):
    """The files that one page has chosen, by what they are to it; a page waits for none of them.

    A subclass says in :meth:`say_busy` that one is read, goes on in :meth:`go`, and reads in :meth:`reread` one that
    has changed. Of each kind the latest choice counts: what an earlier reading gives is dropped.
    """

    def __init__(self, bench: Any) -> None:
        super().__init__(bench)
        self.offers = FolderOffers(self.folder, bench.read)
        self.seen = False  # files are looked at for a page that somebody looks at
        self.reads: dict[str, object] = {}  # the mark of the latest reading of each kind
        self.reading: dict[str, asyncio.Task[None]] = {}
        self.watched: dict[str, tuple[str, Any]] = {}  # the name of each file, and its state when it was read
        self._watch = Postponed(_LOOK, self._look)

    def begin_reading(self, what: str, work: Callable[[object], Coroutine[Any, Any, None]]) -> asyncio.Task[None]:
        """Begin to read what is ``what``, with its mark in ``reads``; an earlier reading of that is overtaken."""
        self.reads[what] = mine = object()
        task = asyncio.get_running_loop().create_task(work(mine))
        self.reading[what] = task
        return task

    def read_then(self, what: str, name: str, then: Callable[[Any], None], function: Any, *args: Any) -> None:
        """Do ``then`` with what reading the file ``name`` gives, unless something else is ``what`` by then."""

        async def work(mine: object) -> None:
            self.say_busy("file")
            try:
                found = await self.bench.read(name, function, *args)
                if self.reads[what] is mine:
                    then(found)
            except (InputError, WorkError) as error:
                if self.reads[what] is mine:
                    self.refuse(error, {"do": "choose", "name": what})
            finally:
                self.say_busy(None)
            self.go()

        self.begin_reading(what, work)

    def list_files(self, _: dict[str, Any]) -> None:
        """Show what the folder offers, once it has been looked at."""
        if "list" not in self.reads:
            self.begin_reading("list", self._offer)

    _do_list = list_files

    async def _offer(self, _: object) -> None:
        # A file that takes too long is said and left out.
        try:
            late = await self.offers.look()
            self.widget.update(files=self.offers.found(self.bench.document.path))
            if late:
                self.widget.update(problem={"message": late})
        finally:
            del self.reads["list"]

    def watch(self, what: str, name: str) -> None:
        """Watch the file ``name`` as what is ``what``, from its present state on."""
        self.watched[what] = name, changed_at(self.folder, name)

    def forget_file(self, what: str) -> None:
        """Watch no longer what is ``what``, and drop what is being read of it."""
        self.reads[what] = object()
        self.watched.pop(what, None)

    def _look(self) -> None:
        """Read the files anew that have changed, and look again in a second while the panel is seen."""
        if not self.seen:
            return
        self._watch.begin()
        for what, (name, before) in list(self.watched.items()):
            if changed_at(self.folder, name) != before:
                self.watch(what, name)
                self.reread(what, name)

    def close(self) -> None:
        """Read and look no more."""
        self.seen = False
        for task in self.reading.values():
            task.cancel()
        self._watch.cancel()

    def say_busy(self, what: str | None) -> None:
        """Say what is waited for; None: nothing."""
        raise NotImplementedError

    def go(self) -> None:
        """Go on after a choice."""
        raise NotImplementedError

    def reread(self, what: str, name: str) -> None:
        """Begin to read what is ``what`` anew: the file ``name`` has changed."""
        raise NotImplementedError
