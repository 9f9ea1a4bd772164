"""The open documents of a folder, shared by all browser tabs."""

import asyncio
import sys

from fuzzy.designer.document import Document
from fuzzy.designer.folder import LARGEST_FILE, MOST_RULES, Folder, FolderError
from fuzzy.designer.saving import DocumentError
from fuzzy.designer.workers import DesignerWorkers
from fuzzy.system import Sugeno

AUTOSAVE = 0.25  # s between two autosaves of a document while it is being dragged


class OpenDocuments:
    """The documents of a folder that are open; all browser tabs with one file share one document."""

    def __init__(self, folder: Folder) -> None:
        self.folder = folder
        self.workers = DesignerWorkers()
        self._documents: list[Document] = []
        self._tabs: dict[int, int] = {}  # how many look at a document, by its id
        self._waiting: set[int] = set()  # documents that were autosaved just now

    def document(self, name: str, begin: Sugeno | None = None) -> Document:
        """The document of the file ``name``, which need not exist yet: then it begins with the system ``begin``.

        Raises FolderError, DocumentError or FisFileError for what cannot be opened.
        """
        path = self.folder.inside(name)
        for document in self._documents:
            if document.path == path:
                return document
        if path.is_file() and path.stat().st_size > LARGEST_FILE:
            raise FolderError(f"{name!r} is larger than {LARGEST_FILE / 1e6:g} MB")
        document = Document(path, self.folder.path, begin)
        if len(document.design.lines) > MOST_RULES:
            raise FolderError(f"{name}: {len(document.design.lines)} rules; the designer shows at most {MOST_RULES}")
        document.listen(lambda: self._autosave_soon(document))
        self._documents.append(document)
        return document

    def arrive(self, document: Document) -> None:
        """Note that a browser tab looks at the document."""
        self._tabs[id(document)] = self._tabs.get(id(document), 0) + 1

    def leave(self, document: Document) -> None:
        """Note that a browser tab no longer looks at the document."""
        self._tabs[id(document)] -= 1

    def save(self, document: Document, name: str | None = None, overwrite: bool = False) -> None:
        """Save the document, under another name if one is given. Raises FolderError, DocumentError, OSError."""
        path = document.path if name is None else self.folder.inside(name)
        for other in [d for d in self._documents if d is not document and d.path == path]:
            if self._tabs.get(id(other), 0) > 0:
                raise FolderError(f"{name!r} is open in another tab; close that tab first or choose another name")
            self._autosave(other)
            self._documents.remove(other)
        document.save(None if name is None else path, overwrite=overwrite)

    def close(self) -> None:
        """Write what is not saved beside the files, and end the workers."""
        for document in self._documents:
            self._autosave(document)
        self.workers.close()

    def _autosave_soon(self, document: Document) -> None:
        """Write now, and during a drag four times a second: whatever happens, at most that much is lost."""
        if id(document) not in self._waiting:
            self._waiting.add(id(document))
            self._autosave(document)
            asyncio.get_running_loop().call_later(AUTOSAVE, self._autosave_again, document)

    def _autosave_again(self, document: Document) -> None:
        self._waiting.discard(id(document))
        self._autosave(document)

    def _autosave(self, document: Document) -> None:
        try:
            document.autosave()
        except DocumentError as error:
            print(f"fuzzy design: {error}", file=sys.stderr)
