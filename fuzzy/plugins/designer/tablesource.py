"""Where a panel's table comes from, a CSV file of the opened folder or an upload in pieces, and what is drawn of it."""

from pathlib import Path
from typing import Any, ClassVar

from fuzzy.errors import InputError
from fuzzy.files.table import DataError
from fuzzy.naming import check_known
from fuzzy.plugins.designer.columns import LoadedTable, read_columns, read_file
from fuzzy.plugins.designer.datapictures import Rows, data_pictures
from fuzzy.plugins.designer.folder import LARGEST_FILE
from fuzzy.plugins.designer.session import PanelSession
from fuzzy.plugins.designer.views import variable_data
from fuzzy.system import Sugeno


class UploadError(InputError):
    """An upload that is none, is too large or did not arrive whole."""


class TableSession(PanelSession):
    """A panel whose page chooses a table, and looks at its rows beside a system; uploads are kept in memory only.

    A subclass names in ``larger`` what to do with larger tables, as the end of a sentence.
    """

    larger: ClassVar[str]

    def __init__(self, bench: Any, **choice: Any) -> None:
        super().__init__(bench, **choice)
        self.table: LoadedTable | None = None
        self.columns: dict[str, str] = {}  # which is which, as the page chose them
        self.rows: Rows | None = None  # that are looked at
        self._pieces: list[str] = []  # of an upload

    def table_files(self) -> list[str]:
        """The CSV files of the folder."""
        folder = self.folder.path
        # A link that leads out of the folder is none of its files.
        return sorted(f.name for f in folder.glob("*.csv") if f.is_file() and f.resolve().is_relative_to(folder))

    def open_table(self) -> None:
        """Begin with the table that the design was made from, or that another panel looks at, if the folder has it."""
        name = self.bench.document.table
        if name in self.table_files():
            self.heard({"do": "file", "name": name})

    async def _do_file(self, message: dict[str, Any]) -> None:
        """Read a file of the folder. Raises DataError."""
        name = check_known(message.get("name"), self.table_files(), "file of the folder", DataError)
        self.bench.document.table = name
        self.show_table(await self.bench.read(name, read_file, self.folder.path / name, LARGEST_FILE, self.larger))

    async def _do_piece(self, message: dict[str, Any]) -> None:
        """Take a piece of an uploaded file, of which the first has the number 0; read the table after the last one.

        Raises UploadError, and DataError for what is no table.
        """
        text, name, number = message.get("text"), message.get("name"), message.get("number")
        if not isinstance(text, str) or not isinstance(name, str):
            raise UploadError("an upload is pieces of text with the file's name")
        if number == 0:
            self._pieces = []
        elif number != len(self._pieces):
            raise UploadError(f"{name} did not arrive whole; please upload it again")
        if sum(map(len, self._pieces)) + len(text) > LARGEST_FILE:
            self._pieces = []
            raise UploadError(f"{name} is larger than {LARGEST_FILE / 1e6:g} MB; {self.larger}")
        self._pieces.append(text)
        if message.get("last"):
            whole, self._pieces = "".join(self._pieces), []
            name = Path(name).name[:200] or "upload"
            self.show_table(await self.bench.read(name, read_columns, name, whole))

    def show_table(self, table: LoadedTable) -> None:
        """Take the table that came of it."""
        raise NotImplementedError

    async def drawn_rows(self, system: Sugeno | None, output: int) -> dict[str, Any] | None:
        """The traits that show the rows beside a system; None where other rows are looked at once they are there.

        Raises InputError or WorkError.
        """
        rows = self.rows
        if system is None or rows is None:
            return dict.fromkeys(("pictures", "points", "residual"))
        data = await self.bench.background(data_pictures, system, rows, output)
        if rows is not self.rows:
            return None
        points, residual = data.pop("points"), data.pop("residual")
        terms = [variable_data(v) for v in system.inputs]
        return {"pictures": data, "points": points, "residual": residual, "terms": terms}
