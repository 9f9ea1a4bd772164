"""A file under design: the design, its history, saving, and unsaved work that outlives a crash."""

import hashlib
import os
import threading
from collections import deque
from collections.abc import Callable, Mapping, MutableSequence
from contextlib import suppress
from dataclasses import replace
from datetime import UTC, datetime
from pathlib import Path
from typing import Any, NamedTuple

from fuzzy.files.fisfile import FisText, parse_bytes, write_fis_text
from fuzzy.naming import check_known
from fuzzy.plugins.designer import autosave
from fuzzy.plugins.designer.design import (
    Design,
    design_of,
    file_text,
    point_in,
    unread,
    with_disabled,
    with_faults,
    with_lines,
)
from fuzzy.plugins.designer.edits import edited
from fuzzy.plugins.designer.saving import DocumentError, alone_in, bytes_of, check_untouched
from fuzzy.plugins.designer.variableedits import new_variable
from fuzzy.plugins.type2.files import system_of
from fuzzy.plugins.type2.system import Type2Sugeno
from fuzzy.system import Sugeno

DEPTH = 100  # edits that can be undone
_LONGEST = 200  # bytes of a file's name: file systems take 255, and unsaved work's is longer


class _Entry(NamedTuple):
    name: str  # of the edit
    design: Design  # before it (undo) or after it (redo)
    number: int  # of the edit, which no other of the document has
    when: datetime


class HistoryEdit(NamedTuple):
    """An edit that can be undone, or one that was taken back and can be made again."""

    number: int  # no other edit of the document has it
    name: str
    when: datetime  # a gesture's end
    done: bool  # not taken back


class FileContent(NamedTuple):
    """What a file held when it was read."""

    digest: str | None  # of its bytes; None: there was none
    text: FisText | None


def read_content(path: Path, mamdani: bool = False, name: str | None = None) -> FileContent:
    """Read a .fis file that need not exist; rules in it may be wrong. Raises DocumentError or FisFileError.

    Args:
        path: The file.
        mamdani: Whether a Mamdani system is read as a Sugeno system, see :func:`fuzzy.read_mamdani`.
        name: What messages call the file, by default its path.
    """
    data = bytes_of(path)
    if data is None:
        return FileContent(None, None)
    return FileContent(hashlib.sha256(data).hexdigest(), parse_bytes(data, name or str(path), mamdani, True, True))


def confined(folder: str | os.PathLike[str], path: str | os.PathLike[str]) -> Path:
    """The absolute path of a .fis file inside a folder, with its links followed.

    ``path`` is relative to ``folder``, or absolute. Raises DocumentError for a path that leads out of the folder or
    is no .fis file's.
    """
    try:
        root = Path(folder).resolve()
        target = (root / os.fspath(path)).resolve()
        longest = max(len(os.fsencode(part)) for part in target.parts)
    except (OSError, ValueError, RuntimeError, TypeError) as error:  # a NUL, a ring of links
        raise DocumentError(f"{str(path)!r} is not the path of a file: {error}") from None
    if longest > _LONGEST or len(target.parts) > _LONGEST:
        raise DocumentError(f"{target.name[:40]}...: the name is too long, at most {_LONGEST} bytes are allowed")
    if not target.is_relative_to(root):
        raise DocumentError(f"{os.fspath(path)} lies outside the opened folder {root}")
    if target.suffix.casefold() != ".fis":
        raise DocumentError(f"{os.fspath(path)}: a design is saved in a file that ends in .fis")
    if any(part.startswith(".") for part in target.relative_to(root).parts):
        raise DocumentError(f"{os.fspath(path)}: hidden files and folders cannot be opened")
    return target


def new_system(name: str) -> Sugeno:
    """The system with which a new file begins: one input, one output, a rule for each term."""
    rules = [f"if input1 is {term} then output1 is {term}" for term in ("low", "medium", "high")]
    return Sugeno([new_variable("input", "input1")], [new_variable("output", "output1")], rules, name=name)


class Document:
    """A .fis file under design. All who look at the file share one document: its edits come one after another.

    ``path`` is relative to ``folder``, outside which nothing is read or written; by default the file's own. A file
    that does not exist begins with ``begin``, by default :func:`new_system`; ``content`` is what it holds where it was
    read already. Unsaved work of a run that ended is
    taken up again: then ``restored`` says when it was written, and undoing leads back to the file. Where the file was
    changed since, the work stands in ``aside`` until one chooses, see :meth:`choose`. ``notes`` are
    sentences on what was found while opening. ``unkept`` says why unsaved work cannot be kept at present.

    Raises DocumentError or FisFileError where there is nothing to open.
    """

    def __init__(
        self,
        path: str | os.PathLike[str],
        folder: str | os.PathLike[str] | None = None,
        begin: Sugeno | None = None,
        content: FileContent | None = None,
    ) -> None:
        if folder is None:
            path = Path(path).absolute()
            folder = path.parent
        self.path = confined(folder, path)
        self.folder = Path(folder).resolve()
        self.begin = begin
        self.revision = 0
        self.compared: Sugeno | Type2Sugeno | None = None
        self.purpose = ""  # what was chosen that it is for; empty: what its names say
        self.table = ""  # the folder's table that it was made from, or beside which it was looked at last
        self.judged: tuple[Any, ...] = ()  # by which terms of a cost the design was tuned last
        self.restored: datetime | None = None
        self.aside: tuple[autosave.Unsaved, ...] = ()  # unsaved work that is older than the file, the newest first
        self.notes: tuple[str, ...] = ()
        self.unkept: str | None = None
        self._keeping = threading.Lock()  # held by whoever writes or removes unsaved work, or writes the file
        self._undo: deque[_Entry] = deque(maxlen=DEPTH)
        self._redo: list[_Entry] = []
        self._edits = 0  # that were ever made: each has the next number
        self.forgotten = False  # were older edits made than the first of the history, which cannot be undone any more?
        self._gesture: Any = None
        self._listeners: list[Callable[[], None]] = []
        self._written: tuple[Design, str] | None = None  # the design of which the text was asked for last
        self._leftover: Path | None = None  # restored work that still stands in a file that is not ours
        if not self.path.parent.is_dir():
            raise DocumentError(f"{self.path}: there is no folder {self.path.parent}")
        self.design = self._from_file(content or read_content(self.path))
        self._restore()

    def _from_file(self, content: FileContent, first_key: int = 0) -> Design:
        """The design in the file; what is known of the file is then what it held when it was read."""
        if content.text is None:
            fis: Sugeno | Type2Sugeno = self.begin or new_system(self.path.stem)
        else:
            fis = system_of(content.text, str(self.path))
            self.notes = (*self.notes, *content.text.warnings)
        faults = content.text.faults if content.text is not None else ()
        self.notes += tuple(
            f"line {f.line} is no rule, and stays as it is until it is mended: {f.reason}" for f in faults
        )
        design = with_faults(design_of(fis, first_key), faults)
        # Only now: of a file that cannot be read, this document does not know what saving would replace.
        self._digest, self._saved_text = content.digest, file_text(design)
        return design

    def _restore(self) -> None:
        if not _inside(self.folder, autosave.place_for(self.path).parent):
            return
        for work in autosave.find(self.path):
            when = f"{work.when:%Y-%m-%d %H:%M:%S}"
            if work.elsewhere:
                self.notes += (f"another designer has {self.path.name} open, with unsaved work of {when}",)
            elif work.base != self._digest and self._changed_after(work.when):
                with suppress(OSError):
                    self.aside += (autosave.put_aside(work, self.path),)
            elif self.restored is None and (file_text(work.design) != self._saved_text or _misspelt(work.design)):
                self.restored = work.when
                self._note(f"take up unsaved work of {when}", self.design, work.when)
                self.design = work.design
                self._digest = work.base
                self._leftover = work.path

    def _changed_after(self, when: datetime) -> bool:
        try:
            return datetime.fromtimestamp(self.path.stat().st_mtime, UTC) > when
        except OSError:
            return False

    @property
    def touched(self) -> bool:
        """Whether there is anything here that opening the file again would not show."""
        return bool(self._undo or self._redo or self._leftover is not None or self.compared is not None)

    def keep(self) -> None:
        """Keep the design as unsaved work from now on, though nothing was edited: for one that no file holds."""
        self._saved_text = ""
        self.autosave()

    @property
    def saved(self) -> bool:
        """Whether the file holds the design, as far as this document knows."""
        return self._digest is not None and self.text() == self._saved_text

    def text(self) -> str:
        """The design as the text of a .fis file."""
        design, written = self.design, self._written
        if written is None or written[0] is not design:
            written = self._written = design, file_text(design)
        return written[1]

    # Edits and history ----------------------------------------------------------------------------------------

    def apply(self, message: Mapping[str, Any]) -> None:
        """Apply one message: an edit, a look at another point, or a step in the history.

        Steps are ``{"do": "undo"}``, ``{"do": "redo"}`` and ``{"do": "go", "to": number}``, see :meth:`go`.

        An edit with the same ``gesture`` (not null) as the one before continues it: both are undone together.
        Raises InputError, with a sentence, for any other message; the design is then as it was.
        """
        if isinstance(message, Mapping) and "edit" not in message and "do" in message:
            self._do(message)
            return
        new, name = edited(self.design, message)
        if "edit" not in message:
            self.design = new
            self._tell()
            return
        gesture = message.get("gesture")
        self._record(new, name, gesture if isinstance(gesture, (str, int)) else None)

    def _do(self, message: Mapping[str, Any]) -> None:
        if message["do"] == "undo":
            self.undo()
        elif message["do"] == "redo":
            self.redo()
        elif message["do"] == "go":
            self.go(message.get("to"))
        else:
            raise DocumentError("a document accepts 'undo', 'redo' and 'go'")

    def _note(self, name: str, before: Design, when: datetime | None = None) -> None:
        self._edits += 1
        self.forgotten |= len(self._undo) == DEPTH
        self._undo.append(_Entry(name, before, self._edits, when or datetime.now(UTC)))

    def _record(self, new: Design, name: str, gesture: Any = None) -> None:
        continues = gesture is not None and gesture == self._gesture and self._undo
        before = self._undo[-1].design if continues else self.design
        if new != self.design:
            last = self._undo.pop() if continues else None
            if new == before:  # a gesture that came back to where it began is none
                pass
            elif last is not None:
                self._undo.append(last._replace(name=name, when=datetime.now(UTC)))
            else:
                self._note(name, before)
            self._redo.clear()
            self._gesture = gesture if new != before else None
            self.design = new
        self._tell()

    @property
    def can_undo(self) -> str | None:
        """The name of the edit that :meth:`undo` takes back."""
        return self._undo[-1].name if self._undo else None

    @property
    def can_redo(self) -> str | None:
        """The name of the edit that :meth:`redo` makes again."""
        return self._redo[-1].name if self._redo else None

    @property
    def history(self) -> tuple[HistoryEdit, ...]:
        """The edits that can be undone and those that can be made again, the oldest first."""
        entries = [(entry, True) for entry in self._undo] + [(entry, False) for entry in reversed(self._redo)]
        return tuple(HistoryEdit(entry.number, entry.name, entry.when, done) for entry, done in entries)

    def undo(self) -> None:
        """Take back the last edit, if there is one."""
        if self._undo:
            self._step(self._undo, self._redo)
            self._tell()

    def redo(self) -> None:
        """Make the edit again that was taken back last, if there is one."""
        if self._redo:
            self._step(self._redo, self._undo)
            self._tell()

    def go(self, number: Any) -> None:
        """Go to the design as it was after an edit of :attr:`history`, as so many undos or redos do; None: before all.

        Nothing is lost until the next edit. Raises DocumentError for an edit that the history does not have.
        """
        done = [entry.number for entry in self._undo]
        undone = [entry.number for entry in self._redo]
        if number is not None and (type(number) is not int or number not in done + undone):
            raise DocumentError("that edit is no longer in the history, because another one was made meanwhile")
        if number in undone:
            for _ in undone[undone.index(number) :]:
                self._step(self._redo, self._undo)
        else:
            for _ in done[0 if number is None else done.index(number) + 1 :]:
                self._step(self._undo, self._redo)
        self._tell()

    def _step(self, entries: MutableSequence[_Entry], others: MutableSequence[_Entry]) -> None:
        """Go to the design of the last of the ``entries``, which then leads back from among the ``others``."""
        entry, before = entries.pop(), self.design
        others.append(entry._replace(design=before))
        # One keeps looking at the same point, and a key that was given once is not given again.
        point = point_in(entry.design.system, before)
        self.design = replace(entry.design, point=point, next_key=max(entry.design.next_key, before.next_key))
        self._gesture = None

    def replace(self, fis: Sugeno, what: str, keep_disabled: bool = False, gesture: str | None = None) -> None:
        """Put a whole new system (uploaded, trained) in the place of the design, as one edit; the loop stays.

        Args:
            fis: The system.
            what: The name of the edit.
            keep_disabled: Whether the disabled rules stay, disabled, as far as ``fis`` has their variables and
                terms: for a system that was learnt from the enabled ones.
            gesture: What is put there one after the other with the same gesture is undone together.

        Raises FisFileError where no .fis file can hold it.
        """
        fis = fis if fis.loop else replace(fis, loop=self.design.system.loop)
        new = design_of(fis, self.design.next_key)
        if keep_disabled:
            new = with_disabled(new, self.design)
        file_text(new)
        self._record(replace(new, point=point_in(new.system, self.design)), what, gesture)

    def take(self, design: Design, what: str) -> None:
        """Put a design that was kept (a snapshot) in the place of this one, as one edit; one looks at the same point.

        Args:
            design: The design, with its disabled and misspelt rules.
            what: The name of the edit.
        """
        first = self.design.next_key
        lines = [replace(line, key=key) for key, line in enumerate(design.lines, first)]
        new = replace(with_lines(design, lines), point=point_in(design.system, self.design))
        self._record(new, what)

    def choose(self, which: Any) -> None:
        """Choose between the file and the newest work in ``aside``.

        Args:
            which: "file" forgets the work, "work" puts it in the place of the design, as one edit.

        Raises DocumentError for anything else, and where there is nothing to choose.
        """
        check_known(which if isinstance(which, str) else "", ("file", "work"), "choice", DocumentError)
        if not self.aside:
            raise DocumentError("there is no unsaved work to choose")
        work = self.aside[0]
        if which == "work":
            self.take(work.design, f"take up unsaved work of {work.when:%Y-%m-%d %H:%M:%S}")
            self.autosave()  # only when it is kept elsewhere it may go
        work.path.unlink(missing_ok=True)
        self.aside = self.aside[1:]
        self._tell()

    def compare(self, fis: Sugeno | Type2Sugeno | None) -> None:
        """Show ``fis`` beside the design; None shows nothing."""
        self.compared = fis
        self._tell()

    def announce(self) -> None:
        """Tell all who look that something beside the design changed: its snapshots."""
        self._tell()

    def listen(self, callback: Callable[[], None]) -> Callable[[], None]:
        """Call ``callback()`` after every change, until the function that is returned is called."""
        self._listeners.append(callback)

        def unlisten() -> None:
            with suppress(ValueError):
                self._listeners.remove(callback)

        return unlisten

    def _tell(self) -> None:
        self.revision += 1
        problems = []
        for callback in tuple(self._listeners):
            try:
                callback()
            except Exception as error:  # the others are told all the same
                problems.append(error)
        if problems:
            raise problems[0]

    # Files ----------------------------------------------------------------------------------------------------

    def save(self, path: str | os.PathLike[str] | None = None, overwrite: bool = False) -> None:
        """Write the .fis file, whole or not at all; with ``path`` (in the folder), that becomes the document's file.

        Raises OverwriteError where the file changed on disk since it was read, or another file is there already,
        unless ``overwrite``; DocumentError or FisFileError where it cannot be written.
        """
        if problem := unread(self.design):
            raise DocumentError(problem)
        target = confined(self.folder, self.path if path is None else path)
        design = self.design
        if self._digest is None and design.system.name == self.path.stem:  # a new system is called as its file
            design = replace(design, system=replace(design.system, name=target.stem))
        text = file_text(design)
        if not target.parent.is_dir():
            raise DocumentError(f"{target}: there is no folder {target.parent}")
        with self._keeping:
            with alone_in(target.parent):
                if not overwrite:
                    check_untouched(target, self._digest if target == self.path else None, target == self.path)
                write_fis_text(text, str(target), "")
            if design != self.design:
                self._record(design, f"rename to {target.stem}")
            self.path, self._saved_text = target, text
            self._digest = hashlib.sha256(text.encode()).hexdigest()
            self._forget()
        self._tell()

    def autosave(self) -> None:
        """Write the design beside the file now, or remove what stands there once the file holds it; in any thread.

        Raises DocumentError where it cannot be written; ``unkept`` then says so until it can.
        """
        with self._keeping:
            try:
                self._keep()
            except DocumentError as error:
                self.unkept = str(error)
                raise
            self.unkept = None

    def _keep(self) -> None:
        if self.text() == self._saved_text and not _misspelt(self.design):  # nothing that the file does not tell
            self._forget()
            return
        target = autosave.place_for(self.path)
        if not _inside(self.folder, target.parent):
            raise DocumentError(f"{target} leads out of the opened folder: unsaved work is not kept")
        try:
            written = autosave.write(self.path, self.design, self._digest)
            if self._leftover not in (None, written):
                self._leftover.unlink(missing_ok=True)
        except OSError as error:
            raise DocumentError(f"unsaved work cannot be kept in {target}: {error.strerror or error}") from None
        self._leftover = written

    def discard(self, content: FileContent | None = None) -> None:
        """Go back to what the file holds now, as an edit that can be undone.

        ``content`` is what it holds where it was read already.
        """
        self.path, self.notes = confined(self.folder, self.path), ()
        if self._digest is not None and not self.path.exists():
            raise DocumentError(f"{self.path.name} no longer exists; saving writes it again")
        design = self._from_file(content or read_content(self.path), self.design.next_key)
        with self._keeping:
            self._forget()
        self.restored = None
        self._record(replace(design, point=point_in(design.system, self.design)), "discard unsaved changes")

    def _forget(self) -> None:
        """Remove the unsaved work that this document wrote or took up."""
        if self._leftover is not None:
            with suppress(OSError):
                self._leftover.unlink(missing_ok=True)
        self._leftover = None


def _misspelt(design: Design) -> bool:
    """Are there sentences that a .fis file cannot keep?"""
    return any(line.problem and line.text != line.source for line in design.lines)


def _inside(folder: Path, path: Path) -> bool:
    """Does ``path``, with its links followed, lie in ``folder``?"""
    return Path(os.path.realpath(path)).is_relative_to(folder)
