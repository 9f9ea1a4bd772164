"""Where a panel's table comes from: a CSV file of the opened folder, or an upload in pieces."""

from pathlib import Path
from typing import Any

from fuzzy.errors import InputError
from fuzzy.files.table import DataError
from fuzzy.naming import check_known
from fuzzy.plugins.designer.columns import LoadedTable, read_columns, read_file
from fuzzy.plugins.designer.session import PanelSession


class UploadError(InputError):
    """An upload that is none, is too large or did not arrive whole."""


class TableSource:
    """The tables that one page may choose from; what is uploaded is kept in memory only.

    Args:
        bench: The page's fuzzy.plugins.designer.panel.Workbench.
        most: The largest file in bytes, and the longest upload in characters.
        larger: What to do with larger tables, as the end of a sentence.
    """

    def __init__(self, bench: Any, most: int, larger: str) -> None:
        self._bench, self._most, self._larger = bench, most, larger
        self._pieces: list[str] = []

    def files(self) -> list[str]:
        """The CSV files of the folder."""
        folder = Path(self._bench.document.folder).resolve()
        # A link that leads out of the folder is none of its files.
        return sorted(f.name for f in folder.glob("*.csv") if f.is_file() and f.resolve().is_relative_to(folder))

    async def file(self, name: Any) -> LoadedTable:
        """Read the file called ``name``. Raises DataError."""
        known = self.files()
        check_known(name, known, "file of the folder", DataError)
        path = Path(self._bench.document.folder) / name
        read: LoadedTable = await self._bench.read(name, read_file, path, self._most, self._larger)
        return read

    async def piece(self, message: dict[str, Any]) -> LoadedTable | None:
        """Take a piece of an uploaded file, of which the first has the number 0; the table after the last one.

        Raises UploadError, and DataError for what is no table.
        """
        text, name, number = message.get("text"), message.get("name"), message.get("number")
        if not isinstance(text, str) or not isinstance(name, str):
            raise UploadError("an upload is pieces of text with the file's name")
        if number == 0:
            self._pieces = []
        elif number != len(self._pieces):
            raise UploadError(f"{name} did not arrive whole; please upload it again")
        if sum(map(len, self._pieces)) + len(text) > self._most:
            self._pieces = []
            raise UploadError(f"{name} is larger than {self._most / 1e6:g} MB; {self._larger}")
        self._pieces.append(text)
        if not message.get("last"):
            return None
        whole, self._pieces = "".join(self._pieces), []
        name = Path(name).name[:200] or "upload"
        read: LoadedTable = await self._bench.read(name, read_columns, name, whole)
        return read


class TableSession(PanelSession):
    """A panel whose page chooses a file, or sends one in pieces; a subclass has a ``source``."""

    source: TableSource

    async def _do_file(self, message: dict[str, Any]) -> None:
        self.show_table(await self.source.file(message.get("name")))

    async def _do_piece(self, message: dict[str, Any]) -> None:
        table = await self.source.piece(message)
        if table is not None:
            self.show_table(table)

    def show_table(self, table: LoadedTable) -> None:
        """Take the table that came of it."""
        raise NotImplementedError
