"""The designer's panel "Data": a table of measured rows beside the design, with or without training.

The page sees what :class:`DataSession` hands to the module ``data.js``, and sends it messages: a file of the folder, an
upload in pieces, which column is which, and a row to look at. What is drawn is computed in another process.
"""

from pathlib import Path
from typing import Any

import numpy as np

from fuzzy.errors import InputError, quoted
from fuzzy.naming import check_known, expected
from fuzzy.plugins.designer.columns import LoadedTable, columns_data, matching
from fuzzy.plugins.designer.datapictures import Rows, histograms
from fuzzy.plugins.designer.folder import LARGEST_FILE
from fuzzy.plugins.designer.latest import Latest
from fuzzy.plugins.designer.panel import FUNCTION, SessionPanel
from fuzzy.plugins.designer.session import refusal_of
from fuzzy.plugins.designer.tablesource import TableSession
from fuzzy.plugins.designer.workers import WorkError
from fuzzy.shown import typeset
from fuzzy.system import Sugeno

_MODULE = Path(__file__).parent / "static" / "data.js"
_TIMES = ("t", "time")  # names of a column that residuals are drawn over at first


class DataPanelError(InputError):
    """A wish of the page that cannot be done. The message says what is accepted."""


class DataSession(TableSession):
    """The table that one page looks at, and which of its columns is which variable of the design."""

    error = DataPanelError
    larger = "use fuzzy evaluate for large tables"

    def __init__(self, bench: Any) -> None:
        super().__init__(bench, output=0, along="", skip_bad=False)
        self.drawn: tuple[Any, ...] | None = None  # what the pictures are of: rows, system, output
        self.keys = self._keys()
        self.pictures = Latest(self._draw)
        self.spread = Latest(self._share)
        self.put(
            _MODULE,
            sources=self.table_files(),
            largest=LARGEST_FILE,
            columns={},
            choice=self.choice,
            variables=self._variables(),
            lack="",
            **dict.fromkeys(("table", "pictures", "points", "residual", "terms")),
        )
        bench.on_change(self._universes_changed, hidden=True)
        self.universes = self.present.inputs
        self.open_table()

    # Messages

    def _do_column(self, message: dict[str, Any]) -> None:
        name, value = message.get("name"), message.get("value")
        name = check_known(name, self.keys, "variable", DataPanelError)
        known = [] if self.table is None else self.table.names
        column = "" if value == "" else check_known(value, known, "column", DataPanelError)
        self.columns = {**self.columns, name: column}
        self._choose_rows()

    def _do_choose(self, message: dict[str, Any]) -> None:
        name, value = self.setting(message)
        known: dict[str, Any] = {
            "output": range(len(self.present.outputs)),
            "along": ("", *(() if self.table is None else self.table.names)),
            "skip_bad": (False, True),
        }
        right = isinstance(value, int if name == "output" else bool if name == "skip_bad" else str)
        if not right or value not in known[name]:
            raise DataPanelError(expected(str(value), [str(v) for v in known[name]], name))
        self.choice = {**self.choice, name: value}
        self._choose_rows()

    def _do_look(self, message: dict[str, Any]) -> None:
        """Lead to the viewer, at a row's inputs."""
        row = message.get("row")
        if self.rows is None or not isinstance(row, int) or not 0 <= row < len(self.rows.x):
            raise DataPanelError("there is no such row any more")
        if not np.isfinite(self.rows.x[row]).all():
            raise DataPanelError("to look at a row, choose a column for every input")
        self.bench.look_at(self.rows.x[row].tolist())
        self.bench.show("Viewer")

    # Rows

    def show_table(self, table: LoadedTable) -> None:
        """Take a table, and its columns by what they are called."""
        self.table = table
        along = next((name for name in table.usable if name.casefold() in _TIMES), "")
        self.choice = {**self.choice, "skip_bad": False, "along": along}
        self.keys = self._keys()
        system = self.present
        names = [v.name for v in (*system.inputs, *system.outputs)]
        found = matching(table, names)
        self.columns = {key: found.get(name, "") for key, name in zip(self.keys, names, strict=True)}
        self._choose_rows()

    def _choose_rows(self) -> None:
        """Take the rows of the chosen columns, and have them drawn."""
        table, lack, problem = self.table, "", None
        if table is not None:
            chosen = [name for name in self.columns.values() if name]
            self.rows = None
            try:
                if not any(self.columns[key] for key in self.keys if key.startswith("input ")):
                    raise DataPanelError("no column is chosen for an input yet")
                lack = table.lack(chosen)
                bad = table.lacking(chosen)
                if bad.all() or (bad.any() and not self.choice["skip_bad"]):
                    rest = ": none is left" if bad.all() else "; leave such rows out, or choose other columns"
                    raise DataPanelError(f"{table.name}: {lack}{rest}")
                self.rows = rows_of(table, self.columns, self.present, ~bad, self.choice["along"])
            except InputError as error:
                problem = error
            self.bench.pictured["data"] = None if self.rows is None else (self.rows.x, self.rows.y)
        self.widget.update(
            sources=self.table_files(),
            table=None if table is None else columns_data(table),
            columns=self.columns,
            choice=self.choice,
            variables=self._variables(),
            lack=lack,
            problem=problem and _note(problem),
        )
        self.pictures.wish()
        self.spread.wish()

    async def _draw(self) -> None:
        """What is drawn of the rows beside the design as it is now."""
        rows, system, choice = self.rows, self.present, self.choice
        if rows is not None:
            if rows.x.shape[1] != len(system.inputs) or rows.y.shape[1] != len(system.outputs):
                return  # variables were added or removed, and the rows are being chosen anew
            if self.drawn is not None and self.drawn[0] is rows and self.drawn[1:] == (system, choice["output"]):
                return  # one looks at another point
        self.drawn = (rows, system, choice["output"])
        try:
            traits = await self.drawn_rows(system, choice["output"])
        except (InputError, WorkError) as error:
            self.drawn, traits = None, {"problem": _note(error)}
        if traits is not None:
            if traits.get("pictures"):
                traits["pictures"]["words"] += self._units()
            self.widget.update(**traits)

    async def _share(self) -> None:
        """Histograms for the tab Memberships."""
        rows, inputs = self.rows, self.present.inputs
        if rows is None or rows.x.shape[1] != len(inputs):
            self.bench.share(histograms=None)
            return
        try:
            found = await self.bench.background(histograms, inputs, rows)
        except (InputError, WorkError):
            found = None
        self.bench.share(histograms=found)

    # The design

    def changed(self) -> None:
        """Show the variables, and draw the rows anew."""
        variables = self._variables()
        self.widget.update(variables=variables, sources=self.table_files())
        if self._follow_names():
            self._choose_rows()
        else:
            self.pictures.wish()

    def _universes_changed(self) -> None:
        """Also while the tab is hidden: the histograms of the tab Memberships follow the universes."""
        now = self.present.inputs
        if [(v.name, v.universe, v.unit) for v in now] == [(v.name, v.universe, v.unit) for v in self.universes]:
            return
        self.universes = now
        if self.rows is not None:
            if self._follow_names():
                self._choose_rows()
            else:
                self.spread.wish()

    def _follow_names(self) -> bool:
        """Keep the columns of variables that were renamed; say whether variables are others than before."""
        before, self.keys = self.keys, self._keys()
        if before == self.keys:
            return False
        if len(before) == len(self.keys) and [k.split(" ")[0] for k in before] == [k.split(" ")[0] for k in self.keys]:
            # A variable that is still there keeps its column; one in the place of one that has gone takes its column.
            gone = dict(zip(self.keys, before, strict=True))
            self.columns = {key: self.columns.get(key, self.columns.get(gone[key], "")) for key in self.keys}
        else:
            self.columns = {key: self.columns.get(key, "") for key in self.keys}
        return True

    def _keys(self) -> list[str]:
        """What the page calls the variables: an input and an output may share a name."""
        return [variable["key"] for variable in self._variables()]

    def _variables(self) -> list[dict[str, str]]:
        system = self.present
        kinds = [("input", v) for v in system.inputs] + [("output", v) for v in system.outputs]
        return [{"key": f"{kind} {v.name}", "kind": kind, "name": v.name, "unit": v.unit} for kind, v in kinds]

    def _units(self) -> list[str]:
        """Say which columns have another unit than their variables."""
        system, found = self.present, []
        for key, variable in zip(self._keys(), (*system.inputs, *system.outputs), strict=False):
            column = self.columns.get(key, "")
            unit = self.table.unit(column) if self.table is not None and column else ""
            if unit and variable.unit and unit != variable.unit:
                found.append(
                    f"The column {quoted(column)} is in {unit}, {variable.name} in {variable.unit}: "
                    "the numbers are taken as they are."
                )
        return found


panel = SessionPanel("Data", 40, DataSession, purpose=FUNCTION)


def _note(error: Exception) -> dict[str, Any]:
    """What no field asked for: why rows are not drawn."""
    told = refusal_of(error)
    return told | {"message": typeset(told["message"])}


def rows_of(table: LoadedTable, columns: dict[str, str], system: Sugeno, which: np.ndarray, along: str) -> Rows:
    """The rows ``which`` (rows,) bool of a table, in the order of the variables of ``system``.

    ``columns`` has the column of "input NAME" and "output NAME", empty where there is none; ``along`` is the column of
    the time, empty for the row's number.
    """

    def values(kind: str, name: str) -> np.ndarray:
        column = columns.get(f"{kind} {name}", "")
        if not column:
            return np.full(int(which.sum()), np.nan)
        return table.values[which, table.names.index(column)]

    return Rows(
        np.column_stack([values("input", v.name) for v in system.inputs]),
        np.column_stack([values("output", v.name) for v in system.outputs]),
        table.begins[which],
        along=table.values[which, table.names.index(along)] if along in table.names else None,
    )
