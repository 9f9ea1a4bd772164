"""The open documents of a folder, shared by all browser tabs."""

import asyncio
import sys
from collections.abc import Callable
from contextlib import suppress
from pathlib import Path
from typing import Any, TypeVar

from fuzzy.errors import InputError
from fuzzy.files.fisfile import FisFileError, FisText, parse_bytes
from fuzzy.plugins.designer.autosave import find
from fuzzy.plugins.designer.design import file_text
from fuzzy.plugins.designer.document import Document, FileContent, read_content
from fuzzy.plugins.designer.folder import Folder, FolderError, check_length, check_shown, check_size, read_bytes
from fuzzy.plugins.designer.latest import Latest, Postponed
from fuzzy.plugins.designer.mamdanifile import SugenoForm, nearest, sugeno_forms
from fuzzy.plugins.designer.saving import DocumentError, digest_of
from fuzzy.plugins.designer.workers import DesignerWorkers, TimedWorkers, WorkError
from fuzzy.system import Sugeno

T = TypeVar("T")
AUTOSAVE = 0.25  # s between two autosaves of a document while it is being dragged
AGAIN = 5.0  # s until unsaved work that could not be kept is tried again
PATIENCE = 20.0  # s that a file may take to be read


class MamdaniFileError(FolderError):
    """A file of the folder that holds a Mamdani system, which can be opened as a Sugeno system.

    Attributes:
        name: The file.
        changes: What becomes another thing then, a sentence each.
        free: The name of a file that there is not yet, for the Sugeno system.
        forms: What its sets can become, and how far the outputs are off then; a sentence where that is not measured.
    """

    def __init__(self, name: str, changes: tuple[str, ...], free: str, forms: list[SugenoForm] | str) -> None:
        super().__init__(name, changes, free, forms)
        self.name, self.changes, self.free, self.forms = name, changes, free, forms

    def __str__(self) -> str:
        return f"{self.name} is a Mamdani system; it can be opened as a Sugeno system, {self.free}"


def _content(path: Path, name: str) -> FileContent:
    content = read_content(path, mamdani=True, name=name)
    if content.text is not None:
        check_shown(content.text.system, name)
    return content


def _kept(path: Path, error: FisFileError) -> FileContent | None:
    """The unsaved work that goes on from a file that cannot be read, as its content; None: there is none."""
    digest = digest_of(path)
    for work in find(path):
        if work.base == digest and not work.elsewhere:
            note = f"the file cannot be read ({error}); shown is your unsaved work of {work.when:%Y-%m-%d %H:%M:%S}"
            return FileContent(
                digest,
                parse_bytes(file_text(work.design).encode(), path.name, False, True, True)._replace(warnings=(note,)),
            )
    return None


class OpenDocuments:
    """The documents of a folder that are open; all browser tabs with one file share one document."""

    def __init__(self, folder: Folder, patience: float = PATIENCE) -> None:
        self.folder = folder
        self.workers = DesignerWorkers()
        self._patience = patience
        self._reader = TimedWorkers(patience)
        self._documents: list[Document] = []
        self._first: Document | None = None  # began with a system that no file holds: kept even if untouched
        self._tabs: dict[int, list[Callable[[], None]]] = {}  # who looks at a document, by its id

    def document(self, name: str, begin: Sugeno | None = None) -> Document:
        """The document of the file ``name``, read here and now; for the page there is :meth:`opened`.

        The file need not exist yet: then the document begins with the system ``begin``, and stays while nobody looks.
        Raises FolderError, DocumentError or FisFileError for what cannot be opened.
        """
        path = self.folder.inside(name)
        found = self._found(path)
        if found is None:
            check_size(path, name)
            found = self._added(name, Document(path, self.folder.path, begin))
            self._first = found if begin is not None else self._first
        return found

    async def opened(self, name: str, mamdani: str = "", fit: str = "") -> Document:
        """The document of the file ``name``, which is read in another process, within a time limit.

        Args:
            name: The file. Where there is none yet, the document begins with a small system.
            mamdani: A file with the Mamdani system with which a file that is not there yet begins.
            fit: What that system's sets become, see :class:`fuzzy.plugins.designer.mamdanifile.SugenoForm`.

        Raises MamdaniFileError, or another InputError or WorkError for what cannot be opened.
        """
        path = self.folder.inside(name)
        try:
            content = None if self._found(path) else await self.content(path, name)
        except FisFileError as error:
            kept = _kept(path, error)
            if kept is None:
                raise
            document = self._added(name, Document(path, self.folder.path, None, kept))
            document.keep()
            return document
        if content is not None and content.text is not None and content.text.changes:
            stem = path.relative_to(self.folder.path).with_suffix("").as_posix()
            forms: list[SugenoForm] | str
            try:
                forms = await self.reading(name, sugeno_forms, path, name)
            except (InputError, WorkError) as error:
                forms = str(error)
            raise MamdaniFileError(name, content.text.changes, self.folder.free_name(f"{stem}-sugeno"), forms)
        begin = await self.read(mamdani) if mamdani and content is not None and content.text is None else None
        if begin is not None and begin.changes and fit:
            near = await self.reading(mamdani, nearest, self.folder.inside(mamdani), mamdani, fit)
            begin = begin._replace(system=near)
        found = self._found(path)  # another tab may have opened it meanwhile
        if found is not None:
            return found
        document = Document(path, self.folder.path, begin and begin.system, content)
        if begin is not None and begin.changes:
            document.notes += (f"{mamdani} was a Mamdani system; this Sugeno system comes near it",)
        return self._added(name, document)

    def begun(self, name: str, fis: Sugeno) -> Document:
        """A new document of the file ``name``, which must not exist, with the system ``fis`` as unsaved work.

        Raises FolderError where there is such a file, or one that is not saved yet; DocumentError.
        """
        path = self.folder.inside(name)
        if path.exists() or self._found(path) is not None or find(path):
            which = "exists already" if path.exists() else "is open, or has unsaved work,"
            raise FolderError(
                f"{name} {which}; choose another name, such as {self.folder.free_name(name[: -len('.fis')])}"
            )
        document = self._added(name, Document(path, self.folder.path, fis))
        with suppress(DocumentError):  # the page says that it cannot be kept
            document.keep()
        return document

    async def mended(self, name: str, text: str) -> str:
        """Take ``text`` in the place of what the file ``name`` holds, as unsaved work; the file stays as it is.

        The name of the document is returned: that of a Mamdani system's Sugeno system is another one. Raises InputError
        where the text cannot be read either, WorkError.
        """
        path = self.folder.inside(name)
        data = text.encode()
        check_length(len(data), name)
        if self._found(path) is not None:  # another tab has mended it
            return name
        read = await self.reading(name, parse_bytes, data, name, True, True, True)
        check_shown(read.system, name)
        if read.changes:
            free = self.folder.free_name(f"{name[: -len('.fis')]}-sugeno")
            self.begun(free, read.system)
            return free
        document = self._added(name, Document(path, self.folder.path, None, FileContent(digest_of(path), read)))
        document.keep()
        return name

    async def content(self, path: Path, name: str) -> FileContent:
        """What the file called ``name`` holds, a Mamdani system as a Sugeno system. Raises InputError, WorkError."""
        check_size(path, name)
        return await self.reading(name, _content, path, name)

    async def read(self, name: str) -> FisText:
        """The system in a file of the folder, read in another process. Raises InputError, WorkError."""
        return await self.reading(name, self.folder.read_any, name)

    async def read_upload(self, data: bytes, name: str) -> FisText:
        """The system in the bytes of a file called ``name``. Raises InputError, WorkError."""
        return await self.reading(name, read_bytes, data, name)

    async def reading(self, name: str, function: Callable[..., T], *args: Any) -> T:
        """Run ``function(*args)``, which reads the file called ``name``, in another process, within a time limit.

        Raises InputError, also where it takes too long, or WorkError.
        """
        late = f"{name} was not read within {self._patience:g} s: it is too large, or this machine is busy"
        return await self._reader.run(late, function, *args)

    def _found(self, path: Path) -> Document | None:
        return next((document for document in self._documents if document.path == path), None)

    def _added(self, name: str, document: Document) -> Document:
        check_shown(document.design.system, name)
        kept = Latest(lambda: self._autosave_aside(document, again))
        again = Postponed(AGAIN, kept.wish)
        document.listen(kept.wish)
        self._documents.append(document)
        return document

    def arrive(self, document: Document, announce: Callable[[], None] = lambda: None) -> None:
        """Note that a browser tab looks at the document.

        ``announce`` is called when unsaved work can be kept no longer, or again: see ``Document.unkept``.
        """
        self._tabs.setdefault(id(document), []).append(announce)

    def leave(self, document: Document, announce: Callable[[], None] | None = None) -> None:
        """Note that a browser tab no longer looks at the document; one that nobody touched is forgotten."""
        tabs = self._tabs[id(document)]
        tabs.remove(tabs[0] if announce is None else announce)
        if not tabs:
            del self._tabs[id(document)]
            if document in self._documents and document is not self._first and not document.touched:
                self._documents.remove(document)

    def save(self, document: Document, name: str | None = None, overwrite: bool = False) -> None:
        """Save the document, under another name if one is given. Raises FolderError, DocumentError, OSError."""
        path = document.path if name is None else self.folder.inside(name)
        for other in [d for d in self._documents if d is not document and d.path == path]:
            if self._tabs.get(id(other)):
                raise FolderError(f"{name!r} is open in another tab; close that tab first or choose another name")
            self._autosave(other)
            self._documents.remove(other)
        document.save(None if name is None else path, overwrite=overwrite)

    def close(self) -> None:
        """Write what is not saved beside the files, and end the workers."""
        for document in self._documents:
            self._autosave(document)
        self._reader.close()
        self.workers.close()

    async def _autosave_aside(self, document: Document, again: Postponed) -> None:
        """Write in a thread, because nobody who drags waits for a disk; what cannot be kept is tried again later.

        It takes a quarter of a second, so that a drag is written four times a second: at most that much is lost.
        """
        before = document.unkept
        await asyncio.to_thread(_keep, document)
        self._tell(document, before)
        if document.unkept is not None and document in self._documents:
            again.begin()
        await asyncio.sleep(AUTOSAVE)

    def _autosave(self, document: Document) -> None:
        before = document.unkept
        _keep(document)
        self._tell(document, before)

    def _tell(self, document: Document, before: str | None) -> None:
        """Tell the tabs whether unsaved work can be kept, and the terminal why not, where that is new."""
        if before == document.unkept:
            return
        if document.unkept is not None:
            print(f"fuzzy design: {document.unkept}", file=sys.stderr)
        for announce in self._tabs.get(id(document), []):
            announce()


def _keep(document: Document) -> None:
    """Keep the unsaved work of a document; ``document.unkept`` says why that cannot be."""
    with suppress(DocumentError):
        document.autosave()
